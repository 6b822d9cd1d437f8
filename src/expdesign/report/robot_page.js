// A page that shows its robot in one state, or in one of those that are chosen from.
"use strict";
if (report.data.view) {
  const { view } = report.data;
  const robots = [robotView("robot", view), ...(view.dimension === 3 ? [robotView("robot-above", fromAbove(view))] : [])];
  const state = document.getElementById("state");
  const show = (number) => robots.forEach((robot) => robot.show(number, []));
  show(0);
  if (state) state.addEventListener("change", () => show(state.selectedIndex));
}

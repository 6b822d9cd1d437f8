// A page that shows its robot in one state, or in one of those that are chosen from.
"use strict";
if (report.data.view) {
  const robot = robotView("robot", report.data.view);
  const state = document.getElementById("state");
  robot.show(0, []);
  if (state) state.addEventListener("change", () => robot.show(state.selectedIndex, []));
}

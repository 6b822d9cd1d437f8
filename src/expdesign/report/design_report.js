// The page of `expdesign run`: choosing a design on a figure or in the table shows its plan, robot and error budget.
"use strict";
(() => {
  const { designs, recommended, knee, criteria, columns, budget, view, targets, bound, captions } = report.data;
  const element = (id) => document.getElementById(id);
  const robot = view ? robotView("robot", view) : null;
  const showEllipses = ellipseView(report.data.ellipses, designs);
  const showMap = mapView(report.data.maps, designs);
  let current = recommended;

  // ----- the front
  const horizontal = element("horizontal");
  const vertical = element("vertical");
  const axes = () => (horizontal ? [horizontal.value, vertical.value] : report.data.objectives.slice(0, 2));

  function drawFront() {
    const [x, y] = axes();
    const at = (name, index) => criteria[name].values[index];
    return report.update("front", (figure) => {
      const [all, best, middle, chosen] = figure.data;
      all.x = criteria[x].values;
      all.y = criteria[y].values;
      for (const [trace, index] of [[best, recommended], [middle, knee], [chosen, current]]) {
        Object.assign(trace, { x: [at(x, index)], y: [at(y, index)], text: [designs[index].hover], customdata: [index] });
      }
      chosen.name = `chosen: design ${designs[current].number}`;
      figure.layout.xaxis.title = { text: criteria[x].title };
      figure.layout.yaxis.title = { text: criteria[y].title };
      const lines = [];
      if (bound !== null && x === "duir") lines.push({ x0: bound, x1: bound, xref: "x", y0: 0, y1: 1, yref: "paper" });
      if (bound !== null && y === "duir") lines.push({ y0: bound, y1: bound, yref: "y", x0: 0, x1: 1, xref: "paper" });
      figure.layout.shapes = lines.map((line) => (
        { ...line, type: "line", line: { color: "var(--muted)", dash: "dash", width: 1.5 } }
      ));
      figure.layout.annotations = lines.map(({ x0, y0, xref, yref }) => ({
        x: x0, y: y0, xref, yref, text: "lower bound of DUIR", showarrow: false, textangle: xref === "x" ? -90 : 0,
        xanchor: "left", yanchor: "bottom", font: { size: 12, color: "var(--muted)" },
      }));
    });
  }

  // ----- the chosen design
  function csvOfBudget() {
    const head = ["target", "axis", "noise_std", "load_std", "total_std", "tolerance", ...budget.sources];
    const rows = budget.rows.map(([target, axis, tolerance], index) => {
      const [noise, load, total, ...sources] = designs[current].sigma[index];
      return [target, axis, noise, load, total, tolerance, ...sources].map((value) => value ?? "");
    });
    return [head, ...rows].map((row) => row.join(",")).join("\n") + "\n";
  }

  function drawBudget() {
    const sigma = designs[current].sigma;
    return report.update("budget", (figure) => {
      figure.data.forEach((trace, part) => {
        const rows = budget.bars.map((row) => [sigma[row][part], budget.rows[row]]);
        trace.x = rows.map(([value, [, , tolerance]]) => (value === null ? null : value / tolerance));
        trace.text = rows.map(([value, [, axis]], index) => (
          `${(1e6 * sigma[budget.bars[index]][part]).toPrecision(3)} ${axis.endsWith("_m") ? "µm" : "µrad"}`
        ));
      });
    });
  }

  function showState() {
    if (!robot) return;
    const design = designs[current];
    const value = element("state").value;
    const measurements = design.plan.map((_, index) => current * design.plan.length + index);
    if (value.startsWith("t")) {
      const target = Number(value.slice(1));
      robot.show(designs.length * design.plan.length + target, []);
      report.setText("state-text", targets[target]);
    } else {
      const row = design.plan[Number(value)];
      const parts = columns.map(([title, unit], index) => `${title} ${row[index]}${unit ? ` ${unit}` : ""}`);
      robot.show(measurements[Number(value)], measurements);
      report.setText("state-text", `${parts.join(", ")}. Force ${design.forces[Number(value)]} N.`);
    }
  }

  function select(index) {
    current = index;
    const design = designs[index];
    report.choose("designs", index);
    report.setText("chosen-text", design.summary);
    report.setText("plan-title", `Plan of design ${design.number}`);
    report.setText("accuracy-title", `What design ${design.number} achieves`);
    report.setSentences("accuracy", design.sentences);
    report.setSentences("deviations-text", design.deviationsText);
    const tables = { plan: design.plan, "budget-table": design.budget };
    if (captions["criteria-table"]) tables["criteria-table"] = design.criteria;
    if (showEllipses) tables["ellipse-table"] = design.ellipseTable;
    for (const [id, rows] of Object.entries(tables)) {
      report.setTable(id, rows, captions[id].replace("{design}", design.number));
    }
    showState();
    const views = [showEllipses, showMap].filter(Boolean).map((show) => show(index));
    return Promise.all([drawFront(), drawBudget(), ...views]);
  }

  report.csv.plan = () => ({ filename: `plan-design-${designs[current].number}.csv`, text: designs[current].csv });
  report.csv["budget-table"] = () => ({ filename: `error-budget-design-${designs[current].number}.csv`, text: csvOfBudget() });
  report.csv.budget = report.csv["budget-table"];
  if (showEllipses) report.csv["ellipse-table"] = () => ({ filename: `ellipses-design-${designs[current].number}.csv`, text: report.tableText("ellipse-table") });
  if (captions["criteria-table"]) report.csv["criteria-table"] = () => ({ filename: `criteria-design-${designs[current].number}.csv`, text: report.tableText("criteria-table") });
  report.csv.front = report.csv.designs;

  report.onChoice("designs", select);
  element("choose-recommended").addEventListener("click", () => select(recommended));
  element("choose-knee").addEventListener("click", () => select(knee));
  if (robot) element("state").addEventListener("change", showState);
  if (horizontal) for (const selector of [horizontal, vertical]) selector.addEventListener("change", drawFront);

  select(recommended).then(() => {
    element("front").on("plotly_click", ({ points }) => {
      const index = points[0].customdata;
      select(Array.isArray(index) ? index[0] : index);
    });
    document.documentElement.dataset.ready = "true";
  });
})();

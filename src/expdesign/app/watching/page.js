// Draws the state of a run as often as it changes, and passes on the wish to end it.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const INTERVAL = 300;   // ms between questions
  const UNANSWERED = 10;  // questions without an answer after which the command is taken to have ended
  const button = byId("end"), said = byId("said"), bar = byId("bar");
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  let last = null, failures = 0;

  const number = (value) => (value === null ? "–" : Number(value.toPrecision(4)).toString());

  function look() { document.documentElement.dataset.theme = dark.matches ? "dark" : "light"; }

  function draw(id, data, x, y, state) {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = (title) => ({
      title: { text: title }, gridcolor: colour("--grid"), linecolor: colour("--line"), zeroline: false, automargin: true,
    });
    const layout = {
      height: id === "front" ? 380 : 220, margin: { l: 56, r: 16, t: 12, b: 48 }, showlegend: false, dragmode: false,
      paper_bgcolor: colour("--card"), plot_bgcolor: colour("--card"), hovermode: "closest",
      font: { family: getComputedStyle(document.body).fontFamily, size: 13, color: colour("--ink") },
      xaxis: axis(x), yaxis: axis(y), uirevision: state.objectives.join(),
    };
    for (const trace of data) trace.marker = { ...trace.marker, color: colour(trace.marker.color) };
    for (const trace of data) if (trace.line) trace.line.color = trace.marker.color;
    Plotly.react(byId(id), data, layout, { responsive: true, displayModeBar: false, plotlyServerURL: "" });
  }

  function prepare(state) {
    const names = state.objectives;
    byId("axes").hidden = names.length < 3;
    for (const [place, id] of ["across", "up"].entries()) {
      byId(id).replaceChildren(...names.map((name, index) => new Option(name, String(index))));
      byId(id).value = String(Math.min(place, names.length - 1));
      byId(id).addEventListener("change", () => show(last));
    }
    const [title, value] = [document.createElement("dt"), document.createElement("dd")];
    value.innerHTML = '<span class="value" id="best">–</span>';
    title.textContent = `Best ${names[0]}`;
    byId("least").append(title, value);
  }

  function words(state) {
    if (state.end === "failed") return `There is no result. ${state.message}`;
    if (state.end !== null) return `The run has ${state.end === "ended" ? "been ended" : "finished"}. The report opens by itself; it is in ${state.folder}.`;
    const steps = state.total ? `${state.done} of ${state.total}` : "";
    const stage = { searching: "Searching, generation", bounding: "Bounding what any plan can reach, step", starting: "Starting", writing: "Writing the report" }[state.stage] || state.stage;
    const now = `${[stage, steps].filter(Boolean).join(" ")}${state.note ? ": " + state.note : ""}.`;
    return state.ending && state.stage === "searching" ? `Ending as soon as this round is done. ${now}` : now;
  }

  function show(state) {
    if (last === null) prepare(state);
    const fresh = last === null || last.front.length !== state.front.length || last.course.length !== state.course.length;
    last = state;
    said.textContent = words(state);
    bar.max = state.total || 1;
    bar.value = state.end === null ? state.done : bar.max;
    byId("designs").textContent = state.front.length || "–";
    byId("hypervolume").textContent = number(state.hypervolume);
    byId("elapsed").textContent = state.elapsed_s.toFixed(1);
    byId("best").textContent = state.front.length ? number(state.front[0][0]) : "–";
    button.disabled = state.ending || state.end !== null || state.stage !== "searching";
    button.textContent = state.ending ? "Ending" : "End with what is there";
    if (!state.front.length) return;
    const [x, y] = [Number(byId("across").value), Number(byId("up").value)];
    const single = state.objectives.length === 1;
    const points = { type: "scatter", mode: "markers", marker: { color: "--accent", size: 9 },
      x: state.front.map((row, index) => (single ? index + 1 : row[x])), y: state.front.map((row) => row[y]) };
    draw("front", [points], single ? "Design" : state.objectives[x], state.objectives[y], state);
    const course = { type: "scatter", mode: "lines", line: { width: 2, shape: "hv" }, marker: { color: "--recommended" },
      x: state.course.map((row) => row[0]), y: state.course.map((row) => row[1]) };
    draw("course", [course], "Time, s", "Hypervolume", state);
    if (fresh) document.documentElement.dataset.drawn = String(state.course.length);
  }

  button.addEventListener("click", async () => {
    button.disabled = true;
    const answer = await fetch("end", { method: "POST", headers: { "X-Key": document.body.dataset.key } });
    if (!answer.ok) said.textContent = "The wish to end did not arrive; press Ctrl-C where the command runs.";
  });

  async function ask() {
    try {
      const state = await (await fetch("state", { cache: "no-store" })).json();
      failures = 0;
      show(state);
      if (state.report) { setTimeout(() => location.replace("report"), calm.matches ? 0 : 800); return; }
      if (state.end === "failed") return;
    } catch {
      failures += 1;
      if (failures >= UNANSWERED) {
        said.textContent = `The command has ended. Its results are in ${last ? last.folder : "its folder"}.`;
        button.disabled = true;
        return;
      }
    }
    setTimeout(ask, INTERVAL);
  }

  look();
  dark.addEventListener("change", () => { look(); if (last) show(last); });
  ask();
})();

// Error ellipses at a target: 95 % outlines of two coordinates, from noise, from load errors and from both.
"use strict";
function ellipseView({ scale, views }, designs) {
  const selector = document.getElementById("ellipse-view");
  if (!selector) return null;
  let current = 0;

  /** Outline of the ellipse of a covariance xx, xy, yy. */
  function outline([xx, xy, yy]) {
    if (xx === null) return { x: [], y: [] };
    const a = Math.sqrt(xx);
    const b = a > 0 ? xy / a : 0;
    const c = Math.sqrt(Math.max(0, yy - b * b));
    const turns = Array.from({ length: 121 }, (_, index) => (2 * Math.PI * index) / 120);
    return {
      x: turns.map((turn) => scale * a * Math.cos(turn)),
      y: turns.map((turn) => scale * (b * Math.cos(turn) + c * Math.sin(turn))),
    };
  }

  function parts() {
    const [a, b, c, d, e, f] = designs[current].ellipses[Number(selector.value)];
    const sum = (one, other) => (one === null || other === null ? null : one + other);
    return [["both", "total", [sum(a, d), sum(b, e), sum(c, f)]], ["measurement noise", "noise", [a, b, c]], ["load errors", "load", [d, e, f]]];
  }

  function draw() {
    const view = views[Number(selector.value)];
    const outlines = parts().map(([name, colour, covariance]) => ({ name, colour, ...outline(covariance) }));
    const reach = ["x", "y"].map((axis) => Math.max(1e-12, ...outlines[0][axis].map(Math.abs)));
    const near = view.tolerance.map((tolerance, axis) => tolerance !== null && tolerance < 2.5 * Math.max(...reach));
    const ranges = reach.map((extent, axis) => 1.15 * Math.max(extent, near[axis] ? view.tolerance[axis] : 0));
    return report.update("ellipses", (figure) => {
      figure.data = outlines.map(({ name, colour, x, y }) => ({
        type: "scatter", mode: "lines", name, x, y, hoverinfo: "name",
        line: { color: `var(--${colour})`, width: 2.5, dash: { total: "solid", noise: "dash", load: "dot" }[colour] },
        ...(colour === "total" ? { fill: "toself", fillcolor: "var(--accent-soft)" } : {}),
      }));
      ["xaxis", "yaxis"].forEach((key, axis) => {
        figure.layout[key].title = { text: `error along ${view.axes[axis]} (${view.unit})` };
        figure.layout[key].range = [-ranges[axis], ranges[axis]];
      });
      figure.layout.shapes = view.tolerance.flatMap((tolerance, axis) => (near[axis] ? [-1, 1] : []).map((side) => ({
        type: "line", line: { color: "var(--muted)", dash: "dot", width: 1.5 },
        ...(axis === 0
          ? { xref: "x", x0: side * tolerance, x1: side * tolerance, yref: "paper", y0: 0, y1: 1 }
          : { yref: "y", y0: side * tolerance, y1: side * tolerance, xref: "paper", x0: 0, x1: 1 }),
      })));
    });
  }

  report.csv.ellipses = () => {
    const view = views[Number(selector.value)];
    const rows = parts().flatMap(([name, , covariance]) => {
      const { x, y } = outline(covariance);
      return x.map((value, index) => [name, value * 1e-6, y[index] * 1e-6].join(","));
    });
    const head = ["part", ...view.columns].join(",");
    return { filename: `error-ellipses-target-${view.target}.csv`, text: `${[head, ...rows].join("\n")}\n` };
  };
  selector.addEventListener("change", draw);
  return (design) => { current = design; return draw(); };
}

// The error to expect over two coordinates: the product of each point's weights with the plan's covariance.
"use strict";
function mapView(charts, designs) {
  const selector = document.getElementById("map-view");
  if (!selector) return null;
  let current = 0;

  function floats(text) {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Array.from({ length: bytes.length / 4 }, (_, index) => view.getFloat32(4 * index, true));
  }
  const weights = charts.map((chart) => floats(chart.weight));

  /** RMS error in tolerances, row by row; null where it is not known. */
  function values(index) {
    const covariance = floats(designs[current].compliance);
    const [across, up] = charts[index].grid;
    return up.map((_, row) => across.map((__, column) => {
      const start = (row * across.length + column) * covariance.length;
      const square = covariance.reduce((sum, entry, place) => {
        const weight = weights[index][start + place];
        return weight === 0 ? sum : sum + entry * weight;  // what is not determined need not count here
      }, 0);
      return Number.isFinite(square) ? Math.sqrt(Math.max(0, square)) : null;
    }));
  }

  /** Where the chosen plan measures, in the coordinates of the chart. */
  function measured(chart) {
    const [head, ...rows] = designs[current].csv.trim().split("\n").map((line) => line.split(","));
    return chart.columns.map((name, axis) => rows.map((row) => Number(row[head.indexOf(name)]) * chart.factors[axis]));
  }

  function draw() {
    const index = Number(selector.value);
    const chart = charts[index];
    const [across, up] = chart.grid.map((grid, axis) => grid.map((value) => value * chart.factors[axis]));
    const [x, y] = measured(chart);
    return report.update("map", (figure) => {
      figure.data = [
        {
          type: "contour", x: across, y: up, z: values(index), colorscale: "Cividis", connectgaps: false,
          contours: { coloring: "heatmap", showlabels: true, labelfont: { color: "#ffffff", size: 11 } }, ncontours: 12,
          line: { color: "rgba(255,255,255,0.55)", width: 1 }, colorbar: { thickness: 12, title: { text: "tolerances", side: "right" } },
          hovertemplate: `${chart.titles[0]} %{x:.4g}<br>${chart.titles[1]} %{y:.4g}<br>%{z:.3g} tolerances<extra></extra>`,
        },
        {
          type: "scatter", mode: "markers", name: "measurements", x, y, cliponaxis: false,
          marker: { color: "#ffffff", size: 10, line: { color: "#16202b", width: 2 } }, hoverinfo: "name",
        },
        {
          type: "scatter", mode: "markers", name: `target ${chart.target}`, cliponaxis: false,
          x: [chart.at[0] * chart.factors[0]], y: [chart.at[1] * chart.factors[1]],
          marker: { color: "#ff5d3a", size: 16, symbol: "star", line: { color: "#ffffff", width: 1 } }, hoverinfo: "name",
        },
      ];
      figure.layout.xaxis = { title: { text: chart.titles[0] }, range: [across[0], across[across.length - 1]] };
      figure.layout.yaxis = { title: { text: chart.titles[1] }, range: [up[0], up[up.length - 1]] };
    });
  }

  report.csv.map = () => {
    const index = Number(selector.value);
    const { grid: [across, up], columns, target } = charts[index];
    const rows = values(index).flatMap((row, j) => row.map((value, i) => [across[i], up[j], value ?? ""].join(",")));
    return {
      filename: `accuracy-map-target-${target}.csv`,
      text: `${[[...columns, "rms_tolerances"].join(","), ...rows].join("\n")}\n`,
    };
  };
  selector.addEventListener("change", draw);
  return (design) => { current = design; return draw(); };
}

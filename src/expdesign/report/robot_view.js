// Draws a robot, its load and, faintly, where else the plan puts its platform (robot_view.py gives the geometry).
"use strict";
function robotView(id, view) {
  const inSpace = view.dimension === 3;
  const webgl = (() => {
    try { return Boolean(document.createElement("canvas").getContext("webgl")); } catch { return false; }
  })();
  const projected = inSpace && !webgl;
  const csvRows = [];

  /** Point `index` of a state, projected to the plane where the browser cannot draw in space. */
  function point(state, index) {
    const at = view.states[state].slice(index * view.dimension, (index + 1) * view.dimension);
    if (!projected) return at;
    const [c, s] = [Math.cos(Math.PI / 6), Math.sin(Math.PI / 6)];
    return [c * at[0] + s * at[1], 0.9 * at[2] + 0.4 * (c * at[1] - s * at[0])];
  }

  /** Least and largest coordinates of all states in the plane of projection, with room around. */
  const frame = (() => {
    if (!projected) return null;
    const limits = [[Infinity, -Infinity], [Infinity, -Infinity]];
    view.states.forEach((coordinates, state) => {
      for (let index = 0; index < coordinates.length / view.dimension; index++) {
        point(state, index).forEach((value, axis) => {
          limits[axis] = [Math.min(limits[axis][0], value), Math.max(limits[axis][1], value)];
        });
      }
    });
    return limits.map(([low, high]) => [low - 0.05 * view.size, high + 0.05 * view.size]);
  })();

  /** Coordinates of paths of point indices, with gaps between the paths. */
  function lines(state, paths) {
    const columns = inSpace && !projected ? [[], [], []] : [[], []];
    for (const path of paths) {
      for (const index of path) point(state, index).forEach((value, axis) => columns[axis].push(value));
      columns.forEach((column) => column.push(null));
    }
    const [x, y, z] = columns;
    return z ? { type: "scatter3d", x, y, z } : { type: "scatter", x, y };
  }

  const style = {
    base: { mode: "lines+markers", line: { color: "var(--base)", width: 3 }, marker: { color: "var(--base)", size: inSpace ? 4 : 9 } },
    actuator: { mode: "lines", line: { color: "var(--actuator)", width: inSpace ? 7 : 5 } },
    platform: { mode: "lines+markers", line: { color: "var(--platform)", width: 5 }, marker: { color: "var(--platform)", size: inSpace ? 4 : 9 } },
  };

  /** Show one state; `others` are states whose platform is drawn faintly. */
  function show(state, others) {
    const platform = view.parts.filter((part) => part.role === "platform").flatMap((part) => part.paths);
    const ghosts = others.filter((other) => other !== state);
    const traces = [];
    ghosts.forEach((other, number) => traces.push({
      ...lines(other, platform), mode: inSpace ? "lines" : "lines+markers", name: "platform in the other measurements",
      line: { color: "var(--ghost)", width: 2 }, marker: { color: "var(--ghost)", size: 6 },
      legendgroup: "ghost", showlegend: number === 0, hoverinfo: "skip",
    }));
    for (const part of view.parts) {
      traces.push({ ...lines(state, part.paths), ...style[part.role], name: part.name, hovertemplate: hover(part.name) });
    }
    traces.push({
      ...lines(state, [[view.origin, view.contact]]), mode: "lines+markers", name: "where the load acts",
      line: { color: "var(--mass)", width: 2, dash: "dot" },
      marker: { color: "var(--mass)", size: inSpace ? [0, 6, 0] : [0, 11, 0], line: { width: 0 } },
      hovertemplate: hover("where the load acts"),
    });
    const arrow = lines(state, [[view.contact, view.tip]]);
    if (arrow.type === "scatter3d") {
      traces.push({ ...arrow, mode: "lines", name: "force", line: { color: "var(--force)", width: 7 }, hoverinfo: "skip" });
      const [from, to] = [point(state, view.contact), point(state, view.tip)];
      const [u, v, w] = to.map((value, axis) => value - from[axis]);
      if (Math.hypot(u, v, w) > 0) {
        traces.push({
          type: "cone", x: [to[0]], y: [to[1]], z: [to[2]], u: [u], v: [v], w: [w], anchor: "tip", sizemode: "absolute",
          sizeref: 0.06 * view.size, colorscale: [[0, "var(--force)"], [1, "var(--force)"]], showscale: false, hoverinfo: "skip",
        });
      }
    } else {
      traces.push({
        ...arrow, mode: "lines+markers", name: "force", line: { color: "var(--force)", width: 3 }, hoverinfo: "skip",
        marker: { color: "var(--force)", size: [0, 14, 0], symbol: "arrow", angleref: "previous", line: { width: 0 } },
      });
    }
    csvRows.length = 0;
    for (const part of view.parts) {
      part.paths.forEach((path, number) => path.forEach((index) => csvRows.push([part.name, number + 1, index])));
    }
    csvRows.push(["platform origin", 1, view.origin], ["where the load acts", 1, view.contact]);
    report.update(id, (figure) => {
      figure.data = traces;
      if (inSpace && !projected) {
        ["xaxis", "yaxis", "zaxis"].forEach((axis, number) => { figure.layout.scene[axis].range = view.bounds[number]; });
        const [x, y, z] = view.aspect;
        figure.layout.scene.aspectratio = { x, y, z };
      } else if (projected) {
        // The same frame for every state, wide enough for markers, arrows and the buttons above the figure.
        delete figure.layout.scene;
        const [across, up] = frame;
        Object.assign(figure.layout, {
          xaxis: { visible: false, range: across, constrain: "domain" },
          yaxis: { visible: false, range: up, scaleanchor: "x", constrain: "domain" },
          margin: { l: 8, r: 8, t: 44, b: 70 },
        });
      } else {
        figure.layout.xaxis.range = view.bounds[0];
        figure.layout.yaxis.range = view.bounds[1];
      }
    });
    report.csv[id] = () => ({ filename: "robot.csv", text: csvText(state) });
  }

  function hover(name) {
    if (projected) return `${name}<extra></extra>`;
    return `${name}<br>x %{x:.4f} m<br>y %{y:.4f} m${inSpace ? "<br>z %{z:.4f} m" : ""}<extra></extra>`;
  }

  function csvText(state) {
    const head = ["part", "line", ...["x_m", "y_m", "z_m"].slice(0, view.dimension)];
    const body = csvRows.map(([name, number, index]) => [
      name, number, ...view.states[state].slice(index * view.dimension, (index + 1) * view.dimension),
    ]);
    return [head, ...body].map((row) => row.join(",")).join("\n") + "\n";
  }

  return { show };
}

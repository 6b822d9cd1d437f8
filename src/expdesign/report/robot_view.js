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

  /** Least and largest coordinates of what is shown, with room around: the whole state and the platforms of others. */
  function bounds(state, others, moving) {
    const limits = Array.from({ length: projected ? 2 : view.dimension }, () => [Infinity, -Infinity]);
    const include = (at) => at.forEach((value, axis) => {
      limits[axis] = [Math.min(limits[axis][0], value), Math.max(limits[axis][1], value)];
    });
    for (let index = 0; index < view.states[state].length / view.dimension; index++) include(point(state, index));
    for (const other of others) for (const index of moving.flat()) include(point(other, index));
    const room = (axis) => (view.dimension === 2 && axis === 0 ? 0.1 : 0.04) * view.size; // names are wide
    return limits.map(([low, high], axis) => [low - room(axis), high + room(axis)]);
  }

  /**
   * Scale (per m) at which a state fills the picture from the camera at `eye`, and the axes around it keep room for their
   * numbers. A point at p from the middle of the scene appears at (up·p, right·p) / (|eye| - n·p), n towards the camera,
   * in a view of 45 degrees.
   */
  function filling(state, frame, { x, y, z }) {
    const { clientWidth, clientHeight } = document.getElementById(id);
    const distance = Math.hypot(x, y, z);
    const n = [x, y, z].map((value) => value / distance);
    const level = Math.hypot(n[0], n[1]);
    const right = [-n[1] / level, n[0] / level, 0];
    const up = [-n[2] * right[1], n[2] * right[0], n[0] * right[1] - n[1] * right[0]];
    const whole = Math.tan(Math.PI / 8);
    const shape = Math.min(1.5, clientWidth / Math.max(1, clientHeight - 68));
    const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
    let scale = 4 / Math.max(...frame.map(([low, top]) => top - low));
    const drawn = Array.from({ length: view.states[state].length / 3 }, (_, index) => [0.6, point(state, index)]);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0.75, frame.map((ends, axis) => ends[(bits >> axis) & 1])]);
    for (const [part, at] of [...drawn, ...corners]) {
      const p = at.map((value, axis) => value - (frame[axis][0] + frame[axis][1]) / 2);
      for (const [direction, share] of [[up, part * whole], [right, part * whole * shape]]) {
        const needed = Math.abs(dot(direction, p)) + share * dot(n, p);
        if (needed > 0) scale = Math.min(scale, (share * distance) / needed);
      }
    }
    return scale;
  }

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

  /** Names at points of a state; in the plane, one that would cover another that comes before it is moved down. */
  function names(state, texts, first, look) {
    const shown = lines(state, texts.map((_, index) => [first + index]));
    if (view.dimension === 2) {
      const [wide, high] = [0.1 * view.size, 0.06 * view.size];
      const covers = (k, other) => Math.abs(shown.x[k] - shown.x[other]) < wide && Math.abs(shown.y[k] - shown.y[other]) < 0.99 * high;
      for (let k = 0; k < shown.y.length; k += 2) {
        while (shown.y.some((_, other) => other < k && other % 2 === 0 && covers(k, other))) shown.y[k] -= high;
      }
    }
    return {
      ...shown, text: texts.flatMap((text) => [text, ""]), showlegend: false, hoverinfo: "skip",
      textfont: { color: "var(--ink)", size: 13 }, ...look,
    };
  }

  const numbers = view.labels.map((name) => name.replace(/^(joint|leg) /, ""));

  /** Numbers of legs or joints as notes in space, in front of all that is drawn; those at one place stand in one note. */
  function notes(state) {
    const found = [];
    numbers.forEach((text, index) => {
      const at = point(state, view.tip + 1 + index);
      const same = found.find((note) => Math.hypot(...at.map((value, axis) => value - note.at[axis])) < 0.04 * view.size);
      if (same) same.text += `, ${text}`;
      else found.push({ at, text });
    });
    return found.map(({ at: [x, y, z], text }) => ({
      x, y, z, text, showarrow: false, font: { color: "var(--ink)", size: 13 }, bgcolor: "var(--card)", opacity: 0.85, borderpad: 0,
    }));
  }

  /** Joints' axes, numbers, markers, and the components that are concerned. */
  function annotations(state) {
    const first = view.tip + 1;
    const traces = [];
    if (view.concerned.length) {
      traces.push({
        ...lines(state, view.concerned), mode: "lines+markers", name: "where the mismatch points", hoverinfo: "skip",
        line: { color: "var(--concerned)", width: inSpace && !projected ? 12 : 8 },
        marker: { color: "var(--concerned)", size: inSpace && !projected ? 6 : 11 },
      });
    }
    if (view.axes.length) {
      traces.push({
        ...lines(state, view.axes), mode: "lines", name: "axes of the joints, by number", hoverinfo: "skip",
        line: { color: "var(--muted)", width: 2, dash: "dash" },
      });
    }
    // In space the numbers are notes of the scene, which nothing hides; axes of joints end at their name, not in it.
    if (!inSpace || projected) {
      const place = view.axes.length ? "top center" : "middle center";
      traces.push(names(state, inSpace ? numbers : view.labels, first, { mode: "text", textposition: place }));
    }
    if (view.markers.length) {
      traces.push(names(state, view.markers, first + view.labels.length, {
        mode: "markers+text", textposition: "top center",
        marker: { color: "var(--marker)", size: inSpace && !projected ? 4 : 9, symbol: "diamond" },
      }));
    }
    return traces;
  }

  /** The force of the load, and where it acts. */
  function load(state) {
    const [at, head] = [view.contact, view.tip].map((index) => point(state, index));
    if (!view.loaded || at.every((value, axis) => value === head[axis])) return [];
    const traces = [{
      ...lines(state, [[view.origin, view.contact]]), mode: "lines+markers", name: "where the load acts",
      line: { color: "var(--mass)", width: 2, dash: "dot" },
      marker: { color: "var(--mass)", size: inSpace ? [0, 6, 0] : [0, 11, 0], line: { width: 0 } },
      hovertemplate: hover("where the load acts"),
    }];
    const arrow = lines(state, [[view.contact, view.tip]]);
    if (arrow.type === "scatter3d") {
      traces.push({ ...arrow, mode: "lines", name: "force", line: { color: "var(--force)", width: 7 }, hoverinfo: "skip" });
      const [[x, y, z], [u, v, w]] = [head, head.map((value, axis) => value - at[axis])];
      traces.push({
        type: "cone", x: [x], y: [y], z: [z], u: [u], v: [v], w: [w], anchor: "tip", sizemode: "absolute",
        sizeref: 0.06 * view.size, colorscale: [[0, "var(--force)"], [1, "var(--force)"]], showscale: false, hoverinfo: "skip",
      });
    } else {
      traces.push({
        ...arrow, mode: "lines+markers", name: "force", line: { color: "var(--force)", width: 3 }, hoverinfo: "skip",
        marker: { color: "var(--force)", size: [0, 14, 0], symbol: "arrow", angleref: "previous", line: { width: 0 } },
      });
    }
    return traces;
  }

  /** Show one state; `others` are states whose platform is drawn faintly. */
  function show(state, others) {
    const platform = view.parts.filter((part) => part.role === "platform").flatMap((part) => part.paths);
    const ghosts = view.ghosts ? others.filter((other) => other !== state) : [];
    const traces = [];
    ghosts.forEach((other, number) => traces.push({
      ...lines(other, platform), mode: inSpace ? "lines" : "lines+markers", name: `${view.moving} in the other measurements`,
      line: { color: "var(--ghost)", width: 2 }, marker: { color: "var(--ghost)", size: 6 },
      legendgroup: "ghost", showlegend: number === 0, hoverinfo: "skip",
    }));
    for (const part of view.parts) {
      traces.push({ ...lines(state, part.paths), ...style[part.role], name: part.name, hovertemplate: hover(part.name) });
    }
    traces.push(...annotations(state), ...load(state));
    const frame = bounds(state, ghosts, platform);
    csvRows.length = 0;
    for (const part of view.parts) {
      part.paths.forEach((path, number) => path.forEach((index) => csvRows.push([part.name, number + 1, index])));
    }
    csvRows.push([`origin of the ${view.moving}`, 1, view.origin]);
    if (view.loaded) csvRows.push(["where the load acts", 1, view.contact]);
    view.axes.forEach(([from, to]) => csvRows.push(["axes of the joints", 1, from], ["axes of the joints", 1, to]));
    view.markers.forEach((name, index) => csvRows.push([`marker ${name}`, 1, view.tip + 1 + view.labels.length + index]));
    report.update(id, (figure) => {
      figure.data = traces;
      if (inSpace && !projected) {
        const longest = Math.max(...frame.map(([low, high]) => high - low));
        ["xaxis", "yaxis", "zaxis"].forEach((axis, number) => {
          const [low, high] = frame[number];
          Object.assign(figure.layout.scene[axis], { range: [low, high], nticks: 2 + Math.round((5 * (high - low)) / longest) });
        });
        figure.layout.scene.annotations = notes(state);
        const scale = filling(state, frame, figure.layout.scene.camera.eye);
        const [x, y, z] = frame.map(([low, high]) => scale * (high - low));
        figure.layout.scene.aspectratio = { x, y, z };
      } else if (projected) {
        delete figure.layout.scene;
        const [across, up] = frame;
        Object.assign(figure.layout, {
          xaxis: { visible: false, range: across, constrain: "domain" },
          yaxis: { visible: false, range: up, scaleanchor: "x", constrain: "domain" },
          margin: { l: 8, r: 8, t: 44, b: 70 },
        });
      } else {
        figure.layout.xaxis.range = frame[0];
        figure.layout.yaxis.range = frame[1];
      }
    });
    report.csv[id] = () => ({ filename: `${id}.csv`, text: csvText(state) });
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

/** What a robot in space is seen from above, as large as it is in the plane. */
function fromAbove(view) {
  const states = view.states.map((at) => at.filter((_, index) => index % 3 < 2));
  const extent = (at, axis) => {
    const along = at.filter((_, index) => index % 2 === axis);
    return Math.max(...along) - Math.min(...along);
  };
  const size = Math.max(...states.map((at) => Math.hypot(extent(at, 0), extent(at, 1))));
  return { ...view, dimension: 2, states, size: size || view.size };
}

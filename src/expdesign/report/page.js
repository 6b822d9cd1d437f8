// What every report page can do: draw its figures in the chosen look, save pictures and data, change its tables.
"use strict";
const report = (() => {
  const content = JSON.parse(document.getElementById("report-content").textContent);
  const figures = content.figures;
  const csv = content.csv;
  const root = document.documentElement;
  const drawn = new Map();

  // ----- look
  const themeButton = document.getElementById("theme");
  const darkSystem = window.matchMedia("(prefers-color-scheme: dark)");
  let chosenTheme = null;
  try { chosenTheme = localStorage.getItem("expdesign-theme"); } catch { /* no storage for files: start afresh */ }

  function applyTheme(name) {
    root.dataset.theme = name;
    themeButton.setAttribute("aria-pressed", String(name === "dark"));
    for (const id of drawn.keys()) draw(id);
  }
  const currentTheme = () => chosenTheme || (darkSystem.matches ? "dark" : "light");
  themeButton.addEventListener("click", () => {
    chosenTheme = root.dataset.theme === "dark" ? "light" : "dark";
    try { localStorage.setItem("expdesign-theme", chosenTheme); } catch { /* as above */ }
    applyTheme(chosenTheme);
  });
  darkSystem.addEventListener("change", () => applyTheme(currentTheme()));
  let paperWidth = null;
  window.addEventListener("beforeprint", () => { paperWidth = 660; applyTheme("light"); });
  window.addEventListener("afterprint", () => { paperWidth = null; applyTheme(currentTheme()); });

  // ----- figures
  /** A copy of a figure's description with `var(--name)` replaced by the colour it stands for. */
  function resolved(value, style) {
    if (typeof value === "string") {
      const match = /^var\((--[\w-]+)\)$/.exec(value);
      return match ? style.getPropertyValue(match[1]).trim() : value;
    }
    if (Array.isArray(value)) return value.map((entry) => resolved(entry, style));
    if (value && typeof value === "object") {
      return Object.fromEntries(Object.entries(value).map(([key, entry]) => [key, resolved(entry, style)]));
    }
    return value;
  }

  function themed(plot, { clientWidth: width, clientHeight: height }) {
    const style = getComputedStyle(root);
    const colour = (name) => style.getPropertyValue(name).trim();
    const { data, layout } = resolved(plot, style);
    const axis = {
      gridcolor: colour("--grid"), linecolor: colour("--line"), zerolinecolor: colour("--line"),
      tickcolor: colour("--line"), automargin: true,
    };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis\d*$/.test(key)) layout[key] = { ...axis, ...layout[key] };
    }
    for (const key of ["xaxis", "yaxis"]) layout[key] = layout[key] || { ...axis };
    if (layout.scene) {
      for (const key of ["xaxis", "yaxis", "zaxis"]) {
        layout.scene[key] = {
          gridcolor: colour("--grid"), zerolinecolor: colour("--line"), linecolor: colour("--line"),
          showbackground: false, showspikes: false, nticks: 6, ...layout.scene[key],
        };
      }
    }
    const coarse = window.matchMedia("(pointer: coarse)").matches;
    return {
      data,
      layout: {
        autosize: true, ...(paperWidth ? { autosize: false, width: Math.min(width, paperWidth), height } : {}), margin: { l: 56, r: 16, t: 34, b: 48 }, hovermode: "closest",
        dragmode: coarse ? false : "zoom", clickmode: "event",
        ...layout,
        paper_bgcolor: colour("--card"), plot_bgcolor: colour("--card"),
        font: { family: getComputedStyle(document.body).fontFamily, size: width < 480 ? 11 : 13, color: colour("--ink") },
        modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("--muted"), activecolor: colour("--accent") },
        hoverlabel: { bgcolor: colour("--card"), bordercolor: colour("--muted"), font: { color: colour("--ink") }, align: "left" },
        legend: { orientation: "h", x: 0, y: 0, yref: "container", yanchor: "bottom", bgcolor: "rgba(0,0,0,0)", ...layout.legend },
      },
    };
  }

  function draw(id) {
    const element = document.getElementById(id);
    const { data, layout } = themed(figures[id], element);
    // plotly offers to send charts to a server of its maker by default; a report never leaves the computer.
    const config = {
      responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "",
      modeBarButtonsToRemove: ["toImage", "select2d", "lasso2d"],
    };
    drawn.set(id, true);
    return Plotly.react(element, data, layout, config);
  }

  /** Change a figure's description in place and draw it again. */
  function update(id, change) {
    change(figures[id]);
    return draw(id);
  }

  // ----- saving
  function save(filename, text, type) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = filename;
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  function saveCsv(id) {
    const file = typeof csv[id] === "function" ? csv[id]() : csv[id];
    save(file.filename, file.text, "text/csv;charset=utf-8");
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    if (button.dataset.csv) saveCsv(button.dataset.csv);
    if (button.dataset.picture) {
      const element = document.getElementById(button.dataset.of);
      const { clientWidth: width, clientHeight: height } = element;
      Plotly.downloadImage(element, {
        format: button.dataset.picture, filename: element.dataset.filename, width, height,
        ...(button.dataset.picture === "png" ? { scale: 2 } : {}),
      });
    }
    if (button.dataset.step) {
      const selector = document.getElementById(button.dataset.of);
      const length = selector.options.length;
      selector.selectedIndex = (selector.selectedIndex + Number(button.dataset.step) + length) % length;
      selector.dispatchEvent(new Event("change"));
    }
  });

  // ----- texts and tables
  function setText(id, text) {
    document.getElementById(id).textContent = text;
  }

  function setSentences(id, sentences) {
    document.getElementById(id).replaceChildren(...sentences.map((sentence) => {
      const item = document.createElement("li");
      sentence.split("`").forEach((part, index) => { // parts between marks are code
        const piece = document.createElement(index % 2 ? "code" : "span");
        piece.textContent = part;
        item.append(piece);
      });
      return item;
    }));
  }

  function setTable(id, rows, caption) {
    const body = document.getElementById(id).tBodies[0];
    const heads = document.getElementById(id).tHead.rows[0].cells;
    body.replaceChildren(...rows.map((cells) => {
      const row = document.createElement("tr");
      cells.forEach((text, column) => {
        const cell = document.createElement(column === 0 ? "th" : "td");
        if (column === 0) cell.scope = "row";
        cell.className = heads[column].className;
        cell.textContent = text;
        row.append(cell);
      });
      return row;
    }));
    if (caption) document.querySelector(`#${id}-caption span`).textContent = caption;
  }

  /** A table as it is shown, as CSV. */
  function tableText(id) {
    const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const rows = [...document.getElementById(id).rows];
    return rows.map((row) => [...row.cells].map((cell) => quoted(cell.textContent)).join(",")).join("\n") + "\n";
  }

  /** Call `listener` with the row's index when a row of a table of choices is chosen, by mouse or keyboard. */
  function onChoice(id, listener) {
    const table = document.getElementById(id);
    table.addEventListener("change", (event) => listener(Number(event.target.value)));
    table.tBodies[0].addEventListener("click", (event) => {
      if (event.target.closest("label")) return;
      const input = event.target.closest("tr").querySelector("input");
      input.focus({ preventScroll: true });
      if (!input.checked) { input.checked = true; listener(Number(input.value)); }
    });
  }

  function choose(id, index) {
    const rows = document.getElementById(id).tBodies[0].rows;
    for (const [number, row] of [...rows].entries()) row.classList.toggle("chosen", number === index);
    rows[index].querySelector("input").checked = true;
    const box = rows[index].closest(".scroll");
    const above = rows[index].offsetTop - 3 * rows[index].offsetHeight;
    const below = rows[index].offsetTop + 2 * rows[index].offsetHeight - box.clientHeight;
    if (box.scrollTop > above) box.scrollTop = Math.max(0, above);
    else if (box.scrollTop < below) box.scrollTop = below;
  }

  applyTheme(currentTheme());
  return { data: content.data, figures, csv, draw, update, setText, setSentences, setTable, tableText, onChoice, choose };
})();
for (const id of Object.keys(report.figures)) report.draw(id);

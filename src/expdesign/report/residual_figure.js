// Residuals against the coordinate that is chosen (residual_figure.py).
"use strict";
(() => {
  const selector = document.getElementById("residuals-over");
  const choices = report.data.residuals;
  function draw() {
    const { title, values } = choices[Number(selector.value)];
    report.update("residuals", (figure) => {
      for (const trace of figure.data) trace.x = values;
      figure.layout.xaxis.title = { text: title };
    });
  }
  selector.addEventListener("change", draw);
  document.documentElement.dataset.ready = "true";
})();

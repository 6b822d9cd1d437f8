// Unpacks what the page carries compressed (base 64 of RFC 4648 for file names, gzip), then runs its scripts in order.
"use strict";
(async () => {
  function bytes(text) {
    return Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
  }

  const unpacked = (text) =>
    new Response(new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"))).text();

  function execute(source) {
    const script = document.createElement("script");
    script.textContent = source;
    document.body.append(script);
  }

  const library = document.getElementById("plotly");
  if (library) execute(await unpacked(library.textContent.trim()));
  const content = document.getElementById("report-content");
  content.textContent = await unpacked(content.textContent.trim());
  for (const script of document.querySelectorAll("script.after-unpacking")) execute(script.textContent);
  document.documentElement.dataset.unpacked = "true";
})();

// Unpacks what the page carries compressed (base 85 with `,` for `<`, gzip), then runs its scripts in their order.
"use strict";
(async () => {
  const alphabet = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
  const digit = new Uint8Array(128);
  for (let index = 0; index < 85; index++) digit[alphabet.charCodeAt(index)] = index;

  function bytes(text) {
    const padding = (5 - (text.length % 5)) % 5;
    const whole = text + "~".repeat(padding);
    const out = new DataView(new ArrayBuffer((whole.length / 5) * 4));
    for (let group = 0; 5 * group < whole.length; group++) {
      let word = 0;
      for (let place = 0; place < 5; place++) word = word * 85 + digit[whole.charCodeAt(5 * group + place)];
      out.setUint32(4 * group, word);
    }
    return new Uint8Array(out.buffer, 0, out.byteLength - padding);
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

// Files that the page writes: they go to the browser's downloads.

function download(name, parts, type) {
  const url = URL.createObjectURL(new Blob(parts, {type}));
  const a = Object.assign(document.createElement("a"), {href: url, download: name});
  a.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

// A PFM file as render_map writes it: rows from the bottom to the top, little endian (scale -1.0), as is every host of WebAssembly.
function pfm({width, height, rgb}) {
  const row = 3 * width, body = new Float32Array(rgb.length);
  for (let y = 0; y < height; ++y) body.set(rgb.subarray(y * row, (y + 1) * row), (height - 1 - y) * row);
  return [`PF\n${width} ${height}\n-1.0\n`, body];
}

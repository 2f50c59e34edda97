#!/usr/bin/env python3
"""Joins the parts of the page into one HTML file that opens from disk.

assemble.py SOURCE_FOLDER MODULE.js OUT.html

Replaces these lines of page.html, each of which stands alone on its line (blanks around it do not matter):
    <link rel="stylesheet" href="page.css">             by the content of page.css in a style element
    <script type="text/plain" id="worker-source"></script>
        by the same element with a text: MODULE.js (Emscripten's output with the WebAssembly in it, which defines
        createTilemesh), then worker.js. page.js makes a Blob of this text and a Worker of the Blob
    <script src="NAME.js"></script>, one or more          by the content of NAME.js in a script element
In worker.js: `const module = await createTilemesh();` then module.cwrap(...), module._malloc, module._free,
module.HEAPU8, module.HEAPF32, module.HEAPF64, module.UTF8ToString, module.stringToUTF8, module.lengthBytesUTF8.
"""
import pathlib
import re
import sys


def main() -> None:
    folder, module, out = map(pathlib.Path, sys.argv[1:4])
    read = lambda path: path.read_text(encoding="utf-8")
    # A closing tag inside a script would end it; `<\/` is the same text in JavaScript.
    script = lambda text: text.replace("</script", "<\\/script")
    parts = {
        '<link rel="stylesheet" href="page.css">': lambda: f'<style>\n{read(folder / "page.css")}</style>',
        '<script type="text/plain" id="worker-source"></script>': lambda: '<script type="text/plain" id="worker-source">\n'
        + script(read(module) + "\n" + read(folder / "worker.js")) + "</script>",
    }
    lines = []
    for line in read(folder / "page.html").splitlines():
        part = parts.pop(line.strip(), None)
        if own := re.fullmatch(r'<script src="([a-z_]+\.js)"></script>', line.strip()):
            part = lambda: f"<script>\n{script(read(folder / own[1]))}</script>"
        lines.append(line if part is None else part())
    if parts:
        sys.exit(f"page.html lacks lines ({', '.join(parts)}); write each on a line of its own")
    out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

#!/bin/sh
# python.sh PYTHON LIBTILEMESH_C.so: examples/page/render.py renders a frame into numpy, and refuses a map that is none with one line.
set -eu
python=$1 library=$2
script=$(dirname "$0")/../../examples/page/render.py
if ! "$python" -c 'import numpy' 2>/dev/null; then
    echo "skipped: $python has no numpy (apt-get install python3-numpy)"
    exit 0
fi
text=$("$python" "$script" "$library")
echo "$text"
case $text in
"(360, 640, 3) mean 0.4"*" supersteps, "*" ms modelled") ;;
*) echo "render.py printed another text"; exit 1 ;;
esac
if refused=$("$python" "$script" "$library" "$script" 2>&1); then
    echo "render.py took its own text for a map"
    exit 1
fi
echo "$refused"
test "$(printf '%s\n' "$refused" | wc -l)" = 1
case $refused in
"render.py: "*"("*"); "*) ;;
*) echo "that is not one line of the library"; exit 1 ;;
esac

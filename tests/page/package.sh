#!/bin/sh
# package.sh PYTHON BUILD: the Python package in BUILD/python. The example of its README prints what the README says; package.py tests the
# rest, once with numpy and once without. Pictures are compared with those of BUILD/examples/render_map where that was built.
set -eu
python=$1 build=$2
here=$(cd "$(dirname "$0")" && pwd)
readme=$here/../../examples/python/README.md
render_map=$build/examples/render_map
export PYTHONPATH="$build/python" PYTHONDONTWRITEBYTECODE=1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ -x "$render_map" ]; then
    cat >"$work/four.ply" <<PLY
ply
format ascii 1.0
element vertex 4
$(for name in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $name"; done)
end_header
0 0 0 1 0.5 0.2 4 -2 -1 -2 1 0 0 0
1 0 0 -1 0.5 0.2 2 -2 -2 -1 1 0.2 0 0
0 1 0.5 1 -0.5 1.2 1 -1 -2 -2 1 0 0.4 0
-1 -1 0 0 1.5 0.2 3 -2 -1 -2 1 0 0 0.3
PLY
    for quality in default viewing; do
        chosen="" # --quality has no word for the preset's own cut-offs
        [ $quality = default ] || chosen="--quality $quality"
        for map in "" "$work/four.ply"; do
            out=$work/built_in.$quality
            [ -z "$map" ] || out=$work/four.$quality
            "$render_map" $map --size 320x180 --float --depth --alpha $chosen --report "$out/report.json" --out "$out" >/dev/null 2>&1
        done
    done
else
    echo "skipped: there is no $render_map, so pictures are not compared with render_map's"
fi
for without in "" numpy; do
    if [ -z "$without" ] && ! "$python" -c 'import numpy' 2>/dev/null; then
        echo "skipped: $python has no numpy (apt-get install python3-numpy)"
        continue
    fi
    WITHOUT=$without WORK=$work "$python" -W error "$here/package.py" -q
    awk '/^```python/ { code = 1; next } /^```/ { code = 0 } code' "$readme" >"$work/example.py"
    awk '/^```python/ { after = 1; next } after && /^```$/ { n++; next } n == 3 { exit } n == 2' "$readme" | grep . >"$work/expected"
    WITHOUT=$without "$python" -W error -c 'import os, runpy, sys
if os.environ["WITHOUT"]: sys.modules["numpy"] = None
runpy.run_path(sys.argv[1])' "$work/example.py" >"$work/printed"
    test "$(wc -l <"$work/example.py")" -le 10
    # The last digits may differ where products and sums are fused.
    if ! diff "$work/expected" "$work/printed"; then
        echo "the example of $readme prints another text"
        exit 1
    fi
done

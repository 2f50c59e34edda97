#!/bin/sh
# python.sh PYTHON LIBTILEMESH_C.so: examples/c/render.py renders a frame into numpy, and refuses a map that is none with one line.
# Where render_map was built beside the library without fused operations, the picture has the bits of render_map's.
set -eu
python=$1 library=$2
script=$(dirname "$0")/../../examples/c/render.py
render_map=$(dirname "$library")/render_map
if ! "$python" -c 'import numpy' 2>/dev/null; then
    echo "skipped: $python has no numpy (apt-get install python3-numpy)"
    exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
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

# A map of four Gaussians, from the camera that shows all of it.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 4\n'
    for name in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $name"; done
    printf 'end_header\n0 0 0 1 0.5 0.2 4 -2 -1 -2 1 0 0 0\n1 0 0 -1 0.5 0.2 2 -2 -2 -1 1 0.2 0 0\n0 1 0.5 1 -0.5 1.2 1 -1 -2 -2 1 0 0.4 0\n-1 -1 0 0 1.5 0.2 3 -2 -1 -2 1 0 0 0.3\n'
} >"$work/four.ply"
"$python" "$script" "$library" "$work/four.ply" "$work/four.npy"
# No picture takes the place of the map or of the library.
cp "$work/four.ply" "$work/kept.ply"
ln "$work/four.ply" "$work/hard.npy"
ln -s four.ply "$work/link.npy"
ln -s "$library" "$work/library.npy"
for picture in "$work/four.ply" "$work/../$(basename "$work")/four.ply" "$work/hard.npy" "$work/link.npy" "$work/library.npy"; do
    if refused=$("$python" "$script" "$library" "$work/four.ply" "$picture" 2>&1); then
        echo "render.py wrote its picture over what it reads: $picture"
        exit 1
    fi
    case $refused in
    "render.py: cannot write the picture to "*" (this run reads that file); "*) ;;
    *) echo "not the refusal of $picture: $refused"; exit 1 ;;
    esac
    cmp "$work/four.ply" "$work/kept.ply"
done
# Names with bytes that are no UTF-8 are read, and escaped where they are shown.
latin=$work/$(printf 'latin\351\033')
for map in absent taken; do
    [ $map = absent ] || cp "$script" "$latin"
    refused=$("$python" "$script" "$library" "$latin" 2>&1) && exit 1
    case $refused in
    "render.py: "*"latin??"*"("*"); "*) ;;
    *) echo "not one line about a map of another name: $refused"; exit 1 ;;
    esac
done
if [ ! -x "$render_map" ]; then
    echo "skipped: there is no $render_map, so the picture is not compared with render_map's"
    exit 0
fi
"$render_map" "$work/four.ply" --size 640x360 --program anchored --float --out "$work" >"$work/log"
"$python" - "$work/four.npy" "$work/frame_0000.pfm" <<'PYTHON'
import sys
import numpy
ours = numpy.load(sys.argv[1])
with open(sys.argv[2], "rb") as file:
    head = [file.readline() for _ in range(3)]
    theirs = numpy.frombuffer(file.read(), "<f4").reshape(360, 640, 3)[::-1]
assert head[1] == b"640 360\n", head
assert ours.max() > 0.1, "the picture is black"
most = abs(ours - theirs).max()
print("the picture has the bits of render_map's" if most == 0 else f"the picture differs from render_map's by at most {most:.3g}")
assert most < 1e-4, "more than fused operations change"  # with fused operations: alpha within 2e-5, transmittance after four splats
PYTHON

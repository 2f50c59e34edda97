#!/bin/sh
# What render_map does with cameras: a crop is the window of its picture in every format, near planes that hide something say so, and maps
# that were trained with anti-aliasing.
# Usage: sh render_map_cameras.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# map UNIT: 60 large Gaussians around the axis, many of them beside the picture, at depths of 0.05 to 3 units.
map() {
    awk -v unit="$1" 'BEGIN {
        print "ply\nformat ascii 1.0\nelement vertex 60"
        n = split("x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3", names, " ")
        for (i = 1; i <= n; ++i) print "property float " names[i]
        print "end_header"
        for (i = 0; i < 60; ++i) {
            z = (0.05 + 0.05 * i) * unit
            s = log(0.3 * z)
            print 1.7 * z * sin(2.4 * i), (i % 3 ? 1.2 : 0.5) * z * cos(1.7 * i), z, sin(i), cos(i), sin(2 * i), 2, s, s - 1, s - 2, 1, sin(3 * i), cos(5 * i), 0.3
        }
    }'
}
map 1 >map.ply
small="--threads 2 --quiet --float --arithmetic precise"

# --- crops -------------------------------------------------------------------------------------
# camera FORMAT WIDTH HEIGHT CX CY: a camera at the origin that looks along +z, fx = fy = 60.
camera() {
    case $1 in
    own.json)
        printf '{"cameras": [{"name": "c", "width": %s, "height": %s, "fx": 60, "fy": 60, "cx": %s, "cy": %s, "near": 0.01,
            "world_to_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}' "$2" "$3" "$4" "$5" >own.json
        ;;
    transforms.json)
        printf '{"w": %s, "h": %s, "fl_x": 60, "fl_y": 60, "cx": %s, "cy": %s, "frames": [{"file_path": "c.png",
            "transform_matrix": [[1,0,0,0],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]}]}' "$2" "$3" "$4" "$5" >transforms.json
        ;;
    model)
        mkdir -p model
        printf '1 PINHOLE %s %s 60 60 %s %s\n' "$2" "$3" "$4" "$5" >model/cameras.txt
        printf '1 1 0 0 0 0 0 0 1 c.png\n\n' >model/images.txt
        ;;
    esac
}
# pixels FILE: the floats of a PFM, without its header of three lines.
pixels() { tail -n +4 "$1" 2>/dev/null; }
for format in own.json transforms.json model; do
    # The picture has its principal point in the middle. A PFM begins with the lowest row.
    camera $format 128 72 64 36
    runs $small map.ply --cameras $format --near 0.01 --out whole
    pixels whole/frame_0000.pfm >whole.bytes
    for name in anchored homes; do
        camera $format 128 30 64 -6 # its lowest 30 rows
        runs $small map.ply --cameras $format --near 0.01 --program $name --out crop
        pixels crop/frame_0000.pfm >crop.bytes
        equal "bytes of $format" "$(wc -c <crop.bytes)" $((128 * 30 * 12))
        head -c $((128 * 30 * 12)) whole.bytes | cmp -s - crop.bytes || fail "$format, $name: the lowest rows are not those of the picture"
        camera $format 128 20 64 36 # its highest 20 rows
        runs $small map.ply --cameras $format --near 0.01 --program $name --out crop
        pixels crop/frame_0000.pfm >crop.bytes
        tail -c $((128 * 20 * 12)) whole.bytes | cmp -s - crop.bytes || fail "$format, $name: the highest rows are not those of the picture"
    done
    # Trainers bound slopes by half of the picture's height, wherever the principal point is.
    camera $format 128 72 64 36
    runs $small map.ply --cameras $format --quality training --out whole
    camera $format 128 30 64 -6
    runs $small map.ply --cameras $format --quality training --out crop
    pixels whole/frame_0000.pfm | head -c $((128 * 30 * 12)) >whole.bytes
    pixels crop/frame_0000.pfm >crop.bytes
    if cmp -s whole.bytes crop.bytes; then fail "$format: training has no bounds of its own"; fi
done

# --- near planes -------------------------------------------------------------------------------
camera transforms.json 128 72 64 36
camera own.json 128 72 64 36 # it names 0.01
hidden='would be in the picture, but not beyond the near plane'
runs map.ply --cameras own.json --threads 2
if grep -q "$hidden" stdout; then fail "0.01 hides something"; fi
runs map.ply --cameras transforms.json --threads 2 --near 0.2
has stdout "1 Gaussian would be in the picture, but not beyond the near plane (0.200 world units), and is not drawn; --near moves it"
# The same map in other units has the same picture, but for the rounding: its near plane follows.
for unit in 0.01 0.001 0.00001; do
    map $unit >small.ply
    runs small.ply --cameras transforms.json --threads 2 --quiet --out small --report small.json
    map 0.1 >tenth.ply
    runs tenth.ply --cameras transforms.json --threads 2 --quiet --out tenth --report tenth.json
    equal "visible records in units of $unit" "$(counter small.json visible 0)" "$(counter tenth.json visible 0)"
done
runs map.ply --cameras transforms.json --threads 2 --near 50 --reference
has stdout "no Gaussian is in this picture, so these errors say nothing"
runs map.ply --cameras transforms.json --threads 2 --reference
if grep -q "these errors say nothing" stdout; then fail "a picture with Gaussians says nothing"; fi
# A camera from --from, and one that moves.
runs small.ply --from 0,0,0 --look 0,0,1 --size 128x72 --fov 90 --threads 2 --quiet --report from.json
[ "$(counter from.json visible 0)" -gt 10 ] || fail "a camera of --from sees nothing of a small map"

# --- anti-aliasing -----------------------------------------------------------------------------
runs $small map.ply --cameras transforms.json --out plain
runs $small map.ply --cameras transforms.json --antialias --out dimmed --reference --report dimmed.json
if cmp -s plain/frame_0000.pfm dimmed/frame_0000.pfm; then fail "--antialias changes nothing"; fi
runs $small map.ply --cameras transforms.json --antialias --program homes --out dimmed_homes
same dimmed/frame_0000.pfm dimmed_homes/frame_0000.pfm

finish

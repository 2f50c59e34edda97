#!/bin/sh
# A table of all kinds of files that render_map reads and all kinds that it writes: no output takes the place of an input, whichever name
# leads to it. render_map_files.cpp has random names; this script has every pair.
# Usage: sh render_map_inputs.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

mkdir in in/model in/photos in/blender in/blender/train
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n'
} >in/map.ply
cp in/map.ply in/second.ply
printf '{"cameras": [{"scene": "any", "name": "a", "width": 16, "height": 12, "fx": 9, "fy": 9, "cx": 8, "cy": 6,
    "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}\n' >in/cameras.json
printf '1 PINHOLE 16 12 9 9 8 6\n' >in/model/cameras.txt
printf '1 1 0 0 0 0 0 0 1 a\n\n' >in/model/images.txt
printf '{"camera_angle_x": 1, "frames": [{"file_path": "./train/a", "transform_matrix": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]},
    {"file_path": "./train/b", "transform_matrix": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]]}]}\n' >in/blender/transforms.json
printf '0 0 0 0 0 0 0 1\n1 0.1 0 0 0 0 0 1\n' >in/walk.tum
small="--size 16x12 --grid 2x2 --threads 1 --quiet"
# shellcheck disable=SC2086
runs in/map.ply $small --cameras in/cameras.json --camera a --out made --trace made --float
for picture in in/photos/a.png in/blender/train/a.png in/blender/train/b.png; do cp made/frame_0000.png $picture; done
cp made/frame_0000.pfm in/other.pfm
cp made/model.txt in/model.txt
{
    echo 'energy test'
    for event in slot projection routed copied comparison pair pixel sent_byte capacity_byte tile_cycle; do echo "$event 1 fJ nobody"; done
} >in/energy.txt
cp -R in kept

# words INPUT FILE: the words of a run that reads FILE, or the folder of it, as its INPUT; in $words.
words() {
    more="--float --depth --alpha --trace clash/trace --follow 1"
    case $1 in
    map) words="$2 --cameras in/cameras.json --camera a $more" ;;
    second) words="in/map.ply $2 --cameras in/cameras.json --camera a $more" ;;
    cameras | model) words="in/map.ply --cameras $2 --camera a $more" ;;
    blender) words="in/map.ply --cameras $2 --camera train/a $more" ;;
    sized | sized_too) words="in/map.ply --cameras $2 --camera train/a $more" ;; # also of a camera that is not rendered
    trajectory) words="in/map.ply --trajectory $2 --relative $more" ;;
    photographs) words="in/map.ply --cameras in/cameras.json --camera a --photos $2 --error-picture $more" ;;
    other) words="in/map.ply --cameras in/cameras.json --camera a --compare $2 --error-picture $more" ;;
    cost_model) words="in/map.ply --cost-model $2 $more" ;;
    energy) words="in/map.ply --energy $2 $more" ;;
    esac
    case $words in *--cameras*) words="$words --grid 2x2 --threads 1 --quiet" ;; *) words="$words $small" ;; esac
}
runs_of=0
for input in map:in/map.ply second:in/second.ply cameras:in/cameras.json model:in/model/cameras.txt model:in/model/images.txt \
    blender:in/blender/transforms.json sized:in/blender/train/a.png sized_too:in/blender/train/b.png trajectory:in/walk.tum \
    photographs:in/photos/a.png other:in/other.pfm cost_model:in/model.txt energy:in/energy.txt; do
    kind=${input%%:*} file=${input#*:}
    case $kind in
    model) named=in/model ;;
    sized*) named=in/blender/transforms.json ;;
    photographs) named=in/photos ;;
    *) named=$file ;;
    esac
    # As it is, the run goes well.
    mkdir clash
    words $kind $named
    # shellcheck disable=SC2086
    runs $words --out clash/out --report clash/report.json --video clash/walk.y4m
    rm -r clash
    outputs="out/frame_0000.png out/frame_0000.pfm out/frame_0000.depth.pfm out/frame_0000.alpha.pfm trace/report.html trace/model.txt trace/frames.csv
        trace/follow_1.csv trace/frame_0000.tiles.csv trace/frame_0000.supersteps.csv trace/frame_0000.trace.json trace/no_progress.txt report.json walk.y4m"
    case $kind in
    photographs | other) outputs="$outputs out/frame_0000.error.png" ;;
    energy) outputs="$outputs trace/frame_0000.energy.csv" ;;
    esac
    for output in $outputs; do
        case $output in
        report.json) option="--report clash/report.json" ;;
        walk.y4m) option="--video clash/walk.y4m" ;;
        *) option= ;;
        esac
        for way in link hard_link link_to_link; do
            mkdir -p clash/out clash/trace
            case $way in
            link) ln -s "$work/$file" "clash/$output" ;;
            hard_link) ln "$file" "clash/$output" ;;
            link_to_link) ln -s "$work/$file" clash/first && ln -s "$work/clash/first" "clash/$output" ;;
            esac
            # shellcheck disable=SC2086
            refuses "this run reads that file" $words --out clash/out $option
            [ "$(find clash -type f -o -type l | wc -l)" -eq "$([ $way = link_to_link ] && echo 2 || echo 1)" ] || fail "a refused run wrote a file: $file as $output, a $way: $(find clash)"
            runs_of=$((runs_of + 1))
            rm -r clash
        done
    done
    # --report and --video name the file itself.
    mkdir -p clash/out
    for option in --report --video; do
        for name in "$file" "./$file" "in/../$file" "clash/out/../../$file" "$work/$file"; do
            # shellcheck disable=SC2086
            refuses "this run reads that file" $words --out clash/out $option "$name"
            runs_of=$((runs_of + 1))
        done
    done
    rm -r clash
    diff -r in kept >differences || fail "an input has changed ($file): $(cat differences)"
done
# An input that lies where an output goes, as a picture of an earlier run does.
for output in out/frame_0000.png trace/model.txt trace/frames.csv; do
    for input in map:in/map.ply cameras:in/cameras.json trajectory:in/walk.tum cost_model:in/model.txt energy:in/energy.txt other:in/other.pfm; do
        for spelling in "clash/$output" "clash/../clash/$output" "$work/clash/$output"; do
            mkdir -p clash/out clash/trace
            cp "${input#*:}" "clash/$output"
            words "${input%%:*}" "$spelling"
            # shellcheck disable=SC2086
            refuses "this run reads that file" $words --out clash/out
            same "${input#*:}" "clash/$output"
            runs_of=$((runs_of + 1))
            rm -r clash
        done
    done
done
[ $runs_of -ge 600 ] || fail "only $runs_of pairs of inputs and outputs were tried"
finish

#!/bin/sh
# Several maps, compressed maps, --turn and a folder of SOG, from the command line to the picture.
# Usage: sh render_map_maps.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# map FILE: the rows of standard input as an ASCII PLY.
map() {
    cat >rows
    {
        printf 'ply\nformat ascii 1.0\nelement vertex %d\n' "$(wc -l <rows)"
        for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
        echo end_header
        cat rows
    } >"$1"
}
near='-0.4 0.2 3 1.5 0.2 -1 2 -1.5 -2 -2.5 1 0.3 0 0.1'
far='0.5 -0.3 4 -1 1 0.5 1.5 -1 -2 -1.5 0.8 0 0.4 0.2'
echo "$near" | map near.ply
echo "$far" | map far.ply
printf '%s\n%s\n' "$near" "$far" | map both.ply
lens='--fov 60 --size 64x48 --quiet'
front='--from 0,0,-1 --look 0,0,1 --up 0,-1,0'

# seen NAME MAPS AND OPTIONS...: renders into NAME. picture: from the front.
seen() {
    name=$1
    shift
    # shellcheck disable=SC2086
    runs "$@" $lens --out "$name" --report "$name.json"
}
# shellcheck disable=SC2086
picture() { seen "$@" $front; }
# gaussians NAME: the number of Gaussians in its report.
gaussians() { sed -n 's/.*"gaussians": \([0-9]*\).*/\1/p' "$1.json" | head -1; }

# --- several maps are one ----------------------------------------------------------------------
picture both both.ply
picture two near.ply far.ply
same both/frame_0000.png two/frame_0000.png
[ "$(gaussians two)" = 2 ] || fail "two maps of one Gaussian have $(gaussians two)"
picture other far.ply near.ply
same both/frame_0000.png other/frame_0000.png # their depths order them, not their files
picture one near.ply
cmp -s both/frame_0000.png one/frame_0000.png && fail "the second map changes nothing"
refuses 'gone.ply cannot be opened (no such file)' near.ply gone.ply

# --- a .splat and an SPZ without compression ---------------------------------------------------
# .splat: mean 0.5 0 3, scales 0.25, red 255, opacity 230, rotation w 255.
printf '\000\000\000\077\000\000\000\000\000\000\100\100\000\000\200\076\000\000\200\076\000\000\200\076\377\000\000\346\377\200\200\200' >one.splat
# SPZ 2, degree 0, 12 bits: mean -0.5 0 -3 (y up, z back), opacity 230, colours 128 255 0, scales 128 (-2), rotation 128.
printf 'NGSP\002\000\000\000\001\000\000\000\000\014\000\000\000\370\377\000\000\000\000\320\377\346\200\377\000\200\200\200\200\200\200' >one.spz
picture splat one.splat
picture spz one.spz
picture packed one.splat one.spz near.ply
[ "$(gaussians packed)" = 3 ] || fail "a .splat, an SPZ and a PLY have $(gaussians packed) Gaussians"
grep -q 'one.splat: read as .splat' packed.json || fail "no note says that one.splat is a .splat"
grep -q 'one.spz: read as SPZ version 2' packed.json || fail "no note says that one.spz is an SPZ"
for alone in splat spz; do
    cmp -s "$alone/frame_0000.png" packed/frame_0000.png && fail "$alone alone is the picture of three maps"
done
head -c 30 one.spz >short.spz
refuses 'short.spz ends inside its attribute' near.ply short.spz

# --- --turn ------------------------------------------------------------------------------------
seen turned both.ply --turn x180 --from 0,0,1 --look 0,0,-1 --up 0,1,0
same both/frame_0000.png turned/frame_0000.png
seen not_turned both.ply --from 0,0,1 --look 0,0,-1 --up 0,1,0
cmp -s both/frame_0000.png not_turned/frame_0000.png && fail "--turn changes nothing"
refuses 'turn' both.ply --turn x45

# --- a folder of SOG, whose pictures have other names than .webp -------------------------------
mkdir room
# Lossless WebP of one pixel: low and high bytes of the mean, scales, rotation, colour and opacity.
printf '\122\111\106\106\032\000\000\000\127\105\102\120\126\120\070\114\016\000\000\000\057\000\000\000\000\007\020\021\375\017\104\104\377\003' >room/means_l.data
printf '\122\111\106\106\034\000\000\000\127\105\102\120\126\120\070\114\020\000\000\000\057\000\000\000\000\007\120\300\050\160\377\003\021\321\377\000' >room/means_u.data
printf '\122\111\106\106\032\000\000\000\127\105\102\120\126\120\070\114\016\000\000\000\057\000\000\000\000\007\020\021\375\017\104\104\377\003' >room/scales.data
printf '\122\111\106\106\036\000\000\000\127\105\102\120\126\120\070\114\021\000\000\000\057\000\000\000\020\007\120\300\002\026\260\374\201\210\350\177\000\000' >room/quats.data
printf '\122\111\106\106\034\000\000\000\127\105\102\120\126\120\070\114\017\000\000\000\057\000\000\000\020\007\020\375\217\232\007\042\242\377\001\000' >room/sh0.data
zeros=$(awk 'BEGIN { for (i = 1; i < 255; i++) printf "-2," }')
cat >room/meta.json <<END
{"version": 2, "count": 1,
 "means": {"mins": [-1, -1, 0], "maxs": [1, 1, 2], "files": ["means_l.data", "means_u.data"]},
 "scales": {"codebook": [-1.5,$zeros-2], "files": ["scales.data"]},
 "quats": {"files": ["quats.data"]},
 "sh0": {"codebook": [0.5,$zeros 1.5], "files": ["sh0.data"]}}
END
if run room --size 64x48 --quiet --out probe >stdout 2>stderr; then
    picture folder room
    picture meta room/meta.json
    same folder/frame_0000.png meta/frame_0000.png
    picture with_folder near.ply room/
    [ "$(gaussians with_folder)" = 2 ] || fail "a PLY and a folder of SOG have $(gaussians with_folder) Gaussians"
    # A picture of the map is an input: --resume notices that it changes, and no output may take its name.
    view="$lens $front"
    # shellcheck disable=SC2086
    {
        runs room $view --out resumed --resume
        runs room $view --out resumed --resume
        cp room/sh0.data kept
        cp room/scales.data room/sh0.data
        refuses 'sh0.data has changed since' room $view --out resumed --resume
        cp kept room/sh0.data
        runs room $view --out resumed --resume
        refuses 'sh0.data' room $view --out resumed --report room/sh0.data
    }
    same kept room/sh0.data
    rm room/quats.data
    refuses 'quats.data cannot be opened' room
else
    is_refusal $? 'libwebp-dev'
    skip "a folder of SOG (render_map was built without libwebp)"
fi

finish

#!/bin/sh
# What refine promises: photographs of a map make a spoilt copy of it better, also in views that are held out; the report's hash is that
# of the map, which render_map reads; threads change no byte; no output takes the place of an input; a signal leaves a whole map; and bad
# input is one line and status 2.
# Usage: sh refine.sh PATH_TO_refine PATH_TO_render_map
case $2 in /*) render_map=$2 ;; *) render_map=$PWD/$2 ;; esac
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# --- the command line --------------------------------------------------------------------------
runs --help
for option in --turn --sh-degree --antialias --cameras --camera --list --photos --size --ignore-distortion --steps --every --out --report --optimiser --rate --scale \
    --background --near --threads --quiet; do
    has stdout "^  $option "
done

# --- a COLMAP model with photographs that render_map took ---------------------------------------
mkdir -p colmap/sparse/0 colmap/images/left
printf '1 PINHOLE 96 64 80 80 48 32\n' >colmap/sparse/0/cameras.txt
names='left/a.png b.png c.png d.png e.png f.png g.png h.png i.png'
x=0
for name in $names; do
    echo "$((x + 1)) 1 0 0 0 -0.$x 0.1 0.$x 1 $name"
    echo
    x=$((x + 1))
done >colmap/sparse/0/images.txt
# room OFF: 60 Gaussians; OFF: how far they are from where they should be.
room() {
    printf 'ply\nformat ascii 1.0\nelement vertex 60\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    echo end_header
    awk -v off="$1" 'BEGIN {
        for (i = 0; i < 60; ++i) {
            e = off * ((i * 37 % 60) / 60 - 0.5); f = off * ((i * 23 % 60) / 60 - 0.5)
            print (i % 10 - 4.5) * 0.3 + 0.1 * e, (int(i / 10) - 2.5) * 0.3 + 0.1 * f, 2.5 + i % 3 + 0.1 * f,
                0.1 * (i % 7) + e, 0.05 * (i % 11) + f, 1 - 0.02 * i - e, 2 + e, -1.6 + f, -1.8 + e, -2 - f,
                1, 0.1 * (i % 4) + 0.3 * e, 0.2, 0.2 * f } }'
}
room 0 >truth.ply
room 1 >spoilt.ply
"$render_map" truth.ply --cameras colmap/sparse/0 --quiet --out taken >log 2>&1 || fail "render_map: $(cat log)"
frame=0
for name in $names; do
    cp taken/frame_000$frame.png "colmap/images/$name"
    frame=$((frame + 1))
done
cat truth.ply spoilt.ply colmap/sparse/0/*.txt colmap/images/*.png colmap/images/left/a.png >inputs
photos="--cameras colmap/sparse/0 --photos colmap/images"

# --- it becomes better, in held-out views too -----------------------------------------------------
# shellcheck disable=SC2086 # $photos is several words
runs spoilt.ply $photos --every 4 --steps 90 --out map.ply --report report.json
is_json report.json
# of FILE MEMBER: psnr_db of before or after.
of() { sed -nE "s/.*\"$2\": \\{\"psnr_db\": ([0-9.]+)\\}.*/\\1/p" "$1"; }
awk -v a="$(of report.json before)" -v b="$(of report.json after)" 'BEGIN { exit !(a > 15 && a < 30 && b > a + 10) }' ||
    fail "from $(of report.json before) to $(of report.json after) dB"
equal "the held-out views" "$(sed -nE 's/.*"camera": "([^"]*)".*/\1/p' report.json | tr '\n' ' ')" "b.png f.png left/a.png "
has stdout '^60 Gaussians, 6 photographs, 3 held out; before: [0-9.]* dB$'
has stdout '^after 90 steps: [0-9.]* dB; map.ply has the map$'
if command -v sha256sum >/dev/null; then
    equal "the map's hash" "$(sed -nE 's/.*"map_sha256": "([0-9a-f]*)".*/\1/p' report.json)" "$(sha256sum <map.ply | cut -d' ' -f1)"
else
    skip "sha256sum is absent, so nobody else computes the hash"
fi
# render_map reads the map, and compares it with the photographs as the report says. Its stop and its largest alpha are others.
"$render_map" map.ply $photos --every 4 --quiet --out shown --report shown.json >log 2>&1 || fail "render_map: $(cat log)"
shown=$(sed -nE 's/.*"psnr_db": ([0-9.]+).*/\1/p' shown.json | head -n 1)
awk -v a="$(of report.json after)" -v b="$shown" 'BEGIN { exit !(a - b < 2 && b - a < 2) }' ||
    fail "render_map has another PSNR than $(of report.json after)"

# --- the same bytes ---------------------------------------------------------------------------------
runs spoilt.ply $photos --every 4 --steps 90 --out again.ply --threads 3 --quiet
same map.ply again.ply
[ ! -s stdout ] || fail "--quiet prints"
runs spoilt.ply $photos --every 4 --steps 90 --out adam.ply --optimiser adam --report adam.json --quiet
awk -v a="$(of adam.json before)" -v b="$(of adam.json after)" 'BEGIN { exit !(b > a + 8) }' ||
    fail "adam: from $(of adam.json before) to $(of adam.json after) dB"
cmp -s map.ply adam.ply && fail "the optimisers have one map"
runs spoilt.ply $photos --scale 2 --steps 2 --out half.ply --quiet
runs spoilt.ply $photos --size 48x32 --steps 2 --out sized.ply --quiet
same half.ply sized.ply
runs spoilt.ply $photos --turn z180 --steps 1 --out turned.ply --quiet

# --- what it refuses --------------------------------------------------------------------------------
refuses 'no map is named'
refuses 'no cameras are named' spoilt.ply
refuses 'no photographs are named' spoilt.ply --cameras colmap/sparse/0
refuses 'there is no option' spoilt.ply $photos --step 3
refuses 'has no value' spoilt.ply $photos --steps
refuses 'from 1 to 100000000' spoilt.ply $photos --steps 0
refuses 'from 2 to 1000000' spoilt.ply $photos --every 1
refuses '^refine has no --antialias (' spoilt.ply $photos --antialias
refuses 'both given' spoilt.ply $photos --scale 2 --size 48x32
refuses 'by-kind or adam' spoilt.ply $photos --optimiser sgd
refuses 'three numbers' spoilt.ply $photos --background 1,1
refuses 'has no photograph of these cameras' spoilt.ply --cameras colmap/sparse/0 --photos colmap/sparse
refuses 'it is no directory' spoilt.ply --cameras colmap/sparse/0 --photos truth.ply
refuses 'there is no directory' spoilt.ply $photos --out nowhere/map.ply
mkdir other && cp colmap/images/*.png other && cp -r colmap/images/left other
"$render_map" truth.ply --size 40x30 --quiet --out small >log 2>&1 || fail "render_map: $(cat log)"
cp small/frame_0000.png other/c.png
refuses 'is no photograph of its camera (it has 40 x 30 pixels, the camera 96 x 64)' spoilt.ply --cameras colmap/sparse/0 --photos other
head -c 300 colmap/images/c.png >other/c.png
refuses 'c.png' spoilt.ply --cameras colmap/sparse/0 --photos other
# No output takes the place of an input, by any name.
ln -s spoilt.ply link.ply
ln spoilt.ply hard.ply
for out in spoilt.ply ./colmap/../spoilt.ply link.ply hard.ply colmap/sparse/0/images.txt colmap/images/d.png colmap/images/left/a.png; do
    refuses 'the map' spoilt.ply $photos --steps 1 --out "$out"
    refuses 'the report' spoilt.ply $photos --steps 1 --out new.ply --report "$out"
done
refuses 'the report' spoilt.ply $photos --steps 1 --out new.ply --report ./new.ply
[ ! -e new.ply ] || fail "a refused run wrote a map"
rm link.ply hard.ply
cat truth.ply spoilt.ply colmap/sparse/0/*.txt colmap/images/*.png colmap/images/left/a.png | cmp -s - inputs || fail "an input has changed"

# --- signals, and a full standard output ---------------------------------------------------------------
for signal in INT:130 TERM:143; do
    name=${signal%:*}
    if ! env --default-signal="$name" true 2>/dev/null; then
        skip "env cannot give SIG$name back"
        continue
    fi
    rm -f cut.ply
    env --default-signal="$name" "$program" spoilt.ply $photos --steps 10000000 --out cut.ply --report cut.json \
        </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until grep -q Gaussians stdout || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s "$name" $pid
    wait $pid
    equal "the status after SIG$name" $? "${signal#*:}"
    has stderr "^interrupted after step [0-9]* of 10000000 (SIG$name); cut.ply has the map so far, start again for the rest$"
    equal "the steps" "$(sed -nE 's/.*"steps": ([0-9]+).*/\1/p' cut.json)" "$(sed -nE 's/^interrupted after step ([0-9]+) .*/\1/p' stderr)"
    "$render_map" cut.ply --cameras colmap/sparse/0 --camera b.png --quiet --out shown >log 2>&1 ||
        fail "the map after a signal: $(cat log)"
done
if [ -w /dev/full ]; then
    rm -f map2.ply
    run spoilt.ply $photos --every 4 --steps 90 --out map2.ply >/dev/full 2>stderr
    is_refusal $? 'cannot write to standard output'
    same map.ply map2.ply
fi
has_no_parts .
finish

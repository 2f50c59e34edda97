#!/bin/sh
# What slam promises: from no map, a short sequence of the built-in map is tracked and mapped; the report, the map and the trajectories
# agree; threads and a second run change no byte; pictures as files work as well; a map to start from is extended; a run that loses every
# frame has status 1; no output takes the place of an input; after a signal, an unreadable picture and a full standard output, all files
# are whole; a run that was stopped goes on to the same bytes, and no other run goes on from its state; and bad input is one line and
# status 2.
# Usage: sh slam.sh PATH_TO_slam PATH_TO_track_camera
case $2 in /*) track_camera=$2 ;; *) track_camera=$PWD/$2 ;; esac
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# --- the command line --------------------------------------------------------------------------
runs --help
for option in --photos --render --map --turn --sh-degree --antialias --from --look --up --fov --ignore-distortion --list --cameras --camera --trajectory --trajectory-format --relative --near --depth-scale --frames --every \
    --size --noise --shutter --gain-drift --method --keyframe-every --open --steps --finish --optimiser --cell --threads --report --page --out --resume --quiet; do
    has stdout "^  $option "
done

# --- from no map, and the same bytes ------------------------------------------------------------
# value FILE MEMBER: of the report's summary.
value() { sed -nE "s/.*\"summary\": .*\"$2\": \"?([0-9a-fA-Z.e+-]+)\"?[,}].*/\\1/p" "$1"; }
short="--frames 12 --size 96x54"
# shellcheck disable=SC2086 # $short is several words
runs $short --out first --report first.json --page first.html
is_json first.json
equal "frames that were lost" "$(value first.json frames_lost)" 0
equal "frames" "$(grep -c '"status":' first.json)" 12
equal "keyframes" "$(grep -c '"open_share":' first.json)" "$(value first.json keyframes)"
awk -v k="$(value first.json keyframes)" -v p="$(value first.json psnr_db)" -v a="$(value first.json ate_rmse)" -v s="$(value first.json median_depth)" \
    'BEGIN { exit !(k >= 3 && k <= 6 && p > 25 && a > 0 && a < 0.02 * s) }' || fail "the summary: $(grep summary first.json)"
equal "frames that were compared" "$(value first.json frames_compared)" $((12 - $(value first.json keyframes)))
equal "Gaussians" "$(grep -a -m 1 '^element vertex' first/map.ply)" "element vertex $(value first.json gaussians)"
for file in estimated truth; do equal "poses of $file" "$(grep -c -v '^#' first/$file.tum)" 12; done
has stdout '^frame 0: converged, 0 evaluations, [0-9.]* ms, off by 0 degrees and 0 world units, keyframe: 1296 new, 0 removed, 1296 Gaussians$'
has stdout '^12 frames, 0 lost, [0-9]* keyframes, [0-9]* Gaussians; [0-9.]* dB in [0-9]* other frames; [0-9.]* ms a frame$'
paste first/truth.tum first/estimated.tum | awk '/^#/ { next } { s += ($2 - $10) ^ 2 + ($3 - $11) ^ 2 + ($4 - $12) ^ 2; ++n } END { print sqrt(s / n) }' >ate
awk -v a="$(value first.json ate_rmse)" '{ exit !($1 - a < 1e-4 * a && a - $1 < 1e-4 * a) }' ate || fail "the trajectories have the ATE $(cat ate)"
if command -v sha256sum >/dev/null; then
    equal "the map's hash" "$(value first.json map_sha256)" "$(sha256sum <first/map.ply | cut -d' ' -f1)"
else
    skip "sha256sum is absent, so nobody else computes the hash"
fi
equal "pictures of the page" "$(grep -o 'data:image/png;base64' first.html | wc -l)" 3
has first.html 'after frame 0'
has first.html 'after frame 11'
has first.html '</svg>'
for threads in 1 2 3; do
    # shellcheck disable=SC2086
    runs $short --out again --threads $threads --report again.json --quiet
    [ ! -s stdout ] || fail "--quiet prints"
    for file in map.ply estimated.tum truth.tum; do same first/$file again/$file; done
    equal "the hash with $threads threads" "$(value again.json map_sha256)" "$(value first.json map_sha256)"
done
for other in "--optimiser by-kind" "--steps 12" "--finish 0" "--cell 3" "--method hybrid" "--noise 0" "--keyframe-every 3" "--gain-drift 0"; do
    # shellcheck disable=SC2086
    runs $short --frames 8 --out other --quiet $other --report other.json
    equal "frames lost with $other" "$(value other.json frames_lost)" 0
    cmp -s first/map.ply other/map.ply && fail "$other changes nothing"
done

# --- pictures as files ----------------------------------------------------------------------------
{
    printf 'ply\nformat ascii 1.0\nelement vertex 600\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    echo end_header
    awk 'BEGIN { for (i = 0; i < 600; ++i) print (i % 30 - 14.5) * 0.2, (int(i / 30) - 9.5) * 0.2, 2.4 + 0.2 * (i * 37 % 3),
        (i * 29 % 17) / 6 - 1.4, (i * 13 % 19) / 7 - 1.4, (i * 7 % 11) / 4 - 1.4, 4, -2.2, -2.2, -2.2, 1, 0, 0, 0 }'
} >wall.ply
printf '{"cameras": [{"scene": "wall", "name": "a", "width": 96, "height": 64, "fx": 80, "fy": 80, "cx": 48, "cy": 32,
    "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}\n' >cameras.json
"$track_camera" wall.ply --cameras cameras.json --camera a --size 96x64 --noise 0 --frames 8 --method forward --save-photos seen --out seen \
    --quiet >log 2>&1 || fail "track_camera: $(cat log)"
rm -f seen/estimated.tum seen/truth.tum seen/paths.svg seen/residual.ppm
lens="--cameras cameras.json --camera wall/a"
# shellcheck disable=SC2086
runs --photos seen $lens --trajectory seen/groundtruth.txt --out photos --report photos.json
equal "frames lost of files" "$(value photos.json frames_lost)" 0
awk -v p="$(value photos.json psnr_db)" -v a="$(value photos.json ate_rmse)" -v s="$(value photos.json median_depth)" \
    'BEGIN { exit !(p > 22 && a > 0 && a < 0.03 * s && s > 2.3 && s < 2.9) }' || fail "the summary of files: $(grep summary photos.json)"
# shellcheck disable=SC2086
runs --photos seen/associations.txt $lens --out unknown --report unknown.json # no truth
[ ! -e unknown/truth.tum ] || fail "a truth that nobody knows is written"
equal "an unknown ATE" "$(value unknown.json ate_rmse)" ""
# The same views, rendered by this program.
# shellcheck disable=SC2086
runs --render wall.ply $lens --size 96x64 --noise 0 --frames 8 --out rendered --report rendered.json
awk -v a="$(value photos.json median_depth)" -v b="$(value rendered.json median_depth)" 'BEGIN { exit !(a - b < 0.01 && b - a < 0.01) }' ||
    fail "files and views have different depths"
# A map to start from is tracked from the first frame on, and needs few new Gaussians.
# shellcheck disable=SC2086
runs --render wall.ply --map wall.ply $lens --size 96x64 --noise 0 --frames 6 --steps 0 --finish 0 --out extended --report extended.json
awk -v n="$(value extended.json gaussians)" -v a="$(value extended.json ate_rmse)" 'BEGIN { exit !(n > 560 && n < 700 && a < 0.06) }' ||
    fail "the map that was extended: $(grep summary extended.json)"
# Half of the files: the others are damaged, and the map of those before is written.
cp -R seen cut
head -c 300 seen/rgb/000005.png >cut/rgb/000005.png
# shellcheck disable=SC2086
run --photos cut $lens --out before --report before.json --quiet >stdout 2>stderr
is_refusal $? '000005.png'
equal "poses before a damaged picture" "$(grep -c -v '^#' before/estimated.tum)" 5
is_json before.json
sed 's/ depth.*//; s/ [0-9.]*$//' seen/associations.txt >seen/flat.txt
# shellcheck disable=SC2086
refuses 'the first picture has no known depth' --photos seen/flat.txt $lens --out flat

# --- lost frames ----------------------------------------------------------------------------------
# The second picture is of another scene: a white ball in the dark.
{
    sed -n '1,/end_header/p' wall.ply | sed 's/vertex 600/vertex 1/'
    echo 0.6 0.2 1.2 1.7 1.7 1.7 6 -1.5 -1.5 -1.5 1 0 0 0
} >ball.ply
"$track_camera" ball.ply --cameras cameras.json --camera wall/a --size 96x64 --noise 0 --frames 1 --save-photos ball --out ball --quiet >log 2>&1 ||
    fail "track_camera: $(cat log)"
{
    grep -v '^#' seen/associations.txt | head -n 1 | sed 's, \([rd]\), seen/\1,g'
    echo 0.1 ball/rgb/000000.png 0.1 ball/depth/000000.png
} >two.txt
# shellcheck disable=SC2086
run --photos two.txt $lens --out lost --quiet >stdout 2>stderr
equal "the status of a run that lost all" $? 1
has stderr '^the only frame that was tracked is lost (the first: .*); take pictures that are closer together$'
[ -s lost/map.ply ] || fail "a run that lost all wrote no map"

# --- what it refuses --------------------------------------------------------------------------------
: >empty.tum
echo '999 0 0 0 0 0 0 1' >late.tum
printf 'no map\n' >map.ply
: >file
refuses 'there is no option' --no-such-option
refuses 'is no option (slam takes no word without one)' wall.ply
refuses 'from 1 to 1000000' --frames 0
refuses 'has no value' --frames
refuses 'a width and a height' --size big
refuses 'from 0 to 1' --noise 2
refuses 'from 0 to 0.9' --gain-drift 1
refuses 'from 0 to 1' --open nan
refuses 'from 1 to 64' --cell 0
refuses 'adam or by-kind' --optimiser sgd
refuses 'hybrid or forward' --method esm
refuses 'exclude each other' --photos seen --render wall.ply
refuses 'needs the camera' --photos seen
refuses 'for rendered pictures' --photos seen --cameras cameras.json --size 96x64
refuses 'without --cameras' --camera a
refuses 'without --trajectory' --relative
refuses '^slam has no --antialias (' --antialias
refuses 'nowhere.ply' --render nowhere.ply
refuses 'map.ply' --map map.ply
refuses 'empty.tum' --trajectory empty.tum
refuses 'nowhere' --photos nowhere --cameras cameras.json
refuses 'is not the path of these pictures' --photos seen --cameras cameras.json --camera wall/a --trajectory late.tum --out o
refuses 'file' --frames 1 --out file
refuses 'nowhere' --frames 1 --out one --report nowhere/report.json
# No output takes the place of an input, by any name.
mkdir in
cp wall.ply cameras.json seen/groundtruth.txt in
cat in/* >inputs
words="--render in/wall.ply --cameras in/cameras.json --camera wall/a --trajectory in/groundtruth.txt --size 96x64 --frames 1 --quiet"
for input in wall.ply cameras.json groundtruth.txt; do
    for output in map.ply estimated.tum truth.tum report; do
        for way in link hard_link; do
            mkdir -p clash
            if [ $way = link ]; then ln -s "$work/in/$input" clash/$output; else ln in/$input clash/$output; fi
            # shellcheck disable=SC2086
            refuses 'this run reads that file' $words --out clash --report clash/report
            rm -r clash
        done
    done
    # shellcheck disable=SC2086
    refuses 'this run reads that file' $words --out o --report in/../in/$input
    # shellcheck disable=SC2086
    refuses 'this run reads that file' $words --out o --page ./in/$input
done
# shellcheck disable=SC2086
refuses 'has that name\|is the file of' $words --out o --report o/map.ply
# shellcheck disable=SC2086
refuses 'has that name\|is the file of' $words --out o --report o.json --page o.json
cp in/wall.ply map_before.ply && mkdir start && cp wall.ply start/map.ply
refuses 'this run reads that file' --map start/map.ply --frames 1 --out start
same start/map.ply wall.ply
cat in/* | cmp -s - inputs || fail "an input has changed"

# --- signals ---------------------------------------------------------------------------------------------
for signal in INT:130 TERM:143; do
    name=${signal%:*}
    if ! env --default-signal="$name" true 2>/dev/null; then
        skip "env cannot give SIG$name back"
        continue
    fi
    : >stdout # that of the run before has frames, too
    env --default-signal="$name" "$program" --size 96x54 --frames 100000 --out "SIG$name" --report "SIG$name.json" </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until grep -q '^frame 2:' stdout || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s "$name" $pid
    wait $pid
    equal "the status after SIG$name" $? "${signal#*:}"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line after SIG$name: $(cat stderr)"
    has stderr "^interrupted after frame [0-9]* of 100000 (SIG$name); SIG$name/map.ply has the map of these frames, start again for the rest$"
    frames=$(sed -n 's/^interrupted after frame \([0-9]*\) .*/\1/p' stderr)
    equal "the poses after SIG$name" "$(grep -c -v '^#' "SIG$name/estimated.tum")" "$frames"
    is_json "SIG$name.json"
    equal "the frames of the report after SIG$name" "$(grep -c '"status":' "SIG$name.json")" "$frames"
    has_no_parts "SIG$name"
done

# --- a run that goes on ----------------------------------------------------------------------------------
# untimed FILE: a report without its times.
untimed() { sed -E 's/"(host_ms|keyframe_host_ms|host_ms_per_frame)": [0-9.e+-]+/"\1"/g' "$1" >"$1.untimed"; }
# as_straight FOLDER: the run that was stopped and went on has the results of the straight run in first/.
as_straight() {
    for file in map.ply estimated.tum truth.tum; do same first/$file "$1/$file"; done
    untimed "$1.json"
    same first.json.untimed "$1.json.untimed"
    has_no_parts "$1"
}
# begins_anew PATTERN ARGUMENTS...: status 0, the pattern in one line on standard error, and the checkpoint of before is kept.
begins_anew() {
    pattern=$1
    shift
    cp going/checkpoint.bin before.bin
    run "$@" --resume --out going --quiet >stdout 2>stderr || fail "status $? of: $*"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line: $*: $(cat stderr)"
    has stderr "^going/checkpoint.bin $pattern; the run begins anew, and checkpoint.bin.old keeps that file$"
    same before.bin going/checkpoint.bin.old
}
untimed first.json
[ ! -e first/checkpoint.bin ] || fail "a run without --resume keeps its state"
for signal in TERM KILL; do
    status=0
    tries=0
    while [ $status -eq 0 ] && [ $tries -lt 5 ]; do # the signal may come too late
        rm -rf going going.json
        : >stdout # that of the run before has frames, too
        # shellcheck disable=SC2086
        "$program" $short --resume --out going --report going.json --page going.html </dev/null >stdout 2>stderr &
        pid=$!
        waits=0
        until grep -q '^frame 1:' stdout || [ $waits -eq 3000 ] || ! kill -0 $pid 2>/dev/null; do
            sleep 0.02
            waits=$((waits + 1))
        done
        kill -s $signal $pid 2>/dev/null
        wait $pid 2>/dev/null
        status=$?
        tries=$((tries + 1))
    done
    [ $status -gt 128 ] || fail "the status after SIG$signal is $status"
    [ $signal = KILL ] || has stderr '^interrupted after .*; going/map.ply has the map of these frames, the same command goes on from there$'
    rm -f going/*.part going/*.ply
    # shellcheck disable=SC2086
    runs $short --resume --out going --report going.json --page going.html --threads 2
    has stdout '^going on after frame [0-9]*$'
    grep -q '^frame 0:' stdout && fail "a frame of the run that was stopped is mapped again"
    as_straight going
    same first.html going.html
done
# A finished run goes on from its last keyframe. Damage is seen.
# shellcheck disable=SC2086
runs $short --resume --out going --report going.json --page going.html --quiet
as_straight going
size=$(wc -c <going/checkpoint.bin)
printf '\125' | dd of=going/checkpoint.bin bs=1 seek=$((size / 2)) conv=notrunc 2>/dev/null
# shellcheck disable=SC2086
begins_anew 'is damaged (its digest is of other bytes)' $short --report going.json --page going.html
as_straight going
head -c $((size / 2)) going/checkpoint.bin >cut.bin && mv cut.bin going/checkpoint.bin
quick="--frames 1 --steps 0 --finish 0 --size 96x54"
# shellcheck disable=SC2086
begins_anew 'is damaged (its digest is of other bytes)' $quick
# shellcheck disable=SC2086
begins_anew 'is of another run (its options or the files that it read are others)' $quick --cell 3
# shellcheck disable=SC2086
runs $quick --cell 3 --resume --out going --finish 1 --threads 2 # these change no state
has stdout '^going on after frame 0$'
sed '1s/checkpoint 1/checkpoint 0/' going/checkpoint.bin >other.bin && mv other.bin going/checkpoint.bin
# shellcheck disable=SC2086
begins_anew 'is not of this version (its first line is another)' $quick --cell 3
# Pictures as files: more frames go on from less.
rm -r going
# shellcheck disable=SC2086
runs --photos seen $lens --trajectory seen/groundtruth.txt --frames 7 --resume --out going --quiet
# shellcheck disable=SC2086
runs --photos seen $lens --trajectory seen/groundtruth.txt --resume --out going --report going.json
has stdout '^going on after frame [1-6]$'
for file in map.ply estimated.tum truth.tum; do same photos/$file going/$file; done
untimed photos.json
untimed going.json
same photos.json.untimed going.json.untimed
# shellcheck disable=SC2086
begins_anew 'has more frames than --frames allows ([2-7])' --photos seen $lens --trajectory seen/groundtruth.txt --frames 1
cp cameras.json cameras_before.json && echo >>cameras.json
# shellcheck disable=SC2086
begins_anew 'is of another run (its options or the files that it read are others)' --photos seen $lens --trajectory seen/groundtruth.txt --frames 1
mv cameras_before.json cameras.json
mkdir -p taken/checkpoint.bin clash
# shellcheck disable=SC2086
refuses 'checkpoint.bin' $quick --resume --out taken
ln in/wall.ply clash/checkpoint.bin
# shellcheck disable=SC2086
refuses 'this run reads that file' $words --resume --out clash
cat in/* | cmp -s - inputs || fail "an input has changed"

# --- a full standard output, and a full disk ---------------------------------------------------------------
if [ -w /dev/full ]; then
    # shellcheck disable=SC2086
    run $short --out full >/dev/full 2>stderr
    is_refusal $? 'cannot write to standard output'
    same first/map.ply full/map.ply
fi
# A file of more than 8 KiB cannot be written: the map cannot, and no part of it stays.
# shellcheck disable=SC2086
(ulimit -f 16 && run $short --frames 1 --out limited --quiet) >stdout 2>stderr
is_refusal $? 'map.ply (File too large)'
has_no_parts limited
finish

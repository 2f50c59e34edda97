#!/bin/sh
# What track_camera promises: a short spoilt sequence on the built-in map is tracked, its report and its trajectories say so; the same
# pictures as PNG files are tracked as well; a bad picture costs no frame before it; a run that loses every frame has status 1; no output
# takes the place of an input; a signal or a full disk leaves whole files; and bad input is one line and status 2.
# Usage: sh track_camera.sh PATH_TO_track_camera
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

size=640x480

# --- the command line --------------------------------------------------------------------------
runs --help
for option in --turn --sh-degree --antialias --from --look --up --fov --ignore-distortion --list --gain-drift --trajectory --relative --cameras --camera --frames --size --noise --method --threads --report --out --quiet --photos --depth-scale --save-photos --one-in; do
    has stdout "^  $option "
done

# --- a short sequence --------------------------------------------------------------------------
runs --size $size --frames 3 --method forward --out tracked --report report.json
[ "$(grep -c '^frame [0-9]*: ' stdout)" -eq 3 ] || fail "not a line for each of 3 frames: $(cat stdout)"
has stdout "0 lost"
is_json report.json
for key in frames status iterations host_ms rotation_error_deg translation_error summary ate_rmse frames_lost host_ms_per_frame; do
    has report.json "\"$key\":"
done
for file in estimated.tum truth.tum paths.svg; do
    [ -s "tracked/$file" ] || fail "tracked/$file is missing"
done
has tracked/paths.svg "<svg"
for file in estimated.tum truth.tum; do # seconds, position, quaternion of length 1
    awk '/^#/ { next } { ++n; if (NF != 8) bad = 1; q = $5 * $5 + $6 * $6 + $7 * $7 + $8 * $8; if (q < 0.999 || q > 1.001) bad = 1 }
        END { exit bad || n != 3 }' "tracked/$file" || fail "tracked/$file does not have 3 poses: $(cat "tracked/$file")"
done
# The estimates are near the truth, and the report's error is that of the files.
paste tracked/truth.tum tracked/estimated.tum | awk '/^#/ { next } { d = ($2 - $10) ^ 2 + ($3 - $11) ^ 2 + ($4 - $12) ^ 2; s += d; ++n }
    END { printf "%.9f\n", sqrt(s / n) }' >rmse
if have_python; then
    python3 - <<'END' || fail "the report is not what the sequence was"
import json
report = json.load(open("report.json"))
frames, summary = report["frames"], report["summary"]
assert len(frames) == 3, frames
for f in frames:
    assert f["status"] == "converged", f
    assert f["iterations"] >= 3 and f["host_ms"] > 0, f
    assert f["why"] == "" and f["tried_again"] is False, f
    assert 0 <= f["rotation_error_deg"] < 0.02 and 0 <= f["translation_error"] < 0.01, f
assert summary["frames_lost"] == 0 and summary["host_ms_per_frame"] > 0, summary
rmse = float(open("rmse").read())
assert 0 < rmse < 0.01, rmse
assert abs(summary["ate_rmse"] - rmse) < 1e-6, (summary["ate_rmse"], rmse)
moved = [l.split() for l in open("tracked/truth.tum") if l[0] != "#"]
assert moved[0][1:] != moved[2][1:], "the camera stands still"
END
else
    skip "python3 is absent, so nobody reads the report's numbers"
fi

# A recorded trajectory, relative to the first pose; the same poses with other threads, in every byte.
printf '0 0 0 0 0 0 0 1\n0.1 0.01 0 0.01 0 0.004 0 0.99999200\n' >walk.tum
runs --size $size --trajectory walk.tum --relative --method gradient --noise 0 --out one --report one.json --quiet
[ ! -s stdout ] || fail "--quiet is not quiet"
runs --size $size --trajectory walk.tum --relative --method gradient --noise 0 --out two --threads 2 --quiet
same one/estimated.tum two/estimated.tum
[ "$(grep -c -v '^#' one/estimated.tum)" -eq 2 ] || fail "not two poses"

# --- pictures from files -----------------------------------------------------------------------
# distance A B: the largest distance between the poses of two trajectories.
distance() {
    paste "$1" "$2" | awk '/^#/ { next } { d = sqrt(($2 - $10) ^ 2 + ($3 - $11) ^ 2 + ($4 - $12) ^ 2); if (d > m) m = d; ++n }
        END { printf "%.9f %d\n", m, n }'
}
runs --size 320x240 --frames 3 --method forward --out rendered --save-photos seen --quiet
[ "$(find seen -name '*.png' | wc -l)" -eq 6 ] || fail "--save-photos did not write 3 pictures and 3 depths: $(find seen)"
same seen/groundtruth.txt rendered/truth.tum
runs --photos seen --trajectory seen/groundtruth.txt --method forward --out photos --report photos.json
has stdout "^3 frames, 0 lost"
distance photos/truth.tum rendered/truth.tum >apart
awk '{ exit !($2 == 3 && $1 < 1e-6) }' apart || fail "the truth of pictures from files is another: $(cat apart)"
# Colours are the same 8 bits; depths and time stamps are rounded. So the poses differ by far less than their errors.
distance photos/estimated.tum rendered/estimated.tum >apart
awk '{ exit !($2 == 3 && $1 < 2e-4) }' apart || fail "tracked from files, poses are elsewhere: $(cat apart)"
# The two lists of the benchmark in place of its associations; without depths; without the truth, from the camera's own pose.
cp -R seen lists
awk '/^#/ { next } { print $1, $2 >"lists/rgb.txt"; print $3, $4 >"lists/depth.txt" }' lists/associations.txt
rm lists/associations.txt
runs --photos lists --trajectory lists/groundtruth.txt --method forward --out from_lists --quiet
same from_lists/estimated.tum photos/estimated.tum
runs --photos seen/associations.txt --frames 2 --no-depth --method forward --out blind
has stdout "^2 frames, 0 lost"
[ ! -e blind/truth.tum ] || fail "a truth of pictures without one"

# A picture that cannot be read is one line; the frames before it are there.
# spoilt NAME PATTERN: the folder NAME has a bad third frame.
spoilt() {
    run --photos "$1" --trajectory seen/groundtruth.txt --method forward --out "$1.out" --report "$1.json" >stdout 2>stderr
    is_refusal $? "$2"
    [ "$(grep -c '^frame [0-9]*: converged' stdout)" -eq 2 ] || fail "$1: the frames before were not tracked: $(cat stdout)"
    [ "$(grep -c -v '^#' "$1.out/estimated.tum")" -eq 2 ] || fail "$1: the frames before are not in the trajectory"
    is_json "$1.json"
    [ "$(grep -c '"status": "converged"' "$1.json")" -eq 2 ] || fail "$1: the frames before are not in the report"
    has_no_parts "$1.out"
}
for bad in cut cut_depth small gone grey; do cp -R seen $bad; done
head -c 20000 seen/rgb/000002.png >cut/rgb/000002.png
spoilt cut "000002.png"
head -c 20000 seen/depth/000002.png >cut_depth/depth/000002.png
spoilt cut_depth "depth/000002.png"
# On the built-in map in 160 x 120, every frame is lost: the run says so, also with --quiet. It writes its files all the same.
run --size 160x120 --frames 1 --save-photos half --out half.out --quiet >stdout 2>stderr
equal "the status of a run that lost its only frame" $? 1
has stderr '^the only frame is lost (the first: [0-9]* splats without room.*); choose larger pictures'
run --size 160x120 --frames 3 --out half.out >stdout 2>stderr
equal "the status of a run that lost every frame" $? 1
has stderr '^all 3 frames are lost (the first: [0-9]* splats without room.*); choose larger pictures'
[ "$(wc -l <stderr)" -eq 1 ] || fail "not one line of a run that lost every frame: $(cat stderr)"
has stdout '^3 frames, 3 lost'
[ "$(grep -c -v '^#' half.out/estimated.tum)" -eq 3 ] || fail "lost frames are not in the trajectory"
cp half/rgb/000000.png small/rgb/000002.png
spoilt small "rgb/000002.png"
rm gone/rgb/000002.png
spoilt gone "rgb/000002.png"
cp seen/rgb/000002.png grey/depth/000002.png
spoilt grey "depth/000002.png"

# --- notes, maps far from 0 --------------------------------------------------------------------
# A picture and its depth that are far apart are noted, with the name of the list; also rows that the trajectory's reader leaves out.
awk '/^#/ { print; next } { if (++n == 2) $3 = "98.532258"; print }' seen/associations.txt >seen/apart.txt
{
    cat seen/groundtruth.txt
    echo '9 nan 0 0 0 0 0 1'
} >left_out.tum
runs --photos seen/apart.txt --trajectory left_out.tum --frames 1 --method forward --out noted
has stdout '^note: apart.txt: pictures whose depth is more than 0.02 s away: 1, the furthest is 98.5 s away, of the picture at 0.032258$'
has stdout '^note: left_out.tum: .*left out'
runs --photos seen/apart.txt --frames 1 --method forward --out noted --quiet
[ ! -s stdout ] || fail "--quiet prints notes: $(cat stdout)"
runs --photos seen --frames 1 --method forward --out noted
if grep -q '^note' stdout; then fail "a note about a usual sequence: $(cat stdout)"; fi

# A georeferenced map: its origin is subtracted from it, from the camera and from the trajectory, and added to what is written. So the poses
# are those of the same map at 0, moved.
# ball_map X Y: 1,500 Gaussians around (X, Y, 4), in double.
ball_map() {
    printf 'ply\nformat ascii 1.0\nelement vertex 1500\n'
    printf 'property double %s\n' x y z
    printf 'property float %s\n' f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    echo end_header
    awk -v x="$1" -v y="$2" 'function next_random() { s = (s * 16807) % 2147483647; return s / 2147483647 }
        BEGIN { s = 7; for (i = 0; i < 1500; i++) printf "%.6f %.6f %.6f %.3f %.3f %.3f 3 -2.4 -2.4 -2.4 1 0 0 0\n", x + 4 * next_random() - 2,
            y + 3 * next_random() - 1.5, 3 + 2 * next_random(), 3 * next_random() - 1.5, 3 * next_random() - 1.5, 3 * next_random() - 1.5 }'
}
# camera_at X Y
camera_at() {
    printf '{"cameras": [{"scene": "any", "name": "a", "width": 320, "height": 240, "fx": 300, "fy": 300, "cx": 160, "cy": 120,
        "world_to_camera": [[1, 0, 0, %d], [0, 1, 0, %d], [0, 0, 1, 0], [0, 0, 0, 1]]}]}\n' "-$1" "-$2"
}
# walk_at X Y
walk_at() { awk -v x="$1" -v y="$2" 'BEGIN { for (i = 0; i < 3; i++) printf "%.1f %.6f %.6f %.6f 0 %.6f 0 1\n", i / 10, x + i / 100, y - i / 200, i / 300, i / 500 }'; }
ball_map 0 0 >at_0.ply
ball_map 500000 5000000 >georeferenced.ply
camera_at 0 0 >at_0.json
camera_at 500000 5000000 >georeferenced.json
walk_at 0 0 >at_0.tum
walk_at 500000 5000000 >georeferenced.tum
georeferenced="--noise 0 --method forward --frames 3"
# shellcheck disable=SC2086
{
    runs at_0.ply $georeferenced --cameras at_0.json --camera a --size 320x240 --trajectory at_0.tum --out at_0
    has stdout '^3 frames, 0 lost'
    if grep -q '^note' stdout; then fail "a note about a map at 0: $(cat stdout)"; fi
    runs georeferenced.ply $georeferenced --cameras georeferenced.json --camera a --size 320x240 --trajectory georeferenced.tum --out georeferenced --save-photos far_seen
    has stdout '^note: .*the origin 500000, 5000000, [0-9]* is subtracted'
    has stdout '^3 frames, 0 lost'
    for file in estimated.tum truth.tum; do
        awk '/^#/ { print; next } { $2 -= 500000; $3 -= 5000000; print }' CONVFMT=%.9f OFMT=%.9f georeferenced/$file >moved.tum
        distance at_0/$file moved.tum >apart
        awk '{ exit !($2 == 3 && $1 < 2e-5) }' apart || fail "the $file of a map far from 0 is elsewhere: $(cat apart)"
    done
    # Its pictures as files, with the truth in the coordinates of the map's file; --relative starts at the camera.
    runs georeferenced.ply --method forward --cameras georeferenced.json --camera a --photos far_seen --trajectory far_seen/groundtruth.txt --out far_photos
    has stdout '^3 frames, 0 lost'
    runs georeferenced.ply $georeferenced --cameras georeferenced.json --camera a --size 320x240 --trajectory walk.tum --relative --out relative
    has stdout '^2 frames, 0 lost'
    awk '$1 == "0" { found = $2 == 500000 && $3 == 5000000 && $4 == 0 } END { exit !found }' relative/truth.tum || fail "--relative does not start at the camera: $(cat relative/truth.tum)"
}

# --- one block in many -------------------------------------------------------------------------
# With no block at all every frame is lost; with all of them it is found.
runs --size 320x240 --frames 2 --one-in 1000000 --method forward --out few --report few.json
[ "$(grep -c 'converged, tried again with all blocks' stdout)" -eq 2 ] || fail "frames were not tried again: $(cat stdout)"
has stdout "^2 frames, 0 lost, 2 tried again"
has few.json '"tried_again": true'

# --- bad input ---------------------------------------------------------------------------------
: >empty.tum
printf 'three words here\n' >words.tum
printf 'no map\n' >map.ply
: >file
refuses "no-such-option" --no-such-option
refuses "^track_camera has no --antialias (" --antialias
refuses "frames" --frames 0
refuses "frames" --frames
refuses "size" --size 0x90
refuses "size" --size 70000x90
refuses "size" --size big
refuses "noise" --noise -1
refuses "noise" --noise nan
refuses "method" --method newton
refuses "threads" --threads 0
refuses "cameras" --camera front
refuses "nowhere.ply" nowhere.ply
refuses "map.ply" map.ply
refuses "nowhere.tum" --trajectory nowhere.tum
refuses "empty.tum" --trajectory empty.tum
refuses "words.tum" --trajectory words.tum
refuses "nowhere.json" --cameras nowhere.json
refuses "second map\|no such option" map.ply map.ply
# What cannot be written is refused before the first frame, and nothing of an older run is lost.
refuses "file" --size $size --frames 1 --out file/below
refuses "file" --size $size --frames 1 --out file
refuses "nowhere" --size $size --frames 1 --out one --report nowhere/report.json
refuses "one" --size $size --frames 1 --out one --report one
mkdir taken taken/estimated.tum locked
refuses "estimated.tum" --size $size --frames 1 --out taken
refuses "file" --size $size --frames 1 --out one --save-photos file
same one/estimated.tum two/estimated.tum
has_no_parts one
chmod 500 locked
if [ -w locked ]; then
    skip "this user may write everywhere, so no folder is locked"
else
    refuses "locked" --size $size --frames 1 --out locked
    refuses "locked" --size $size --frames 1 --out one --report locked/report.json
    refuses "locked" --size $size --frames 1 --out one --save-photos locked
fi

# Printed numbers have three digits and a unit.
runs --size 320x240 --frames 1 --method forward --out one
has stdout '^frame 0: converged, [0-9]* evaluations, [0-9.]* ms, off by [0-9.e-]* degrees and [0-9.e-]* world units$'
has stdout '^ATE [0-9.e-]* world units (aligned [0-9.e-]*; [0-9.e-]* of the median depth), [0-9.e-]* degrees; RPE [0-9.e-]* world units and [0-9.e-]* degrees a frame$'
if sed 's/e-[0-9]*//g' stdout | grep -q '[1-9][0-9.]*[0-9][0-9.]*[0-9][0-9.]*[0-9][0-9]*\.[0-9]\|\.0*[1-9][0-9][0-9][0-9]'; then fail "a number with more than three digits: $(cat stdout)"; fi

# --- no output takes the place of an input -----------------------------------------------------
# All kinds of inputs: a map, two kinds of camera files, a trajectory, an association file, two lists, a picture and a depth.
mkdir in in/model
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n'
} >in/map.ply
printf '{"cameras": [{"scene": "map", "name": "a", "width": 320, "height": 240, "fx": 300, "fy": 300, "cx": 160, "cy": 120,
    "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}\n' >in/cameras.json
printf '1 PINHOLE 320 240 300 300 160 120\n' >in/model/cameras.txt
mkdir in/blender # a file without sizes: the picture beside it says them
printf '{"camera_angle_x": 1, "frames": [{"file_path": "a", "transform_matrix": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}]}\n' >in/blender/transforms.json
cp seen/rgb/000000.png in/blender/a.png
runs in/map.ply --cameras in/blender/transforms.json --size 320x240 --frames 1 --out blender
rm in/blender/a.png # without it, --size says them
runs in/map.ply --cameras in/blender/transforms.json --size 320x240 --frames 1 --out blender
cp seen/rgb/000000.png in/blender/a.png
printf '1 1 0 0 0 0 0 0 1 a\n\n' >in/model/images.txt
printf '0 0 0 0 0 0 0 1\n0.1 0.001 0 0 0 0 0 1\n' >in/walk.tum
cp -R seen in/seen
cp -R lists in/lists
cp -R in kept
inputs_are_kept() { diff -r in kept >differences || fail "an input has changed, of: $*: $(cat differences)"; }

# words KIND FILE: the words of a run that reads FILE as its KIND, in $words.
words() {
    map=in/map.ply cameras=in/cameras.json walk=in/walk.tum photos=
    case $1 in
    map) map=$2 ;;
    cameras) cameras=$2 ;;
    model | blender) cameras=$2 ;;
    trajectory) walk=$2 ;;
    *) photos=$2 ;;
    esac
    words="$map --cameras $cameras --camera a --trajectory $walk --threads 1 --quiet"
    if [ -n "$photos" ]; then words="$words --photos $photos"; else words="$words --size 320x240 --save-photos clash/saved"; fi
}
# keeps KIND FILE WHAT [ARGUMENTS...]: such a run is refused, and no file is another one afterwards.
keeps() {
    words "$1" "$2"
    what=$3
    shift 3
    find clash | sort >before
    # shellcheck disable=SC2086 # $words is several words
    refuses "this run reads that file" $words --out clash/out "$@"
    find clash | sort >after
    same before after
    inputs_are_kept "$words --out clash/out $* ($what)"
}
clashes=0
for input in map:in/map.ply cameras:in/cameras.json model:in/model/cameras.txt model:in/model/images.txt blender:in/blender/a.png trajectory:in/walk.tum \
    photos:in/seen/associations.txt photos:in/seen/rgb/000001.png photos:in/seen/depth/000001.png photos:in/lists/rgb.txt photos:in/lists/depth.txt; do
    kind=${input%%:*} file=${input#*:}
    case $file in
    in/seen/*) named=in/seen ;;
    in/lists/*) named=in/lists ;;
    in/model/*) named=in/model ;;
    in/blender/*) named=in/blender/transforms.json ;;
    *) named=$file ;;
    esac
    outputs="out/estimated.tum out/truth.tum out/paths.svg out/residual.ppm report.json"
    [ "$kind" = photos ] || outputs="$outputs saved/associations.txt saved/groundtruth.txt saved/rgb/000000.png saved/depth/000001.png"
    for output in $outputs; do
        case $output in report.json) report="--report clash/report.json" ;; *) report= ;; esac
        for way in link hard_link link_to_link folder; do
            mkdir -p clash/out clash/saved/rgb clash/saved/depth
            case $way in
            link) ln -s "$work/$file" "clash/$output" ;;
            hard_link) ln "$file" "clash/$output" ;;
            link_to_link) ln -s "$work/$file" clash/first && ln -s "$work/clash/first" "clash/$output" ;;
            folder) # the output's folder is a link to a folder with a hard link
                [ "$report" = "" ] || continue
                mkdir clash/elsewhere && ln "$file" "clash/elsewhere/$(basename "$output")"
                if [ "$output" = "out/$(basename "$output")" ]; then rm -r clash/out && ln -s elsewhere clash/out; else rm -r "clash/$(dirname "$output")" && ln -s "$work/clash/elsewhere" "clash/$(dirname "$output")" && mkdir -p clash/saved/rgb clash/saved/depth; fi
                ;;
            esac
            # shellcheck disable=SC2086 # $report is two words or none
            keeps "$kind" "$named" "$output, a $way" $report
            clashes=$((clashes + 1))
            rm -r clash
        done
    done
    # --report names the file itself, in four ways.
    mkdir -p clash/out clash/saved/rgb clash/saved/depth
    for report in "$file" "./$file" "in/../$file" "$work/$file"; do
        keeps "$kind" "$named" "the input itself" --report "$report"
        clashes=$((clashes + 1))
    done
    rm -r clash
done
# An input that lies where an output goes: a trajectory of an earlier run is the natural case.
for output in out/estimated.tum out/truth.tum out/paths.svg out/residual.ppm saved/associations.txt saved/groundtruth.txt saved/rgb/000000.png saved/depth/000001.png; do
    for kind in map:in/map.ply cameras:in/cameras.json trajectory:in/walk.tum; do
        for spelling in "clash/$output" "clash/../clash/$output" "$work/clash/$output"; do
            mkdir -p clash/out clash/saved/rgb clash/saved/depth
            cp "${kind#*:}" "clash/$output"
            keeps "${kind%%:*}" "$spelling" "$output, the input itself"
            same "${kind#*:}" "clash/$output"
            clashes=$((clashes + 1))
            rm -r clash
        done
    done
done
[ $clashes -ge 300 ] || fail "only $clashes pairs of inputs and outputs were tried"
# Two outputs are not one file either, and a stream goes to no file of the run.
mkdir one_file one_file/rgb
refuses "that is the file of\|a result of this run has that name" --size $size --frames 1 --out one_file --report one_file/truth.tum
ln -s rgb one_file/depth
refuses "its folders rgb and depth are one" --size $size --frames 1 --out one_file --save-photos one_file
(run in/map.ply --cameras in/cameras.json --trajectory in/walk.tum --size 320x240 --out one_file >>in/walk.tum) 2>stderr
is_refusal $? "standard output cannot go to in/walk.tum (this run reads that file)"
inputs_are_kept "a run that prints into its trajectory"

# --- names -------------------------------------------------------------------------------------
# Control characters, and bytes that are no UTF-8, reach no terminal.
for name in "$(printf 'two\nlines')" "$(printf 'escape\033[31m')" "$(printf 'latin\351')" "$(printf 'c1\302\233')" "$(printf 'surrogate\355\240\200')"; do
    for words in "--trajectory" "--cameras" "--photos" "--report nowhere/" "--frames" ""; do
        # shellcheck disable=SC2086
        refuses '?' ${words%nowhere/} "${words#"${words%nowhere/}"}$name"
        if tr -d '\n' <stderr | grep -q -a "$(printf '[\001-\037\177-\237\340-\377]')"; then fail "a byte of the name reaches the terminal: $(cat stderr)"; fi
    done
done
mkdir "$(printf 'caf\303\251')"
refuses "$(printf 'caf\303\251')" --trajectory "$(printf 'caf\303\251')/nowhere"
# A long name is shortened.
refuses '\.\.\.' --trajectory "$(head -c 3000 /dev/zero | tr '\0' a)"

# --- compressed maps ---------------------------------------------------------------------------
# One Gaussian as SPZ, a gzip stream: it is read, or a build without zlib says that it is one.
printf 'NGSP\002\000\000\000\001\000\000\000\000\014\000\000\000\000\000\000\000\000\000\320\377\346\200\377\000\240\240\240\200\200\200' | gzip -c >ball.spz
if grep -q 'inflate' "$program"; then
    run ball.spz --cameras in/cameras.json --camera a --size 320x240 --frames 1 --out ball --quiet >stdout 2>stderr
    if grep -q 'without zlib' stderr; then fail "an SPZ is refused although zlib is there: $(cat stderr)"; fi
    [ -s ball/estimated.tum ] || fail "an SPZ map is not tracked: $(cat stderr)"
else
    refuses 'zlib' ball.spz --cameras in/cameras.json
fi

# --- signals, full disks -----------------------------------------------------------------------
if [ -c /dev/full ]; then
    run --size 320x240 --frames 2 --method forward --out full --report full.json >/dev/full 2>stderr
    is_refusal $? "standard output (No space"
    [ "$(grep -c -v '^#' full/estimated.tum)" -eq 2 ] || fail "a full standard output took the trajectory"
    is_json full.json
    run --size 320x240 --frames 1 --method forward --out full --report /dev/full --quiet 2>stderr
    is_refusal $? "No space"
    [ -c /dev/full ] || fail "a report took the place of /dev/full"
    run --help >/dev/full 2>stderr
    is_refusal $? "No space"
else
    skip "there is no /dev/full"
fi
{
    run --size 320x240 --frames 1 --method forward --out full 2>stderr
    echo $? >status
} | :
is_refusal "$(cat status)" "Broken pipe"
# A file of more than 8 KiB cannot be written: the pictures cannot, the trajectory can.
(ulimit -f 16 && run --size 320x240 --frames 1 --method forward --out limited --save-photos limited --quiet) >stdout 2>stderr
is_refusal $? "too large"
has_no_parts limited
[ -z "$(find limited -name '*.p[np][gm]')" ] || fail "a picture that could not be written has its name: $(find limited)"
(ulimit -f 16 && run --size 320x240 --frames 1 --method forward --out limited --quiet) >stdout 2>stderr
is_refusal $? "residual.ppm (File too large)"
[ "$(grep -c -v '^#' limited/estimated.tum)" -eq 1 ] || fail "a limit on files took the trajectory"
has_no_parts limited
# Old files survive a run that cannot write new ones.
cp full/estimated.tum limited/estimated.tum
(ulimit -f 0 && run --size 320x240 --frames 1 --method forward --out limited --quiet) >stdout 2>/dev/null
equal "the status of a run that cannot write" $? 2
same full/estimated.tum limited/estimated.tum
has_no_parts limited

for signal in INT:130 TERM:143; do
    name=${signal%:*}
    if ! env --default-signal="$name" true 2>/dev/null; then
        skip "env cannot give SIG$name back"
        continue
    fi
    env --default-signal="$name" "$program" --size 320x240 --frames 100000 --method forward --noise 0 --out "SIG$name" --save-photos "SIG$name" \
        --report "SIG$name/report.json" --quiet </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until [ -e "SIG$name/rgb/000002.png" ] || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s "$name" $pid
    wait $pid
    equal "the status after SIG$name" $? "${signal#*:}"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line after SIG$name: $(cat stderr)"
    has stderr "^interrupted after frame [0-9]* of 100000 (SIG$name); SIG$name/estimated.tum has the poses of these frames"
    frames=$(sed -n 's/^interrupted after frame \([0-9]*\) .*/\1/p' stderr)
    for file in estimated.tum truth.tum groundtruth.txt associations.txt; do
        equal "the lines of $file after SIG$name" "$(grep -c -v '^#' "SIG$name/$file")" "$frames"
    done
    equal "the pictures after SIG$name" "$(find "SIG$name" -name '*.png' | wc -l)" $((2 * frames))
    is_json "SIG$name/report.json"
    equal "the frames of the report after SIG$name" "$(grep -c '"status":' "SIG$name/report.json")" "$frames"
    has "SIG$name/paths.svg" '</svg>'
    has_no_parts "SIG$name"
done
finish

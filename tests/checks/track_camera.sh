#!/bin/sh
# What track_camera promises: a short spoilt sequence on the built-in map is tracked, its report and its trajectories say so; the same
# pictures as PNG files are tracked as well; a bad picture costs no frame before it; and bad input is one line and status 2.
# Usage: sh track_camera.sh PATH_TO_track_camera
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

size=640x480

# --- the command line --------------------------------------------------------------------------
runs --help
for option in --trajectory --relative --cameras --camera --frames --size --noise --method --threads --report --out --quiet --photos --depth-scale --save-photos --one-in; do
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
run --size 160x120 --frames 1 --save-photos half --out half.out --quiet >stdout 2>stderr # the frame is lost; its pictures are written
cp half/rgb/000000.png small/rgb/000002.png
spoilt small "rgb/000002.png"
rm gone/rgb/000002.png
spoilt gone "rgb/000002.png"
cp seen/rgb/000002.png grey/depth/000002.png
spoilt grey "depth/000002.png"

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
# --- nothing that is read is overwritten -------------------------------------------------------
# Every kind of input under every name that the run writes: as the file itself, by a path with .., by a hard link, by a symbolic link.
runs --size $size --frames 2 --method forward --out made --save-photos photos --quiet
printf '[{"id": 0, "img_name": "a", "width": 640, "height": 480, "position": [0, 0, 0], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 500, "fy": 500}]' >lens.json
trajectory=made/truth.tum
clashes() { # INPUT OUTPUT ARGUMENTS...: the run refuses, and both keep their bytes
    kept=$1 target=$2
    shift 2
    for way in itself above hard symbolic; do
        rm -rf clash && mkdir -p clash/rgb clash/depth && cp "$kept" clash/input
        case $way in
        itself) mv clash/input "clash/$target" && given=clash/$target ;;
        above) mv clash/input "clash/$target" && given=clash/rgb/../$target ;;
        hard) ln clash/input "clash/$target" && given=clash/input ;;
        symbolic) ln -s "$PWD/clash/input" "clash/$target" && given=clash/input ;;
        esac
        refuses "reads that file" --size $size --frames 1 "$@" "$given"
        same "$kept" "$given"
        has_no_parts clash
    done
}
for name in estimated.tum truth.tum paths.svg residual.ppm; do
    clashes $trajectory $name --out clash --trajectory
    clashes lens.json $name --out clash --cameras
done
clashes $trajectory report.json --out one --report clash/report.json --trajectory
clashes lens.json report.json --out one --report clash/report.json --cameras
for name in associations.txt groundtruth.txt rgb/000000.png depth/000000.png; do
    clashes $trajectory $name --out one --save-photos clash --trajectory
done
refuses "reads that file" --cameras lens.json --photos photos --out photos/rgb/../ --report photos/rgb/000001.png
refuses "reads that file" --cameras lens.json --photos photos --out one --report photos/associations.txt
refuses "to be\|of this run" --size $size --frames 1 --out one --report one/estimated.tum
for file in photos/rgb/000001.png photos/associations.txt; do [ -s $file ] || fail "$file is lost"; done

# --- signals, a full disk, a run that is lost --------------------------------------------------
"$program" --size $size --frames 500 --method forward --out stopped >stdout 2>stderr &
pid=$!
n=0
while [ "$(grep -c '^frame' stdout)" -lt 2 ] && [ $n -lt 600 ]; do sleep 0.1 && n=$((n + 1)); done
kill -TERM $pid # a shell starts its jobs with SIGINT switched off
wait $pid
status=$?
[ $status -eq 143 ] || fail "status $status after SIGTERM, not 143: $(cat stderr)"
has stderr "interrupted after frame [0-9]* of 500 (SIGTERM)"
[ "$(grep -vc '^#' stopped/estimated.tum)" -ge 2 ] || fail "the poses so far are lost: $(ls stopped)"
has_no_parts stopped
if [ -w /dev/full ]; then
    run --size $size --frames 1 --method forward --out full >/dev/full 2>stderr
    is_refusal $? "standard output"
    [ -s full/estimated.tum ] || fail "a full standard output loses the poses"
fi
(ulimit -f 1 && exec timeout 120 "$program" --size $size --frames 1 --method forward --out small --quiet </dev/null) >stdout 2>stderr
is_refusal $? "small/"
has_no_parts small
run --size 160x120 --frames 2 --quiet --out lost >stdout 2>stderr
[ $? -eq 1 ] || fail "a run that lost every frame does not end with status 1"
has stderr "every frame is lost (2 of 2)"

chmod 500 locked
if [ -w locked ]; then
    skip "this user may write everywhere, so no folder is locked"
else
    refuses "locked" --size $size --frames 1 --out locked
    refuses "locked" --size $size --frames 1 --out one --report locked/report.json
    refuses "locked" --size $size --frames 1 --out one --save-photos locked
fi
finish

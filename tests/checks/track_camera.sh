#!/bin/sh
# What track_camera promises: a short spoilt sequence on the built-in map is tracked, its report and its trajectories say so, and bad input
# is one line and status 2.
# Usage: sh track_camera.sh PATH_TO_track_camera
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

size=640x480

# --- the command line --------------------------------------------------------------------------
runs --help
for option in --trajectory --relative --cameras --camera --frames --size --noise --method --threads --report --out --quiet; do
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
    assert f["iterations"] >= 2 and f["host_ms"] > 0, f
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
refuses "file" --size $size --frames 1 --out file/below --quiet
finish

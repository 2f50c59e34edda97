#!/bin/sh
# report.json of many kinds of runs: each is as report.schema.json describes it, and its advice is true.
# Usage: sh render_map_report.sh PATH_TO_render_map PATH_TO_report_schema SCHEMA
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
validate=$2 schema=$3

# shellcheck disable=SC2086 # $spot and $small are several words
small="--size 320x180 --quiet"
# Two hundred Gaussians on one spot, with harmonics of degree 1: one tile needs a slot for each.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 200\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    for i in 0 1 2 3 4 5 6 7 8; do echo "property float f_rest_$i"; done
    echo end_header
    awk 'BEGIN { for (i = 0; i < 200; ++i) print 0.03 + 0.0001 * i " 0.02 3 1 0.5 0 2 -9 -9 -9 1 0 0 0 .1 .1 .1 .1 .1 .1 .1 .1 .1" }'
} >spot.ply
echo '{"cameras": [{"name": "a", "width": 320, "height": 180, "fx": 300, "fy": 300, "cx": 160, "cy": 90, "exposure": 1,
    "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}' >lens
spot="spot.ply --cameras lens"
printf '1305031102.175304 0 0 0 0 0 0 1\n1305031102.211214 0.01 0 0 0 0 0 1\n' >walk.tum

# --- kinds of runs -----------------------------------------------------------------------------
runs $small --out plain --report plain.json
runs $small --out references --reference --report reference.json
runs $spot $small --out resumed --resume --depth --alpha --float --report resume.json
runs $spot $small --out resumed --resume --depth --alpha --float --report resume.json
runs $small --out dropped --preset prototype --storage-slots 60 --channel-slots 3 --report dropped.json
runs $small --out late --orbit 2 --frames 3 --hops 2 --report late.json
runs $small --out held --preset paper --saturation hold --report paper.json
runs $spot $small --out walked --trajectory walk.tum --relative --report walked.json
runs $spot $small --out unplaced --program anchored --storage-slots 150 --report unplaced.json
runs $spot $small --out traced --trace trace --machine test --report traced.json
runs $spot $small --out homes --program homes --held 40 --report homes.json
runs $spot $small --out cut --program homes --held 40 --rounds 2 --report cut.json
runs $spot $small --out auto --storage-slots 150 --report auto.json
mkdir photos && cp plain/frame_0000.png photos/a.png
runs spot.ply --cameras lens --quiet --out photographed --photos photos --error-picture --report photographed.json
runs spot.ply --cameras lens --quiet --out compared --compare photos/a.png --report compared.json
"$validate" "$schema" ./*.json || fail "a report is not as its schema says"

# --- what they say -----------------------------------------------------------------------------
has plain.json '^ "schema": 2,$'
has plain.json "^ \"version\": \"$("$program" --version | sed 's/.* //')\",\$"
has plain.json '^ "advice": null,$'
has walked.json '"timestamp_s": 1305031102.175304,'
has walked.json '"timestamp_s": 1305031102.211214,'
has walked.json 'lens: 1 camera has \\"exposure\\", which is not read"'
if grep -q timestamp_s plain.json; then fail "a camera without a trajectory has a time stamp"; fi

# member FILE GROUP NAME: a number of the first frame.
member() { awk -v group="\"$2\": {" -v name="\"$3\":" 'index($0, group) { f = 1 } f && index($0, name) { gsub(/[^0-9.]/, "", $2); print $2; exit }' "$1"; }
# The console counts passes and exchanges; the files of a trace have a line for each pass.
[ "$(grep -c . trace/frame_0000.supersteps.csv)" -eq $((1 + $(member traced.json passes project) + $(member traced.json passes route) + \
    $(member traced.json passes bloom) + $(member traced.json passes composite))) ] || fail "the trace has other passes than the report"
[ "$(member traced.json modelled cycles)" -eq \
    "$(awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i ~ /_cycles$/ && $i != "slowest_cycles") of[i] = 1 } NR > 1 { for (i in of) n += $i } END { print n }' \
        trace/frame_0000.supersteps.csv)" ] || fail "modelled cycles are not those of the trace"
runs $spot --size 320x180 --orbit 1 --frames 2
has stdout '^frame .* passes  *exchanges '

# The tile that is full: all 200 belong on one, and it has 150 slots.
[ "$(member unplaced.json full_tiles slots_available)" -eq 150 ] || fail "the full tile has other slots"
needed=$(member unplaced.json full_tiles slots_needed)
[ "$needed" -ge 200 ] || fail "200 Gaussians on one spot need $needed slots"
[ "$(member unplaced.json losses unplaced)" -eq "$(grep -c '"cause": "unplaced"' unplaced.json)" ] || fail "losses are not those of the list"
full=$(member unplaced.json full_tiles fullest)
if grep -A1 '"cause": "unplaced"' unplaced.json | grep '"tile"' | grep -vq "\"tile\": [0-9]"; then fail "an unplaced record has no tile"; fi
grep -A1 '"cause": "unplaced"' unplaced.json | grep -q "\"tile\": $full\$" || fail "no record is unplaced on the fullest tile"

# --- the advice is true ------------------------------------------------------------------------
# follow MAP... : what the run of these arguments advises, option by option, is done, and no tile is full.
follow() {
    runs "$@" $small --out advised --report advised.json
    advice=$(sed -n 's/^ "advice": "\(.*\)",$/\1/p' advised.json)
    [ -n "$advice" ] || fail "no advice: $*"
    has stderr "; $advice\$"
    printf '%s\n' "$advice" | grep -oE -e '(no --storage-slots|--[a-z-]+ [a-z0-9]+( without --storage-slots)?) \([0-9,]+ slots a tile\)' >ways
    [ -s ways ] || fail "no way is named: $advice"
    while read -r way; do
        case $way in *--storage-slots*) without=1 ;; *) without=0 ;; esac
        option=$(printf '%s\n' "$way" | sed -n 's/^\(--[a-z-]* [a-z0-9]*\).*/\1/p')
        followed=$(printf '%s ' "$@" $option)
        [ $without -eq 0 ] || followed=$(printf '%s' "$followed" | sed 's/--storage-slots [0-9]*//')
        case $option in --preset*) followed="$(printf '%s' "$followed" | sed 's/--preset [a-z]*//')" ;; esac
        # shellcheck disable=SC2086
        runs $followed $small --out followed --report followed.json
        if grep -qE '"cause": "(unplaced|storage_full)"' followed.json; then fail "$followed: tiles are full in spite of: $advice"; fi
        if grep -q full_tiles followed.json; then fail "$followed: full tiles"; fi
    done <ways
    cat ways >>all_ways
    rm -rf advised followed
}
follow $spot --program anchored --storage-slots 150
follow --preset prototype --storage-slots 60
has all_ways '^no --storage-slots'
has all_ways '^--machine test without --storage-slots (40,000 slots a tile)$'
has all_ways '^--sh-degree 0'
has all_ways '^--preset lossless'

finish

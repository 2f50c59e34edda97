#!/bin/sh
# What render_map writes with --trace for frames of the program of homes: every round on the timeline and in a table, each tile's frontier
# after each round, maps whose sums are the counters of the run's report.
# Usage: sh render_map_trace_homes.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

small="--program homes --size 160x90 --grid 10x9 --quiet --held 150"

# homes FILE KEY FRAME: the number of homes.KEY in the run's report, of the frame from 0.
homes() { sed -n '/"homes": {/,/}/p' "$1" | counter /dev/stdin "$2" "$3"; }
# column FILE NAME: the column's values.
column() { awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next } { print $c }' "$1"; }

# agrees FOLDER FRAME REPORT NUMBER: files of a frame of homes agree with each other and with the run's report.
agrees() {
    frame=$1/frame_$2
    rounds=$(homes "$3" rounds "$4")
    [ "$rounds" -gt 1 ] || fail "$frame has $rounds rounds"
    for end in tiles.csv supersteps.csv heat.csv rounds.csv trace.json heat_rounds.png heat_entries.png heat_frontier.png; do
        [ -s "$frame.$end" ] || fail "$frame.$end is missing"
    done
    is_json "$frame.trace.json"
    equal "entries of $frame" "$(sum "$frame.heat.csv" entries)" "$(homes "$3" entries "$4")"
    equal "pairs of $frame" "$(sum "$frame.heat.csv" pairs)" "$(counter "$3" pairs "$4")"
    equal "refusals of $frame" "$(sum "$frame.heat.csv" refusals)" $(($(counter "$3" channel_full "$4") + $(counter "$3" no_credit "$4")))
    equal "refused splats of $frame" "$(sum "$frame.rounds.csv" refused)" "$(homes "$3" refused "$4")"
    equal "the last round of $frame" "$(column "$frame.rounds.csv" round | sort -n | tail -n 1)" "$rounds"
    equal "rounds of all tiles of $frame" "$(sum "$frame.heat.csv" rounds)" "$(($(wc -l <"$frame.rounds.csv") - 1))"
    equal "the most splats in a round of $frame" "$(column "$frame.rounds.csv" held | sort -n | tail -n 1)" "$(counter "$3" storage "$4")"
    # Each round is on the timeline, with its number, once.
    number=1
    while [ $number -le "$rounds" ]; do
        equal "round $number on the timeline of $frame" "$(grep -c "\"name\":\"round $number of $rounds\"" "$frame.trace.json")" 1
        number=$((number + 1))
    done
    # A frontier never goes back, and the map has the last one.
    awk -F, 'NR > 1 { tile = $3 "," $4; if (tile in depth && $7 < depth[tile]) exit 1; depth[tile] = $7; if (tile in done && chapter[tile] == $2) exit 1
        if ($8 == 1) done[tile]; chapter[tile] = $2 }' "$frame.rounds.csv" || fail "$frame.rounds.csv: a frontier goes back, or a tile goes on when it is done"
    awk -F, 'NR > 1 { depth[$3 "," $4] = $7 } END { for (tile in depth) print tile "," depth[tile] }' "$frame.rounds.csv" | sort >last
    awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "frontier") c = i; next } $c > 0 { print $1 "," $2 "," $c }' "$frame.heat.csv" | sort >map
    [ -s map ] || fail "$frame.heat.csv has no frontier"
    same last map
    has_no_parts "$1"
}

# shellcheck disable=SC2086
{
    runs $small --orbit 5 --frames 2 --out plain --float
    runs $small --orbit 5 --frames 2 --out pictures --float --trace trace --report report.json
}
same plain/frame_0000.pfm pictures/frame_0000.pfm
same plain/frame_0001.pfm pictures/frame_0001.pfm
agrees trace 0000 report.json 0
agrees trace 0001 report.json 1
for words in "<h3>Rounds</h3>" "<th>nearest frontier</th>" "in world units" "frame_0001.rounds.csv has a line" ">round 1</text>"; do has trace/report.html "$words"; done
equal "prices on the page" "$(sed -n "s/^<tr><td>\([a-z_]*\)<.*>millicycles<.*/\1/p" trace/report.html | sort | tr '\n' ' ')" \
    "comparison exchange_byte left pair passed pixel projection settled slot "
equal "rows of rounds" "$(awk '/<h3>Rounds</ { on = 1 } /<\/table>/ { on = 0 } on && /^<tr><td>/' trace/report.html | wc -l)" \
    $(($(homes report.json rounds 0) + $(homes report.json rounds 1)))

# An unchanged view has no round, and the file of an earlier run goes.
printf '1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n' >still.tum
# shellcheck disable=SC2086
runs $small --trajectory still.tum --out pictures --trace trace --report still.json
agrees trace 0000 still.json 0
equal "rounds of an unchanged view" "$(homes still.json rounds 1)" 0
[ ! -e trace/frame_0001.rounds.csv ] || fail "an unchanged view has rounds"

# The same bytes on any number of threads, and on the other engine.
# shellcheck disable=SC2086
{
    runs $small --out pictures --trace one
    runs $small --out pictures --trace three --threads 3
    runs $small --out pictures --trace other --engine sequential
}
for file in one/*; do same "$file" "three/${file#one/}"; done
for file in one/*.csv one/*.json; do same "$file" "other/${file#one/}"; done

# A bound: the tiles that are not done are the report's unfinished ones, cut where it says.
# shellcheck disable=SC2086
runs $small --rounds 2 --out pictures --trace cut --report cut.json
agrees cut 0000 cut.json 0
equal "rounds at a bound" "$(homes cut.json rounds 0)" 2
equal "unfinished tiles" "$(awk -F, '$1 == 2 && $8 == 0' cut/frame_0000.rounds.csv | wc -l)" "$(homes cut.json unfinished_tiles 0)"

finish

#!/bin/sh
# What render_map writes with --trace and --follow: every file that it promises, numbers that agree with each other and with the
# run's report, a report that a browser shows without a network, one line and status 2 for what cannot be traced.
# Usage: sh render_map_trace.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

small="--program anchored --size 160x90 --grid 20x18 --quiet"
walk="$small --orbit 5 --frames 2"
maps="load copies channel_fill refusals drops busy_cycles idle_cycles pairs"

# has_trace FOLDER FRAMES: all that is promised, not empty, and nothing else but what is followed.
has_trace() {
    for file in report.html model.txt frames.csv; do [ -s "$1/$file" ] || fail "$1/$file is missing"; done
    for frame in $2; do
        for end in tiles.csv supersteps.csv heat.csv trace.json; do [ -s "$1/frame_$frame.$end" ] || fail "$1/frame_$frame.$end is missing"; done
        for map in $maps; do [ -s "$1/frame_$frame.heat_$map.png" ] || fail "$1/frame_$frame.heat_$map.png is missing"; done
        [ "$(wc -c <"$1/frame_$frame.trace.json")" -lt 20000000 ] || fail "frame_$frame.trace.json is 20 MB or more"
        is_json "$1/frame_$frame.trace.json"
    done
    # shellcheck disable=SC2086
    equal "files in $1" "$(find "$1" -type f | grep -vc follow_)" $((3 + 12 * $(echo $2 | wc -w)))
    has_whole_pictures "$1"
    has_no_parts "$1"
    # No script, nothing that is fetched: the only address is that of data in the page.
    for what in '://' '<script' 'href="' '@import' 'srcset="'; do
        if grep -a -q -F -e "$what" "$1/report.html"; then fail "$what is in $1/report.html"; fi
    done
    equal "sources of pictures in $1" "$(grep -a -o 'src="[^"]\{0,22\}' "$1/report.html" | sort -u)" 'src="data:image/png;base64,'
    has "$1/report.html" "default-src 'none'"
    equal "the end of $1/report.html" "$(tail -c 8 "$1/report.html")" "</html>"
    # It opens with one sentence, and has no number that is none.
    equal "the first sentences of $1/report.html" "$(sed -n '/^<h1>/{n;s/^<p class="lead">\(Slowest: \).*/\1/p;}' "$1/report.html")" "Slowest: "
    if sed 's/;base64,[^"]*//g' "$1/report.html" | grep -a -E -e '[^a-z](nan|inf)[^a-z]' -e '0 kind'; then fail "no number in $1/report.html"; fi
}
# agrees FOLDER FRAME REPORT NUMBER: the sums over tiles are the run's counters.
agrees() {
    heat=$1/frame_$2.heat.csv
    tiles=$1/frame_$2.tiles.csv
    equal "copies of $heat" "$(sum "$heat" copies)" "$(counter "$3" copies "$4")"
    equal "refusals of $heat" "$(sum "$heat" refusals)" \
        $(($(counter "$3" channel_full "$4") + $(counter "$3" no_credit "$4")))
    equal "drops of $heat" "$(sum "$heat" drops)" \
        $(($(counter "$3" storage_full "$4") + $(counter "$3" copies_full "$4") + $(counter "$3" copies_refused "$4")))
    equal "pairs of $heat" "$(sum "$heat" pairs)" "$(counter "$3" pairs "$4")"
    [ "$(sum "$tiles" pair)" -ge "$(sum "$heat" pairs)" ] || fail "the slowest workers of $tiles did less than all did"
    equal "busy cycles of $heat" "$(sum "$heat" busy_cycles)" "$(sum "$tiles" compute_cycles)"
    equal "tile runs of $tiles" "$(sum "$1/frame_$2.supersteps.csv" tiles_run)" $(($(wc -l <"$tiles") - 1))
    equal "busy and idle cycles of $heat" $(($(sum "$heat" busy_cycles) + $(sum "$heat" idle_cycles))) \
        $(($(sum "$1/frame_$2.supersteps.csv" compute_cycles) * ($(wc -l <"$heat") - 1)))
    [ "$(sum "$heat" load)" -gt 0 ] || fail "$heat has no load"
}

runs --help
for option in --trace --cost-model --energy --follow --most-passes; do has stdout "^  $option "; done

# --- all files, and their numbers --------------------------------------------------------------
# shellcheck disable=SC2086
runs $walk --fit off --out plain --float
# shellcheck disable=SC2086
runs $walk --out pictures --float --trace trace --follow 17 --report report.json
same plain/frame_0000.pfm pictures/frame_0000.pfm
same plain/frame_0001.pfm pictures/frame_0001.pfm
has_trace trace "0000 0001"
agrees trace 0000 report.json 0
agrees trace 0001 report.json 1
for column in pairs messages copies; do
    equal "$column of frames.csv" "$(sum trace/frames.csv $column)" $(($(counter report.json $column 0) + $(counter report.json $column 1)))
done
equal "records of both frames" "$(sum trace/frame_0000.heat.csv load)" \
    $(($(counter report.json visible 0) + $(counter report.json parked 0) + $(counter report.json copies 0)))
for heading in "<h1>Map built_in on " "<h2>Frames</h2>" "<h2>Frame 0: built_in orbit" "<h2>Frame 1: built_in orbit" \
    "Where the time goes, by step" "The run over time" "<h2>The life of Gaussian 17</h2>" \
    "<h2>Ledger of a tile" "<h2>Cost model mk2</h2>" \
    "<h2>What the operations mean</h2>" "<h2>What the counters mean</h2>"; do
    has trace/report.html "$heading"
done
# The prices of operations that the frames counted, and no others.
prices() { sed -n "s/^<tr><td>\([a-z_]*\)<.*>millicycles<.*/\1/p" "$1/report.html" | sort | tr '\n' ' '; }
equal "prices on the page" "$(prices trace)" "comparison copied exchange_byte pair pixel projection routed slot "
has trace/report.html "prices of operations that this run did not count"

# Steps of one kernel have different names, each once on the timeline of each frame; maps have the picture's shape.
for name in project route "bloom 1" "bloom 2" "depth sort" composite; do
    equal "names of step $name" "$(grep -a -o ">$name</text>" trace/report.html | wc -l)" 4 # two frames of two diagrams
    equal "rows of step $name" "$(grep -a -c "^<tr><td>$name</td>" trace/report.html)" "$(case $name in bloom*) echo 2 ;; *) echo 4 ;; esac)"
done
for frame in 0 1; do
    equal "passes of frame $frame" "$(grep -a -o '<dt>passes</dt><dd>[0-9,]*' trace/report.html | sed -n "$((frame + 1))s/.*>//p" | tr -d ,)" \
        $(($(wc -l <trace/frame_000$frame.supersteps.csv) - 1))
    exchanges=$(grep -a -o '<dt>exchanges</dt><dd>[0-9,]*' trace/report.html | sed -n "$((frame + 1))s/.*>//p" | tr -d ,)
    [ "$exchanges" -le "$(wc -l <trace/frame_000$frame.supersteps.csv)" ] || fail "$exchanges exchanges are more than passes"
done
has trace/report.html 'style="aspect-ratio: 160.000 / 90.000"'

# The same bytes for any number of threads.
# shellcheck disable=SC2086
runs $walk --out pictures --trace again --follow 17 --threads 3
for file in trace/*; do same "$file" "again/${file#trace/}"; done

# Into one folder with the pictures, and what a terminal says.
run --size 160x90 --grid 20x18 --out one --trace one/. --follow 17 >stdout 2>stderr || fail "status $?: $(cat stderr)"
has stdout "^modelled by mk2 (capacity exchange), busy [0-9.]* % of all tile time:"
has stdout "^Gaussian 17 in frame 0: on tile ([0-9]*, [0-9]*), [0-9]* cop[a-z]*, [0-9]* hops*, [0-9]* refusals*"
has stdout "^wrote one/frame_0000.png"
has stdout "report.html, and the trace beside it"
[ -s one/frame_0000.png ] || fail "the picture is missing beside the trace"

# --- another cost model ------------------------------------------------------------------------
# shellcheck disable=SC2086
runs $small --out pictures --trace first
# shellcheck disable=SC2086
runs $small --out pictures --trace second --cost-model first/model.txt
for file in first/*; do same "$file" "second/${file#first/}"; done
# The first sentence gives the share of the step and phase with the most cycles, and the tile that is slowest in it.
awk -F, 'NR > 1 { c[$2] += $5; slow[$2 " (" $9 ", " $10 ")"] += $5; all += $5 + $6 + $7 + $8 }
    END { for (s in c) if (c[s] > most) { most = c[s]; step = s }
        for (t in slow) if (index(t, step " ") == 1 && slow[t] > longest) { longest = slow[t]; tile = substr(t, index(t, "(")) }
        printf "%.1f %% of the frame is its compute\ntile %s\n", 100 * most / all, tile }' first/frame_0000.supersteps.csv >worst
while IFS= read -r words; do
    sed -n '/^<h1>/{n;p;}' first/report.html | grep -a -q -F -e "$words" || fail "\"$words\" is not in: $(sed -n '/^<h1>/{n;p;}' first/report.html)"
done <worst
equal "lines about the bottleneck" "$(wc -l <worst)" 2
# The table by step names the tile of each step whose passes as the slowest tile take the most cycles, and the number of these passes.
awk -F, 'NR > 1 && $5 > 0 { of[$2]++; at = $2 ",(" $9 ", " $10 ")"; times[at]++; cycles[at] += $5 }
    END { for (s in of) { most = 0
        for (t in cycles) if (index(t, s ",") == 1 && cycles[t] > most) { most = cycles[t]; at = t }
        print s "|" substr(at, index(at, "(")) (of[s] == 1 ? ":" : " in " times[at] " of " of[s] " passes:") } }' first/frame_0000.supersteps.csv |
    sort -n | sed 's/^.*|//' >slowest
grep -a -o '<td>([0-9]*, [0-9]*)[^<]*:$' first/report.html | sed 's/<td>//' >named
equal "steps with a slowest tile" "$(wc -l <slowest)" 6
same slowest named
sed 's/^\(exchange_cost *\)capacity/\1live    /; s/^model .*/model of "mine" <b>/' first/model.txt >mine.txt
# shellcheck disable=SC2086
runs $small --out pictures --trace second --cost-model mine.txt
same first/frame_0000.heat.csv second/frame_0000.heat.csv
[ "$(sum second/frame_0000.supersteps.csv exchange_cycles)" -lt "$(sum first/frame_0000.supersteps.csv exchange_cycles)" ] ||
    fail "live bytes cost no less than capacity"
has second/report.html "Cost model of &quot;mine&quot; &lt;b&gt;"
same mine.txt second/model.txt

# --- ideal routing -----------------------------------------------------------------------------
# cells NUMBER: of the table rows under Ideal routing of frame 0 of the run before, that cell; the last row is the sum.
cells() { awk -F '</?td>' -v c="$1" '/<h[23]>/ { on = /<h3>Ideal routing</ } on && NF > 1 { print $(2 * c) }' second/report.html | tr -d ,; }
costs=$(($(sum second/frame_0000.supersteps.csv exchange_cycles) + $(sum second/frame_0000.supersteps.csv sync_cycles) +
    $(sum second/frame_0000.supersteps.csv vote_cycles)))
equal "cycles hop by hop" "$(cells 2 | tail -n 1)" $costs
for column in 2 3 4; do equal "column $column of ideal routing" "$(cells $column | sed '$d' | awk '{ s += $1 } END { print s }')" "$(cells $column | tail -n 1)"; done
[ "$(cells 3 | tail -n 1)" -lt $costs ] || fail "no way is shorter than hop by hop with live exchange"
has second/report.html "This is a bound and no machine"

# --- energy ------------------------------------------------------------------------------------
# A price for all that occurs with live exchange, and none for capacity_byte, which does not.
echo 'energy of "mine" <b>' >energy.txt
femtojoules=0
for price in slot:1 projection:20 routed:300 copied:4000 comparison:5 pair:600 pixel:70; do
    echo "${price%:*} ${price#*:} fJ a <test>" >>energy.txt
    femtojoules=$((femtojoules + $(sum second/frame_0000.tiles.csv "${price%:*}") * ${price#*:}))
done
# Bytes over hops are 8 fJ each, and every cycle of all 360 tiles 3.
printf 'sent_byte 8 fJ a <test>\ntile_cycle 3 fJ a <test>\n' >>energy.txt
for side in north east west south; do femtojoules=$((femtojoules + $(sum second/frame_0000.tiles.csv ${side}_bytes) * 8)); done
femtojoules=$((femtojoules + 3 * 360 * ($(sum second/frame_0000.supersteps.csv compute_cycles) + costs)))
run --program anchored --size 160x90 --grid 20x18 --out pictures --trace priced --cost-model mine.txt --energy energy.txt >stdout 2>stderr || fail "$(cat stderr)"
# joules DIGITS: the sum over all tiles.
joules() { awk -F, -v form="%.$1g" 'NR > 1 { s += $3 } END { printf form, s }' priced/frame_0000.energy.csv; }
equal "the joules of all tiles" "$(joules 12)" "$(awk -v n=$femtojoules 'BEGIN { printf "%.12g", n / 1e15 }')"
equal "what a terminal says of energy" "$(grep '^energy' stdout)" "energy by of \"mine\" <b> in frame 0: $(joules 6) J"
has priced/report.html "<dt>energy</dt><dd>$(joules 6) J</dd>"
for cells in 5:8 3:4; do # by kind, by step: of so many cells, which field has the joules
    equal "joules in rows of ${cells%:*}" "$(awk -F '</?td>' -v fields=$((2 * ${cells%:*} + 1)) -v at="${cells#*:}" '
        /<h[23]>/ { on = /<h3>Energy</ } on && NF == fields { s += $at } END { printf "%.4g", s }' priced/report.html)" "$(joules 4)"
done
equal "the head of the joules" "$(head -n 1 priced/frame_0000.energy.csv)" tile_x,tile_y,joules
equal "tiles with joules" "$(awk -F, 'NR > 1 && $3 > 0' priced/frame_0000.energy.csv | wc -l)" 360
has priced/report.html "<h2>Energy model of &quot;mine&quot; &lt;b&gt;"
has priced/report.html "<tr><td>pair</td><td>600</td><td>fJ</td><td>a &lt;test&gt;</td></tr>"
has_whole_pictures priced
# Everything else is as without, where there is no word of it.
[ -s priced/frame_0000.heat_energy.png ] || fail "priced/frame_0000.heat_energy.png is missing"
equal "files with energy" "$(find priced -type f | wc -l)" 17
for file in second/*; do [ "$file" = second/report.html ] || same "$file" "priced/${file#second/}"; done
if grep -a -i -e energy -e joules second/report.html; then fail "energy without --energy"; fi

# --- the life of one Gaussian ------------------------------------------------------------------
# A map of one Gaussian, framed whole: it ends in the middle of the picture, on the middle tile of five by five.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    for property in x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do
        echo "property float $property"
    done
    printf 'end_header\n0 0 0 0 0 0 1 1 1 5 -1 -1 -1 1 0 0 0\n'
} >one.ply
run one.ply --size 50x50 --grid 5x5 --out pictures --trace middle --follow 1 --report one.json >stdout 2>stderr || fail "$(cat stderr)"
has stdout "^Gaussian 1 in frame 0: on tile (2, 2)"
copies=$(counter one.json copies 0)
[ "$copies" -gt 0 ] || fail "one Gaussian that fills the picture has no copies"
has stdout "on tile (2, 2), $copies copies, 4 hops, 0 refusals" # loaded onto tile (0, 0)
has middle/follow_1.csv '^frame,superstep,kernel,tile_x,tile_y,what,side,refusal$'
has middle/follow_1.csv '^0,0,project,0,0,leaving,,0$'
has middle/follow_1.csv '^0,1,route,1,0,road,west,0$'
has middle/follow_1.csv '^0,[0-9]*,route,2,2,road,north,0$'
has middle/follow_1.csv '^0,[0-9]*,route,2,2,anchored,,0$'
has middle/report.html "<h3>[0-9]* maps are the same on every tile</h3>" # nothing is refused or dropped
has middle/report.html "<p>Refusals: .* It is 0 sends on every tile.</p>"
equal "tiles that got a copy" "$(grep -c ',copy,,0$' middle/follow_1.csv)" "$copies"
equal "the fifth column and the third row of the load" "$(sed -n 14p middle/frame_0000.heat.csv | cut -d, -f1-4)" 2,2,1,0
equal "tiles with a copy" "$(awk -F, '$4 == 1' middle/frame_0000.heat.csv | wc -l)" "$copies"

# One slot a channel: what is followed is refused, as often as the machine refuses anything.
{
    sed 's/vertex 1/vertex 40/; /^0 0 0/d' one.ply
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40; do
        echo '0 0 0 0 0 0 1 1 1 5 -4 -4 -4 1 0 0 0'
    done
} >forty.ply
all=0
for id in $(seq 40); do
    run forty.ply --size 50x50 --grid 5x5 --out pictures --channel-slots 1 --trace narrow --follow "$id" --report narrow.json >stdout 2>stderr ||
        fail "$(cat stderr)"
    has stdout "^Gaussian $id in frame 0: on tile (2, 2)"
    equal "refusals of $id" "$(grep -c ',1$' "narrow/follow_$id.csv")" "$(sed -n 's/^Gaussian .* \([0-9]*\) refusals*$/\1/p' stdout)"
    all=$((all + $(grep -c ',1$' "narrow/follow_$id.csv")))
done
[ $all -gt 0 ] || fail "nobody waits for a channel of one slot"
agrees narrow 0000 narrow.json 0
equal "refusals of all forty" $all "$(sum narrow/frame_0000.heat.csv refusals)"
equal "the fullest channel in percent" "$(awk -F, 'NR > 1 && $5 > most { most = $5 } END { print most }' narrow/frame_0000.heat.csv)" 100

# Five slots of storage: what arrives at a full tile is seen to, record and copy.
all=0
for id in $(seq 40); do
    run forty.ply --size 50x50 --grid 5x5 --out pictures --storage-slots 5 --trace tight --follow "$id" --report tight.json >stdout 2>stderr ||
        fail "$(cat stderr)"
    all=$((all + $(grep -c ',dropped,[a-z]*,1$' "tight/follow_$id.csv")))
    if ! grep -q ',route,2,2,dropped,' "tight/follow_$id.csv"; then continue; fi
    has stdout "^Gaussian $id in frame 0: dropped on tile (2, 2)"
done
equal "what met a full storage" $all $(($(counter tight.json storage_full 0) + $(counter tight.json copies_full 0)))
[ "$(counter tight.json storage_full 0)" -gt 0 ] || fail "a tile of five slots had room for forty records"
[ "$(counter tight.json copies_full 0)" -gt 0 ] || fail "a tile of five slots had room for forty copies"

# Thousands of supersteps: fewer of the busiest tiles are in the timeline, so that it stays below 20 MB.
run --program anchored --size 80x45 --grid 10x9 --channel-slots 1 --quiet --out pictures --trace long || fail "status $?"
has_trace long 0000
has long/report.html "timeline of the machine and its 32 busiest tiles"
[ "$(wc -l <long/frame_0000.supersteps.csv)" -gt 2000 ] || fail "a channel of one slot was fast"

# Tiles that are too small: the host recalls copies, and the frame takes a second run, which is in the trace too.
# shellcheck disable=SC2086
runs $walk --storage-slots 240 --out pictures --trace crowded --report crowded.json
agrees crowded 0000 crowded.json 0
agrees crowded 0001 crowded.json 1
equal "runs of the first frame" "$(grep -c ',project,' crowded/frame_0000.supersteps.csv)" 2
[ "$(sum crowded/frame_0000.heat.csv drops)" -gt 0 ] || fail "tiles of 240 slots had room for all"

# --- other presets -----------------------------------------------------------------------------
for preset in paper prototype; do
    # shellcheck disable=SC2086
    runs $small --out plain --float --preset $preset --channel-slots 10
    # shellcheck disable=SC2086
    runs $small --out pictures --float --preset $preset --channel-slots 10 --trace $preset --follow 17 --report $preset.json
    same plain/frame_0000.pfm pictures/frame_0000.pfm
    has_trace $preset 0000
    agrees $preset 0000 $preset.json 0
done
[ "$(sum prototype/frame_0000.heat.csv drops)" -gt 0 ] || fail "channels of ten slots dropped nothing"
# A record that is gone: its life ends where it met a full storage.
# shellcheck disable=SC2086
runs $small --out pictures --preset prototype --channel-slots 20 --storage-slots 150 --trace gone --follow 7 --report gone.json
has gone.json '"id": 7,'
equal "the end of a record that is dropped" "$(tail -n 1 gone/follow_7.csv)" 0,13,route,2,10,dropped,north,1

# --- other machines, engines, policies and planes ----------------------------------------------
# Both engines have one trace, byte for byte. Whatever is asked for, the picture is the one without a trace.
# shellcheck disable=SC2086
{
    for options in "" "--depth --alpha"; do
        runs $small --out pictures --trace threads --follow 17 $options
        runs $small --out pictures --trace sequential --follow 17 --engine sequential $options
        has_trace sequential 0000
        for file in threads/*.csv; do same "$file" "sequential/${file##*/}"; done
        rm -r threads sequential
    done
    for options in "--machine test" "--copies screen" "--pixels rgbx8" "--saturation drop --channel-slots 10" \
        "--preset paper --saturation hold --channel-slots 10 --depth"; do
        runs $small --out plain --float --fit off $options
        runs $small --out pictures --float $options --trace other --follow 17 --report other.json
        same plain/frame_0000.pfm pictures/frame_0000.pfm
        has_trace other 0000
        agrees other 0000 other.json 0
        rm -r other
    done
}

# --- what is refused ---------------------------------------------------------------------------
for option in --trace --cost-model --energy --follow --most-passes; do refuses "^$option has no value" $option; done
for value in 0 -1 x 4294967296; do refuses "whole number" --most-passes "$value"; done
for value in 0 -1 x 4294967296; do refuses "whole number" --trace refused --follow "$value"; done
refuses "empty" --trace ""
refuses "^--cost-model is given without --trace" --cost-model first/model.txt
refuses "^--energy is given without --trace" --energy energy.txt
refuses "^--follow is given without --trace" --follow 1
# shellcheck disable=SC2086
{
    refuses "^--follow cannot be 99999999 (map built_in has " $small --trace refused --follow 99999999
    refuses "cannot read the cost model absent.txt (No such file" $small --trace refused --cost-model absent.txt
    refuses "cannot read the cost model first (" $small --trace refused --cost-model first
    refuses "^one.ply line 1 begins no cost model" $small --trace refused --cost-model one.ply
    refuses "cannot read the energy model absent.txt (No such file" $small --trace refused --energy absent.txt
    refuses "cannot read the energy model first (" $small --trace refused --energy first
    refuses "^one.ply line 1 begins no energy model" $small --trace refused --energy one.ply
    { cat energy.txt; echo "slot 2 fJ twice"; } >twice.txt
    refuses "^twice.txt line 11 repeats a parameter" $small --trace refused --energy twice.txt
    # Known only when it occurs: before a file of the trace is written.
    grep -v ^pair energy.txt >unset.txt
    refuses "event pair occurs, first in superstep [0-9]*, and its energy is not set" $small --out pictures --trace unset --cost-model mine.txt \
        --energy unset.txt
    refuses "event capacity_byte occurs" $small --out pictures --trace unset --energy energy.txt
    equal "files beside an energy that is not set" "$(ls unset)" ""
    cp energy.txt unset/frame_0000.energy.csv
    refuses "to unset/frame_0000.energy.csv (this run reads that file); name another directory with --trace" $small --trace unset --energy unset/frame_0000.energy.csv
    same energy.txt unset/frame_0000.energy.csv
    cp -r first reused
    refuses "cannot write a file of the trace to reused/model.txt (this run reads that file)" $small --trace reused --cost-model reused/model.txt
    same first/model.txt reused/model.txt
    refuses "a file of the trace of this run has that name" $small --out pictures --trace first --report first/report.html
    refuses "a file of the trace of this run has that name" $small --out pictures --trace first --report first/frame_0000.heat.csv
    : >file
    refuses "cannot write to file (.*); name a writable directory with --trace" $small --out pictures --trace file
    refuses "cannot write to file/below (.*); name a writable directory with --trace" $small --out pictures --trace file/below
}
[ ! -e refused ] || fail "a folder for a trace that was refused"

# --- view-dependent colour ---------------------------------------------------------------------
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    for property in x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 $(seq -f 'f_rest_%g' 0 8) opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do
        echo "property float $property"
    done
    printf 'end_header\n0 0 0 0 0 0 1 1 1 1 1 1 1 1 1 1 1 1 5 -1 -1 -1 1 0 0 0\n'
} >shaded.ply
# shellcheck disable=SC2086
for bytes in 96 60; do # of a record
    options=
    [ $bytes -eq 96 ] || options="--sh-degree 0"
    runs shaded.ply $small --out plain --float $options
    runs shaded.ply $small --out pictures --float --trace shaded --follow 1 --report shaded.json $options
    same plain/frame_0000.pfm pictures/frame_0000.pfm
    has_trace shaded 0000
    agrees shaded 0000 shaded.json 0
    has shaded/follow_1.csv ',anchored,,0$'
    # A record that routing sends has 4 bytes more than a copy that bloom sends: its anchor tile.
    hops=$(counter shaded.json hops 0)
    equal "live bytes of records of $bytes bytes" "$(counter shaded.json live 0)" $((4 * hops + bytes * $(counter shaded.json messages 0)))
    rm -r shaded
done

# A bound that is too small for records that come from far: one line, and with a trace what it says besides in a file.
bounded="$small --out pictures --most-passes"
# shellcheck disable=SC2086
{
    refuses "^step 1 is not quiet after 3 passes .*superstep 4 (route)" $bounded 3 --fit off
    refuses "^--trace-tiles" $small --trace-tiles
    runs --program anchored --channel-slots 1 --quiet --trace long --trace-tiles # 600,000 lines
    [ "$(wc -l <long/frame_0000.tiles.csv)" -gt 200000 ] || fail "long/frame_0000.tiles.csv has too few lines for this test"
    runs --program anchored --channel-slots 1 --quiet --trace long
    [ ! -e long/frame_0000.tiles.csv ] || fail "a long table by tile was written, or the one of the last run is still there"
    has long/report.html "trace-tiles writes it"
    refuses "^step 1 is not quiet after 3 passes .*superstep 4 (route)" $bounded 3 --engine sequential
    refuses "^step 1 is not quiet after 3 passes .*superstep 4 (route).* in bounded/no_progress.txt$" $bounded 3 --trace bounded
    equal "files of a run without a frame" "$(ls bounded)" no_progress.txt
    equal "its first line and the error" "$(head -n 1 bounded/no_progress.txt) in bounded/no_progress.txt" "$(cat stderr)"
    has bounded/no_progress.txt "^step 1 (route) repeats nothing in its last 4 supersteps"
    cp first/model.txt bounded/no_progress.txt
    refuses "to bounded/no_progress.txt (this run reads that file)" $bounded 3 --trace bounded --cost-model bounded/no_progress.txt
    runs $bounded 1000 --trace bounded
    has_trace bounded 0000
    same first/frame_0000.tiles.csv bounded/frame_0000.tiles.csv
}

# What ends a run in the middle does not take the frames before, nor does an interrupt.
mkdir -p stopped/frame_0001.heat.csv/in_the_way
# shellcheck disable=SC2086
refuses "cannot write stopped/frame_0001.heat.csv" $small --out pictures --orbit 1 --frames 3 --trace stopped
has stopped/report.html "stopped after frame 1 of 3"
has stopped/report.html "<h2>Frame 0: built_in orbit"
has_no_parts stopped
if env --default-signal=INT true 2>/dev/null; then # a background job of a script ignores SIGINT
    # shellcheck disable=SC2086
    env --default-signal=INT "$program" $small --out pictures --orbit 0.01 --frames 3000 --trace cut </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until [ -s cut/frame_0001.heat.csv ] || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s INT $pid
    wait $pid
    equal "the status after an interrupt" $? 130
    has cut/report.html "interrupted after frame [0-9]* of 3000"
    equal "the end of a report after an interrupt" "$(tail -c 8 cut/report.html)" "</html>"
    has_no_parts cut
else
    skip "env cannot give SIGINT back"
fi

# --- a browser ---------------------------------------------------------------------------------
browser=
for name in chromium chromium-browser google-chrome headless_shell; do
    if [ -z "$browser" ] && command -v $name >/dev/null; then browser=$name; fi
done
if [ -z "$browser" ]; then
    skip "no browser"
else
    timeout 120 "$browser" --headless --no-sandbox --disable-gpu --user-data-dir="$work/profile" --enable-logging=stderr \
        --dump-dom "file://$work/trace/report.html" >dom 2>log </dev/null || fail "status $? of $browser: $(tail -n 3 log)"
    for heading in "<h1>Map built_in on " "<h2>Frame 1: built_in orbit" "<h2>The life of Gaussian 17</h2>" "<h2>Cost model mk2</h2>" "</svg>"; do
        has dom "$heading"
    done
    if grep CONSOLE log; then fail "$browser has something to say about report.html"; fi
fi

finish

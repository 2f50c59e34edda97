#!/bin/sh
# What explore promises: known rows of a small study; prices need no run and are, to the cycle, those of a run with these prices; a run that
# is resumed renders nothing again and writes the same; the page shows losses; threads change no byte; and bad input is one line, status 2.
# Usage: sh explore.sh PATH_TO_explore PATH_TO_render_map FOLDER_OF_machines
case $2 in /*) render_map=$2 ;; *) render_map=$PWD/$2 ;; esac
case $3 in /*) machines=$3 ;; *) machines=$PWD/$3 ;; esac
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
cp "$machines"/*.txt .

runs --help
for option in --csv --out --threads --quiet; do has stdout "^  $option "; done
# explores ARGUMENTS...: quietly, with status 0.
explores() { runs "$@" --quiet; }

# --- three points, against render_map --------------------------------------------------------------
cat >three.json <<'JSON'
{"size": [160, 90], "machines": ["mk2.txt"], "costs": ["machine", {"exchange_byte": 125}, {"clock": 2650000}]}
JSON
explores three.json --csv three.csv --out three
equal "lines" "$(wc -l <three.csv)" 4
equal "runs" "$(ls three/run_*.png | wc -l)" 1
"$render_map" --size 160x90 --machine mk2.txt --trace where --reference --fit off --program anchored --quiet --out frames --report r.json >log 2>&1 || fail "render_map: $(cat log)"
cycles=$(counter r.json cycles 0)
awk -F, 'NR > 1 { print $11 }' three.csv >cycles
equal "cycles of the machine's prices" "$(sed -n 1p cycles)" "$cycles"
equal "cycles at twice the clock" "$(sed -n 3p cycles)" "$cycles"
# The second: as a run with these prices.
sed 's/^exchange_byte .*/exchange_byte 125 millicycles guess/' where/model.txt >half.txt
"$render_map" --size 160x90 --machine mk2.txt --trace again --cost-model half.txt --fit off --program anchored --quiet --out frames --report h.json >log 2>&1 ||
    fail "render_map: $(cat log)"
equal "cycles at twice the link speed" "$(sed -n 2p cycles)" "$(counter h.json cycles 0)"
[ "$(sed -n 2p cycles)" -lt "$cycles" ] || fail "faster links take as long"
awk -F, 'NR == 2 { a = $10 } NR == 4 { b = $10 } END { exit !(b * 2 > a * 0.999999 && b * 2 < a * 1.000001) }' three.csv || fail "twice the clock is not half of the time"
equal "bytes of a tile" "$(sed -n 2p three.csv | cut -d, -f12)" "$(counter r.json budgeted_bytes 0)"
psnr=$(tr -d ' \n' <r.json | sed -E 's/.*"error":\{[^}]*"psnr_db":([0-9.]+).*/\1/')
awk -v a="$(sed -n 2p three.csv | cut -d, -f9)" -v b="$psnr" 'BEGIN { exit !(a - b < 0.001 && b - a < 0.001) }' || fail "PSNR is not $psnr"
same three/run_*.png frames/frame_0000.png
has three/index.html '<title>mk2 / clock 2650000: '
has three/index.html '<a href="run_[0-9a-f]*.png"><circle'
if grep -q '<script' three/index.html; then fail "the page has a script"; fi

# --- capacities, programs and machines; losses are marked --------------------------------------------
cat >many.json <<'JSON'
{"size": [160, 90], "machines": ["mk2.txt", {"file": "mk2.txt", "sram": [262144, 400000]}, "scamp5.txt", "mk1.txt"], "grid": [20, 18],
 "programs": ["anchored", "homes"], "sizes": ["preset", {"channel": [20, 60], "waiting": 20, "storage": "the rest"}, {"channel": 20, "waiting": 20, "storage": 300}]}
JSON
explores many.json --csv many.csv --out many --threads 2
equal "points" "$(wc -l <many.csv)" 41
has many.csv '^scamp-5 / anchored / preset,.*does not fit'
has many.csv '^mk1 / anchored / preset,.*,"barrier, vote, exchange_start",'
# A tile of 300 slots loses records, and neither the table nor the page hides it.
awk -F, '$1 == "mk2 / anchored / channel 20 waiting 20 storage 300" { exit !($14 > 0) }' many.csv || fail "300 slots lose nothing"
awk -F, 'NR > 1 && $14 > 0 && ($23 == 1 || $24 == 1) { bad = 1 } END { exit bad }' many.csv || fail "a point that loses something is on the front"
has many/index.html 'loses [0-9,]*'
has many/index.html 'at least: without barrier'
has many/index.html 'does not fit'
# A number of slots that does not fit is refused in both programs, and "the rest" of too small a tile is no number.
has many.csv '^scamp-5 / homes / channel 20 waiting 20 storage 300,.*does not fit'
has many.csv '^scamp-5 / homes / channel 20 waiting 20 storage the rest,.*does not fit'
if grep -qE '4294967295|2147483647' many.csv; then fail "a size that nobody asked for: $(grep -E '4294967295|2147483647' many.csv | head -n 1)"; fi
# Of one anchored setting with the rest of the SRAM, one more slot would not fit.
name='mk2 sram 262144 / anchored / channel 60 waiting 20 storage the rest'
awk -F, -v name="$name" '$1 == name { exit !($12 <= 262144 && $12 + 136 > 262144) }' many.csv || fail "the rest of the SRAM: $(grep "$name" many.csv)"
explores many.json --csv one.csv --out one --threads 1
same many.csv one.csv

cat >beam.json <<'JSON'
{"size": [80, 48], "machines": ["mk2.txt"], "sizes": [{"road": 20, "beam": 40}]}
JSON
explores beam.json --csv beam.csv --out beam
equal "road and beam" "$(awk -F, 'NR == 2 { print $21, $(NF - 3) }' beam.csv)" "20 40"
has beam/index.html '/ 20 and 40 / '
cat >large.json <<'JSON'
{"size": [160, 90], "machines": ["mk2.txt"], "grid": [20, 18], "programs": ["anchored", "homes"], "sizes": [{"channel": 20, "waiting": 20, "storage": 90000}]}
JSON
explores large.json --csv large.csv --out large
has large.csv '/ homes.*storage 90000 of homes on machine mk2 (a tile has room for '
has large.csv '/ anchored.*does not fit'

# Maps are not compared with each other: each has its front.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n'
} >one.ply
cat >maps.json <<'JSON'
{"maps": ["built-in", "one.ply"], "size": [80, 48], "views": {"frames": 2, "degrees": 1}, "machines": ["mk2.txt"], "programs": ["homes"],
 "costs": ["machine", {"exchange_byte": 125}, {"exchange_byte": 500}]}
JSON
explores maps.json --csv maps.csv --out maps
equal "points on a front" "$(awk -F, '$23 == 1 { print $2 }' maps.csv | tr '\n' ' ')" "built-in one "
has maps/index.html 'The front of one'
"$render_map" one.ply --size 80x48 --orbit 1 --frames 2 --machine mk2.txt --program homes --trace t --quiet --out o --report o.json >log 2>&1 || fail "render_map: $(cat log)"
equal "cycles of two frames" "$(awk -F, 'NR == 5 { print $11 }' maps.csv)" "$(($(counter o.json cycles 0) + $(counter o.json cycles 1)))"

# --- the studies of the README, with a map of one ball in the place of each, and small pictures --------
# study_of NAME: the block below `<!-- study NAME -->`, with pictures of 80 x 48.
study_of() {
    awk -v mark="<!-- study $1 -->" '$0 == mark { on = 1; next } on && /^```/ { if (inside) exit; inside = 1; next } inside' "$readme" |
        sed '1s/{/{"size": [80, 48], /' >"$1.json"
    [ "$(wc -l <"$1.json")" -ge 2 ] || fail "the README has no study $1"
}
readme=$machines/../README.md
mkdir -p examples/machines
cp ./*.txt examples/machines
for map in salad sloth room; do cp one.ply $map.ply; done
comma=
printf '{"cameras": [' >cameras.json
for scene in salad sloth; do
    printf '%s{"scene": "%s", "name": "front", "width": 1280, "height": 720, "fx": 900, "fy": 900, "cx": 640, "cy": 360,
      "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, %d], [0, 0, 0, 1]]}' "$comma" $scene $((${#comma} + 1)) >>cameras.json
    comma=,
done
printf ']}\n' >>cameras.json
for name in split links ten; do
    study_of $name
    explores $name.json --csv $name.csv --out $name
done
equal "points of a split" "$(wc -l <split.csv)" 19
equal "splits with losses or refused" "$(awk -F, 'NR > 1 && $14 != 0 { n++ } END { print n + 0 }' split.csv)" 0
equal "runs of a split" "$(ls split/run_*.png | wc -l)" 18
equal "points of links" "$(wc -l <links.csv)" 9
equal "runs of links" "$(ls links/run_*.png | wc -l)" 4
awk -F, '/^[a-z-]* \/ mk2,/ { before = $10 } / twice the links,/ { n += $10 < before && $10 > before / 2 } END { exit n != 4 }' links.csv || fail "twice the links do not pay"
equal "machines" "$(cut -d, -f3 ten.csv | sort -u | wc -l)" 11
has ten.csv '^mk2 sram 262144 exchange 8,'
# Which camera shows which map stands in the table, on the page, in the terminal.
has links.csv '^salad / mk2,.*,"camera salad/front of cameras.json, 3 frames around the map.s middle",'
has links.csv '^sloth / mk2,.*,"camera sloth/front of cameras.json, 3 frames'
has links.csv '^room / mk2,.*,"a guessed camera, along +z at the whole map, 3 frames'
has links.csv "^built-in / mk2,.*,\"the built-in map's camera, 3 frames"
has links/index.html 'camera sloth/front of cameras.json, 3 frames'
run links.json --csv links.csv --out links >stdout 2>stderr || fail "status $?"
has stdout '^the front of sloth (camera sloth/front of cameras.json, 3 frames'
# The first frame is the one in which the records find their tiles; the mean of all is that of the first and the others.
fields() { awk -F, -v name="$1" '$1 == name { print $10, $25, $26 }' links.csv; }
fields 'built-in / mk2' | awk '{ exit !($2 > $3 && $1 * 3 > ($2 + 2 * $3) * 0.999999 && $1 * 3 < ($2 + 2 * $3) * 1.000001) }' || fail "times of frames: $(fields 'built-in / mk2')"
equal "a single frame" "$(awk -F, 'NR == 2 { print ($10 == $25) $26 }' ten.csv)" 1
# One map in two views is two maps with names; each camera has its picture.
cat >views.json <<'JSON'
{"size": [80, 48], "machines": ["mk2.txt"], "programs": ["homes"], "views": {"cameras": "cameras.json"},
 "maps": [{"file": "one.ply", "name": "near", "camera": "salad/front"}, {"file": "one.ply", "name": "far", "camera": "sloth/front"}]}
JSON
explores views.json --csv views.csv --out views
equal "views" "$(cut -d, -f2 views.csv | tr '\n' ' ')" "map near far "
equal "pictures of views" "$(ls views/run_*.png | wc -l)" 2
equal "labels of views" "$(awk -F, 'NR > 1 { print $(NF - 2) }' views.csv | tr '\n' ' ')" "camera salad/front of cameras.json camera sloth/front of cameras.json "
# What a knee and its gain are stands where they are named.
cat >knee.json <<'JSON'
{"size": [160, 90], "machines": [{"file": "mk2.txt", "sram": [200000, 230000, 262144, 300000, 400000]}], "grid": [20, 18], "programs": ["homes"]}
JSON
run knee.json --csv knee.csv --out knee >stdout 2>stderr || fail "status $?"
has stdout '^The knee, where more time buys less SRAM, is mk2 sram '
for place in stdout knee/index.html "$readme"; do has "$place" 'more time stops to buy much'; done

# --- small machines: what happens, in words of a study -------------------------------------------------
cat >small.json <<'JSON'
{"size": [160, 90], "machines": [{"file": "mk2.txt", "sram": [150000, 140000]}, {"file": "mk2.txt", "workers": 7}], "grid": [20, 18], "programs": ["anchored", "homes"]}
JSON
explores small.json --csv small.csv --out small
has small.csv '^mk2 sram 140000 / anchored,.* slots hold 9720); name more slots of ""storage"" in ""sizes"", a larger ""grid"" or a machine with more ""sram"""$'
has small.csv '^mk2 sram 150000 / homes,.*preset lossless of homes on machine mk2 sram 150000 (256 slots of storage, the fewest that are chosen unasked, are [0-9,]* bytes over beside [0-9]* homes and channels of 4 slots); name a number of ""storage"" in ""sizes"", as [0-9]* '
has small.csv '^mk2 workers 7 / anchored,.* 7 workers (a tile counts the work of 1 to 6); give the machine 1 to 6 workers$'
has small.csv '^mk2 workers 7 / homes,.* 7 workers (a tile counts the work of 1 to 6); give the machine 1 to 6 workers$'
# An advice helps: the number of storage that is named runs, and one slot of each list fits where fewer slots are advised.
storage=$(sed -nE 's/^mk2 sram 150000 \/ homes,.* in ""sizes"", as ([0-9]+),? .*/\1/p' small.csv)
cat >helped.json <<JSON
{"size": [160, 90], "machines": [{"file": "mk2.txt", "sram": 150000}], "grid": [20, 18], "programs": ["homes"], "sizes": {"storage": ${storage:-0}}}
JSON
explores helped.json --csv helped.csv --out helped
equal "what the advice brings" "$(awk -F, 'NR == 2 { print $14, $20 }' helped.csv)" "0 $storage"
has many.csv '^scamp-5 / anchored / channel.*); name a machine with more ""sram"" than [0-9,]* bytes: one slot of each list takes these, and a picture several times as many"$'
has many.csv '^scamp-5 / homes / channel.*); name a machine with more ""sram"" than [0-9,]* bytes: one slot of each list takes these, and a picture several times as many"$'
cat >fewer.json <<'JSON'
{"size": [160, 90], "machines": [{"file": "mk2.txt", "sram": 150000}], "grid": [20, 18], "programs": ["anchored", "homes"],
 "sizes": [{"channel": 4000, "storage": 1}, {"channel": 1, "waiting": 1, "storage": 1}]}
JSON
explores fewer.json --csv fewer.csv --out fewer
equal "fewer slots are advised" "$(grep -c '/ channel 4000 storage 1,.*does not fit.*; name fewer slots in ""sizes"", or a machine' fewer.csv)" 2
if grep '/ channel 1 waiting 1 storage 1,' fewer.csv | grep -q 'does not fit'; then fail "one slot of each list does not fit: $(cat fewer.csv)"; fi
if grep -nE '::|set_price|max_workers|choose more slots|give it fewer' ./*.csv; then fail "an advice for programmers"; fi

# A wafer has too many tiles for a point: other machines of the study run, and so does a part of it.
cat >wafer.json <<'JSON'
{"size": [80, 48], "machines": ["gpu_sm.txt", "wse2.txt", {"file": "wse2.txt", "name": "part", "columns": 40, "rows": 24}], "programs": ["homes"]}
JSON
explores wafer.json --csv wafer.csv --out wafer
has wafer.csv '^wse-2,.*,"a grid of [0-9]* x [0-9]* tiles (machine wse-2; explore takes at most 262,144); give the machine fewer ""columns"" and ""rows"", or all machines a smaller ""grid"""$'
equal "points that run" "$(awk -F, 'NR > 1 && $14 == "0" { print $1 }' wafer.csv | tr '\n' ' ')" "gpu-sm part "

# --- a preset that fits keeps its sizes; what is full has no rounding; prices and bytes say of what kind they are ------
cat >fits.json <<'JSON'
{"size": [160, 90], "machines": [{"file": "mk2.txt", "sram": [420000, 524288]}, "gpu_sm.txt"], "grid": [10, 9], "programs": ["homes"],
 "sizes": ["preset", {"channel": [20, 21, 22], "waiting": 20, "storage": "the rest"}, {"road": 20, "storage": 100}]}
JSON
run fits.json --csv fits.csv --out fits >stdout 2>stderr || fail "status $?"
# name FIELD of a point of fits.csv
field() { awk -F, -v name="$1" -v field="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == field) column = i; next } $1 == name { print $column }' fits.csv; }
equal "slots that fit" "$(field 'mk2 sram 524288 / preset' storage) $(field 'mk2 sram 524288 / preset' channel) $(field 'mk2 sram 524288 / preset' waiting)" "2800 120 120"
"$render_map" --size 160x90 --grid 10x9 --machine mk2.txt --program homes --fit off --quiet --out frames --report f.json >log 2>&1 || fail "render_map: $(cat log)"
equal "bytes that stay free" "$(field 'mk2 sram 524288 / preset' free_bytes)" "$((524288 - $(counter f.json budgeted_bytes 0)))"
[ "$(field 'mk2 sram 420000 / preset' channel)" -lt 120 ] || fail "channels do not shrink"
for channel in 20 21 22; do
    equal "a full tile" "$(field "mk2 sram 420000 / channel $channel waiting 20 storage the rest" sram_bytes)" 420000
    equal "of a full tile" "$(field "mk2 sram 420000 / channel $channel waiting 20 storage the rest" free_bytes)" 0
done
equal "bytes of mk2" "$(field 'mk2 sram 420000 / preset' bytes_of)" channels
equal "bytes of a GPU" "$(field 'gpu-sm / road 20 storage 100' bytes_of)" messages
has stdout ' ms ([0-9.]* % guessed), [0-9,]* bytes of SRAM a tile ([0-9,]* free), [0-9,]* bytes exchanged '
has fits.csv '^mk2 sram 420000 / preset,.*,"guessed: [a-z_, ]*",0,'
has fits/index.html '[0-9.]* % guessed: [a-z_, ]*'
has fits/index.html 'the front compares only bytes of one kind'

# --- bytes: with the heads of channel ends on every machine, as tiles.csv and the prices have them --------------
cat >bytes.json <<'JSON'
{"size": [80, 48], "grid": [10, 9], "machines": ["gpu_sm.txt"], "programs": ["homes"]}
JSON
explores bytes.json --csv bytes.csv --out bytes
"$render_map" --size 80x48 --grid 10x9 --machine gpu_sm.txt --trace sent --trace-tiles --fit off --program homes --quiet --out frames --report b.json >log 2>&1 ||
    fail "render_map: $(cat log)"
sent=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i ~ /^(north|east|west|south)_bytes$/) column[i] = 1; next } { for (i in column) n += $i } END { printf "%d", n }' sent/frame_0000.tiles.csv)
equal "bytes sent" "$(sed -n 2p bytes.csv | cut -d, -f13)" "$sent"
[ "$sent" -gt "$(counter b.json live 0)" ] || fail "no heads in $sent bytes"

# --- a run that goes on ------------------------------------------------------------------------------
run three.json --csv again.csv --out three >stdout 2>stderr || fail "status $?"
has stderr '^3 points: 3 from an earlier run, 0 runs for 0 points'
same three.csv again.csv
head -n 20 many/points.jsonl >kept
echo '{"digest": "half a li' >>kept
mkdir half
cp many/run_*.png half
cp kept half/points.jsonl
run many.json --csv half.csv --out half >stdout 2>stderr || fail "status $?"
has stderr '^40 points: 20 from an earlier run'
same many.csv half.csv
# Another price is another point: it is priced anew, and the other two stay.
sed 's/125/126/' three.json >other.json
run other.json --csv other.csv --out three >stdout 2>stderr || fail "status $?"
has stderr '^3 points: 2 from an earlier run, 1 runs for 1 points'

# --- what it refuses ---------------------------------------------------------------------------------
refuses 'no study is named'
refuses 'no table is named' three.json
refuses 'no folder is named' three.json --csv a.csv
refuses 'there is no option' three.json --csv a.csv --out a --thread 2
refuses 'from 1 to 1024' three.json --csv a.csv --out a --threads 0
refuses "cannot read the study's file" none.json --csv a.csv --out a
# bad TEXT PATTERN
bad() {
    printf '%s\n' "$1" >bad.json
    refuses "$2" bad.json --csv a.csv --out a
    [ ! -e a.csv ] || fail "a refused study wrote a table"
}
bad '{"machines": ["mk2.txt"' 'bad.json is no JSON (line 2'
bad '[]' 'is no object'
bad '{}' 'has no machines'
bad '{"machines": [], "size": [64, 48]}' 'is an empty list'
bad '{"machines": ["mk2.txt"], "machine": 1}' 'has an unknown key "machine"'
bad '{"machines": ["none.txt"]}' 'cannot read the machine'
bad '{"machines": [{"sram": 1}]}' 'names no machine'
bad '{"machines": [{"file": "mk2.txt", "sarm": 1}]}' 'a machine has no number "sarm"'
bad '{"machines": [{"file": "mk2.txt", "sram": "lots"}]}' 'has no sram "lots"'
bad '{"machines": ["mk2.txt", "mk2.txt"]}' 'has two points "mk2"'
bad '{"machines": ["mk2.txt"], "size": [64]}' 'is no list of two numbers'
bad '{"machines": ["mk2.txt"], "size": [0, 48]}' 'is no whole number from 1 to 65535'
bad '{"machines": ["mk2.txt"], "programs": ["auto"]}' 'cannot be "auto"'
bad '{"machines": ["mk2.txt"], "sizes": [{"chanel": 3}]}' 'has an unknown key "chanel"'
bad '{"machines": ["mk2.txt"], "sizes": [{"storage": "half"}]}' 'or "the rest"'
bad '{"machines": ["mk2.txt"], "costs": [{"warp": 3}]}' 'a cost model has no parameter "warp" .*vote); write a parameter and a value'
bad '{"machines": ["mk2.txt"], "costs": [{"exchange_cost": 3}]}' 'parameter exchange_cost cannot be 3'
bad '{"machines": ["mk2.txt"], "maps": [{"camera": "a"}]}' 'maps\[0\] names no map'
bad '{"machines": ["mk2.txt"], "maps": [{"file": "one.ply", "trun": "x90"}]}' 'has an unknown key "trun"); use turn, or another of file'
bad '{"machines": ["mk2.txt"], "maps": [{"file": "one.ply", "turn": "x45"}]}' 'cannot be "x45"); write another value: there are x90'
bad '{"machines": ["mk2.txt"], "views": {"scale": 2}}' 'is no key of a map); all maps of a study have its size'
bad '{"machines": ["mk2.txt"], "maps": [{"file": "one.ply", "camera": "a"}]}' 'has a camera without cameras'
bad '{"machines": ["mk2.txt"], "maps": [{"file": "one.ply", "frames": 2}]}' 'has an unknown key "frames"'
bad '{"machines": ["mk2.txt"], "maps": [{"file": "one.ply", "cameras": "cameras.json"}]}' 'no camera belongs to map "one"'
bad '{"machines": ["mk2.txt"], "costs": ["mk2.txt"]}' 'begins no cost model'
bad '{"machines": ["mk2.txt"], "costs": [{"exchange": 8}]}' 'write "exchange_byte"'
bad '{"machines": ["mk2.txt"], "maps": ["none.ply"]}' 'none.ply'
cp three.json study.json
refuses 'the table' study.json --csv study.json --out a
refuses 'the table' three.json --csv mk2.txt --out a
same "$machines/mk2.txt" mk2.txt
same three.json study.json

# --- a signal ----------------------------------------------------------------------------------------
cat >long.json <<'JSON'
{"size": [640, 360], "machines": ["mk2.txt"], "sizes": [{"channel": [10, 20, 30, 40, 50, 60, 70, 80, 90, 100], "storage": [900, 1000, 1100, 1200]}]}
JSON
if env --default-signal=TERM true 2>/dev/null; then
    env --default-signal=TERM "$program" long.json --csv long.csv --out long </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until grep -q '^run 1 of' stderr || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s TERM $pid
    wait $pid
    equal "the status after SIGTERM" $? 143
    has stderr '^interrupted after [0-9]* of 40 points (SIGTERM); the same command goes on$'
    [ ! -e long.csv ] || fail "an interrupted study wrote a table"
    equal "the points" "$(wc -l <long/points.jsonl)" "$(sed -nE 's/^interrupted after ([0-9]+) .*/\1/p' stderr)"
else
    skip "env cannot give SIGTERM back"
fi
has_no_parts .
finish

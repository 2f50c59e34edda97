#!/bin/sh
# usage: bench_paper.sh PROGRAM [DATA]    (the environment variable TILEMESH_DATA wins)
# Runs the paper's tables quickly on the built-in map, without data: every row of the CSV has its table, row, quantity and kind and the
# ratio of its two figures, what must hold does, the arithmetic has known answers, and results do not depend on threads. With DATA, a
# folder with the map of Sloth, the six counts of the churn table are the paper's. What is no option or no table is refused with one line.
set -eu
export LC_ALL=C
program=$1
data=${TILEMESH_DATA:-${2:-}}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
complain() { echo "$*" && failed=1; }

tables="memory host_io power fps load stage churn saturation convergence"
chosen=
for table in $tables; do chosen="$chosen --table $table"; done
# shellcheck disable=SC2086
for threads in 1 2; do
    TILEMESH_DATA=$folder/none "$program" --quick --threads $threads $chosen --csv "$folder/$threads.csv" --out "$folder/out$threads" \
        >"$folder/$threads.txt" 2>"$folder/progress" || complain "the run with $threads threads ended with $?"
done
cmp -s "$folder/1.csv" "$folder/2.csv" || complain "the CSV depends on the number of threads"
[ "$(head -1 "$folder/1.csv")" = table,row,quantity,paper,ours,ratio,kind,how,note ] || complain "the CSV begins with $(head -1 "$folder/1.csv")"
grep -q '^BROKEN' "$folder/1.txt" && complain "something is broken: $(grep '^BROKEN' "$folder/1.txt")"
for table in $tables; do grep -q "^$table," "$folder/1.csv" || complain "no row of $table"; done
for file in memory.svg load_built_in.png saturation_400.png saturation_100.png; do
    [ -s "$folder/out1/$file" ] || complain "no $file"
done

# A field in quotes may hold commas: they are replaced first.
plain() { awk '{ out = ""; inside = 0; for (i = 1; i <= length($0); ++i) { c = substr($0, i, 1); if (c == "\"") inside = !inside; else out = out (inside && c == "," ? ";" : c) } print out }' "$1"; }
plain "$folder/1.csv" >"$folder/plain.csv"
awk -F, '
    NR == 1 { next }
    NF != 9 { print "row " NR " has " NF " fields of 9"; bad = 1 }
    $1 == "" || $2 == "" || $3 == "" || $7 == "" { print "row " NR " lacks a name or a kind"; bad = 1 }
    $5 == "" && $9 !~ /^skipped: |; skipped: / { print "row " NR " has no figure of ours and does not say why"; bad = 1 }
    { both = $4 != "" && $5 != "" && $4 != 0 }
    $7 !~ /^(measured|modelled|fitted|null_model|no_figure)$/ || ($4 == "") != ($7 == "no_figure") { print "row " NR " is of kind " $7; bad = 1 }
    seen[$1 "," $2 "," $3 "," $7]++ { print "row " NR " is there twice: " $1 ", " $2 ", " $3; bad = 1 }
    both != ($6 != "") { print "row " NR " has a ratio without two figures, or none with them"; bad = 1 }
    both { d = $6 * $4 - $5; if (d < 0) d = -d; e = $5 < 0 ? -$5 : $5; if (d > 1e-4 * e + 1e-9) { print "row " NR ": " $5 " over " $4 " is not " $6; bad = 1 } }
    END { exit bad }' "$folder/plain.csv" || complain "bad rows in the CSV"

# What is known without any machine: table, row, quantity, ours.
known() {
    awk -F, -v t="$1" -v r="$2" -v q="$3" -v wanted="$4" '
        $1 == t && $2 == r && $3 == q { found = 1; if ($5 + 0 != wanted + 0) { print t ", " r ", " q " is " $5 ", not " wanted; bad = 1 } }
        END { if (!found) { print "no row " t ", " r ", " q; bad = 1 } exit bad }' "$folder/plain.csv" || complain "a known answer is wrong"
}
known memory sloth model_mb 1.50966
known memory a_channel slots_as_the_authors_code_strides 100
known memory storage slots_as_the_authors_code_strides 800
known host_io a_frame_out rgbx8_bytes 3686400
known convergence 40_x_36_tiles bound_on_routing_dx_dy 74

if [ -n "$data" ] && [ -f "$data/maps/sloth.ply" ]; then
    # The same data, but a recorded path of one pose: nothing can be counted between frames.
    data=$(cd "$data" && pwd)
    mkdir -p "$folder/one/trajectories"
    ln -s "$data/maps" "$data/cameras.json" "$folder/one/"
    echo "0 0 0 0 0 0 0 1" >"$folder/one/trajectories/sloth_teleport.tum"
    "$program" --quick --data "$folder/one" --table churn --csv "$folder/churn.csv" >"$folder/churn.txt" 2>"$folder/progress" ||
        complain "the churn table ended with $?"
    awk -F, '$3 == "moved" && $4 != "" { ++n; if ($6 < 0.99 || $6 > 1.01) { print $2 ": " $5 " for " $4; bad = 1 } }
        END { if (n != 6) { print n " motions, not 6"; bad = 1 } exit bad }' "$folder/churn.csv" || complain "churn is not the paper's"
    grep -q '^churn,recorded_teleport,moved,,,,no_figure,counted,"skipped: sloth_teleport.tum has 1 poses,' "$folder/churn.csv" ||
        complain "a path of one pose is not skipped: $(grep recorded_teleport "$folder/churn.csv")"
    grep -q '^churn,recorded_orbit_0.5_deg,moved,,,,no_figure,counted,skipped: sloth_orbit.tum is not there$' "$folder/churn.csv" ||
        complain "a path that is not there is not skipped: $(grep recorded_orbit "$folder/churn.csv")"
    grep -qF "$folder" "$folder/churn.csv" && complain "the CSV names a folder of this machine"
else
    echo "skipped: the churn of Sloth (its map is not there)"
fi

for wrong in --no-such-option "--table none" "--threads 0" "--out"; do
    status=0
    # shellcheck disable=SC2086
    "$program" $wrong >"$folder/refused" 2>&1 || status=$?
    [ $status -eq 2 ] || complain "$wrong ended with $status, not 2"
    [ "$(grep -c . "$folder/refused")" -eq 1 ] || complain "$wrong gives $(grep -c . "$folder/refused") lines, not 1"
done
exit $failed

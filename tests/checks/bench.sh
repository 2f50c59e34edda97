#!/bin/sh
# usage: bench.sh PROGRAM CSV COLUMNS [OPTION...]
# Runs a bench quickly, and with the options too where there are some: its checks hold, its CSV begins with COLUMNS and every row
# has a value in each; with --spoil its checks fail; what is no option is refused with one line.
set -eu
export LC_ALL=C
program=$1 csv=$2 columns=$3
shift 3
failed=0
complain() { echo "$*" && failed=1; }

rm -f "$csv"
"$program" --quick --csv "$csv" || complain "the quick run ended with $?"
if [ $# -gt 0 ]; then "$program" --quick "$@" || complain "the quick run with $* ended with $?"; fi
case $(head -1 "$csv") in
"$columns" | "$columns,"*) ;;
*) complain "the first line of $csv does not begin with $columns" ;;
esac
# fma_gflops and what is made of it is empty for targets whose peak is not measured.
awk -F, -v wanted="$(echo "$columns" | tr ',' '\n' | grep -c .)" '
    NR == 1 { n = NF; for (i = 1; i <= NF; ++i) name[i] = $i; next }
    NF != n { print "row " NR " has " NF " fields of " n; bad = 1 }
    {
        for (i = 1; i <= wanted; ++i) {
            if (name[i] ~ /gflops|roofline/) continue
            if ($i == "" || (name[i] ~ /_ms$|^pairs|^bytes|^threads/ && !($i + 0 > 0))) { print "row " NR ": " name[i] " is \"" $i "\""; bad = 1 }
        }
    }
    END { if (NR < 2) { print "no rows"; bad = 1 } exit bad }' "$csv" || complain "bad rows in $csv"

status=0
"$program" --quick --spoil >"$csv.spoilt" 2>&1 || status=$?
[ $status -eq 1 ] || complain "with --spoil the run ended with $status, not 1"
grep -q '^BROKEN: ' "$csv.spoilt" || complain "with --spoil nothing is said to be broken"

status=0
"$program" --no-such-option >"$csv.refused" 2>&1 || status=$?
[ $status -eq 2 ] || complain "an unknown option ended with $status, not 2"
[ "$(grep -c . "$csv.refused")" -eq 1 ] || complain "an unknown option gives $(grep -c . "$csv.refused") lines, not 1"
exit $failed

#!/bin/sh
# What bench/silicon says of traces: of two that are made here, by hand; of the measured ones where TILEMESH_DATA has them.
# Usage: sh silicon.sh PATH_TO_silicon
set -u
LC_ALL=C
export LC_ALL
case $1 in /*) program=$1 ;; *) program=$PWD/$1 ;; esac
table=$(cd "$(dirname "$0")/../../bench/silicon" && pwd)/judges.csv || exit 1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failed=0
fail() { echo "FAILED: $*" && failed=1; }

mkdir traces
# read STAMP SX SY DX DY BYTES: core (SX, SY) reads from (DX, DY) over NOC_0.
read_at() {
    printf ',{"proc": "NCRISC", "noc": "NOC_0", "vc": -1, "sx": %s, "sy": %s, "dx": %s, "dy": %s, "num_bytes": %s, "type": "READ", "timestamp": %s}\n' \
        "$2" "$3" "$4" "$5" "$6" "$1"
}
end_at() { printf ',{"proc": "NCRISC", "noc": "NOC_0", "sx": 1, "sy": 1, "dx": -1, "dy": -1, "num_bytes": 0, "type": "READ_BARRIER_END", "timestamp": %s}]\n' "$1"; }
zone='[{"proc": "", "zone": "KERNEL", "zone_phase": "begin", "sx": 1, "sy": 1, "timestamp": 1000}'
# One read of 2,048 bytes by (3, 1) from (1, 1): two links there, eight back. 2,080 bytes with the head take 65 cycles.
{ echo "$zone" && read_at 1000 3 1 1 1 2048 && end_at 1500; } >traces/one.json
# Two reads of a core from DRAM (0, 1): 2 x 2,080 bytes over 24 bytes a cycle are 173.3 cycles; 2 x 127 cycles of issue are more.
{ echo "$zone" && read_at 1100 1 1 0 1 2048 && read_at 1300 1 1 0 1 2048 && end_at 1900; } >traces/two.json
"$program" --traces traces --csv out.csv >stdout || fail "status $?"
start=$((9 * 10 + 270))
grep -qx "one,500,$((127 + start)),65,$((127 + start)),1,2048,issue 0" out.csv || fail "one: $(grep one out.csv)"
grep -qx "two,800,$((254 + start)),174,$((254 + start)),2,4096,issue 0" out.csv || fail "two: $(grep two out.csv)"
grep -q "^bound by: issue 2$" stdout || fail "bound by: $(grep bound stdout)"

# A time that no link allows.
{ echo "$zone" && read_at 1000 3 1 1 1 2048 && end_at 1064; } >traces/fast.json
"$program" --traces traces >stdout && fail "a measured time below the bound passes"
grep -q "^BROKEN: a bound of documented rates is above a measured time$" stdout || fail "nothing is said to be broken"
rm traces/fast.json

refuses() {
    pattern=$1
    shift
    "$program" "$@" >stdout 2>stderr
    [ $? -eq 2 ] || fail "status is not 2: $*"
    [ "$(wc -l <stderr)" -eq 1 ] && grep -q "^[^(].* (.*); .*" stderr && grep -q "$pattern" stderr || fail "$*: $(cat stderr)"
}
mkdir empty
refuses "no traces to judge by"
refuses "no .json file in absent" --traces absent
refuses "no .json file in empty" --traces empty
for text in '' '{}' '[' '[{"timestamp": 1, "type": "READ_BARRIER_END"}]' '[{"timestamp": "x", "type": 5}]'; do
    printf '%s' "$text" >empty/bad.json
    refuses "trace bad cannot be used" --traces empty
done
{ echo "$zone" && read_at 1000 30 1 1 1 2048 && end_at 1500; } >empty/bad.json
refuses "a transfer at node (30, 1)" --traces empty

# Published measurements: four rows by hand. A read of the next node takes 12 hops there and back; 24,000 bytes take 6,000 cycles of Mk2.
columns=machine,figure,measured,unit,phase,missing,source
{
    echo "$columns"
    echo "Wormhole,a,505,cycles,pair read straight 1 64,,hand"
    echo "Blackhole,b,392,cycles,pair write straight 4 1024,,hand"
    echo "C600,c,0.005,ms,compiled 24000,lookups,hand"
    echo "CS-1,d,6,cycles a hop,reduce 602 595,forward,hand"
    echo "CS-3,f,2,cycles,wafer hop,wafer,hand"
    echo "CS-3,g,1.25,cycles,wafer word,,hand"
    echo "GC200,e,2,ms,stage sloth route_mean_ms,stages,hand"
} >judges.csv
{ echo "table,row,quantity,paper,ours,ratio,kind,how,note" && echo "stage,sloth,route_mean_ms,2,3,1.5,modelled,predicted,n" &&
    echo "stage,sloth,route_mean_ms,2,9,1.5,null_model,null model,n"; } >paper.csv
"$program" --judges judges.csv --paper paper.csv --csv judged.csv >stdout || fail "judges: status $?"
for row in "Wormhole,a,505.0,cycles,$((127 + 12 * 9 + 270)),1.000,3.0000,issue,,hand" \
    "Blackhole,b,392.0,cycles,$((4 * 17 + 12 * 9 + 20)),0.500,68,port out,,hand" \
    "C600,c,0.0050,ms,0.0048,0.951,,port in,the program looks up 400 records a tile: instructions that no document prices; there is no host copy in it,hand" \
    "CS-1,d,6.0000,cycles a hop,12,2.000,,hops,our Reduce wakes a core on each hop and ends in a corner; the wafer's routers forward in one cycle to its middle,hand" \
    "CS-3,f,2.0000,cycles,1.0000,0.500,,hops,the price is that of documents about the first wafer; measured was the third,hand" \
    "CS-3,g,1.2500,cycles,1.0000,0.800,,link,,hand" \
    "GC200,e,2.0000,ms,3.0000,1.500,,compute,a price of Sort that explains its mean and its slowest tile,hand"; do
    grep -qxF "$row" judged.csv || fail "judges: no line $row in $(cat judged.csv)"
done
"$program" --judges judges.csv >stdout || fail "judges without --paper: status $?"
awk '$1 == "GC200" && $2 == 0 && $3 == 1 { found = 1 } END { exit !found }' stdout || fail "a row without a prediction is not skipped: $(cat stdout)"
sed 's/505/2/' judges.csv >fast.csv
"$program" --judges fast.csv >stdout && fail "a published time below the bound passes"
grep -q "^BROKEN: a bound of documented rates is above a measured time$" stdout || fail "nothing is said to be broken"
for line in "Wormhole,a,505,cycles,pair read straight 1 64,hand" "Wormhole,a,0,cycles,pair read straight 1 64,,hand" "Wormhole,a,x,cycles,reduce 2 2,,hand" \
    "Wormhole,a,5,cycles,pair read straight 1,,hand" "Wormhole,a,5,cycles,pair read straight 1 0,,hand" "CS-3,a,2,cycles,wafer turn,,hand" "Wormhole,a,5,cycles,pair look straight 1 64,,hand" \
    "Epiphany,a,5,cycles,pair read straight 1 64,,hand" "Wormhole,a,5,cycles,guess,,hand" "Wormhole,a,5,cycles,reduce 2 2,,"  "Wormhole,a,5,cycles,reduce 2 2,why,hand"; do
    { echo "$columns" && echo "$line"; } >wrong.csv
    refuses "^line 2 of the measurements cannot be used" --judges wrong.csv
done
echo "$line" >wrong.csv
refuses "^line 1 of the measurements cannot be used" --judges wrong.csv
refuses "nothing to read" --judges absent.csv
refuses "no measurements to judge by" --traces traces --paper paper.csv
# The table of the bench: at least 100 measurements of three machines, each with what bounds it.
"$program" --judges "$table" --csv judged.csv >stdout || fail "the bench's table: status $?: $(grep BROKEN stdout)"
awk -F, 'NR > 1 && $8 != "skipped" { ++rows; if ($8 == "" || $10 == "") bad = 1; if (!($1 in seen)) { seen[$1]; ++machines } }
    END { exit !(rows >= 100 && machines >= 3 && !bad) }' judged.csv || fail "the bench's table has too few rows"
# Transfers of 4 KiB and more are right on both chips.
awk '($1 == "Wormhole" || $1 == "Blackhole") && $2 >= 4096 { ++n; if ($5 > 10) bad = 1 } END { exit !(n == 4 && !bad) }' stdout ||
    fail "large transfers are predicted worse than they were: $(cat stdout)"

if [ -d "${TILEMESH_DATA:-}/noc" ]; then
    "$program" --traces "$TILEMESH_DATA/noc" >stdout || fail "measured traces: status $?"
    awk '/in rounds: the prediction/ { found = 1; if ($5 > 4 || $7 > 13 || $9 / $11 < 0.98) bad = 1 } END { exit !found || bad }' stdout ||
        fail "the prediction is worse than it was: $(grep prediction stdout)"
else
    echo "skipped: TILEMESH_DATA has no measured traces"
fi
[ $failed -eq 0 ] && echo "silicon: all good"
exit $failed

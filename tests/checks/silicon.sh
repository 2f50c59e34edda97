#!/bin/sh
# What bench/silicon says of traces: of two that are made here, by hand; of the measured ones where TILEMESH_DATA has them.
# Usage: sh silicon.sh PATH_TO_silicon
set -u
LC_ALL=C
export LC_ALL
case $1 in /*) program=$1 ;; *) program=$PWD/$1 ;; esac
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

if [ -d "${TILEMESH_DATA:-}/noc" ]; then
    "$program" --traces "$TILEMESH_DATA/noc" >stdout || fail "measured traces: status $?"
    awk '/in rounds: the prediction/ { found = 1; if ($5 > 4 || $7 > 13 || $9 / $11 < 0.98) bad = 1 } END { exit !found || bad }' stdout ||
        fail "the prediction is worse than it was: $(grep prediction stdout)"
else
    echo "skipped: TILEMESH_DATA has no measured traces"
fi
[ $failed -eq 0 ] && echo "silicon: all good"
exit $failed

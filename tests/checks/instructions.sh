#!/bin/sh
# usage: instructions.sh [--record] COMPILER INCLUDE BENCH FOLDER
# The gate against slow changes: a small fixed frame, by the bare rasteriser and by the mesh, built for x86-64-v3 (valgrind knows
# no AVX-512), must take as many instructions as instructions.txt says for this compiler, within 2 %. Wall time on shared machines
# is no evidence; this is the same on all of them.
#
# When a change is meant to cost or save instructions: sh instructions.sh --record COMPILER ../../include ../../bench FOLDER
set -eu
export LC_ALL=C
record=no
if [ "$1" = --record ]; then record=yes && shift; fi
compiler=$1 include=$2 bench=$3 folder=$4
figures=instructions.txt
parts="direct_precise direct_fast cold_precise static_precise static_fast moved_precise"

skip() { echo "skipped: $*" && exit 0; }
command -v valgrind >/dev/null 2>&1 || skip "valgrind is absent"
command -v "$compiler" >/dev/null 2>&1 || skip "the compiler is absent ($compiler)"
for feature in avx2 fma bmi2; do
    grep -qw "$feature" /proc/cpuinfo 2>/dev/null || skip "this processor has no $feature, so no program for x86-64-v3 runs"
done
version=$(printf '__clang_major__ __GNUC__\n' | "$compiler" -E -P -x c++ - | tail -1)
case $version in
__clang_major__*) name="gcc-${version##* }" ;;
*) name="clang-${version%% *}" ;;
esac
if [ $record = no ] && ! grep -q "^$name " $figures; then skip "no figures are recorded for $name"; fi

mkdir -p "$folder"
for source in instructions.cpp "$bench/common/direct.cpp"; do
    "$compiler" -std=c++20 -O2 -DNDEBUG -march=x86-64-v3 -I "$include" -I "$bench" -c "$source" -o "$folder/$(basename "$source" .cpp).o"
done
"$compiler" "$folder/instructions.o" "$folder/direct.o" -o "$folder/instructions" -pthread

failed=0
: >"$folder/found.txt"
for part in $parts; do
    if ! valgrind --tool=callgrind --toggle-collect=measured_frame --callgrind-out-file="$folder/callgrind.$part" \
        "$folder/instructions" "$part" >"$folder/log.$part" 2>&1; then
        cat "$folder/log.$part"
        exit 1
    fi
    count=$(sed -n 's/^totals: //p; s/^summary: //p' "$folder/callgrind.$part" | tail -1)
    if [ "${count:-0}" -eq 0 ]; then echo "$part: callgrind counted nothing" && exit 1; fi
    echo "$name $part $count" >>"$folder/found.txt"
    expected=$(sed -n "s/^$name $part //p" $figures)
    printf '%-9s %-15s %12s instructions, recorded %s\n' "$name" "$part" "$count" "${expected:-nothing}"
    if [ $record = yes ]; then continue; fi
    # In units of a thousand, so that a shell's integers hold 2 % of it.
    if [ -z "$expected" ] || [ $((count / 1000 * 100)) -gt $((expected / 1000 * 102)) ] ||
        [ $((count / 1000 * 100)) -lt $((expected / 1000 * 98)) ]; then
        echo "$part: more than 2 % off; find out why, or record it (instructions.sh --record) where it is meant"
        failed=1
    fi
done
if [ $record = yes ]; then
    { grep -v "^$name " $figures; cat "$folder/found.txt"; } >"$folder/figures.txt"
    cp "$folder/figures.txt" $figures
fi
exit $failed

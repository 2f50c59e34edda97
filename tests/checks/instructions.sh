#!/bin/sh
# usage: instructions.sh [--record|--traced] COMPILER INCLUDE BENCH FOLDER
# The gate against slow changes: a small fixed frame, by the bare rasteriser and by the mesh, built for x86-64-v3 (valgrind knows
# no AVX-512), must take as many instructions as instructions.txt says for this compiler, within 2 %. Wall time on shared machines
# is no evidence; this is the same on all of them.
# And tracing that is off costs nothing: without the `operations` of any kernel the object file is the same to the byte.
#
# With --traced the counts of a machine that keeps a trace stand beside, which nothing holds to a figure (the figures of include/tilemesh/model/README.md).
# When a change is meant to cost or save instructions: sh instructions.sh --record COMPILER ../../include ../../bench FOLDER
set -eu
export LC_ALL=C
record=no traced=no
if [ "$1" = --record ]; then record=yes && shift; fi
if [ "$1" = --traced ]; then traced=yes && shift; fi
compiler=$1 include=$2 bench=$3 folder=$4
figures=instructions.txt
parts="direct_precise direct_fast cold_precise static_precise static_fast kept_fast moved_precise"
traced_parts="cold_precise static_precise moved_precise"

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
failed=0
compile() { # OBJECT SOURCE INCLUDE FLAGS...: FOLDER/OBJECT.o
    object=$1 source=$2 headers=$3
    shift 3
    "$compiler" -std=c++20 -O2 -DNDEBUG -march=x86-64-v3 "$@" -I "$headers" -I "$bench" -c "$source" -o "$folder/$object.o"
}
count() { # PROGRAM PART: instructions of its measured frame
    if ! valgrind --tool=callgrind --toggle-collect=measured_frame --callgrind-out-file="$folder/callgrind.$2" "$folder/$1" "$2" \
        >"$folder/log.$2" 2>&1; then
        cat "$folder/log.$2" >&2
        exit 1
    fi
    sed -n 's/^totals: //p; s/^summary: //p' "$folder/callgrind.$2" | tail -1
}
compile instructions instructions.cpp "$include"
compile direct "$bench/common/direct.cpp" "$include"
"$compiler" "$folder/instructions.o" "$folder/direct.o" -o "$folder/instructions" -pthread

# The headers without what only a trace calls; empty lines stand for it.
hooks='static Operations operations('
rm -rf "$folder/bare"
cp -R "$include" "$folder/bare"
kernels=$(cd "$include" && grep -lF "$hooks" tilemesh/splat/*.hpp tilemesh/splat/homes/*.hpp tilemesh/splat/map/*.hpp tilemesh/splat/pose/*.hpp)
removed=0
for file in $kernels; do
    awk -v hooks="$hooks" 'index($0, hooks) { inside = 1 } { print inside ? "" : $0 } /^    }$/ { inside = 0 }' "$include/$file" >"$folder/bare.hpp"
    cp "$folder/bare.hpp" "$folder/bare/$file"
    removed=$((removed + $(grep -cF "$hooks" "$include/$file")))
done
compile bare instructions.cpp "$folder/bare"
if [ "$removed" -lt 5 ] || grep -rqF "$hooks" "$folder/bare/tilemesh/splat"; then
    echo "$name: found the operations of $removed kernels, of the frame's 5 at least; this check no longer knows them"
    failed=1
elif cmp "$folder/instructions.o" "$folder/bare.o"; then
    echo "$name: without the operations of $removed kernels, which only a trace calls, the object file is the same to the byte"
else
    echo "$name: the operations of kernels leave something in a program without a trace"
    failed=1
fi
if [ $traced = yes ]; then
    compile traced instructions.cpp "$include" -DTRACED
    "$compiler" "$folder/traced.o" "$folder/direct.o" -o "$folder/traced" -pthread
    for part in $traced_parts; do
        with=$(count traced "$part")
        without=$(count instructions "$part")
        printf '%-9s %-15s %12s instructions, with a trace %12s\n' "$name" "$part" "$without" "$with"
    done
    exit $failed
fi

: >"$folder/found.txt"
for part in $parts; do
    count=$(count instructions "$part")
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

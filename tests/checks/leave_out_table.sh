#!/bin/sh
# usage: leave_out_table.sh [COMPILER [NM]]
# Prints the table of bench/README.md, what each feature costs: bytes of a record, of a slot of storage with its lists, of a tile
# besides, and of the kernels' code at -O2 for any x86-64; exchanges, messages and counted work of a frame. Takes minutes.
set -eu
export LC_ALL=C
compiler=${1:-g++} nm=${2:-nm} include=../../include
cd "$(dirname "$0")"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

code_bytes() { # SETUP: the sizes of all functions of its kernels, shared leaves included
    "$compiler" -std=c++20 -O2 -ffunction-sections -DSETUP="$1" -I "$include" -c leave_out/kernels_of.cpp -o "$folder/code.o"
    "$nm" -SC --defined-only "$folder/code.o" | grep -v 'leave_out::Emit' | awk '$3 ~ /^[TWt]$/ { print $2 }' |
        while read -r hex; do echo $((0x$hex)); done | awk '{ n += $1 } END { print n }' | sed -E ':a; s/([0-9])([0-9]{3})($|,)/\1,\2\3/; ta'
}

"$compiler" -std=c++20 -O2 -I "$include" leave_out/count.cpp -o "$folder/count" -pthread
"$folder/count" >"$folder/rows.txt"
echo '| setup | record, bytes | slot, bytes | tile besides, bytes | slots a tile | code, bytes | exchanges, cold / static | messages, cold / static | projections, cold / static | pairs | missing |'
echo '|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|'
while IFS="|" read -r setup called record slot besides slots cold_steps cold_messages cold_projections steps messages projections pairs missing; do
    if [ "$setup" = one_tile ]; then break; fi
    echo "| $called | $record | $slot | $besides | $slots | $(code_bytes "$setup") | $cold_steps / $steps | $cold_messages / $messages | $cold_projections / $projections | $pairs | $missing |"
done <"$folder/rows.txt"
# Only `minimal` and its two relatives without bloom miss what spans tiles; on one tile nothing does.
echo
echo "With the frame on one tile (a test machine) the least misses $missing: $steps exchanges, $messages messages, $projections projections, $pairs pairs."

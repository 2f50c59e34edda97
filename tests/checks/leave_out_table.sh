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
label() {
    case $1 in
    minimal) echo 'the least: one colour, one view' ;;
    with_bloom) echo '+ bloom (footprints span tiles)' ;;
    with_routing) echo '+ routing (the view moves)' ;;
    both) echo '+ both: the default' ;;
    degree_1) echo 'default + harmonics of degree 1' ;;
    degree_2) echo 'default + harmonics of degree 2' ;;
    degree_3) echo 'default + harmonics of degree 3' ;;
    with_depth) echo 'default + depth' ;;
    with_alpha) echo 'default + alpha' ;;
    everything) echo 'everything' ;;
    *) echo "no label for $1" >&2 && exit 1 ;;
    esac
}

"$compiler" -std=c++20 -O2 -I "$include" leave_out/count.cpp -o "$folder/count" -pthread
"$folder/count" >"$folder/rows.txt"
echo '| setup | record, bytes | slot, bytes | tile besides, bytes | slots a tile | code, bytes | exchanges, cold / static | messages, cold / static | projections, cold / static | pairs | missing |'
echo '|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|'
while read -r setup record slot besides slots cold_steps cold_messages cold_projections steps messages projections pairs missing; do
    if [ "$setup" = one_tile ]; then break; fi
    echo "| $(label "$setup") | $record | $slot | $besides | $slots | $(code_bytes "$setup") | $cold_steps / $steps | $cold_messages / $messages | $cold_projections / $projections | $pairs | $missing |"
done <"$folder/rows.txt"
# Only `minimal` and its two relatives without bloom miss what spans tiles; on one tile nothing does.
echo
echo "With the frame on one tile (a test machine) the least misses $missing: $steps exchanges, $messages messages, $projections projections, $pairs pairs."

#!/bin/sh
# usage: fast_math.sh COMPILER INCLUDE
# Every header refuses -ffast-math with a sentence. Exempt are headers whose floating-point arithmetic, if any, changes no result.
set -eu
export LC_ALL=C
compiler=$1 include=$2
no_arithmetic='engine/(arena|digest|stopwatch|team|tile_set|counters)|error|joined_threads|mpi/(bands|detail/ranks)|machine/(name|spec|superstep|types)|mapping/detail/parallel|render/(detail/sorted_table|ranks/row_shares)|splat/(sizes|(homes/)?counts)|report/(distinct_files|table|frame_report|plot|stacked_bars|whole_file)|scene/detail/ply_(header|kind|source)'
failed=0
for header in $(cd "$include" && find tilemesh -name '*.hpp' | sort | grep -vxE "tilemesh/($no_arithmetic)\.hpp"); do
    if printf '#include <%s>\n' "$header" | "$compiler" -std=c++20 -ffast-math -Wfatal-errors -I "$include" -I ../poplar/standin -E -o /dev/null -x c++ - 2>/dev/null; then
        echo "$header takes -ffast-math"
        failed=1
    fi
done
for flag in -ffast-math -ffinite-math-only; do
    text=$(echo '#include <tilemesh/tilemesh.hpp>' | "$compiler" -std=c++20 $flag -I "$include" -E -o /dev/null -x c++ - 2>&1 || true)
    case $text in
    *"tilemesh: -ffast-math, or a part of it, breaks the promise of equal bits"*) ;;
    *) echo "no sentence for $flag in: $text" && failed=1 ;;
    esac
done
exit $failed

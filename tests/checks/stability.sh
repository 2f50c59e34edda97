#!/bin/sh
# usage: stability.sh PROJECT
# The catalogue is complete: rows 1 to 90 have one test case each, and tests/stability/README.md has the result of each.
set -eu
export LC_ALL=C
cd "$1/tests"
failed=0
rows=$(seq 1 90)
cases=$(grep -ohE '^TEST_CASE\("row [0-9]+' stability/*.cpp | awk '{ print $2 }' | sort -n) || true
if [ "$cases" != "$rows" ]; then
    echo "rows that have no test case, or two:"
    printf '%s\n' "$cases" "$rows" | sort -n | uniq -c | awk '$1 != 2 { print $2 }'
    failed=1
fi
table=$(sed -n '/^<!-- stability table -->$/,/^<!-- end of stability table -->$/p' stability/README.md)
listed=$(printf '%s\n' "$table" | sed -nE 's/^\| ([0-9]+) \|.*/\1/p')
if [ "$listed" != "$rows" ]; then
    echo "the table in tests/stability/README.md does not have rows 1 to 90 once each; write it with: cmake --build BUILD --target stability_table"
    failed=1
fi
# What does not apply is said in both places.
apart() { sort -n | tr '\n' ' '; }
in_sources=$(sed -nE 's/^TEST_CASE\("row ([0-9]+) does not apply.*/\1/p' stability/*.cpp | apart)
in_table=$(printf '%s\n' "$table" | sed -nE 's/^\| ([0-9]+) \| does not apply: .*/\1/p' | apart)
if [ "$in_sources" != "$in_table" ]; then
    echo "rows that do not apply are [$in_sources] in the sources and [$in_table] in the table"
    failed=1
fi
exit $failed

#!/bin/sh
# usage: table.sh TESTS_STABILITY README
# Runs the catalogue's cases and writes what they measured into README, between the lines that say so.
set -eu
export LC_ALL=C
tests=$1 readme=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

TILEMESH_STABILITY_TABLE="$work/results" "$tests" '-tc=row *' >"$work/log" || { tail -40 "$work/log" && exit 1; }
sort -n "$work/results" | awk -F '\t' '
    BEGIN { print "| row | input | naive float32 | ours | tolerance | naive fails |"; print "|---|---|---|---|---|---|" }
    { for (i = 1; i <= NF; ++i) gsub(/\|/, "\\|", $i) }
    $6 ~ /^does not apply/ { printf "| %s | %s | | | | |\n", $1, $6; next }
    { printf "| %s | %s | %s | %s | %s | %s |\n", $1, $2, $3, $4, $5, $6 == "bites" ? "yes" : "" }' >"$work/table"

grep -q '^<!-- stability table -->$' "$readme" && grep -q '^<!-- end of stability table -->$' "$readme" ||
    { echo "$readme has no place for the table" && exit 1; }
awk -v table="$work/table" '
    /^<!-- end of stability table -->$/ { skip = 0 }
    !skip { print }
    /^<!-- stability table -->$/ { skip = 1; while ((getline line < table) > 0) print line }' "$readme" >"$work/readme"
cp "$work/readme" "$readme"

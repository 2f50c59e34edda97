#!/bin/sh
# usage: readme.sh PROJECT [render_map]
# What README.md shows is what the project holds: every block of C++ or CMake is part of the file named in the comment above it, every
# file that is named exists, every `render_map` line runs, and the examples print what it says they print. tests/README.md: every test file exists, and so do the cases quoted.
set -u
export LC_ALL=C
project=$1 program=${2:-}
cd "$project" && project=$(pwd) || exit 1
failed=0
fail() { echo "$*" && failed=1; }

# --- blocks ------------------------------------------------------------------------------------
# The comment `<!-- PATH -->` stands on the line above the fence.
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
awk -v work="$work" '
    /^```(cpp|cmake)$/ { n++; file = work "/" n ".block"; print source > (work "/" n ".source"); printf "" > file; inside = 1; next }
    /^```/ && inside { inside = 0; close(file); next }
    inside { print > file; next }
    { source = $0 ~ /^<!-- [^ ]+ -->$/ ? $2 : "" }' README.md
blocks=0
for block in "$work"/*.block; do
    [ -e "$block" ] || break
    blocks=$((blocks + 1))
    source=$(cat "${block%.block}.source")
    if [ -z "$source" ]; then
        fail "no file is named above: $(head -n 1 "$block")"
    elif [ ! -e "$source" ]; then
        fail "$source is named above a block and does not exist"
    else
        awk -v block="$block" '
            BEGIN { while ((getline line < block) > 0) want = want line "\n" }
            { text = text $0 "\n" }
            END { exit index(text, want) == 0 }' "$source" || fail "not a part of $source: $(head -n 1 "$block")..."
    fi
done
[ "$blocks" -ge 3 ] || fail "only $blocks blocks of code were found in README.md"

# --- names -------------------------------------------------------------------------------------
for name in $(grep -oE '`(include|examples|tests|bench|\.ci)/[A-Za-z0-9_./*-]+`' README.md tests/README.md -h | tr -d '`' | sort -u); do
    # shellcheck disable=SC2086
    set -- $name
    [ -e "$1" ] || fail "named, and not there: $name"
done
# `part/file.cpp` "the beginning of a case"
grep -oE '`[a-z_]+/[A-Za-z0-9_*]+\.[a-z]+`( "[^"]+")?' tests/README.md | grep -vE '^`(include|examples|bench)/' |
    sort -u >"$work/cases"
while read -r line; do
    file=$(printf '%s' "$line" | cut -d '`' -f 2)
    case=$(printf '%s' "$line" | sed -n 's/^[^"]*"\(.*\)"$/\1/p')
    # shellcheck disable=SC2086
    set -- tests/$file
    [ -e "$1" ] || { fail "tests/README.md names $file, which is not there" && continue; }
    [ -z "$case" ] || grep -qF "\"$case" "$@" || grep -qF "\"slow: $case" "$@" || fail "$file has no case \"$case...\""
done <"$work/cases"

# --- commands ----------------------------------------------------------------------------------
if [ -z "$program" ]; then
    echo "skipped: render_map was not built, so its lines were not run"
    exit $failed
fi
cd "$work" || exit 1
# A map of three balls, README's own camera for it, a walk.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 3\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    printf 'end_header\n'
    for x in -1 0 1; do echo "$x 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0"; done
} >room.ply
awk '/^```/ { inside = /^```json$/; next } inside' "$project/README.md" >cameras.json
[ -s cameras.json ] || fail "README.md shows no camera file"
mkdir -p colmap/sparse/0
printf '1 PINHOLE 1280 720 900 900 640 360\n' >colmap/sparse/0/cameras.txt
printf '1 1 0 0 0 0 0 0 1 door.jpg\n\n' >colmap/sparse/0/images.txt
printf '# walk\n0 0 0 0 0 0 0 1\n0.1 0.01 0 0 0 0 0 1\n' >walk.txt
sed -n '/^```sh$/,/^```$/p' "$project/README.md" | sed 's/#.*//; s/ *$//' | grep '^render_map ' >lines
runs=0
while read -r _ arguments; do
    runs=$((runs + 1))
    # shellcheck disable=SC2086
    "$program" $arguments --quiet >out 2>&1 </dev/null || fail "render_map $arguments: $(cat out)"
    rm -rf tilemesh_out
done <lines
# The output of a program, below `<!-- output of COMMAND -->`: each line, but for host times and the counts that depend on how the
# target rounds (with or without fused multiplication: README says so).
exact() { sed -E '/contributing|order by id/d; s/^( *(project|route|bloom|composite|picture|frame) +[0-9]+) +[0-9.]+$/\1/'; }
outputs=0
sed -n 's/^<!-- output of \([a-z_].*\) -->$/\1/p' "$project/README.md" >names
while IFS= read -r name; do
    outputs=$((outputs + 1))
    # shellcheck disable=SC2086
    "$(dirname "$program")"/$name >printed 2>&1 </dev/null || fail "$name: $(cat printed)"
    exact <printed >exact_printed
    sed -n "/^<!-- output of $name -->\$/,\$p" "$project/README.md" | awk '/^```/ { n++; next } n == 1 { print } n == 2 { exit }' |
        exact >block
    [ -s block ] || fail "README.md shows nothing of $name"
    while IFS= read -r line; do
        grep -qxF -- "$line" exact_printed || fail "$name does not print: $line"
    done <block
done <names
[ "$outputs" -ge 2 ] || fail "only $outputs outputs of examples were found in README.md"
[ "$runs" -ge 4 ] || fail "only $runs render_map lines were found in README.md"
echo "$blocks blocks, $runs commands, $outputs outputs"
exit $failed

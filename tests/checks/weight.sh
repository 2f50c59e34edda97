#!/bin/bash
# usage: weight.sh [--write] PROJECT COMPILER [BUILD]
# What the project weighs for a compiler, in figures that no load of the machine changes: lines after preprocessing that are not empty,
# bytes of object code at -O0, compiled units of a target, and renderers that their object files hold (each one is seconds of compiling).
# The table stands in .github/CONTRIBUTING.md. The check fails if a figure is more than 3 % above the table. --write writes the table.
# BUILD is a build of the preset ci. Without it, or if a program of it is not built, the figures of that program are left out.
# The table is for one compiler (GCC 12 of Debian 12); with another one, the check says "skipped".
set -euo pipefail
export LC_ALL=C
write=no
if [ "${1:-}" = --write ]; then write=yes && shift; fi
project=$(cd "$1" && pwd) compiler=$2 build=${3:-}
if [ -n "$build" ]; then build=$(cd "$build" && pwd); fi
page=$project/.github/CONTRIBUTING.md
case $("$compiler" --version 2>&1 | head -n 1) in
*Debian\ 12*) [ "$("$compiler" -dumpversion)" = 12 ] || { echo "skipped: the table is for GCC 12" && exit 0; } ;;
*) echo "skipped: the table is for GCC 12 of Debian 12" && exit 0 ;;
esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
flags=(-std=c++20 -I "$project/include")
lines() { "$compiler" "${flags[@]}" "$@" -E -P | grep -c '[^ ]'; }
bytes() { # text and data of the object file
    "$compiler" "${flags[@]}" -O0 "$@" -c -o object.o
    size object.o | awk 'NR == 2 { print $1 + $2 }'
}

# KIND, what, first figure, second figure ("-": none)
figures() {
    printf '#include <tilemesh/tilemesh.hpp>\nint main() {}\n' >umbrella.cpp
    echo "program|umbrella, empty main, headers alone|$(lines umbrella.cpp)|-"
    flags+=(-DTILEMESH_COMPILED)
    echo "program|umbrella, empty main|$(lines umbrella.cpp)|-"
    for name in sort jacobi picture first_frame; do
        echo "program|$name|$(lines "$project/examples/$name.cpp")|$(bytes "$project/examples/$name.cpp")"
    done
    echo "program|heat|$(lines "$project/examples/heat/main.cpp")|$(bytes "$project/examples/heat/main.cpp")"
    for name in walk_around modelled_frame traffic my_machine; do
        echo "program|$name|$(lines "$project/examples/$name.cpp")|-"
    done
    for folder in examples/render_map include/tilemesh/compiled; do
        local sum=0 one file
        for file in "$project/$folder"/*.cpp; do
            case $file in */on_ranks*) continue ;; esac # they need MPI
            one=$(lines "$file")
            sum=$((sum + one))
        done
        echo "program|units of $folder, together|$sum|-"
    done
    [ -n "$build" ] || return 0
    # The units of a command are those that it compiles in a clean folder. Their object files are those of BUILD.
    local command preset target
    for command in "demo picture" "demo render_map" "test all" "ci all"; do
        read -r preset target <<<"$command"
        (cd "$project" && cmake --preset "$preset" -B "$work/$preset" -DCMAKE_CXX_COMPILER="$compiler") >log 2>&1 || { cat log >&2 && return 1; }
        ninja -C "$preset" -t commands "$target" | grep -oE ' -o [^ ]*\.cpp\.o ' | sed -E 's/^ -o //; s/ $//' | sort -u >units
        sed -E "s,tilemesh_(first|compiled)_native\.dir,tilemesh_compiled.dir,; s,^,$build/," units >objects
        [ "$target" != all ] || target=everything
        if xargs ls -d <objects >there 2>/dev/null; then
            echo "build|preset $preset, $target|$(wc -l <units)|$(renderers <objects)"
        else
            echo "note: no row for the preset $preset, $target ($build has not all of its object files)" >&2
        fi
    done
}
renderers() { # Each object file counts once for each renderer that it holds.
    xargs nm -A -C --defined-only 2>/dev/null |
        sed -nE 's/^([^:]*):[^ ]* [A-Za-z] (.*(Frame|Homes)Renderer<.*>::render_into\(.*\))$/\1 \2/p
            s/^([^:]*):[^ ]* [A-Za-z] (.*PoseEvaluator.*::evaluate\(.*TrackOptions const&\))$/\1 \2/p' |
        sort -u | wc -l
}
figures >figures
table() { # KIND, three headings
    printf '| %s | %s | %s |\n|---|--:|--:|\n' "$2" "$3" "$4"
    awk -F'|' -v kind="$1" '
        function grouped(n) { while (n ~ /[0-9][0-9][0-9][0-9]/) { if (!match(n, /[0-9][0-9][0-9](,|$)/)) break; n = substr(n, 1, RSTART - 1) "," substr(n, RSTART) } return n }
        $1 == kind { printf "| %s | %s | %s |\n", $2, $3 == "-" ? "" : grouped($3), $4 == "-" ? "" : grouped($4) }' figures
}
if [ "$write" = yes ]; then
    [ -n "$build" ] || { echo "weight.sh --write needs a build of the preset ci; name its folder" >&2 && exit 2; }
    {
        table program "program, with \`TILEMESH_COMPILED\`" "lines, preprocessed" "bytes of object code at -O0"
        echo
        table build "command, from a clean folder" "units" "renderers in their object files"
    } >table
    awk -v table=table '/^<!-- end of weight -->$/ { inside = 0 } !inside { print }
        /^<!-- weight -->$/ { inside = 1; while ((getline line < table) > 0) print line }' "$page" >page
    cmp -s page "$page" || cat page >"$page"
    exit 0
fi
awk -v page="$page" -F'|' '
    function plain(text) { gsub(/[, ]/, "", text); return text }
    BEGIN {
        while ((getline line < page) > 0) {
            if (line == "<!-- weight -->") inside = 1
            if (line == "<!-- end of weight -->") inside = 0
            if (!inside || split(line, cell, "|") < 5) continue
            sub(/^ /, "", cell[2]); sub(/ $/, "", cell[2])
            known[cell[2], 3] = plain(cell[3]); known[cell[2], 4] = plain(cell[4])
        }
    }
    {
        for (i = 3; i <= 4; i++) {
            if ($i == "-") continue
            n++
            was = known[$2, i]
            if (was == "") { print "not in the table of .github/CONTRIBUTING.md: " $2 " (" $i ")"; failed = 1 }
            else if ($i > was * 1.03) { printf "%s weighs %d (the table of .github/CONTRIBUTING.md says %d, %.1f %% less); make it lighter, or write a new table: tests/checks/weight.sh --write\n", $2, $i, was, 100 - 100 * was / $i; failed = 1 }
            else if ($i < was * 0.97) print "note: " $2 " weighs " $i ", and the table says " was ": write a new one"
        }
    }
    END { print n " figures"; exit failed || n == 0 }' figures

#!/bin/sh
# usage: readme.sh [--write [--slow]] PROJECT [render_map]
# Everything that the README files show is what the project holds:
# - A block of C++ or CMake is a part of the file that the comment above it names.
# - Every file, test case, link and preset of CMake that is named exists.
# - The tables of RendererOptions and MeshOptions have their members in the order of declaration.
# - README.md has at most 160 lines of at most 120 characters, and each of its headline numbers names its command.
# - Every target, cache entry of CMake and file that a command names is in the project, and every option is one of its program.
# - Every `render_map` and `pfm_error` line and every block of Python runs.
# - A block below `<!-- output of COMMAND -->` is what COMMAND prints, but for host times and for counts that depend on fused
#   multiplication. `<!-- output of COMMAND, from "TEXT" to "TEXT" -->` is a part of it: from the first line that begins with TEXT to
#   the next that does. Either end may be left out. A block is fenced, or a Markdown table that COMMAND prints as such.
# - The version is the same everywhere.
# With --write, the script writes these blocks anew. With --slow, it also writes the blocks below `<!-- slow output of COMMAND -->`,
# which take minutes and are not compared; DIR in such a command is the folder TILEMESH_DATA.
set -u
export LC_ALL=C
write=no slow=no
if [ "${1:-}" = --write ]; then write=yes && shift; fi
if [ "${1:-}" = --slow ]; then slow=yes && shift; fi
project=$1 program=${2:-}
case $program in '' | /*) ;; *) program=$PWD/$program ;; esac
cd "$project" && project=$(pwd) || exit 1
failed=0
fail() { echo "$*" && failed=1; }
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
find . -name README.md -not -path './build*' -not -path './.*' | sed 's,^\./,,' | sort >"$work/readmes"
readmes=$(cat "$work/readmes")
texts="$readmes CHANGELOG.md .github/CONTRIBUTING.md .github/SECURITY.md"

# --- size --------------------------------------------------------------------------------------
[ "$(wc -l <README.md)" -le 160 ] || fail "README.md has $(wc -l <README.md) lines, more than 160"
[ -z "$(awk 'length($0) > 120' README.md)" ] || fail "README.md has lines of more than 120 characters: $(awk 'length($0) > 120 { print FNR }' README.md)"
for file in $readmes; do # tables and programs may be wider
    wide=$(awk '/^```/ { inside = !inside } !inside && !/^\|/ && !/^!\[/ && length($0) > 120 { printf " %d", FNR }' "$file")
    [ -z "$wide" ] || fail "$file has lines of more than 120 characters:$wide"
done

# --- blocks ------------------------------------------------------------------------------------
# The comment `<!-- PATH -->` stands on the line above the fence.
for file in $readmes; do
    awk -v work="$work" -v name="$(echo "$file" | tr / _)" -v readme="$file" '
        /^```(cpp|cmake)$/ { n++; file = work "/" name n ".block"; print readme " " source > (work "/" name n ".source"); printf "" > file; inside = 1; next }
        /^```/ && inside { inside = 0; close(file); next }
        inside { print > file; next }
        { source = $0 ~ /^<!-- [^ ]+ -->$/ ? $2 : "" }' "$file"
done
blocks=0
for block in "$work"/*.block; do
    [ -e "$block" ] || break
    blocks=$((blocks + 1))
    read -r readme source <"${block%.block}.source"
    if [ -z "$source" ]; then
        fail "$readme: no file is named above: $(head -n 1 "$block")"
    elif [ ! -e "$source" ]; then
        fail "$readme: $source is named above a block and does not exist"
    else
        awk -v block="$block" '
            BEGIN { while ((getline line < block) > 0) want = want line "\n" }
            { text = text $0 "\n" }
            END { exit index(text, want) == 0 }' "$source" || fail "$readme: not a part of $source: $(head -n 1 "$block")..."
    fi
done
[ "$blocks" -ge 12 ] || fail "only $blocks blocks of code were found in the README files"

# --- names -------------------------------------------------------------------------------------
# shellcheck disable=SC2086
for name in $(grep -hoE '`(include|examples|tests|bench|\.ci|\.github)/[A-Za-z0-9_./*-]+`' $texts | tr -d '`' | sort -u); do
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

# --- tables of options -------------------------------------------------------------------------
# Designated initialisers follow the order of declaration, so a table of options has it, and lacks no member.
in_order() { # in_order STRUCT HEADER HEADING_OF_THE_TABLE
    sed -nE "/^struct $1 \\{/,/^\\};/p" "include/tilemesh/$2" |
        sed -nE 's,///.*,,; s/^    [A-Za-z_:].*[ >]([a-z_]+)( = [^;]*|\{\});.*/\1/p' >"$work/declared"
    awk -v heading="$3" 'on && !/^\|/ { exit } on { split($0, cell, "|"); print cell[2] } index($0, heading) == 1 { on = 1 }' \
        include/tilemesh/README.md | grep -oE '`\.[a-z_]+`' | tr -d '`.' >"$work/in_table"
    [ -s "$work/declared" ] || fail "$1 has no members in $2"
    diff "$work/declared" "$work/in_table" >"$work/order" || fail "include/tilemesh/README.md: its table of $1 has not the members in the order of declaration:
$(cat "$work/order")"
}
in_order RendererOptions render/renderer_options.hpp '| option | type | default |'
in_order MeshOptions engine/mesh_options.hpp '| `MeshOptions` |'

# --- presets -----------------------------------------------------------------------------------
# Every preset of CMake, and every folder of a build, that a command names is there: a folder is that of a preset, or follows -B.
grep -v '"hidden": true' CMakePresets.json | sed -nE 's/.*"name": "([a-z0-9_-]+)".*/\1/p' | sort -u >"$work/presets"
# shellcheck disable=SC2086
for preset in $(grep -hoE '(cmake|ctest)[^`|]* --preset[ =][a-z0-9_-]+' $texts | sed 's/.*[ =]//' | sort -u); do
    grep -qx -e "$preset" "$work/presets" || fail "a README names the preset $preset, which CMakePresets.json has not"
done
# shellcheck disable=SC2086
for file in $texts; do
    for folder in $(grep -oE '(--build|--install|--test-dir) build/[a-z0-9_-]+' "$file" | sed 's,.*/,,' | sort -u); do
        grep -qx -e "$folder" "$work/presets" || grep -q -e "-B build/$folder\>" "$file" ||
            fail "$file builds in build/$folder, which is no preset's folder, and no -B names it"
    done
done

# --- words of commands -------------------------------------------------------------------------
# The commands of all blocks, one a line, without comments: a line that ends with && goes on.
# shellcheck disable=SC2086
awk 'FNR == 1 { inside = 0 } /^```sh$/ { inside = 1; next } /^```/ { inside = 0 } inside' $texts |
    sed 's/[[:space:]]#.*//; /^#/d' | sed 's/&&/\n/g' | sed 's/^ *//; s/ *$//; /^$/d' | sort -u >"$work/commands"
git_files() { find CMakeLists.txt tests examples bench -name CMakeLists.txt -o -name '*.cmake'; }
# shellcheck disable=SC2046
cat $(git_files) >"$work/cmake_files"
for word in $(grep -oE -e '--target [a-z0-9_ ]+' "$work/commands" | sed 's/--target//'); do
    grep -qw -e "$word" "$work/cmake_files" || fail "a README builds the target $word, which no CMakeLists.txt has"
done
for word in $(grep -oE -e '-DTILEMESH_[A-Z_]+' "$work/commands" | sed 's/^-D//' | sort -u); do
    grep -qw -e "$word" "$work/cmake_files" || fail "a README sets $word, which no CMakeLists.txt reads"
done
for word in $(grep -oE '(^|[ =])(tests|examples|bench|include)/[a-z0-9_/.]+\.(sh|py|cpp|mjs)' "$work/commands" | sed 's/^[ =]//' | sort -u); do
    [ -e "$word" ] || fail "a README's command names $word, which does not exist"
done

# --- links -------------------------------------------------------------------------------------
# A heading's anchor: lower case, without punctuation, a hyphen for each space.
anchors() {
    awk '/^```/ { inside = !inside } !inside && /^#+ /' "$1" | sed -E 's/^#+ +//' | tr '[:upper:]' '[:lower:]' |
        sed -E 's/[^a-z0-9 _-]//g; s/ /-/g'
}
links=0
for file in $texts; do
    for link in $(awk '/^```/ { inside = !inside } !inside' "$file" | grep -oE '\]\([^) ]+\)' | sed 's/^](//; s/)$//'); do
        case $link in http://* | https://*) continue ;; esac
        links=$((links + 1))
        target=${link%%#*}
        if [ -n "$target" ]; then target=$(dirname "$file")/$target; else target=$file; fi
        [ -e "$target" ] || { fail "$file: the link $link leads nowhere" && continue; }
        case $link in
        *#*) anchors "$target" | grep -qx -- "${link#*#}" || fail "$file: $target has no heading for ${link#*#}" ;;
        esac
    done
done
for file in $readmes; do # a reader finds every README file from another
    [ "$file" = README.md ] || awk -v file="$file" -v files="$readmes" '
        BEGIN {
            n = split(files, all)
            for (i = 1; i <= n; i++) while ((getline line < all[i]) > 0) {
                folder = all[i]
                sub(/[^\/]*$/, "", folder)
                while (match(line, /\]\([^) #]+/)) {
                    target = folder substr(line, RSTART + 2, RLENGTH - 2)
                    line = substr(line, RSTART + RLENGTH)
                    while (sub(/[^\/.][^\/]*\/\.\.\//, "", target)) {}
                    if (target == file) exit 0
                }
            }
            exit 1
        }' || fail "no README file links to $file"
done

# --- headline numbers --------------------------------------------------------------------------
# Each row's last column is a command: a bench, and a table that it has.
awk '/^## Six numbers/ { inside = 1; next } /^## / { inside = 0 } inside && /^\| [^q]/ && !/^\|--/' README.md >"$work/headlines"
[ "$(wc -l <"$work/headlines")" -eq 6 ] || fail "README.md has $(wc -l <"$work/headlines") headline numbers, not six"
while IFS= read -r row; do
    command=$(printf '%s\n' "$row" | sed -nE 's/.*\| `([^`]+)` \|$/\1/p')
    bench=${command%% *} table=$(printf '%s\n' "$command" | sed -nE 's/.* --table ([a-z_]+).*/\1/p')
    if [ -z "$command" ] || [ ! -d "bench/$bench" ]; then fail "no command in the row: $row"; continue; fi
    if [ "$bench" = paper ]; then
        [ -n "$table" ] && grep -qF "\"$table\"" bench/paper/main.cpp || fail "bench/paper has no table \"$table\": $row"
    fi
done <"$work/headlines"

# Each promise names a test.
awk '/^## What is promised/ { inside = 1; next } /^## / { inside = 0 } inside' README.md | sed -nE 's/^\|.*\| `([^`]+)` \|$/\1/p' >"$work/promises"
[ "$(wc -l <"$work/promises")" -ge 6 ] || fail "README.md shows tests for $(wc -l <"$work/promises") promises only"
while IFS= read -r name; do
    case $name in
    check.*) grep -qE "add_(check|table)\(${name#check.} " tests/checks/CMakeLists.txt || [ -e "tests/checks/tables/${name#check.}.txt" ] ;;
    *.*) [ -e "tests/${name%%.*}/${name#*.}.cpp" ] ;;
    *) [ -d "tests/$name" ] ;;
    esac || fail "README.md promises something that test $name shows, and there is no such test"
done <"$work/promises"

# --- versions ----------------------------------------------------------------------------------
version=$(sed -nE 's/^ +VERSION ([0-9.]+)$/\1/p' CMakeLists.txt)
number=$(sed -nE 's/^#define TILEMESH_VERSION ([0-9]+).*/\1/p' include/tilemesh/config.hpp)
[ "$version" = "$((number / 10000)).$((number / 100 % 100)).$((number % 100))" ] || fail "CMakeLists.txt has version $version, config.hpp $number"
grep -qx "version: $version" CITATION.cff || fail "CITATION.cff has not version $version"
[ "$(sed -nE 's/^## \[([0-9.]+)\].*/\1/p' CHANGELOG.md | head -n 1)" = "$version" ] || fail "CHANGELOG.md does not begin with version $version"

# --- commands ----------------------------------------------------------------------------------
if [ -z "$program" ]; then
    [ "$write" = no ] || fail "--write needs render_map, beside which the other programs are"
    echo "skipped: render_map was not built, so its lines were not run"
    exit $failed
fi
examples=$(dirname "$program")
benches=$(dirname "$examples")/bench
# Options that a command gives to a program stand in its help. A name of a program alone, or in a folder of a build; after mpirun, too.
asked=0
while read -r line; do
    set -f
    # shellcheck disable=SC2086
    set -- $line
    set +f
    if [ "$1" = mpirun ]; then while [ $# -gt 0 ] && case $1 in build/*) false ;; esac do shift; done; fi
    [ $# -gt 0 ] || continue
    name=${1##*/}
    shift
    built=
    for folder in "$examples" "$benches"; do [ -f "$folder/$name" ] && [ -x "$folder/$name" ] && built=$folder/$name; done
    [ -n "$built" ] || continue
    [ -e "$work/$name.help" ] || "$built" --help >"$work/$name.help" 2>&1 </dev/null
    for word in "$@"; do
        case $word in --[a-z]*) ;; *) continue ;; esac
        asked=$((asked + 1))
        grep -q -e "$word\([^a-z-]\|$\)" "$work/$name.help" || fail "a README gives $name the option $word, which its --help has not"
    done
done <"$work/commands"
[ "$asked" -ge 20 ] || fail "only $asked options were found in the commands of the README files"
# In the text, `--option` is one of a program here, of a script, of CMake or of mpirun.
if [ -e "$work/track.help" ] && [ -e "$work/scaling.help" ]; then
    (cd "$project" && find examples tests bench \( -name '*.sh' -o -name '*.py' -o -name '*.mjs' -o -name main.cpp \) -exec cat {} +) >"$work/scripts"
    for file in $readmes; do
        for word in $(cd "$project" && awk '/^```/ { inside = !inside } !inside' "$file" | grep -oE -e '`--[a-z][a-z-]+' | sed 's/^`//' | sort -u); do
            case $word in --target | --bind-to) continue ;; esac
            cat "$work"/*.help "$work/scripts" | grep -q -e "$word\([^a-z-]\|$\)" || fail "$file names the option $word, which no program has"
        done
    done
fi
mkdir -p "$work/run/examples" && cp -R "$project/examples/machines" "$work/run/examples" && cd "$work/run" || exit 1
# A map of three balls, the cameras that examples/README.md shows, a walk, an energy model.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 3\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    printf 'end_header\n'
    for x in -1 0 1; do echo "$x 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0"; done
} >room.ply
awk '/^```/ { inside = /^```json$/; next } inside' "$project/examples/README.md" >cameras.json
[ -s cameras.json ] || fail "examples/README.md shows no camera file"
mkdir -p colmap/sparse/0
printf '1 PINHOLE 1280 720 900 900 640 360\n' >colmap/sparse/0/cameras.txt
printf '1 1 0 0 0 0 0 0 1 door.jpg\n\n' >colmap/sparse/0/images.txt
printf '# walk\n0 0 0 0 0 0 0 1\n0.1 0.01 0 0 0 0 0 1\n' >walk.txt
(cd "$project" && sed -n '/^```sh$/,/^```$/p' README.md examples/README.md include/tilemesh/model/README.md) | sed 's/ #.*//; s/ *$//' >all_lines
grep '^render_map ' all_lines | grep -v '\.spz\|\.sog\|\.splat' >lines # a map in those formats is no text that a script can write
runs=0
# run_lines PROGRAM ARGUMENT...: runs the commands of `lines`, with these arguments behind theirs.
run_lines() {
    built=$1
    shift
    while read -r _ arguments; do
        runs=$((runs + 1))
        # shellcheck disable=SC2086
        "$built" $arguments "$@" >out 2>&1 </dev/null || fail "${built##*/} $arguments: $(cat out)"
    done <lines
}
run_lines "$program" --quiet
if command -v python3 >/dev/null; then
    awk '/^```/ { inside = /^```python$/; next } inside' "$project/examples/README.md" >read_report.py
    [ -s read_report.py ] || fail "examples/README.md shows no Python"
    { printf 'P6\n1280 720\n255\n' && head -c 2764800 /dev/zero; } >other.ppm
    "$program" room.ply --report report.json --quiet >out 2>&1 </dev/null && python3 read_report.py >out 2>&1 || fail "the Python of examples/README.md: $(cat out)"
fi
if [ -x "$benches/pfm_error" ] && [ -e other.pfm ]; then
    grep '^pfm_error ' all_lines >lines
    run_lines "$benches/pfm_error"
fi
for name in track_camera slam; do # with two small pictures
    [ -x "$examples/$name" ] || continue
    grep -hE "^(build/demo/examples/)?$name --out" "$work/commands" >lines
    run_lines "$examples/$name" --frames 2 --size $([ $name = slam ] && echo 96x54 || echo 320x240) --quiet
done
[ "$runs" -ge 10 ] || fail "only $runs commands were found in the README files"

# --- outputs -----------------------------------------------------------------------------------
# Without host times, and without what depends on how the target rounds (with or without fused multiplication).
exact() { sed -E '/contributing|order by id/d; s/off by at most [0-9.e-]+/off by at most/; s/^( *(project|route|bloom|composite|picture|other|frame)( +[0-9]+)+) +[0-9.]+$/\1/'; }
# marks FILE: for each block its number, `slow` or `quick`, the command, and the beginnings of its first and last line, or "-".
marks() {
    awk '/^<!-- (slow )?output of [^ ].* -->$/ {
            kind = /^<!-- slow/ ? "slow" : "quick"
            sub(/^<!-- (slow )?output of /, "")
            sub(/ -->$/, "")
            first = last = "-"
            if (match($0, /,? to "[^"]*"$/)) {
                last = substr($0, RSTART, RLENGTH - 1)
                $0 = substr($0, 1, RSTART - 1)
            }
            if (match($0, /, from "[^"]*"$/)) {
                first = substr($0, RSTART, RLENGTH - 1)
                $0 = substr($0, 1, RSTART - 1)
            }
            sub(/^[^"]*"/, "", first)
            sub(/^[^"]*"/, "", last)
            print ++n "\t" kind "\t" $0 "\t" first "\t" last
        }' "$1"
}
outputs=0
for file in $readmes; do
    rm -f printed.*
    marks "$project/$file" >marks
    while IFS="$(printf '\t')" read -r n kind command first last; do
        if [ "$kind" = slow ] && [ "$slow" = no ]; then continue; fi
        case $command in *" DIR"*)
            [ -n "${TILEMESH_DATA:-}" ] || { echo "skipped: $command needs TILEMESH_DATA" && continue; } ;;
        esac
        outputs=$((outputs + 1))
        # shellcheck disable=SC2046,SC2086
        PATH=$examples:$benches:$PATH $(printf '%s\n' "$command" | sed "s, DIR\>, ${TILEMESH_DATA:-},; s, tests/, $project/tests/,") >printed 2>&1 </dev/null ||
            fail "$command: $(cat printed)"
        awk -v first="$first" -v last="$last" '
            !on && !done && (first == "-" || index($0, first) == 1) { on = 1 }
            on
            on && last != "-" && index($0, last) == 1 { on = 0; done = 1 }
            END { exit !(done || last == "-") }' printed | sed 's/ *$//' >"printed.$n"
        [ -s "printed.$n" ] || fail "$file: $command prints no line that begins with \"$first\""
        if [ "$write" = yes ]; then continue; fi
        awk -v n="$n" '/^<!-- (slow )?output of / { at++ } at == n && /^```/ { fence++; next } at == n && fence == 1' "$project/$file" | exact >block
        exact <"printed.$n" | diff block - >difference || fail "$file: $command prints something else (readme.sh --write writes it):
$(cat difference)"
    done <marks
    if [ "$write" = yes ]; then
        awk '/^<!-- (slow )?output of / { n++; fence = 0; file = "printed." n; has = (getline line < file) >= 0; close(file) }
            /^\|/ && has && fence == 0 { # a table: to its last row
                while ((getline line < file) > 0) print line
                fence = 3
            }
            /^\|/ && has && fence == 3 { next }
            fence == 3 { fence = 2 }
            /^```/ && has && fence < 2 {
                print
                if (++fence == 1) while ((getline line < file) > 0) print line
                next
            }
            !(has && fence == 1)' "$project/$file" >rewritten
        cmp -s rewritten "$project/$file" || cat rewritten >"$project/$file"
    fi
done
[ "$outputs" -ge 3 ] || fail "only $outputs outputs were found in the README files"
echo "$blocks blocks, $links links, $runs commands, $outputs outputs"
exit $failed

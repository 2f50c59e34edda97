#!/bin/sh
# No byte of a name that a terminal should not get reaches standard output or standard error. Every option of every program gets a name with
# a control character and with bytes that are no UTF-8, and so do the map and an option that is none. Under the name of a file there are in
# turn nothing, a file of such bytes, a folder, a map, an empty file.
# Usage: sh names.sh [-m] PROGRAM...; after -m, a program reads no map (a bench), and each option is refused at once, because a file is
# where the name needs a folder.
started_in=$PWD
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n'
} >map.ply
name=$(printf 'a\033[31m\377\303b')
there() {
    rm -rf "$name"* tilemesh_out
    case $1 in
    nothing) ;;
    bytes) printf '%s 1 2\n{"%s": "%s"\n' "$name" "$name" "$name" >"$name" ;;
    folder) mkdir "$name" && : >"$name/$name.png" && : >"$name/images.txt" ;;
    map) cp map.ply "$name" ;;
    empty) : >"$name" ;;
    esac
}
runs_done=0
# prints_text ARGUMENTS...
prints_text() {
    runs_done=$((runs_done + 1))
    (exec timeout -k 5 60 "$program" "$@" </dev/null) >stdout 2>stderr
    [ $? -lt 124 ] || fail "$short $* does not end: $(cat -v stderr)"
    cat stdout stderr | tr -d '\n\t' >printed
    if grep -q -a "$(printf '[\001-\037\177]')" printed || ! iconv -f UTF-8 -t UTF-8 printed >/dev/null 2>&1; then
        fail "$short $(echo "$*" | cat -v) prints the name's bytes: $(cat -v stdout stderr | head -n 3)"
    fi
}
maps=yes
for program in "$@"; do
    if [ "$program" = -m ]; then
        maps=
        continue
    fi
    case $program in
    /*) ;;
    *) program=$started_in/$program ;;
    esac
    short=${program##*/}
    (exec timeout 60 "$program" --help </dev/null) >help 2>&1
    words=$(grep -oE -e '--[a-z][a-z-]* ([A-Z]+)' help | sort -u)
    options=$(echo "$words" | cut -d ' ' -f 1 | sort -u)
    map=map.ply
    [ "$short" != slam ] || map="--render map.ply" # its map is an option
    if [ -z "$maps" ]; then
        there bytes
        for option in $options; do prints_text --quick "$option" "$name/x"; done
        prints_text "$name" "$name/x"
    else
        small=
        [ -z "$options" ] || small="--size 64x48" # a program with options knows this one
        there nothing
        for option in $options; do prints_text $map $small "$option" "$name"; done
        for kind in bytes folder map empty; do
            for option in $(echo "$words" | grep -E ' (FILE|DIR)$' | cut -d ' ' -f 1); do
                there $kind
                prints_text $map $small "$option" "$name"
            done
            for file in "$name" "$name/x" "$name.ply" "$name.spz"; do
                there $kind
                [ "$file" = "$name" ] || [ "$file" = "$name/x" ] || mv "$name" "$file"
                prints_text "$file" $small
            done
        done
    fi
    prints_text "--$name"
done
[ $runs_done -ge 10 ] || fail "only $runs_done runs"
finish

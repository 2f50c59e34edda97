#!/bin/sh
# The small examples that read a map and write pictures with fixed names: a map that has such a name, or to which a link of such a name leads, is
# refused, and keeps its bytes. Bytes of names that no terminal should get are escaped.
# Usage: sh small_examples.sh FOLDER_OF_PROGRAMS PROGRAM=OUTPUT,OUTPUT,...
folder=$1
shift
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n'
} >map.ply
cp map.ply kept.ply
# is_clash OUTPUT WAY: the run was refused, and wrote nothing.
is_clash() {
    is_refusal "$1" 'this run reads that file'
    same map.ply kept.ply
}
tried=0
for each in "$@"; do
    program=$folder/${each%%=*}
    outputs=$(echo "${each#*=}" | tr , ' ')
    for output in $outputs; do
        for way in own dotted link hard_link link_to_link; do
            mkdir clash
            map=../map.ply
            case $way in
            own) cp map.ply "clash/$output" && map=$output ;;
            dotted) cp map.ply "clash/$output" && map=../clash/./$output ;;
            link) ln -s ../map.ply "clash/$output" ;;
            hard_link) ln map.ply "clash/$output" ;;
            link_to_link) ln -s ../map.ply clash/first && ln -s first "clash/$output" ;;
            esac
            cd clash || exit 1
            run "$map" >../stdout 2>../stderr
            status=$?
            cd .. || exit 1
            is_clash $status
            same kept.ply "clash/$output"
            tried=$((tried + 1))
            rm -r clash
        done
    done
    (run map.ply >>map.ply) 2>stderr
    is_clash $?
    for name in "$(printf 'escape\033[31m')" "$(printf 'latin\351')" "$(printf 'c1\302\233')"; do
        refuses '?' "$name"
        if tr -d '\n' <stderr | grep -q -a "$(printf '[\001-\037\177-\237\340-\377]')"; then fail "a byte of the name reaches the terminal: $(cat stderr)"; fi
        cp map.ply "$name"
        ln -s "$name" "${outputs%% *}"
        run "$name" >stdout 2>stderr
        is_refusal $? 'this run reads that file'
        if tr -d '\n' <stderr | grep -q -a "$(printf '[\001-\037\177-\237\340-\377]')"; then fail "a byte of the name reaches the terminal: $(cat stderr)"; fi
        rm "$name" "${outputs%% *}"
    done
done
[ $tried -ge 5 ] || fail "only $tried pairs were tried"
finish

#!/bin/sh
# What render_map does with what it should never be given: broken files, absurd sizes, full disks, closed streams, interrupts.
# Nothing may crash, hang, take the host's memory or leave half a file.
# Usage: sh render_map_hostile.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# 4 GB: an allocation that a file's promise alone asks for would die. Sanitizers reserve more than that.
if grep -q __asan_init "$program" || grep -q __tsan_init "$program"; then
    skip "a limit on memory: the program is sanitized"
else
    address_space_kib=4000000
fi
small="--size 64x48 --grid 4x3 --threads 2 --quiet"

# --- maps --------------------------------------------------------------------------------------
# header ROWS [PROPERTIES]; row Z: a Gaussian at (0, 0, Z), a float in printf's escapes.
zero='\000\000\000\000' one='\000\000\200\077' two='\000\000\000\100' minus_three='\000\000\100\300' not_a_number='\000\000\300\177'
properties='x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3'
header() {
    printf 'ply\nformat binary_little_endian 1.0\nelement vertex %s\n' "$1"
    # shellcheck disable=SC2086
    printf 'property float %s\n' ${2-$properties}
    printf 'end_header\n'
}
row() {
    size=$minus_three
    # shellcheck disable=SC2059
    printf "$zero$zero$1$one$one$one$two$size$size$size$one$zero$zero$zero"
}
{ header 3 && row "$zero" && row "$one" && row "$two"; } >map.ply
bytes=$(wc -c <map.ply)
start=$(header 3 | wc -c)
runs $small map.ply --out good --float --report good.json
has good.json '"gaussians": 3,'
has good.json '"notes": \[\]'

refuses "absent.ply" absent.ply
mkdir folder
refuses "is a folder without meta.json" folder
: >empty.ply
refuses "empty.ply" empty.ply
for length in 3 40 $((start - 5)) "$start" $((start + 1)) $((start + 56)) $((start + 100)) $((bytes - 1)); do
    head -c "$length" map.ply >cut.ply
    refuses "cut.ply" $small cut.ply
done
for rows in 4 1099511627776 18446744073709551615 99999999999999999999 -1 3.5 nan; do
    { header "$rows" && row "$zero" && row "$one" && row "$two"; } >count.ply
    refuses "count.ply" $small count.ply
done
header 0 >none.ply
refuses "no Gaussian" $small none.ply
for property in $properties; do
    { header 3 "$(echo "$properties" | sed "s/$property/other/")" && row "$zero" && row "$one" && row "$two"; } >lacks.ply
    refuses "$property" $small lacks.ply
done
{ header 2 && row "$not_a_number" && row "$not_a_number"; } >nan.ply
refuses "all of its 2 rows are rejected: row 1" $small nan.ply
{ header 3 && row "$zero" && row "$not_a_number" && row "$two"; } >some.ply
runs --size 64x48 --grid 4x3 some.ply --report some.json
has stdout "row 2"
has some.json '"rejected": 1,'
has some.json 'row 2'
run --size 64x48 --grid 4x3 some.ply --quiet >stdout 2>stderr || fail "status $? of a map with a rejected row"
has stderr '^map some lacks 1 of its 3 rows, which are rejected: row 2'
[ "$(wc -l <stderr)" -eq 1 ] || fail "not one line of what the map lacks: $(cat stderr)"
head -c 100000 /dev/urandom >noise.ply
refuses "noise.ply" noise.ply
{ printf 'ply\n' && head -c 1000000 /dev/zero; } >zeros.ply
refuses "zeros.ply" zeros.ply
mkfifo pipe
for device in /dev/zero /dev/null pipe; do
    [ -e $device ] || continue
    refuses "$device" $device
    refuses "$device" --cameras $device
    refuses "$device" --trajectory $device
    refuses "cannot read the cost model $device (it is a pipe or a device)" --trace refused --cost-model $device
    refuses "cannot read the energy model $device (it is a pipe or a device)" --trace refused --energy $device
done

# --- cameras -----------------------------------------------------------------------------------
# camera NAME FX ROTATION Z: a camera file with one camera; the rotation's first row and second row.
camera() {
    printf '{"cameras": [{"scene": "map", "name": "a", "width": 64, "height": 48, "fx": %s, "fy": 60, "cx": 32, "cy": 24,
    "world_to_camera": [[%s, 0], [%s, 0], [0, 0, 1, %s], [0, 0, 0, 1]]}]}\n' "$2" "$3" "0, 1, 0" "$4" >"$1"
}
straight="1, 0, 0"
camera good_camera.json 60 "$straight" 3
runs map.ply --grid 4x3 --quiet --cameras good_camera.json
for focal in NaN Infinity 1e999 0 -60 null '"60"'; do
    camera bad.json "$focal" "$straight" 3
    refuses "bad.json" map.ply --cameras bad.json
done
for depth in NaN 1e999 1e38; do
    camera bad.json 60 "$straight" "$depth"
    refuses "bad.json" map.ply --cameras bad.json
done
for rotation in "2, 0, 0" "1, 0.5, 0" "0, 1, 0" "0, 0, 0" "-1, 0, 0"; do
    camera bad.json 60 "$rotation" 3
    refuses "bad.json" map.ply --cameras bad.json
done
for text in '' '{' '[]' '{"cameras": 3}' '{"cameras": [3]}' '{"cameras": [{}]}' '{"cameras": []}'; do
    printf '%s' "$text" >bad.json
    refuses "." map.ply --cameras bad.json
done
# Depths of 0.001 (before the near plane), 0.25 (five standard deviations wide on the screen) and 1e30.
for depth in 0.001 0.25 1e30; do
    camera inside.json 60 "$straight" "$depth"
    runs map.ply --grid 4x3 --quiet --cameras inside.json --out inside --float
    if tail -c +15 inside/frame_0000.pfm | od -An -v -tf4 | grep -q -i -e nan -e inf; then
        fail "a picture that is not finite, $depth from a Gaussian"
    fi
done

printf '0 0 0 0 0 0 0 1\n1 word 0 0 0 0 0 1\n' >walk.tum
refuses "line 2" $small map.ply --trajectory walk.tum
printf '0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n' >walk.tum # left out and named, as a row of a map
run $small map.ply --trajectory walk.tum --report nan.json >stdout 2>stderr || fail "status $? for a row that is not finite: $(cat stderr)"
grep -q 'rows left out because a number is not finite: 1 (line 2)' nan.json || fail "the report does not name the row that is not finite"
: >walk.tum
refuses "no pose" $small map.ply --trajectory walk.tum
printf '# nothing\n\n' >walk.tum
refuses "no pose" $small map.ply --trajectory walk.tum
printf '0 0 0 -3 0 0 0 1\n' >walk.tum
runs $small map.ply --trajectory walk.tum --out one_pose
[ "$(find one_pose -name '*.png' | wc -l)" -eq 1 ] || fail "one pose is not one picture"
for text in '0 0 0 0 0 0 0 0' '0 0 0 0 0 0 1' '0 0 0 0 0 0 0 1 2' 'a b c d e f g h'; do
    printf '%s\n' "$text" >walk.tum
    refuses "line 1" $small map.ply --trajectory walk.tum
done

# --- sizes -------------------------------------------------------------------------------------
refuses "whole numbers" map.ply --size 0x0
runs map.ply --size 1x1 --quiet --out tiny --float
refuses "33 x 21.*; write --tile 7x91, --size 1280x720, --program homes or --machine test$" map.ply --size 1283x721 --program anchored
refuses "; write --size 1280x720, --program homes or --machine test$" map.ply --size 1920x1080 --program anchored
runs map.ply --size 1283x721 --tile 7x91 --threads 2 --quiet --out odd --float
runs map.ply --size 1280x720 --threads 2 --quiet --out odd
# Machine test reserves 64 MiB of address space a tile, and uses little of it.
limit=$address_space_kib address_space_kib=
runs map.ply --size 1283x721 --machine test --threads 2 --quiet --out odd_test --float
same odd/frame_0000.pfm odd_test/frame_0000.pfm
runs map.ply --machine test --grid 70x50 --size 64x48 --quiet # more tiles than pixels in a row or column
address_space_kib=$limit
refuses "14.5 GiB.*4.0 GiB" map.ply --size 20000x20000
refuses "28.3 GiB.*leave out --reference" map.ply --size 20000x20000 --reference --machine test
refuses "too large" map.ply --size 65535x65535
refuses "tiles" map.ply --grid 65535x1
refuses "tiles" map.ply --machine test --grid 65535x65535

# --- options -----------------------------------------------------------------------------------
refuses "both given" $small --orbit 1 --frames 2 --trajectory walk.tum
refuses "both given" map.ply --engine sequential --threads 2
for words in "--camera a" "--frames 3" "--orbit 3" "--relative"; do
    # shellcheck disable=SC2086
    refuses "without" map.ply $words
done
refuses "the frame is" map.ply --grid 2x2 --tile 16x20
long=$(head -c 10000 /dev/zero | tr '\0' a)
for option in --camera --orbit --frames --size --preset --grid --tile --machine --channel-slots --storage-slots \
    --saturation --footprint --copies --hops --pixels --arithmetic --quality --background --engine --threads; do
    refuses "^$option cannot be \"aaa" map.ply $option "$long"
done
refuses "." $small map.ply --cameras "$long"
refuses "." $small map.ply --trajectory "$long"
refuses "." $small map.ply --out "$long"
refuses "." $small map.ply --report "$long"
refuses "." "$long"
refuses "no option" "--$long"
refuses "." $small map.ply --out "$(echo "$long" | cut -c 1-256)"
refuses "." $small map.ply --report "$(echo "$long" | cut -c 1-256)"
refuses "there is no option -" -
refuses "cannot be empty" ''

# --- names -------------------------------------------------------------------------------------
# Each is a map, a camera file, a trajectory, a folder and a report; none of them a second line or a wrong file.
printf '0 0 0 -3 0 0 0 1\n' >walk.tum
for name in "with space" "$(printf 'two\nlines')" 'quote"and'"'"'quote' "$(printf 'latin\351')" "$(printf 'escape\033[31m')" \
    'dollar$(x)`y`*' 'back\slash' 'percent%s%n' .hidden; do
    mkdir names
    cp map.ply "names/$name.ply"
    cp walk.tum "names/$name.tum"
    cp good_camera.json "names/$name.json"
    run --size 64x48 --grid 4x3 "names/$name.ply" --cameras "names/$name.json" --camera a --trajectory "names/$name.tum" \
        --out "names/$name" --report "names/$name.report" >stdout 2>stderr || fail "status $? with the name $name: $(cat stderr)"
    [ ! -s stderr ] || fail "standard error with the name $name: $(cat stderr)"
    has_whole_pictures "names/$name"
    is_json "names/$name.report"
    grep -q "$(printf '\033')" stdout && fail "an escape sequence of a name reaches the terminal"
    refuses "such file\|opened" --quiet "names/absent $name.ply"
    rm -r names
done
for name in -dash.ply --quiet; do
    cp map.ply ./$name
    runs $small --out="--$name" --report=--report.json -- $name
    has_whole_pictures "./--$name"
    is_json ./--report.json
done

# --- where nothing can be written --------------------------------------------------------------
: >file
for out in file file/below /dev/full /proc/absent/below; do refuses "cannot write to" $small map.ply --out $out; done
for report in file/report.json absent/report.json good .; do refuses "report" $small map.ply --report $report; done
refuses "this run reads that file" $small map.ply --report map.ply
refuses "this run reads that file" $small map.ply --cameras good_camera.json --camera a --report ./good_camera.json
refuses "a picture of this run" $small map.ply --out good --report good/frame_0000.png
# A COLMAP model is two files: naming one reads both. Links, hard links and `..` lead to a file. No picture goes into a pipe.
mkdir -p sparse links out_of_pipes
printf '1 PINHOLE 64 48 60 60 32 24\n' >sparse/cameras.txt
printf '1 1 0 0 0 0 0 3 1 a\n\n' >sparse/images.txt
cp -r sparse before
for model in sparse sparse/cameras.txt sparse/images.txt; do
    for report in sparse/images.txt sparse/../sparse/cameras.txt; do
        refuses "this run reads that file" map.ply --grid 4x3 --quiet --cameras $model --report $report
    done
done
cp map.ply before
ln -s ../map.ply links/frame_0000.png
refuses "cannot write a picture to links/frame_0000.png (this run reads that file: it is map.ply); name another directory" $small map.ply --out links
refuses "this run reads that file" $small links/frame_0000.png --out links
refuses "this run reads that file" $small map.ply --out links --orbit 1 --frames 2
rm links/frame_0000.png
runs $small map.ply --out links --report links/frame_0000.pfm # no picture has that name without --float
rm links/*
ln map.ply links/frame_0000.pfm
refuses "this run reads that file" $small map.ply --out links --float
ln -s ../linked.json links/frame_0000.png
refuses "that is the file of a picture of this run" $small map.ply --out links --report linked.json
ln -s absent dangling
refuses "cannot write to dangling (dangling is a link to absent, which does not exist)" $small map.ply --out dangling
refuses "cannot write to dangling/below (dangling is a link to absent" $small map.ply --out dangling/below
mkfifo out_of_pipes/frame_0000.png
refuses "frame_0000.png (it is a pipe or a socket" $small map.ply --out out_of_pipes
(run --size 64x48 --grid 4x3 map.ply --out good >>map.ply) 2>stderr
is_refusal $? "standard output cannot go to map.ply (this run reads that file)"
same map.ply before/map.ply
for file in cameras images; do same sparse/$file.txt before/$file.txt; done
runs $small map.ply --out new/folder --report new/folder/report.json
is_json new/folder/report.json
if [ -c /dev/full ]; then
    refuses "No space" $small map.ply --report /dev/full
    [ -c /dev/full ] || fail "a report took the place of /dev/full"
    run --size 64x48 --grid 4x3 map.ply --report after.json >/dev/full 2>stderr
    is_refusal $? "No space"
    is_json after.json
    run --help >/dev/full 2>stderr
    is_refusal $? "No space"
else
    skip "there is no /dev/full"
fi

# A file of more than 16 blocks cannot be written: 36 KB of floats cannot, the PNG can.
(ulimit -f 16 && run $small map.ply --out limited --float) >stdout 2>stderr
is_refusal $? "too large"
has_whole_pictures limited
has_no_parts limited
[ ! -e limited/frame_0000.pfm ] || fail "a file that could not be written has its name"

# What ends a run in the middle does not take the report of the frames before.
mkdir -p stopped/frame_0001.png/in_the_way
refuses "cannot write stopped/frame_0001.png" $small map.ply --out stopped --orbit 1 --frames 3 --report stopped.json
is_json stopped.json
has stopped.json "stopped after frame 1 of 3"
has_no_parts stopped

mkdir disk
if mount -t tmpfs -o size=64k none disk 2>/dev/null; then
    trap 'umount "$work/disk"; rm -rf "$work"' EXIT
    refuses "No space" $small map.ply --out disk --float --orbit 1 --frames 9
    has_whole_pictures disk
    has_no_parts disk
    [ ! -e disk/frame_0008.pfm ] || fail "the disk is larger than it should be"
    if mount -o remount,ro disk 2>/dev/null; then refuses "Read-only" $small map.ply --out disk; fi
    umount disk
    trap 'rm -rf "$work"' EXIT
else
    skip "no file system can be mounted here, so no disk is full"
fi

# --- closed streams ----------------------------------------------------------------------------
for stream in 0 1 2; do
    (eval "exec $stream>&-" && exec timeout 120 "$program" $small map.ply --out closed) || fail "status $? without stream $stream"
    has_whole_pictures closed
    rm -r closed
done
(exec >&- && exec timeout 120 "$program" --size 64x48 --grid 4x3 map.ply --out closed) 2>stderr
is_refusal $? "standard output"
has_whole_pictures closed
(exec 2>&- && exec timeout 120 "$program" absent.ply) >stdout
[ $? -eq 2 ] || fail "a refusal that nobody can read has another status"
[ ! -s stdout ] || fail "a refusal went to standard output"
{
    run --size 64x48 --grid 4x3 map.ply --out closed 2>stderr
    echo $? >status
} | :
is_refusal "$(cat status)" "Broken pipe"

# --- two runs, and interrupts ------------------------------------------------------------------
run $small map.ply --out both --orbit 1 --frames 20 --float &
run $small map.ply --out both --orbit 1 --frames 20 --float || fail "status $? of one of two runs"
wait $! || fail "status $? of the other of two runs"
has_whole_pictures both
has_no_parts both
[ "$(find both -size 36878c -name '*.pfm' | wc -l)" -eq 20 ] || fail "not twenty whole pictures of two runs"

# A background job of a script ignores SIGINT, and so would the program: `env` gives it the signal back.
for signal in INT:130 TERM:143; do
    name=${signal%:*}
    if ! env --default-signal="$name" true 2>/dev/null; then
        skip "env cannot give SIG$name back"
        continue
    fi
    env --default-signal="$name" "$program" $small map.ply --out "SIG$name" --orbit 0.001 --frames 100000 \
        --report "SIG$name/report.json" </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until [ -e "SIG$name/frame_0001.png" ] || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s "$name" $pid
    wait $pid
    status=$?
    [ $status -eq "${signal#*:}" ] || fail "status $status after SIG$name"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line after SIG$name: $(cat stderr)"
    has stderr "^interrupted after frame [0-9]* of 100000 (SIG$name); the frames written are whole"
    has_whole_pictures "SIG$name"
    has_no_parts "SIG$name"
    is_json "SIG$name/report.json"
    has "SIG$name/report.json" "\"interrupted after frame [0-9]* of 100000 (SIG$name)\""
    [ "$(grep -c '"image":' "SIG$name/report.json")" -eq "$(find "SIG$name" -name '*.png' | wc -l)" ] ||
        fail "the report after SIG$name has other frames than there are pictures"
done

finish

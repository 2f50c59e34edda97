#!/bin/sh
# --resume: a run that is killed at any point and started again ends with the pictures and the report of an uninterrupted run.
# Usage: sh render_map_resume.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# A walk that jumps, turns back and stands still: records park, wait, come back, and get lost where room is short.
{
    for x in 0 0.02 0.3 0.3 0.3 0.9 0.1 0.1 0; do echo "$x $x 0 0 0 0 0 1"; done
    echo '9 0.1 0 0 0 0.1 0 1'
    echo '9 0.1 0 0 0 0.1 0 1'
    echo '10 0 0 0 0 0 0 1'
} >walk.tum
# 900 Gaussians in a block, so that ten slots a tile are too few.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 900\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    echo end_header
    awk 'BEGIN { for (i = 0; i < 900; i++) print (i % 15) / 5 - 1.4, int(i / 15) % 10 / 5 - 0.9, 3 + int(i / 150) / 4, 1, i % 7 / 7, 0, 1, -3, -3.5, -2.5, 1, 0, 0.2, 0 }'
} >block.ply
walk="block.ply --trajectory walk.tum --relative --size 160x90 --grid 10x9 --quiet"
frames=12

# counters FILE: a report without what was measured on the host.
counters() { awk '/"host_ms": \{/ { inside = 1 } !inside { print } /\}/ { inside = 0 }' "$1"; }
same_counters() {
    counters "$1" >one.counters
    counters "$2" >other.counters
    same one.counters other.counters
    [ "$(wc -l <one.counters)" -gt 300 ] || fail "$1 has few counters"
}
same_pictures() {
    [ "$(find "$1" -name 'frame_*' | wc -l)" -eq "$(find "$2" -name 'frame_*' | wc -l)" ] || fail "$1 and $2 have other pictures"
    for picture in "$1"/frame_*; do same "$picture" "$2/${picture##*/}"; done
}
# on WORDS...: a run with --resume; it may say that pictures lack something.
on() {
    run "$@" --resume >stdout 2>stderr || fail "status $? of: $*: $(cat stderr)"
}
# cut KEPT: the list of frames as a kill leaves it, with so many whole lines and a part of the next.
cut_off() {
    head -n $((1 + $1)) cut/resume.jsonl >kept
    sed -n "$((2 + $1))p" cut/resume.jsonl | head -c 100 >>kept
    mv kept cut/resume.jsonl
}

# --- cut off after any frame -------------------------------------------------------------------
# Each set of options leaves its own traces from frame to frame.
sets="--channel-slots=2 --copies=screen
--preset=prototype --channel-slots=2 --storage-slots=20
--program=anchored --preset=paper --saturation=hold --storage-slots=25 --float
--program=anchored --storage-slots=20 --depth --alpha
--hops=2
--quality=training --background=1,0.5,0.25
--program=anchored --engine=sequential --storage-slots=30 --channel-slots=1
--storage-slots=20
--program=homes --held=15 --rounds=4 --channel-slots=2"
[ -z "${TILEMESH_FAST:-}" ] || sets=$(echo "$sets" | sed -n '2p;4p;6p;8p')
echo "$sets" >sets
while read -r options; do
    rm -rf whole cut
    # shellcheck disable=SC2086
    {
        on $walk $options --out whole --report whole.json
        run $walk $options --out plain --report plain.json >stdout 2>stderr || fail "$options: $(cat stderr)"
        same_pictures whole plain
        # Without --resume the report says nothing of what it was made from, and all else.
        counters whole.json | awk '/"made_from"/ { inside = 1 } !inside { print } /^ \},/ { inside = 0 }' >one.counters
        counters plain.json >other.counters
        same one.counters other.counters
        for kept in 0 1 4 $((frames - 1)) $frames; do
            cp -r whole cut
            cut_off $kept
            last=$kept
            while [ "$last" -lt $frames ]; do
                rm -f "$(printf 'cut/frame_%04d.png' "$last")"
                last=$((last + 1))
            done
            on $walk $options --out cut --report cut.json
            same_pictures whole cut
            same_counters whole.json cut.json
            rm -r cut
        done
        # Frames in the middle are gone or damaged: 3, in the middle of a view that stands still, and 6, the first of one.
        cp -r whole cut
        rm cut/frame_0003.png
        printf x >>cut/frame_0006.png
        on $walk $options --out cut --report cut.json
        same_pictures whole cut
        same_counters whole.json cut.json
        cp -r cut again
        on $walk $options --out again --report again.json
        same_counters whole.json again.json
        cmp -s whole.json again.json && fail "$options: frames 3 and 6 were not rendered again"
        cmp -s cut.json again.json || fail "$options: what is whole was rendered again"
        rm -r again plain
    }
    case $options in # what is lost, or comes late, in one frame is missed in the next
    --channel* | --quality*) ;;
    --storage-slots=20 | --program=homes*) has whole.json '"program": "homes"' ;;
    *) has whole.json '"cause": ' ;;
    esac
done <sets

# --- killed ------------------------------------------------------------------------------------
# A long run, killed again and again wherever it is, until it ends.
# shellcheck disable=SC2086
long="block.ply --orbit 1 --frames 60 --size 160x90 --grid 10x9 --quiet --float --preset prototype --storage-slots 20"
on $long --out long --report long.json
kills=0
for lines in 1 2 9 23 40; do
    "$program" $long --out killed --report killed.json --resume </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until { [ -e killed/resume.jsonl ] && [ "$(wc -l <killed/resume.jsonl)" -ge $lines ]; } || [ $tries -eq 3000 ]; do
        sleep 0.02
        tries=$((tries + 1))
    done
    kill -s KILL $pid 2>/dev/null && kills=$((kills + 1))
    wait $pid 2>/dev/null
    [ ! -e killed/frame_0000.png ] || has_whole_pictures killed
done
[ $kills -ge 3 ] || fail "only $kills of 5 runs were there to be killed"
on $long --out killed --report killed.json
find killed -name '*.part' -exec rm {} + # what a kill leaves
same_pictures long killed
same_counters long.json killed.json

# --- what goes with it -------------------------------------------------------------------------
# The summary says so; errors against the reference are kept, an infinite one too.
# shellcheck disable=SC2086
{
    small="block.ply --size 64x48 --grid 4x3 --threads 2 --orbit 1 --frames 3"
    runs $small --quiet --reference --out reference --resume --report reference.json
    cp reference/frame_0000.png first.png
    runs $small --reference --out reference --resume --report second.json
    same reference.json second.json
    has stdout "^3 of 3 frames were there from an earlier run"
    has reference.json '"options": \['
    has reference.json '"--orbit=1"'
    # What changes no frame may be another.
    runs block.ply --size 64x48 --grid 4x3 --orbit 1 --frames 3 --threads 1 --quiet --reference --out ./reference --resume --report third.json
    grep -v '"threads"' reference.json >second.json
    grep -v '"threads"' third.json >third
    same second.json third
}

# --- what does not go with it ------------------------------------------------------------------
printf 'ply\nformat ascii 1.0\nelement vertex 1\n' >map.ply
for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done >>map.ply
printf 'end_header\n0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0\n' >>map.ply
small="--size 64x48 --grid 4x3 --threads 2 --quiet"
# shellcheck disable=SC2086
{
    runs map.ply $small --out made --resume --orbit 1 --frames 2
    cp -r made before
    refuses "^cannot resume in made (its frames were rendered with --frames=2 without --frames=3)" map.ply $small --out made --resume --orbit 1 --frames 3
    refuses "(its frames were rendered without --preset=paper)" map.ply $small --out made --resume --orbit 1 --frames 2 --preset paper
    sed 's/^0 0 3/0 0 -3/' map.ply >other && cat other >map.ply
    refuses "(map.ply has changed since)" map.ply $small --out made --resume --orbit 1 --frames 2
    mkdir old
    sed '1s/tilemesh) [0-9.]*/tilemesh) 0.0.0/' made/resume.jsonl >old/resume.jsonl
    refuses "(its frames are of render_map (tilemesh) 0.0.0, this is render_map (tilemesh) " map.ply $small --out old --resume --orbit 1 --frames 2
    same_pictures before made
    same before/resume.jsonl made/resume.jsonl
    mkdir -p strange empty piped folder/resume.jsonl
    echo "my own notes" >strange/resume.jsonl
    : >empty/resume.jsonl
    mkfifo piped/resume.jsonl
    refuses "not the list of frames" map.ply $small --out strange --resume
    refuses "resume.jsonl" map.ply $small --out empty --resume
    refuses "resume.jsonl" map.ply $small --out piped --resume
    refuses "resume.jsonl" map.ply $small --out folder --resume
    refuses "both given" map.ply $small --resume --trace trace
    refuses "that name" map.ply $small --out made --resume --report made/frame_0000.png
    mkdir device && ln -s /dev/null device/frame_0000.png
    refuses "(it is a device, and this run reads its files again)" map.ply $small --out device --resume
    refuses "that is the file of the list of finished frames" map.ply $small --out new --resume --report new/resume.jsonl
}

# A line counts only as it was written: with any other number, name, digest or length its frame is rendered again, and a line says so.
# shellcheck disable=SC2086
{
    small="map.ply --size 64x48 --grid 4x3 --threads 2 --orbit 1 --frames 2"
    runs $small --quiet --out named --resume --report before.json
    cp -r named before_named
    for change in 's/"files":\[[^]]*\]/"files":[]/' 's/"name":"frame_0001.png"/"name":".\/frame_0001.png"/' 's/"visible":[0-9]*/"visible":7/' \
        's/"frame":1,/"frame":0,/' 's/"parked":[0-9]/&9/' 's/"digest":"[^"]*"}$/"digest":"0"}/' 's/,"digest":"[^"]*"}$/}/' 's/.$//' 's/.*/{}/' \
        's/,"report"/, "report"/' 's/$/ /'; do
        sed "3$change" before_named/resume.jsonl >named/resume.jsonl
        cmp -s before_named/resume.jsonl named/resume.jsonl && fail "$change changes nothing"
        on $small --out named --report after.json
        has stderr "^named/resume.jsonl: line 3 changed after the run wrote it (.*); its frame is rendered again$"
        [ "$(wc -l <stderr)" -eq 1 ] || fail "$change: $(cat stderr)"
        has stdout "^1 of 2 frames were there from an earlier run"
        same before_named/frame_0001.png named/frame_0001.png
        same_counters before.json after.json
        runs $small --out named --resume # the frame has a whole line again
        has stdout "^2 of 2 frames were there from an earlier run"
    done
    sed '2,3s/"visible":[0-9]*/"visible":7/' before_named/resume.jsonl >named/resume.jsonl
    on $small --out named --report after.json
    has stderr "line 2 and 1 more changed .*; their frames are rendered again$"
    same_counters before.json after.json
    # A line of another list, with the same pictures.
    runs $small --quiet --out second --resume --quality viewing
    { head -n 1 before_named/resume.jsonl && sed 1d second/resume.jsonl; } >named/resume.jsonl
    on $small --out named --report after.json
    same_counters before.json after.json
}

# The order and the folders of the files do not count, their names and bytes do.
# shellcheck disable=SC2086
{
    small="--size 64x48 --grid 4x3 --threads 2 --frames 2"
    cp map.ply m.ply
    runs --trajectory walk.tum $small m.ply --out spelled --resume --quiet
    runs ./m.ply $small --trajectory "$PWD/walk.tum" --out spelled --resume
    has stdout "^2 of 2 frames were there from an earlier run"
    cp walk.tum stroll.tum
    refuses "(stroll.tum was not among its files)" m.ply $small --trajectory stroll.tum --out spelled --resume
    echo '# other' >>m.ply
    refuses "(m.ply has changed since)" --trajectory walk.tum $small m.ply --out spelled --resume
    mkdir sparse
    echo '1 PINHOLE 64 48 60 60 32 24' >sparse/cameras.txt
    printf '1 1 0 0 0 0 0 3 1 a\n\n' >sparse/images.txt
    runs map.ply --grid 4x3 --cameras sparse/images.txt --out model --resume --report model.json --quiet
    [ "$(head -n 1 model/resume.jsonl | grep -o images.txt | wc -l)" -eq 1 ] || fail "images.txt is listed twice"
    runs map.ply --grid 4x3 --cameras sparse --out model --resume
    has stdout "^1 of 1 frames were there from an earlier run"
}

# A file that cannot be looked at is not left out.
printf '%s' '{"cameras": [{"scene": "map", "name": "a", "width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 32, "cy": 24,
    "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]]}]}' >cameras.txt
ln -s images.txt images.txt
refuses "cannot take the digest of images.txt" map.ply --grid 4x3 --cameras cameras.txt --out ring --resume

finish

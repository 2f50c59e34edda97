#!/bin/sh
# --video: the stream in a file, in a pipe and on standard output, and what becomes of it if a run does not end as planned.
# Usage: sh render_map_video.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

small="--size 37x23 --grid 4x3 --threads 2"
orbit="--orbit 7 --frames 4"
head_line="YUV4MPEG2 W37 H23 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED"
frame_bytes=$((6 + 3 * 37 * 23))

# is_video FILE HEADER FRAMES: the header, so many frames of 37 x 23 pixels, and nothing else.
is_video() {
    equal "the header of $1" "$(head -n 1 "$1")" "$2"
    equal "the bytes of $1" "$(wc -c <"$1")" $((${#2} + 1 + $3 * frame_bytes))
    frame=0
    while [ "$frame" -lt "$3" ]; do
        equal "the line of frame $frame of $1" "$(tail -c +$((${#2} + 2 + frame * frame_bytes)) "$1" | head -c 5)" FRAME
        frame=$((frame + 1))
    done
}
# samples FILE FRAME: the samples of a frame, one a line: Y', Cb, Cr of the first pixel, then of the next.
samples() {
    tail -c +$((${#head_line} + 2 + $2 * frame_bytes + 6)) "$1" | head -c $((3 * 37 * 23)) | od -An -v -tu1 -w1 |
        awk '{ s[NR - 1] = $1 } END { for (i = 0; i < NR / 3; ++i) print s[i], s[NR / 3 + i], s[2 * NR / 3 + i] }'
}
# computed FILE: the same of a PFM, whose rows begin at the bottom, by the matrix of BT.601 with its three decimals.
computed() {
    tail -c +$((1 + $(head -n 3 "$1" | wc -c))) "$1" | od -An -v -tf4 -w12 | awk '
        function unit(v) { return v < 0 ? 0 : v > 1 ? 1 : v }
        { r[NR - 1] = unit($1); g[NR - 1] = unit($2); b[NR - 1] = unit($3) }
        END { for (y = 22; y >= 0; --y) for (x = 0; x < 37; ++x) {
            i = 37 * y + x
            print 16 + 65.481 * r[i] + 128.553 * g[i] + 24.966 * b[i], 128 - 37.797 * r[i] - 74.203 * g[i] + 112 * b[i], 128 + 112 * r[i] - 93.786 * g[i] - 18.214 * b[i]
        } }'
}

# --- a file ------------------------------------------------------------------------------------
# shellcheck disable=SC2086
{
    runs $small $orbit --quiet --out plain --float
    runs $small $orbit --out out --float --video walk.y4m
    has stdout "^wrote walk.y4m, 4 frames at 30 per second$"
}
for picture in plain/*; do same "$picture" "out/${picture##*/}"; done
has_no_parts .
is_video walk.y4m "$head_line" 4
for frame in 0 1 2 3; do
    samples walk.y4m $frame >sampled
    computed out/frame_000$frame.pfm >wanted
    [ "$(wc -l <sampled)" -eq $((37 * 23)) ] || fail "frame $frame has $(wc -l <sampled) pixels"
    paste -d ' ' sampled wanted | awk '{ for (c = 1; c <= 3; ++c) if (($c - $(c + 3)) ^ 2 > 0.503 ^ 2) ++wrong } END { exit wrong > 0 }' ||
        fail "the samples of frame $frame are not those of its picture"
done
# The host, a reference and a trace change no byte; the rate changes the header alone.
for options in "--threads 1" "--engine sequential" "--reference" "--trace traced" "--depth --alpha --report report.json"; do
    # shellcheck disable=SC2086
    runs $(echo "$small" | sed 's/--threads 2//') $orbit --quiet --out out --video other.y4m $options
    same walk.y4m other.y4m
done
# shellcheck disable=SC2086
{
    runs $small $orbit --quiet --out out --video other.y4m --fps 30000/1001
    is_video other.y4m "$(echo "$head_line" | sed 's/30:1/30000:1001/')" 4
    runs $small --quiet --out out --video one.y4m --fps=60
    is_video one.y4m "$(echo "$head_line" | sed 's/30:1/60:1/')" 1
}

# --- standard output and pipes -----------------------------------------------------------------
# shellcheck disable=SC2086
{
    run $small $orbit --out out --video - 2>stderr | cat >piped.y4m
    same walk.y4m piped.y4m
    has stderr "^wrote the video to standard output, 4 frames at 30 per second$"
    run $small $orbit --quiet --out out --video - >redirected.y4m 2>stderr || fail "status $? of a video to standard output"
    same walk.y4m redirected.y4m
    [ ! -s stderr ] || fail "--quiet is not quiet: $(cat stderr)"
    mkfifo pipe
    cat pipe >read.y4m &
    runs $small $orbit --quiet --out out --video pipe
    wait $!
    same walk.y4m read.y4m
    {
        run $small --orbit 1 --frames 400 --quiet --out closed --video - 2>stderr
        echo $? >status
    } | head -c 5000 >beginning
    is_refusal "$(cat status)" "cannot write the video to standard output (Broken pipe); "
    [ "$(find closed -name '*.png' | wc -l)" -lt 400 ] || fail "a run goes on without a reader of its video"
    run $small $orbit --quiet --out out --video - >stderr 2>&1
    is_refusal $? "cannot write the video to standard output (standard error goes there too)"
    (exec >&- && exec timeout 120 "$program" $small --quiet --out out --video -) 2>stderr
    is_refusal $? "cannot write the video to standard output"
    if [ -c /dev/full ]; then
        run $small $orbit --quiet --out out --video - >/dev/full 2>stderr
        is_refusal $? "No space"
        refuses "No space" $small $orbit --quiet --out out --video /dev/full
    fi
}

# --- a run that does not end as planned --------------------------------------------------------
# shellcheck disable=SC2086
{
    echo "the old file" >old
    cp old kept.y4m
    # 2 frames fit into 16 blocks of 512 bytes, or of 1024 in some shells; 10 do not.
    (ulimit -f 16 && run $small --orbit 7 --frames 10 --quiet --out limited --video kept.y4m) >stdout 2>stderr
    is_refusal $? "cannot write kept.y4m (.*too large"
    same old kept.y4m
    has_no_parts .
    has_whole_pictures limited
    mkdir -p stopped/frame_0001.png/in_the_way
    refuses "cannot write stopped/frame_0001.png" $small $orbit --quiet --out stopped --report stopped.json --video kept.y4m
    has stopped.json "stopped after frame 1 of 4"
    same old kept.y4m
    has_no_parts .
}
# A kill leaves the part, and not the name. Ctrl-C leaves the video of the finished frames.
for signal in KILL:137 INT:130; do
    name=${signal%:*}
    if ! env --default-signal="$name" true 2>/dev/null && [ "$name" = INT ]; then
        skip "env cannot give SIG$name back"
        continue
    fi
    # shellcheck disable=SC2086
    env --default-signal=INT "$program" $small --quiet --out "SIG$name" --orbit 0.001 --frames 5000 --video "$name.y4m" </dev/null >stdout 2>stderr &
    pid=$!
    tries=0
    until [ -e "SIG$name/frame_0001.png" ] || [ $tries -eq 600 ]; do
        sleep 0.1
        tries=$((tries + 1))
    done
    kill -s "$name" $pid
    wait $pid 2>/dev/null
    equal "the status after SIG$name" $? "${signal#*:}"
done
[ ! -e KILL.y4m ] || fail "a killed run leaves a video with its name"
[ -e KILL.y4m.part ] || fail "a killed run leaves no part"
rm -f KILL.y4m.part
if [ -e SIGINT ]; then is_video INT.y4m "$head_line" "$(find SIGINT -name '*.png' | wc -l)"; fi
has_no_parts .

# --- what is refused ---------------------------------------------------------------------------
printf '%s' '{"cameras": [
 {"name": "a", "width": 37, "height": 23, "fx": 30, "fy": 30, "cx": 18, "cy": 12, "world_to_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,3],[0,0,0,1]]},
 {"name": "b", "width": 37, "height": 24, "fx": 30, "fy": 30, "cx": 18, "cy": 12, "world_to_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,3],[0,0,0,1]]}]}' >cameras.json
# shellcheck disable=SC2086
{
    refuses "--video needs frames of one size (a has 37 x 23 pixels, b has 37 x 24); add --size, or name one camera" --cameras cameras.json --quiet --video a.y4m
    runs $small --cameras cameras.json --quiet --out out --video two.y4m
    is_video two.y4m "$head_line" 2
    refuses "--resume and --video are both given" $small --video a.y4m --resume
    refuses "--fps is given without --video" $small --fps 30
    for rate in 0 -1 1.5 30/0 0/1 1000001 30/1/1 / "" thirty; do refuses "^--fps cannot be \"$rate\"" $small --video a.y4m --fps "$rate"; done
    cp cameras.json before.json
    refuses "cannot write the video to ./cameras.json (this run reads that file" $small --cameras cameras.json --quiet --video ./cameras.json
    (run $small --cameras cameras.json --quiet --video - >>cameras.json) 2>stderr
    is_refusal $? "standard output cannot go to cameras.json (this run reads that file)"
    same before.json cameras.json
    refuses "a picture of this run has that name" $small --quiet --out out --video out/frame_0000.png
    refuses "that is the file of the report" $small --quiet --report both.json --video both.json
    refuses "a file of the trace of this run has that name" $small --quiet --trace traced --video traced/report.html
    refuses "there is no directory" $small --quiet --video absent/a.y4m
    refuses "it is a directory" $small --quiet --video out
}
[ ! -e a.y4m ] || fail "a refused run leaves a video"
has_no_parts .

finish

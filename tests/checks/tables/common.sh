# shellcheck shell=sh
# Functions for the commands of the tables. run_table.cpp reads this file before each command.
set -u
ply_columns='x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3'
ball='0 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0'
# ply [COLUMN...]: the rows of standard input as a map in ASCII, with these columns after the usual ones.
ply() {
    rows=$(cat)
    printf 'ply\nformat ascii 1.0\nelement vertex %d\n' "$(printf '%s' "$rows" | awk 'END { print NR }')"
    # shellcheck disable=SC2086
    printf 'property float %s\n' $ply_columns "$@"
    printf 'end_header\n%s\n' "$rows"
}
# camera SCENE NAME WIDTH HEIGHT FOCAL Z [MORE]: a camera that looks along +z from -Z, as a member of "cameras"; scene -: any.
camera() {
    printf '{"name": "%s", "width": %s, "height": %s, "fx": %s, "fy": %s, "cx": %s, "cy": %s, %s%s"world_to_camera":
    [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, %s], [0, 0, 0, 1]]}' "$2" "$3" "$4" "$5" "$5" $(($3 / 2)) $(($4 / 2)) \
        "$([ "$1" = - ] || printf '"scene": "%s", ' "$1")" "${7-}" "$6"
}
# cameras CAMERA...: a camera file.
cameras() { printf '{"cameras": [%s' "$1" && shift && if [ $# -gt 0 ]; then printf ', %s' "$@"; fi && printf ']}\n'; }
# colmap FOLDER WIDTH HEIGHT FOCAL NAME...: a model whose first camera is at 0 and whose other cameras stand beside it.
colmap() {
    mkdir -p "$1"
    printf '1 PINHOLE %s %s %s %s %s %s\n' "$2" "$3" "$4" "$4" $(($2 / 2)) $(($3 / 2)) >"$1/cameras.txt"
    to=$1/images.txt x=0
    shift 4
    for name in "$@"; do printf '%s 1 0 0 0 -0.%s 0.1 0.%s 1 %s\n\n' $((x + 1)) $x $x "$name" && x=$((x + 1)); done >"$to"
}
# transforms MORE FRAME...: a transforms.json of 96 x 64 pixels with MORE before its frames. A frame is NAME:X[:MASK], looks along +z and stands at X.
transforms() {
    printf '{"fl_x": 80, "w": 96, "h": 64, %s"frames": [' "$1" && shift
    comma=
    for frame in "$@"; do
        x=${frame#*:} && mask=${x#*:} && x=${x%%:*}
        [ "$mask" != "$x" ] || mask=
        printf '%s{"file_path": "%s", %s"transform_matrix": [[1, 0, 0, %s], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}' "$comma" "${frame%%:*}" \
            "${mask:+\"mask_path\": \"$mask\", }" "$x"
        comma=', '
    done
    printf ']}\n'
}
# blot, and the ball around it whose picture before white is its mask.
blot() { echo 0 0 1.5 5 5 5 9 -2.5 -2.5 -2.5 1 0 0 0 | ply; }
around_blot() { echo 0 0 1.5 -5 -5 -5 9 -1.2 -1.2 -1.2 1 0 0 0 | ply; }
# room OFF: 60 Gaussians; OFF: how far they are from where they should be.
room() {
    awk -v off="$1" 'BEGIN { for (i = 0; i < 60; ++i) {
        e = off * ((i * 37 % 60) / 60 - 0.5); f = off * ((i * 23 % 60) / 60 - 0.5)
        print (i % 10 - 4.5) * 0.3 + 0.1 * e, (int(i / 10) - 2.5) * 0.3 + 0.1 * f, 2.5 + i % 3 + 0.1 * f, 0.1 * (i % 7) + e,
            0.05 * (i % 11) + f, 1 - 0.02 * i - e, 2 + e, -1.6 + f, -1.8 + e, -2 - f, 1, 0.1 * (i % 4) + 0.3 * e, 0.2, 0.2 * f } }' | ply
}
# bytes FILE FROM COUNT: these bytes of a file as hexadecimal digits; a negative FROM counts from the end.
bytes() { if [ "$2" -lt 0 ]; then tail -c "${2#-}" "$1"; else tail -c +$(($2 + 1)) "$1"; fi | head -c "$3" | od -An -v -tx1 | tr -d ' \n'; }
# pixels FILE: the floats of a PFM, without its header of three lines.
pixels() { tail -n +4 "$1"; }
# link WAY FILE NAME: NAME leads to FILE.
link() {
    case $1 in
    link) ln -s "$PWD/$2" "$3" ;;
    hard_link) ln "$2" "$3" ;;
    link_to_link) ln -s "$PWD/$2" "$3.first" && ln -s "$PWD/$3.first" "$3" ;;
    copy) cp "$2" "$3" ;;
    esac
}
# all_same FOLDER OTHER [PATTERN]: each file of a folder, or each that matches, is in the other with the same bytes.
all_same() {
    [ -d "$1" ] && [ -d "$2" ] || exit 1
    find "$1" -type f -name "${3-*}" | { while read -r file; do cmp "$file" "$2/${file#"$1"/}" || exit 1; done; }
}
# untimed FILE: a report without what depends on the host.
untimed() { sed -e '/"host_ms": {/,/}/d' -e '/"engine"/d' -e '/"threads"/d' -e '/"ranks"/d' -e '/"advice"/d' "$1"; }
# begun CONDITION ARGUMENTS...: starts $PROGRAM as $pid, with its output in the files `stdout` and `stderr`, and waits until the condition holds.
begun() {
    until=$1 tries=0
    shift
    rm -f stdout stderr
    # A background job of a script ignores SIGINT; env gives the signal back.
    env --default-signal=INT,TERM "$PROGRAM" "$@" </dev/null >stdout 2>stderr &
    pid=$!
    until eval "$until" 2>/dev/null || [ $tries -eq 3000 ] || ! kill -0 $pid 2>/dev/null; do sleep 0.02 && tries=$((tries + 1)); done
}
# unread ARGUMENTS...: $PROGRAM, after the reader of its standard output has gone. Its status is in the file `status`, its errors in `said`.
unread() {
    rm -f reader.gone status
    { until [ -e reader.gone ]; do sleep 0.02; done && "$PROGRAM" "$@" 2>said || echo $? >status; } | { exec <&- && : >reader.gone; }
}
# stopped SIGNAL:STATUS CONDITION ARGUMENTS...: $PROGRAM gets the signal when the condition holds, and ends with the status.
stopped() {
    signal=$1
    shift
    begun "$@"
    kill -s "${signal%:*}" $pid
    status=0
    wait $pid 2>/dev/null || status=$?
    [ $status -eq "${signal#*:}" ] || { echo "status $status: $(cat stderr)" && exit 1; }
}
# whole FOLDER: it holds a PNG, each PNG ends with its last chunk, and no file.part is left.
whole() {
    ls "$1"/*.png >/dev/null
    for png in "$1"/*.png; do [ "$(bytes "$png" -8 8)" = 49454e44ae426082 ] || exit 1; done
    ! find "$1" -name '*.part' | grep .
}

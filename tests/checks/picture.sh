#!/bin/sh
# What examples/picture promises: the built-in map, or a map that is named, becomes a PNG; bad input is one line and status 2; no map is
# written over.
# Usage: sh picture.sh PATH_TO_picture
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

is_png() { [ "$(head -c 8 "$1" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] || fail "$1 is no PNG"; }
ball() { # [PROPERTIES VALUES]: a map of one ball, 3 m ahead
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    # shellcheck disable=SC2086
    printf 'property float %s\n' x y z f_dc_0 f_dc_1 f_dc_2 ${1-} opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3
    printf 'end_header\n0 0 3 1 0.5 0 %s 2 -1 -1 -1 1 0 0 0\n' "${2-}"
}

runs --help
has stdout '^usage: picture '
runs
is_png picture.png
has stdout "$PWD/picture.png\$"
[ "$(wc -c <picture.png)" -gt 100000 ] || fail "the built-in map has a picture of $(wc -c <picture.png) bytes"
ball >ball.ply
runs ball.ply ball.png
is_png ball.png
has stdout '^The picture of 1 Gaussian'
cmp -s ball.png picture.png && fail "two maps have one picture"
ball "$(seq -f f_rest_%g 0 8)" '9 9 9 9 9 9 9 9 9' >shaded.ply # as trained maps are: its colours depend on the view
runs shaded.ply shaded.png
has stdout '^Each Gaussian has one colour here'
cmp -s ball.png shaded.png || fail "harmonics change the picture"

refuses 'absent.ply' absent.ply
head -c 300 ball.ply >cut.ply
refuses 'cut.ply' cut.ply
refuses 'see picture --help' --depth
refuses 'see picture --help' ball.ply ball.png more
refuses 'see picture --help' ''
cp ball.ply kept.ply
refuses 'this run reads that file' ball.ply ball.ply
ln ball.ply hard_link.png
refuses 'this run reads that file' ball.ply hard_link.png
ln -s ball.ply link.png
refuses 'this run reads that file' ball.ply link.png
refuses 'no_folder' ball.ply no_folder/ball.png
same ball.ply kept.ply
finish

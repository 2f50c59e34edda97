#!/bin/sh
# What render_map says about photographs and other renderers' pictures: --photos, --compare, --error-picture, --every, --scale.
# Usage: sh render_map_photographs.sh PATH_TO_render_map
examples=$(cd "$(dirname "$0")/../../examples" && pwd)
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# number FILE MEMBER [N]: the N-th number of that name in a report; `compared` and the like.
number() { awk -v name="\"$2\":" -v n="${3:-1}" 'index($0, name) && ++found == n { sub(/.*: /, ""); sub(/,$/, ""); print; exit }' "$1"; }
# near VALUE EXPECTED TOLERANCE TEXT
near() { awk -v a="$1" -v b="$2" -v t="$3" 'BEGIN { exit !(a != "" && a != "null" && a - b <= t && b - a <= t) }' || fail "$4 is $1, not $2"; }
# ends STATUS ARGUMENTS...: a run that ends with this status.
ends() {
    wanted=$1
    shift
    run "$@" >stdout 2>stderr
    status=$?
    [ $status -eq "$wanted" ] || fail "status $status, not $wanted, of: $*: $(cat stderr)"
}

# --- a COLMAP model with the program's own pictures as photographs -----------------------------
mkdir -p colmap/sparse/0 colmap/images/left
printf '1 PINHOLE 96 64 80 80 48 32\n' >colmap/sparse/0/cameras.txt
names='left/d.png c.png b.jpg.png a.png e.png'
x=0
for name in $names; do
    echo "$((x + 1)) 1 0 0 0 -0.$x 0.1 0.$x 1 $name"
    echo
    x=$((x + 1))
done >colmap/sparse/0/images.txt
# The built-in map as a file is not there: 60 Gaussians.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 60\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    echo end_header
    awk 'BEGIN { for (i = 0; i < 60; ++i) print (i % 10 - 4.5) * 0.3, (int(i / 10) - 2.5) * 0.3, 2.5 + i % 3, 0.1 * (i % 7), 0.05 * (i % 11), 1 - 0.02 * i, 3, -1.6, -1.8, -2, 1, 0.1 * (i % 4), 0.2, 0 }'
} >room.ply
colmap="room.ply --cameras colmap/sparse/0 --photos colmap/images"
# shellcheck disable=SC2086 # $colmap is several words
runs room.ply --cameras colmap/sparse/0 --float --quiet --out own
frame=0
for name in $names; do
    cp own/frame_000$frame.png "colmap/images/$name"
    frame=$((frame + 1))
done
runs $colmap --out first --report first.json
has stdout '^frame  *camera  *PSNR, dB  *SSIM  *L1$'
has stdout '^ *mean  *5 frames  *[0-9.]*  *[0-9.]*  *0.00[0-9]*$'
has stdout '^ *2  *b.jpg.png  *[0-9]'
[ "$(number first.json compared)" = 5 ] || fail "not all five are compared"
[ "$(number first.json not_compared)" = 0 ] || fail "some are not compared"
# The photographs differ by rounding to 255 levels alone: at most half a level, and about 1/12 level^2 on average where a pixel is not black.
for n in 2 3 4 5 6; do # the first is the mean
    awk -v db="$(number first.json psnr_db $n)" 'BEGIN { exit !(db > 58.5 && db < 66) }' || fail "PSNR of rounding is $(number first.json psnr_db $n)"
    awk -v d="$(number first.json largest $((n - 1)))" 'BEGIN { exit !(d > 0.0015 && d < 0.00197) }' || fail "the largest difference is $(number first.json largest $((n - 1)))"
done
sum=0
for n in 2 3 4 5 6; do sum=$(awk -v a="$sum" -v b="$(number first.json ssim $n)" 'BEGIN { printf "%.15g", a + b }'); done
near "$(number first.json ssim)" "$(awk -v a="$sum" 'BEGIN { printf "%.15g", a / 5 }')" 1e-12 "the mean SSIM"
runs $colmap --camera c.png --quiet --out one --report one.json
near "$(number one.json psnr_db 2)" "$(number first.json psnr_db 3)" 1e-12 "the PSNR of one camera"

# A transparent pixel of a photograph shows the background, as the frame does. The picture has a transparent red pixel and a white one.
printf '\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000\000\002\000\000\000\001\010\006\000\000\000\364\042\177\212\000\000\000\017\111\104\101\124\170\234\143\370\317\300\300\360\037\010\000\021\367\004\374\061\171\316\231\000\000\000\000\111\105\116\104\256\102\140\202' >transparent.png
runs room.ply --from 0,0,-1e6 --look 0,0,-2e6 --size 2x1 --quiet --out away --compare transparent.png --background 1,1,1 --report away.json
near "$(number away.json largest)" 0 0 "the difference of a transparent pixel on white"
runs room.ply --from 0,0,-1e6 --look 0,0,-2e6 --size 2x1 --quiet --out away --compare transparent.png --report away.json
near "$(number away.json largest)" 1 0 "the difference of a white pixel and black"

# Held-out views: every second of the sorted names (a, b, c, e, left/d).
runs $colmap --every 2 --quiet --out held --report held.json
[ "$(grep -o '"camera": "[^"]*"' held.json | tr -d '\n')" = '"camera": "a.png""camera": "c.png""camera": "left/d.png"' ] || fail "other views are held out"
has held.json '3 of 5 cameras: one in 2 of the sorted names'
near "$(number held.json psnr_db 3)" "$(number first.json psnr_db 3)" 1e-12 "the PSNR of a held-out view"
runs $colmap --every 1 --quiet --out held
runs $colmap --every 4294967295 --quiet --out held --report held.json
[ "$(grep -c '"camera":' held.json)" -eq 1 ] || fail "not one view is left"

# Half the size: photographs of the whole size are halved; those of half the size, up or down, are taken as they are.
runs $colmap --scale 2 --quiet --out half --report half.json
[ "$(grep -c '^ *48,$' half.json)" -ge 5 ] || fail "the frames are not 48 pixels wide"
[ "$(number half.json compared)" = 5 ] || fail "not all five are compared at half the size"
for n in 2 3 4 5 6; do near "$(number half.json psnr_db $n)" 33 13 "the PSNR of a halved photograph"; done
mkdir halves
frame=0
for name in $names; do
    cp half/frame_000$frame.png "halves/$(basename "$name")" # without the name's folder
    frame=$((frame + 1))
done
runs room.ply --cameras colmap/sparse/0 --photos halves --scale 2 --quiet --out half --report half.json
for n in 2 3 4 5 6; do near "$(number half.json psnr_db $n)" 62 4 "the PSNR of a photograph of half the size"; done
sed 's/96 64 80 80 48 32/95 63 80 80 48 32/' colmap/sparse/0/cameras.txt >cameras.txt
cp colmap/sparse/0/images.txt .
for size in 48x32 47x31; do # both are half of 95 x 63
    runs room.ply --cameras cameras.txt --camera a.png --size $size --quiet --out odd
    mkdir -p odd_photos && cp odd/frame_0000.png odd_photos/a.png
    runs room.ply --cameras cameras.txt --camera a.png --photos odd_photos --scale 2 --quiet --out odd --report odd.json
    has odd.json "^ *${size%x*},\$"
done

# --- photographs that cannot be compared -------------------------------------------------------
cp -r colmap/images damaged
rm damaged/c.png
cp half/frame_0000.png damaged/a.png
head -c 300 colmap/images/left/d.png >damaged/left/d.png
mv damaged/e.png damaged/e.JPG # the content tells
ends 1 room.ply --cameras colmap/sparse/0 --photos damaged --out first --report damaged.json
[ "$(wc -l <stderr)" -eq 3 ] || fail "not three lines: $(cat stderr)"
has stderr '^damaged/c.png is not compared (there is no such photograph, nor one of that name with .png or .jpg); name the folder that has it with --photos$'
has stderr '^damaged/a.png is not compared (it has 48 x 32 pixels, its camera 96 x 64); name the photographs of these cameras, or choose another --scale$'
has stderr '^damaged/left/d.png cannot be decoded (.*); write it again as PNG or JPEG$'
has stdout '^ *1  *c.png  *not compared *$'
has stdout '^ *mean  *2 frames  *[0-9]'
[ "$(number damaged.json compared)" = 2 ] || fail "the others are not compared"
[ "$(number damaged.json not_compared)" = 3 ] || fail "three cannot be compared"
near "$(number damaged.json psnr_db 4)" "$(number first.json psnr_db 4)" 1e-12 "the PSNR beside damaged photographs"
ends 1 room.ply --cameras colmap/sparse/0 --photos damaged --quiet --out first
[ ! -s stdout ] || fail "--quiet is not quiet"
[ "$(wc -l <stderr)" -eq 3 ] || fail "not three lines with --quiet"
rm damaged/a.png damaged/b.jpg.png && mkfifo damaged/a.png && echo text >damaged/b.jpg.png
ends 1 room.ply --cameras colmap/sparse/0 --photos damaged --quiet --out first
has stderr '^damaged/a.png cannot be opened (it is no regular file); '
has stderr '^damaged/b.jpg.png is not a picture that is read (it is neither PNG nor JPEG); '
mkdir empty
refuses '^--photos empty has no photograph of these cameras (the first is "left/d.png"); ' room.ply --cameras colmap/sparse/0 --photos empty
refuses '^--photos cannot be nowhere (it is no directory' room.ply --cameras colmap/sparse/0 --photos nowhere
refuses '^--photos cannot be room.ply (it is no directory)' room.ply --cameras colmap/sparse/0 --photos room.ply

# --- kinds of pictures -------------------------------------------------------------------------
# A camera that sees nothing, so L1 is the mean of the photograph's levels. The means are those that Pillow decodes.
printf '1 PINHOLE 16 12 20 20 8 6\n' >cameras.txt
printf '1 1 0 0 0 0 0 -100 1 p.png\n' >images.txt
mkdir kinds
kind() { # NAME MEAN TOLERANCE BASE64
    printf '%s' "$4" | base64 -d >"kinds/p.$1"
    runs room.ply --cameras cameras.txt --photos kinds --quiet --out kind --report kind.json
    near "$(number kind.json l1)" "$2" "$3" "the mean of p.$1"
    rm "kinds/p.$1"
}
jpeg=/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMUFRUVDA8XGBYUGBIUFRT/2wBDAQMEBAUEBQkFBQkUDQsNFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBT/wAARCAAMABADAREAAhEBAxEB/8QAFQABAQAAAAAAAAAAAAAAAAAABwj/xAAbEAACAQUAAAAAAAAAAAAAAAAABiMEByIyof/EABgBAAIDAAAAAAAAAAAAAAAAAAUHBAYI/8QAGhEAAgMBAQAAAAAAAAAAAAAAAAMEBSECMf/aAAwDAQACEQMRAD8AnVYtTpDwkqkgSmv/ADRbWLUaQ8Ci5A9aa/8ANFBZXKHGIo6mdGEKaY7NFtYXKHCILKZ0PWmmOzT/2Q==
kind jpg 0.44456699346405226 0.002 "$jpeg"
kind JPEG 0.44474400871459696 0.002 /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMUFRUVDA8XGBYUGBIUFRT/2wBDAQMEBAUEBQkFBQkUDQsNFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBT/wgARCAAMABADASIAAhEBAxEB/8QAFQABAQAAAAAAAAAAAAAAAAAABgf/xAAVAQEBAAAAAAAAAAAAAAAAAAABBP/aAAwDAQACEAMQAAABnS1QuYf/xAAXEAEBAQEAAAAAAAAAAAAAAAAEAAIF/9oACAEBAAEFAjcqNyox8Rj4v//EABcRAAMBAAAAAAAAAAAAAAAAAAADBSH/2gAIAQMBAT8BjWGYf//EABYRAQEBAAAAAAAAAAAAAAAAAAMAAf/aAAgBAgEBPwE32//EABUQAQEAAAAAAAAAAAAAAAAAAAAx/9oACAEBAAY/AoiI/8QAFhABAQEAAAAAAAAAAAAAAAAAACEx/9oACAEBAAE/Ic3NnJz/2gAMAwEAAgADAAAAEGf/xAAVEQEBAAAAAAAAAAAAAAAAAAAAUf/aAAgBAwEBPxCk/8QAFREBAQAAAAAAAAAAAAAAAAAAACH/2gAIAQIBAT8Qkf/EABYQAQEBAAAAAAAAAAAAAAAAAPEAEP/aAAgBAQABPxAqO1O//9k=
kind png 0.4587167162584878 1e-6 iVBORw0KGgoAAAANSUhEUgAAABAAAAAMEAAAAAAeHL4eAAAAMElEQVR42mNkYOdfILCAf4EAColgMTFw4YfEKmBEE2Yk2QQiFWCziCpW4PYBdXwBADLaEU+bU34lAAAAAElFTkSuQmCC
kind png 0.24083044982698965 1e-6 iVBORw0KGgoAAAANSUhEUgAAABAAAAAMCAYAAABr5z2BAAAAI0lEQVR42mMUkdNg4GFgEyAXszDwszEwMJCPRw0YNWBwGAAA4q0HS5UcOgkAAAAASUVORK5CYII=
# A colour key (tRNS) makes its pixels transparent, so black: RGB and grey of 8 bits, RGB of 16.
kind png 0.2 1e-6 iVBORw0KGgoAAAANSUhEUgAAABAAAAAMCAIAAADkharWAAAABnRSTlMAyABkADIwypb3AAAAGklEQVR42mM4kWKEFRmnzcSKGEY1jGrArgEAbuH2AYy9DzkAAAAASUVORK5CYII=
kind png 0.1 1e-6 iVBORw0KGgoAAAANSUhEUgAAABAAAAAMCAAAAABOjGJdAAAAAnRSTlMA/1uRIrUAAAARSURBVHjaY/gPBcZQwDB0BQDt/nLByh90BAAAAABJRU5ErkJggg==
kind png 0.2 1e-6 iVBORw0KGgoAAAANSUhEUgAAABAAAAAMEAIAAAC0FXaVAAAABnRSTlPqYAADADKK2qfhAAAAJUlEQVR42mN4lcDAzGBEPGlsnJY2cybxJMOoBaMWjFowagFhEgC4dHUwGNsxQQAAAABJRU5ErkJggg==
# A JPEG that is cut short is refused at every length that has its header. The decoder alone would fill it with grey.
printf '%s' "$jpeg" | base64 -d >whole.jpg
for bytes in 160 200 300 353 354; do
    head -c $bytes whole.jpg >kinds/p.jpg
    ends 1 room.ply --cameras cameras.txt --photos kinds --quiet --out kind
    has stderr '^kinds/p.jpg cannot be decoded (\(the file is cut short\|its header cannot be read: .*\)); '
done
# A flipped bit in a PNG is one line, and no number. Each byte of one is tried, one bit of each; tests/report/picture_input.cpp tries all.
rm kinds/p.jpg
printf '%s' iVBORw0KGgoAAAANSUhEUgAAABAAAAAMCAAAAABOjGJdAAAAAnRSTlMA/1uRIrUAAAARSURBVHjaY/gPBcZQwDB0BQDt/nLByh90BAAAAABJRU5ErkJggg== | base64 -d >whole.png
for byte in 0 5 9 18 24 28 31 40 45 57 60 66 70 72 74 80 85; do
    cp whole.png kinds/p.png
    old=$(od -An -tu1 -j $byte -N 1 whole.png)
    # shellcheck disable=SC2059 # an octal escape is the format
    printf "\\$(printf %o $((old ^ (1 << byte % 8))))" | dd of=kinds/p.png bs=1 seek=$byte conv=notrunc 2>/dev/null
    ends 1 room.ply --cameras cameras.txt --photos kinds --quiet --out kind
    has stderr '^kinds/p.png \(cannot be decoded\|is not a picture that is read\) (.*); '
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line for a PNG with a flipped bit: $(cat stderr)"
done
rm kinds/p.png
{ cat whole.jpg && echo more; } >kinds/p.jpg # bytes after the end do not matter
runs room.ply --cameras cameras.txt --photos kinds --quiet --out kind

# --- another renderer's picture ----------------------------------------------------------------
one="room.ply --cameras colmap/sparse/0 --camera c.png --quiet"
runs $one --compare own/frame_0001.pfm --out same --report same.json
[ "$(number same.json psnr_db)" = null ] || fail "the PSNR of equal pictures is a number"
[ "$(number same.json ssim)" = 1.0 ] || fail "the SSIM of equal pictures is not 1"
has same.json '"compared": {'
runs $one --compare own/frame_0001.png --out same --report same.json
near "$(number same.json psnr_db)" "$(number first.json psnr_db 3)" 1e-12 "the PSNR against an 8-bit picture"
# One float of a PFM is changed: pixel 10, 3 from the top, green, by 0.5. Its rows go from the bottom up.
runs $one --compare own/frame_0001.pfm --out same --float
header=$(head -n 3 own/frame_0001.pfm | wc -c)
at=$((header + 12 * (96 * (63 - 3) + 10) + 4))
printf '\0\0\340\100' | dd of=same/frame_0000.pfm bs=1 seek=$at conv=notrunc 2>/dev/null # 7.0: a PFM is not clamped
cp same/frame_0000.pfm other.pfm
runs room.ply --cameras colmap/sparse/0 --camera c.png --compare other.pfm --error-picture --out same --report same.json
has stdout '^against other.pfm: PSNR .* dB, SSIM .*, L1 .*, largest difference [67].[0-9]* at pixel 10, 3$'
has stdout 'and as .error.png'
has same.json '"error": "frame_0000.error.png"'
awk -v d="$(number same.json largest)" 'BEGIN { exit !(d > 6 && d <= 7) }' || fail "the largest difference of a PFM is clamped"
has_whole_pictures same
runs $colmap --error-picture --quiet --out errors --report errors.json
[ "$(find errors -name '*.error.png' | wc -l)" -eq 5 ] || fail "an error picture is missing"
ends 1 room.ply --cameras colmap/sparse/0 --photos damaged --error-picture --quiet --out some --report some.json
[ "$(find some -name '*.error.png' | wc -l)" -eq "$(number some.json compared)" ] || fail "an error picture without a comparison"
refuses '^--compare cannot be half/frame_0000.png (it has 48 x 32 pixels, the frame 96 x 64); add --size 48x32 ' $one --compare half/frame_0000.png
refuses '^--compare own/frame_0001.pfm is one picture, and this run has 5 ' room.ply --cameras colmap/sparse/0 --compare own/frame_0001.pfm
refuses '^nothing.png cannot be opened (no such file); ' $one --compare nothing.png
refuses '^room.ply is not a picture that is read ' $one --compare room.ply
refuses 'cannot be decoded' $one --compare damaged/left/d.png

# --- the walk-through of examples/render_map/README.md -----------------------------------------
mkdir -p walk/garden && cd walk || exit 1
cp ../room.ply garden.ply && cp -r ../colmap/sparse ../colmap/images garden && cp ../own/frame_0001.pfm other.pfm
lines=0
while read -r _ arguments; do
    lines=$((lines + 1))
    # shellcheck disable=SC2086
    runs $arguments
    case $arguments in *--every\ 8*) has stdout '^ *mean  *1 frame  *[0-9.]*  *[0-9.]*  *0.00[0-9]*$\|^against garden/images/a.png: PSNR ' ;; esac
done <<EOF
$(grep '^render_map ' "$examples/render_map/README.md")
EOF
[ $lines -ge 5 ] || fail "the walk-through has only $lines commands"
runs garden.ply --cameras garden/sparse/0 --list
[ "$(tr '\n' ' ' <stdout)" = "$names " ] || fail "the names of the cameras are $(cat stdout)"

# --- examples/read_report.py -------------------------------------------------------------------
if have_python; then
    runs garden.ply --cameras garden/sparse/0 --photos garden/images --report all.json --quiet --float --depth --trace trace --out all
    python3 "$examples/read_report.py" all.json trace/frame_0000.tiles.csv all/frame_0000.pfm all/frame_0000.depth.pfm >read 2>&1 || fail "read_report.py: $(cat read)"
    has read '^all.json: map garden, 60 Gaussians$'
    has read '^frame  camera .*  PSNR, dB  *SSIM  *L1$'
    has read "^    1  c.png .* $(awk -v v="$(number all.json psnr_db 3)" 'BEGIN { printf "%.2f", v }') "
    has read '^mean of 5 photographs: PSNR '
    has read '^trace/frame_0000.tiles.csv: [0-9]* rows of '
    has read '^all/frame_0000.pfm: 96 x 64 pixels, values '
    # One value of each picture, at a pixel that od finds too; a column; a member that no frame has.
    header=$(head -n 3 all/frame_0000.pfm | wc -c)
    value=$(od -An -tf4 -j $((header + 12 * (96 * (63 - 30) + 40) + 8)) -N 4 all/frame_0000.pfm | tr -d ' ')
    PYTHONPATH=$examples python3 -c '
import read_report, sys
picture = read_report.load_pfm("all/frame_0000.pfm")
assert len(picture) == 64 and len(picture[0]) == 96 and len(picture[0][0]) == 3
assert abs(picture[30][40][2] - float(sys.argv[1])) < 1e-6, (picture[30][40][2], sys.argv[1])
assert len(read_report.load_pfm("all/frame_0000.depth.pfm")[63]) == 96
report = read_report.load_report("all.json")
assert len(read_report.column(report, "photograph.ssim")) == 5
assert list(read_report.column(report, "nothing.there")) == [None] * 5
tiles = read_report.load_csv("trace/frame_0000.tiles.csv")
assert len(set(len(values) for values in tiles.values())) == 1
' "$value" 2>read || fail "read_report.py: $(cat read)"
    for broken in 'x' '{}' '[]' '{"schema": 1}'; do
        printf '%s' "$broken" >broken.json
        python3 "$examples/read_report.py" broken.json >read 2>&1
        [ $? -eq 2 ] && [ "$(wc -l <read)" -eq 1 ] || fail "a broken report: $(cat read)"
    done
    printf 'PF\n2 2\n-1.0\n123' >broken.pfm
    python3 "$examples/read_report.py" broken.pfm >read 2>&1
    [ $? -eq 2 ] && has read '^read_report: broken.pfm has 3 bytes of pixels, not those of 2 x 2$'
else
    skip "python3 is absent: examples/read_report.py"
fi
cd .. || exit 1

# --- files and options -------------------------------------------------------------------------
# A photograph is never written over.
cp own/frame_0001.png b.png && mkdir over && cp own/frame_0002.png over/frame_0000.png
sed 's/a.png/frame_0000.png/' colmap/sparse/0/images.txt >images.txt
cp colmap/sparse/0/cameras.txt .
refuses 'cannot write pictures to ./over (it is the folder of the photographs); ' room.ply --cameras cameras.txt --photos over --out ./over
# Nor is one of a camera that --every leaves out.
mkdir -p spare/below && cp b.png spare/a.png && cp own/frame_0002.png spare/below/frame_0000.png
refuses 'this run reads that file' room.ply --cameras colmap/sparse/0 --photos spare --every 5 --out spare/below
same own/frame_0002.png spare/below/frame_0000.png
cmp -s own/frame_0002.png over/frame_0000.png || fail "a photograph is written over"
# A run that is resumed has the measures of the frames that it takes over.
runs $colmap --quiet --resume --out resumed --report resumed.json
cp resumed.json uninterrupted.json
sed -i '4d' resumed/resume.jsonl # the third frame
runs $colmap --quiet --resume --out resumed --report resumed.json
for n in 1 2 3 4 5 6; do [ "$(number resumed.json ssim $n)" = "$(number uninterrupted.json ssim $n)" ] || fail "a resumed run has another SSIM"; done
# Without its photograph a frame has no error picture, and is taken over all the same.
cp -r colmap/images lacking && rm lacking/c.png
for _ in 1 2; do ends 1 room.ply --cameras colmap/sparse/0 --photos lacking --error-picture --resume --out again; done
has stdout '^\([0-9]*\) of \1 frames were there from an earlier run$'
cp colmap/images/c.png colmap/images/a.png
refuses 'a.png has changed since' $colmap --quiet --resume --out resumed
refuses 'a camera file names the photographs' room.ply --photos colmap/images
refuses 'it divides the sizes' room.ply --scale 2
refuses 'it counts the poses of a trajectory, or the cameras of a file' room.ply --every 2
refuses '^--photos and --orbit are both given' $colmap --orbit 1 --frames 2
refuses '^--photos and --compare are both given' $colmap --compare b.png
refuses '^--photos and --size are both given' $colmap --size 96x64
refuses '^--scale and --size are both given' room.ply --cameras cameras.txt --size 96x64 --scale 2
refuses '^--error-picture is given without' room.ply --error-picture
refuses '^--scale cannot be "0"' room.ply --cameras cameras.txt --scale 0

finish

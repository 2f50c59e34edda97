#!/bin/sh
# What render_map promises on its command line: pictures, report, one line and status 2 on bad input.
# Usage: sh render_map_cli.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

small="--size 320x180 --quiet"

# --- a picture ---------------------------------------------------------------------------------
runs --help
for option in --cameras --camera --list --from --look --up --fov --orbit --frames --trajectory --trajectory-format --every --ignore-distortion --scale --relative --size --near --antialias --preset --program --grid --tile --machine \
    --channel-slots --storage-slots --held --rounds --fold --saturation --footprint --copies --hops --pixels --arithmetic --quality --background --sh-degree --fit --engine \
    --threads --out --float --depth --alpha --video --fps --reference --photos --compare --error-picture --report --explain --quiet --strict --resume --version --help; do
    has stdout "^  $option "
done
[ "$(awk '{ if (length($0) > most) most = length($0) } END { print most }' stdout)" -le 100 ] || fail "the help is too wide"
runs --version
grep -q '^render_map (tilemesh) [0-9]*\.[0-9]*\.[0-9]*$' stdout || fail "the version is $(cat stdout)"

runs --size 320x180
has stdout "tilemesh_out/frame_0000.png"
has stdout "^composite "
[ "$(head -c 8 tilemesh_out/frame_0000.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] || fail "frame_0000.png is no PNG"
[ ! -e tilemesh_out/frame_0000.pfm ] || fail "a PFM that nobody asked for"

runs $small --out first --float --reference --report first.json
[ ! -s stdout ] || fail "--quiet is not quiet"
has_no_parts .
for key in schema version map machine ledger preset threads advice frames passes exchanges gaussians losses lost copies hops exchanged_bytes pairs peak host_ms \
    error error_same_cuts psnr_db; do
    has first.json "\"$key\":"
done
is_json first.json

# --- one picture, whatever renders it ----------------------------------------------------------
for options in "--engine sequential" "--threads 1" "--threads=3" "--copies screen" "--saturation drop" "--grid 32x32" \
    "--tile 9x7" "--machine test --tile 24x24" "--machine test --grid 1x1" "--machine test --tile 64x40 --engine sequential" \
    "--program anchored" "--program homes" "--program homes --threads 2 --held 300 --channel-slots 9 --fold off" \
    "--program homes --machine test --grid 3x2 --held 40000" "--storage-slots 60" "--held 300 --storage-slots 100" \
    "--channel-slots 5" "--footprint opacity_box --hops quiet --pixels float --arithmetic fast"; do
    # shellcheck disable=SC2086
    runs $small --out other --float $options
    same first/frame_0000.pfm other/frame_0000.pfm
    same first/frame_0000.png other/frame_0000.png
    rm -r other
done

# The picture in bytes is the float picture, rounded.
runs $small --out other --float --pixels rgbx8
same first/frame_0000.png other/frame_0000.png
if cmp -s first/frame_0000.pfm other/frame_0000.pfm; then fail "rgbx8 kept floats"; fi

# One hop a frame: the first picture lacks what is still under way, and the report says what.
runs $small --out other --float --hops 1 --report other.json
if cmp -s first/frame_0000.pfm other/frame_0000.pfm; then fail "one hop was enough"; fi
has other.json '"cause": "late"'

# --- planes ------------------------------------------------------------------------------------
for preset in lossless paper prototype; do
    runs $small --out plain --float --preset $preset
    runs $small --out planes --float --preset $preset --depth --alpha --report planes.json
    same plain/frame_0000.pfm planes/frame_0000.pfm
    for plane in depth alpha; do
        has planes.json "\"$plane\": \"frame_0000.$plane.pfm\""
        [ "$(head -c 2 planes/frame_0000.$plane.pfm)" = Pf ] || fail "frame_0000.$plane.pfm is no grey PFM"
        runs $small --out one_plane --preset $preset --$plane
        same planes/frame_0000.$plane.pfm one_plane/frame_0000.$plane.pfm
    done
    [ "$(find one_plane -name '*.depth.pfm' | wc -l)" -eq 1 ] || fail "a plane that was asked for is missing"
    rm -r plain planes one_plane
done
runs --size 320x180 --depth --alpha
has stdout "and as .depth.pfm and .alpha.pfm"

# --- presets -----------------------------------------------------------------------------------
for preset in lossless paper prototype; do
    runs $small --out threads --float --preset $preset --report report.json
    has report.json "\"preset\": \"$preset\""
    runs $small --out sequential --float --preset $preset --engine sequential
    same threads/frame_0000.pfm sequential/frame_0000.pfm
done
has report.json '"budgeted": false'
has report.json '"note":'
for copies in world screen; do
    for pixels in float rgbx8; do
        runs $small --out threads --float --preset paper --saturation hold --copies $copies --pixels $pixels
        runs $small --out sequential --float --preset paper --saturation hold --copies $copies --pixels $pixels \
            --engine sequential
        same threads/frame_0000.pfm sequential/frame_0000.pfm
    done
done
runs $small --preset prototype --storage-slots 60 --channel-slots 3 --report report.json
# render_map reports what is missing, even with --quiet, and in the notes; with --strict it ends with status 1.
text="frame_0000.png lacks [0-9,]* of the map's 39,517 Gaussians and [0-9,]* copies of others ([0-9,]* storage_full, [0-9,]* channel_full)"
[ "$(wc -l <stderr)" -eq 1 ] || fail "not one line of what is missing: $(cat stderr)"
has stderr "^$text; the fullest tile needs [0-9,]* slots, and there is room with --preset lossless without --storage-slots (2,000 slots a tile), or .*; with --saturation hold records wait for a free slot in a channel$"
has report.json "^  \"$text\"$"
run $small --preset prototype --storage-slots 60 --channel-slots 3 --strict --out strict --report strict.json >stdout 2>strict.err
[ $? -eq 1 ] || fail "--strict has another status than 1"
same stderr strict.err
has_whole_pictures strict
has strict.json "^  \"$text\"$"
runs $small --preset paper --channel-slots 10 # no whole Gaussian is missing: then there are no others
has stderr "^frame_0000.png lacks [0-9,]* copies ([0-9,]* channel_full); with --saturation hold "
runs $small --strict --report report.json
[ ! -s stderr ] || fail "a whole picture lacks something: $(cat stderr)"
has report.json '^ "notes": \[\],$'
runs $small --orbit 1 --frames 3 --hops 2
has stderr "^3 of 3 pictures lack something, most of all frame_000[0-2].png: .* late); with --hops quiet a frame ends when all have arrived$"
# A whole Gaussian counts more than copies: the named frame lacks the most of them, though another lacks more entries. The fullest tile has
# its own frame.
runs $small --orbit 3 --frames 3 --storage-slots 60 --program anchored
has stderr "^3 of 3 pictures lack something, most of all frame_0001.png: [0-9,]* of the map's 39,517 Gaussians and .*; the fullest tile of frame_0000.png needs "
runs $small --preset prototype --storage-slots 60 --channel-slots 3 --report report.json
has report.json '"cause": "channel_full"'
has report.json '"cause": "storage_full"'
has report.json '"storage_slots": 60,'
has report.json '"channel_slots": 3,'

# --- programs ----------------------------------------------------------------------------------
# Where anchored tiles would lack something, auto renders with homes: from that frame on, complete, and says so once.
runs $small --orbit 3 --frames 3 --storage-slots 60 --arithmetic precise --float --out auto --strict --report auto.json
[ ! -s stderr ] || fail "auto lacks something: $(cat stderr)"
runs $small --orbit 3 --frames 3 --machine test --grid 1x1 --arithmetic precise --float --out roomy
for frame in 0 1 2; do same auto/frame_000$frame.pfm roomy/frame_000$frame.pfm; done
has auto.json '^ "program": "auto",$'
[ "$(grep -c '"program": "homes"' auto.json)" -eq 3 ] || fail "not every frame is of homes"
[ "$(grep -c 'the program of homes renders' auto.json)" -eq 1 ] || fail "the change is not said once"
has auto.json 'from frame_0000.png on, the program of homes renders (on anchored tiles, records or copies would be missing)'
has auto.json '"storage_slots": 60,'
runs $small --storage-slots 10 --out auto --float --report auto.json # more records than slots
same first/frame_0000.pfm auto/frame_0000.pfm
has auto.json '"program": "homes"'
# Nothing is missing, or an option is the anchored program's alone: auto stays there.
for options in "" "--preset prototype" "--hops 1" "--copies screen" "--saturation drop --storage-slots 60" "--tile 8x5 --storage-slots 60"; do
    # shellcheck disable=SC2086
    runs $small $options --out stays --report stays.json
    if grep -q '"program": "homes"' stays.json; then fail "homes rendered: $options"; fi
done
runs --size 320x180 --program homes --rounds all
has stdout ", program homes, "
has stdout "^homes: [1-9][0-9]* rounds\{0,1\}, [0-9,]* parcels sent, [0-9,]* entries, 0 refused, 0 tiles unfinished, 0 chapters, 0 bytes streamed$"
# A view that did not change runs nothing.
printf '1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n' >still.tum
runs $small --program homes --trajectory still.tum --float --out still --report still.json
same still/frame_0000.pfm still/frame_0001.pfm
[ "$(grep -c '"rounds": 0' still.json)" -eq 1 ] || fail "the second of two equal views ran rounds"
[ "$(grep -cE '"composite": 0,?$' still.json)" -ge 2 ] || fail "the second of two equal views ran passes"
# A bound on rounds leaves tiles unfinished, and says where.
runs $small --program homes --held 16 --rounds 1 --out cut --report cut.json
has stderr "^frame_0000.png lacks what is far on [0-9,]* tiles ([0-9,]* unfinished, cut at depth [0-9.]* or behind, the nearest on tile [0-9]*); with --rounds all every tile is finished$"
has cut.json '"unfinished": \['
[ "$(sed -n 's/.*"unfinished_tiles": \([0-9]*\).*/\1/p' cut.json)" -eq "$(grep -c '"depth": [0-9]' cut.json)" ] || fail "unfinished tiles are not those of the list"
run $small --program homes --held 16 --rounds 1 --strict --out cut >stdout 2>stderr
[ $? -eq 1 ] || fail "--strict has another status than 1 for unfinished tiles"
# The rules of another preset: its picture on a machine with room for all.
runs $small --preset paper --machine test --grid 1x1 --float --out roomy
runs $small --preset paper --saturation hold --program homes --float --out homes
same roomy/frame_0000.pfm homes/frame_0000.pfm
refuses "^--program homes and --preset paper are both given (homes drop nothing); add --saturation hold, or leave one of them out$" --program homes --preset paper
for options in "--copies screen" "--hops 3" "--tile 32x20"; do
    # shellcheck disable=SC2086
    refuses "^--program homes and ${options%% [0-9]*} are both given (.*); " --program homes $options
done
refuses "^--program homes and --follow are both given (" --program homes --trace traced --follow 7
refuses "^--rounds and --program anchored are both given (only the program of homes has rounds); leave one of them out$" --program anchored --rounds 2
refuses "^--held and --preset paper are both given (" --preset paper --held 100
refuses "^--held cannot be 5000 (homes on machine mk2 have 1 to [0-9,]* slots a tile for this map and frame); choose 1 to [0-9]*$" $small --held 5000
refuses "^--channel-slots cannot be 121 (homes on machine mk2 have 1 to 120 slots a channel" $small --program homes --channel-slots 121
refuses "^--program cannot be \"home\" (there are anchored, homes, auto); choose one of these$" --program home

# --- what the scene does not need ---------------------------------------------------------------
runs $small --out fitted --float --explain --report fitted.json
has stdout "^  routing  *left out  one view, so nothing moves"
has stdout "^  bloom  *kept  "
has stdout "^  depth  *left out"
has fitted.json '"feature": "routing"'
has fitted.json '"route": 0'
if grep -q '"region": "road"' fitted.json; then fail "a road that nobody takes is in the ledger"; fi
runs $small --out unfitted --float --explain --fit off --report unfitted.json
same fitted/frame_0000.pfm unfitted/frame_0000.pfm
has stdout "^  routing  *kept .*kept: --fit off"
has unfitted.json '"region": "road"'
if grep -q '"route": 0' unfitted.json; then fail "--fit off has no routing"; fi
runs $small --explain --hops quiet --channel-slots 50
has stdout "^  routing  *kept .*--channel-slots"
runs --quiet --size 320x180 --out walked --float --orbit 3 --frames 2 --explain --report walked.json
has stdout "^  routing  *kept      2 views that differ"
[ "$(wc -l <stdout)" -lt 12 ] || fail "--quiet --explain prints more than it explains"
runs --size 320x180 --out walked_off --float --orbit 3 --frames 2 --fit off
same walked/frame_0001.pfm walked_off/frame_0001.pfm
# One tile for the frame: nothing spans two.
runs --size 320x180 --out whole --float --machine test --tile 320x180 --explain --report whole.json
has stdout "^  bloom  *left out  the largest footprint touches 1 x 1 tiles"
has whole.json '"bloom": 0'
has whole.json '"messages": 0'
if grep -qE '"region": "(road|beam|bloom debts|credits and flow control)"' whole.json; then fail "an unused region is in the ledger"; fi
runs --size 320x180 --out whole_off --float --machine test --tile 320x180 --fit off
same whole/frame_0000.pfm whole_off/frame_0000.pfm

# --- qualities -----------------------------------------------------------------------------------
# cut_off FILE NAME: its value in the report.
cut_off() { sed -n "/\"cut_offs\"/,/}/s/.*\"$2\": \([0-9.e-]*\).*/\1/p" "$1"; }
# is_about VALUE EXPECTED WHAT: a float's digits.
is_about() { awk -v a="$1" -v b="$2" 'BEGIN { d = a - b; if (d < 0) d = -d; exit !(a != "" && d <= 1e-6 * b) }' || fail "$3 is $1, not $2"; }
# error FILE KEY: the RMSE below it.
error() { awk -v key="\"$2\":" 'index($0, key) { f = 1 } f && /"rmse"/ { gsub(/[^0-9.e-]/, "", $2); print $2; exit }' "$1"; }
has first.json '"quality": "default"'
is_about "$(cut_off first.json alpha_min)" 0.00392156863 alpha_min
is_about "$(cut_off first.json transmittance_min)" 5e-3 transmittance_min
is_about "$(cut_off first.json alpha_max)" 1 alpha_max
last_pairs=999999999999 last_error=0
for row in "evaluation 0.000122549020 1e-4" "viewing 0.0078125 5e-3" "on_sensor 0.015625 1e-2"; do
    # shellcheck disable=SC2086
    set -- $row
    quality=$1 alpha=$2 stop=$3
    runs $small --out of_quality --float --quality "$quality" --reference --report quality.json
    has quality.json "\"quality\": \"$quality\""
    is_about "$(cut_off quality.json alpha_min)" "$alpha" "$quality: alpha_min"
    is_about "$(cut_off quality.json transmittance_min)" "$stop" "$quality: transmittance_min"
    is_about "$(cut_off quality.json alpha_max)" 1 "$quality: alpha_max"
    if cmp -s first/frame_0000.pfm of_quality/frame_0000.pfm; then fail "--quality $quality has the default's picture"; fi
    # The reference with the same cut-offs has those of the quality: it is as near to every one.
    awk -v e="$(error quality.json error_same_cuts)" 'BEGIN { exit !(e != "" && e < 1e-4) }' ||
        fail "--quality $quality is $(error quality.json error_same_cuts) off the reference with its own cut-offs"
    pairs=$(sed -n 's/.*"pairs": \([0-9]*\).*/\1/p' quality.json)
    [ "$pairs" -lt "$last_pairs" ] || fail "--quality $quality evaluates $pairs pairs, the one before $last_pairs"
    awk -v a="$last_error" -v b="$(error quality.json error)" 'BEGIN { exit !(b != "" && a + 0 < b + 0) }' ||
        fail "--quality $quality is no farther off than the one before"
    last_pairs=$pairs last_error=$(error quality.json error)
    runs $small --out unfitted_quality --float --quality "$quality" --fit off
    same of_quality/frame_0000.pfm unfitted_quality/frame_0000.pfm
    runs --size 320x180 --explain --quality "$quality"
    grep '^  records ' stdout >>culled
    rm -r unfitted_quality
done
[ "$(sort -u culled | wc -l)" -eq 3 ] || fail "what is loaded does not depend on the quality"
for preset in paper prototype; do
    if [ -n "${TILEMESH_FAST:-}" ]; then break; fi
    runs $small --out plain --float --preset $preset --report plain.json
    has plain.json '"quality": "default"'
    is_about "$(cut_off plain.json transmittance_min)" 1e-4 "$preset: transmittance_min"
    runs $small --out asked --float --preset $preset --quality on_sensor --report asked.json
    has asked.json '"quality": "on_sensor"'
    is_about "$(cut_off asked.json transmittance_min)" 1e-2 "$preset, on_sensor: transmittance_min"
    is_about "$(cut_off asked.json alpha_max)" 0.99 "$preset, on_sensor: alpha_max"
    if cmp -s plain/frame_0000.pfm asked/frame_0000.pfm; then fail "preset $preset has no on_sensor"; fi
    rm -r plain asked
done
rm -r of_quality

# --- the rules of training, and the background ---------------------------------------------------
runs $small --out trained --float --quality training --background 1,0.5,0.25 --reference --report trained.json
has trained.json '"quality": "training"'
has trained.json '"footprint": "three_sigma_tiles"'
is_about "$(cut_off trained.json alpha_min)" 0.00392156863 "training: alpha_min"
is_about "$(cut_off trained.json transmittance_min)" 1e-4 "training: transmittance_min"
is_about "$(cut_off trained.json alpha_max)" 0.99 "training: alpha_max"
[ "$(sed -n '/"background"/,/]/p' trained.json | tr -d ' \n')" = '"background":[1.0,0.5,0.25],' ] || fail "the report has another background"
awk -v e="$(error trained.json error_same_cuts)" 'BEGIN { exit !(e != "" && e < 1e-4) }' ||
    fail "--quality training is $(error trained.json error_same_cuts) off the reference with its own rules"
runs $small --out trained_unfitted --float --quality training --background 1,0.5,0.25 --fit off --program homes
same trained/frame_0000.pfm trained_unfitted/frame_0000.pfm
runs $small --out black --float --background 0,0,0
same first/frame_0000.pfm black/frame_0000.pfm
# Where nothing is, the frame is the background.
runs --from 0,0,-1e6 --look 0,0,-2e6 --size 2x1 --quiet --out away --float --background 1,0.5,0.25
[ "$(tail -c 24 away/frame_0000.pfm | od -An -tx1 | tr -d ' \n')" = 0000803f0000003f0000803e0000803f0000003f0000803e ] || fail "an empty frame is not the background"
rm -r trained trained_unfitted black away

# --- view-dependent colour ---------------------------------------------------------------------
shaded() { # COLUMNS VALUE: a map of three balls with that many columns of harmonics
    printf 'ply\nformat ascii 1.0\nelement vertex 3\n'
    for p in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3; do echo "property float $p"; done
    i=0
    while [ $i -lt "$1" ]; do echo "property float f_rest_$i" && i=$((i + 1)); done
    echo end_header
    for x in -1 0 1; do
        printf '%s 0 3 1 0.5 0 2 -1 -1 -1 1 0 0 0' $x
        i=0
        while [ $i -lt "$1" ]; do printf ' %s' "$2" && i=$((i + 1)); done
        echo
    done
}
shaded 0 0 >plain.ply
shaded 45 0 >zero.ply
for columns in 9 24 45; do shaded $columns 0.3 >shaded_$columns.ply; done
runs plain.ply $small --out plain --float
runs zero.ply $small --out zero --float --report zero.json --explain
has stdout "view-dependent colour *left out *its coefficients are 0"
same plain/frame_0000.pfm zero/frame_0000.pfm
for columns in 9 24 45; do
    runs shaded_$columns.ply $small --out shaded --float --reference --report shaded.json
    if cmp -s plain/frame_0000.pfm shaded/frame_0000.pfm; then fail "$columns columns of harmonics change nothing"; fi
    awk '/"error_same_cuts"/ { f = 1 } f && /"psnr_db"/ { gsub(/[^0-9.]/, ""); exit !($0 + 0 > 90) }' shaded.json ||
        fail "the picture with harmonics is far from the reference"
    runs shaded_$columns.ply --size 320x180 --out base --float --sh-degree 0
    has stdout "view-dependent colour above degree 0 left out"
    same plain/frame_0000.pfm base/frame_0000.pfm
    runs shaded_$columns.ply $small --out planes --float --depth
    same shaded/frame_0000.pfm planes/frame_0000.pfm
    runs shaded_$columns.ply --size 320x180 --orbit 5 --frames 2 --machine test
    rm -r shaded base planes
done
# Any preset, engine and policy takes it; the reports have the bytes of its records.
runs shaded_45.ply $small --out shaded --float
for options in "--engine sequential" "--copies screen" "--saturation drop" "--machine test --fit off"; do
    # shellcheck disable=SC2086
    runs shaded_45.ply $small --out other --float $options
    same shaded/frame_0000.pfm other/frame_0000.pfm
    rm -r other
done
for preset in paper prototype; do
    runs shaded_45.ply $small --out shaded_$preset --float --preset $preset
    runs shaded_45.ply $small --out other --float --preset $preset --engine sequential --depth
    same shaded_$preset/frame_0000.pfm other/frame_0000.pfm
    if cmp -s shaded_$preset/frame_0000.pfm shaded/frame_0000.pfm; then fail "preset $preset has the picture of lossless"; fi
    rm -r shaded_$preset other
done
rm -r shaded
runs shaded_45.ply --size 320x180 --out explained --depth --explain
has stdout "view-dependent colour *kept .*; a record of 240 bytes, 860 slots a tile"
has stdout "^  depth  *kept      asked for"
has stdout "^  alpha  *left out  not asked for"
[ ! -e explained/frame_0000.alpha.pfm ] || fail "a plane that nobody asked for"
refuses "--storage-slots cannot be 861 (preset lossless on machine mk2 has 1 to 860 slots of 316 bytes a tile for records of degree 3, in 271,760 of a tile's 638,976 bytes; without this option the machine is cut to what the scene needs and has 1,266); choose 1 to 860, or what has room for 861: --machine test or --sh-degree 0$" shaded_45.ply $small --storage-slots 861
runs shaded_45.ply $small --storage-slots 860 --channel-slots 50
refuses "--channel-slots cannot be 51 (preset lossless on machine mk2 has 1 to 50 slots a channel for records of degree 3, in " shaded_45.ply $small --channel-slots 51
refuses "--sh-degree cannot be" --sh-degree 4
refuses "--fit cannot be" --fit me

# --- sequences ---------------------------------------------------------------------------------
runs --size 320x180 --out orbit --orbit -0.5 --frames 3 --float --report orbit.json
has stdout "3 frames"
[ "$(find orbit -name 'frame_000[012].png' | wc -l)" -eq 3 ] || fail "not three frames"
same first/frame_0000.pfm orbit/frame_0000.pfm
if cmp -s orbit/frame_0000.pfm orbit/frame_0001.pfm; then fail "the orbit stands still"; fi
has orbit.json '"camera": "built_in orbit\[2\]"'

printf '# time x y z qx qy qz qw\n0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n2 1.1 2 3 0 0 0 1\n' >walk.tum
runs $small --out walk --trajectory walk.tum --relative --float --report walk.json
same first/frame_0000.pfm walk/frame_0000.pfm
same first/frame_0000.pfm walk/frame_0001.pfm
if cmp -s walk/frame_0001.pfm walk/frame_0002.pfm; then fail "the walk stands still"; fi
has walk.json '"camera": "walk\[2\]"'
runs $small --out walk --trajectory walk.tum
printf '2 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n' >back.tum
runs --size 320x180 --trajectory back.tum --relative --report back.json
has stdout "^  back.tum: stamps that go back in time"
has back.json '"back.tum: stamps that go back in time'
has back.json '"the lens is a guess'
runs $small --out first_two --trajectory walk.tum --relative --frames 2 --float
[ "$(find first_two -name '*.png' | wc -l)" -eq 2 ] || fail "not the first two poses"
same walk/frame_0001.pfm first_two/frame_0001.pfm
# Every second of three poses: the first and the last. Motion is still relative to the first.
runs $small --out walk --trajectory walk.tum --relative --float
runs $small --out every_two --trajectory walk.tum --relative --every 2 --float --report every.json
[ "$(find every_two -name '*.png' | wc -l)" -eq 2 ] || fail "not every second pose"
same walk/frame_0000.pfm every_two/frame_0000.pfm
same walk/frame_0002.pfm every_two/frame_0001.pfm
[ "$(sed -n 's/.*"timestamp_s": \(.*\),$/\1/p' every.json | tr '\n' ' ')" = "0.0 2.0 " ] || fail "the time stamps are not those of poses 0 and 2"
runs $small --out every_two --trajectory walk.tum --every 3 --frames 2 --report every.json
[ "$(grep -c '"timestamp_s"' every.json)" -eq 1 ] || fail "every third of three poses is not one"
cat >cameras.json <<'JSON'
{"cameras": [
 {"scene": "built_in", "name": "a", "width": 320, "height": 180, "fx": 300, "fy": 300, "cx": 160, "cy": 90,
  "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]},
 {"scene": "built_in", "name": "b", "width": 160, "height": 90, "fx": 150, "fy": 150, "cx": 80, "cy": 45,
  "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]}
JSON
runs --quiet --out all --cameras cameras.json --report all.json
[ "$(find all -name '*.png' | wc -l)" -eq 2 ] || fail "not two cameras"
has all.json '"camera": "built_in/b"'
runs --quiet --out one --cameras cameras.json --camera b --size 320x180 --float
runs --quiet --out two --cameras cameras.json --camera built_in/a --float
same one/frame_0000.pfm two/frame_0000.pfm
runs --quiet --out three --cameras cameras.json --camera a --orbit 1 --frames 2

# --- progress ----------------------------------------------------------------------------------
# Nothing where standard error is no terminal (`runs` sees to that); with one, how long it will take.
if have_python && python3 -c 'import pty' 2>/dev/null; then
    python3 -c 'import pty, sys; sys.exit(pty.spawn(sys.argv[1:]) >> 8)' "$program" --size 320x180 --orbit 1 --frames 3 \
        </dev/null >terminal 2>&1 || fail "status $? on a terminal"
    has terminal "frame 1 of 3, built_in orbit\[0\]: rendering..\[K"
    has terminal "frame 3 of 3, built_in orbit\[2\]: rendering, [0-9]*:[0-9][0-9] left"
else
    skip "python3 is absent, so there is no terminal to look at"
fi

# --- what is refused ---------------------------------------------------------------------------
refuses "no option --colour" --colour blue
refuses "write --camera, or see" --camrea a
refuses "write --trajectory, or see" --traj walk.tum
refuses "^[^;]*; see render_map --help" --nonsense
refuses "no option -x" -x
refuses "given twice" --size 1x1 --size=2x2
refuses "absent.ply cannot be opened" absent.ply other.ply
refuses "absent.ply" absent.ply
refuses "is a folder without meta.json" .
printf 'not a map\n' >bad.ply
refuses "bad.ply" bad.ply
printf 'a\nb' >"$(printf 'two\nlines.ply')"
refuses "two?lines.ply" "$(printf 'two\nlines.ply')"
for option in --cameras --camera --orbit --frames --trajectory --trajectory-format --size --preset --grid --tile --machine --channel-slots \
    --storage-slots --saturation --footprint --copies --hops --pixels --arithmetic --quality --background --engine --threads --out --report; do
    refuses "^$option has no value" $option
    refuses "^$option has no value" $option --quiet
done
for option in --preset --machine --saturation --footprint --copies --pixels --engine --arithmetic --quality; do
    refuses "there are .*choose one" $option nonsense
done
for option in --size --grid --tile; do
    for value in 12 0x5 5x0 x 5x 5x5x5 65536x1 -1x5 1e1x5 " 5x5"; do refuses "two whole numbers" $option "$value"; done
done
for option in --frames --every --channel-slots --storage-slots --threads --hops; do
    for value in -1 1.5 x 99999999999999999999 "" 1k; do refuses "whole number" $option "$value"; done
    case $option in --*-slots) ;; *) refuses "whole number" $option 0 ;; esac
done
for value in x nan inf "" 1x; do refuses "degrees" --orbit "$value"; done
for value in x "" 1 1,1 1,1,1,1 1,1,1x nan,0,0 -0.1,0,0 0,0,1.01 0,inf,0 "1, 1,1"; do
    refuses "^--background cannot be .*three numbers from 0 to 1" --background "$value"
done
refuses "takes no value" --quiet=yes
for option in --cameras --trajectory --out --report; do refuses "empty" $option ""; done
refuses "without --cameras" --camera a
refuses "without --orbit" --frames 3
refuses "without --frames" --orbit 3
refuses "without --trajectory" --relative
refuses "without --trajectory" --trajectory-format tum
refuses "there are .*choose one" --trajectory walk.tum --trajectory-format csv
refuses "without --trajectory" --every 2
refuses "both given" --orbit 1 --frames 2 --trajectory walk.tum
refuses "both given" --engine sequential --threads 2
refuses "has 1 to 2,000 slots of 136 bytes a tile for records of degree 0, in 272,000 of a tile's 638,976 bytes; without this option the machine is cut to what the scene needs and has 2,941); choose 1 to 2000, or what has room for 2,900: --preset paper or --machine test$" --storage-slots 2900
runs $small --storage-slots 2000
runs $small --storage-slots 2001 --machine test
refuses "has 1 to 800 slots" --storage-slots 801 --preset prototype
refuses "choose 1 to 100, or what has room for 101: --preset lossless or --preset paper$" --channel-slots 101 --preset prototype
runs $small --preset lossless --channel-slots 101
refuses "choose 1 to 200, or what has room for 201: --preset paper$" --channel-slots 201
runs $small --preset paper --channel-slots 201
runs $small --preset paper --storage-slots 2900
refuses "^--channel-slots cannot be 0 (preset lossless on machine mk2 has 1 to 200 slots a channel for records of degree 0, in 198,400 of a tile's 638,976 bytes); choose 1 to 200$" --channel-slots 0
refuses "has 1 to 40,000 slots" --storage-slots 0 --machine test
for preset in paper prototype; do
    refuses "^--hops 3 and --preset $preset are both given (.*); choose --preset lossless, or leave --hops out$" --preset $preset --hops 3
done
runs $small --preset lossless --hops 3
refuses "(it takes a whole number, 1 or more); " --hops 0
refuses "absent.json" --cameras absent.json
refuses "no camera \"c\"" --cameras cameras.json --camera c
refuses "camera that moves" --cameras cameras.json --orbit 1 --frames 2
refuses "bad.ply is not JSON" --cameras bad.ply
refuses "line 1" --trajectory bad.ply
refuses "framebuffer.*, --program homes or --machine test" --size 1920x1080 --program anchored
refuses "framebuffer" --size 7680x4320 --machine mk2
refuses "homes have no room for its pixels" --size 7680x4320 --machine mk2 --program homes
runs --size 1920x1080
has stdout "the program of homes renders (anchored tiles have no room for its pixels)"
runs --size 7680x4320
has stdout "machine test (64 MiB a tile): a frame of 7680 x 4320 pixels has no room on mk2"
refuses "a near plane is a distance above 0" --near 0
refuses "a near plane is a distance above 0" --near 1e400
refuses "^--near and --quality training are both given" --near 1 --quality training
refuses "mk2 has 1472" --grid 64x64
refuses "the frame is" --grid 2x2 --tile 16x20
refuses "too large" --machine test --grid 65535x65535
refuses "too large" --machine test --tile 1x1 --size 65535x1000
refuses "too large" --machine test --size 65535x65535
refuses "slots hold" $small --storage-slots 10 --program anchored
: >file
refuses "directory" $small --out file
refuses "file" $small --out file/below
refuses "report" $small --report absent/report.json
refuses "report" $small --report .
if [ "$(id -u)" -ne 0 ]; then
    mkdir closed && chmod 555 closed
    refuses "Permission" $small --out closed
    refuses "Permission" $small --out closed/below
fi

finish

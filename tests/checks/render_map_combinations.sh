#!/bin/sh
# render_map runs every combination of preset, machine, engine, saturation, copies, pixels, planes, harmonics, rules and trace, or refuses it because
# it does not fit, with the region and its bytes. This check tries a pairwise cover of them: every pair of values is in some run.
# Usage: sh render_map_combinations.sh PATH_TO_render_map
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"

# Small tiles of a small frame: the picture has 6 x 4 of them, and Gaussians that span several.
small="--size 96x64 --grid 6x4 --quiet"

# --- maps --------------------------------------------------------------------------------------
# made_map DEGREE: sixty Gaussians before the camera, as ASCII PLY, with harmonics of that degree.
made_map() {
    awk -v degree="$1" '
        # A generator of its own, so that every awk makes the same map: 0 to 1.
        function next_one() { seed = (seed * 1103 + 12345) % 65536; return seed / 65536 }
        function between(a, b) { return a + (b - a) * next_one() }
        BEGIN {
            seed = 7
            columns = 3 * ((degree + 1) * (degree + 1) - 1)
            print "ply\nformat ascii 1.0\nelement vertex 60"
            n = split("x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3", names, " ")
            for (i = 1; i <= n; ++i) print "property float " names[i]
            for (i = 0; i < columns; ++i) print "property float f_rest_" i
            print "end_header"
            for (g = 0; g < 60; ++g) {
                line = between(-1.5, 1.5) " " between(-1, 1) " " between(2, 4)
                for (i = 0; i < 3; ++i) line = line " " between(-1, 2)
                line = line " " between(-1, 8)
                for (i = 0; i < 3; ++i) line = line " " between(-4, -1.5)
                line = line " 1 " between(-0.5, 0.5) " " between(-0.5, 0.5) " " between(-0.5, 0.5)
                for (i = 0; i < columns; ++i) line = line " " between(-0.3, 0.3)
                print line
            }
        }' </dev/null >"degree_$1.ply"
}
for degree in 0 1 2 3; do made_map $degree; done

# --- the cover ---------------------------------------------------------------------------------
# A factor a line: its values, separated by "|", as they stand on the command line. "." is nothing: as the preset has it.
# Engine and trace are one factor: with planes they decide which of the compiled renderers runs, and the cover has each.
cat >factors <<'END'
--preset lossless|--preset paper|--preset prototype
--machine mk2|--machine test
--engine threads|--engine sequential|--engine threads --trace|--engine sequential --trace
.|--saturation hold|--saturation drop
.|--copies world|--copies screen
.|--pixels float|--pixels rgbx8
.|--depth|--alpha|--depth --alpha
degree_0.ply|degree_1.ply|degree_2.ply|degree_3.ply|degree_3.ply --sh-degree 0
.|--background 0,1,0.5|--quality training --background 0,1,0.5
END
# Greedy: a run begins with the first pair that no run has, and takes of each other factor the value with most new pairs.
awk -F'|' '
    { for (v = 1; v <= NF; ++v) value[NR, v] = $v; values[NR] = NF }
    function key(f, v, g, w) { return f < g ? f "," v "," g "," w : g "," w "," f "," v }
    END {
        for (f = 1; f < NR; ++f) for (g = f + 1; g <= NR; ++g)
            for (v = 1; v <= values[f]; ++v) for (w = 1; w <= values[g]; ++w) { open[key(f, v, g, w)] = 1; ++left }
        while (left > 0) {
            for (h = 1; h <= NR; ++h) row[h] = 0
            begun = 0
            for (f = 1; f < NR && !begun; ++f) for (g = f + 1; g <= NR && !begun; ++g)
                for (v = 1; v <= values[f] && !begun; ++v) for (w = 1; w <= values[g] && !begun; ++w)
                    if (open[key(f, v, g, w)]) { row[f] = v; row[g] = w; begun = 1 }
            for (h = 1; h <= NR; ++h) {
                if (row[h]) continue
                most = -1
                for (i = 0; i < values[h]; ++i) {
                    v = 1 + (i + runs) % values[h] # so that a value that is as good as another is not always the first
                    new = 0
                    for (g = 1; g <= NR; ++g) if (row[g]) new += open[key(h, v, g, row[g])]
                    if (new > most) { most = new; best = v }
                }
                row[h] = best
            }
            line = ""
            for (h = 1; h <= NR; ++h) {
                line = line (h > 1 ? "|" : "") value[h, row[h]]
                for (g = 1; g < h; ++g) if (open[key(h, row[h], g, row[g])]) { open[key(h, row[h], g, row[g])] = 0; --left }
            }
            print line
            ++runs
        }
    }' factors >cover
# It is complete: counted again from the runs alone, without the code that made them.
awk -F'|' '{ for (f = 1; f < NF; ++f) for (g = f + 1; g <= NF; ++g) print f " " $f ", " g " " $g }' cover | sort -u >pairs
awk -F'|' '{ for (v = 1; v <= NF; ++v) value[NR, v] = $v; n[NR] = NF }
    END { for (f = 1; f < NR; ++f) for (g = f + 1; g <= NR; ++g)
        for (v = 1; v <= n[f]; ++v) for (w = 1; w <= n[g]; ++w) print f " " value[f, v] ", " g " " value[g, w] }' factors | sort >all_pairs
[ "$(wc -l <all_pairs)" -gt 300 ] || fail "there are only $(wc -l <all_pairs) pairs of values"
same pairs all_pairs
[ "$(wc -l <cover)" -le 40 ] || fail "the cover has $(wc -l <cover) runs"

# words_of LINE: a line of the cover as words of a command line.
words_of() { echo "$1" | tr '|' '\n' | grep -v '^\.$' | tr '\n' ' '; }
# value_of LINE OPTION: what the line gives the option; empty: nothing.
value_of() { echo "$1" | tr '|' '\n' | sed -n "s/^$2 \([a-z0-9]*\).*/\1/p"; }

# --- every run ---------------------------------------------------------------------------------
# The picture depends on the map, on the preset's rules, and on the rules and the background that are asked for; `paper` and `prototype`
# have the same.
# picture_of PRESET MAP RULES: the folder of that picture.
picture_of() { if [ "$3" = . ]; then echo "$1 $2"; else echo "$1 $2 $3"; fi; }
sed -n 9p factors | tr '|' '\n' >rules
while IFS= read -r map; do
    for preset in lossless paper; do
        while IFS= read -r rule; do
            # shellcheck disable=SC2086
            runs $map $small --preset $preset --machine test --fit off --out "$(picture_of $preset "$map" "$rule")" $(words_of "$rule")
        done <rules
    done
done <<END
$(sed -n 8p factors | tr '|' '\n')
END
differ() { if cmp -s "$1/frame_0000.png" "$2/frame_0000.png"; then fail "$1 and $2 have one picture"; fi; }
differ "lossless degree_3.ply" "paper degree_3.ply"
differ "lossless degree_3.ply" "lossless degree_3.ply --background 0,1,0.5"
differ "lossless degree_3.ply --background 0,1,0.5" "lossless degree_3.ply --quality training --background 0,1,0.5"
same "lossless degree_3.ply --quality training --background 0,1,0.5/frame_0000.png" "paper degree_3.ply --quality training --background 0,1,0.5/frame_0000.png"
for preset in lossless paper; do
    differ "$preset degree_3.ply" "$preset degree_3.ply --sh-degree 0"
    for degree in 1 2 3; do differ "$preset degree_$degree.ply" "$preset degree_$((degree - 1)).ply"; done
done

# is_combination LINE: it runs, with what it asks for, and its picture is whole and right; or it does not fit, with the bytes.
is_combination() {
    rm -rf out traced report.json
    # shellcheck disable=SC2046
    run $small --out out --report report.json $(words_of "$1" | sed 's/--trace/--trace traced/') >stdout 2>stderr
    status=$?
    if [ $status -ne 0 ]; then
        is_refusal $status "does not fit .*region .* [0-9]* bytes"
        refused=$((refused + 1))
        return
    fi
    [ ! -s stderr ] || fail "standard error of $1: $(cat stderr)"
    preset=$(value_of "$1" --preset)
    has report.json "\"preset\": \"$preset\""
    has report.json "\"engine\": \"$(value_of "$1" --engine)\""
    for policy in saturation copies; do
        value=$(value_of "$1" --$policy)
        [ -z "$value" ] || has report.json "\"$policy\": \"$value\""
    done
    case $1 in
    *"--pixels float"*) has report.json '"pixels": "float' ;;
    *"--pixels rgbx8"*) has report.json '"pixels": "rgbx8"' ;;
    esac
    for plane in depth alpha; do
        case $1 in
        *--$plane*) [ "$(head -c 2 out/frame_0000.$plane.pfm)" = Pf ] || fail "no plane $plane of $1" ;;
        *) [ ! -e out/frame_0000.$plane.pfm ] || fail "a plane $plane that nobody asked for, of $1" ;;
        esac
    done
    case $1 in
    *--trace*) [ -s traced/report.html ] || fail "no trace of $1" ;;
    *) [ ! -e traced ] || fail "a trace that nobody asked for, of $1" ;;
    esac
    has_no_parts out
    has_whole_pictures out
    [ "$preset" = lossless ] || preset=paper
    same "$(picture_of $preset "$(echo "$1" | cut -d'|' -f8)" "$(echo "$1" | cut -d'|' -f9)")/frame_0000.png" out/frame_0000.png
}
refused=0
while IFS= read -r line; do is_combination "$line"; done <cover
[ $refused -eq 0 ] || fail "$refused of $(wc -l <cover) combinations do not fit; with the presets' sizes all of them do"

# --- engines and threads -----------------------------------------------------------------------
# The same pictures, planes and counters from either engine and from any number of threads: two views, so that records move. A report says
# besides how long the host took and which engine it had.
told() { sed '/"host_ms"/,/}/d' "$1" | grep -v -e '"engine"' -e '"threads"'; }
while IFS= read -r words; do
    # shellcheck disable=SC2086
    for host in "--engine threads --threads 1" "--engine threads --threads 2" "--engine sequential"; do
        out="host $host"
        rm -rf "$out"
        runs $small --fit off --orbit 20 --frames 2 --float $words $host --out "$out" --report "$out.json"
    done
    first="host --engine threads --threads 1"
    told "$first.json" >expected
    [ "$(grep -c '"moved": [1-9]' expected)" -gt 0 ] || fail "nothing moves in: $words"
    for other in "host --engine threads --threads 2" "host --engine sequential"; do
        told "$other.json" >got
        cmp -s expected got || fail "the reports of $first and $other differ: $words: $(diff expected got | head -n 4 | tr '\n' ' ')"
        for file in "$first"/*; do same "$file" "$other/${file##*/}"; done
        [ "$(find "$first" -type f | wc -l)" -eq "$(find "$other" -type f | wc -l)" ] || fail "$first and $other have other files: $words"
    done
done <<'END'
degree_0.ply
degree_3.ply --depth --alpha
degree_1.ply --copies screen --channel-slots 2
degree_2.ply --preset paper --saturation hold --pixels float --channel-slots 1
degree_2.ply --preset prototype --channel-slots 3 --storage-slots 20
degree_3.ply --machine test --saturation drop --pixels rgbx8 --alpha --storage-slots 30
END

# --- the program of homes ----------------------------------------------------------------------
# Each degree, plane, pixel and trace on either engine: the picture of the anchored program.
while IFS= read -r words; do
    rm -rf out anchored traced
    # shellcheck disable=SC2086
    {
        runs $small --float --machine test --fit off --out anchored ${words%% --trace*}
        runs $small --float --program homes --held 20 --channel-slots 3 --out out --report report.json $words
    }
    has report.json '"program": "homes"'
    for file in anchored/*; do same "$file" "out/${file##*/}"; done
    case $words in *--trace*) [ -s traced/report.html ] || fail "no trace of homes: $words" ;; esac
done <<'END'
degree_0.ply --pixels rgbx8
degree_1.ply --depth --alpha --footprint three_sigma_square
degree_2.ply --engine sequential --quality on_sensor
degree_3.ply --alpha --pixels rgbx8 --engine sequential
degree_3.ply --sh-degree 0 --threads 2
degree_3.ply --arithmetic precise --trace traced
degree_2.ply --quality training --background 1,0.5,0.25 --depth --alpha
degree_1.ply --quality training --background 1,0.5,0.25 --engine sequential
degree_1.ply --depth --engine sequential --trace traced
END
# The engines and any number of threads count the same.
for host in "--threads 1" "--threads 2" "--engine sequential"; do
    rm -rf out
    # shellcheck disable=SC2086
    runs degree_1.ply $small --orbit 20 --frames 2 --program homes --held 20 --out out --report "homes $host.json" $host
    told "homes $host.json" >got
    [ "$host" != "--threads 1" ] || cp got expected
    cmp -s expected got || fail "homes $host: the report differs: $(diff expected got | head -n 4 | tr '\n' ' ')"
done

# --- what is refused ---------------------------------------------------------------------------
# A frame whose tiles have too many pixels, and a capacity that the SRAM has no room for.
# shellcheck disable=SC2086
{
    refuses "does not fit on machine mk2 (40 x 36 tiles would have 48 x 30 pixels each, and the framebuffer of a tile has 640)" \
        degree_3.ply --size 1920x1080 --depth --alpha --program anchored
    refuses "^--storage-slots cannot be 2000 (preset lossless on machine mk2 has 1 to [0-9]* slots of 316 bytes a tile for records of degree 3, in " degree_3.ply $small --storage-slots 2000
}
# Whatever else is asked for, a value that is mistyped is one line.
for words in "--preset papr" "--machine mk3" "--engine thread" "--saturation halt" "--copies wold" "--pixels flaot" "--sh-degree 4" "--fit scenes"; do
    # shellcheck disable=SC2086
    refuses "^${words% *} cannot be \"${words#* }\" (there are .*); choose one of these" degree_3.ply $small --out mistyped $words
done
[ ! -e mistyped ] || fail "a folder for a run that was refused"

finish

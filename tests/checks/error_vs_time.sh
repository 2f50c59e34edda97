#!/bin/sh
# usage: error_vs_time.sh PROGRAM PFM_ERROR [CSV ...]
# Runs some twenty settings of every kind on the built-in map, in small frames and without data, and checks each row of the CSV by
# arithmetic of its own: where nothing is missing the mesh's picture is the whole frame's, the split of the error adds up to the printed
# digits, fronts and named settings are where pairs and errors put them, what failed says why. PFM_ERROR measures the written pictures
# again: equal to the last digit. Results do not depend on threads, --spoil is found out, mistakes are refused with one line.
# Each CSV of a whole run (--quick or full) that is named is checked in the same way, and has at least 60 settings a map.
set -eu
export LC_ALL=C
program=$1
pfm_error=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export TILEMESH_DATA="$folder/none"
failed=0
complain() { echo "$*" && failed=1; }

beginning=scene,camera,setting,e_cut_rmse,e_round_rmse,e_mesh_max,psnr_db,ssim,max_levels,modelled_ms,host_ms,pairs,on_front

# A field in quotes may hold commas and quotes: they are replaced, and the quotes around it go.
plain() {
    awk '{ out = ""; inside = 0
           for (i = 1; i <= length($0); ++i) {
               c = substr($0, i, 1)
               if (c == "\"" && inside && substr($0, i + 1, 1) == "\"") { out = out "_"; ++i }
               else if (c == "\"") inside = !inside
               else out = out (inside && c == "," ? ";" : c)
           }
           print out }' "$1"
}

# Every row of the CSV $1; at least $2 settings have a result in each single view.
check_rows() {
    case $(head -1 "$1") in
    "$beginning",*) ;;
    *) complain "$1 begins with $(head -1 "$1" | cut -c1-200)" ;;
    esac
    plain "$1" >"$folder/plain.csv"
    awk -F, -v least="$2" '
        function of(name) { if (!(name in at)) { print "no column " name; exit bad = 1 } return $(at[name]) }
        function wrong(what) { print "row " NR " (" row "): " what; bad = 1 }
        function near(a, b, tolerance, what, d) { d = a - b; if (!((d < 0 ? -d : d) <= tolerance)) wrong(what ": " a " against " b) }
        # Half a unit of the last of five digits.
        function half_unit(text, part) { split(text, part, "e"); return text + 0 == 0 ? 0 : 0.5 * 10 ^ (part[2] - 4) }
        # The power that a root mean square printed as text stands for, and how far off it may be by its rounding.
        function square(text) { return text * text }
        function square_off(text, h) { h = half_unit(text); return 2 * text * h + h * h }
        # -20 log10 of five digits, printed with three decimals.
        function check_psnr(rmse, psnr, what) {
            if (rmse + 0 == 0) { if (psnr != "inf") wrong(what " of equal pictures is " psnr); return }
            near(-20 * log(rmse) / log(10), psnr, 20 / log(10) * half_unit(rmse) / rmse + 0.00051, what)
        }
        # Four significant digits of five: where the fifth is 5, what was cut off decides, and both are possible.
        function low4(text, part) { split(text, part, "e"); return substr(part[1], 6, 1) == 5 ? substr(part[1], 1, 5) "e" part[2] : sprintf("%.3e", text) }
        function high4(text, part) { split(text, part, "e"); return substr(part[1], 6, 1) == 5 ? substr(part[1], 1, 5) + 0.001 "e" part[2] : sprintf("%.3e", text) }

        NR == 1 { columns = NF; for (i = 1; i <= NF; ++i) { if ($i in at) { print "column " $i " is there twice"; bad = 1 } at[$i] = i } next }
        { row = $(at["scene"]) ", " $(at["camera"]) ", " $(at["setting"]) }
        NF != columns { wrong(NF " fields of " columns); next }
        seen[row]++ { wrong("is there twice") }
        {
            group = of("scene") ", " of("camera")
            if (!(group in first)) { first[group] = of("setting"); ++groups; name[groups] = group; single[group] = of("frames") == 1 }
            for (i = 1; i <= NF; ++i) if ($i == "" && i != at["git"] && i != at["cpu"]) wrong("no " $i " in column " i)
        }
        of("status") != "ok" {
            if (length(of("status")) < 20) wrong("does not say why it failed: " of("status"))
            if (of("on_front") != 0 || of("on_front_modelled") != 0) wrong("failed and is on a front")
            n = split("e_cut_rmse e_round_rmse e_mesh_max psnr_db ssim max_levels modelled_ms host_ms pairs rmse mae p999_levels share_over_one_level e_mesh_rmse twice_products split_off lost late unplaced exchanges messages front_pairs host_over_default", results, " ")
            for (i = 1; i <= n; ++i) if (of(results[i]) != "NaN") wrong("failed and has " results[i] " " of(results[i]))
            if (of("claim") != "no claim") wrong("failed and claims to be " of("claim"))
            died[group, of("setting")] = 1
            next
        }
        {
            ++ok[group]
            missing = of("lost") + of("late") + of("unplaced")
            if (missing == 0 && !(of("e_mesh_rmse") == "0.0000e+00" && of("e_mesh_max") == "0.0000")) wrong("lacks nothing, but E_mesh is " of("e_mesh_rmse") ", " of("e_mesh_max") " levels")
            if (of("e_mesh_max") > 0) {
                if (of("lost") > 0) lost = 1
                if (of("late") > 0) late = 1
                if (of("unplaced") > 0) unplaced = 1
            }
            parts = square(of("e_cut_rmse")) + square(of("e_round_rmse")) + square(of("e_mesh_rmse")) + of("twice_products")
            off = square_off(of("rmse")) + square_off(of("e_cut_rmse")) + square_off(of("e_round_rmse")) + square_off(of("e_mesh_rmse")) + half_unit(of("twice_products") < 0 ? substr(of("twice_products"), 2) : of("twice_products"))
            near(square(of("rmse")), parts, off * 1.000001, "the split does not add up")
            if (!(of("split_off") <= 1e-9)) wrong("split_off is " of("split_off"))
            check_psnr(of("rmse"), of("psnr_db"), "PSNR")
            check_psnr(of("e_cut_rmse"), of("e_cut_psnr_db"), "PSNR of E_cut")
            check_psnr(of("e_round_rmse"), of("e_round_psnr_db"), "PSNR of E_round")
            check_psnr(of("e_mesh_rmse"), of("e_mesh_psnr_db"), "PSNR of E_mesh")
            # RMSE lies between mean and maximum; levels are of 255.
            if (of("mae") > of("rmse") * 1.0001 || of("rmse") * 255 > of("max_levels") + 0.00006 || of("p999_levels") > of("max_levels") + 0) wrong("mean, RMSE, p99.9 and maximum are out of order")
            if (of("share_over_one_level") < 0 || of("share_over_one_level") > 1 || of("ssim") > 1) wrong("a share beyond 1")
            if (!(of("pairs") > 0 && of("pairs_contributing") > 0 && of("exchanges") > 0 && of("modelled_ms") > 0)) wrong("a cost is not positive")
            if (of("frames") == 1 && !(of("host_rounds") > 0 && of("host_ms_min") <= of("host_ms_p20") && of("host_ms_p20") <= of("host_ms") && of("host_ms") <= of("host_ms_p80"))) wrong("host times are out of order")
            # Nothing is said about host time within the noise.
            ratio_low = of("host_over_default_low"); ratio_high = of("host_over_default_high"); noise = of("aa_noise")
            if (of("claim") == "faster" && !(noise != "inf" && of("host_rounds") >= 3 && ratio_high < 1 - noise + 1e-4)) wrong("faster within the noise")
            if (of("claim") == "slower" && !(noise != "inf" && of("host_rounds") >= 3 && ratio_low > 1 + noise - 1e-4)) wrong("slower within the noise")
            n = ++rows[group]
            setting[group, n] = of("setting"); pairs[group, n] = of("pairs") + 0; error[group, n] = of("rmse") + 0
            program[group, n] = of("program")
            if ((of("program") == "homes") != (of("homes_rounds") > 0)) wrong("program " of("program") " with " of("homes_rounds") " rounds")
            if (of("program") == "homes" && missing != 0) wrong("homes lack something")
            low[group, n] = low4(of("rmse")) + 0; high[group, n] = high4(of("rmse")) + 0
            on_front[group, n] = of("on_front"); front_pairs[group, n] = of("front_pairs") + 0
        }
        END {
            if (groups == 0) { print "no rows"; bad = 1 }
            for (g = 1; g <= groups; ++g) {
                group = name[g]
                if (first[group] != "default") { print group ": begins with " first[group]; bad = 1 }
                if (single[group] && ok[group] < least) { print group ": " ok[group] + 0 " settings have a result, not " least; bad = 1 }
                if (single[group] && !((group, "storage 10") in died)) { print group ": 10 slots a tile hold the map"; bad = 1 }
                for (n = 1; n <= rows[group]; ++n) index_of[group, setting[group, n]] = n
                for (n = 1; n <= rows[group]; ++n) {
                    beaten = maybe = 0; most = least_pairs = pairs[group, n]
                    for (o = 1; o <= rows[group]; ++o) {
                        if (program[group, o] != program[group, n]) continue
                        fewer = pairs[group, o] < pairs[group, n]; same = pairs[group, o] == pairs[group, n]
                        if ((fewer && high[group, o] <= low[group, n]) || (same && high[group, o] < low[group, n])) beaten = 1
                        if ((fewer && low[group, o] <= high[group, n]) || (same && low[group, o] < high[group, n])) maybe = 1
                        if (high[group, o] <= low[group, n] && pairs[group, o] < most) most = pairs[group, o]
                        if (low[group, o] <= high[group, n] && pairs[group, o] < least_pairs) least_pairs = pairs[group, o]
                    }
                    where = group ", " setting[group, n]
                    if (on_front[group, n] == 1 ? beaten : !maybe) { print where ": on_front is " on_front[group, n]; bad = 1 }
                    f = front_pairs[group, n]
                    if (f < least_pairs / pairs[group, n] - 6e-5 || f > most / pairs[group, n] + 6e-5) { print where ": front_pairs is " f; bad = 1 }
                }
                if (!single[group]) continue
                split("default evaluation viewing on_sensor", named, " ")
                for (i = 1; i <= 4; ++i) {
                    if (!((group, named[i]) in index_of)) { print group ": no " named[i]; bad = 1; continue }
                    f = front_pairs[group, index_of[group, named[i]]]
                    if (!(f >= 0.98)) { print group ", " named[i] ": " f " of its pairs do as well"; bad = 1 }
                }
                d = index_of[group, "default"]
                for (n = 1; n <= rows[group]; ++n)
                    if (program[group, n] == program[group, d] && pairs[group, n] <= 0.9 * pairs[group, d] && error[group, n] <= error[group, d]) { print group ", " setting[group, n] ": better than the default with " pairs[group, n] " pairs of " pairs[group, d]; bad = 1 }
            }
            if (!lost) { print "nothing is lost anywhere"; bad = 1 }
            if (!late) { print "nothing is late anywhere"; bad = 1 }
            if (!unplaced) { print "nothing is unplaced anywhere"; bad = 1 }
            exit bad
        }' "$folder/plain.csv" || complain "bad rows in $1"
}

# Settings of every kind, the neighbours of the named ones among them, with a comma between them.
settings="evaluation,viewing,on_sensor,alpha 1/8160 stop 0,alpha 1/8160 stop 1e-3,alpha 1/280 stop 1e-2,alpha 1/220 stop 2e-3,\
alpha 1/190 stop 1e-2,alpha 1/64 stop 0,sigma 2 alpha 0,sigma 3,no cut,crossing dropped clamp 0.99 stop 1e-3,3DGS,degree 3,half conic,16-bit keys,hold 5 slots,\
drop 5 slots,1 hop,storage 1000,storage 10,homes,homes 300 held,homes 2 slots"
chosen() { # SETTINGS PROGRAM ARGUMENTS...: with --setting for each
    list=$1
    shift
    old=$IFS
    IFS=,
    for one in $list; do set -- "$@" --setting "$one"; done
    IFS=$old
    "$@"
}
chosen "$settings" "$program" --quick --scene built_in --no-sequences --size 320x180 --rounds 1 --csv "$folder/all.csv" --pfm "$folder/pfm" \
    --out "$folder/plots" >"$folder/all.txt" 2>"$folder/progress" || complain "the run ended with $?: $(tail -n 1 "$folder/all.txt" "$folder/progress")"
grep '^BROKEN' "$folder/all.txt" && complain "something is broken"
grep -q '^failed: built_in, orbit2, storage 10: a map of' "$folder/all.txt" || complain "10 slots a tile are not said to fail"
check_rows "$folder/all.csv" 25
for file in "$@"; do check_rows "$file" 60; done

# The pictures, measured by a program that shares no line with the bench.
column() { # SETTING COLUMN: of the single view
    plain "$folder/all.csv" | awk -F, -v s="$1" -v c="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next } $(at["setting"]) == s && $(at["frames"]) == 1 { print $(at[c]) }'
}
compare() { # SETTING PICTURE REFERENCE, then pairs MEASURE COLUMN
    setting=$1 picture=$2 reference=$3
    shift 3
    files=$folder/pfm/built_in_$(echo "$setting" | tr ' ' _)
    "$pfm_error" "${files}_$picture.pfm" "${files}_$reference.pfm" >"$folder/measured" || complain "pfm_error ended with $?"
    while [ $# -gt 0 ]; do
        theirs=$(sed -n "s/^$1 //p" "$folder/measured")
        ours=$(column "$setting" "$2")
        [ "${ours:-nothing}" = "$theirs" ] || complain "$setting: $2 is $ours, but pfm_error has $1 $theirs"
        shift 2
    done
}
for setting in default on_sensor "drop 5 slots"; do
    compare "$setting" mesh reference rmse rmse max_levels max_levels p999_levels p999_levels psnr_db psnr_db ssim ssim mae mae \
        share_over_one_level share_over_one_level
    compare "$setting" cut reference rmse e_cut_rmse max_levels e_cut_max psnr_db e_cut_psnr_db mae e_cut_mae p999_levels e_cut_p999_levels \
        ssim e_cut_ssim share_over_one_level e_cut_share_over_one_level
    compare "$setting" whole cut rmse e_round_rmse max_levels e_round_max psnr_db e_round_psnr_db mae e_round_mae p999_levels e_round_p999_levels \
        ssim e_round_ssim share_over_one_level e_round_share_over_one_level
    compare "$setting" mesh whole rmse e_mesh_rmse max_levels e_mesh_max psnr_db e_mesh_psnr_db mae e_mesh_mae p999_levels e_mesh_p999_levels \
        ssim e_mesh_ssim share_over_one_level e_mesh_share_over_one_level
done

for plot in pairs modelled host; do
    file=$folder/plots/built_in_$plot.svg
    { [ -s "$file" ] && grep -q '<svg' "$file" && grep -q '</svg>' "$file" && grep -q '<text' "$file"; } || complain "no plot of $plot"
    if grep -qiwE 'nan|inf' "$file"; then complain "the plot of $plot has what is no number"; fi
done

# A few with a sequence. Results do not depend on threads: all columns but those of host time.
few="evaluation,viewing,on_sensor,half conic,drop 5 slots,1 hop,storage 2000,storage 300,storage 10,homes 300 held"
for threads in 1 2; do
    chosen "$few" "$program" --quick --scene built_in --scene sloth --size 160x90 --rounds 1 --threads $threads --csv "$folder/$threads.csv" \
        >"$folder/$threads.txt" 2>"$folder/progress" || complain "the small run with $threads threads ended with $?"
    plain "$folder/$threads.csv" | awk -F, '
        NR == 1 { for (i = 1; i <= NF; ++i) kept[i] = $i !~ /^(host_.*|claim|aa_noise|threads)$/ }
        { out = ""; for (i = 1; i <= NF; ++i) if (kept[i]) out = out "," $i; print out }' >"$folder/$threads.kept"
done
check_rows "$folder/1.csv" 9
cmp "$folder/1.kept" "$folder/2.kept" || complain "results depend on the number of threads"
[ "$(grep -c 'orbit2 x 6' "$folder/1.kept")" -eq 9 ] || complain "of the small run's sequence there are $(grep -c 'orbit2 x 6' "$folder/1.kept") rows, not 9"
grep -q '^skipped: sloth (its map is not there; ' "$folder/1.txt" || complain "a map that is not there is not said to be skipped"

status=0
"$program" --quick --scene sloth >"$folder/nothing" 2>"$folder/progress" || status=$?
[ $status -eq 2 ] || complain "with no map at all the run ended with $status, not 2"
grep -q '^nothing was measured (' "$folder/progress" || complain "that nothing was measured is not said"

status=0
"$program" --quick --scene built_in --setting on_sensor --no-sequences --size 64x48 --rounds 1 --spoil >"$folder/spoilt" 2>"$folder/progress" || status=$?
[ $status -eq 1 ] || complain "with --spoil the run ended with $status, not 1"
grep -q '^BROKEN: built_in, orbit2, on_sensor: nothing is missing' "$folder/spoilt" || complain "with --spoil nothing is said to be broken"

for wrong in --no-such-option "--size 10x10" "--scene nowhere" "--setting nothing" "--rounds 0" --out; do
    status=0
    # shellcheck disable=SC2086
    "$program" $wrong >"$folder/refused" 2>&1 || status=$?
    [ $status -eq 2 ] || complain "$wrong ended with $status, not 2"
    [ "$(grep -c . "$folder/refused")" -eq 1 ] || complain "$wrong gives $(grep -c . "$folder/refused") lines, not 1"
done
exit $failed

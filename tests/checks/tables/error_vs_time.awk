# Each row of a CSV of error_vs_time, by arithmetic of its own. `least`: so many settings have a result in each single view.
# Where nothing is missing the mesh's picture is the whole frame's, the split of the error adds up to the printed digits, fronts and named
# settings are where pairs and errors put them, what failed says why.
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
    # The reference in double and the enclosure are two programs for one formula.
    if (of("frames") == 1 && !(of("certified_levels") >= of("max_levels") - 0.01 && of("certified_levels") <= of("max_levels") + 0.1)) wrong("certified " of("certified_levels") " levels, measured " of("max_levels"))
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
    }

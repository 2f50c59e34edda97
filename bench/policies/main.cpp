// What each policy costs and gives: error, exchanges, modelled time, balance, SRAM, bytes and host time.
#include "measure.hpp"
#include "prefetch.hpp"
#include <algorithm>
#include <cmath>
#include <common/program.hpp>
#include <common/statistics.hpp>
#include <iostream>
#include <sstream>
#include <tilemesh/report/table.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace {

using namespace policies;
using bench::fixed;
using tilemesh::report::thousands;

constexpr char const* map_names[] = {"sloth", "salad", "playbot_250k", "built_in"};

constexpr auto all_maps = shared::words_of(map_names);
constexpr shared::Option<Options> rows_of_options[] = {
    shared::option<&Options::write>("write", "DIR", "write README.md into this folder"),
    shared::words<&Options::maps>("map", "NAME", "{}; may be repeated [the first three]", all_maps),
    shared::option<&Options::threads>("threads", "N", "host threads of each machine; only host times depend on it [1]", {1, 64})};
shared::OptionTable table_of(Options& own)
{
    return bench::table_of({"policies",
                            "Measures policies on one machine (Mk2, 40 x 36 tiles, 1280 x 720): what goes first and stays, records of\n"
                            "32 and 16 bytes, a bound on hops, few slots, records that move early. Each row has the error against the\n"
                            "exact picture beside its cost. Times are modelled with mk2(). A picture from which nothing is missing and\n"
                            "nothing is rounded must have the bits of the naive loop.\n",
                            "a part of the built-in map, a small picture; takes seconds", "write a row per map, view and policy"},
                           own, rows_of_options);
}

std::string db(double value) { return std::isinf(value) ? "exact" : fixed(value, 1); }

std::string without_commas(std::string text)
{
    std::replace(text.begin(), text.end(), ',', ';');
    return text;
}
std::string csv(std::vector<Row> const& rows)
{
    std::ostringstream out;
    out << "map,view,policy,lossy,psnr_db,missing,exchanges,modelled_ms,slowest_over_mean,sram_bytes,storage,exchanged_bytes,host_ms\n";
    for (auto const& r : rows)
        out << r.map << ',' << r.view << ',' << without_commas(r.policy) << ',' << (r.lossy ? 1 : 0) << ','
            << (std::isinf(r.psnr_db) ? "inf" : fixed(r.psnr_db, 4)) << ',' << r.missing << ',' << r.exchanges << ','
            << fixed(r.modelled_ms, 5) << ','
            << fixed(r.slowest_over_mean, 4) << ','
            << r.sram_bytes << ',' << r.storage << ',' << r.exchanged_bytes << ',' << fixed(r.host_ms, 3) << '\n';
    return out.str();
}
std::string table(std::vector<Row> const& rows)
{
    std::string text = "| map | view | policy | PSNR, dB | missing | exchanges | modelled ms | slowest / mean | SRAM, bytes "
                       "| slots | exchanged, MB | host ms |\n|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (auto const& r : rows)
        text += "| " + r.map + " | " + r.view + " | " + r.policy + " | " + db(r.psnr_db) + " | " + thousands(r.missing) + " | " +
                thousands(r.exchanges) + " | " + fixed(r.modelled_ms, 2) + (r.lossy ? " (lossy)" : "") + " | " +
                fixed(r.slowest_over_mean, 2) + " | " + thousands(r.sram_bytes) + " | " + thousands(r.storage) + " | " +
                fixed(static_cast<double>(r.exchanged_bytes) * 1e-6, 2) + " | " + fixed(r.host_ms, 0) + " |\n";
    return text;
}
std::string table(std::vector<Products> const& products)
{
    std::string text = "| map | blend, % of a frame | bound | bound with colours at 64 a cycle | half colours, dB "
                       "| half colours and weights, dB | RMSE |\n"
                       "|---|--:|--:|--:|--:|--:|--:|\n";
    for (auto const& p : products) {
        text += "| " + p.map + " | " + fixed(100 * p.blend_share, 1) + " | " + fixed(p.bound, 2) + " | " +
                fixed(p.bound_of_colours, 2) + " | " + db(p.colours_db) + " | " + db(p.both_db) + " | " +
                bench::scientific(p.both_rmse, 2) + " |\n";
    }
    return text;
}
/// A sentence for each policy that has a partner without it: what it gains and loses, over all views.
std::string findings(std::vector<Row> const& rows)
{
    std::string text;
    auto const pair = [&](std::string const& policy, std::string const& other) {
        for (auto const& r : rows)
            for (auto const& o : rows)
                if (r.map == o.map && r.view == o.view && r.policy == policy && o.policy == other && (r.lossy || o.lossy)) {
                    double const time = r.modelled_ms / o.modelled_ms;
                    bool const pays = r.psnr_db > o.psnr_db || (r.psnr_db == o.psnr_db && time < 1);
                    text += "- " + r.map + ", " + r.view + ": **" + policy + "**, " + db(r.psnr_db) + " dB for " +
                            db(o.psnr_db) + " (" + other + "),\n  in " + fixed(time, 2) + " times the modelled time." +
                            (pays ? "\n" : " It does not pay here.\n");
                }
    };
    for (std::string const kind : {"drop, few slots", "hold, few slots", "hold, 40 hops", "hold, 4 hops", "hold"})
        pair(kind + ", largest first", kind + ", first come");
    for (std::string const bytes : {"32", "16"}) {
        pair("hold, records of " + bytes + " bytes", "hold, first come");
        pair("homes, records of " + bytes + " bytes", "homes");
    }
    return text;
}
void write_readme(Options const& options, std::vector<Row> const& rows, std::vector<Products> const& products,
                  std::vector<Motion> const& motions, bool complete)
{
    std::string text =
        "# What does each policy cost, and what does it give?\n"
        "The paper leaves these questions open: what goes first when not all can go, smaller records, records that move ahead of\n"
        "the camera, and blending as matrix products. Each has its rows here, on Mk2 with 40 x 36 tiles at 1280 x 720. The bench\n"
        "writes this file. Other links for routing, and work that neighbours lend, did not pay: [removed](removed/README.md) has\n"
        "their rows.\n"
        "```sh\n"
        "build/test/bench/policies --data DIR --csv policies.csv --write bench/policies\n"
        "build/test/bench/policies --quick                       # no data, seconds\n"
        "```\n"
        "- PSNR is against the exact picture (the naive loop, all records). \"exact\": the same bits. A time is marked \"lossy\"\n"
        "  if the picture lacks records or has rounded ones: do not compare it with the time of a complete picture.\n"
        "- Times are modelled with `mk2()`; no machine has confirmed them. The other counts are exact. Host times belong to two\n"
        "  cores of an AMD EPYC (Zen 5), with other jobs beside them, and include the trace.\n"
        "- \"Slowest / mean\": modelled compute cycles of the slowest tile over the mean of all 1,440 tiles.\n"
        "- \"Largest first\" is [`splat::LargestFirst`](../../include/tilemesh/splat/contribution.hpp), `render_map --priority\n"
        "  largest`. \"Few slots\" are the 100 and 800 of the authors' public code. 40 hops end routing, and bloom, of a frame.\n"
        "- Records of 32 and 16 bytes: a tile stores and sends [packed records](../common/compact.hpp), and unpacks one each time\n"
        "  that it projects it. This work is in the times: a projection costs 1.46 times as much with 32 bytes, 1.41 with 16. A\n"
        "  tile never packs. 16 bytes need 24 bytes more a tile: the box of the map. The bench checks that pictures, exchanges\n"
        "  and bytes are those of records that were rounded before. These programs move values, which takes the host longer.\n"
        "- In homes, records of 32 and 16 bytes are a **bound**: each record is rounded before it is loaded, the ledger has the\n"
        "  packed bytes of the records on their home tiles, and no time is counted for unpacking.\n"
        "- The work of ranking is not in the modelled times either: the model has no price for it. It is in the host times.\n"
        "- \"Whole\" is a cold start. `fr1_xyz` is frame 4 of a recorded motion of a hand-held camera, after the whole view.\n"
        "- No policy here is a default.\n";
    if (!complete) text += "\n**A check failed in this run.**\n";
    text += "\n## Findings\n" + findings(rows) + "\n## Policies\n" + table(rows) +
            "\n## Blending as matrix products\n"
            "A bound from the exact counts of a frame of homes: if blending took no time, and if only the 4 multiply-adds of a pair\n"
            "(its colour and weight) took time, at 64 half-precision multiply-adds a cycle, evenly over the tiles. Alpha and\n"
            "transmittance are not products, so a machine gains less. The error is that of colours and weights rounded to half\n"
            "precision and summed as floats.\n\n" +
            table(products) + "\n" + section(motions);
    tilemesh::report::write_whole(options.write / "README.md", text);
}

int run(Options const& options)
{
    bench::expect_folder_of(options.csv);
    if (!options.write.empty()) bench::expect_folder_of(options.write / "README.md");
    std::vector<Row> rows;
    std::vector<Products> products;
    std::vector<Motion> motions;
    std::vector<std::string> broken;
    for (std::string const name : map_names) {
        bool const own = name == "built_in";
        if (options.maps.empty() ? own != options.quick : !bench::chosen(options.maps, name)) continue;
        if (!bench::has_scene(name, options.data)) {
            std::cout << "skipped: " << name << " (its map is not there; name its folder with --data)\n";
            continue;
        }
        tilemesh::scene::Size const small{320, 180}, whole{1280, 720};
        auto const scene = bench::load_scene(name, options.data, options.quick ? small : whole);
        measure(scene, options, rows, products, broken);
        measure_prefetch(scene, options, motions, broken);
    }
    std::cout << table(rows) << "\n" << table(products) << "\n" << findings(rows) << "\n" << section(motions);
    if (!options.csv.empty()) tilemesh::report::write_whole(options.csv, csv(rows));
    if (!options.write.empty()) write_readme(options, rows, products, motions, broken.empty());
    for (auto const& what : broken) std::cout << "BROKEN: " << what << "\n";
    std::cout << (broken.empty() ? "All that must hold does.\n" : "");
    return broken.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, table_of, run, "not enough memory; name one --map, or --quick");
}

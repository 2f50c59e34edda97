// test: unoptimised test asan
#include "../compare_reports.hpp"
#include "all_different.hpp"
#include "folder.hpp"
#include "json_schema.hpp"
#include <tilemesh/config.hpp>
#include <tilemesh/render/describe.hpp>
#include <tilemesh/report/json.hpp>
#include <tilemesh/report/json_frame.hpp>

namespace report = tilemesh::report;
using Json = nlohmann::ordered_json;

namespace {

report::ErrorMeasures measures(double psnr_db)
{
    return {.rmse = 0.25, .max_levels = 3, .p999_levels = 2, .psnr_db = psnr_db, .ssim = 0.5, .mae = 0, .share_over_one_level = 0};
}

report::Comparison comparison()
{
    return {"photos/b.png", "", {.psnr_db = 31.5, .ssim = 0.875, .l1 = 0.015625, .largest = 0.5, .largest_at = {17, 4}}, "frame_0000.error.png"};
}

/// A frame in which all numbers of the report differ.
report::RunFrame frame()
{
    report::RunFrame f;
    f.report = all_different();
    f.report.width = 1280;
    f.report.height = 720;
    f.image = "frame_0000.png";
    f.grid = {40, 36};
    f.tile_px = {32, 20};
    return f;
}

report::RunReport run()
{
    report::RunReport r;
    r.map = {"sloth", "maps/sloth.ply", 25161, 2, {"columns skipped: nx, ny, nz"}};
    r.machine = {"mk2", 638976, 3200, 400, {{{"storage, and more", 7}, "state", 192008, true}}};
    r.preset = "paper";
    r.engine = "threads";
    r.threads = 3;
    r.policies = {"row_first", "recomputed", "drop", "three_sigma_square", "world", "rgbx8", "precise", 0};
    r.quality = "viewing";
    r.cut_offs = {0.0078125f, 0.25f, 0.75f};
    r.background = {0.25f, 0.5f, 1.0f};
    r.frames = {frame()};
    return r;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("report.json says its form, the library that wrote it, what ran and of what, what was left out, and what would help")
{
    auto const json = report::json_of(run());
    CHECK(json["map"] ==
          Json{{"name", "sloth"}, {"path", "maps/sloth.ply"}, {"gaussians", 25161}, {"rejected", 2}, {"notes", {"columns skipped: nx, ny, nz"}}});
    CHECK(json["preset"] == "paper");
    CHECK(json["engine"] == "threads");
    CHECK(json["threads"] == 3);
    CHECK(json["policies"] == Json{{"routing", "row_first"}, {"addressing", "recomputed"}, {"saturation", "drop"},
                                   {"footprint", "three_sigma_square"}, {"copies", "world"}, {"pixels", "rgbx8"}, {"arithmetic", "precise"},
                                   {"hops", "quiet"}, {"rounds", "all"}});
    CHECK(json["program"] == "anchored");
    CHECK(json["quality"] == "viewing");
    CHECK(json["cut_offs"] == Json{{"alpha_min", 0.0078125}, {"transmittance_min", 0.25}, {"alpha_max", 0.75}});
    CHECK(json["background"] == Json{0.25, 0.5, 1.0});
    CHECK(report::json_of(report::RunReport{})["quality"] == "default");
    CHECK(json["frames"].size() == 1);
    CHECK(json["notes"] == Json::array());
    CHECK(json["advice"].is_null());
    CHECK(json["features"] == Json::array());
    CHECK_FALSE(json.contains("made_from"));
    CHECK(json["schema"] == 2);
    auto const version = json["version"].get<std::string>();
    CHECK(std::count(version.begin(), version.end(), '.') == 2);
    CHECK(std::stoi(version) == TILEMESH_VERSION / 10000);

    auto other = run();
    other.policies.hops = 1;
    other.policies.rounds = 2;
    other.program = report::Program::automatic;
    other.map.path.clear();
    other.notes = {"interrupted"};
    other.advice = "more slots";
    other.made_from = {"0.2.0", {"--size=8x6"}, {{"map.ply", 12, "ff"}}};
    other.features = {{"routing", false, "one view"}, {"bloom", true, "2 x 1 tiles"}};
    auto const changed = report::json_of(other);
    CHECK(changed["policies"]["hops"] == 1);
    CHECK(changed["policies"]["rounds"] == 2);
    CHECK(changed["program"] == "auto");
    CHECK(changed["map"]["path"].is_null());
    CHECK(changed["notes"] == Json::array({"interrupted"}));
    CHECK(changed["advice"] == "more slots");
    CHECK(changed["made_from"] ==
          Json{{"version", "0.2.0"}, {"options", {"--size=8x6"}}, {"files", {{{"path", "map.ply"}, {"bytes", 12}, {"digest", "ff"}}}}});
    CHECK(changed["features"] == Json::array({{{"feature", "routing"}, {"kept", false}, {"why", "one view"}},
                                              {{"feature", "bloom"}, {"kept", true}, {"why", "2 x 1 tiles"}}}));
}

TEST_CASE("report.schema.json describes every member of report.json, and notices each that is missing, unknown or of another type")
{
    auto const file = std::filesystem::path(__FILE__).parent_path() / "../../include/tilemesh/report/report.schema.json";
    std::ifstream in(file);
    auto const schema = Json::parse(in);
    json_schema::Validator validator(schema);
    auto all = run();
    all.made_from = {"0.1.0", {"--size=8x6"}, {{"map.ply", 12, "ff"}}};
    all.features = {{"routing", false, "one view"}};
    all.ranks = 3;
    all.machine.ledger.push_back({{"sort keys", 9}, "state", 38408, false});
    auto& f = all.frames[0];
    f.timestamp_s = 0.5;
    f.view.emplace().lens.kind = tilemesh::splat::LensKind::fov;
    f.view->shutter.turn[0] = 0.5f;
    f.depth = "frame_0000.depth.pfm";
    f.alpha = "frame_0000.alpha.pfm";
    f.modelled = {"mk2", 123456, 0.25};
    f.report.full_tiles = {2, 17, 3105, 2000};
    f.report.unfinished = {{3, 0.5f}};
    f.error = f.error_same_cuts = measures(std::numeric_limits<double>::infinity());
    f.photograph = f.compared = comparison();
    report::Certificate certificate;
    certificate.not_enclosed = {3}, certificate.depth = certificate.alpha = report::Certificate::OfPlane{1, 0.5, 0.25};
    certificate.worst = {{5, 6, 0.75, {"order", 7, 8, 0.125}}}, certificate.causes = {{"order", 2}};
    f.certified = f.compared_certified = certificate;
    auto const ledger = all.machine.ledger;
    tilemesh::render::describe(all, tilemesh::splat::lossless, tilemesh::splat::Rules{}, tilemesh::RendererOptions{});
    all.machine.ledger = ledger;
    auto const json = report::json_of(all);
    CHECK(validator.errors(json) == std::vector<std::string>{});
    CHECK(validator.unseen() == std::vector<std::string>{});
    report::RunReport bare; // of a run that is not described, but for its setup
    bare.setup = all.setup;
    CHECK(validator.errors(report::json_of(bare)) == std::vector<std::string>{});

    std::set<std::string> const optional = {"image", "depth", "alpha", "timestamp_s", "intrinsics_px", "world_to_camera", "modelled", "lens",
                                            "lens_coefficients", "rolling_shutter", "full_tiles", "unfinished", "error", "error_same_cuts",
                                            "photograph", "compared", "certified", "compared_certified"};
    for (auto const& [change, spoiled] : json_schema::spoiled(json)) {
        auto const& how = change; // Clang 14 captures no structured binding
        CAPTURE(how);
        auto const name = how.starts_with("without ") ? how.substr(8, how.find(':') - 8) : "";
        bool const of_frame = how.ends_with(": /frames/0") && optional.contains(name);
        bool const of_planes = how.ends_with("certified") && (name == "depth" || name == "alpha");
        bool const may_lack =
            of_frame || of_planes || how == "without made_from: " || how == "without ranks: " || how == "without note: /machine" || how == "without photographs: ";
        CHECK(validator.errors(spoiled).empty() == may_lack);
    }

    // The numbers and their meanings are those of report_fields: the target `update_schema` writes the file anew. Each cause is one that a
    // loss may have.
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    CHECK(json_schema::text_of(json_schema::with_fields(schema)) + "\n" == text.str());
    auto const& causes = schema["$defs"]["loss"]["properties"]["cause"]["enum"];
    REQUIRE(causes.size() == report::causes);
    for (std::uint32_t cause = 0; cause < report::causes; ++cause) CHECK(causes[cause] == report::to_string(report::Cause{cause}));
    CHECK(schema["properties"]["schema"]["const"] == report::report_schema);
}

TEST_CASE("report.json has the machine and its ledger")
{
    auto all = run();
    auto json = report::json_of(all)["machine"];
    CHECK(json["name"] == "mk2");
    CHECK(json["grid"] == Json{40, 36});
    CHECK(json["tile_px"] == Json{32, 20});
    CHECK(json["sram_bytes"] == 638976);
    CHECK(json["storage_slots"] == 3200);
    CHECK(json["channel_slots"] == 400);
    CHECK(json["ledger"] == Json::array({{{"region", "storage"}, {"bytes", 192008}, {"what", "state"}, {"budgeted", true}}}));
    CHECK(json["budgeted_bytes"] == 192008);
    CHECK_FALSE(json.contains("note"));

    // Lists that the paper's budget has no room for are in the ledger, are left out of the sum, and are marked.
    all.machine.ledger.push_back({{"sort keys", 9}, "state", 38408, false});
    json = report::json_of(all)["machine"];
    CHECK(json["ledger"][1]["budgeted"] == false);
    CHECK(json["budgeted_bytes"] == 192008);
    auto const note = json["note"].get<std::string>();
    CHECK(note.find("38408 bytes") != std::string::npos);
    CHECK(note.find("preset paper") != std::string::npos);

    all.frames.clear();
    json = report::json_of(all);
    CHECK(json["machine"]["grid"].is_null());
    CHECK(json["frames"] == Json::array());
}

TEST_CASE("report.json has every number of a frame under its name")
{
    auto const json = report::json_of(run())["frames"][0];
    auto const r = run().frames[0].report;
    Json expected{{"camera", "sloth/front"}, {"program", "anchored"}, {"size_px", {1280, 720}}, {"grid", {40, 36}}, {"tile_px", {32, 20}},
                  {"image", "frame_0000.png"}};
    for (auto const& field : report::report_fields) {
        if (field.group() == "size_px" || field.name == "lost") continue;
        auto& in = field.group().empty() ? expected : expected[std::string(field.group())];
        if (field.exact()) in[std::string(field.leaf())] = field.count(r);
        else in[std::string(field.leaf())] = field.milliseconds(r);
    }
    expected["lost"] = {{{"id", 7}, {"what", "record"}, {"cause", "unplaced"}, {"tile", 1000}},
                        {{"id", 8}, {"what", "copy"}, {"cause", "storage_full"}, {"tile", 1439}},
                        {{"id", 9}, {"what", "copy"}, {"cause", "late"}, {"tile", 3}},
                        {{"id", 9}, {"what", "copy"}, {"cause", "late"}, {"tile", 4}},
                        {{"id", 9}, {"what", "copy"}, {"cause", "late"}, {"tile", 5}}};
    CHECK(json == expected);
    CHECK(json["gaussians"]["moved"] == r.gaussians.moved);
    CHECK(json["exchanged_bytes"]["capacity"] == 0xffffffffffffffffu);
    CHECK(json["host_ms"]["picture"] == r.host_ms.picture);

    auto more = run();
    more.frames[0].timestamp_s = 1305031102.175304;
    more.frames[0].modelled = {"mk2", 123456, 0.25};
    more.frames[0].report.full_tiles = {2, 17, 3105, 2000};
    more.frames[0].depth = "frame_0000.depth.pfm";
    more.frames[0].alpha = "frame_0000.alpha.pfm";
    auto const with_more = report::json_of(more)["frames"][0];
    CHECK(with_more["timestamp_s"].dump() == "1305031102.175304");
    CHECK(with_more["modelled"] == Json{{"cost_model", "mk2"}, {"cycles", 123456}, {"ms", 0.25}});
    CHECK(with_more["full_tiles"] == Json{{"count", 2}, {"fullest", 17}, {"slots_needed", 3105}, {"slots_available", 2000}});
    CHECK(with_more["depth"] == "frame_0000.depth.pfm");
    CHECK(with_more["alpha"] == "frame_0000.alpha.pfm");
}

TEST_CASE("errors are in report.json where a reference was rendered; an infinite PSNR is null")
{
    auto all = run();
    all.frames[0].error = measures(12.5);
    all.frames[0].error_same_cuts = measures(std::numeric_limits<double>::infinity());
    auto const json = report::json_of(all)["frames"][0];
    CHECK(json["error"] == Json{{"rmse", 0.25}, {"max_levels", 3.0}, {"p999_levels", 2.0}, {"psnr_db", 12.5}, {"ssim", 0.5}});
    CHECK(json["error_same_cuts"]["psnr_db"].is_null());
    CHECK(json["error_same_cuts"]["rmse"] == 0.25);
    CHECK_FALSE(report::json_of(run())["frames"][0].contains("error"));
}

TEST_CASE("photographs and their means are in report.json; a photograph that cannot be compared has its reason and no measures")
{
    auto all = run();
    CHECK_FALSE(report::json_of(all).contains("photographs"));
    CHECK_FALSE(report::json_of(all)["frames"][0].contains("photograph"));
    all.frames.push_back(all.frames[0]);
    all.frames.push_back(all.frames[0]);
    all.frames[0].photograph = comparison();
    all.frames[1].photograph = report::Comparison{"photos/c.png", "photos/c.png cannot be opened (no such file); check the path", {}, ""};
    auto json = report::json_of(all);
    CHECK(json["frames"][0]["photograph"] == Json{{"file", "photos/b.png"}, {"problem", nullptr}, {"psnr_db", 31.5}, {"ssim", 0.875},
                                                  {"l1", 0.015625}, {"largest", 0.5}, {"largest_at", {17, 4}}, {"error", "frame_0000.error.png"}});
    CHECK(json["frames"][1]["photograph"]["problem"] == "photos/c.png cannot be opened (no such file); check the path");
    for (auto const* member : {"psnr_db", "ssim", "l1", "largest", "largest_at", "error"}) CHECK(json["frames"][1]["photograph"][member].is_null());
    CHECK_FALSE(json["frames"][2].contains("photograph"));
    CHECK(json["photographs"] == Json{{"compared", 1}, {"not_compared", 1}, {"psnr_db", 31.5}, {"ssim", 0.875}, {"l1", 0.015625}});
    all.frames[2].photograph = comparison();
    all.frames[2].photograph->measures = {.psnr_db = 32.5, .ssim = 0.625, .l1 = 0.046875, .largest = 0.75, .largest_at = {0, 0}};
    json = report::json_of(all);
    CHECK(json["photographs"] == Json{{"compared", 2}, {"not_compared", 1}, {"psnr_db", 32.0}, {"ssim", 0.75}, {"l1", 0.03125}});
    all.frames[0].photograph->measures.psnr_db = std::numeric_limits<double>::infinity();
    CHECK(report::json_of(all)["photographs"]["psnr_db"].is_null());
    CHECK(report::json_of(all)["photographs"]["ssim"] == 0.75);
    all.frames.resize(2);
    all.frames[0].photograph.reset();
    CHECK(report::json_of(all)["photographs"] == Json{{"compared", 0}, {"not_compared", 1}, {"psnr_db", nullptr}, {"ssim", nullptr}, {"l1", nullptr}});
}

TEST_CASE("a frame of report.json is read back as it was written")
{
    auto const json_of = [](report::RunFrame const& f) {
        report::RunReport run;
        run.frames = {f};
        return report::json_of(run)["frames"][0];
    };
    auto const same = [&](report::RunFrame const& f) {
        auto const json = json_of(f);
        return json_of(report::frame_of(Json::parse(json.dump()))) == json;
    };
    auto f = frame();
    CHECK(same(f));
    CHECK(report::frame_of(json_of(f)).report.lost == f.report.lost);
    auto newer = json_of(f); // a member of a newer version does not raise `schema`
    newer["new_member"] = newer["losses"]["new_member"] = newer["lost"][0]["new_member"] = 5;
    CHECK(json_of(report::frame_of(newer)) == json_of(f));
    f.depth = "frame_0000.depth.pfm";
    f.alpha = "frame_0000.alpha.pfm";
    f.error = measures(12.5);
    f.error_same_cuts = measures(std::numeric_limits<double>::infinity());
    f.photograph = report::Comparison{"photos/c.png", "photos/c.png cannot be opened (no such file); check the path", {}, ""};
    f.compared = comparison();
    CHECK(same(f));
    CHECK(report::frame_of(json_of(f)).photograph->problem == f.photograph->problem);
    CHECK(report::frame_of(json_of(f)).compared->measures.largest_at == std::array<std::uint32_t, 2>{17, 4});
    f.photograph = comparison();
    f.photograph->measures.psnr_db = std::numeric_limits<double>::infinity();
    CHECK(report::frame_of(json_of(f)).photograph->measures.psnr_db == std::numeric_limits<double>::infinity());
    f.report.host_ms.total = 0.1;
    f.timestamp_s = 1305031102.175304;
    f.view.emplace(tilemesh::splat::Camera{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {1, 2, 4}, 50, 60, 32, 24, 0.2f, 64, 48});
    f.view->lens = {tilemesh::splat::LensKind::opencv, {0.5f, -0.25f, 1, 2, 3, 4}, {0.125f, -8}, 0, 0};
    f.modelled = {"my machine", 7, 0.1};
    f.report.full_tiles = {2, 17, 3105, 2000};
    f.report.program = report::Program::homes;
    f.report.unfinished = {{3, 0.1f}, {9, 7.25f}};
    for (std::uint32_t cause = 0; cause < report::causes; ++cause)
        f.report.lost.push_back({tilemesh::splat::GaussianId{cause}, cause, report::Cause{cause}});
    CHECK(same(f));
    CHECK(json_of(f)["lens"] == "opencv");
    CHECK(json_of(f)["lens_coefficients"].dump() == "[0.5,-0.25,1.0,2.0,3.0,4.0,0.125,-8.0]");
    CHECK(json_of(f)["world_to_camera"].dump() == "[[0.0,1.0,0.0,-2.0],[-1.0,0.0,0.0,1.0],[0.0,0.0,1.0,-4.0],[0.0,0.0,0.0,1.0]]"); // -R c
    CHECK(report::frame_of(json_of(f)).report.program == report::Program::homes);
    CHECK(report::frame_of(json_of(f)).report.unfinished == f.report.unfinished);
    CHECK(report::frame_of(json_of(f)).error_same_cuts->psnr_db == std::numeric_limits<double>::infinity());

    CHECK(report::first_difference(f.report, report::frame_of(json_of(f)).report) == ""); // every number is another
    auto large = json_of(f);
    large["peak"]["storage"] = 0xffffffffu;
    CHECK(report::frame_of(large).report.peak_storage == 0xffffffffu);
    large["peak"]["storage"] = 0x100000000u;
    CHECK_THROWS_WITH_AS(report::frame_of(large),
                         "a frame of a report has 4294967296 as peak.storage (a report holds 32 bits of it); write the report again", tilemesh::Error);

    // Every key is required, except the keys of files and errors. No key may have another type.
    std::set<std::string> const optional = {"image", "depth", "alpha", "error", "error_same_cuts", "timestamp_s", "lens", "modelled", "full_tiles",
                                            "unfinished", "photograph", "compared"};
    auto const keys = json_of(f);
    for (auto const& item : keys.items()) {
        auto const& key = item.key();
        CAPTURE(key);
        auto lacks = json_of(f);
        lacks.erase(key);
        if (optional.contains(key)) CHECK_NOTHROW(report::frame_of(lacks));
        else CHECK_THROWS_AS(report::frame_of(lacks), tilemesh::Error);
        auto other = json_of(f);
        other[key] = true;
        CHECK_THROWS_AS(report::frame_of(other), tilemesh::Error);
    }
    auto other = json_of(f);
    other["lost"][0]["cause"] = "bad_luck";
    CHECK_THROWS_WITH_AS(report::frame_of(other), doctest::Contains("bad_luck"), tilemesh::Error);
    other = json_of(f);
    other["lost"][0]["what"] = "half";
    CHECK_THROWS_WITH_AS(report::frame_of(other), doctest::Contains("lost a \"half\" (a loss is a record or a copy)"), tilemesh::Error);
    other = json_of(f);
    other["losses"]["late"] = 77;
    CHECK_THROWS_WITH_AS(report::frame_of(other), "a frame of a report has other losses.late than its list `lost`; write the report again",
                         tilemesh::Error);
    CHECK_THROWS_AS(report::frame_of(Json::array()), tilemesh::Error);
}

TEST_CASE("report.json is written whole, or what was there stays")
{
    tests::Folder const folder;
    auto all = run();
    all.map.path = "no utf-8: \xff";
    report::write_json(folder.path / "report.json", all);
    CHECK(folder.names() == std::vector<std::string>{"report.json"});

    auto const read = Json::parse(tests::contents(folder.path / "report.json"));
    CHECK(read["map"]["path"] == "no utf-8: \xef\xbf\xbd");
    CHECK(read["frames"] == report::json_of(all)["frames"]);
    auto keys = std::string();
    for (auto const& [key, value] : read.items()) keys += key + " ";
    CHECK(keys == "schema version map machine preset program policies quality cut_offs background setup features engine threads notes advice frames ");
    CHECK_THROWS_AS(report::write_json(folder.path / "absent" / "report.json", all), tilemesh::Error);
}

TEST_SUITE_END();

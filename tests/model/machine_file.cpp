// test: unoptimised test asan, without tsan
// Machines as files: those of examples/machines/ with their sources, the prices that follow, and what is refused in one line.
#include "../engine/everywhere.hpp"
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/setup_types.hpp>

using namespace tilemesh;
using engine_test::error_of;
using engine_test::has;

namespace {

/// The folder `machines`: CMake names it; without CMake it is beside tests/.
std::string folder()
{
#if defined(TILEMESH_MACHINES)
    return TILEMESH_MACHINES;
#else
    return (std::filesystem::path(__FILE__).parent_path() / "../../examples/machines").string();
#endif
}
MachineFile load(std::string const& name)
{
    std::ifstream in(folder() + "/" + name);
    REQUIRE(in.good());
    return read_machine_file(in, name);
}
MachineFile read(std::string const& text)
{
    std::istringstream in(text);
    return read_machine_file(in, "m.txt");
}
/// mk2.txt with another line in place of a number's.
std::string with_line(std::string const& name, std::string const& line)
{
    auto text = machine_file_text(load("mk2.txt"));
    auto const at = text.find('\n' + name + ' ') + 1;
    REQUIRE(at != 0);
    return text.replace(at, text.find('\n', at) - at, line);
}
std::string refusal(std::string const& text)
{
    return error_of([&] { (void)read(text); });
}

} // namespace

TEST_CASE("every machine of the folder is read and written back equal, and each of its numbers has a source")
{
    std::set<std::string> names;
    std::size_t files = 0;
    for (auto const& entry : std::filesystem::directory_iterator(folder())) {
        if (entry.path().extension() != ".txt") continue;
        ++files;
        auto const machine = load(entry.path().filename().string());
        INFO(entry.path().string());
        names.insert(machine.name);
        CHECK(machine.numbers.size() == 15);
        for (auto const& n : machine.numbers) {
            INFO(n.name);
            CHECK(n.source.size() >= 8);
            // A kind is never an accident: a source begins with its kind's word, or the number is unknown.
            if (n.value) CHECK((n.kind() != PriceKind::guessed || has(n.source, "guess")));
        }
        auto const again = read(machine_file_text(machine));
        CHECK(again == machine);
        CHECK(cost_model_of(machine).clock_khz == machine.need("clock"));
        auto const size = size_of(machine);
        CHECK(std::string(size.name) == machine.name);
        CHECK(size.sram_bytes == machine.need("sram"));
    }
    CHECK(files == 7);
    CHECK(names == std::set<std::string>{"bow", "gpu-sm", "mk1", "mk2", "pixels-998", "scamp-5", "wse-2"});
}

TEST_CASE("mk2.txt is Mk2: its size, and every price of mk2() with its kind")
{
    auto const machine = load("mk2.txt");
    auto const size = size_of(machine), mine = size_of_machine<Mk2>();
    for (auto const member :
         {&MachineSize::tiles, &MachineSize::sram_bytes, &MachineSize::code_bytes, &MachineSize::workers, &MachineSize::clock_khz})
        CHECK(size.*member == mine.*member);
    CHECK(grid_of(machine)->width == 40);
    CHECK(grid_of(machine)->height == 36);
    auto const model = cost_model_of(machine), known = mk2();
    CHECK(model.name == "mk2");
    CHECK(model.prices == known.prices);
    REQUIRE(model.parameters.size() == known.parameters.size());
    for (std::size_t i = 0; i < known.parameters.size(); ++i) {
        auto const &ours = model.parameters[i], &theirs = known.parameters[i];
        CHECK_MESSAGE((ours.name == theirs.name && ours.value == theirs.value && ours.kind == theirs.kind), theirs.name);
    }
    std::ostringstream out;
    write_cost_model(out, model); // each price has its source
    CHECK(machine.unknown().empty());
    CHECK(has(machine_text(machine), "guessed: barrier, vote, exchange_start; unknown: none"));
}

TEST_CASE("prices of other machines follow from workers and instructions; an unknown number is named, and costs nothing")
{
    auto const gpu = cost_model_of(load("gpu_sm.txt")); // 4 workers that issue one instruction each
    CHECK(price_of(gpu, "pair") == (price_of(mk2(), "pair") + 2) / 4);
    CHECK(price_of(gpu, "comparison") == price_of(mk2(), "comparison") / 6);
    CHECK(gpu.exchange_millicycles_a_byte == 31); // 32 bytes a cycle: 31.25
    auto const find = [](CostModel const& m, std::string const& name) {
        return *std::find_if(m.parameters.begin(), m.parameters.end(), [&](ModelParameter const& p) { return p.name == name; });
    };
    CHECK(has(find(gpu, "exchange_byte").source, "rounded"));
    CHECK(find(gpu, "pair").kind == PriceKind::guessed);

    auto const mk1 = load("mk1.txt");
    CHECK(mk1.unknown() == std::vector<std::string>{"barrier", "vote", "exchange_start", "host_link"});
    auto const model = cost_model_of(mk1);
    CHECK(model.name == "mk1, at least: without barrier, vote, exchange_start, host_link");
    CHECK(model.sync_cycles == 0);
    CHECK(find(model, "sync").kind == PriceKind::guessed);
    CHECK(has(error_of([&] { (void)mk1.need("barrier"); }), "machine mk1 cannot be used (its barrier is unknown: "));

    auto const wafer = load("wse2.txt");
    REQUIRE(wafer.network);
    CHECK(wafer.network->link.value == 4);
    CHECK(cost_model_of(wafer).network == wafer.network);
    CHECK(cost_model_of(wafer).exchange_millicycles_a_byte == 0);
}

TEST_CASE("a pixel processor array of today has no room for a frame, and one with Mk2's bytes a pixel has")
{
    auto choice = splat::setup_of<splat::Prototype>();
    auto const today = load("scamp5.txt"), scaled = load("pixels.txt");
    choice.machine = size_of(today);
    choice.sizes = {.storage = 1, .road = 1, .beam = 1, .waiting = 0, .tile_pixels = 64};
    CHECK(has(error_of([&] { (void)render::checked(choice); }), "does not fit"));
    choice.machine = size_of(scaled);
    auto const filled = render::fill_storage(choice, *grid_of(scaled), {8, 8});
    CHECK(filled.sizes.storage > 300);
    CHECK(render::sram_bytes_of(filled) <= scaled.need("sram"));
}

TEST_CASE("a number of a machine is set by its words")
{
    auto machine = load("mk2.txt");
    set_number(machine, "exchange", "147/10", "guess: by hand");
    CHECK(cost_model_of(machine).exchange_millicycles_a_byte == 68);
    CHECK(machine.number("exchange").per == 10);
    set_number(machine, "exchange_cost", "live", "guess: by hand");
    CHECK(cost_model_of(machine).exchange_cost == ExchangeCost::live);
    set_number(machine, "vote", "unknown", "no document");
    CHECK(machine.unknown() == std::vector<std::string>{"vote"});
    CHECK(read(machine_file_text(machine)) == machine);
    auto const before = machine;
    auto const refuses = [&](char const* name, char const* value, std::string const& source, char const* words) {
        auto const text = error_of([&] { set_number(machine, name, value, source); });
        INFO(text);
        CHECK(has(text, words));
        CHECK(text.find('\n') == std::string::npos);
        CHECK(machine == before);
    };
    refuses("warp", "1", "guess", "a machine has no number \"warp\"");
    refuses("sram", "0", "guess", "from 1 to 4294967295 bytes");
    refuses("sram", "4 KB", "guess", "from 1 to 4294967295 bytes");
    refuses("exchange", "4/0", "guess", "BYTES/CYCLES");
    refuses("exchange_cost", "free", "guess", "write capacity, live or unknown");
    refuses("sram", "1", "", "has no source that a file can hold");
    refuses("tiles", "1000", "guess", "has a grid of 40 x 36 tiles (machine mk2 has 1000)");
}

TEST_CASE("bad machine files are refused in one line that names the file")
{
    auto const begins = [](std::string const& text, std::string const& words) {
        auto const said = refusal(text);
        INFO(said);
        CHECK(said.rfind("m.txt ", 0) == 0);
        CHECK(has(said, words));
        CHECK(said.find('\n') == std::string::npos);
        CHECK(said.find("; ") != std::string::npos);
    };
    begins("", "it holds no machine");
    begins("model mk2\n", "begins no machine");
    begins("machine\n", "names no model");
    begins(with_line("tiles", "tile 4 tiles x"), "has an unknown parameter (\"tile\"); use tiles, columns");
    begins(with_line("tiles", "tiles 4 tiles x\ntiles 4 tiles x"), "repeats a parameter");
    begins(with_line("sram", ""), "parameter sram is missing");
    begins(with_line("sram", "sram 1 KB x"), "has another unit");
    begins(with_line("sram", "sram 1 bytes"), "has no source");
    begins(with_line("sram", "sram 0 bytes x"), "is out of range");
    begins(with_line("sram", "sram 4294967296 bytes x"), "is out of range");
    begins(with_line("sram", "sram some bytes x"), "has no whole number");
    begins(with_line("exchange", "exchange 0 bytes_a_cycle x"), "has no value of exchange");
    begins(with_line("exchange", "exchange 4/ bytes_a_cycle x"), "has no value of exchange");
    begins(with_line("exchange_cost", "exchange_cost dear kind x"), "has no kind of exchange");
    begins(with_line("columns", "columns 1000 tiles x"), "has a grid of 1000 x 36 tiles");
    begins(with_line("vote", "vote 1 cycles x\nnetwork.link 4 bytes_a_cycle x"), "without \"network\"");
    begins(with_line("vote", "vote 1 cycles x\nnetwork mesh kind n"), "without its nodes");
    begins(with_line("vote", "vote 1 cycles x\nnetwork mesh kind n\nnetwork.nodes 2x2 nodes x"), "without its flits");
    begins(with_line("vote", "vote 1 cycles x\nnetwork.lnik 4 bytes_a_cycle x"), "has an unknown parameter (\"network.lnik\"); use network, ");
    CHECK(read(with_line("sram", "sram unknown bytes nobody said")).unknown() == std::vector<std::string>{"sram"});
    CHECK(has(error_of([] { (void)size_of(read(with_line("sram", "sram unknown bytes nobody said"))); }), "its sram is unknown: nobody said"));
}

#include "require.hpp"
#include <optional>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/machine_file.hpp>

// Any text is a cost model, an energy model or a machine, which is written and read back, or gives an Error of one line.
namespace {

using namespace tilemesh;

template <class Read, class Write>
void check(std::string const& text, Read const& read, Write const& write)
{
    std::istringstream in(text);
    std::optional<decltype(read(in, "file"))> model;
    try {
        model = read(in, "file");
    } catch (Error const& error) {
        return require_error(error.what());
    }
    std::istringstream again(write(*model)); // an Error from here on is a finding
    require(read(again, "again") == *model, "what is written is read back");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const text(reinterpret_cast<char const*>(data), size);
    check(text, read_cost_model, [](CostModel const& model) {
        std::ostringstream out;
        write_cost_model(out, model);
        return out.str();
    });
    check(text, read_machine_file, [](MachineFile const& machine) {
        if (machine.number("clock").value) (void)cost_model_of(machine);
        return machine_file_text(machine);
    });
    check(text, read_energy_model, [&](EnergyModel const&) { return text; }); // nothing writes one
    return 0;
}

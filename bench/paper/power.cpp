#include "machines.hpp"
#include "tables.hpp"
#include <common/scenes.hpp>

void paper::power(Context const& context, Rows& rows)
{
    struct Chip {
        char const* name;
        double ms, fps, watts, peak_watts, fps_a_watt, joules;
    };
    constexpr Chip chips[] = {
        {"IPU", 50.55, 19.80, 27.18, 29.30, 0.73, 1.373},
        {"GTX 1080", 1.74, 580.55, 74.42, 119.67, 7.80, 0.128},
        {"RTX 4090", 0.42, 2401.47, 89.80, 112.61, 26.74, 0.037},
    };
    // Compares the table's columns with each other.
    for (auto const& c : chips) {
        rows.push_back({"power", c.name, "frames a second from its frame time", c.fps, 1000 / c.ms, "arithmetic",
                        "the mean of frame rates differs from the rate of the mean time"});
        rows.push_back({"power", c.name, "J a frame from power x time", c.joules, c.watts * c.ms / 1000, "arithmetic"});
        rows.push_back({"power", c.name, "frames a second a watt", c.fps_a_watt, c.fps / c.watts, "arithmetic"});
    }
    constexpr double stages_ms = 46.07, exchange_ms = 0.07;
    rows.push_back({"power", "IPU", "frame time from the stages (ms)", chips[0].ms, stages_ms + exchange_ms, "arithmetic",
                    "the stage table's mean total of slowest tiles, plus one exchange; no table has the rest of 50.55 ms"});

    // Ours: modelled times with the paper's measured power, as if the library's kernels drew the same power.
    double ms = 0;
    std::uint32_t scenes = 0;
    for (std::string const name : {"sloth", "salad"})
        if (bench::has_scene(name, context.data)) ms += model_scene(context, name).milliseconds, ++scenes;
    std::string const note = scenes == 0 ? "skipped: neither Sloth nor Salad is there"
                                         : "our kernels (parameters mk2), mean of Sloth and Salad on the orbit; assumes the power that the "
                                           "paper measured";
    auto const ours = [&](double value) { return scenes == 0 ? std::optional<double>() : value; };
    ms = scenes == 0 ? 1 : ms / scenes;
    auto const& ipu = chips[0];
    rows.push_back({"power", "ours on Mk2", "frame time (ms)", ipu.ms, ours(ms), "modelled", note});
    rows.push_back({"power", "ours on Mk2", "J a frame at 27.18 W", ipu.joules, ours(ipu.watts * ms / 1000), "modelled", note});
    rows.push_back({"power", "ours on Mk2", "frames a second a watt at 27.18 W", ipu.fps_a_watt, ours(1000 / ms / ipu.watts), "modelled", note});
    rows.push_back(
        skipped("power", "ours on Mk2", "power (W)", ipu.watts, "modelled", "no document gives an energy per event, and the library invents none"));
    rows.push_back(skipped("power", "ours on Mk2", "peak power (W)", ipu.peak_watts, "modelled", "as above"));
}

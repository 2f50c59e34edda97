#include "tables.hpp"
#include <common/statistics.hpp>

void paper::host_io(Context const&, Rows& rows)
{
    using bench::fixed;
    constexpr double pixels = 1280.0 * 720.0, frame_ms = 50.55, share_percent = 1.6;
    constexpr double in_bytes = 34 * 4;                                   // two 4 x 4 matrices and two focal lengths
    constexpr double rgbx8_bytes = 4 * pixels, float_bytes = 16 * pixels; // four floats a pixel
    constexpr double counts_bytes = 4 * (1440.0 + 7200.0);                // one count and five cycle words per tile
    /// PCIe Gen4 x16, one way; nominal.
    constexpr double gigabytes_a_second = 32;
    std::string const rate = "PCIe at " + fixed(gigabytes_a_second, 0) + " GB/s one way, nominal; no latency";
    auto const ms = [](double bytes) { return bytes / (gigabytes_a_second * 1e6); };
    auto const share = [&](double bytes) { return 100 * ms(in_bytes + bytes) / frame_ms; };

    double const paper_ms = share_percent / 100 * frame_ms;
    auto const add = [&](char const* row, char const* quantity, std::optional<double> paper, double ours, char const* kind,
                         std::string const& note = {}) {
        rows.push_back({"host_io", row, quantity, paper, ours, kind, note});
    };
    add("a frame in", "view and projection (B)", {}, in_bytes, "arithmetic", "34 floats");
    add("a frame out", "RGBX8 (B)", {}, rgbx8_bytes, "arithmetic");
    add("a frame out", "floats (B)", {}, float_bytes, "arithmetic", "what the authors' earlier code sent");
    add("a frame out", "counts and cycles only (B)", {}, counts_bytes, "arithmetic",
        "the authors' benchmark reads these by default; it reads the framebuffer only on request");
    auto const of_frame = "share of the paper's 50.55 ms (%)";
    add("RGBX8", of_frame, share_percent, share(rgbx8_bytes), "modelled", rate);
    add("floats", of_frame, share_percent, share(float_bytes), "modelled", rate);
    add("counts and cycles", of_frame, share_percent, share(counts_bytes), "modelled",
        rate + "; if this is what the paper reads, its share is latency");
    auto const gigabytes = [&](double bytes) { return (in_bytes + bytes) / (paper_ms * 1e6); };
    add("1.6 % of 50.55 ms", "time (ms)", {}, paper_ms, "arithmetic");
    add("1.6 % of 50.55 ms", "rate if RGBX8 was read (GB/s)", {}, gigabytes(rgbx8_bytes), "arithmetic", "a seventh of the nominal rate one way");
    add("1.6 % of 50.55 ms", "rate if floats were read (GB/s)", {}, gigabytes(float_bytes), "arithmetic");
    add("1.6 % of 50.55 ms", "rate if counts and cycles were read (GB/s)", {}, gigabytes(counts_bytes), "arithmetic");
}

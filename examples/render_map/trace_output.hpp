#pragma once
#include "instruments.hpp"
#include "options.hpp"
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/trace_section.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/run_report.hpp>
#include <utility>
#include <vector>

namespace render_map {

/// A frame's longer table by superstep and tile is written only if --trace-tiles asks for it: 10 MB at about 50 bytes a line.
inline constexpr std::size_t most_tile_lines = 200'000;
/// A frame's timeline for trace viewers stays below this: the busiest tiles are shown, as many as fit.
inline constexpr std::size_t most_timeline_bytes = 20'000'000;

/// The report shows so many frames in full, and no more after so many bytes: a browser should open it at once. All frames
/// are in the other files, and up to `most_lines` of them have a line in its tables.
inline constexpr std::size_t most_full_frames = 12, most_report_bytes = 32'000'000, most_lines = 1000;

/// What --trace writes: each frame's files when it is rendered, then the report. Every file is whole or not there. Throws
/// `tilemesh::Error` for a model that cannot be read, an event that occurs and has no energy in the one that --energy names, and
/// a file that cannot be written.
class TraceOutput {
public:
    /// Reads the cost model and the energy model, where they are named. Nothing is written yet.
    explicit TraceOutput(Options const& options);

    /// The frame that was rendered last. `map` and setup are described in `run`, which may still lack the frame. Returns its modelled time.
    tilemesh::report::Modelled add_frame(std::size_t index, tilemesh::report::RunFrame const& frame, tilemesh::report::Image const& picture,
                   Instruments& instruments);

    /// The error of a run that made no progress, whole; returns the file's name.
    std::string write_no_progress(std::string const& text) const;

    /// Writes report.html, and what was seen of the Gaussian that is followed.
    void finish(tilemesh::report::RunReport const& run) const;

    /// For a terminal: where the cycles of the last frame went, and the followed Gaussian's life.
    std::string summary() const;

private:
    /// What the report shows of a frame.
    struct Section {
        std::size_t frame;
        std::string heading;
        std::vector<std::pair<std::string, std::string>> facts;
        tilemesh::TraceSection run;
        std::vector<std::vector<std::string>> rounds; ///< of the program of homes
    };
    void write(std::string const& name, std::string const& text) const;
    void remove_old(std::string const& name) const; ///< what this run has none of and an earlier one may have left
    void add_life(std::size_t index, Life const& life);
    void add_run(tilemesh::report::HtmlReport& report, tilemesh::report::RunReport const& run) const;
    void add_frames(tilemesh::report::HtmlReport& report) const;

    Options options_;
    std::filesystem::path folder_;
    std::uint32_t followed_; ///< 0: none
    tilemesh::CostModel model_;
    std::optional<tilemesh::EnergyModel> energy_model_;
    std::vector<std::string> counted_; ///< operations of all frames
    std::vector<Section> sections_; ///< of the frames that are shown in full
    std::size_t bytes_ = 0, frames_ = 0, sights_ = 0;
    std::size_t slowest_ = 0;       ///< the frame that takes the most cycles; of equals the first
    std::uint64_t slowest_cycles_ = 0;
    std::string slowest_lead_;      ///< the sentence that names its bottleneck
    std::vector<std::vector<std::string>> lines_, lives_, seen_;
    std::vector<std::pair<double, double>> milliseconds_; ///< of each frame
    std::string follow_csv_;
    std::string cost_text_, life_text_; ///< of the last frame
};

} // namespace render_map

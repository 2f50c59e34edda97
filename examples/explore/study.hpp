#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/machine_file.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/quality.hpp>
#include <utility>
#include <vector>

namespace explore {

/// The capacities of a point. Empty: those of the preset, as far as they fit on the machine.
struct Capacities {
    std::string name;                              ///< "preset", or the words that were asked for
    bool of_preset = true;
    std::vector<tilemesh::render::SetupValue> channels; ///< fields of a setup: slots of channels and FIFOs
    std::optional<std::uint32_t> storage;          ///< slots; none: the rest of the SRAM
};

/// A map with its views. It is shared, because most points have one map.
struct Subject {
    std::string name, key;                         ///< `key` changes with the map's bytes and the views
    std::string view;                              ///< which camera shows it, for readers
    tilemesh::scene::Map map;
    std::vector<tilemesh::splat::Camera> views;
    bool antialias = false;                        ///< the map was trained so
};

/// Prices. A model of `machine` has the prices of the point's machine, changed.
struct Prices {
    std::string name;                              ///< empty: those of the machine
    std::optional<tilemesh::CostModel> model;      ///< a file's
    std::vector<std::pair<std::string, std::uint64_t>> changed; ///< parameter and value
};

/// What can be asked of one point.
struct Setting {
    std::string name;                              ///< what differs from point to point
    std::shared_ptr<Subject const> subject;
    std::shared_ptr<tilemesh::MachineFile const> machine;
    tilemesh::Extent2 grid{};
    bool homes = false;
    std::string preset;
    std::vector<tilemesh::render::SetupValue> policies; ///< others than the preset's
    std::optional<tilemesh::splat::Quality> quality;
    Capacities capacities;
    std::shared_ptr<Prices const> prices;
};

struct Study {
    std::string name;
    std::vector<Setting> settings;
    std::vector<std::filesystem::path> read;       ///< every file that it reads
    std::vector<std::string> notes;                ///< what a reader of the answers must know, a line each
};

/// A problem with another advice: what follows the last "; " of an error.
inline std::string with_remedy(std::string const& error, std::string const& remedy)
{
    return error.substr(0, error.rfind("; ")) + "; " + remedy;
}

/// Reads a study and the files that it names, which are beside it, in the `folder` that it names, or absolute. Throws `tilemesh::Error`,
/// one line, for anything else.
Study load_study(std::filesystem::path const& path);

} // namespace explore

#pragma once
#include <common/options.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <vector>

namespace track_bench {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
namespace track = tilemesh::track;
namespace report = tilemesh::report;

inline constexpr char const* method_names[] = {"hybrid", "forward", "gradient", "esm"};

struct Options : bench::Options {
    std::vector<std::string> scenes, tables, methods; ///< empty: all
    std::uint32_t trials = 20;
    std::uint32_t rounds = 9;

    void finish(shared::OptionTable const& given);
};

/// The names of the scenes that the options name and whose files exist; it says which are skipped.
std::vector<std::string> scenes_of(Options const& options);

/// A map, a camera that sees it, what the camera sees, and the median depth there.
struct View {
    scene::Map map;
    splat::Camera camera;
    report::Image colour;
    report::Plane depth; ///< 0 where less than half of a pixel is covered
    double scale = 1;
};
/// `front` of the authors' maps, or the built-in map's own camera. Throws Error for a bad file.
View load_view(std::string const& name, std::filesystem::path const& data, scene::Size size);

/// What a solver asks for, besides the level.
struct Asked {
    bool depth = true, exposure = false;
    std::uint32_t one_in = 1, seed = 0;
};

/// track::PoseEvaluator. It is compiled once for all tables.
class Evaluator {
public:
    virtual ~Evaluator() = default;
    virtual void set_target(report::Image colour, report::Plane depth) = 0;
    virtual void ask(Asked asked) = 0;
    virtual track::NormalEquations operator()(splat::Camera const& camera, track::Level const& level) = 0;
    /// Pairs of the last evaluation in forward mode that contributed.
    virtual std::uint64_t contributing() = 0;
    /// The most records and copies of a tile.
    virtual std::uint32_t most_stored() = 0;
    virtual tilemesh::Grid grid() = 0;
    virtual tilemesh::Extent2 tile() = 0;   ///< pixels
    virtual std::uint32_t slots() = 0; ///< of a tile's storage
    /// Only for a traced one: the trace of the last evaluation.
    virtual tilemesh::Trace const& trace() = 0;
};
/// Mk2, with the tiles and slots that tracking chooses for the size of the picture; or a machine whose tiles of 16 x 40 have room for any of
/// these maps.
enum class On { mk2, mk2_traced, roomy };
std::unique_ptr<Evaluator> make_evaluator(View const& view, std::uint32_t threads, On where);

/// Prints the tables of convergence that the options name, and writes them. Returns 1 if a bound is missed that must hold.
int basin(Options const& options);
/// Prints milliseconds of evaluations, of a frame, and of renders of the same map.
void times(Options const& options);
/// Prints the modelled milliseconds of evaluations on Mk2, step by step.
void modelled(Options const& options);

} // namespace track_bench

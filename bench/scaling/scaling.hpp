#pragma once
#include <common/options.hpp>
#include <common/scenes.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/model/hosts.hpp>
#include <tilemesh/render/setup.hpp>
#include <vector>

namespace scaling {

struct Options : bench::Options {
    std::vector<std::string> axes; ///< empty: all
    std::string motion = "orbit0.5";
    std::vector<std::uint32_t> threads; ///< measured side by side
    bool ranks = false, frames = false, predict = false, chips = false;
    std::optional<tilemesh::HostNetwork> network; ///< one more network for the prediction

    void finish(shared::OptionTable const& given);
};

/// A map of `gaussians` records from one distribution, and its camera. A map with n records has the first n records of any larger map.
///
/// Means are uniform over the frame and a tenth beyond it on each side, at depths of 2 to 6. Footprints have standard deviations of about 1
/// to 8 pixels at 1280 x 720, with axis ratios up to 7. Opacities are 0.05 to 0.6, so that light passes through some tens of layers. The
/// map is computed with integers, and `exp`, `log` and `sqrt` in double. With another `pixels_wide`, footprints have these sizes in a frame
/// that is so wide.
bench::Scene synthetic(std::uint32_t gaussians, tilemesh::scene::Size size, std::uint32_t pixels_wide = 1280);

/// `lossless` with more slots and pixels per tile: room for every value of every axis. Capacity is address space, and costs no memory until
/// it is used.
tilemesh::render::Setup roomy_setup();

/// Prints the predicted time of a frame over 1 to 1,024 hosts. Returns the exit status.
int predict(Options const& options);
/// Prints what arrays of Mk2 chips cost against one chip of as many tiles. Returns the exit status.
int chips(Options const& options);

/// With the argument --ranks, MPI is initialised as long as this lives, and only rank 0 prints.
class OnRanks {
public:
    OnRanks(int argc, char** argv);
    ~OnRanks();
    OnRanks(OnRanks const&) = delete;
    OnRanks& operator=(OnRanks const&) = delete;

private:
    [[maybe_unused]] bool on_ = false;
};

/// Measures MpiMesh over ranks and threads. Collective. Returns the exit status. Throws Error in a build without MPI.
int run_on_ranks(Options const& options);
/// Measures whole frames over ranks and threads. Collective. Returns the exit status. Only in a build with MPI.
int frames_on_ranks(Options const& options);

} // namespace scaling

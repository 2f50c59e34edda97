#pragma once
#include <cstddef>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/slam/state_bytes.hpp>
#include <tilemesh/splat/camera.hpp>
#include <utility>
#include <vector>

namespace slam_program {

/// Pictures of a map while it grows, all of one view: from the first pose, with a lens that is twice as wide, so that new places come into
/// the picture. At most 64 are kept, evenly spaced over the keyframes.
class Growth {
public:
    Growth(tilemesh::scene::Pose const& first, tilemesh::scene::Intrinsics lens);
    /// After a keyframe.
    void see(tilemesh::slam::Mapper& mapper, std::size_t frame);

    /// The pictures so far, for a run that goes on; `load` reads them.
    void save(tilemesh::slam::StateWriter& out) const;
    void load(tilemesh::slam::StateReader& in);

    struct Picture {
        std::size_t frame, gaussians;
        std::string png;
    };
    /// After the first keyframe, in the middle, and now: less if there are less keyframes.
    std::vector<Picture> three(tilemesh::slam::Mapper& mapper, std::size_t frames) const;

private:
    Picture picture_of(tilemesh::slam::Mapper& mapper, std::size_t frame) const;

    tilemesh::splat::Camera camera_;
    std::vector<Picture> seen_;
    std::size_t every_ = 1, keyframes_ = 0;
};

/// A page of a run as one HTML file: its numbers, three pictures of the map, and the paths, as an SVG.
std::string page_of(std::vector<std::pair<std::string, std::string>> const& numbers, std::vector<Growth::Picture> const& pictures,
                    std::string const& path_svg);

} // namespace slam_program

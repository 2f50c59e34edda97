#pragma once
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/camera.hpp>

namespace bench {

/// A mesh that renders frame after frame; hides the setup that it was compiled for.
class Machine {
public:
    virtual ~Machine() = default;
    /// Wakes the mesh's threads, as they are while frames follow each other.
    virtual void wake(tilemesh::splat::Camera const&) = 0;
    virtual void render(tilemesh::splat::Camera const&) = 0;
    /// Of the last frame.
    virtual tilemesh::report::Image const& image() const = 0;
    virtual tilemesh::report::FrameReport const& report() const = 0;
};

} // namespace bench

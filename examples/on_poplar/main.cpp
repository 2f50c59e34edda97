// A map on an IPU: the frame program as a Poplar graph, a cold start and the same view again.
//   on_poplar CODELETS.gp [MAP.ply]
#include "../shared/kept_inputs.hpp"
#include "../shared/text.hpp"
#include <cstdio>
#include <exception>
#include <iostream>
#include <poplar/DeviceManager.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/poplar/poplar_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;

namespace {
poplar::Device first_ipu()
{
    for (auto& device : poplar::DeviceManager::createDeviceManager().getDevices(poplar::TargetType::IPU, 1))
        if (device.attach()) return std::move(device);
    throw tilemesh::Error("no IPU (none is there, or all are taken); see gc-info, and try again");
}
} // namespace

int main(int argc, char** argv)
try {
    if (argc != 2 && argc != 3)
        throw tilemesh::Error("no codelets (usage: on_poplar CODELETS.gp [MAP.ply]); build codelets.gp with popc");
    shared::keep_inputs({argv + 1, argv + argc}, {"on_poplar.pfm"});
    auto const map = argc == 3 ? scene::load_ply(argv[2]) : scene::built_in_map();
    auto const camera = argc == 3 ? scene::frame_whole(map, {1280, 720}) : scene::built_in_camera({1280, 720});

    auto const device = first_ipu();
    tilemesh::PoplarOptions on;
    on.device = &device;
    on.codelets = argv[1];
    on.prefix = "lossless"; // the prefix of the vertices' names in codelets.cpp
    tilemesh::BasicRenderer<tilemesh::splat::Lossless, tilemesh::PoplarMesh> renderer{map, {}, on};
    tilemesh::RenderedFrame frame;
    for (int i = 0; i < 2; ++i) {
        renderer.render_into(camera, frame);
        std::cout << frame.report << '\n';
    }
    report::write_pfm("on_poplar.pfm", frame.image);
} catch (std::exception const& e) {
    std::fprintf(stderr, "on_poplar: %s\n", shared::one_line(e.what()).c_str());
    return 2;
}

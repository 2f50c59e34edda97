// A stranger's program. What it prints is exact: the same for every way to get the library.
#include <iostream>
#include <tilemesh/tilemesh.hpp>

int main()
try {
    auto const map = tilemesh::scene::built_in_map();
    auto const camera = tilemesh::scene::frame_whole(map, {320, 180});

    tilemesh::Renderer renderer{map};
    auto const report = renderer.render(camera).report;

    std::cout << "exchanges " << report.exchanges.total() << '\n'
              << "visible " << report.gaussians.visible << '\n'
              << "copies " << report.copies << '\n'
              << "messages " << report.messages << '\n'
              << "pairs " << report.pairs << '\n'
              << "lost " << report.lost.size() << '\n';
} catch (tilemesh::Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}

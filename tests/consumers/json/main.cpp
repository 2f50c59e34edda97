// A stranger's program that reads and writes JSON: the name of a camera file, the name of the report to write.
#include <iostream>
#include <tilemesh/report/json.hpp>
#include <tilemesh/scene/camera_json.hpp>

int main(int, char** argv)
try {
    tilemesh::report::RunReport run;
    for (auto const& named : tilemesh::scene::load_cameras(argv[1])) {
        tilemesh::report::RunFrame frame;
        frame.report.camera = named.scene + '/' + named.name;
        frame.report.width = named.camera.width;
        frame.report.height = named.camera.height;
        run.frames.push_back(frame);
    }
    tilemesh::report::write_json(argv[2], run);
    auto const json = tilemesh::report::json_of(run);
    for (auto const& frame : json["frames"]) std::cout << frame["camera"] << ' ' << frame["size_px"] << '\n';
} catch (tilemesh::Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}

// With two_units_b.cpp: all of the library in two translation units of one program. A function that is not inline would not link, and both
// units render the same picture. With headers alone, a Renderer says which program it does not have.
#include <cstdio>
#include <string>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/tilemesh.hpp>

static_assert(TILEMESH_VERSION == PROJECT_VERSION_NUMBER, "CMakeLists.txt and config.hpp name different versions");

tilemesh::report::Image other_unit_renders(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera);

namespace {
/// The error of a Renderer with these options.
std::string refusal(tilemesh::scene::Map const& map, tilemesh::RendererOptions const& options)
{
    try {
        tilemesh::Renderer{map, options};
    } catch (tilemesh::Error const& error) {
        return error.what();
    }
    return {};
}
} // namespace

int main()
{
    auto const map = tilemesh::scene::built_in_map();
    tilemesh::splat::Camera const camera{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, -0.3f, -1.5f}, 60, 60, 40, 30, 0.2f, 80, 60};
    tilemesh::Renderer renderer(map);
    auto const frame = renderer.render(camera);
    auto const other = other_unit_renders(map, camera);
    float sum = 0;
    for (float v : frame.image.rgb) sum += v;
    std::printf("%llu pairs, sum of the picture %g\n", static_cast<unsigned long long>(frame.report.pairs_contributing),
                static_cast<double>(sum));
    tilemesh::RendererOptions homes, checked, traced;
    homes.program = tilemesh::report::Program::homes;
    checked.engine = tilemesh::render::EngineKind::checked;
    traced.trace = true;
    bool const says = refusal(map, homes).starts_with("the program of homes in a program that has headers alone") &&
                      refusal(map, checked).starts_with("an engine that checks in") && refusal(map, traced).starts_with("a trace in");
    return says && sum > 0 && frame.image.rgb == other.rgb ? 0 : 1;
}

// With two_units_b.cpp: all of the library in two translation units of one program. A function that is not inline would not link, and both
// units render the same picture.
#include <cstdio>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/tilemesh.hpp>

static_assert(TILEMESH_VERSION == PROJECT_VERSION_NUMBER, "CMakeLists.txt and config.hpp name different versions");

tilemesh::report::Image other_unit_renders(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera);

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
    return sum > 0 && frame.image.rgb == other.rgb ? 0 : 1;
}

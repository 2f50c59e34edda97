// test: unoptimised test asan tsan
// The host's work for the machine, bit for bit: it projects a table of any degree, and shows floats as levels.
#include "../splat/support.hpp"
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/project_records.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
/// Does the record of a row have the map's coefficients of that row, followed by zeros?
template <std::uint32_t Degree>
bool is_row_of(scene::Map const& map, std::uint32_t row, GaussianOfDegree<Degree> const& record)
{
    if constexpr (Degree != 0) {
        std::vector<float> expected(std::size(record.harmonics));
        auto const floats = 3 * std::size_t{harmonics_per_channel(map.sh_degree)};
        std::copy_n(map.harmonics.begin() + static_cast<std::ptrdiff_t>(row * floats), map.sh_degree == 0 ? 0 : floats, expected.begin());
        if (std::memcmp(expected.data(), record.harmonics, sizeof record.harmonics) != 0) return false;
    }
    return record.id == map.gaussians[row].id;
}
template <std::uint32_t Degree>
void same_projections(scene::Map const& map)
{
    render::RecordTable const table(map, Degree);
    for (std::uint32_t row = 0; row < table.rows(); ++row)
        CHECK(is_row_of<Degree>(map, row, table.record<GaussianOfDegree<Degree>>(row)));
    for (float turn : {0.0f, 0.4f, 2.9f})
        for (auto const arithmetic : {Arithmetic::precise, Arithmetic::fast}) {
            Rules rules;
            rules.arithmetic = arithmetic;
            auto const view = make_view(support::lens(120, 80, turn), rules);
            auto const tiling = make_tiling(120, 80, 16, 10);
            std::vector<Splat> all(table.rows());
            render::project_rows(table, 0, 7, view, tiling, all.data());
            render::project_rows(table, 7, table.rows() - 7, view, tiling, all.data() + 7);
            std::uint32_t wrong = 0, visible = 0;
            for (std::uint32_t row = 0; row < table.rows(); ++row) {
                auto const value = project(table.record<GaussianOfDegree<Degree>>(row), view, tiling);
                auto const one = render::project_row(table, row, view, tiling);
                wrong += std::memcmp(&one, &value, sizeof value) != 0 || std::memcmp(&all[row], &value, sizeof value) != 0;
                visible += value.visible();
            }
            INFO("degree ", Degree, ", turn ", turn);
            CHECK(wrong == 0);
            CHECK((visible > 100 || turn == 2.9f));
        }
}
scene::Map shaded(std::uint32_t degree)
{
    auto map = support::map_of(support::cloud(500, 91));
    map.sh_degree = degree;
    support::Random random(degree);
    map.harmonics.resize(3 * std::size_t{harmonics_per_channel(degree)} * map.gaussians.size());
    for (float& v : map.harmonics) v = random.uniform(-1, 1);
    if (degree != 0) { // spoils a colour
        map.harmonics[3] = std::numeric_limits<float>::quiet_NaN();
        map.harmonics[map.harmonics.size() / 2] = std::numeric_limits<float>::infinity();
        map.harmonics[map.harmonics.size() - 1] = -3e38f;
    }
    return map;
}
} // namespace

TEST_CASE("a table of any degree projects its rows as tiles project their records")
{
    same_projections<0>(shaded(0));
    same_projections<1>(shaded(1));
    same_projections<2>(shaded(2));
    same_projections<3>(shaded(3));
}

TEST_CASE("a table whose records have room for more than the map gives: as tiles project them")
{
    auto const map = shaded(0);
    same_projections<1>(map);
    same_projections<3>(map);
}

TEST_CASE("a row of floats is shown as the machine's bytes are, whatever blending left")
{
    std::vector<float> values = {0, -0.0f, 1, -1, 3.8f, 1e-45f, -1e-45f, 255, 256, 3e38f, -3e38f, 0.5f, std::nextafter(1.0f, 0.0f),
                                 std::nextafter(1.0f, 2.0f), std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                                 -std::numeric_limits<float>::infinity()};
    for (int level = 0; level < 255; ++level) { // around each half
        auto const half = static_cast<float>((level + 0.5) / 255);
        for (float v : {std::nextafter(half, 0.0f), half, std::nextafter(half, 1.0f)}) values.push_back(v);
    }
    while (values.size() % 3 != 0) values.push_back(0.25f);
    auto const pixels = static_cast<std::uint32_t>(values.size() / 3);
    RenderedFrame machine;
    machine.image = report::Image(pixels, 1);
    for (std::uint32_t x = 0; x < pixels; ++x) {
        float const* const v = values.data() + 3 * std::size_t{x};
        render::detail::show(Rgbx8Pixel::make({{v[0], v[1], v[2]}, 1, 0, 0}), x, 0, machine);
    }
    auto host = values;
    render::detail::round_to_levels(host.data(), 3 * pixels);
    CHECK(std::memcmp(host.data(), machine.image.rgb.data(), host.size() * sizeof(float)) == 0);
    CHECK(host[3] == 0);
    CHECK(host[4] == 1);
    CHECK(host[14] == 0); // no number
}

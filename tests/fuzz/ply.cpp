#include "plain_maps.hpp"
#include "plain_ply.hpp"
#include "require.hpp"
#include "same_map.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/ply.hpp>

// Any bytes are a map that keeps the reader's promises, or give an Error of one line.
namespace {

bool finite(float const* values, int n)
{
    bool all = true;
    for (int i = 0; i < n; ++i) all = all && std::isfinite(values[i]);
    return all;
}

std::uint64_t promised_rows(std::string const& bytes)
{
    std::istringstream stream(bytes);
    tilemesh::scene::detail::ByteSource source(stream, "fuzz");
    for (auto const& element : tilemesh::scene::detail::read_ply_header(source, "fuzz").elements)
        if (element.name == "vertex") return element.count;
    return ~std::uint64_t{0};
}

void check(tilemesh::scene::Map const& map, std::string const& bytes)
{
    require(map.gaussians.size() + map.rejected == promised_rows(bytes), "every row is kept or rejected");
    require(map.gaussians.size() <= bytes.size() / 14, "14 bytes make a row at least");
    for (auto const& note : map.notes) {
        require(note.size() < 2000, "notes are short");
        require(note.find_first_of("\n\r") == std::string::npos, "notes have one line");
    }
    require(map.sh_degree <= 3, "no degree above 3");
    auto const floats = std::size_t{3} * tilemesh::splat::harmonics_per_channel(map.sh_degree);
    require(map.harmonics.size() == map.gaussians.size() * floats, "harmonics go with the Gaussians");
    require(finite(map.harmonics.data(), static_cast<int>(map.harmonics.size())), "harmonics are finite");
    std::uint32_t last = 0;
    for (auto const& g : map.gaussians) {
        auto const id = static_cast<std::uint32_t>(g.id);
        require(id > last, "ids ascend from 1");
        last = id;
        require(finite(g.mean_world, 3) && finite(g.colour, 3) && finite(g.rotation, 4) && finite(g.log_scale, 3),
                "fields are finite");
        require(g.opacity >= 0.0f && g.opacity <= 1.0f, "opacity is in [0, 1]");
        float squares = 0.0f;
        for (float q : g.rotation) squares += q * q;
        require(std::fabs(squares - 1.0f) < 2e-3f, "quaternions are normalised");
        for (int i = 0; i < 3; ++i) {
            require(map.sh_degree != 0 || g.colour[i] >= 0.0f, "a colour that nothing is added to is not negative");
            require(g.log_scale[i] >= -87.0f, "log_scale is not below -87");
        }
    }
    require(last <= promised_rows(bytes), "ids are rows");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const bytes(reinterpret_cast<char const*>(data), size);
    auto const expected = plain::Ply(bytes).read();
    std::istringstream stream(bytes);
    try {
        auto const map = tilemesh::scene::read_ply(stream, "fuzz.ply");
        check(map, bytes);
        if (!map.notes.empty() && map.notes[0].starts_with("read as a compressed PLY")) {
            auto const unpacked = plain::compressed_ply(bytes);
            require(unpacked.has_value(), "a compressed PLY is one");
            require_same(map, *unpacked);
            return 0;
        }
        require(expected.has_value(), "what the plain reader refuses is refused");
        require_same(map, *expected);
    } catch (tilemesh::Error const& error) {
        std::string const text = error.what();
        require(!expected.has_value(), "what the plain reader reads is read");
        require_error(text);
        require(text.size() < 2000, "errors are short");
    }
    return 0;
}

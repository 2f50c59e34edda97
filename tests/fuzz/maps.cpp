#include "../scene/plain_codecs.hpp"
#include "plain_maps.hpp"
#include "require.hpp"
#include "same_map.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/map_file.hpp>

// Any bytes are a map that keeps the readers' promises, or give an Error of one line. The formats are .splat, SPZ, SOG and, less often, PLY.
// The decoders are stand-ins that decompress nothing and check nothing: so inputs reach what lies behind them.
extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    namespace scene = tilemesh::scene;
    std::string const bytes(reinterpret_cast<char const*>(data), size);
    std::istringstream stream(bytes);
    try {
        scene::Map const map = scene::read_map(stream, "fuzz.splat", scene_test::plain_codecs<false>());
        require(map.gaussians.size() + map.rejected <= size + 65536, "rows are bounded by the length of the file");
        require(map.gaussians.capacity() <= size + 65536, "memory is bounded by the length of the file");
        bool const headless = !bytes.starts_with("ply") && !bytes.starts_with("PK") && !bytes.starts_with("NGSP") && !bytes.starts_with("\x1f\x8b");
        require(!headless || map.gaussians.size() + map.rejected == size / 32, "32 bytes are a row of a .splat");
        for (auto const& note : map.notes) require(is_one_line(note) && note.size() < 2000, "notes are short lines");
        require(map.sh_degree <= 3, "no degree above 3");
        auto const floats = std::size_t{3} * tilemesh::splat::harmonics_per_channel(map.sh_degree);
        require(map.harmonics.size() == map.gaussians.size() * floats, "harmonics go with the Gaussians");
        bool finite = true;
        for (float v : map.harmonics) finite = finite && std::isfinite(v);
        std::uint32_t last = 0;
        for (auto const& g : map.gaussians) {
            require(static_cast<std::uint32_t>(g.id) > last, "ids ascend from 1");
            last = static_cast<std::uint32_t>(g.id);
            float squares = 0.0f;
            for (float q : g.rotation) squares += q * q;
            require(std::fabs(squares - 1.0f) < 1e-5f, "quaternions are normalised");
            for (int i = 0; i < 3; ++i) {
                finite = finite && std::isfinite(g.mean_world[i]) && std::isfinite(g.colour[i]) && std::isfinite(g.log_scale[i]);
                require(map.sh_degree != 0 || g.colour[i] >= 0.0f, "a colour that nothing is added to is not negative");
                require(g.log_scale[i] >= -87.0f, "log_scale is not below -87");
            }
            require(g.opacity >= 0.0f && g.opacity <= 1.0f, "opacity is in [0, 1]");
        }
        require(finite, "numbers are finite");
        require(last <= map.gaussians.size() + map.rejected, "ids are rows");
        if (map.notes.empty()) return 0;
        if (auto const expected = plain::compressed(bytes, map.notes[0])) require_same(map, *expected);
        else require(map.notes[0].find("read as ") != 0 || (map.notes[0].find("read as SOG") == 0 && plain::has_a_key_twice(bytes)),
                     "every format has a plain reader, which reads what the library reads");
    } catch (tilemesh::Error const& error) {
        require_error(error.what());
        require(std::string(error.what()).size() < 2000, "errors are short");
    }
    return 0;
}

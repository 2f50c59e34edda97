#include "../scene/map_writers.hpp"
#include "../scene/plain_codecs.hpp"
#include "map_promises.hpp"
#include <span>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/codecs.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <utility>

namespace {

constexpr char const *pictures = "pictures of an SOG map", *sog_maps = "whole SOG maps", *spz_maps = "whole SPZ maps";
[[maybe_unused]] bool const named = (reached = {{pictures, 0}, {sog_maps, 0}, {spz_maps, 0}}, true);
bool decoded = false; ///< a picture of this input

/// The stand-ins, and a count of the inputs that have a picture to decode: their archive and meta.json are whole.
tilemesh::scene::Codecs counting_codecs()
{
    auto codecs = scene_test::plain_codecs<false>();
    codecs.webp_read = +[](std::span<unsigned char const> in, std::span<unsigned char> rgba) {
        if (!std::exchange(decoded, true)) ++reached[pictures];
        return scene_test::plain_codecs<false>().webp_read(in, rgba);
    };
    return codecs;
}

/// An archive with a meta.json, which ends at the first line break, and the pictures of two Gaussians. The bytes behind that line break change
/// those of the pictures.
std::string archive_of(std::string const& text)
{
    scene_test::Numbers numbers(1);
    scene_test::Packing packing;
    packing.codecs = scene_test::plain_codecs<false>();
    auto files = scene_test::PackedSog::random(2, 2, 1, numbers).files(packing);
    std::size_t at = std::min(text.find('\n'), text.size());
    files["meta.json"] = text.substr(0, at);
    for (auto& [name, content] : files) {
        if (name == "meta.json") continue;
        for (std::size_t i = 0; i < content.size() && ++at < text.size(); ++i) content[i] = static_cast<char>(content[i] ^ text[at]);
    }
    return scene_test::write_zip(files, packing, false);
}

} // namespace

// Any bytes are a map that keeps the readers' promises, or give an Error of one line. The formats are .splat, SPZ, SOG and, less often, PLY.
// The decoders are stand-ins that decompress nothing and check nothing: so inputs reach what lies behind them. An input that begins with "{" becomes
// an SOG archive (`archive_of`): there a mutation may change lengths, which the directory of an archive does not survive.
extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    namespace scene = tilemesh::scene;
    decoded = false;
    std::string bytes(reinterpret_cast<char const*>(data), size);
    if (bytes.starts_with("{")) {
        bytes = archive_of(bytes);
        size = bytes.size();
    }
    std::istringstream stream(bytes);
    try {
        scene::Map const map = scene::read_map(stream, "fuzz.splat", counting_codecs());
        require(map.gaussians.size() + map.rejected <= size + 65536, "rows are bounded by the length of the file");
        require(map.gaussians.capacity() <= size + 65536, "memory is bounded by the length of the file");
        bool const headless = !bytes.starts_with("ply") && !bytes.starts_with("PK") && !bytes.starts_with("NGSP") && !bytes.starts_with("\x1f\x8b");
        require(!headless || map.gaussians.size() + map.rejected == size / 32, "32 bytes are a row of a .splat");
        require_promises(map);
        if (map.notes.empty()) return 0;
        if (map.notes[0].starts_with("read as SOG")) ++reached[sog_maps];
        if (map.notes[0].starts_with("read as SPZ")) ++reached[spz_maps];
    } catch (tilemesh::Error const& error) {
        require_short_error(error.what());
    }
    return 0;
}

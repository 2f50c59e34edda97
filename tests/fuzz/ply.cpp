#include "map_promises.hpp"
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/ply.hpp>

// Any bytes are a map that keeps the reader's promises, or give an Error of one line.
namespace {

std::uint64_t promised_rows(std::string const& bytes)
{
    std::istringstream stream(bytes);
    tilemesh::scene::detail::ByteSource source(stream, "fuzz");
    for (auto const& element : tilemesh::scene::detail::read_ply_header(source, "fuzz").elements)
        if (element.name == "vertex") return element.count;
    return ~std::uint64_t{0};
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const bytes(reinterpret_cast<char const*>(data), size);
    std::istringstream stream(bytes);
    try {
        auto const map = tilemesh::scene::read_ply(stream, "fuzz.ply");
        require_promises(map);
        require(map.gaussians.size() + map.rejected == promised_rows(bytes), "every row is kept or rejected");
        require(map.gaussians.size() <= bytes.size() / 14, "14 bytes make a row at least");
    } catch (tilemesh::Error const& error) {
        require_short_error(error.what());
    }
    return 0;
}

// Where is the camera: how far off a start may be, how exact the pose is, and what an evaluation costs.
#include "basin.hpp"
#include "options.hpp"
#include "times.hpp"
#include <common/program.hpp>

namespace {

int run(track_bench::Options const& options)
{
    auto const wants = [&](char const* table) { return bench::chosen(options.tables, table); };
    int status = 0;
    if (wants("basin") || wants("subsets") || wants("spoilt")) status = track_bench::basin(options);
    if (wants("times")) track_bench::times(options);
    if (wants("model")) track_bench::modelled(options);
    return status;
}

} // namespace

int main(int argc, char** argv)
{
    return bench::program(argc, argv, track_bench::table_of, run, "not enough memory (each scene has a mesh); name one --scene");
}

// EXPECT: two kernels of a program with one name
#include <tilemesh/poplar/program_graph.hpp>

struct Sum {
    std::uint32_t word;
};
template <std::uint32_t N>
struct Add {
    void operator()(Sum& sum) const noexcept { sum.word += N; }
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Add<1>>, tilemesh::Superstep<Add<100>>>;

template class tilemesh::on_poplar::ProgramGraph<Program, tilemesh::Mk2>;

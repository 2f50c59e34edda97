#include <doctest/doctest.h>
#include <string>
#include <tilemesh/machine/name.hpp>

namespace plain {
struct Region {};
template <class T>
struct Of {
    struct Inner {};
    template <int N>
    struct Deep {};
};
enum class Colour { red };
template <Colour C>
struct Painted {};
struct Called {
    static constexpr char const* name = "waiting (side 0)";
};
template <class T>
struct CalledOf {
    static constexpr char const* name = sizeof(T) == 1 ? "small" : "large";
};
} // namespace plain

namespace {
struct Hidden {};
template <class X>
std::string name()
{
    auto const n = tilemesh::name_of<X>();
    return {n.text, n.size};
}
} // namespace

static_assert(tilemesh::name_of<plain::Region>().size == 6);
static_assert(tilemesh::name_of<plain::Called>().size == 16);

TEST_CASE("a type is called by the last part of its name, without namespaces and template arguments")
{
    CHECK(name<plain::Region>() == "Region");
    CHECK(name<Hidden>() == "Hidden");
    CHECK(name<plain::Of<int>>() == "Of");
    CHECK(name<plain::Of<plain::Of<plain::Region>>>() == "Of");
    CHECK(name<plain::Of<plain::Region>::Inner>() == "Inner");
    CHECK(name<plain::Of<plain::Of<int>>::Deep<3>>() == "Deep");
    CHECK(name<plain::Painted<plain::Colour::red>>() == "Painted");
    struct Local {};
    CHECK(name<Local>() == "Local");
    CHECK(name<float>() == "float");
}

TEST_CASE("a type's own name wins")
{
    CHECK(name<plain::Called>() == "waiting (side 0)");
    CHECK(name<plain::CalledOf<char>>() == "small");
    CHECK(name<plain::CalledOf<int>>() == "large");
}

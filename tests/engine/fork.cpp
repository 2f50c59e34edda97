// test: unoptimised test asan, without tsan
// A child of fork has none of its parent's threads: a mesh starts new ones there, and its destructor joins none that are not there.
#include "everywhere.hpp"
#include "programs.hpp"
#include <memory>
#include <sys/wait.h>
#include <tilemesh/engine/team.hpp>
#include <unistd.h>

using namespace engine_test;

namespace {

/// Does this return true in a child? A child that hangs is killed after 60 seconds.
template <class F>
bool holds_in_child(F const& f)
{
    auto const child = ::fork();
    if (child == 0) {
        ::alarm(60);
        ::_exit(f() ? 0 : 1);
    }
    int status = -1;
    return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

} // namespace

TEST_CASE("a team in a child has as many threads as before, there and in a child of the child")
{
    for (std::uint32_t const threads : {1u, 2u, 5u}) {
        CAPTURE(threads);
        auto team = std::make_unique<engine::detail::Team>(threads);
        auto const all_come = [&] {
            std::vector<int> count(threads, 0);
            for (int i = 0; i < 3; ++i) team->each([&](std::uint32_t w) noexcept { ++count[w]; });
            return team->size() == threads && count == std::vector<int>(threads, 3);
        };
        CHECK(all_come());
        CHECK(holds_in_child([&] { return team.reset(), true; })); // without a call
        CHECK(holds_in_child([&] {
            bool const holds = all_come() && holds_in_child([&] { return all_come() && (team.reset(), true); });
            team.reset();
            return holds;
        }));
        CHECK(all_come()); // the parent has its own as before
    }
}

TEST_CASE("a mesh that ran goes on in a child, and has the same counts")
{
    Mesh<Post, Bench> mesh{{}, Grid{6, 5}, {.threads = 3, .digest = true}};
    mesh.run();
    CHECK(holds_in_child([&] {
        Mesh<Post, Bench> fresh{{}, Grid{6, 5}, {.threads = 3, .digest = true}};
        fresh.run();
        return mesh.run().digests == fresh.run().digests;
    }));
    CHECK_FALSE(mesh.run().digests.empty());
}

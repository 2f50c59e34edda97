// test: unoptimised test asan tsan
#include <atomic>
#include "../standard.hpp"
#include <thread>
#include <tilemesh/joined_threads.hpp>

using namespace tilemesh;

TEST_SUITE_BEGIN("joined_threads");

namespace {

TEST_CASE("threads have ended when their owner is gone, also where an exception ends its scope")
{
    constexpr int most = 4;
    std::atomic<int> ended{0};
    auto const start_some = [&](bool fail) {
        std::atomic<bool> go{false};
        JoinedThreads threads;
        auto const work = [&](int n) {
            while (!go) std::this_thread::yield();
            ended += n;
        };
        for (int i = 0; i < most; ++i) threads.start(work, 1);
        CHECK(threads.size() == most);
        CHECK(ended % most == 0); // they wait
        go = true;
        if (fail) throw std::runtime_error("planned");
    };
    start_some(false);
    CHECK(ended == most);
    CHECK_THROWS_AS(start_some(true), std::runtime_error);
    CHECK(ended == 2 * most);
}

TEST_CASE("after join() there are none, and more can be started")
{
    std::atomic<int> ended{0};
    JoinedThreads threads;
    threads.join();
    threads.start([&] { ++ended; });
    threads.join();
    CHECK(ended == 1);
    CHECK(threads.size() == 0);
    threads.start([&] { ++ended; });
    threads.join();
    CHECK(ended == 2);
}

} // namespace

TEST_SUITE_END();

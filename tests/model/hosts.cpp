// Predicted frames over hosts: known answers, limits, and the supersteps of a trace.
#include "../engine/everywhere.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/hosts.hpp>

using namespace tilemesh;
using engine_test::error_of;

namespace {

HostNetwork const perfect{"perfect", 0, 0, INFINITY, "a limit"};
HostNetwork const slow{"slow", 10, 2, 4, "by hand"};

/// Bands of equal height for a height that the number of hosts divides.
std::vector<std::uint32_t> bands(std::uint32_t height, std::uint32_t hosts)
{
    std::vector<std::uint32_t> first;
    for (std::uint32_t h = 0; h <= hosts; ++h) first.push_back(height / hosts * h);
    return first;
}
HostPrediction predict(HostNetwork const& net, std::vector<HostSuperstep> const& steps, std::vector<std::uint32_t> const& first_row, double bytes = 8)
{
    return predict_hosts(net, steps, first_row, bytes);
}
HostSuperstep even(std::uint32_t height, double us, double bytes)
{
    std::vector<double> const sent(height, bytes);
    return {3, std::vector<double>(height, us), sent, sent};
}

} // namespace

TEST_CASE("hosts: three hosts by hand, with and without messages")
{
    // Rows of 5, 40 | 10 | 20, 1 us. Every message has 8 bytes: 2 us at 4 bytes/us.
    std::vector<std::uint32_t> const first{0, 2, 3, 5};
    HostSuperstep quiet{1, {5, 40, 10, 20, 1}, {}, {}};
    // Agreement: two rounds of 10 + 8 / 4 us, after the slowest host's 45 us.
    auto const without = predict(slow, {quiet}, first);
    CHECK(without.frame_us == doctest::Approx(45 + 24));
    CHECK(without.slowest_us == 45);
    CHECK(without.efficiency == doctest::Approx(76.0 / (3 * 69)));
    CHECK(without.messages == 0);

    auto busy = quiet;
    busy.north_bytes = busy.south_bytes = {8, 8, 8, 8, 8};
    // Host 0 computes for 45 us and pays 2 us to send: the agreement ends at 47 + 24. Host 1 has everything at 45 + 10 + 2.
    auto const with = predict(slow, {busy}, first);
    CHECK(with.frame_us == doctest::Approx(71));
    CHECK(with.messages == 4);
    CHECK(with.bytes == 32);

    // A message of 400 bytes from host 0 to host 1 arrives at 45 + 10 + 100.
    busy.south_bytes[1] = 400;
    CHECK(predict(slow, {busy}, first).frame_us == doctest::Approx(155));
    busy.south_bytes[1] = 8;
    // The row that does not touch another band sends inside its host.
    busy.south_bytes[0] = busy.north_bytes[4] = 1e6;
    CHECK(predict(slow, {busy}, first).frame_us == doctest::Approx(71));
    // A superstep that occurs twice, and a network that needs no time but the overheads: 45, 2 to send and 2 to receive.
    busy.times = 2;
    CHECK(predict({"overhead", 0, 2, INFINITY, ""}, {busy}, first).frame_us == doctest::Approx(2 * 49));
}

TEST_CASE("hosts: interior rows hide a message")
{
    // Two hosts of three rows. Edges take 1 + 1 us, the interior 50: the message is there at 2 + 10 + 2, long before.
    HostSuperstep s{1, {1, 50, 1, 1, 50, 1}, {0, 0, 8, 8, 0, 0}, {0, 0, 8, 8, 0, 0}};
    CHECK(predict(slow, {s}, {0, 3, 6}, 0).frame_us == doctest::Approx(52 + 2 + 10));
    // If the edges are the whole band, it is not hidden.
    HostSuperstep edges{1, {26, 26, 26, 26}, {0, 200, 200, 0}, {0, 200, 200, 0}};
    CHECK(predict(slow, {edges}, {0, 2, 4}, 0).frame_us == doctest::Approx(52 + 10 + 50));
}

TEST_CASE("hosts: one host is compute alone; a perfect network has efficiency 1")
{
    std::vector<HostSuperstep> const frame{even(64, 7, 500), even(64, 2, 0)};
    double const alone = 3 * 64 * (7 + 2);
    CHECK(predict(slow, frame, {0, 64}).frame_us == doctest::Approx(alone));
    CHECK(predict(slow, frame, {0, 64}).efficiency == doctest::Approx(1));
    CHECK(predict(slow, frame, {0, 64}).messages == 0);
    for (std::uint32_t hosts : {1u, 2u, 4u, 64u}) {
        CHECK(predict(perfect, frame, bands(64, hosts)).frame_us == doctest::Approx(alone / hosts));
        CHECK(predict(perfect, frame, bands(64, hosts)).efficiency == doctest::Approx(1));
    }
    CHECK(predict(slow, {}, bands(64, 4)).efficiency == 1);
}

TEST_CASE("hosts: efficiency falls with hosts, and no frame is shorter than its slowest bands")
{
    for (auto const& net : {slow, HostNetwork{"fast", 0.6, 0.3, 25'000, ""}}) {
        double before = 1;
        for (std::uint32_t hosts : {2u, 4u, 8u, 16u, 32u, 64u}) {
            CAPTURE(hosts);
            auto const p = predict(net, {even(64, 7, 500)}, bands(64, hosts));
            CHECK(p.efficiency < before);
            CHECK(p.frame_us > p.slowest_us);
            CHECK(p.slowest_us == doctest::Approx(3 * 64 * 7.0 / hosts));
            before = p.efficiency;
        }
    }
    // Hosts without rows have no neighbours, and take part in the agreement. Uneven rows: the slowest band of each superstep counts.
    std::vector<HostSuperstep> const uneven{{1, {9, 1}, {}, {}}, {1, {1, 9}, {}, {}}};
    auto const p = predict(slow, uneven, {0, 0, 1, 2, 2}, 0);
    CHECK(p.slowest_us == 18);
    CHECK(p.frame_us == doctest::Approx(18 + 2 * 2 * 10));
    CHECK(p.efficiency == doctest::Approx(20.0 / (4 * 58)));
    CHECK(predict(slow, {even(2, 1, 8)}, {0, 0, 1, 2, 2}).messages == 3 * 2);
}

TEST_CASE("hosts: the supersteps of a trace share measured times like modelled cycles")
{
    // A grid of one column: the by-hand trace has its tiles in a row, here they are one below the other.
    auto trace = engine_test::two_supersteps::by_hand();
    Grid const column{1, 3};
    trace.supersteps[0].tiles[0].sent_bytes[index(Direction::south)] = 30;
    trace.supersteps[0].tiles[1].sent_bytes[index(Direction::north)] = 40;
    trace.supersteps[0].tiles[0].sent_bytes[index(Direction::north)] = 50; // over the grid's edge
    std::vector<double> const step_us{116, 46};
    auto const s = host_supersteps(trace, column, engine_test::model(), step_us);
    REQUIRE(s.size() == 2);
    CHECK(s[0].row_us == std::vector<double>{34, 62, 20}); // 17, 31 and 10 of 58 cycles
    CHECK(s[1].row_us == std::vector<double>{0, 22, 24});  // 11 and 12 of 23
    CHECK(s[0].south_bytes == std::vector<double>{42, 0, 0});
    CHECK(s[0].north_bytes == std::vector<double>{0, 52, 0});
    CHECK(s[1].north_bytes.empty());
    CHECK(predict(slow, s, {0, 3}).frame_us == doctest::Approx(162));
    CHECK(error_of([&] { host_supersteps(trace, column, engine_test::model(), std::vector<double>{1}); }) ==
          "1 host times (the trace has 2 steps); give one for each step");
}

TEST_CASE("hosts: a grid three times as wide and as high")
{
    std::vector<HostSuperstep> const small{{2, {1, 4}, {8, 16}, {0, 2}}, {1, {5, 6}, {}, {}}};
    auto const large = enlarged(small, 3, {true, false});
    CHECK(large[0].times == 6);
    CHECK(large[1].times == 1);
    CHECK(large[0].row_us == std::vector<double>{3, 3, 3, 12, 12, 12});
    CHECK(large[0].north_bytes == std::vector<double>{24, 24, 24, 48, 48, 48});
    CHECK(large[0].south_bytes == std::vector<double>{0, 0, 0, 6, 6, 6});
    CHECK(large[1].north_bytes.empty());
    // Nine times the tiles: the time of a step that stays where it is grows by nine, that of one that travels by 27.
    CHECK(predict(perfect, large, {0, 6}).frame_us == doctest::Approx(27 * 10 + 9 * 11));
    CHECK(error_of([&] { enlarged(small, 0, {true, false}); }).find("a grid cannot be enlarged (") == 0);
}

TEST_CASE("hosts: figures and lists that cannot be are refused")
{
    std::vector<HostSuperstep> const one{even(4, 1, 0)};
    for (auto const& bad : {HostNetwork{"bad", -1, 0, 1, ""}, HostNetwork{"bad", 1, 0, 0, ""}, HostNetwork{"bad", NAN, 0, 1, ""}})
        CHECK(error_of([&] { predict(bad, one, {0, 4}); }).starts_with("network \"bad\" (a negative time"));
    for (auto const& first : {std::vector<std::uint32_t>{}, {0}, {1, 4}, {0, 3, 2, 4}})
        CHECK(error_of([&] { predict(slow, one, first); }).find("; give bands of rows") != std::string::npos);
    CHECK(error_of([&] { predict(slow, one, {0, 5}); }).find("a superstep of 4 rows (") == 0);
    auto half = one;
    half[0].south_bytes.clear();
    CHECK(error_of([&] { predict(slow, half, {0, 4}); }).find("a superstep of 4 rows (") == 0);
}

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The sums of the tiles' counters in a run: of every word of `Counts`, and of every member of `Work`, which has a word for each worker.
/// All members are words of 8 bytes, which processes add up.
template <class Counts, class Work>
class TileSums {
    static constexpr std::size_t words = sizeof(Counts) / 4, members = sizeof(Work) / 4 / Work::max_workers;
    using Words = std::array<std::uint32_t, words>;
    using WorkersWords = std::array<std::uint32_t, members * Work::max_workers>;

public:
    void add(Counts const& c, Work const& w) noexcept
    {
        // Every frame adds the words of all tiles: without loops, GCC takes half the instructions.
        add_each(__builtin_bit_cast(Words, c), std::make_index_sequence<words>{});
        add_workers(__builtin_bit_cast(WorkersWords, w),
                    std::make_index_sequence<members * Work::max_workers>{});
    }
    std::uint64_t& operator[](std::uint32_t Counts::*word) noexcept { return words_[numbered<Counts, words>.*word]; }
    std::uint64_t operator[](std::uint32_t Counts::*word) const noexcept { return words_[numbered<Counts, words>.*word]; }

    /// Adds every number of the report that the program's kernels count.
    void add_to(report::FrameReport& r) const
    {
        for (auto const& field : report::report_fields) {
            auto const& from = field.counted_in(Counts{});
            if (from.word != nullptr) field.add(r, from.unit * (*this)[from.word]);
            if (from.of_workers != nullptr)
                field.add(r, from.unit * of_workers_[(numbered<Work, members * Work::max_workers>.*from.of_workers)[0] / Work::max_workers]);
        }
    }

private:
    template <std::size_t... I>
    void add_each(std::array<std::uint32_t, words> const& counts, std::index_sequence<I...>) noexcept
    {
        ((words_[I] += counts[I]), ...);
    }
    template <std::size_t... I>
    void add_workers(std::array<std::uint32_t, sizeof...(I)> const& pairs, std::index_sequence<I...>) noexcept
    {
        ((of_workers_[I / Work::max_workers] += pairs[I]), ...);
    }

    /// A state whose words are their numbers.
    template <class State, std::size_t N>
    static constexpr State numbered = [] {
        std::array<std::uint32_t, N> numbers{};
        for (std::size_t i = 0; i < N; ++i) numbers[i] = static_cast<std::uint32_t>(i);
        return __builtin_bit_cast(State, numbers);
    }();

    std::uint64_t words_[words]{}, of_workers_[members]{};
};

/// Adds the messages, bytes and digests of a run.
inline void add_traffic(RunCounters const& run, report::FrameReport& r)
{
    r.messages += run.messages();
    for (auto const& s : run.steps) {
        r.exchanged_live_bytes += s.live_bytes;
        r.exchanged_capacity_bytes += s.capacity_bytes;
    }
    r.digests.insert(r.digests.end(), run.digests.begin(), run.digests.end());
}

}}} // namespace tilemesh::render

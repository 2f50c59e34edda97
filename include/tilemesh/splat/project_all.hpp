#pragma once
#include <cstdint>
#include <cstring>
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/instruction_sets.hpp>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// Four words of each of N records. By columns, `a` holds word 0 of all records, `b` word 1, and so on. By rows, lanes 4 k to 4 k + 3 of
/// `a`, `b`, `c`, `d` hold the words of records 4 k, 4 k + 1, 4 k + 2, 4 k + 3. Four members, not an array: GCC would keep an array in
/// memory.
template <std::uint32_t N>
struct FourWords {
    Floats<N> a, b, c, d;
};
/// Turns columns into rows, and rows into columns.
template <std::uint32_t N, int... I>
TILEMESH_KERNEL void turn(FourWords<N>& v, std::integer_sequence<int, I...>) noexcept
{
    constexpr int n = static_cast<int>(N); // lane I of `a`; lane I of `b` has the number n + I
    Floats<N> const ab_low = __builtin_shufflevector(v.a, v.b, (I / 4 * 4 + I % 4 / 2 + I % 2 * n)...);
    Floats<N> const ab_high = __builtin_shufflevector(v.a, v.b, (I / 4 * 4 + 2 + I % 4 / 2 + I % 2 * n)...);
    Floats<N> const cd_low = __builtin_shufflevector(v.c, v.d, (I / 4 * 4 + I % 4 / 2 + I % 2 * n)...);
    Floats<N> const cd_high = __builtin_shufflevector(v.c, v.d, (I / 4 * 4 + 2 + I % 4 / 2 + I % 2 * n)...);
    v.a = __builtin_shufflevector(ab_low, cd_low, (I / 4 * 4 + I % 2 + I % 4 / 2 * n)...);
    v.b = __builtin_shufflevector(ab_low, cd_low, (I / 4 * 4 + 2 + I % 2 + I % 4 / 2 * n)...);
    v.c = __builtin_shufflevector(ab_high, cd_high, (I / 4 * 4 + I % 2 + I % 4 / 2 * n)...);
    v.d = __builtin_shufflevector(ab_high, cd_high, (I / 4 * 4 + 2 + I % 2 + I % 4 / 2 * n)...);
}
/// Loads lanes 4 k to 4 k + 3 from address p + 4 k stride, for all k. `stride` is in bytes.
template <std::uint32_t N>
TILEMESH_KERNEL void load_pieces(unsigned char const* p, std::uint32_t stride, Floats<N>& v) noexcept
{
    if constexpr (N == 4) {
        std::memcpy(&v, p, sizeof v);
    } else {
        Floats<N / 2> low, high;
        load_pieces<N / 2>(p, stride, low);
        load_pieces<N / 2>(p + N / 2 * stride, stride, high);
        join(low, high, v);
    }
}
template <std::uint32_t N>
TILEMESH_KERNEL void store_pieces(unsigned char* p, std::uint32_t stride, Floats<N> const& v) noexcept
{
    if constexpr (N == 4) {
        std::memcpy(p, &v, sizeof v);
    } else {
        Floats<N / 2> low, high;
        split(v, low, high);
        store_pieces<N / 2>(p, stride, low);
        store_pieces<N / 2>(p + N / 2 * stride, stride, high);
    }
}
/// Loads four words at `p` and at the same place of the next N - 1 records, by columns. `stride`: bytes of a record.
template <std::uint32_t N>
TILEMESH_KERNEL FourWords<N> load_columns(unsigned char const* p, std::uint32_t stride) noexcept
{
    FourWords<N> v;
    load_pieces<N>(p, stride, v.a);
    load_pieces<N>(p + stride, stride, v.b);
    load_pieces<N>(p + 2 * stride, stride, v.c);
    load_pieces<N>(p + 3 * stride, stride, v.d);
    turn<N>(v, Range<0, static_cast<int>(N)>{});
    return v;
}
/// Stores four words of N records, the reverse of load_columns. It stores zeros where `kept` is not set.
template <std::uint32_t N>
TILEMESH_KERNEL void store_columns(unsigned char* p, std::uint32_t stride, FourWords<N> const& words,
                                   Words<N> const& kept) noexcept
{
    FourWords<N> v{floats_of<N>(bits_of<N>(words.a) & kept), floats_of<N>(bits_of<N>(words.b) & kept),
                   floats_of<N>(bits_of<N>(words.c) & kept), floats_of<N>(bits_of<N>(words.d) & kept)};
    turn<N>(v, Range<0, static_cast<int>(N)>{});
    store_pieces<N>(p, stride, v.a);
    store_pieces<N>(p + stride, stride, v.b);
    store_pieces<N>(p + 2 * stride, stride, v.c);
    store_pieces<N>(p + 3 * stride, stride, v.d);
}

/// Projects as many records at once as the set has lanes; all must exist. Returns the stiff ones as bits: their splats have no meaning.
struct ProjectLanes {
    template <class Set, class Record>
    TILEMESH_KERNEL static std::uint32_t run(Record const* records, View const& view, Tiling const& tiling, Splat* out) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        using Real = typename A::Real;
        static_assert(sizeof(Gaussian) == 15 * 4 && sizeof(Splat) == 14 * 4, "the words below are all words");

        // Load records into lanes. The last group of four words begins one word early, so that it does not read beyond the record.
        auto const* const from = reinterpret_cast<unsigned char const*>(records);
        auto const w0 = load_columns<N>(from, sizeof(Record)), w4 = load_columns<N>(from + 4 * 4, sizeof(Record));
        auto const w8 = load_columns<N>(from + 4 * 8, sizeof(Record)), w11 = load_columns<N>(from + 4 * 11, sizeof(Record));
        GaussianWords<A> const g{{w0.a, w0.b, w0.c}, {w0.d, w4.a, w4.b}, w4.c, {w4.d, w8.a, w8.b, w8.c}, {w11.a, w11.b, w11.c}};
        SplatWords<A> s;
        auto const [visible, stiff] = project_words<A>(g, view, tiling, s);

        // Store lanes as splats; the last groups overlap by two words. An invisible splat is all zeros.
        auto* const to = reinterpret_cast<unsigned char*>(out);
        Real const depth_key = A::floats(s.depth_key), columns = A::floats(s.columns), rows = A::floats(s.rows), anchor = A::floats(s.anchor);
        store_columns<N>(to, sizeof(Splat), {s.mean_px[0], s.mean_px[1], s.along, s.slope}, visible);
        store_columns<N>(to + 4 * 4, sizeof(Splat), {s.across, s.opacity, g.colour[0], g.colour[1]}, visible);
        store_columns<N>(to + 4 * 8, sizeof(Splat), {g.colour[2], depth_key, s.faintest, columns}, visible);
        store_columns<N>(to + 4 * 10, sizeof(Splat), {s.faintest, columns, rows, anchor}, visible);
        std::uint32_t bits = 0;
        if (A::any(stiff)) {
            for (std::uint32_t i = 0; i < N; ++i) bits |= (stiff[i] != 0 ? 1u : 0u) << i;
        }
        return bits;
    }
};

/// Projects as many records at once as the set has lanes. All must exist.
template <class Set, class Record>
void project_group(Set const& set, Record const* records, View const& view, Tiling const& tiling, Splat* out) noexcept
{
    // One by one: stiff records, which lanes cannot compute, and the colours that depend on the direction.
    auto const stiff = set.template call<ProjectLanes>(records, view, tiling, out);
    for (std::uint32_t i = 0; stiff >> i != 0; ++i)
        if ((stiff >> i & 1u) != 0) out[i] = project(static_cast<Gaussian const&>(records[i]), view, tiling);
    if constexpr (Record::sh_degree > 0) {
        for (std::uint32_t i = 0; i < set.lanes(); ++i)
            if (out[i].visible() && !shade(records[i], view, out[i])) out[i] = {};
    }
}
} // namespace detail

/// Projects n records: `out[i]` is `project(records[i], view, tiling)`, bit for bit, for any `Lanes`. It projects 16, 8 or 4 records at
/// once, as many as the target's vectors hold; on a target with two lanes or one, it projects one at a time. `out` must not overlap
/// `records`.
///
/// Cost: about 110 instructions a record with AVX2 (one by one 670), 270 with SSE2 (one by one 870). A stiff record costs an additional
/// `project`; it has a quaternion whose square is not between 1e-30 and 1e30, or an axis longer than 1e9 pixels. If n is not a multiple of
/// `Lanes`, the cost is that of the next multiple. Harmonics are added one by one, for visible records only.
template <std::uint32_t Lanes = detail::lanes_in_use, class Record>
void project_all(Record const* records, std::uint32_t n, View const& view, Tiling const& tiling, Splat* out) noexcept
{
    using Set = detail::SetOf<Lanes>;
    if constexpr (Set::most_lanes >= 4) {
        Set const set{};
        std::uint32_t const lanes = set.lanes();
        if (n == 0) return;
        if (n < lanes) { // fill the lanes with the last record
            Record some[Set::most_lanes];
            Splat splats[Set::most_lanes];
            for (std::uint32_t i = 0; i < lanes; ++i) some[i] = records[i < n ? i : n - 1];
            detail::project_group(set, some, view, tiling, splats);
            std::memcpy(static_cast<void*>(out), splats, n * sizeof(Splat));
            return;
        }
        for (std::uint32_t i = 0; i < n; i += lanes) { // the last step takes the last `lanes` records, some of them a second time
            std::uint32_t const first = i < n - lanes ? i : n - lanes;
            detail::project_group(set, records + first, view, tiling, out + first);
        }
    } else {
        for (std::uint32_t i = 0; i < n; ++i) out[i] = project(records[i], view, tiling);
    }
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END

#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <mpi.h>
#include <numeric>
#include <span>
#include <string>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/mpi/bands.hpp>
#include <tilemesh/mpi/detail/ranks.hpp>
#include <typeinfo>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mpi::detail {

/// Mixes the numbers of a program value into a digest: how often its steps and loops may run.
struct ProgramDigest {
    std::uint64_t words = 0;
    template <class Step>
    void step(Step const& step, std::uint32_t)
    {
        words = engine::mix(words, StepTraits<Step>::most(step));
    }
    template <class Part, class Body>
    void loop(Part const& part, LoopAt, Body const& body)
    {
        words = engine::mix(words, part.at_most);
        body();
    }
    template <class Part, class Body>
    void condition(Part const&, Body const& body)
    {
        body();
    }
};

/// One rank's part of a mesh: a Mesh of the whole grid, of which it runs the tiles of its rows. Memory follows written words, so the other
/// rows cost 20 to 52 bytes a tile: tables of places for each kind of edge. Tiles, slots and samples have the numbers of the whole grid.
///
/// A tile of the first or last row writes what it sends over the band's edge where a Mesh would write it: into the row beyond. From there
/// it is packed, and cleared. The neighbour puts it at the same place of its own memory.
template <class Program, class Machine>
class BandMesh : public Mesh<Program, Machine> {
    using Base = Mesh<Program, Machine>;
    using KernelFacts = engine::KernelFacts;

public:
    using typename Base::Links;
    using typename Base::States;
    using typename Base::Sizes;

    BandMesh(Ranks const& ranks, Bands bands, Program program, Grid grid, Sizes const& sizes, MeshOptions const& options)
        : Base(program, grid, sizes, options), ranks_(ranks), bands_(std::move(bands)), first_row_(bands_.first(ranks.rank())),
          last_row_(bands_.last(ranks.rank())), everything_(std::size_t{last_row_ - first_row_} * grid.width)
    {
        std::iota(everything_.begin(), everything_.end(), first_tile());
        if (first_row_ == last_row_) return;
        bool const north_end = first_row_ == 0, south_end = last_row_ == grid.height;
        auto const north = bands_.rank_of(north_end ? grid.height - 1 : first_row_ - 1), south = bands_.rank_of(south_end ? 0 : last_row_);
        sides_[0] = {Direction::north, north, north != ranks.rank(), north_end, (first_row_ + grid.height - 1) % grid.height, {}, {}, {}};
        sides_[1] = {Direction::south, south, south != ranks.rank(), south_end, last_row_ % grid.height, {}, {}, {}};
    }

    Bands const& bands() const noexcept { return bands_; }
    std::uint32_t first_tile() const noexcept { return first_row_ * this->grid_.width; }
    std::uint32_t last_tile() const noexcept { return last_row_ * this->grid_.width; }

    /// Everything that must be the same on all ranks for a mesh of one program, but for the values that may change between runs.
    static std::uint64_t digest_of_program(Grid grid, Sizes const& sizes, MeshOptions const& options)
    {
        auto h = text_digest(0, typeid(Program).name());
        h = text_digest(h, sizes.machine.name);
        for (std::uint64_t word : {grid.width, grid.height, sizes.machine.tiles, sizes.machine.sram_bytes, sizes.machine.code_bytes,
                                   sizes.machine.workers, sizes.machine.clock_khz, options.most_passes, options.digest ? 1u : 0u,
                                   Base::traced ? 1u : 0u})
            h = engine::mix(h, word);
        for (auto slots : sizes.slots) h = engine::mix(h, slots);
        for (auto const& link : sizes.links) h = engine::mix(engine::mix(h, link.slots), link.message_bytes);
        for (bool shared : sizes.shares_memory) h = engine::mix(h, shared ? 1 : 0);
        return engine::mix(h, sizes.sram_bytes);
    }
    /// The values that may change between runs and must be the same on all ranks.
    std::uint64_t digest_of_run()
    {
        ProgramDigest digest;
        walk(this->program_, digest);
        auto h = digest.words;
        for (auto capacity : this->capacity_) h = engine::mix(h, capacity);
        for (auto capacity : this->link_capacity_) h = engine::mix(h, capacity);
        auto const& r = this->rectangle_;
        for (auto edge : {r.x0, r.y0, r.x1, r.y1}) h = engine::mix(h, edge);
        return h;
    }
    /// Makes what a run needs on this rank.
    void prepare()
    {
        this->view().require_capacities();
        this->run_.template begin<Base::traced>(this->program_, this->shareds());
        this->begin_run();
        for (auto& side : sides_)
            if (side.remote) {
                auto const words = most_words(side);
                if (words > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
                    throw Error("a message of up to " + std::to_string(words) + " words from a rank to its neighbour (MPI counts to " +
                                std::to_string(std::numeric_limits<int>::max()) + "); give channels fewer slots");
                if (side.in.words() >= words) continue;
                side.in = engine::Arena(words);
                side.out = engine::Arena(words);
            }
    }
    /// Every rank gets the broadcasts of rank 0.
    void share_broadcasts() { share_broadcasts(typename Base::Shareds{}); }

    RunCounters run_program()
    {
        busy_ = false;
        auto limits = this->limits();
        limits.explain = Base::traced ? explain_elsewhere : nullptr;
        return this->run_.go_on({this, [](void* band) { return static_cast<BandMesh*>(band)->superstep(); },
                                 [](void* band) { return static_cast<BandMesh*>(band)->busy_; },
                                 [](void* band) { return static_cast<BandMesh*>(band)->digest_now(); },
                                 [](void* band) { return static_cast<BandMesh*>(band)->peaks_of_all(); }},
                                this->view(), limits);
    }
    std::vector<engine::Peak> peaks_of_all()
    {
        std::vector<engine::Peak> peaks;
        std::vector<std::uint64_t> items;
        ranks_.together([&] {
            peaks = engine::MeshCore::peaks(this->view());
            for (auto const& p : peaks) items.push_back(p.items);
        });
        ranks_.most(items.data(), items.size());
        for (std::size_t i = 0; i < peaks.size(); ++i) peaks[i].items = static_cast<std::uint32_t>(items[i]);
        return peaks;
    }
    /// An observer for every rank if some rank has one: `mine` may be empty. Its exception on one rank is an Error on all.
    void observe_together(Observer const* mine)
    {
        this->run_.observer = [this, mine](SuperstepEvent const& event) {
            Mistake mistake;
            if (*mine) mistake.watch([&] { (*mine)(event); });
            ranks_.agree(mistake, [this] { return this_superstep(); });
        };
    }
    void require_idle() const { this->run_.require_idle(); }
    void observe_nothing() { this->run_.observer = nullptr; }

    /// Copies the states X of all tiles to rank 0.
    template <class X>
    void gather()
    {
        std::uint64_t const most = std::uint64_t{this->grid_.width} * this->template words<X>();
        engine::Arena row;
        ranks_.together([&] {
            if (most > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
                throw Error("a row of " + std::to_string(most) + " words (MPI counts to " + std::to_string(std::numeric_limits<int>::max()) +
                            "); gather a state with fewer slots");
            row = engine::Arena(most);
        });
        if (ranks_.rank() != 0) {
            for (auto y = first_row_; y < last_row_; ++y) {
                auto* to = row.data();
                for (std::uint32_t x = 0; x < this->grid_.width; ++x) to = copy_state<X, true>(y * this->grid_.width + x, to);
                MPI_Send(row.data(), static_cast<int>(to - row.data()), MPI_UINT32_T, 0, tag_of_states, ranks_.comm());
            }
            return;
        }
        for (auto y = last_row_; y < this->grid_.height; ++y) {
            MPI_Recv(row.data(), static_cast<int>(most), MPI_UINT32_T, static_cast<int>(bands_.rank_of(y)), tag_of_states, ranks_.comm(),
                     MPI_STATUS_IGNORE);
            auto* from = row.data();
            for (std::uint32_t x = 0; x < this->grid_.width; ++x) from = copy_state<X, false>(y * this->grid_.width + x, from);
        }
    }
    /// The trace of all tiles on rank 0, an empty one on the others, from each rank's trace of its own tiles.
    Trace gather_trace(Trace const& mine)
    {
        static_assert(Base::traced, "a mesh without a trace (its machine is not Traced); build it for Traced<Machine>");
        static_assert(sizeof(TileSample) % 4 == 0 && std::is_trivially_copyable_v<TileSample>);
        constexpr std::size_t words = sizeof(TileSample) / 4;
        Trace all;
        std::vector<std::uint64_t> tiles;
        ranks_.together([&] {
            for (auto const& s : mine.supersteps) tiles.push_back(s.tiles.size());
        });
        ranks_.sum(tiles.data(), tiles.size());
        ranks_.together([&] {
            if (ranks_.rank() != 0) return;
            all = mine;
            for (std::size_t i = 0; i < tiles.size(); ++i) all.supersteps[i].tiles.resize(tiles[i]);
        });
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            auto const& own = mine.supersteps[i].tiles;
            if (ranks_.rank() != 0) {
                if (first_row_ == last_row_) continue;
                MPI_Send(own.data(), static_cast<int>(own.size() * words), MPI_UINT32_T, 0, tag_of_trace, ranks_.comm());
                continue;
            }
            auto at = own.size(); // bands follow one another, and so do their tiles
            for (std::uint32_t r = 1; r < ranks_.size(); ++r) {
                if (bands_.first(r) == bands_.last(r)) continue;
                MPI_Status status;
                int n = 0;
                MPI_Recv(all.supersteps[i].tiles.data() + at, static_cast<int>((tiles[i] - at) * words), MPI_UINT32_T, static_cast<int>(r),
                         tag_of_trace, ranks_.comm(), &status);
                MPI_Get_count(&status, MPI_UINT32_T, &n);
                at += static_cast<std::size_t>(n) / words;
            }
        }
        return all;
    }

private:
    static constexpr int tag_northwards = 0, tag_southwards = 1, tag_of_states = 2, tag_of_trace = 3;

    /// The north or the south edge of the band.
    struct Side {
        Direction direction = Direction::north;
        std::uint32_t rank = 0;        ///< the rank on the other side
        bool remote = false;           ///< is that another rank?
        bool over_edge = false;        ///< is the band's edge the grid's? Then only channels that wrap reach the other side
        std::uint32_t beyond = 0;      ///< the first row on the other side
        engine::Arena out, in;
        MPI_Request requests[2] = {MPI_REQUEST_NULL, MPI_REQUEST_NULL}; ///< of the message that leaves, of the message that comes
    };
    /// What the ranks add up after a superstep.
    struct Sums {
        static constexpr std::size_t messages = 0, tile_runs = 1, live_bytes = 2, busy = 3, failures = 4, mistakes = 5, mail = 6;
        std::array<std::uint64_t, mail + Links::count + 1> words{};
        std::uint64_t& operator[](std::size_t i) noexcept { return words[i]; }
    };

    static std::string explain_elsewhere(Trace const&, Grid, std::uint32_t)
    {
        return "A rank has the trace of its own tiles; run the program on a Mesh, whose explain_no_progress names the steps that repeat";
    }
    static std::uint64_t text_digest(std::uint64_t h, char const* text) noexcept
    {
        for (; *text != '\0'; ++text) h = engine::mix(h, static_cast<unsigned char>(*text));
        return engine::mix(h, 0);
    }
    std::string this_superstep() const { return " [superstep " + std::to_string(this->run_.pass()) + " (" + this->run_.kernel() + ")]"; }
    template <class... P>
    void share_broadcasts(machine::Types<P...>)
    {
        (MPI_Bcast(&this->template broadcast<P>(), static_cast<int>(sizeof(P) / 4), MPI_UINT32_T, 0, ranks_.comm()), ...);
    }

    // --- messages -------------------------------------------------------------------------------------------------------
    /// Does a kernel send on this channel over this side to another rank?
    static bool crosses(Side const& side, engine::LinkUse const& use) noexcept
    {
        return use.writes && side.remote && (!side.over_edge || engine::link_table<Program>.at[use.link].edge == Edge::wrap);
    }
    static bool crosses_with_any(Side const& side, KernelFacts const& kernel) noexcept
    {
        for (auto const& use : kernel.links)
            if (crosses(side, use)) return true;
        return false;
    }
    /// The words of the largest message after any step.
    std::uint64_t most_words(Side const& side) const noexcept
    {
        std::uint64_t words = 1;
        for (auto const& step : engine::program_facts<Program>.steps) words = std::max(words, most_words_after(side, *step.kernel));
        return words;
    }
    std::uint64_t most_words_after(Side const& side, KernelFacts const& kernel) const noexcept
    {
        std::uint64_t words = 0;
        for (auto const& use : kernel.links)
            if (crosses(side, use))
                words += 1 +
                    this->grid_.width * (3 + std::uint64_t{this->link_capacity_[use.link]} * engine::link_table<Program>.at[use.link].item_words);
        return words;
    }
    /// Packs what these tiles sent over a side, channel by channel: the number of ends, and for each end its column, size, note, messages.
    std::uint32_t* pack(std::uint32_t link, Side const& side, std::span<std::uint32_t const> tiles, std::uint32_t* to) noexcept
    {
        auto* const ends = to++;
        *ends = 0;
        for (auto tile : tiles) {
            auto const end = this->sent(this->view(), link, tile, side.direction);
            if ((end.head[0] | end.head[1]) == 0) continue;
            ++*ends;
            *to++ = tile % this->grid_.width;
            *to++ = end.head[0];
            *to++ = end.head[1];
            auto const words = std::size_t{end.head[0]} * engine::link_table<Program>.at[link].item_words;
            std::memcpy(to, end.items, words * 4);
            to += words;
            end.head[0] = end.head[1] = 0;
        }
        return to;
    }
    std::uint32_t const* unpack(std::uint32_t link, Side const& side, std::uint32_t const* from) noexcept
    {
        for (auto ends = *from++; ends != 0; --ends) {
            auto const tile = side.beyond * this->grid_.width + from[0];
            this->deliver(this->view(), link, tile, opposite(side.direction), from + 1, from + 3);
            from += 3 + std::size_t{from[1]} * engine::link_table<Program>.at[link].item_words;
        }
        return from;
    }
    void send(Side& side, std::span<std::uint32_t const> tiles, KernelFacts const& kernel)
    {
        auto* to = side.out.data();
        for (auto const& use : kernel.links)
            if (crosses(side, use)) to = pack(use.link, side, tiles, to);
        MPI_Isend(side.out.data(), static_cast<int>(to - side.out.data()), MPI_UINT32_T, static_cast<int>(side.rank),
                  side.direction == Direction::north ? tag_northwards : tag_southwards, ranks_.comm(), &side.requests[0]);
    }
    void receive(Side& side)
    {
        MPI_Irecv(side.in.data(), static_cast<int>(side.in.words()), MPI_UINT32_T, static_cast<int>(side.rank),
                  side.direction == Direction::north ? tag_southwards : tag_northwards, ranks_.comm(), &side.requests[1]);
    }
    void take_in(Side& side, KernelFacts const& kernel)
    {
        MPI_Wait(&side.requests[1], MPI_STATUS_IGNORE);
        std::uint32_t const* from = side.in.data();
        for (auto const& use : kernel.links)
            if (crosses(side, use)) from = unpack(use.link, side, from);
    }

    // --- one superstep --------------------------------------------------------------------------------------------------
    std::uint64_t digest_now()
    {
        auto digest = this->digest_of(this->view(), first_tile(), last_tile());
        ranks_.sum(&digest, 1);
        return digest;
    }
    /// The tiles of this rank that run, in order.
    std::span<std::uint32_t const> tiles_to_run(KernelFacts const& kernel, bool everywhere)
    {
        auto const& r = this->rectangle_;
        if (everywhere && r.covers(this->grid_)) {
            this->forget_waking(kernel);
            return everything_;
        }
        this->list_waking(kernel);
        if (everywhere)
            for (auto y = std::max(r.y0, first_row_); y < std::min(r.y1, last_row_); ++y)
                this->active_.insert(y * this->grid_.width + r.x0, y * this->grid_.width + r.x1);
        auto const* const tiles = this->tiles_.data();
        auto const* const end = tiles + this->active_.list(this->tiles_.data());
        // Mail that went to another rank has marked its receiver in the row beyond.
        return {std::lower_bound(tiles, end, first_tile()), std::lower_bound(tiles, end, last_tile())};
    }
    engine::Passed superstep()
    {
        auto const& step = engine::program_facts<Program>.steps[this->run_.step()];
        auto const& kernel = *step.kernel;
        bool const everywhere = step.everywhere;
        auto const mail = [&](std::uint32_t link) { return mail_[link]; };
        if (!everywhere && !busy_ && !engine::mail_to_read(kernel, mail)) return {};
        if (engine::sends_over_unread(kernel, mail)) throw this->run_.failed(this->grid_, 0, engine::over_unread);
        auto const tiles = tiles_to_run(kernel, everywhere);
        std::uint32_t const most_alone = everywhere ? 1 : Base::most_tiles_of_one_thread;
        auto const run = [&](std::span<std::uint32_t const> some) {
            if (!some.empty()) this->run_on_team(this->steps(), this->run_.step(), some.data(), static_cast<std::uint32_t>(some.size()), most_alone);
        };

        // The rows at open edges first: their messages travel while the other rows run.
        bool const open[] = {crosses_with_any(sides_[0], kernel), crosses_with_any(sides_[1], kernel)};
        for (std::size_t s : {0u, 1u})
            if (open[s]) receive(sides_[s]);
        auto const at = [&](std::uint32_t row) {
            return static_cast<std::size_t>(std::lower_bound(tiles.begin(), tiles.end(), row * this->grid_.width) - tiles.begin());
        };
        std::size_t first = 0, last = tiles.size();
        if (open[0]) run(tiles.first(first = at(first_row_ + 1)));
        if (open[1]) {
            auto const row = at(last_row_ - 1);
            last = std::max(row, first); // a band of one row has run
            run(tiles.subspan(last));
            send(sides_[1], tiles.subspan(row), kernel);
        }
        if (open[0]) send(sides_[0], tiles.first(first), kernel);
        run(tiles.subspan(first, last - first));

        engine::Passed passed;
        typename Base::Failure failure;
        Mistake mistake;
        mistake.watch([&] {
            failure = this->collect(this->view(), this->run_, step, passed);
            if (this->options_.digest) this->run_.make_room_for_digest();
        });
        Sums sums;
        sums[Sums::messages] = passed.messages;
        sums[Sums::tile_runs] = passed.tile_runs;
        sums[Sums::live_bytes] = passed.live_bytes;
        sums[Sums::busy] = Base::any_busy() ? 1 : 0;
        sums[Sums::failures] = failure.count;
        sums[Sums::mistakes] = mistake.made ? 1 : 0;
        for (std::uint32_t l = 0; l < Links::count; ++l) sums[Sums::mail + l] = this->has_mail(l) ? 1 : 0;
        MPI_Request agreement;
        MPI_Iallreduce(MPI_IN_PLACE, sums.words.data(), static_cast<int>(sums.words.size()), MPI_UINT64_T, MPI_SUM, ranks_.comm(), &agreement);
        for (std::size_t s : {0u, 1u})
            if (open[s]) take_in(sides_[s], kernel);
        for (std::size_t s : {0u, 1u})
            if (open[s]) MPI_Wait(&sides_[s].requests[0], MPI_STATUS_IGNORE);
        MPI_Wait(&agreement, MPI_STATUS_IGNORE);
        this->flip(kernel);

        if (sums[Sums::mistakes] != 0) ranks_.agree(mistake, [this] { return this_superstep(); });
        if (sums[Sums::failures] != 0) {
            std::uint64_t tile = failure.tile;
            ranks_.least(&tile, 1);
            auto const broken = static_cast<std::uint32_t>(tile);
            auto const owner = bands_.rank_of(broken / this->grid_.width);
            auto const text = ranks_.text_of(owner, failure.text != nullptr ? failure.text : "");
            throw Error(this->run_.failed(this->grid_, broken, text, sums[Sums::failures]).what() + Ranks::of_rank(owner));
        }
        busy_ = sums[Sums::busy] != 0;
        for (std::size_t l = 0; l < mail_.size(); ++l) mail_[l] = sums[Sums::mail + l] != 0;
        passed.ran = true;
        passed.sent = engine::sent_anything(kernel, mail);
        passed.messages = sums[Sums::messages];
        passed.tile_runs = sums[Sums::tile_runs];
        passed.live_bytes = sums[Sums::live_bytes];
        if constexpr (Base::traced) this->run_.trace->supersteps.back().sent = passed.sent;
        return passed;
    }

    // --- states ---------------------------------------------------------------------------------------------------------
    /// Copies the live words of a tile's state X to (Out) or from a buffer. Returns the buffer's next word.
    template <class X, bool Out>
    std::uint32_t* copy_state(std::uint32_t tile, std::uint32_t* buffer) noexcept
    {
        auto const copy = [&](std::uint32_t* words, std::size_t n) {
            std::memcpy(Out ? buffer : words, Out ? words : buffer, n * 4);
            buffer += n;
        };
        auto const place = this->template state_place<X>(tile);
        if constexpr (is_list<X>) {
            copy(place.head, 2);
            copy(place.items, std::size_t{place.head[0]} * X::item_words);
        } else {
            copy(place.items, sizeof(X) / 4);
        }
        return buffer;
    }

    Ranks const& ranks_;
    Bands bands_;
    std::uint32_t first_row_, last_row_;               ///< this rank's rows are first_row_..last_row_-1
    std::vector<std::uint32_t> everything_;            ///< all tiles of this rank
    std::array<Side, 2> sides_;                        ///< north, south
    bool busy_ = false;                                ///< did a tile of any rank vote busy in the superstep before?
    std::array<bool, Links::count + 1> mail_{};        ///< has any rank unread mail on a channel?
};

}}} // namespace tilemesh::mpi::detail

#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/digest.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/render/ranks/gather.hpp>
#include <tilemesh/render/ranks/record_share.hpp>
#include <tilemesh/render/ranks/row_shares.hpp>
#include <tilemesh/render/ranks/row_weights.hpp>
#include <tilemesh/render/host.hpp>
#include <tilemesh/render/losses.hpp>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The host of a mesh over several processes. Every process has a renderer of the same map, setup and options, and calls the same functions
/// with the same cameras and rules; the engine (mpi/mpi_mesh.hpp) has one part of the tiles in each. Members that are not const are collective. Each
/// has its share of the map (RendererOptions::rows_of_all_parts), puts records on its own tiles, and sends a record that starts on a tile of another
/// process there. All return the same report; `host_ms` is their own. The first process gets the picture and makes the list of losses, the others get
/// an empty picture. What fails in one process is an Error in all of them.
///
/// Members are those of Host for one process. Cost: a frame gathers the picture, and adds up 12 words; a frame that lists losses collects a
/// splat of each record in the first process.
template <class MeshType, class Machine>
    requires over_ranks<MeshType>
class Host<MeshType, Machine> : public HostOfMesh<MeshType, Machine> {
    using Base = HostOfMesh<MeshType, Machine>;
    using Base::engine_, Base::mesh_, Base::observer_, Base::ordered_;
    using Group = typename MeshType::Group;

public:
    using typename Base::EngineOptions;
    using Records = RecordShare;
    static constexpr bool has_one_memory = false;

    using Base::Base, Base::traced;

    /// All processes have the same words and records, or `view_of` throws.
    void identify(Records const& records, RendererOptions const& options, std::initializer_list<std::uint32_t> words)
    {
        digest_ = options.rows_of_all_parts == 0 ? records.digest() : 0;
        for (auto const word : words) digest_ = engine::mix(digest_, word);
    }
    /// Throws Error in all processes if one refuses its camera or rules, or if they render different frames.
    template <class Check>
    splat::View view_of(splat::Camera const& camera, splat::Rules const& rules, Check const& check)
    {
        this->drop_halfway();
        splat::View view{};
        auto const agree = [&](auto& all) {
            all.together([&] {
                check_camera(camera);
                check_rules(rules);
                view = splat::make_view(camera, rules);
                check(view);
            });
            static_assert(sizeof view % 4 == 0 && alignof(splat::View) == 4);
            std::uint32_t words[sizeof view / 4];
            __builtin_memcpy(words, &view, sizeof view);
            require_same(all, engine::mix_words(digest_, words, sizeof view / 4));
        };
        if (mesh_) {
            agree(*mesh_);
        } else {
            Group group(engine_);
            agree(group);
        }
        return view;
    }

    /// `first`: the processes then have bands of equal work in this view. Without it, and for programs that spread their work, bands of equal
    /// height.
    template <class Plan>
    void build(RendererOptions const& options, Records& records, Plan const& plan, splat::View const* first = nullptr,
               splat::Tiling const& tiling = {})
    {
        Group group(engine_);
        require_same(group, digest_);
        std::optional<std::invoke_result_t<Plan const&>> p;
        EngineOptions engine;
        group.together([&] {
            set_engine_options<traced>(options, engine_);
            engine = engine_;
            p.emplace(plan());
        });
        if (first != nullptr && engine.row_weights.empty())
            engine.row_weights = weights_of_rows(group, records, !shared_ && options.rows_of_all_parts == 0, p->grid.height, *first, tiling);
        this->make_mesh(p->program, p->grid, p->sizes, engine);
        step([&] {
            if (observer_) mesh_->observe(observer_);
        });
        if (!shared_) records.share(*mesh_, options.rows_of_all_parts);
        shared_ = true;
    }
    template <class Record, class PlaceOf>
    void reorder(Records& records, PlaceOf const& place_of)
    {
        if (!ordered_) records.template deal<Record>(*mesh_, place_of);
        ordered_ = true;
    }

    /// Runs f, which does not communicate. An exception in one process is an Error in all of them.
    template <class F>
    void step(F const& f)
    {
        mesh_->together(f);
    }
    bool has(TileId t) const noexcept { return mesh_->owns(t); }
    template <class F>
    void each_tile(F const& f)
    {
        step([&] {
            for (TileId const tile : mesh_->grid().tiles())
                if (has(tile)) f(tile);
        });
    }
    /// The tiles of a process follow those of the process before, so it goes on where that one stopped.
    template <class F>
    std::uint64_t in_turn(std::uint64_t next, F const& f)
    {
        return mesh_->in_turn(next, f);
    }
    template <class Sums, class F>
    Sums total(F const& add)
    {
        static_assert(sizeof(Sums) % 8 == 0 && std::is_trivially_copyable_v<Sums>);
        Sums sums{};
        add(sums);
        std::uint64_t words[sizeof(Sums) / 8];
        __builtin_memcpy(words, &sums, sizeof sums);
        mesh_->sum(words, sizeof(Sums) / 8);
        __builtin_memcpy(&sums, words, sizeof sums);
        return sums;
    }
    template <std::size_t N>
    void most(std::uint64_t (&words)[N])
    {
        mesh_->most(words, N);
    }
    bool any(bool here)
    {
        std::uint64_t processes = here ? 1 : 0;
        mesh_->sum(&processes, 1);
        return processes != 0;
    }
    template <class T, class F>
    std::vector<T> list(F const& add)
    {
        std::vector<T> items;
        step([&] { add(items); });
        mesh_->join(items);
        mesh_->share(items);
        return items;
    }

    /// A slot first gets an empty record with its id, if that is known. Then the processes of the rows send the records.
    template <class Record>
    class Loading {
    public:
        template <class Make>
        Record record(Make const&, splat::GaussianId id) const
        {
            Record g{};
            g.id = id;
            return g;
        }
        void took(std::uint32_t row, TileId tile, std::uint32_t slot) { slots.push_back({row, tile, slot}); }

        struct Slot {
            std::uint32_t row;
            TileId tile;
            std::uint32_t slot;
        };
        std::vector<Slot> slots;
    };
    template <class Record, class Put>
    void finish(Loading<Record>& loading, Records const& records, Put const& put)
    {
        std::vector<std::uint32_t> wanted;
        step([&] {
            wanted.reserve(loading.slots.size());
            for (auto const& s : loading.slots) wanted.push_back(s.row);
        });
        auto const got = fetch_rows<Record>(*mesh_, records.shares(), std::move(wanted), [&](std::uint32_t row) {
            return records.template record<Record>(row - records.first_row());
        });
        for (std::size_t i = 0; i < got.size(); ++i) put(loading.slots[i].tile, loading.slots[i].slot, got[i]);
    }
    template <class Item, class SendAll, class Put>
    void to_tiles(SendAll const& send_all, Put const& put)
    {
        struct Sent {
            TileId tile;
            Item item;
        };
        std::vector<Sent> sent;
        std::vector<std::uint64_t> counts;
        auto const process_of = [&](Sent const& s) { return mesh_->bands().rank_of(s.tile.y()); };
        step([&] {
            counts.assign(mesh_->ranks(), 0);
            send_all([&](TileId tile, Item const& item) {
                sent.push_back({tile, item});
                ++counts[process_of(sent.back())];
            });
            std::stable_sort(sent.begin(), sent.end(), [&](Sent const& a, Sent const& b) { return process_of(a) < process_of(b); });
        });
        sent = mesh_->deal(std::move(sent), counts); // in the order of rows, because shares follow one another
        step([&] {
            for (auto const& s : sent) put(s.tile, s.item);
        });
    }
    template <class T, class Before>
    void everywhere(std::vector<T>& items, Before const& before)
    {
        mesh_->join(items);
        step([&] { std::sort(items.begin(), items.end(), before); });
        mesh_->share(items);
    }
    template <class Item, class FirstOf, class Make, class Fill>
    void deal(std::uint64_t n, FirstOf const& first_of, Make const& item, Fill const& fill)
    {
        auto const shares = RowShares::of_parts(*mesh_, n);
        std::vector<Item> items;
        std::vector<std::uint64_t> counts;
        step([&] {
            auto const& bands = mesh_->bands();
            auto const own = mesh_->rank(), width = mesh_->grid().width;
            for (std::uint32_t p = 0; p < mesh_->ranks(); ++p) {
                auto const first = std::max(shares.first(own), first_of(shares.rows(), bands.first(p) * width));
                auto const last = std::min(shares.last(own), first_of(shares.rows(), bands.last(p) * width));
                counts.push_back(last > first ? last - first : 0);
            }
            items.reserve(n);
            for (std::uint32_t i = 0; i < n; ++i) items.push_back(item(i));
        });
        items = mesh_->deal(std::move(items), counts);
        std::size_t at = 0;
        each_tile([&](TileId tile) { fill(tile, shares.rows(), [&] { return items[at++]; }); });
    }
    struct KeyRange {
        std::uint64_t from, to;
    };
    static constexpr std::uint64_t no_key = ~std::uint64_t{0}; ///< behind all keys
    /// Cost: 128 agreements of one word.
    KeyRange range_of(std::vector<std::uint64_t>& keys, std::uint64_t done, std::uint64_t n)
    {
        if (done == 0) std::sort(keys.begin(), keys.end());
        return {nth_of_all(keys, done), nth_of_all(keys, done + n)};
    }

    template <class P>
    NotOnTiles losses(LossQuestion const& question, Records const& records, report::FrameReport& report)
    {
        FactLists lists;
        step([&] { lists = fact_lists<P>(*this); });
        mesh_->join(lists.held);
        mesh_->join(lists.owned);
        mesh_->join(lists.under_way);
        mesh_->join(lists.copies_under_way);
        mesh_->join(lists.parked);
        std::vector<ScreenRows::Row> rows;
        step([&] {
            for (std::uint32_t row = 0; row < records.rows(); ++row)
                rows.push_back({records.id(row), project_row(records, row, question.view, question.tiling)});
        });
        mesh_->join(rows);
        NotOnTiles off;
        step([&] {
            if (is_first()) off = list_losses(question, ScreenRows(std::move(rows)), MeshFacts(std::move(lists)), report);
        });
        mesh_->share(report.lost);
        mesh_->share(off.missing);
        mesh_->share(off.missing_ids);
        mesh_->share(off.under_way);
        share_counts(*mesh_, report);
        return off;
    }
    template <class P>
    void picture(Setup const& setup, splat::Tiling const& tiling, splat::Camera const& camera, RenderedFrame& to)
    {
        gather_picture<P>(*mesh_, setup, tiling, camera, to);
    }
    template <class X, class F>
    void picture_of(RenderedFrame& to, F const& copy)
    {
        mesh_->template gather<X>();
        step([&] {
            if (is_first()) return copy();
            to.image = {};
            to.depth = to.alpha = {};
        });
    }

    void begin_frame()
    {
        this->begin_frame_in([&](auto const& f) { step(f); });
    }
    RunCounters run()
    {
        return this->run_in([&](auto const& f) { step(f); });
    }
    Trace gather_trace()
        requires(traced)
    {
        return mesh_->gather_trace(this->trace());
    }

private:
    bool is_first() const noexcept { return mesh_->rank() == 0; }
    template <class All>
    static void require_same(All& all, std::uint64_t digest)
    {
        if (!all.same(digest))
            throw Error("ranks with different frames (the map, the camera, the model or the options of a rank differ from those of another); "
                        "give the same to every rank");
    }
    /// The n-th of the keys of all processes, counted from 0; `no_key` if there are fewer. `keys`: those of this process, sorted. Cost: 64
    /// agreements of one word.
    std::uint64_t nth_of_all(std::vector<std::uint64_t> const& keys, std::uint64_t n)
    {
        std::uint64_t least_key = 0, most_key = no_key; // at most n keys are below least_key, and more than n are up to most_key
        while (least_key < most_key) {
            auto const middle = least_key + (most_key - least_key) / 2;
            auto upto = static_cast<std::uint64_t>(std::upper_bound(keys.begin(), keys.end(), middle) - keys.begin());
            mesh_->sum(&upto, 1);
            if (upto > n) most_key = middle;
            else least_key = middle + 1;
        }
        return least_key;
    }

    std::uint64_t digest_ = 0; ///< of what all processes have in common
    bool shared_ = false;      ///< this process has its share of the records
};

}}} // namespace tilemesh::render

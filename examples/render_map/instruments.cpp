#include "instruments.hpp"
#include <algorithm>
#include <utility>

namespace render_map {

char const* name_of(Seen what) noexcept
{
    constexpr char const* names[] = {"anchored", "copy", "leaving", "waiting", "road",
                                     "beam",     "owed", "refused", "dropped", "left"};
    return names[static_cast<std::uint32_t>(what)];
}
char const* name_of(tilemesh::Direction side) noexcept
{
    constexpr char const* names[] = {"north", "east", "west", "south"};
    return names[tilemesh::index(side)];
}

namespace {
bool is_stored(Follower::Fact const& f)
{
    return f.what == Seen::anchored || f.what == Seen::copy || f.what == Seen::leaving;
}
bool is_sent(Follower::Fact const& f)
{
    return f.what == Seen::road || f.what == Seen::beam;
}
} // namespace

void Follower::begin_frame()
{
    life_ = {};
    begins_ = true;
}

/// Finds records that were dropped in this superstep. Such a record was read or tried again in this superstep, is now neither on its tile
/// nor sent on, and its tile had no room for something. A copy of an older view does not count, because its tile may forget it.
void Follower::see_what_is_dropped(Step const& step, std::vector<Fact> const& facts)
{
    auto const look = [&](Fact const& f) {
        auto const goes_on = [&](Fact const& g) {
            if (g.tile == f.tile) return is_stored(g) || g.what == Seen::waiting;
            return is_sent(g) && step.grid.neighbour(g.tile, *g.side) == f.tile;
        };
        if (std::find(step.full.begin(), step.full.end(), f.tile) == step.full.end() ||
            std::any_of(facts.begin(), facts.end(), goes_on))
            return;
        life_.sightings.push_back({step.number, step.kernel, f.tile, Seen::dropped, f.side, true});
        ++life_.refusals;
        if (f.what == Seen::beam) ++life_.dropped_copies;
        else life_.dropped = f.tile;
    };
    std::vector<Fact> unread;
    for (auto const& f : under_way_)
        if (f.what == Seen::road ? step.routes : step.blooms) look(f);
        else unread.push_back(f);
    if (step.routes)
        for (auto const& f : before_)
            if (f.what == Seen::waiting) look(f);
    under_way_ = std::move(unread);
    for (auto const& f : facts)
        if (is_sent(f)) under_way_.push_back(f);
}

void Follower::superstep(Step const& step, std::vector<Fact> facts)
{
    see_what_is_dropped(step, facts);
    for (auto const& f : before_)
        if (is_stored(f) &&
            std::none_of(facts.begin(), facts.end(), [&](auto const& g) { return is_stored(g) && g.tile == f.tile; }))
            life_.sightings.push_back({step.number, step.kernel, f.tile, Seen::left, {}, false});
    life_.anchor.reset();
    life_.copies = 0;
    for (auto const& f : facts) {
        bool const is_new = std::none_of(before_.begin(), before_.end(), [&](auto const& g) {
            return g.tile == f.tile && g.what == f.what && g.side == f.side;
        });
        bool const refusal = f.refusal || (f.what == Seen::refused && is_new);
        // A message in a channel was sent in this superstep. At the beginning of a frame, every fact is new.
        if (is_new || begins_ || is_sent(f) || refusal)
            life_.sightings.push_back({step.number, step.kernel, f.tile, f.what, f.side, refusal});
        if (f.what == Seen::anchored || f.what == Seen::leaving) life_.anchor = f.tile;
        life_.copies += f.what == Seen::copy ? 1 : 0;
        life_.hops += f.what == Seen::road ? 1 : 0;
        life_.sent_copies += f.what == Seen::beam ? 1 : 0;
        life_.refusals += refusal ? 1 : 0;
    }
    before_ = std::move(facts);
    begins_ = false;
}

} // namespace render_map

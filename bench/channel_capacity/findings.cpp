#include "findings.hpp"
#include <algorithm>
#include <cmath>
#include <tilemesh/report/table.hpp>

namespace channel_capacity {

namespace {

using tilemesh::report::thousands;

std::string percent(double share)
{
    if (share == 0) return "nothing";
    return share < 0.0005 ? "under 0.05 %" : fixed(100 * share, share < 0.0995 ? 1 : 0) + " %";
}
bool is_continuous(std::string const& motion)
{
    return motion != "static" && motion != "teleport";
}
std::string called(std::string const& motion)
{
    return motion == "static" ? "a cold start" : motion == "teleport" ? "a teleport" : motion;
}
std::string slots(std::uint32_t n)
{
    return thousands(n) + (n == 1 ? " slot" : " slots");
}
std::vector<Knee> knees(std::vector<Row> const& rows, std::string const& scene, Saturation saturation)
{
    std::vector<Knee> out;
    for (auto const* motion : motion_names) {
        auto const one = select(rows, scene, motion, saturation);
        if (!one.empty()) out.push_back(knee_of(one));
    }
    return out;
}
/// The setting for the example pictures: its losses are plain to see, but part of the picture remains. If a setting loses copies only
/// because of full channels, it is one of these; among them, it is the one nearest to 5 % lost copies.
Row const* telling(std::vector<Row> const& rows)
{
    Row const* best = nullptr;
    auto const off = [](Row const& r) { return std::fabs(std::log(r.missing_share() / 0.05)); };
    for (bool const channels_alone : {true, false}) {
        for (auto const& r : rows)
            if (r.missing != 0 && (!channels_alone || r.refused_storage == 0) && (best == nullptr || off(r) < off(*best))) best = &r;
        if (best != nullptr) break;
    }
    return best;
}

} // namespace

std::string milliseconds(std::uint64_t cycles, int decimals)
{
    return fixed(tilemesh::milliseconds(cost_model(), cycles), decimals);
}

std::vector<bool> pareto_front(std::vector<Row> const& rows)
{
    std::vector<bool> out;
    for (auto const& r : rows)
        out.push_back(std::none_of(rows.begin(), rows.end(), [&](Row const& other) {
            auto const mine = r.cycles_most(), its = other.cycles_most();
            if ((other.saturation == Saturation::homes) != (r.saturation == Saturation::homes)) return false;
            return other.worst.psnr_db >= r.worst.psnr_db && its <= mine && (other.worst.psnr_db > r.worst.psnr_db || its < mine);
        }));
    return out;
}
std::vector<Row> by_time(std::vector<Row> const& rows, std::string const& scene, std::string const& motion)
{
    auto out = select(rows, scene, motion, Saturation::hold);
    auto const dropped = select(rows, scene, motion, Saturation::drop);
    out.insert(out.end(), dropped.begin(), dropped.end());
    std::stable_sort(out.begin(), out.end(), [](Row const& a, Row const& b) { return a.cycles_most() < b.cycles_most(); });
    return out;
}

std::vector<Row> select(std::vector<Row> const& rows, std::string const& scene, std::string const& motion, Saturation saturation)
{
    std::vector<Row> out;
    for (auto const& r : rows)
        if (r.scene == scene && r.motion == motion && r.saturation == saturation) out.push_back(r);
    return out;
}

Knee knee_of(std::vector<Row> const& rows)
{
    Knee knee;
    knee.motion = rows.front().motion;
    auto const lacks = [](Row const& r) { return r.missing + r.missing_first; };
    std::uint64_t least = lacks(rows.front());
    knee.least_missing = rows.front().missing_share();
    for (auto const& r : rows)
        if (lacks(r) < least) least = lacks(r), knee.least_missing = r.missing_share();
    auto const is_good = [&](Row const& r) { return 20 * lacks(r) <= 21 * least; };
    std::uint64_t fewest = ~std::uint64_t{0};
    for (auto const& r : rows)
        if (is_good(r)) {
            fewest = std::min(fewest, r.exchanges);
            knee.storage = 0;
        } else if (knee.storage == 0) {
            knee.storage = r.capacity, knee.storage_slots = r.storage;
        }
    for (auto const& r : rows)
        if (is_good(r) && (r.saturation == Saturation::drop || 20 * r.exchanges <= 21 * fewest)) {
            knee.channel = r.capacity, knee.channel_storage = r.storage;
            break;
        }
    knee.complete = least == 0;
    knee.fewest_exchanges = (fewest + rows.front().frames / 2) / rows.front().frames;
    return knee;
}

std::vector<std::string> knee_sentences(std::vector<Row> const& rows, std::string const& scene)
{
    std::vector<std::string> out;
    for (auto const saturation : {Saturation::hold, Saturation::drop}) {
        auto const all = knees(rows, scene, saturation);
        if (all.empty()) continue;
        auto const largest = [&](auto const& of) {
            Knee const* best = nullptr;
            for (auto const& k : all)
                if (of(k) && (best == nullptr || k.channel > best->channel)) best = &k;
            return best;
        };
        auto const* moving = largest([](Knee const& k) { return is_continuous(k.motion); });
        auto const* jumping = largest([](Knee const& k) { return !is_continuous(k.motion); });
        Knee const* first = nullptr; // the motion that is first limited by storage
        for (auto const& k : all)
            if (k.storage != 0 && (first == nullptr || k.storage < first->storage)) first = &k;

        std::string text = scene + ", " + to_string(saturation) + ": ";
        auto const need = [&](Knee const& k) { return "up to " + slots(k.channel) + " a channel for " + called(k.motion); };
        text += saturation == Saturation::hold ? "channels save exchanges " : "channels save records ";
        if (moving != nullptr) text += need(*moving) + (jumping != nullptr ? " (the most of all continuous motions) and " : "");
        if (jumping != nullptr) text += need(*jumping);
        text += ", and no more beyond";
        if (first != nullptr)
            text += "; from " + slots(first->storage) + " on, which leave " + thousands(first->storage_slots) +
                    " of storage, storage is what is missing (" + called(first->motion) + ")";
        auto const complete = std::all_of(all.begin(), all.end(), [](Knee const& k) { return k.complete; });
        if (!complete) {
            auto const worst =
                std::max_element(all.begin(), all.end(), [](Knee const& a, Knee const& b) { return a.least_missing < b.least_missing; });
            text += "; no split shows everything: the best lacks " + percent(worst->least_missing) + " of the copies (" +
                    called(worst->motion) + ")";
        }
        out.push_back(text + ".");
    }
    return out;
}

std::vector<std::string> paper_sentences(std::vector<Row> const& rows, std::string const& scene)
{
    std::vector<std::string> out;
    auto const jumps = select(rows, scene, "teleport", Saturation::drop);
    auto const* jump = telling(jumps);
    if (jump == nullptr) return out;
    auto const share = static_cast<double>(jump->missing_dense) / static_cast<double>(jump->missing);
    auto const fair = static_cast<double>(jump->wanted_dense) / static_cast<double>(jump->wanted);
    out.push_back(scene + ": dense regions saturate: of what " + slots(jump->capacity) + " a channel lose after a teleport (" +
                  percent(jump->missing_share()) + " of the copies, " + fixed(jump->worst.psnr_db, 1) + " dB in the worst frame), " +
                  percent(share) + " lies on the 5 % of the tiles that want most; they want " + percent(fair) +
                  (share > fair ? "." : ": NOT reproduced."));

    std::string text;
    double most = 0;
    for (auto const* motion : motion_names) {
        if (!is_continuous(motion)) continue;
        for (auto const& r : select(rows, scene, motion, Saturation::drop)) {
            if (r.capacity != jump->capacity) continue;
            text += (text.empty() ? "" : ", ") + std::string(motion) + " " + percent(r.missing_share());
            most = std::max(most, r.missing_share());
        }
    }
    if (!text.empty()) {
        text = scene + ": continuous motion loses less: with " + slots(jump->capacity) + " a channel a teleport loses " +
               percent(jump->missing_share()) + "; " + text;
        if (most > 0) text += "; " + fixed(jump->missing_share() / most, 1) + " times less at least";
        out.push_back(text + (most < jump->missing_share() ? "." : ": NOT reproduced."));
    }
    return out;
}

std::vector<std::string> homes_sentences(std::vector<Row> const& rows, std::string const& scene)
{
    std::vector<std::string> out;
    for (auto const* motion : motion_names) {
        auto const all = select(rows, scene, motion, Saturation::homes);
        if (all.empty()) continue;
        auto const faster = [](Row const& a, Row const& b) { return a.cycles_most() < b.cycles_most(); };
        auto const& best = *std::min_element(all.begin(), all.end(), faster);
        auto const near = std::find_if(all.begin(), all.end(), [&](Row const& r) { return 20 * r.cycles_most() <= 21 * best.cycles_most(); });
        auto const text = [](Row const& r) {
            auto const rounds = (r.rounds + r.frames / 2) / r.frames;
            return slots(r.capacity) + " a channel and " + thousands(r.storage) + " for splats: " + thousands(rounds) +
                   (rounds == 1 ? " round, " : " rounds, ") + thousands((r.exchanges + r.frames / 2) / r.frames) + " exchanges, " +
                   milliseconds(r.cycles_most(), 2) + " ms";
        };
        out.push_back(scene + ", homes, " + called(motion) + ": nothing is ever missing. With " + text(all.front()) + "; the least time with " + text(best) +
                      "; within 5 % of it from " + slots(near->capacity) + " on; with " + text(all.back()) + ".");
    }
    return out;
}

std::vector<std::string> latency_sentences(std::vector<LatencyRow> const& rows)
{
    std::vector<std::string> out;
    for (std::size_t begin = 0; begin < rows.size();) {
        auto end = begin;
        std::uint64_t gaussians = 0;
        bool exact = true;
        for (; end < rows.size() && rows[end].scene == rows[begin].scene && rows[end].hops == rows[begin].hops; ++end) {
            gaussians += rows[end].gaussians;
            exact = exact && rows[end].late_min == rows[end].expected && rows[end].late_max == rows[end].expected;
        }
        auto const& far = rows[end - 1];
        auto const formula = far.hops == 1 ? std::string("d frames") : "floor(d / " + std::to_string(far.hops) + ") frames";
        out.push_back(far.scene + ", " + std::to_string(far.hops) + (far.hops == 1 ? " hop" : " hops") + " a frame, after a teleport: " +
                      (exact ? "each of " + thousands(gaussians) + " Gaussians that moves d tiles is late exactly " + formula
                             : "latency is NOT " + formula + " for every one of " + thousands(gaussians) + " Gaussians that move d tiles") +
                      "; the farthest moves " + std::to_string(far.distance) + " and is late " + std::to_string(far.late_max) + ".");
        begin = end;
    }
    return out;
}

namespace {
void add_row(std::string& out, Row const& r, bool on_front)
{
    out += r.scene + "," + r.motion + "," + std::to_string(r.capacity) + "," + std::to_string(r.storage) + "," +
           (r.saturation == Saturation::drop ? "drop" : "hold") + "," + fixed(r.worst.psnr_db, 3) + "," + std::to_string(r.exchanges_most) + "," +
           milliseconds(r.cycles_most(), 4) + "," + std::to_string(r.held) + "," + std::to_string(r.dropped) + "," +
           std::to_string(r.peak_channel) + "," +
           std::to_string(r.peak_storage) + "," + fixed(r.psnr_last_db, 3) + "," + fixed(r.worst.max_levels, 3) + "," +
           fixed(r.worst.ssim, 6) + "," + fixed(r.worst.share_over_one_level, 6) + "," + std::to_string(r.frames) + "," +
           fixed(static_cast<double>(r.exchanges) / r.frames, 1);
    for (auto const n : {r.hops, r.messages, r.moved, r.unplaced, r.not_loaded, r.lost_copies, r.late, r.refused_channel,
                         r.refused_storage, r.wanted, r.missing, r.missing_first, r.wanted_dense, r.missing_dense})
        out += "," + std::to_string(n);
    out += r.ran ? ",1," : ",0,";
    out += milliseconds(r.cycles_mean(), 4) + "," + milliseconds(r.exchange_mean(), 4) + (on_front ? ",1" : ",0") +
           (r.saturation == Saturation::homes ? ",homes," : ",anchored,") + std::to_string(r.rounds) + "\n";
}
} // namespace

std::string csv(std::vector<Row> const& rows)
{
    std::string out =
        "scene,motion,capacity,storage,saturation,psnr_db,exchanges,modelled_ms,held,dropped,peak_channel,peak_storage,"
        "psnr_last_db,max_levels,ssim,share_over_one_level,frames,exchanges_mean,hops,messages,moved,unplaced,not_loaded,lost_copies,"
        "late,refused_channel,refused_storage,wanted,missing,missing_first,wanted_dense,missing_dense,ran,modelled_ms_mean,"
        "modelled_exchange_ms_mean,pareto,program,rounds\n";
    for (std::size_t begin = 0; begin < rows.size();) { // a motion of a scene after the other
        auto const& first = rows[begin];
        auto end = begin;
        while (end < rows.size() && rows[end].scene == first.scene && rows[end].motion == first.motion) ++end;
        std::vector<Row> const one(rows.begin() + static_cast<std::ptrdiff_t>(begin), rows.begin() + static_cast<std::ptrdiff_t>(end));
        auto const front = pareto_front(one);
        for (std::size_t i = 0; i < one.size(); ++i) add_row(out, one[i], front[i]);
        begin = end;
    }
    return out;
}

std::string csv(std::vector<LatencyRow> const& rows)
{
    std::string out = "scene,hops,distance,gaussians,late_min,late_median,late_max,expected\n";
    for (auto const& r : rows) {
        out += r.scene;
        for (auto const n : {std::uint64_t{r.hops}, std::uint64_t{r.distance}, r.gaussians, std::uint64_t{r.late_min},
                             std::uint64_t{r.late_median}, std::uint64_t{r.late_max}, std::uint64_t{r.expected}})
            out += "," + std::to_string(n);
        out += "\n";
    }
    return out;
}

} // namespace channel_capacity

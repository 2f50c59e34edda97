#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tilemesh/report/causes.hpp>
#include <tilemesh/report/detail/enclosed_splats.hpp>
#include <tilemesh/report/detail/enclosure_code.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report::detail {

TILEMESH_HOST std::vector<std::pair<std::string, splat::Rules>> other_rules(splat::Rules const& rules)
{
    std::vector<std::pair<std::string, splat::Rules>> out;
    auto const add = [&](std::string const& word, auto const& change) {
        auto other = rules;
        change(other);
        out.emplace_back(word, other);
    };
    for (float const h : {0.0f, 0.1f, 0.3f})
        if (h != rules.dilation) add("dilation " + significant(double{h}, 2), [h](splat::Rules& r) { r.dilation = h; });
    using splat::Coverage;
    if (rules.coverage == Coverage::preserved) add("no antialias", [](splat::Rules& r) { r.coverage = Coverage::of_record; });
    else add("antialias", [](splat::Rules& r) { r.coverage = Coverage::preserved; });
    for (float const least : {0.0f, 1 / 255.0f})
        if (least != rules.alpha_min)
            add(least > 0 ? "alpha_min 1/255" : "alpha_min 0", [least](splat::Rules& r) { r.alpha_min = least > 0 ? least : 1e-12f; });
    for (float const most : {0.99f, 1.0f})
        if (most != rules.alpha_max) add("alpha_max " + significant(double{most}, 2), [most](splat::Rules& r) { r.alpha_max = most; });
    for (float const limit : {0.0f, 1e-4f})
        if (limit != rules.transmittance_min) add("stop " + significant(double{limit}, 2), [limit](splat::Rules& r) { r.transmittance_min = limit; });
    using splat::Footprint;
    if (rules.footprint == Footprint::opacity_box) add("footprint of 3 sigma", [](splat::Rules& r) { r.footprint = Footprint::three_sigma_square; });
    else add("footprint without a limit", [](splat::Rules& r) { r.footprint = Footprint::opacity_box; });
    if (rules.jacobian_limit > 0) add("slopes without a limit", [](splat::Rules& r) { r.jacobian_limit = 0; });
    return out;
}

#if TILEMESH_HAS_BALLS
/// A pixel in double, and what one change makes of it.
class PixelInquiry {
public:
    PixelInquiry(EnclosedScene const& scene, std::int32_t x, std::int32_t y, float const* seen, Written const& written)
        : rules_(scene.rules), ids_(scene.ids), seen_(seen), written_(written)
    {
        double const cut = rules_.alpha_min;
        auto const& list = scene.lists[static_cast<std::size_t>(y / block_px) * scene.columns + static_cast<std::size_t>(x / block_px)];
        for (auto const n : list) {
            auto const& e = scene.splats.splats[n];
            double const dx = x + 0.5 - e.x, off = y + 0.5 - e.y - e.slope * dx;
            double const a = e.opacity * std::exp(e.along * dx * dx + e.across * off * off);
            if (!(a >= cut * 0.99)) continue;
            bool const near_cut = a <= cut * 1.01, at_border = !e.must.contains(x, y) || !e.may.contains(x, y);
            terms_.push_back({&e, n, std::min(a, double{rules_.alpha_max}), a >= cut && e.may.contains(x, y), near_cut || at_border});
        }
        blend();
        error_ = residual(colour_);
    }
    PixelCause cause()
    {
        if (!std::isfinite(error_)) return {"not finite", 0, 0, error_};
        double const enough = std::max(0.1 * error_, 0.002);
        PixelCause best{"unknown", 0, 0, error_};
        auto const consider = [&](char const* word, std::uint32_t id, std::uint32_t other, Colour const& c) {
            if (double const left = residual(c); left < best.left) best = {word, id, other, left};
        };
        look_at_cuts(consider), look_at_stop(consider), look_at_order(consider, 0.9 * error_);
        PixelCause const in_order = best;
        for (std::size_t k = 0; k < in_.size(); ++k) consider("missing", id(in_[k]), 0, with(k, in_[k] + 1, before_[k]));
        if (in_order.left <= std::max(0.02 * error_, 0.002)) return in_order; // the less surprising one
        if (best.left <= (best.word == "missing" ? std::max(0.05 * error_, 0.002) : enough)) return best;
        if (in_order.left <= enough) return in_order;
        if (in_order.word == "order")
            if (auto const more = order_in_steps(in_order, enough); more.left <= enough) return more;
        double const scale = 1 + std::max({std::fabs(colour_.v[0]), std::fabs(colour_.v[1]), std::fabs(colour_.v[2])});
        bool const small = error_ <= scale * std::min(1.0, 255 * 0x1p-12 * static_cast<double>(in_.size() + 8));
        return {small ? "rounding" : "unknown", 0, 0, error_};
    }

private:
    struct Colour {
        double v[3] = {0, 0, 0};
    };
    struct Term {
        DoubleSplat const* splat;
        std::uint32_t n;
        double a;
        bool in, close; ///< it may be decided otherwise
    };
    /// The pixel if it sees `other` from in front of term k.
    Colour with(std::size_t k, Colour const& other) const
    {
        Colour c = colour_;
        for (int i = 0; i < 3; ++i) c.v[i] += before_[k] * (other.v[i] - behind_[k].v[i]);
        return c;
    }
    /// The pixel if from in front of term k on it blends the terms from `first` on, up to a stop of their own. With `more`, one before them.
    Colour with(std::size_t k, std::size_t first, double t, Term const* more = nullptr) const
    {
        Colour c = with(k, Colour{});
        bool goes_on = true;
        auto const blend_one = [&](Term const& term) {
            double const after = t * (1 - term.a);
            bool const crosses = after < double{rules_.transmittance_min};
            if (crosses && rules_.stop == splat::Stop::before_crossing) return false;
            for (int i = 0; i < 3; ++i) c.v[i] += t * term.a * term.splat->colour[i];
            t = after;
            return !crosses;
        };
        if (more != nullptr) goes_on = blend_one(*more);
        for (std::size_t i = first; goes_on && i < terms_.size(); ++i)
            if (terms_[i].in) goes_on = blend_one(terms_[i]);
        for (int i = 0; i < 3; ++i) c.v[i] += t * double{rules_.background[i]};
        return c;
    }
    Colour background() const { return {{rules_.background[0], rules_.background[1], rules_.background[2]}}; }
    static Colour over(Term const& t, Colour behind)
    {
        for (int k = 0; k < 3; ++k) behind.v[k] = t.a * t.splat->colour[k] + (1 - t.a) * behind.v[k];
        return behind;
    }
    std::uint32_t id(std::size_t term) const { return static_cast<std::uint32_t>(ids_[terms_[term].n]); }

    /// The terms up to the stop, the transmittance before each, and what is seen behind each: `behind_[k]` from in front of term k.
    void blend()
    {
        in_.clear(), before_.clear();
        double t = 1;
        for (std::size_t i = 0; i < terms_.size(); ++i) {
            if (!terms_[i].in) continue;
            double const after = t * (1 - terms_[i].a);
            bool const crosses = after < double{rules_.transmittance_min};
            if (crosses && rules_.stop == splat::Stop::before_crossing) break;
            in_.push_back(i), before_.push_back(t);
            t = after;
            if (crosses) break;
        }
        before_.push_back(t);
        behind_.assign(in_.size() + 1, background());
        for (std::size_t k = in_.size(); k-- > 0;) behind_[k] = over(terms_[in_[k]], behind_[k + 1]);
        colour_ = behind_[0];
    }
    /// Levels by which a colour is off.
    double residual(Colour const& c) const
    {
        double most = 0;
        for (int k = 0; k < 3; ++k) {
            double const v = written_.clamped ? std::clamp(c.v[k], 0.0, 1.0) : c.v[k];
            double const off = std::fabs(double{seen_[k]} - v) - written_.half_step;
            most = std::max(most, std::isnan(off) ? std::numeric_limits<double>::infinity() : off);
        }
        return 255 * most;
    }
    template <class Consider>
    void look_at_cuts(Consider const& consider) const
    {
        std::size_t k = 0; // terms that are there, before this one
        for (std::size_t i = 0; i < terms_.size() && k < before_.size(); ++i) {
            auto const& t = terms_[i];
            bool const there = k < in_.size() && in_[k] == i;
            if (t.close && there) consider("cut", id(i), 0, with(k, i + 1, before_[k]));
            if (t.close && !there) consider("cut", id(i), 0, with(k, i + 1, before_[k], &t));
            k += there ? 1 : 0;
        }
    }
    template <class Consider>
    void look_at_stop(Consider const& consider) const
    {
        double const limit = rules_.transmittance_min;
        auto const near = [&](double t) { return std::fabs(t - limit) <= 0.01 * limit; };
        for (std::size_t k = in_.size(); k > 0 && before_[k] < 2 * limit + 1e-6; --k) { // earlier
            if (!near(before_[k])) continue;
            consider("stop", id(in_[k - 1]), 0, with(k, background()));
            consider("stop", id(in_[k - 1]), 0, with(k - 1, background()));
        }
        double t = before_.back(); // later
        Colour further = colour_;
        bool may = in_.empty() || near(t);
        for (std::size_t i = in_.empty() ? 0 : in_.back() + 1; i < terms_.size(); ++i) {
            if (!terms_[i].in) continue;
            double const after = t * (1 - terms_[i].a);
            if (rules_.stop == splat::Stop::before_crossing) may = may || near(after);
            if (!may) break;
            for (int k = 0; k < 3; ++k) further.v[k] += t * terms_[i].a * (terms_[i].splat->colour[k] - double{rules_.background[k]});
            consider("stop", id(i), 0, further);
            t = after;
        }
    }
    /// Term i comes behind term j, or before it: the run between them is a colour and a transmittance. Changes that cannot make `least` levels are
    /// left out, and so is what a pixel of thousands of terms would take too long for.
    template <class Consider>
    void look_at_order(Consider const& consider, double least) const
    {
        double range = 0;
        for (auto const i : in_)
            for (int k = 0; k < 3; ++k) range = std::max(range, std::fabs(terms_[i].splat->colour[k]));
        std::uint32_t pairs = 20'000;
        for (std::size_t i = 0; i < in_.size(); ++i) {
            auto const& a = terms_[in_[i]];
            if (255 * before_[i] * 2 * range < least) break; // nor can a later one
            Colour run; // of the terms behind it
            double through = 1;
            for (std::size_t j = i + 1; j < in_.size(); ++j) {
                auto const& b = terms_[in_[j]];
                if (b.splat->colour[3] > 1.01 * a.splat->colour[3] || pairs == 0) break;
                --pairs;
                Colour later = colour_, sooner = colour_;
                Colour longer = run;
                for (int k = 0; k < 3; ++k) {
                    double const ca = a.splat->colour[k], cb = b.splat->colour[k];
                    longer.v[k] = run.v[k] + through * b.a * cb;
                    double const rest = through * (1 - b.a);
                    later.v[k] += before_[i] * a.a * (longer.v[k] + rest * ca - ca);
                    // b before a and the run between: b, then a and the run, against a, the run, b.
                    double const middle = a.a * ca + (1 - a.a) * run.v[k], after = (1 - a.a) * through;
                    sooner.v[k] += before_[i] * b.a * (cb - middle - after * cb);
                }
                run = longer, through *= 1 - b.a;
                if (255 * before_[i] * std::max(a.a, b.a) * 2 * range < least) continue;
                consider("order", id(in_[i]), id(in_[j]), later);
                if (j > i + 1) consider("order", id(in_[j]), id(in_[i]), sooner);
            }
        }
    }
    /// More than one pair: the best change is made, and the next one looked for.
    PixelCause order_in_steps(PixelCause const& first, double enough)
    {
        PixelCause out = first;
        auto const kept = terms_;
        auto const place = [&](std::uint32_t wanted) {
            std::size_t at = 0;
            while (at < in_.size() && id(in_[at]) != wanted) ++at;
            return at;
        };
        PixelCause step = first;
        for (int n = 0; n < 24 && step.left > enough; ++n) {
            auto const from = place(step.id), to = place(step.other_id);
            if (from == in_.size() || to == in_.size()) break;
            auto const term = [&](std::size_t k) { return terms_.begin() + static_cast<std::ptrdiff_t>(in_[k]); };
            if (from < to) std::rotate(term(from), term(from) + 1, term(to) + 1);
            else std::rotate(term(to), term(from), term(from) + 1);
            blend();
            step = {"order", 0, 0, residual(colour_)};
            double const before = step.left;
            if (step.left > enough)
                look_at_order([&](char const* word, std::uint32_t a, std::uint32_t b, Colour const& c) {
                    if (double const left = residual(c); left < step.left) step = {word, a, b, left};
                }, 0.1 * before);
            out.left = step.left;
            if (step.left > enough && !(step.left < 0.9 * before)) break;
        }
        terms_ = kept;
        blend();
        return out;
    }

    splat::Rules const& rules_;
    std::vector<splat::GaussianId> const& ids_;
    float const* seen_;
    Written const& written_;
    std::vector<Term> terms_;
    std::vector<std::size_t> in_; ///< the terms that are blended
    std::vector<double> before_;
    std::vector<Colour> behind_;
    Colour colour_;
    double error_ = 0;
};

/// The background that fits the pixels that are off, and how many of them it explains; as a picture.
inline Image with_background(Enclosure const& e, Image const& picture, std::vector<std::uint32_t> const& places)
{
    double shift[3];
    for (std::uint32_t k = 0; k < 3; ++k) {
        std::vector<double> shifts;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (double const through = e.transmittance[places[i]]; through > 0.05)
                shifts.push_back((double{picture.rgb[3 * std::size_t{places[i]} + k]} - e.middle[3 * std::size_t{places[i]} + k]) / through);
        shift[k] = quantile(shifts, 0.5);
    }
    Image out = picture;
    for (std::size_t i = 0; i < places.size(); ++i)
        for (std::uint32_t k = 0; k < 3; ++k) {
            auto const at = 3 * std::size_t{places[i]} + k;
            out.rgb[at] = static_cast<float>(e.middle[at] + double{e.transmittance[places[i]]} * shift[k]);
        }
    return out;
}

TILEMESH_HOST void explain(Certificate& certificate, Enclosure const& enclosure, Image const& picture, Written const& written,
                           std::vector<OtherRules> const& others, unsigned threads)
{
    if (!enclosure.scene || certificate.beyond == 0) return;
    auto const off = levels_off(enclosure, picture, written);
    auto const of_pixel = [&](std::size_t i) { return std::max({off[3 * i], off[3 * i + 1], off[3 * i + 2]}); };
    auto const at = [&](std::uint32_t place) {
        return std::pair(static_cast<std::int32_t>(place % picture.width), static_cast<std::int32_t>(place / picture.width));
    };
    auto const cause_of = [&](std::uint32_t place) {
        auto const [x, y] = at(place);
        bool inside = true;
        for (std::size_t i = 3 * std::size_t{place}; i < 3 * std::size_t{place} + 3; ++i) {
            double const middle = written.clamped ? std::clamp(enclosure.middle[i], 0.0, 1.0) : enclosure.middle[i];
            inside = inside && std::fabs(double{picture.rgb[i]} - middle) <= enclosure.radius[i] + written.half_step;
        }
        if (inside) return PixelCause{"undecided", 0, 0, of_pixel(place)};
        return PixelInquiry(*enclosure.scene, x, y, &picture.rgb[3 * std::size_t{place}], written).cause();
    };
    std::vector<std::uint32_t> places;
    for (std::uint32_t i = 0; i < off.size() / 3; ++i)
        if (of_pixel(i) > 0.01) places.push_back(i);
    auto const add = [&](std::string const& word, std::uint64_t pixels) {
        auto const row = std::find_if(certificate.causes.begin(), certificate.causes.end(), [&](auto const& r) { return r.first == word; });
        if (row != certificate.causes.end()) row->second += pixels;
        else certificate.causes.emplace_back(word, pixels);
    };
    // One of each `step` pixels, another one each time, so that a regular pattern is not missed.
    constexpr std::size_t most = 1000;
    auto const step = std::max<std::size_t>(1, (places.size() + most - 1) / most);
    std::vector<std::size_t> sample;
    for (std::size_t i = 0; i < places.size(); i += step) sample.push_back(std::min(places.size() - 1, i + i / step * 7919 % step));
    std::vector<PixelCause> found(sample.size());
    for_each_on(threads, sample.size(), [&](std::size_t i) { found[i] = cause_of(places[sample[i]]); });
    certificate.causes.clear();
    std::uint64_t by_decisions = 0;
    for (auto const& cause : found) add(cause.word, 1), by_decisions += cause.word == "order" || cause.word == "cut" || cause.word == "stop" ? 1 : 0;
    for (auto& pixel : certificate.worst) pixel.cause = cause_of(pixel.y * picture.width + pixel.x);

    if (2 * by_decisions < sample.size() && 200 * places.size() > off.size() / 3) {
        // Levels that are left beside another picture, at most; infinite if one of the two is not finite.
        auto const left_of = [&](std::uint32_t place, auto const& other) {
            double most_left = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                auto const channel = 3 * std::size_t{place} + k;
                double const v = written.clamped ? std::clamp(double{other[channel]}, 0.0, 1.0) : double{other[channel]};
                double const left = 255 * (std::fabs(double{picture.rgb[channel]} - v) - written.half_step);
                most_left = std::max(most_left, std::isnan(left) ? std::numeric_limits<double>::infinity() : left);
            }
            return most_left;
        };
        std::string best;
        std::vector<double> best_left;
        std::uint64_t best_count = 0;
        auto const explains = [&](std::size_t i, double left) {
            double const error = left_of(places[i], enclosure.middle);
            return std::isfinite(left) && error > 0.01 && left <= std::max(0.1 * error, 0.01);
        };
        auto const judge = [&](std::string const& word, Image const& other) {
            std::vector<double> left(places.size());
            std::uint64_t count = 0;
            for (std::size_t i = 0; i < places.size(); ++i) left[i] = left_of(places[i], other.rgb), count += explains(i, left[i]) ? 1 : 0;
            if (count > best_count) best = word, best_count = count, best_left = std::move(left);
        };
        judge("background", with_background(enclosure, picture, places));
        for (auto const& other : others) {
            if (2 * best_count > places.size() && best_count + places.size() / 100 >= places.size()) break; // nothing is left to find
            judge(other.word, other.render());
        }
        if (2 * best_count >= places.size()) {
            certificate.causes.clear();
            for (std::size_t i = 0; i < sample.size(); ++i) add(explains(sample[i], best_left[sample[i]]) ? best : found[i].word, 1);
            for (auto& pixel : certificate.worst) {
                auto const found_at = std::lower_bound(places.begin(), places.end(), pixel.y * picture.width + pixel.x);
                auto const place = static_cast<std::size_t>(found_at - places.begin());
                if (explains(place, best_left[place])) pixel.cause = {best, 0, 0, best_left[place]};
            }
        }
    }
    std::stable_sort(certificate.causes.begin(), certificate.causes.end(), [](auto const& a, auto const& b) { return a.second > b.second; });
}
#else
TILEMESH_HOST void explain(Certificate&, Enclosure const&, Image const&, Written const&, std::vector<OtherRules> const&, unsigned) {}
#endif

}}} // namespace tilemesh::v0_2::report::detail

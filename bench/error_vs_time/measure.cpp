#include "measure.hpp"
#include "machine.hpp"
#include "settings.hpp"
#include "whole_frame.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>
#include <common/options.hpp>
#include <cstddef>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/records.hpp>
#include <utility>
#include <vector>

namespace error_vs_time {

namespace {

using report::Image;
using tilemesh::splat::Camera;
using Gaussians = std::vector<splat::Gaussian>;

/// The number of machines that take turns in the rounds of one batch.
constexpr std::size_t batch_size = 22;
/// A setting that takes more milliseconds than this gets only about three rounds.
constexpr double long_ms = 150;
constexpr std::uint32_t rounds_of_long_ones = 3;

/// The three pictures with which a mesh's picture is compared.
struct References {
    std::shared_ptr<Image const> none; ///< R0
    std::shared_ptr<Image const> cut;  ///< R1
    std::shared_ptr<Image const> whole; ///< R2
};
struct Errors {
    report::ErrorMeasures total{}, cut{}, round{}, mesh{};
    bool mesh_is_whole = false; ///< the mesh's picture is R2, bit for bit
    double twice_products = 0, split_off = 0;
};

double mean_of_products(Image const& a, Image const& b, Image const& c, Image const& d)
{
    double sum = 0; // of (a - b) (c - d)
    for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += (double{a.rgb[i]} - b.rgb[i]) * (double{c.rgb[i]} - d.rgb[i]);
    return sum / static_cast<double>(a.rgb.size());
}

/// Some of the measures of `report::compare`, computed faster.
report::ErrorMeasures part(Image const& picture, Image const& reference)
{
    double sum = 0, squares = 0, most = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
        double const error = std::fabs(double{picture.rgb[i]} - reference.rgb[i]);
        sum += error, squares += error * error, most = std::max(most, error);
    }
    auto const n = static_cast<double>(picture.rgb.size());
    report::ErrorMeasures m{};
    m.rmse = std::sqrt(squares / n);
    m.mae = sum / n;
    m.max_levels = 255 * most;
    m.psnr_db = m.rmse > 0 ? -20 * std::log10(m.rmse) : std::numeric_limits<double>::infinity();
    return m;
}

/// `in_full`: all measures; otherwise rmse, mae, max_levels and psnr_db.
Errors errors_of(Image const& mesh, References const& r, bool in_full)
{
    Errors e;
    auto const measure = in_full ? report::compare : part;
    e.total = measure(mesh, *r.none);
    e.cut = measure(*r.cut, *r.none);
    e.round = measure(*r.whole, *r.cut);
    e.mesh = measure(mesh, *r.whole);
    e.mesh_is_whole = std::memcmp(mesh.rgb.data(), r.whole->rgb.data(), mesh.rgb.size() * sizeof(float)) == 0;
    // mesh - none = (mesh - whole) + (whole - cut) + (cut - none), pixel by pixel. The square of the sum also has products.
    e.twice_products = 2 * (mean_of_products(*r.cut, *r.none, *r.whole, *r.cut) + mean_of_products(*r.cut, *r.none, mesh, *r.whole) +
                            mean_of_products(*r.whole, *r.cut, mesh, *r.whole));
    auto const square = [](report::ErrorMeasures const& m) { return m.rmse * m.rmse; };
    double const all = square(e.total), parts = square(e.cut) + square(e.round) + square(e.mesh);
    e.split_off = all > 0 ? std::fabs(all - parts - e.twice_products) / all : parts;
    return e;
}

/// Makes the references of a view. It keeps those with the default's cut-offs, because many settings share them.
class ReferencesOf {
public:
    ReferencesOf(Gaussians const& gaussians, Camera const& camera, Setting const& first, std::uint32_t threads)
        : gaussians_(gaussians), camera_(camera),
          none_(std::make_shared<Image>(report::render_double(gaussians, camera, first.rules, report::no_cut_offs(no_alpha_cut), threads)))
    {
        first_ = make(first, threads);
        first_setting_ = first;
    }
    References of(Setting const& s) const // each thread on its own
    {
        if (s.knobs == first_setting_.knobs && std::memcmp(&s.rules, &first_setting_.rules, sizeof s.rules) == 0) return first_;
        return make(s, 1);
    }

private:
    References make(Setting const& s, std::uint32_t threads) const
    {
        return {none_, std::make_shared<Image>(report::render_double(gaussians_, camera_, s.rules, cut_offs_of(s), threads)),
                std::make_shared<Image>(whole_frame(gaussians_, camera_, s.rules, s.knobs))};
    }
    Gaussians const& gaussians_;
    Camera camera_;
    std::shared_ptr<Image const> none_;
    References first_;
    Setting first_setting_;
};

/// Calls f(i) for each i below n on `threads` threads. Rethrows the first exception.
template <class F>
void on_threads(std::uint32_t threads, std::size_t n, F const& f)
{
    std::atomic<std::size_t> next{0};
    std::exception_ptr failed;
    std::mutex lock;
    auto const work = [&] {
        for (std::size_t i; (i = next++) < n;) {
            try {
                f(i);
            } catch (...) {
                std::lock_guard const hold(lock);
                if (!failed) failed = std::current_exception();
            }
        }
    };
    {
        tilemesh::JoinedThreads others;
        try {
            for (std::uint32_t t = 1; t < threads && t < n; ++t) others.start(work);
        } catch (std::system_error const&) { // the existing threads do all the work
        }
        work();
    }
    if (failed) std::rethrow_exception(failed);
}

Row begin_row(bench::Scene const& scene, std::string camera, Setting const& setting, std::uint32_t frames)
{
    Row row;
    row.scene = scene.map.name;
    row.camera = std::move(camera);
    row.gaussians = scene.map.gaussians.size();
    row.size = {scene.camera.width, scene.camera.height};
    row.frames = frames;
    row.setting = setting;
    row.projected_bytes = sizeof(splat::Splat) - (setting.knobs.shape == Shape::float32 ? 0 : 6);
    return row;
}
void take_errors(Row& row, Errors const& e)
{
    row.total = e.total, row.cut = e.cut, row.round = e.round, row.mesh = e.mesh;
    row.twice_products = e.twice_products;
}
void take_counters(Row& row, Errors const& e, Machine& machine)
{
    row.counters = machine.counters();
    std::uint64_t lost = 0, late = 0, unplaced = 0;
    for (auto const& l : row.counters.lost)
        ++(l.cause == report::Cause::late ? late : l.cause == report::Cause::unplaced ? unplaced : lost);
    row.lost = std::max(row.lost, lost);
    row.late = std::max(row.late, late);
    row.unplaced = std::max(row.unplaced, unplaced);
    row.mesh_wrong = row.mesh_wrong || (lost + late + unplaced == 0 && !e.mesh_is_whole);
    row.modelled_ms = machine.modelled_ms();
}
/// The setting with which the mesh renders. With --spoil, all settings except the default get another alpha_max than their references.
Setting setting_of_mesh(Setting setting, MeasureOptions const& options)
{
    if (options.spoil && setting.name != "default") setting.rules.alpha_max = bench::spoilt_alpha_max;
    return setting;
}

/// Writes the mesh's picture and the three references, so that another program can compare them.
void write_pictures(std::filesystem::path const& folder, Row const& row, Image const& mesh, References const& r)
{
    auto name = row.scene + "_" + row.setting.name + "_";
    std::replace(name.begin(), name.end(), ' ', '_');
    report::write_pfm(folder / (name + "mesh.pfm"), mesh);
    report::write_pfm(folder / (name + "whole.pfm"), *r.whole);
    report::write_pfm(folder / (name + "cut.pfm"), *r.cut);
    report::write_pfm(folder / (name + "reference.pfm"), *r.none);
}
bool is_written(std::string const& name)
{
    return name == "default" || name == "on_sensor" || name == "drop 5 slots";
}

/// Renders the two views alternately on all machines of a batch, and measures the second view.
void time_batch(std::vector<Row*> const& rows, std::vector<std::unique_ptr<Machine>> const& machines, Camera const& first,
                Camera const& second, std::uint32_t rounds, Noise& noise)
{
    std::vector<double> first_ms(machines.size());
    for (std::size_t i = 0; i < machines.size(); ++i) { // warms up
        if (!machines[i]) continue;
        machines[i]->render(first);
        machines[i]->render(second);
        first_ms[i] = machines[i]->host_ms();
    }
    // Each round has another order, so that no setting always follows the same setting, or the default itself.
    auto const n = machines.size();
    std::size_t stride = 0;
    std::uint32_t const every = std::max(1u, rounds / rounds_of_long_ones);
    std::vector<double> ms(n);
    for (std::uint32_t round = 0; round < rounds; ++round) {
        do stride = stride % n + 1;
        while (std::gcd(stride, n) != 1);
        std::fill(ms.begin(), ms.end(), 0);
        for (std::size_t k = 0; k < n; ++k) {
            auto const i = (round + k * stride) % n;
            bool const is_default = i < 2; // all times are divided by the default's
            if (!machines[i] || (!is_default && first_ms[i] > long_ms && round % every != 0)) continue;
            machines[i]->render(first);
            machines[i]->render(second);
            ms[i] = machines[i]->host_ms();
        }
        for (std::size_t i = 0; i < n; ++i) {
            if (!(ms[i] > 0)) continue;
            if (i == 1) { // the second default
                if (ms[0] > 0) noise.ratios.push_back(ms[1] / ms[0]);
                continue;
            }
            rows[i]->host_ms.push_back(ms[i]);
            if (ms[0] > 0) rows[i]->over_default.push_back(ms[i] / ms[0]);
        }
    }
}

} // namespace

std::vector<Row> measure_view(bench::Scene const& scene, std::vector<Setting> const& settings, MeasureOptions const& options, Noise& noise)
{
    auto const gaussians = tilemesh::scene::records<splat::Gaussian>(scene.map);
    auto const cameras = bench::cameras_of("orbit2", scene, 1, {});
    ReferencesOf const references(gaussians, cameras[1], settings.front(), options.threads);
    auto const exact = report::enclose(gaussians, cameras[1], settings.front().rules, {.threads = options.threads, .cuts = report::Cuts::none});
    noise.scene = scene.map.name;

    std::vector<Row> rows;
    for (auto const& s : settings) rows.push_back(begin_row(scene, "orbit2", s, 1));
    auto const run = [&](Row& row) -> std::unique_ptr<Machine> {
        try {
            auto machine = make_machine(scene.map, setting_of_mesh(row.setting, options), 1);
            machine->settle(cameras[0], cameras[1]);
            for (auto const i : {1u, 0u, 1u}) machine->render(cameras[i]); // there and back, as in the rounds
            auto const r = references.of(row.setting);
            auto const e = errors_of(machine->image(), r, true);
            take_errors(row, e);
            row.split_off = e.split_off;
            row.certified_levels = report::certify(exact, machine->image()).largest;
            take_counters(row, e, *machine);
            if (!options.pfm.empty() && is_written(row.setting.name)) write_pictures(options.pfm, row, machine->image(), r);
            return machine;
        } catch (tilemesh::Error const& error) {
            row.failed = error.what();
            return nullptr;
        }
    };
    // The default, the default again, then a batch of other settings.
    std::unique_ptr<Machine> once, again;
    {
        Row copy = rows.front();
        once = run(rows.front());
        again = run(copy);
    }
    for (std::size_t begin = 1; begin == 1 || begin < rows.size(); begin += batch_size) {
        auto const count = std::min(batch_size, rows.size() - begin);
        std::vector<std::unique_ptr<Machine>> machines(2 + count);
        std::vector<Row*> batch(2 + count, nullptr);
        on_threads(options.threads, count, [&](std::size_t i) {
            batch[2 + i] = &rows[begin + i];
            machines[2 + i] = run(rows[begin + i]);
        });
        batch[0] = &rows.front();
        machines[0] = std::move(once);
        machines[1] = std::move(again);
        time_batch(batch, machines, cameras[0], cameras[1], options.rounds, noise);
        once = std::move(machines[0]);
        again = std::move(machines[1]);
        if (options.progress)
            options.progress(scene.map.name + ": " + std::to_string(begin + count) + " of " + std::to_string(rows.size()) + " settings");
    }
    return rows;
}

std::vector<Row> measure_sequence(bench::Scene const& scene, std::string const& motion, std::uint32_t frames,
                                  std::filesystem::path const& data, std::vector<Setting> const& settings, MeasureOptions const& options)
{
    auto const gaussians = tilemesh::scene::records<splat::Gaussian>(scene.map);
    auto const cameras = bench::cameras_of(motion, scene, frames, data);
    frames = static_cast<std::uint32_t>(cameras.size()) - 1;
    std::vector<Row> rows;
    for (auto const& s : settings) rows.push_back(begin_row(scene, motion + " x " + std::to_string(frames), s, frames));

    std::vector<std::unique_ptr<Machine>> machines(rows.size());
    std::vector<std::shared_ptr<Image>> last(rows.size());
    std::shared_ptr<Image const> last_none;
    for (std::uint32_t frame = 0; frame <= frames; ++frame) {
        ReferencesOf const references(gaussians, cameras[frame], settings.front(), options.threads);
        auto const none = references.of(settings.front()).none;
        on_threads(options.threads, rows.size(), [&](std::size_t i) {
            auto& row = rows[i];
            if (!row.failed.empty()) return;
            try {
                if (frame == 0) {
                    machines[i] = make_machine(scene.map, setting_of_mesh(row.setting, options), 1);
                    machines[i]->settle(cameras[0], cameras[1]);
                } else {
                    machines[i]->render(cameras[frame]);
                    auto const r = references.of(row.setting);
                    auto e = errors_of(machines[i]->image(), r, false);
                    if (frame == 1 || e.total.rmse > row.total.rmse) {
                        e = errors_of(machines[i]->image(), r, true);
                        take_errors(row, e);
                    }
                    row.split_off = std::max(row.split_off, e.split_off);
                    take_counters(row, e, *machines[i]);
                    Image const& now = machines[i]->image();
                    double sum = 0;
                    for (std::size_t k = 0; k < now.rgb.size(); ++k) {
                        double const step = double{now.rgb[k]} - last[i]->rgb[k], wanted = double{none->rgb[k]} - last_none->rgb[k];
                        sum += (step - wanted) * (step - wanted);
                    }
                    row.popping = std::max(row.popping, std::sqrt(sum / static_cast<double>(now.rgb.size())));
                }
                last[i] = std::make_shared<Image>(machines[i]->image());
            } catch (tilemesh::Error const& error) {
                row.failed = error.what();
                machines[i].reset();
            }
        });
        last_none = none;
        if (options.progress)
            options.progress(scene.map.name + " " + motion + ": frame " + std::to_string(frame) + " of " + std::to_string(frames));
    }
    return rows;
}

} // namespace error_vs_time

#include "machine.hpp"
#include "with_knobs.hpp"
#include <common/homes_machine.hpp>
#include <common/machine.hpp>
#include <algorithm>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/basic_renderer.hpp>

namespace error_vs_time {

namespace {

/// The policies of `Lossless` on a machine with room for every setting, so that a setting's error is its own. Storage and channels are
/// limited while it runs. The storage that a setting needs on Mk2 is counted (peak_storage).
tilemesh::render::Setup roomy_facts(bool drops)
{
    auto setup = tilemesh::splat::setup_of<splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.holds = !drops;
    setup.sizes.storage = 100'000;                        // a tile has never held half of it
    setup.sizes.road = setup.sizes.beam = 8'192;          // the cold start of 250,000 records puts fewer into one channel
    setup.sizes.waiting = drops ? 0 : setup.sizes.road;
    return tilemesh::render::checked(setup);
}

class RoomyMachine final : public Machine {
    using P = splat::PoliciesOf<WithKnobs>;

public:
    RoomyMachine(scene::Map const& map, Setting const& setting, std::uint32_t threads)
        : setting_(setting), renderer_(map, roomy_facts(setting.limits.drop),
                                       {.threads = threads,
                                        .tile = {tile_width, tile_height},
                                        .hops = setting.limits.hops == 0 ? 0 : unbounded,
                                        .storage_slots = setting.limits.storage_slots},
                                       {})
    {
        renderer_.rules() = setting.rules;
    }
    void settle(splat::Camera const& first, splat::Camera const& second) override
    {
        renderer_.prepare(first.width, first.height);
        renderer_.mesh().broadcast<ParametersWithKnobs>().knobs = setting_.knobs;
        for (auto const* camera : {&first, &second, &first}) render(*camera);
        auto const n = setting_.limits.channel_slots;
        auto& mesh = renderer_.mesh();
        mesh.limit<splat::Road<P>>(n);
        mesh.limit<splat::Beam<P>>(n);
        if (!setting_.limits.drop) {
            mesh.limit<splat::Waiting<P, 0>>(n);
            mesh.limit<splat::Waiting<P, 1>>(n);
        }
        if (setting_.limits.hops != 0) mesh.program() = splat::frame_program<P>(setting_.limits.hops);
    }
    void render(splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    report::Image const& image() const override { return frame_.image; }
    report::FrameReport const& counters() const override { return frame_.report; }
    double modelled_ms() override { return bench::modelled_ms(renderer_.trace(), renderer_.mesh().grid()); }
    double host_ms() const override // without the list of losses, which belongs to the report
    {
        auto const& ms = frame_.report.host_ms;
        return ms.project + ms.route + ms.bloom + ms.composite + ms.picture;
    }

private:
    /// More hops than any frame takes. It is a bound that can be changed; a renderer without a bound does not look for late records.
    static constexpr std::uint32_t unbounded = 1u << 30;

    Setting setting_;
    tilemesh::render::FrameRenderer<P, tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>> renderer_;
    tilemesh::RenderedFrame frame_;
};

/// The program of homes, with homes for all records. It has no limit to lift while it settles: records do not move.
class Homes final : public Machine {
public:
    Homes(scene::Map const& map, Setting const& setting, std::uint32_t threads) : map_(map), setting_(setting), threads_(threads) {}
    void settle(splat::Camera const& first, splat::Camera const& second) override
    {
        tilemesh::Grid const grid{(first.width + tile_width - 1) / tile_width, (first.height + tile_height - 1) / tile_height};
        auto const homes = static_cast<std::uint32_t>((map_.gaussians.size() + grid.size() - 1) / grid.size());
        machine_ = bench::make_homes_machine(map_, {.held = setting_.limits.storage_slots != 0 ? setting_.limits.storage_slots : 100'000, // as above
                                                    .homes = std::max(homes, 1u),
                                                    .slots = setting_.limits.channel_slots,
                                                    .rules = setting_.rules,
                                                    .threads = threads_,
                                                    .grid = grid});
        for (auto const* camera : {&first, &second, &first}) render(*camera);
    }
    void render(splat::Camera const& camera) override { machine_->render(camera); }
    report::Image const& image() const override { return machine_->image(); }
    report::FrameReport const& counters() const override { return machine_->report(); }
    double modelled_ms() override { return bench::modelled_ms(machine_->trace(), machine_->setting().grid); }
    double host_ms() const override
    {
        auto const& ms = counters().host_ms;
        return ms.project + ms.route + ms.composite + ms.picture;
    }

private:
    scene::Map const& map_;
    Setting setting_;
    std::uint32_t threads_;
    std::unique_ptr<bench::HomesMachine> machine_;
};

} // namespace

std::unique_ptr<Machine> make_machine(scene::Map const& map, Setting const& setting, std::uint32_t threads)
{
    if (setting.limits.homes) return std::make_unique<Homes>(map, setting, threads);
    return std::make_unique<RoomyMachine>(map, setting, threads);
}

} // namespace error_vs_time

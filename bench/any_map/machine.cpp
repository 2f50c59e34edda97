#include "machine.hpp"
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/render/homes_renderer.hpp>

namespace any_map {

namespace {

using tilemesh::render::HomesChoice;
using Renderer = tilemesh::render::HomesRenderer<tilemesh::splat::homes::HostPolicies<>, tilemesh::Mesh,
                                                 tilemesh::Traced<tilemesh::AnyMachine>>;

HomesChoice choice_of(Setting const& setting)
{
    HomesChoice choice;
    choice.machine.sram_bytes = 1u << 30; // rows say what fits
    choice.model.arithmetic = tilemesh::splat::Arithmetic::precise; // because pictures are compared with the naive picture
    if (setting.homes != 0) choice.sizes.homes = setting.homes;
    if (setting.held != 0) choice.sizes.held = setting.held;
    if (setting.slots != 0) choice.sizes.parcels = choice.sizes.waiting = setting.slots;
    return choice;
}

class Machine final : public HomesMachine {
public:
    Machine(tilemesh::scene::Map const& map, Setting const& setting, HomesChoice const& choice)
        : setting_(setting), renderer_(map, choice, options_of(setting))
    {
        setting_.homes = choice.sizes.homes;
        setting_.held = choice.sizes.held;
        setting_.slots = choice.sizes.parcels;
    }
    void render(tilemesh::splat::Camera const& camera) override { renderer_.render_into(camera, frame_); }
    tilemesh::report::Image const& image() const override { return frame_.image; }
    tilemesh::report::FrameReport const& report() const override { return frame_.report; }
    tilemesh::Trace const& trace() const override { return renderer_.trace(); }
    Setting const& setting() const override { return setting_; }
    std::uint64_t sram_bytes() const override { return renderer_.facts().sram_bytes; }

private:
    static tilemesh::RendererOptions options_of(Setting const& setting)
    {
        tilemesh::RendererOptions options;
        options.threads = setting.threads;
        options.grid = {setting.grid.width, setting.grid.height};
        options.fold = setting.folded;
        return options;
    }

    Setting setting_;
    Renderer renderer_;
    tilemesh::RenderedFrame frame_;
};

} // namespace

std::unique_ptr<HomesMachine> make_homes_machine(tilemesh::scene::Map const& map, Setting const& setting)
{
    return std::make_unique<Machine>(map, setting, choice_of(setting));
}

} // namespace any_map

// Renderers that run out of memory.
#include "../splat/runner.hpp"
#include "cloud.hpp"
#include "failing.hpp"

namespace {

using namespace torture;

/// The bits of a picture and of its planes, and the list of losses.
std::string bits(RenderedFrame const& frame)
{
    std::string out;
    for (auto const* plane : {&frame.image.rgb, &frame.depth.values, &frame.alpha.values})
        out.append(reinterpret_cast<char const*>(plane->data()), plane->size() * sizeof(float));
    for (auto const& loss : frame.report.lost)
        out.append(" ").append(std::to_string(static_cast<std::uint32_t>(loss.id))).append(report::to_string(loss.cause));
    return out;
}

using Render = std::function<void(splat::Camera const&, RenderedFrame&)>;
using MakeRenderer = std::function<Render()>;

template <class R>
MakeRenderer renderer_of(RendererOptions o)
{
    return [o] {
        auto renderer = std::make_shared<R>(cloud(), o);
        return Render([renderer](splat::Camera const& camera, RenderedFrame& frame) { renderer->render_into(camera, frame); });
    };
}
template <class S, template <class, class> class Engine = Mesh>
MakeRenderer runner_of(RendererOptions o)
{
    return [o] {
        auto runner = std::shared_ptr<support::Runner>(support::make_runner<S, Engine>(cloud(), o));
        return Render([runner](splat::Camera const& camera, RenderedFrame& frame) { runner->render_into(camera, frame); });
    };
}

/// Makes a renderer and renders its first frame.
class ColdStart : public Act {
public:
    explicit ColdStart(MakeRenderer make) : make_(std::move(make)) {}
    void act() override
    {
        auto const render = make_();
        render(views()[0], frame_);
    }
    std::string result() override { return bits(frame_); }

private:
    MakeRenderer make_;
    RenderedFrame frame_;
};

/// A renderer that has shown one view shows the next one. After a failure it shows that view as a new renderer does, then others.
class NextView : public Act {
public:
    explicit NextView(MakeRenderer const& make, std::size_t view = 1) : make_(make), render_(make()), view_(view) { render_(views()[0], frame_); }
    void act() override { render_(views()[view_], frame_); }
    std::string result() override { return bits(frame_); }
    std::string after_failure(std::string const& right) override
    {
        auto const fresh = make_();
        for (auto const view : {view_, std::size_t{2}, view_}) {
            RenderedFrame expected;
            fresh(views()[view], expected);
            render_(views()[view], frame_);
            if (bits(frame_) != bits(expected)) return "view " + std::to_string(view) + " is not a new renderer's";
            if (expected.report.lost.empty() && view == view_ && bits(expected) != right) return "a new renderer has another picture";
        }
        return {};
    }

private:
    MakeRenderer make_;
    Render render_;
    std::size_t view_;
    RenderedFrame frame_;
};

std::vector<Case> both(std::string const& name, MakeRenderer const& make)
{
    return {{name + ": cold start", [make] { return std::make_unique<ColdStart>(make); }},
            {name + ": next view", [make] { return std::make_unique<NextView>(make); }}};
}

} // namespace

TEST_SUITE_BEGIN("torture");

TEST_CASE("a renderer without memory throws, and then renders the right picture: on both engines, with full tiles, a trace, or no routing")
{
    auto full = options();
    full.storage_slots = 5;
    std::pair<char const*, MakeRenderer> const renderers[] = {{"Mesh", renderer_of<Renderer>(options())},
                                                              {"Mesh, 3 threads", renderer_of<Renderer>(options(3))},
                                                              {"Mesh, storage for 5", renderer_of<Renderer>(full)},
                                                              {"Mesh, traced, 2 threads", renderer_of<WatchedRenderer>(options(2))},
                                                              {"Mesh, no routing", runner_of<splat::Referenced<support::NoRouting>>(options())},
                                                              {"CheckedMesh", runner_of<support::Whole, CheckedMesh>(options())}};
    for (auto const& [name, make] : renderers) torture::torture(both(name, make));
    torture::torture({{"Mesh: the same view again", [] { return std::make_unique<NextView>(renderer_of<Renderer>(options()), 0); }}});
}

TEST_CASE("a renderer that gets no thread says so")
{
    if (!has_threads_that_fail()) return;
    torture::torture({{"Mesh, 3 threads: no thread", [] { return std::make_unique<ColdStart>(renderer_of<Renderer>(options(3))); }, What::thread}});
}

TEST_CASE("an observer that throws leaves a renderer that renders the right picture")
{
    Renderer renderer(cloud(), options()), fresh(cloud(), options());
    (void)renderer.render(views()[0]);
    bool throws = true;
    renderer.observe([&](SuperstepEvent const&) {
        if (throws) throw Error("stopped (by the observer); go on");
    });
    CHECK_THROWS_AS((void)renderer.render(views()[1]), Error);
    throws = false;
    CHECK(bits(renderer.render(views()[1])) == bits(fresh.render(views()[1])));
}

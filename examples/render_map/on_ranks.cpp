#include "process.hpp"
#include "rank_renderer.hpp"
#include "ranks.hpp"
#include <cstddef>
#include <exception>
#include <mpi.h>
#include <tilemesh/error.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace render_map {

namespace {

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using tilemesh::mpi::detail::Ranks;

std::unique_ptr<Ranks> all; ///< between `begin` and `end`
std::uint32_t here = 1;     ///< processes on this host

/// What the first process tells the others to do.
enum class Order : std::uint32_t { end, make, render, drop };
struct Command {
    Order order = Order::end;
    int status = 0;        ///< end
    splat::Camera camera{}; ///< render
    splat::Model model{};
};
/// What all processes need to make the same renderer, besides the map.
struct Plan {
    Choice choice;
    tilemesh::RendererOptions options;
    std::uint64_t culled = 0;
    std::uint32_t sh_degree = 0; ///< of the demand
    std::uint32_t map_degree = 0;
    bool moves = true, spans = true;
};
static_assert(std::is_trivially_copyable_v<Command> && std::is_trivially_copyable_v<Plan>, "processes send them as bytes");

/// Every process gets the object of the first one.
template <class T>
void share(T& object)
{
    MPI_Bcast(&object, static_cast<int>(sizeof object), MPI_BYTE, 0, all->comm());
}

MakeRankRenderer& maker_of(Choice const& choice, tilemesh::render::SetupChoice const& setup)
{
    if (!setup.routes && !setup.blooms) return on_ranks_placed_unspread;
    if (!setup.routes) return setup.sh_degree == 0 ? on_ranks_placed : on_ranks_placed_shaded;
    if (choice.planes()) return setup.sh_degree == 0 ? on_ranks_planes : on_ranks_shaded_planes;
    return setup.sh_degree == 0 ? on_ranks_plain : on_ranks_shaded;
}

/// Makes the renderer of a plan in all processes. The first one has the map and the views.
std::unique_ptr<AnyRenderer> make_in_all(Plan plan, scene::Map map, std::vector<std::uint64_t> views)
{
    share(plan);
    all->share(map.gaussians);
    all->share(map.harmonics);
    all->share(views);
    map.sh_degree = plan.map_degree;
    std::unique_ptr<AnyRenderer> renderer;
    all->together([&] {
        scene::Demand demand;
        demand.sh_degree = plan.sh_degree;
        demand.moves = plan.moves;
        demand.spans = plan.spans;
        demand.culled = plan.culled;
        demand.scanned = std::move(views);
        auto const setup = setup_for(plan.choice, demand);
        renderer = maker_of(plan.choice, setup)(map, tilemesh::render::facts_of(setup), plan.options, all->comm());
        renderer->hold_to(demand);
    });
    return renderer;
}

/// The renderer of the first process. For each frame it gives the others an order first.
class RanksRenderer final : public AnyRenderer {
public:
    explicit RanksRenderer(std::unique_ptr<AnyRenderer> own) : own_(std::move(own)) {}
    ~RanksRenderer() override
    {
        Command command{Order::drop};
        share(command);
        own_.reset();
    }
    RanksRenderer(RanksRenderer const&) = delete;
    RanksRenderer& operator=(RanksRenderer const&) = delete;

    tilemesh::RenderedFrame render(splat::Camera const& camera) override
    {
        Command command{Order::render, 0, camera, own_->model()};
        share(command);
        return own_->render(camera);
    }
    splat::Model& model() override { return own_->model(); }
    void hold_to(scene::Demand const&) override {} // all processes have done that
    tilemesh::Extent2 grid() override { return own_->grid(); }
    tilemesh::Extent2 tile() override { return own_->tile(); }
    tilemesh::render::SetupFacts const& facts() const override { return own_->facts(); }
    bool routes() const override { return own_->routes(); }
    bool blooms() const override { return own_->blooms(); }

private:
    std::unique_ptr<AnyRenderer> own_;
};

/// Obeys the first process until its end. An Error of a frame is the first process's Error, too, which reports it.
int serve()
{
    std::unique_ptr<AnyRenderer> renderer;
    for (;;) {
        Command command;
        share(command);
        try {
            switch (command.order) {
            case Order::end:
                return command.status;
            case Order::make:
                renderer = make_in_all({}, {}, {});
                break;
            case Order::render:
                renderer->model() = command.model;
                renderer->render(command.camera);
                break;
            case Order::drop:
                renderer.reset();
            }
        } catch (tilemesh::Error const&) {
        }
    }
}

} // namespace

std::optional<int> ranks::begin(int& argc, char**& argv)
{
    int level = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    all = std::make_unique<Ranks>(MPI_COMM_WORLD);
    MPI_Comm host = MPI_COMM_NULL;
    MPI_Comm_split_type(all->comm(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
    int size = 1;
    MPI_Comm_size(host, &size);
    here = static_cast<std::uint32_t>(size);
    MPI_Comm_free(&host);
    if (all->rank() == 0) return {};
    int status = 2;
    try {
        status = serve();
    } catch (...) { // not in step with the other processes
        MPI_Abort(MPI_COMM_WORLD, refuse_for_memory());
    }
    all.reset();
    MPI_Finalize();
    return status;
}

int ranks::end(int status)
{
    Command command{Order::end, status};
    share(command);
    all.reset();
    MPI_Finalize();
    return status;
}

std::uint32_t ranks::number() noexcept
{
    return all ? all->size() : 1;
}
std::uint32_t ranks::on_this_host() noexcept
{
    return here;
}

std::unique_ptr<AnyRenderer> ranks::make(Choice const& choice, scene::Map needed, scene::Demand const& demand,
                                         tilemesh::RendererOptions const& options)
{
    Command command{Order::make};
    share(command);
    auto const degree = needed.sh_degree;
    return std::make_unique<RanksRenderer>(
        make_in_all({choice, options, demand.culled, demand.sh_degree, degree, demand.moves, demand.spans}, std::move(needed), demand.scanned));
}

} // namespace render_map

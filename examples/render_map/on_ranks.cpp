#include "../shared/process.hpp"
#include "rank_renderer.hpp"
#include "ranks.hpp"
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <list>
#include <memory>
#include <mpi.h>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/records.hpp>
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

/// What this process has of the map, and what of it the views show.
scene::Map part;
scene::Demand seen;
std::uint64_t rows_of_all = 0;
/// The renderers of the processes that serve, by number: `auto` makes a second one.
std::unique_ptr<tilemesh::render::Core> renderers[2];

/// What the first process tells the others to do.
enum class Order : std::uint32_t { end, load, send_outline, cut, scan, make, render, drop };
struct Command {
    Order order = Order::end;
    std::uint32_t number = 0; ///< of the renderer; cut: the degree
    int status = 0;           ///< end
    splat::Camera camera{};   ///< render
    splat::Rules rules{};     ///< render, scan
    tilemesh::RendererOptions options{}; ///< scan
};
/// What all processes need to load a map.
struct Load {
    bool in_parts = false; ///< each reads its share of one PLY; otherwise the first process has all rows
    std::optional<scene::Turn> turn;
    std::uint32_t sh_degree = 0;
};
/// What all processes need to make the same renderer, besides the map.
struct Plan {
    tilemesh::render::Setup setup{}; ///< its names follow
    tilemesh::RendererOptions options{};
    bool all_visible = false; ///< of the demand: every row may be visible
    std::uint64_t culled = 0;
    std::uint32_t sh_degree = 0;
    bool moves = true, spans = true;
};
static_assert(std::is_trivially_copyable_v<Command> && std::is_trivially_copyable_v<Plan> && std::is_trivially_copyable_v<Load>,
              "processes send them as bytes");

/// Every process gets the object of the first one.
template <class T>
void share(T& object)
{
    MPI_Bcast(&object, static_cast<int>(sizeof object), MPI_BYTE, 0, all->comm());
}

MakeRankRenderer& maker_of(tilemesh::render::Setup const& setup)
{
    if (!setup.routes && !setup.blooms) return on_ranks_placed_unspread;
    if (!setup.routes) return setup.sh_degree == 0 ? on_ranks_placed : on_ranks_placed_shaded;
    if (setup.has_planes()) return setup.sh_degree == 0 ? on_ranks_planes : on_ranks_shaded_planes;
    return setup.sh_degree == 0 ? on_ranks_plain : on_ranks_shaded;
}

/// The first process gets the lines of all.
std::vector<std::string> join_lines(std::vector<std::string> const& lines)
{
    std::vector<char> text;
    all->together([&] {
        for (auto const& line : lines) {
            text.insert(text.end(), line.begin(), line.end());
            text.push_back('\n');
        }
    });
    all->join(text);
    std::vector<std::string> joined;
    for (auto from = text.begin(); from != text.end();) {
        auto const end = std::find(from, text.end(), '\n');
        joined.emplace_back(from, end);
        from = end + 1;
    }
    return joined;
}

/// Gives every process an equal share of the rows of the first one's map.
void scatter(scene::Map& map)
{
    auto const floats = 3 * std::size_t{splat::harmonics_per_channel(map.sh_degree)};
    std::vector<std::uint64_t> counts, coefficients;
    all->together([&] {
        std::uint64_t const rows = map.gaussians.size();
        for (std::uint64_t p = 0; p < all->size(); ++p) {
            counts.push_back(rows * (p + 1) / all->size() - rows * p / all->size());
            coefficients.push_back(counts.back() * floats);
        }
    });
    map.gaussians = all->deal(std::move(map.gaussians), counts);
    map.harmonics = all->deal(std::move(map.harmonics), coefficients);
}

/// Loads the map into all processes. The first has the path, and its own part or, if the map is not read in parts, all rows.
scene::MapPart load_in_all(Load load, std::vector<char> path, scene::MapPart mine)
{
    share(load);
    all->share(path);
    auto& map = mine.map;
    map.sh_degree = load.sh_degree;
    if (load.in_parts) {
        all->together([&] {
            if (all->rank() == 0) return;
            auto read = scene::load_ply_part(std::string(path.begin(), path.end()), all->rank(), all->size());
            if (!read || read->map.sh_degree != load.sh_degree)
                throw tilemesh::Error(std::string(path.begin(), path.end()) + " is another file on another host (its header differs); copy it to "
                                                                              "all hosts");
            mine = std::move(*read);
        });
    } else {
        scatter(map);
    }
    all->together([&] {
        if (load.turn) map = scene::turned(std::move(map), *load.turn);
    });
    mine.rejected = join_lines(mine.rejected);
    std::uint64_t words[] = {map.gaussians.size(), map.rejected};
    all->sum(words, 2);
    rows_of_all = words[0];
    map.rejected = words[1];
    return mine;
}

/// The outline of all parts, in the first process.
Outline send_outline()
{
    Outline outline;
    all->together([&] {
        for (auto const& g : part.gaussians) {
            outline.gaussians.push_back({});
            std::copy_n(g.mean_world, 3, outline.gaussians.back().mean_world);
            std::copy_n(g.log_scale, 3, outline.gaussians.back().log_scale);
        }
    });
    all->join(outline.gaussians);
    return outline;
}

void scan(std::vector<splat::Camera> path, splat::Rules const& rules, tilemesh::RendererOptions const& options)
{
    all->share(path);
    seen = scene::demand_of(
        part, std::span<splat::Camera const>(path), rules,
        [&](splat::Camera const& camera) { return tilemesh::tiling_for(options, camera.width, camera.height); }, *all);
}

/// Makes the renderer of a plan in all processes. The first one has the views.
std::unique_ptr<tilemesh::render::Core> make_in_all(Plan plan, std::vector<std::uint64_t> views)
{
    share(plan);
    static std::list<std::vector<char>> all_names; // of the setups; each ends with 0
    auto& names = all_names.emplace_back();
    if (all->rank() == 0)
        for (std::string_view const name : {plan.setup.name, plan.setup.machine.name}) {
            names.insert(names.end(), name.begin(), name.end());
            names.push_back('\0');
        }
    all->share(names);
    plan.setup.name = names.data();
    plan.setup.machine.name = names.data() + std::string_view(names.data()).size() + 1;
    all->share(views);
    std::unique_ptr<tilemesh::render::Core> renderer;
    all->together([&] {
        scene::Demand demand;
        demand.gaussians = part.gaussians.size(); // for `needed`, which looks at one part
        demand.sh_degree = plan.sh_degree;
        demand.moves = plan.moves;
        demand.spans = plan.spans;
        demand.culled = plan.culled;
        if (!plan.all_visible) demand.visible = seen.visible;
        auto const map = scene::needed(part, demand);
        demand.gaussians = rows_of_all;
        demand.scanned = std::move(views);
        plan.options.rows_of_all_parts = static_cast<std::uint32_t>(rows_of_all - plan.culled);
        auto const& setup = plan.setup;
        if (setup.program == splat::Program::homes) {
            auto& make = setup.sh_degree == 0 && !setup.has_planes() ? homes_on_ranks_plain : homes_on_ranks_any;
            renderer = make(map, setup, plan.options, all->comm());
        } else {
            renderer = maker_of(setup)(map, tilemesh::render::checked(setup), plan.options, all->comm());
        }
        renderer->hold_to(demand);
    });
    return renderer;
}

/// The core of the first process. For each frame it gives the others an order first. All processes hold their own to the demand.
class OrderingCore final : public tilemesh::render::Core {
public:
    OrderingCore(std::unique_ptr<tilemesh::render::Core> own, std::uint32_t number) : own_(std::move(own)), number_(number) {}
    ~OrderingCore() override
    {
        Command command{.order = Order::drop, .number = number_};
        share(command);
        own_.reset();
    }

    void render_into(splat::Camera const& camera, tilemesh::RenderedFrame& frame) override
    {
        Command command{.order = Order::render, .number = number_, .camera = camera, .rules = own_->rules()};
        share(command);
        own_->render_into(camera, frame);
    }
    void observe(tilemesh::Observer observer) override { own_->observe(std::move(observer)); } // of this process's part
    void require_idle() const override { own_->require_idle(); }
    splat::Rules& rules() override { return own_->rules(); }
    scene::Map const& map() const override { return own_->map(); } // this process's share
    tilemesh::Extent2 grid() override { return own_->grid(); }
    tilemesh::Extent2 tile() override { return own_->tile(); }
    tilemesh::render::Setup const& setup() const override { return own_->setup(); }

private:
    std::unique_ptr<tilemesh::render::Core> own_;
    std::uint32_t number_;
};

/// Obeys the first process until its end. An Error of a frame is the first process's Error, too, which reports it.
int serve()
{
    for (;;) {
        Command command;
        share(command);
        auto& renderer = renderers[command.number % 2];
        try {
            switch (command.order) {
            case Order::end:
                for (auto& each : renderers) each.reset();
                return command.status;
            case Order::load:
                part = load_in_all({}, {}, {}).map;
                break;
            case Order::send_outline:
                send_outline();
                break;
            case Order::cut:
                part = scene::at_degree(std::move(part), command.number);
                break;
            case Order::scan:
                scan({}, command.rules, command.options);
                break;
            case Order::make:
                renderer = make_in_all({}, {});
                break;
            case Order::render:
                renderer->rules() = command.rules;
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
        MPI_Abort(MPI_COMM_WORLD, shared::refuse_for_memory());
    }
    all.reset();
    MPI_Finalize();
    return status;
}

int ranks::end(int status)
{
    Command command{.order = Order::end, .status = status};
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

namespace {

class AllParts final : public ranks::Parts {
public:
    scene::Map load(Options const& options, std::function<scene::Map()> const& load_all) override
    {
        // An error of the first process comes before the others begin: it is that of one process.
        std::optional<scene::MapPart> mine;
        std::vector<char> path;
        std::error_code unknown; // then `load_all` says what is wrong
        if (options.maps.size() == 1 && std::filesystem::is_regular_file(options.maps[0], unknown)) {
            auto const text = options.maps[0].string();
            path.assign(text.begin(), text.end());
            mine = scene::load_ply_part(options.maps[0], 0, all->size());
            // Far means are moved by one origin, which needs the whole map.
            if (mine && scene::has_far_means(mine->map)) mine.reset();
        }
        bool const in_parts = mine.has_value();
        if (!in_parts) mine.emplace().map = load_all();
        Command command{.order = Order::load};
        share(command);
        auto const degree = mine->map.sh_degree;
        auto joined = load_in_all({in_parts, options.turn, degree}, std::move(path), std::move(*mine));
        auto map = in_parts ? scene::with_all_notes(std::move(joined)) : std::move(joined.map); // `load_all` has written all notes
        scene::Map described{map.name, map.path, {}, map.sh_degree, {}, map.rejected, map.notes, map.origin};
        part = std::move(map);
        part.notes.clear();
        return described;
    }
    std::uint64_t gaussians() override { return rows_of_all; }
    MapShape shape_of(std::string name) override
    {
        auto const outline = [had = std::make_shared<std::optional<Outline>>()]() -> Outline const& {
            if (*had) return **had;
            Command command{.order = Order::send_outline};
            share(command);
            return had->emplace(send_outline());
        };
        return {std::move(name), [outline] { return scene::robust_centre(outline()); },
                [outline](scene::Size size, glm::dvec3 up, double degrees) { return scene::frame_whole(outline(), size, up, degrees); },
                [outline](splat::Camera const& camera) { return scene::near_for(outline(), camera); }};
    }
    void at_degree(std::uint32_t degree) override
    {
        Command command{.order = Order::cut, .number = degree};
        share(command);
        part = scene::at_degree(std::move(part), degree);
    }
    scene::Demand demand_of(std::vector<splat::Camera> const& path, splat::Rules const& rules, tilemesh::RendererOptions const& options) override
    {
        Command command{.order = Order::scan, .rules = rules, .options = options};
        share(command);
        scan(path, rules, options);
        return seen;
    }
    std::unique_ptr<tilemesh::render::Core> make(tilemesh::report::Program program, Choice const& choice, scene::Demand const& demand,
                                                 tilemesh::RendererOptions const& options) override
    {
        bool const homes = program == tilemesh::report::Program::homes;
        Command command{.order = Order::make, .number = homes ? 1u : 0u};
        Plan plan{homes ? homes_of(choice, std::min(demand.sh_degree, part.sh_degree)) : setup_for(choice, demand), options, demand.visible.empty(),
                  demand.culled, demand.sh_degree, demand.moves, demand.spans};
        share(command);
        return std::make_unique<OrderingCore>(make_in_all(plan, demand.scanned), command.number);
    }
};

} // namespace

ranks::Parts& ranks::parts()
{
    static AllParts parts;
    return parts;
}

} // namespace render_map

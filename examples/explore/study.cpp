#include "study.hpp"
#include "../shared/input_rows.hpp"
#include "../shared/model_input.hpp"
#include "../shared/option_json.hpp"
#include "../shared/sha256.hpp"
#include "../shared/text.hpp"
#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/scene/orbit.hpp>

namespace explore {

namespace {

namespace fs = std::filesystem;
namespace scene = tilemesh::scene;
using Json = nlohmann::ordered_json;
using tilemesh::Error;

constexpr std::size_t most_points = 100'000;

std::string shown(std::string const& text) { return "\"" + shared::one_line(text, 60) + "\""; }
std::string text_of(fs::path const& path) { return shared::load_model<std::string>(path, [](std::istream& in, std::string const&) {
    return std::string(std::istreambuf_iterator<char>(in), {});
}, "study's file", "name a file that is there"); }

/// A value of a study with its place, for errors.
class Value {
public:
    Value(Json const& json, std::string place) : json_(&json), place_(std::move(place)) {}

    [[noreturn]] void refuse(std::string const& why, std::string const& todo) const
    {
        throw Error("the study cannot be used (" + place_ + " " + why + "); " + todo);
    }
    bool is_text() const { return json_->is_string(); }
    bool is_list() const { return json_->is_array(); }
    bool is_object() const { return json_->is_object(); }
    std::string dumped() const { return json_->dump(); }
    std::string text() const
    {
        if (!is_text()) refuse("is no text", "write a text");
        return json_->get<std::string>();
    }
    std::uint32_t whole(std::uint32_t least, std::uint32_t most) const
    {
        bool const good = json_->is_number_integer() && *json_ >= least && *json_ <= most;
        if (!good) refuse("is no whole number from " + std::to_string(least) + " to " + std::to_string(most), "write one");
        return json_->get<std::uint32_t>();
    }
    double number() const
    {
        if (!json_->is_number()) refuse("is no number", "write a number");
        return json_->get<double>();
    }
    /// The words of a value of a machine or a model: 4, "147/10", "unknown".
    std::string words() const
    {
        if (json_->is_string()) return json_->get<std::string>();
        if (!json_->is_number_unsigned()) refuse("is no whole number and no text", "write 4, \"147/10\" or \"unknown\"");
        return std::to_string(json_->get<std::uint64_t>());
    }
    /// The values of a list, or this one.
    std::vector<Value> all() const
    {
        if (!is_list()) return {*this};
        std::vector<Value> out;
        for (std::size_t i = 0; i < json_->size(); ++i) out.emplace_back((*json_)[i], place_ + "[" + std::to_string(i) + "]");
        if (out.empty()) refuse("is an empty list", "give it a value, or leave it out");
        return out;
    }
    std::optional<Value> get(std::string const& key) const
    {
        auto const at = json_->find(key);
        if (at == json_->end()) return {};
        return Value(*at, place_ == "it" ? key : place_ + "." + key);
    }
    /// Refuses every key but these. `any`: an error lists them.
    void allow(std::initializer_list<char const*> keys) const
    {
        if (!is_object()) refuse("is no object", "write {...}");
        for (auto const& [key, value] : json_->items())
            if (std::none_of(keys.begin(), keys.end(), [&k = key](char const* known) { return k == known; }))
                refuse_key(key, {keys.begin(), keys.end()});
    }
    [[noreturn]] void refuse_key(std::string const& key, std::vector<std::string_view> const& known) const
    {
        std::string list;
        for (auto const name : known) list.append(list.empty() ? "" : ", ").append(name);
        auto const near = shared::nearest(key, known);
        refuse("has an unknown key " + shown(key), near.empty() ? "use " + list : "use " + std::string(near) + ", or another of " + list);
    }
    /// Sets the option that a row describes.
    template <class Of>
    void set(Of& of, shared::Option<Of> const& row) const
    {
        try {
            set_from_json(of, row, *json_);
        } catch (shared::Misfit const& misfit) {
            refuse("cannot be " + shown(json_->is_string() ? json_->get<std::string>() : json_->is_structured() ? json_->type_name() : json_->dump()),
                   "write another value: " + misfit.why);
        }
    }
    std::vector<std::pair<std::string, Value>> members() const
    {
        if (!is_object()) refuse("is no object", "write {...}");
        std::vector<std::pair<std::string, Value>> out;
        for (auto const& [key, value] : json_->items()) out.emplace_back(key, Value(value, place_ + "." + key));
        return out;
    }

private:
    Json const* json_;
    std::string place_;
};

/// Each choice of one value for every key: the last key changes fastest.
using Choice = std::vector<std::pair<std::string, Value>>;
std::vector<Choice> product(std::vector<std::pair<std::string, Value>> const& members, Value const& where)
{
    std::vector<Choice> out{{}};
    for (auto const& [key, value] : members) {
        std::vector<Choice> longer;
        auto const values = value.all();
        if (out.size() * values.size() > most_points) where.refuse("has more than 100,000 combinations", "shorten its lists");
        for (auto const& choice : out)
            for (auto const& one : values) {
                longer.push_back(choice);
                longer.back().emplace_back(key, one);
            }
        out = std::move(longer);
    }
    return out;
}

/// Reads a study. Relative paths begin at its folder, or at the one that it names.
class Reader {
public:
    explicit Reader(fs::path const& path) : folder_(path.parent_path()) { study_.read.push_back(path); }

    Study read(Value const& all)
    {
        all.allow({"name", "folder", "maps", "size", "views", "machines", "grid", "programs", "presets", "policies", "qualities", "sizes", "costs"});
        study_.name = all.get("name") ? all.get("name")->text() : study_.read.front().stem().string();
        if (auto const folder = all.get("folder")) folder_ /= folder->text();
        if (auto const size = all.get("size")) size_ = pair_of(*size);
        if (auto const views = all.get("views")) read_views(*views);
        if (auto const grid = all.get("grid")) grid_ = tilemesh::Extent2{pair_of(*grid).width, pair_of(*grid).height};
        std::vector<std::shared_ptr<Subject const>> subjects;
        if (auto const maps = all.get("maps"))
            for (auto const& map : maps->all()) subjects.push_back(subject(map));
        else subjects.push_back(subject("built-in", "built-in", views_));
        auto const machines_of = all.get("machines");
        if (!machines_of) all.refuse("has no machines", "add \"machines\": [\"mk2.txt\"]");
        for (auto const& value : machines_of->all()) add_machines(value);
        std::vector<std::string> programs{"anchored"}, presets{"lossless"}, qualities{"default"};
        words(all, "programs", programs, values_of("program").words.first(2));
        words(all, "presets", presets, values_of("preset").words);
        words(all, "qualities", qualities, values_of("quality").words);
        std::vector<Policies> policies{{}};
        if (auto const values = all.get("policies")) policies = policies_of(*values);
        std::vector<Capacities> sizes;
        if (auto const values = all.get("sizes"))
            for (auto const& value : values->all()) add_sizes(value, sizes);
        else sizes.push_back({"preset", true, {}, {}});
        std::vector<std::shared_ptr<Prices const>> prices;
        if (auto const values = all.get("costs"))
            for (auto const& value : values->all()) add_prices(value, prices);
        else prices.push_back(std::make_shared<Prices const>());

        if (subjects.size() * machines_.size() * programs.size() * presets.size() * policies.size() * qualities.size() * sizes.size() * prices.size() > most_points)
            all.refuse("has more than 100,000 points", "shorten its lists");
        for (auto const& of : subjects)
            for (auto const& machine : machines_)
                for (auto const& program : programs)
                    for (auto const& preset : presets)
                        for (auto const& policy : policies)
                            for (auto const& quality : qualities)
                                for (auto const& capacities : sizes)
                                    for (auto const& price : prices) {
                                        Setting s;
                                        auto const part = [&](std::string const& text, bool differs) {
                                            if (differs && !text.empty()) s.name += (s.name.empty() ? "" : " / ") + text;
                                        };
                                        part(of->name, subjects.size() > 1);
                                        part(machine->name, true);
                                        part(program, programs.size() > 1);
                                        part(preset, presets.size() > 1);
                                        part(policy.name, policies.size() > 1);
                                        part(quality, qualities.size() > 1);
                                        part(capacities.name, sizes.size() > 1);
                                        part(price->name, prices.size() > 1);
                                        s.subject = of;
                                        s.machine = machine;
                                        s.grid = grid_.value_or(grid_of_machine(*machine, *machines_of));
                                        s.homes = program == "homes";
                                        s.preset = preset;
                                        s.policies = policy.values;
                                        if (quality != "default")
                                            s.quality = static_cast<tilemesh::splat::Quality>(static_cast<std::uint32_t>(*values_of("quality").read(quality)));
                                        s.capacities = capacities;
                                        s.prices = price;
                                        study_.settings.push_back(std::move(s));
                                    }
        std::set<std::string> names;
        for (auto const& s : study_.settings)
            if (!names.insert(s.name).second) all.refuse("has two points " + shown(s.name), "give their parts other names");
        return std::move(study_);
    }

private:
    fs::path file(std::string const& name)
    {
        auto path = fs::path(name).is_absolute() ? fs::path(name) : folder_ / name;
        if (std::find(study_.read.begin(), study_.read.end(), path) == study_.read.end()) study_.read.push_back(path);
        return path;
    }
    static scene::Size pair_of(Value const& value)
    {
        auto const two = value.all();
        if (!value.is_list() || two.size() != 2) value.refuse("is no list of two numbers", "write [640, 360]");
        return {two[0].whole(1, 65535), two[1].whole(1, 65535)};
    }
    static tilemesh::render::Values const& values_of(std::string_view field) { return tilemesh::render::find_setup_field(field)->values; }
    static void words(Value const& all, char const* key, std::vector<std::string>& to, std::span<shared::Word const> known)
    {
        auto const values = all.get(key);
        if (!values) return;
        to.clear();
        std::string list;
        for (auto const& one : known) list.append(list.empty() ? "" : ", ").append(one.word);
        for (auto const& value : values->all()) {
            to.push_back(value.text());
            if (std::none_of(known.begin(), known.end(), [&](auto const& one) { return to.back() == one.word; }))
                value.refuse("cannot be " + shown(to.back()), "use " + list);
        }
    }
    struct Policies {
        std::string name;
        std::vector<tilemesh::render::SetupValue> values;
    };
    /// Each combination of values of the fields that every program has.
    static std::vector<Policies> policies_of(Value const& value)
    {
        std::vector<Policies> out;
        for (auto const& choice : product(value.members(), value)) {
            auto& policy = out.emplace_back();
            for (auto const& [key, one] : choice) {
                auto const* const field = tilemesh::render::find_setup_field(key);
                if (field == nullptr || field->use != tilemesh::render::SetupField::everyone) {
                    std::vector<std::string_view> known;
                    for (auto const& other : tilemesh::render::setup_fields)
                        if (other.use == tilemesh::render::SetupField::everyone) known.push_back(other.name);
                    value.refuse_key(key, known);
                }
                auto const text = one.is_text() ? one.text() : one.dumped();
                if (!field->values.read(text)) one.refuse("cannot be " + shown(text), "write another value: " + field->values.takes());
                policy.values.emplace_back(field->name, text);
                policy.name += (policy.name.empty() ? "" : " ") + key + " " + text;
            }
        }
        return out;
    }
    /// How a map is read, and which camera shows it: the rows of render_map's options.
    struct View : shared::MapInput, shared::CameraInput {
        std::string words; ///< what was set, but for the cameras
        View() { bends = true; }
    };
    static constexpr std::pair<char const*, char const*> no_keys[] = {{"list", "render_map --list prints names"},
                                                                      {"size", "all maps of a study have its size"},
                                                                      {"scale", "all maps of a study have its size"}};
    /// Those of `before`, but for what the value names. `others`: the value's other keys.
    static View view_of(Value const& value, View before, std::initializer_list<char const*> others)
    {
        auto known = std::vector<std::string_view>(others.begin(), others.end());
        auto const is_key = [&](shared::OptionRow const& row) {
            return std::none_of(std::begin(no_keys), std::end(no_keys), [&](auto const& no) { return row.name == no.first; });
        };
        for (auto const& row : shared::map_rows) known.push_back(row.name);
        for (auto const& row : shared::camera_rows)
            if (is_key(row)) known.push_back(row.name);
        for (auto const& [key, one] : value.members()) {
            if (std::find(others.begin(), others.end(), key) != others.end()) continue;
            auto name = key;
            std::replace(name.begin(), name.end(), '_', '-');
            for (auto const& [no, why] : no_keys)
                if (name == no) one.refuse("is no key of a map", why);
            auto const* const of_map = shared::find_row(shared::map_rows, name);
            auto const* const of_camera = shared::find_row(shared::camera_rows, name);
            if (of_map != nullptr) one.set<shared::MapInput>(before, *of_map);
            else if (of_camera != nullptr) one.set<shared::CameraInput>(before, *of_camera);
            else value.refuse_key(key, known);
            if (name != "cameras" && name != "camera") before.words += " " + name + " " + one.dumped();
        }
        return before;
    }
    static void need_cameras(Value const& value, View const& view)
    {
        if (!view.camera.empty() && !view.cameras) value.refuse("has a camera without cameras", "add \"cameras\": \"FILE\"");
    }
    void read_views(Value const& views)
    {
        if (auto const n = views.get("frames")) frames_ = n->whole(1, 10'000);
        if (auto const d = views.get("degrees")) degrees_ = d->number();
        views_ = view_of(views, {}, {"frames", "degrees"});
        need_cameras(views, views_);
    }
    std::shared_ptr<Subject const> subject(Value const& map)
    {
        if (map.is_text()) return subject(map.text(), {}, views_);
        auto const of_file = map.is_object() ? map.get("file") : std::nullopt;
        auto const view = view_of(map, views_, {"file", "name"});
        if (!of_file) map.refuse("names no map", "write a file, or {\"file\": \"salad.ply\", \"cameras\": \"cameras.json\", \"camera\": \"front\"}");
        need_cameras(map, view);
        return subject(of_file->text(), map.get("name") ? map.get("name")->text() : "", view);
    }
    /// `name`: empty for that of the map's file.
    std::shared_ptr<Subject const> subject(std::string const& map, std::string const& name, View const& view)
    {
        auto out = std::make_shared<Subject>();
        scene::Size const size{size_.width, size_.height};
        bool const built_in = map == "built-in";
        std::vector<std::string> notes;
        std::vector<fs::path> maps;
        if (!built_in) maps.push_back(file(map));
        out->map = shared::at_degree(shared::load_maps(maps, view), view, notes);
        if (out->map.gaussians.empty()) throw Error(shared::one_line(map) + " has no Gaussian (there is nothing to render); name another map");
        out->antialias = view.antialias;
        auto const shape = shared::shape_of(out->map);
        tilemesh::splat::Camera first;
        std::string cameras_digest;
        if (!view.cameras) {
            first = shared::placed_camera(view, shape, size, built_in);
            out->view = view.from ? "a camera at a point" : built_in ? "the built-in map's camera" : "a guessed camera, along +z at the whole map";
        } else {
            auto of_study = view;
            of_study.cameras = file(view.cameras->string());
            auto const chosen = shared::load_cameras(of_study, shape, size, notes, study_.read).front();
            first = scene::resized(chosen.camera, size.width, size.height);
            out->view = "camera " + shared::one_line(label(chosen), 60) + " of " + shared::one_line(view.cameras->string(), 60);
            cameras_digest = shared::sha256(text_of(*of_study.cameras));
        }
        if (frames_ > 1) out->view += ", " + std::to_string(frames_) + " frames around the map's middle";
        out->name = !name.empty() ? name : built_in ? map : out->map.name;
        notes.insert(notes.begin(), out->map.notes.begin(), out->map.notes.end());
        for (auto const& note : notes)
            if (auto text = "map " + shared::one_line(out->name, 60) + ": " + shared::one_line(note);
                std::find(study_.notes.begin(), study_.notes.end(), text) == study_.notes.end())
                study_.notes.push_back(std::move(text));
        out->views = scene::orbit(first, scene::robust_centre(out->map), degrees_, frames_);
        out->key = (built_in ? map : shared::sha256(text_of(file(map)))) + " " + std::to_string(size.width) + " " + std::to_string(size.height) + " " +
                   std::to_string(frames_) + " " + std::to_string(degrees_) + " " + view.camera + " " + cameras_digest + view.words;
        return out;
    }
    void add_machines(Value const& value)
    {
        auto const load = [&](std::string const& name) {
            return shared::load_model(file(name), tilemesh::read_machine_file, "machine", "name a file as examples/machines/mk2.txt");
        };
        if (value.is_text()) return add_machine(load(value.text()));
        auto const of_file = value.is_object() ? value.get("file") : std::nullopt;
        if (!of_file) value.refuse("names no machine", "write a file, or {\"file\": \"mk2.txt\", \"sram\": 319488}");
        auto const base = load(of_file->text());
        std::vector<std::pair<std::string, Value>> changed;
        for (auto const& [key, one] : value.members())
            if (key != "file" && key != "name") changed.emplace_back(key, one);
        for (auto const& choice : product(changed, value)) {
            auto machine = base;
            if (auto const given = value.get("name")) machine.name = given->text();
            for (auto const& [key, one] : choice) {
                set_number(machine, key, one.words(), "guess: the study has it");
                if (!value.get("name") || value_has_list(changed)) machine.name += " " + key + " " + one.words();
            }
            note_guesses(machine, base);
            add_machine(std::move(machine));
        }
    }
    /// Guesses are for the size of their file's machine.
    void note_guesses(tilemesh::MachineFile const& machine, tilemesh::MachineFile const& base)
    {
        bool const other_size = machine.number("tiles").value != base.number("tiles").value ||
                                machine.number("columns").value != base.number("columns").value ||
                                machine.number("rows").value != base.number("rows").value;
        std::string guessed;
        for (std::string const name : {"barrier", "vote"})
            if (auto const& number = machine.number(name); other_size && number == base.number(name) && number.source.starts_with("guess"))
                guessed.append(guessed.empty() ? "" : " and ").append(name);
        if (!guessed.empty())
            study_.notes.push_back("machine " + shared::one_line(machine.name, 60) + " keeps the " + guessed + " of " + base.name +
                                   " (guesses for its number of tiles, which do not scale); give them in the study");
    }
    static bool value_has_list(std::vector<std::pair<std::string, Value>> const& members)
    {
        return std::any_of(members.begin(), members.end(), [](auto const& member) { return member.second.is_list(); });
    }
    void add_machine(tilemesh::MachineFile machine)
    {
        (void)size_of(machine); // an unknown number of its size is refused here
        machines_.push_back(std::make_shared<tilemesh::MachineFile const>(std::move(machine)));
    }
    static tilemesh::Extent2 grid_of_machine(tilemesh::MachineFile const& machine, Value const& where)
    {
        auto const grid = tilemesh::grid_of(machine);
        if (!grid) where.refuse("has machine " + shown(machine.name) + " without columns or rows", "add \"grid\": [COLUMNS, ROWS]");
        return {grid->width, grid->height};
    }
    static void add_sizes(Value const& value, std::vector<Capacities>& to)
    {
        if (value.is_text()) {
            if (value.text() != "preset") value.refuse("cannot be " + shown(value.text()), "write \"preset\", or {\"channel\": 100, \"storage\": \"the rest\"}");
            to.push_back({"preset", true, {}, {}});
            return;
        }
        value.allow({"channel", "road", "beam", "waiting", "storage"});
        for (auto const& choice : product(value.members(), value)) {
            Capacities c;
            c.of_preset = false;
            for (auto const& [key, one] : choice) {
                bool const rest = key == "storage" && one.is_text();
                if (rest && one.text() != "the rest") one.refuse("cannot be " + shown(one.text()), "write a number of slots, or \"the rest\"");
                c.name += (c.name.empty() ? "" : " ") + key + " " + (rest ? "the rest" : one.words());
                if (rest) continue;
                auto const slots = one.whole(1, 10'000'000);
                if (key == "storage") c.storage = slots;
                else c.channels.emplace_back(key + "-slots", slots);
            }
            to.push_back(std::move(c));
        }
    }
    void add_prices(Value const& value, std::vector<std::shared_ptr<Prices const>>& to)
    {
        if (value.is_text()) {
            Prices p;
            if (value.text() != "machine") {
                p.model = shared::load_model(file(value.text()), tilemesh::read_cost_model, "cost model", "name a file as render_map --trace writes it (model.txt)");
                p.name = p.model->name;
            }
            to.push_back(std::make_shared<Prices const>(std::move(p)));
            return;
        }
        for (auto const& choice : product(value.members(), value)) {
            Prices p;
            auto model = tilemesh::mk2(); // refuses a parameter that no model has
            for (auto const& [key, one] : choice) {
                if (key == "exchange")
                    value.refuse("has \"exchange\" (a model's fixed cycles and a machine's bytes a cycle have this name)",
                                 "write \"exchange_byte\", thousandths of a cycle, for the speed of links, or \"exchange_start\" of a machine");
                auto const number = one.whole(0, 0xffffffffu);
                try {
                    set_parameter(model, key, number, "guess: the study has it");
                } catch (Error const& error) {
                    throw Error(with_remedy(error.what(), "write a parameter and a value that it can have into \"costs\""));
                }
                p.changed.emplace_back(key, number);
                p.name += (p.name.empty() ? "" : " ") + key + " " + std::to_string(number);
            }
            to.push_back(std::make_shared<Prices const>(std::move(p)));
        }
    }

    fs::path folder_;
    Study study_;
    scene::Size size_{640, 360};
    std::optional<tilemesh::Extent2> grid_;
    std::uint32_t frames_ = 1;
    double degrees_ = 0.5;
    View views_;
    std::vector<std::shared_ptr<tilemesh::MachineFile const>> machines_;
};

} // namespace

Study load_study(fs::path const& path)
{
    auto const json = shared::json_of(text_of(path), path.string());
    return Reader(path).read({json, "it"});
}

} // namespace explore

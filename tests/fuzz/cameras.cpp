#include "require.hpp"
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/splat/camera.hpp>

namespace {

using namespace tilemesh;

// One camera in two forms of JSON. The text between two '~' is a number that may be replaced.
constexpr std::string_view own_form =
    R"({"cameras":[{"name":"a","width":~9~,"height":~9~,"fx":~9~,"fy":~9~,"cx":~4~,"cy":~4~,"near":~1~,"world_to_camera":)"
    R"([[~1~,~0~,~0~,~1~],[~0~,~1~,~0~,~2~],[~0~,~0~,~1~,~3~],[~0~,~0~,~0~,~1~]]}]})";
constexpr std::string_view training_form = R"([{"id":~0~,"img_name":"a","width":~9~,"height":~9~,"position":[~3~,~-2~,~-1~],"rotation":)"
                                           R"([[~1~,~0~,~0~],[~0~,~1~,~0~],[~0~,~0~,~1~]],"fx":~9~,"fy":~9~}])";

/// `form` after edits such as "d1e30;h-1": a letter for the number ('a' is the first), then the new text.
std::string edited(std::string_view form, std::string_view edits)
{
    std::vector<std::string> parts{""};
    for (char const c : form) {
        if (c == '~') parts.emplace_back();
        else parts.back() += c;
    }
    while (!edits.empty()) {
        std::string_view const edit = edits.substr(0, edits.find(';'));
        edits.remove_prefix(std::min(edit.size() + 1, edits.size()));
        if (edit.empty()) continue;
        std::size_t const number = static_cast<unsigned char>(edit[0] - 'a') % (parts.size() / 2);
        parts[2 * number + 1] = edit.substr(1);
    }
    std::string text;
    for (auto const& part : parts) text += part;
    return text;
}

/// Reads an input. The first byte chooses. 'C': COLMAP, the rest is cameras.txt, a NUL or '|', images.txt. 'B': COLMAP, the rest is a byte of
/// the length of cameras.bin, cameras.bin, images.bin. 'O', 'T': edits of the library's form and of the form of a training. Any other byte: JSON.
std::vector<scene::NamedCamera> read(std::string const& text, std::vector<std::string>& notes)
{
    constexpr auto kept = scene::DistortedLens::kept;
    bool const is_colmap = text.starts_with('C'), is_binary = text.starts_with('B');
    if (is_colmap || is_binary) {
        std::size_t const length = is_binary && text.size() > 1 ? static_cast<unsigned char>(text[1]) : 0;
        std::size_t const begin = std::min<std::size_t>(is_binary ? 2 : 1, text.size());
        std::size_t const end = is_binary ? begin + length : text.find_first_of(std::string_view("\0|", 2), 1), middle = std::min(end, text.size());
        std::istringstream lenses(text.substr(begin, middle - begin));
        std::istringstream images(text.substr(std::min(middle + (is_colmap ? 1 : 0), text.size())));
        if (is_binary) return scene::read_colmap_binary(lenses, images, "cameras.bin", "images.bin", kept, &notes);
        return scene::read_colmap(lenses, images, "cameras.txt", "images.txt", kept, &notes);
    }
    bool const is_own = text.starts_with('O'), is_edited = is_own || text.starts_with('T');
    std::istringstream stream(is_edited ? edited(is_own ? own_form : training_form, text.substr(1)) : text);
    return scene::read_cameras_json(stream, "file", &notes, kept);
}

/// The cameras as a file in the library's own form.
std::string own_text(std::vector<scene::NamedCamera> const& cameras)
{
    auto list = nlohmann::json::array();
    for (auto const& each : cameras) {
        auto const& c = each.camera;
        auto rows = nlohmann::json::array();
        for (int i = 0; i < 3; ++i) {
            double const x = double{c.rotation[i][0]}, y = double{c.rotation[i][1]}, z = double{c.rotation[i][2]};
            rows.push_back({x, y, z, -glm::dot(glm::dvec3{x, y, z}, *each.position)});
        }
        rows.push_back({0, 0, 0, 1});
        auto const& l = c.lens;
        char const* const model = l.kind == splat::LensKind::opencv ? "FULL_OPENCV" : l.kind == splat::LensKind::fisheye ? "OPENCV_FISHEYE" : "FOV";
        list.push_back({{"name", each.name}, {"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy},
                        {"near", c.near_depth}, {"world_to_camera", rows}});
        if (!each.scene.empty()) list.back()["scene"] = each.scene;
        if (!each.file.empty()) list.back()["file"] = each.file;
        if (l.kind == splat::LensKind::pinhole) continue;
        list.back().update({{"camera_model", model}, {"k1", l.k[0]}});
        if (l.kind != splat::LensKind::fov) list.back().update({{"k2", l.k[1]}, {"k3", l.k[2]}, {"k4", l.k[3]}});
        if (l.kind == splat::LensKind::opencv) list.back().update({{"p1", l.p[0]}, {"p2", l.p[1]}, {"k5", l.k[4]}, {"k6", l.k[5]}});
    }
    return nlohmann::json{{"cameras", list}}.dump();
}

/// What is written in the library's form is read back, and every key is known.
void require_written(std::vector<scene::NamedCamera> const& cameras)
{
    for (auto const& each : cameras)
        if (glm::length(*each.position) > 9e36) return; // rounding may lead beyond the readers' 1e37
    std::istringstream stream(own_text(cameras));
    std::vector<std::string> notes;
    auto const again = scene::read_cameras_json(stream, "again", &notes);
    require(notes.empty() && again.size() == cameras.size(), "every camera is read back without a note");
    for (std::size_t i = 0; i < again.size(); ++i) {
        auto const &a = again[i].camera, &b = cameras[i].camera;
        bool same = a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
        same = same && a.near_depth == b.near_depth && scene::text_of(a.lens) == scene::text_of(b.lens);
        same = same && scene::label(again[i]) == scene::label(cameras[i]) && again[i].file == cameras[i].file;
        for (int k = 0; k < 3; ++k) same = same && std::equal(a.rotation[k], a.rotation[k] + 3, b.rotation[k]);
        require(same, "a camera is read back");
        // A rotation is orthonormal within 1e-3 alone, and a centre is its transpose times the translation.
        double const off = glm::length(*again[i].position - *cameras[i].position);
        require(off <= 4e-3 * glm::length(*cameras[i].position) + 1e-300, "its centre is read back");
    }
}

void require_camera(splat::Camera const& c)
{
    for (int i = 0; i < 3; ++i) {
        require(std::isfinite(c.position[i]), "the centre is finite");
        for (int j = 0; j < 3; ++j) {
            double product = 0.0;
            for (int k = 0; k < 3; ++k) product += static_cast<double>(c.rotation[k][i]) * static_cast<double>(c.rotation[k][j]);
            require(std::fabs(product - (i == j ? 1.0 : 0.0)) <= 2e-3, "the rotation is orthonormal");
        }
    }
    auto const& r = c.rotation;
    float const volume = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) - r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                         r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
    require(volume > 0.0f, "the rotation is not mirrored");
    require(std::isfinite(c.fx) && c.fx > 0.0f && std::isfinite(c.fy) && c.fy > 0.0f, "focal lengths are positive");
    require(std::isfinite(c.cx) && std::isfinite(c.cy), "the principal point is finite");
    require(std::isfinite(c.near_depth) && c.near_depth > 0.0f, "near is positive");
    require(c.width >= 1 && c.width <= 65535 && c.height >= 1 && c.height <= 65535, "sides are 1 to 65535");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const input(reinterpret_cast<char const*>(data), size);
    std::vector<scene::NamedCamera> cameras;
    std::vector<std::string> notes;
    try {
        cameras = read(input, notes);
    } catch (Error const& error) {
        require_error(error.what());
        return 0;
    }
    for (auto const& note : notes) require(note.size() < 500 && is_one_line(note), "a note is a short line");
    for (auto const& camera : cameras) {
        require_camera(camera.camera);
        require(!camera.name.empty(), "a camera has a name");
        auto const chosen = scene::select_cameras(cameras, scene::label(camera), "map");
        require(chosen.size() == 1 && splat::same_view(chosen[0].camera, camera.camera), "a label selects its camera");
    }
    require_written(cameras);
    try {
        scene::select_cameras(cameras, "", "map");
    } catch (Error const& error) { // no camera belongs to the map
        require_error(error.what());
    }
    return 0;
}

#include "plain_cameras.hpp"
#include "require.hpp"
#include <tilemesh/error.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
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

/// The meaning of an input, and the plain reader's result for it. The first byte chooses. 'C': COLMAP, the rest is cameras.txt, a NUL or
/// '|', images.txt. 'B': COLMAP, the rest is a byte of the length of cameras.bin, cameras.bin, images.bin. 'O', 'T': edits of the library's form and of the form of a training. Any other byte: JSON.
struct Input {
    explicit Input(std::string const& text) : is_colmap(text.starts_with('C')), is_binary(text.starts_with('B'))
    {
        if (is_binary) {
            std::size_t const length = text.size() < 2 ? 0 : static_cast<unsigned char>(text[1]);
            first = text.substr(std::min<std::size_t>(2, text.size()), length);
            images_txt = text.substr(std::min(2 + length, text.size()));
            expected = plain::colmap_binary(first, images_txt, close);
            return;
        }
        if (is_colmap) {
            std::size_t const middle = std::min(text.find_first_of(std::string_view("\0|", 2), 1), text.size());
            first = text.substr(1, middle - 1);
            images_txt = text.substr(std::min(middle + 1, text.size()));
            expected = plain::colmap(first, images_txt, close);
            return;
        }
        first = text.starts_with('O') ? edited(own_form, text.substr(1)) : text.starts_with('T') ? edited(training_form, text.substr(1)) : text;
        plain::JsonCameras json;
        expected = json.read(first);
        close = json.close;
        is_json = json.is_json;
        unread = json.unread;
        unread_of_file = json.unread_of_file;
    }

    std::vector<scene::NamedCamera> read(std::vector<std::string>& notes) const
    {
        std::istringstream stream(first), images(images_txt);
        constexpr auto refused = scene::DistortedLens::refused;
        if (is_binary) return scene::read_colmap_binary(stream, images, "cameras.bin", "images.bin", refused);
        return is_colmap ? scene::read_colmap(stream, images, "cameras.txt", "images.txt", refused)
                         : scene::read_cameras_json(stream, "file", &notes, refused);
    }

    bool is_colmap, is_binary, is_json = true;
    bool close = false; ///< near a limit, so that rounding decides
    std::string first, images_txt;
    plain::Cameras expected;
    std::map<std::string, std::size_t> unread;
    std::set<std::string> unread_of_file;
};

/// Equal except for rounding: one float step, in units of `scale`.
bool near_to(float value, double expected, double scale = 1.0)
{
    return std::fabs(static_cast<double>(value) - expected) <= 2e-7 * std::max(std::fabs(expected), scale) + 1e-44; // below: no float
}

void require_same(std::vector<scene::NamedCamera> const& read, std::vector<plain::Camera> const& expected)
{
    require(read.size() == expected.size(), "as many cameras as the plain reader finds");
    for (std::size_t i = 0; i < read.size(); ++i) {
        auto const& [scene, file, name, c, position, names_near, mask, split] = read[i];
        (void)names_near, (void)mask, (void)split;
        auto const& e = expected[i];
        require(scene == e.scene && file == e.file && name == e.name, "names are those that the plain reader reads");
        require(c.width == e.width && c.height == e.height && near_to(c.fx, e.fx) && near_to(c.fy, e.fy) && near_to(c.cx, e.cx) &&
                    near_to(c.cy, e.cy) && near_to(c.near_depth, e.near, 0.0),
                "the lens is as the plain reader reads it");
        double const far = std::max({std::fabs(e.centre[0]), std::fabs(e.centre[1]), std::fabs(e.centre[2])});
        for (unsigned row = 0; row < 3; ++row) {
            require(near_to(c.position[row], e.centre[row], far), "the centre is as the plain reader reads it");
            require(position && c.position[row] == static_cast<float>((*position)[static_cast<int>(row)]), "the centre is the rounded one of double");
            for (unsigned column = 0; column < 3; ++column)
                require(near_to(c.rotation[row][column], e.rotation[row][column]), "the rotation is as the plain reader reads it");
        }
    }
}

/// As `require_notes`, for the keys of the whole file; takes their notes away.
void require_notes_of_file(std::vector<std::string>& notes, std::set<std::string> const& unread)
{
    auto const of_file = [](std::string const& note) { return note.rfind("the file has ", 0) == 0; };
    auto const count = static_cast<std::size_t>(std::count_if(notes.begin(), notes.end(), of_file));
    bool plain_keys = true;
    for (auto const& key : unread) plain_keys = plain_keys && key.size() <= 40 && plain::printable(key);
    if (plain_keys) require(count == std::min<std::size_t>(unread.size(), 9), "each key beside the frames that is not read has a note");
    for (auto const& key : unread)
        if (plain_keys && unread.size() <= 8)
            require(std::count(notes.begin(), notes.end(), "the file has \"" + key + "\", which is not read") == 1, "the keys of the file are named");
    notes.erase(std::remove_if(notes.begin(), notes.end(), of_file), notes.end());
    std::erase_if(notes, [](std::string const& note) {
        return note.find(" names in train_filenames, ") != note.npos || note.find(" and a camera_angle that ") != note.npos;
    });
}

/// A note for each key that is not read, or for eight of them and one more for the others.
void require_notes(std::vector<std::string> const& notes, std::map<std::string, std::size_t> const& unread)
{
    std::set<std::string> expected;
    for (auto const& [key, cameras] : unread)
        expected.insert(std::to_string(cameras) + (cameras == 1 ? " camera has \"" : " cameras have \"") + key + "\", which is not read");
    for (auto const& note : notes) require(note.size() < 200 && note.find('\n') == note.npos, "a note is a short line");
    if (unread.size() > 8) return require(notes.size() == 9, "eight keys are named, and that there are more");
    for (auto const& [key, cameras] : unread)
        if (key.size() > 40 || !plain::printable(key)) return; // keys of one beginning share a note
    require(std::set<std::string>(notes.begin(), notes.end()) == expected, "the keys that are not read are named");
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
    plain::Matrix rotation{};
    for (unsigned i = 0; i < 3; ++i) std::copy_n(c.rotation[i], 3, rotation[i].begin());
    require(plain::determinant(rotation) > 0.0, "the rotation is not mirrored");
    require(std::isfinite(c.fx) && c.fx > 0.0f && std::isfinite(c.fy) && c.fy > 0.0f, "focal lengths are positive");
    require(std::isfinite(c.cx) && std::isfinite(c.cy), "the principal point is finite");
    require(std::isfinite(c.near_depth) && c.near_depth > 0.0f, "near is positive");
    require(c.width >= 1 && c.width <= 65535 && c.height >= 1 && c.height <= 65535, "sides are 1 to 65535");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    Input const input({reinterpret_cast<char const*>(data), size});
    bool read = false;
    try {
        std::vector<std::string> notes;
        auto const cameras = input.read(notes);
        read = true;
        require(input.close || input.expected.has_value(), "what the plain reader refuses is refused");
        if (input.expected) require_same(cameras, *input.expected);
        if (input.expected) require_notes_of_file(notes, input.unread_of_file);
        if (input.expected) require_notes(notes, input.unread);
        for (auto const& camera : cameras) {
            require_camera(camera.camera);
            require(!camera.name.empty(), "a camera has a name");
            auto const label = scene::label(camera);
            auto const chosen = scene::select_cameras(cameras, label, "map");
            require(chosen.size() == 1 && splat::same_view(chosen[0].camera, camera.camera), "a label selects its camera");
        }
        scene::select_cameras(cameras, "", "map");
    } catch (Error const& error) {
        std::string const text = error.what();
        require_error(text);
        if (read) return 0; // no camera belongs to the map
        require(input.close || !input.expected.has_value(), "what the plain reader reads is read");
        bool const says_no_json = text.find(" is not JSON (") != text.npos || text.find("nested deeper than 64") != text.npos;
        require(says_no_json == !input.is_json, "what is no JSON is called so, and nothing else is");
    }
    return 0;
}

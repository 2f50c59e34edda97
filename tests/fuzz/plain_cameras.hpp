#pragma once
#include "plain_text.hpp"
#include <nlohmann/json.hpp>

namespace plain {

using Matrix = std::array<std::array<double, 3>, 3>; ///< rows
struct Camera {
    std::string scene, file, name;
    double width, height, fx, fy, cx, cy, near;
    Matrix rotation; ///< world to camera
    std::array<double, 3> centre;
};
using Cameras = std::optional<std::vector<Camera>>;

inline double determinant(Matrix const& m)
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}
inline bool is_side(double pixels)
{
    return pixels >= 1 && pixels <= 65535 && pixels == std::floor(pixels);
}

/// Can a camera be rendered? Sets `close` if a value is so near to a limit that rounding decides.
inline bool usable(Camera const& c, bool& close)
{
    auto const& r = c.rotation;
    for (unsigned i = 0; i < 3; ++i)
        for (unsigned j = 0; j < 3; ++j) {
            double sum = i == j ? -1.0 : 0.0;
            for (unsigned k = 0; k < 3; ++k) sum += r[k][i] * r[k][j];
            close = close || std::fabs(std::fabs(sum) - 1e-3) < 1e-9;
            if (!(std::fabs(sum) <= 1e-3)) return false;
        }
    auto const is_share = [](double v) { return std::fabs(v) < 2.0; };
    if (is_share(c.fx) && is_share(c.fy) && is_share(c.cx) && is_share(c.cy) && c.width >= 16 && c.height >= 16) return false;
    return determinant(r) > 0.0 && c.fx > 0.0 && c.fx >= 1e-3 * c.width && c.fx <= 16777216.0 && std::fabs(c.cx) <= 16777216.0 && c.fy > 0.0 &&
           c.fy >= 1e-3 * c.height && c.fy <= 16777216.0 && std::fabs(c.cy) <= 16777216.0 && static_cast<float>(c.near) > 0.0f;
}

inline unsigned depth_of(nlohmann::json const& value)
{
    unsigned deepest = 0;
    if (value.is_structured())
        for (auto const& inner : value) deepest = std::max(deepest, depth_of(inner));
    return value.is_structured() ? deepest + 1 : 0;
}

using Words = std::set<std::string>;

/// Whether a value under a distortion key is one that a pinhole camera has; `models`: names of camera models that a pinhole may have.
inline bool means_pinhole(nlohmann::json const& value, Words const& models = {"", "none", "pinhole", "simple_pinhole", "perspective"})
{
    if (value.is_number()) return value.get<double>() == 0.0;
    if (value.is_boolean()) return !value.get<bool>();
    if (value.is_string()) {
        std::string text = value.get<std::string>();
        std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return c < 0x80 ? std::tolower(c) : c; });
        return models.count(text) != 0;
    }
    return std::all_of(value.begin(), value.end(), [&](auto const& part) { return means_pinhole(part, models); }); // of null there is nothing
}

inline bool is_distortion_key(std::string const& key)
{
    static Words const keys{"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "distortion", "distortion_coefficients", "distortion_params",
                            "dist_coeffs", "camera_model"};
    return keys.count(key) != 0;
}

/// Whether a lens, or a file, has distortion.
inline bool is_distorted(nlohmann::json const& object)
{
    for (auto const& item : object.items())
        if (is_distortion_key(item.key()) && !means_pinhole(item.value())) return true;
    return false;
}

/// Reads a file of JSON into a document, and then the cameras from it.
class JsonCameras {
public:
    std::map<std::string, std::size_t> unread; ///< keys that are not read, and how many cameras have each
    Words unread_of_file; ///< keys beside the frames of a transforms.json that are not read
    bool is_json = true; ///< false: refused because it is not JSON, or because it is nested too deep
    bool close = false;

    Cameras read(std::string const& text)
    {
        using nlohmann::json;
        json const file = json::parse(text, nullptr, false);
        // nlohmann takes a byte 0 for the end of the text.
        is_json = !file.is_discarded() && text.find('\0') == text.npos && depth_of(file) <= 64;
        if (!is_json) return {};
        if (file.is_object() && !file.contains("cameras") && file.contains("frames")) return transforms(file);
        bool const own = file.is_object() && file.contains("cameras") && file["cameras"].is_array();
        if (!own && !file.is_array()) return {};
        if (own && is_distorted(file)) return {};
        json const& list = own ? file["cameras"] : file;
        Words const read_keys = own ? Words{"scene", "file", "name", "id", "width", "height", "fx", "fy", "cx", "cy", "near", "world_to_camera"}
                                    : Words{"id", "img_name", "width", "height", "position", "rotation", "fx", "fy"};
        std::vector<Camera> cameras;
        std::map<std::string, int> uses;
        Words labels;
        for (auto const& entry : list) {
            if (!entry.is_object() || !text_of(entry, own ? "name" : "img_name")) return {};
            if (!own) ++uses[*text_of(entry, "img_name")];
            count_unread(entry, read_keys);
        }
        for (auto const& entry : list) {
            if (is_distorted(entry)) return {};
            Camera c{};
            c.name = *text_of(entry, own ? "name" : "img_name");
            if (c.name.empty()) return {};
            if (!own && uses[c.name] > 1) {
                if (!entry.contains("id") || !entry["id"].is_number_integer()) return {};
                c.name += "#" + entry["id"].dump();
            }
            for (auto [key, value] : {std::pair{"scene", &c.scene}, {"file", &c.file}})
                if (own && entry.contains(key)) {
                    if (!text_of(entry, key)) return {};
                    *value = *text_of(entry, key);
                }
            c.near = 0.2f;
            for (auto [key, value] : {std::pair{"width", &c.width}, {"height", &c.height}, {"fx", &c.fx}, {"fy", &c.fy},
                                      {"cx", &c.cx}, {"cy", &c.cy}, {"near", &c.near}}) {
                if (!own && (key[0] == 'n' || key[0] == 'c')) continue;
                if (key[0] == 'n' && !entry.contains(key)) continue;
                if (!entry.contains(key) || !moderate_in(entry[key])) return {};
                *value = entry[key].get<double>();
            }
            if (!is_side(c.width) || !is_side(c.height)) return {};
            if (!own) c.cx = c.width / 2, c.cy = c.height / 2;
            if (!(own ? own_pose(entry, c) : training_pose(entry, c)) || !usable(c, close)) return {};
            if (!labels.insert(c.scene.empty() ? c.name : c.scene + "/" + c.name).second) return {};
            cameras.push_back(c);
        }
        return cameras;
    }

private:
    void count_unread(nlohmann::json const& entry, Words const& read_keys)
    {
        for (auto const& item : entry.items())
            if (read_keys.count(item.key()) == 0 && !is_distortion_key(item.key())) ++unread[item.key()];
    }
    Cameras transforms(nlohmann::json const& file)
    {
        if (!file["frames"].is_array()) return {};
        std::vector<Camera> cameras;
        Words names;
        static Words const no_pinhole{"equirectangular", "latlong", "orthographic"}, lists{"train_filenames", "val_filenames", "test_filenames"};
        // A pinhole too, if the coefficients that have keys of their own are 0.
        static Words const models{"", "none", "pinhole", "simple_pinhole", "perspective", "opencv", "full_opencv", "radial", "simple_radial"};
        static Words const of_lens{"w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x", "camera_angle_y", "is_fisheye", "equirectangular",
                                   "latlong", "orthographic", "sharpness"};
        Words of_frame{"file_path", "transform_matrix", "colmap_im_id", "mask_path"}, of_file{"frames", "aabb_scale", "ply_file_path"};
        of_frame.insert(of_lens.begin(), of_lens.end()), of_file.insert(of_lens.begin(), of_lens.end());
        auto const is_text = [](nlohmann::json const& value) { return value.is_string(); };
        for (auto const& item : file.items()) {
            auto const& list = item.value();
            bool const is_read = lists.count(item.key()) != 0 ? list.is_array() && std::all_of(list.begin(), list.end(), is_text)
                                                              : of_file.count(item.key()) != 0 || is_distortion_key(item.key());
            if (!is_read) unread_of_file.insert(item.key());
        }
        for (auto const& frame : file["frames"]) {
            if (!frame.is_object() || !text_of(frame, "file_path") || !is_matrix(frame, "transform_matrix", 4)) return {};
            if (frame.contains("mask_path") && !frame["mask_path"].is_null() && !text_of(frame, "mask_path")) return {};
            count_unread(frame, of_frame);
            auto const value = [&](std::string const& key) -> nlohmann::json const* {
                return frame.contains(key) ? &frame[key] : file.contains(key) ? &file[key] : nullptr;
            };
            for (auto const* object : {&frame, &file})
                for (auto const& item : object->items())
                    if (no_pinhole.count(item.key()) != 0 && item.value() == true) return {};
                    else if ((is_distortion_key(item.key()) || item.key() == "is_fisheye") && !means_pinhole(*value(item.key()), models)) return {};
            Camera c{};
            c.name = *text_of(frame, "file_path");
            std::replace(c.name.begin(), c.name.end(), '\\', '/');
            if (c.name.size() > 2 && c.name.substr(0, 2) == "./") c.name = c.name.substr(2);
            if (c.name.empty() || !names.insert(c.name).second) return {};
            bool refused = false;
            auto const number = [&](char const* key) -> std::optional<double> {
                if (value(key) == nullptr) return {};
                refused = refused || !moderate_in(*value(key));
                return refused ? 0.0 : value(key)->get<double>();
            };
            auto const width = number("w"), height = number("h");
            if (refused || !width || !height) return {};
            c.width = *width, c.height = *height, c.near = 0.2f;
            if (!is_side(c.width) || !is_side(c.height)) return {};
            auto fx = number("fl_x"), fy = number("fl_y");
            if (!fx) {
                auto const angle_x = number("camera_angle_x");
                auto const angle_y = fy ? std::nullopt : number("camera_angle_y");
                for (auto const& angle : {angle_x, angle_y})
                    if (angle && !(*angle > 0.0 && *angle < std::acos(-1.0))) return {};
                if (!angle_x) return {};
                fx = 0.5 * c.width / std::tan(0.5 * *angle_x);
                if (angle_y) fy = 0.5 * c.height / std::tan(0.5 * *angle_y);
            }
            c.fx = *fx, c.fy = fy.value_or(*fx);
            c.cx = number("cx").value_or(c.width / 2), c.cy = number("cy").value_or(c.height / 2);
            if (refused) return {};
            auto const& m = frame["transform_matrix"];
            if (!is_last_row(m[3])) return {};
            for (std::size_t i = 0; i < 3; ++i) {
                c.centre[i] = m[i][3].get<double>();
                for (std::size_t j = 0; j < 3; ++j) c.rotation[i][j] = (i == 0 ? 1 : -1) * m[j][i].get<double>();
            }
            if (!usable(c, close)) return {};
            cameras.push_back(c);
        }
        return cameras;
    }
    static std::optional<std::string> text_of(nlohmann::json const& entry, char const* key)
    {
        if (!entry.contains(key) || !entry[key].is_string() || !printable(entry[key].get<std::string>())) return {};
        return entry[key].get<std::string>();
    }
    static bool moderate_in(nlohmann::json const& value) { return value.is_number() && std::fabs(value.get<double>()) <= 1e37; }
    static bool is_matrix(nlohmann::json const& entry, char const* key, std::size_t n)
    {
        if (!entry.contains(key) || !entry[key].is_array() || entry[key].size() != n) return false;
        for (auto const& row : entry[key]) {
            if (!row.is_array() || row.size() != n) return false;
            for (auto const& value : row)
                if (!moderate_in(value)) return false;
        }
        return true;
    }
    /// 0 0 0 1
    bool is_last_row(nlohmann::json const& row)
    {
        double off = 0.0;
        for (std::size_t i = 0; i < 4; ++i) off += std::fabs(row[i].get<double>() - (i == 3 ? 1.0 : 0.0));
        close = close || std::fabs(off - 1e-6) < 1e-12;
        return off <= 1e-6;
    }
    bool own_pose(nlohmann::json const& entry, Camera& c)
    {
        if (!is_matrix(entry, "world_to_camera", 4)) return false;
        auto const& m = entry["world_to_camera"];
        if (!is_last_row(m[3])) return false;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) c.rotation[i][j] = m[i][j].get<double>();
        for (std::size_t j = 0; j < 3; ++j) { // Cramer's rule for R c = -t
            auto replaced = c.rotation;
            for (std::size_t i = 0; i < 3; ++i) replaced[i][j] = -m[i][3].get<double>();
            c.centre[j] = determinant(replaced) / determinant(c.rotation);
        }
        return true;
    }
    static bool training_pose(nlohmann::json const& entry, Camera& c)
    {
        if (!is_matrix(entry, "rotation", 3)) return false;
        if (!entry.contains("position") || !entry["position"].is_array() || entry["position"].size() != 3) return false;
        for (std::size_t i = 0; i < 3; ++i) {
            if (!moderate_in(entry["position"][i])) return false;
            c.centre[i] = entry["position"][i].get<double>();
            for (std::size_t j = 0; j < 3; ++j) c.rotation[j][i] = entry["rotation"][i][j].get<double>();
        }
        return true;
    }
};

/// The rotation of a quaternion w, x, y, z, by rows; nothing for a zero quaternion.
inline std::optional<Matrix> rotation_of(double w, double x, double y, double z)
{
    double const largest = std::max({std::fabs(w), std::fabs(x), std::fabs(y), std::fabs(z)});
    if (largest == 0.0) return {};
    double const length = std::sqrt((w / largest) * (w / largest) + (x / largest) * (x / largest) + (y / largest) * (y / largest) + (z / largest) * (z / largest));
    w = w / largest / length, x = x / largest / length, y = y / largest / length, z = z / largest / length;
    return Matrix{{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                   {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                   {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}}};
}

/// The models of COLMAP whose picture is a pinhole's if their coefficients are 0: focal lengths, coefficients, MODEL_ID.
struct Model {
    unsigned focals, coefficients;
    std::uint64_t id;
};
inline std::map<std::string, Model> const straight_models{{"SIMPLE_PINHOLE", {1, 0, 0}}, {"PINHOLE", {2, 0, 1}}, {"SIMPLE_RADIAL", {1, 1, 2}}, {"RADIAL", {1, 2, 3}},
                                                          {"OPENCV", {2, 4, 4}}, {"FULL_OPENCV", {2, 8, 6}}, {"FOV", {2, 1, 7}}};

/// The lens of these parameters, if it is a pinhole.
inline std::optional<Camera> lens_of(Model const& model, double width, double height, std::vector<double> values, bool& close)
{
    if (!is_side(width) || !is_side(height)) return {};
    if (model.focals == 1) values.insert(values.begin(), values[0]);
    for (std::size_t i = 4; i < values.size(); ++i)
        if (values[i] != 0.0) return {};
    Camera lens{"", "", "", width, height, values[0], values[1], values[2], values[3], 0.2f, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}};
    if (!usable(lens, close)) return {};
    return lens;
}

/// The camera of an image.
inline std::optional<Camera> image_of(Camera camera, std::array<double, 7> const& v, std::string name)
{
    std::replace(name.begin(), name.end(), '\\', '/');
    auto const rotation = rotation_of(v[0], v[1], v[2], v[3]);
    if (!rotation || name.empty() || !printable(name)) return {};
    camera.rotation = *rotation;
    for (std::size_t k = 0; k < 3; ++k) camera.centre[k] = -((*rotation)[0][k] * v[4] + (*rotation)[1][k] * v[5] + (*rotation)[2][k] * v[6]);
    camera.name = name;
    return camera;
}

/// Reads both files of a binary model.
inline Cameras colmap_binary(std::string const& cameras_bin, std::string const& images_bin, bool& close)
{
    std::size_t at = 0;
    bool ended = false;
    std::string const* bytes = &cameras_bin;
    auto const whole_number = [&](std::size_t size) {
        std::uint64_t value = 0;
        ended = ended || bytes->size() - at < size;
        for (std::size_t i = 0; i < size && !ended; ++i) value |= std::uint64_t{static_cast<unsigned char>((*bytes)[at + i])} << (8 * i);
        at += ended ? 0 : size;
        return value;
    };
    auto const real = [&] {
        std::uint64_t const bits = whole_number(8);
        double value;
        static_assert(sizeof value == sizeof bits);
        std::memcpy(&value, &bits, sizeof value);
        return std::fabs(value) <= 1e37 ? value : std::nan("");
    };
    std::map<std::uint64_t, Camera> lenses;
    std::uint64_t count = whole_number(8);
    if (ended || count > 1u << 20) return {};
    for (; count > 0; --count) {
        auto const id = whole_number(4), model_id = whole_number(4), width = whole_number(8), height = whole_number(8);
        auto const model = std::find_if(straight_models.begin(), straight_models.end(), [&](auto const& each) { return each.second.id == model_id; });
        if (ended || model == straight_models.end()) return {};
        std::vector<double> values;
        for (unsigned i = 0; i < model->second.focals + 2 + model->second.coefficients; ++i) values.push_back(real());
        for (double const value : values)
            if (ended || std::isnan(value)) return {};
        auto const lens = lens_of(model->second, static_cast<double>(width), static_cast<double>(height), values, close);
        if (!lens || !lenses.emplace(id, *lens).second) return {};
    }
    if (at != bytes->size()) return {};
    bytes = &images_bin;
    at = 0;
    count = whole_number(8);
    if (ended || count > 1u << 20) return {};
    std::vector<Camera> cameras;
    Words names;
    for (; count > 0; --count) {
        whole_number(4);
        std::array<double, 7> v{};
        for (double& value : v) value = real();
        auto const id = whole_number(4);
        std::size_t const end = bytes->find('\0', at);
        if (ended || end == std::string::npos || end - at > 65536 || lenses.count(id) == 0) return {};
        for (double const value : v)
            if (std::isnan(value)) return {};
        auto const camera = image_of(lenses.at(id), v, bytes->substr(at, end - at));
        at = end + 1;
        auto const points = whole_number(8);
        if (!camera || ended || points > (bytes->size() - at) / 24 || !names.insert(camera->name).second) return {};
        at += points * 24;
        cameras.push_back(*camera);
    }
    if (at != bytes->size()) return {};
    return cameras;
}

inline Cameras colmap(std::string const& cameras_txt, std::string const& images_txt, bool& close)
{
    std::map<std::uint64_t, Camera> lenses;
    for (auto const& line : lines(without_mark(cameras_txt))) {
        auto const w = words(line);
        if (w.empty() || w[0][0] == '#') continue;
        if (w.size() < 2 || straight_models.count(w[1]) == 0) return {};
        auto const& model = straight_models.at(w[1]);
        if (w.size() != 6 + model.focals + model.coefficients) return {};
        auto const id = whole_with_plus(w[0], 32), width = whole_with_plus(w[2], 32), height = whole_with_plus(w[3], 32);
        if (!id || !width || !height) return {};
        std::vector<double> values;
        for (std::size_t i = 4; i < w.size(); ++i) {
            if (!moderate(w[i])) return {};
            values.push_back(*moderate(w[i]));
        }
        auto const lens = lens_of(model, static_cast<double>(*width), static_cast<double>(*height), values, close);
        if (!lens || !lenses.emplace(*id, *lens).second) return {};
    }

    std::vector<Camera> cameras;
    Words names;
    auto const all = lines(without_mark(images_txt));
    for (std::size_t i = 0; i < all.size(); ++i) {
        auto const w = words(all[i]);
        if (w.empty() || w[0][0] == '#') continue;
        if (w.size() < 10 || !whole_with_plus(w[0], 32)) return {};
        std::array<double, 7> v{};
        for (std::size_t k = 0; k < 7; ++k) {
            if (!moderate(w[k + 1])) return {};
            v[k] = *moderate(w[k + 1]);
        }
        auto const id = whole_with_plus(w[8], 32);
        if (!id || lenses.count(*id) == 0) return {};
        // The name is the rest of the line after nine words.
        std::string rest = all[i];
        for (std::size_t k = 0; k < 9; ++k) rest = rest.substr(rest.find(w[k], rest.find_first_not_of(" \t\r\v\f")) + w[k].size());
        rest = rest.substr(rest.find_first_not_of(" \t\r\v\f"));
        auto const camera = image_of(lenses.at(*id), v, rest.substr(0, rest.find_last_not_of(" \t\r\v\f") + 1));
        if (!camera || !names.insert(camera->name).second) return {};
        cameras.push_back(*camera);

        if (++i >= all.size()) break;
        auto const points = words(all[i]);
        if (points.size() % 3 != 0) return {};
        for (std::size_t k = 0; k < points.size(); ++k)
            if (points[k].find_first_not_of(k % 3 == 2 ? "0123456789+-" : "0123456789+-.eEnaif") != std::string::npos) return {};
    }
    return cameras;
}

} // namespace plain

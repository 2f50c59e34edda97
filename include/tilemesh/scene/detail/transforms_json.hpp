#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_values.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

using PictureSizeOf = std::function<std::optional<Size>(std::string const&)>; ///< scene::PictureSizeOf (camera_json.hpp)

/// The lens that a transforms.json gives, for all frames or for one; each field may be missing.
struct TransformsLens {
    CameraField<double> w, h, fl_x, fl_y, cx, cy, camera_angle_x, camera_angle_y;
    std::uint32_t given = 0, bent = 0; ///< bit i: distortion key i is there; its value bends the picture
    LensValues values{};
    std::string model{};               ///< a camera model that is no perspective; empty: there is none

    CameraField<double>* field(std::string_view key)
    {
        for (auto const& [name, value] : {std::pair<std::string_view, CameraField<double>*>{"w", &w}, {"h", &h}, {"fl_x", &fl_x}, {"fl_y", &fl_y},
                                          {"cx", &cx}, {"cy", &cy}, {"camera_angle_x", &camera_angle_x}, {"camera_angle_y", &camera_angle_y}})
            if (name == key) return value;
        return nullptr;
    }
    void set_distortion(std::size_t key, bool bends)
    {
        given |= 1u << key;
        bent = bends ? bent | 1u << key : bent & ~(1u << key);
    }
    bool any() const
    {
        bool there = given != 0 || !model.empty();
        for (auto const* field : {&w, &h, &fl_x, &fl_y, &cx, &cy, &camera_angle_x, &camera_angle_y}) there = there || field->there;
        return there;
    }
};

/// The frames of a transforms.json, until the whole file is read: the lens of all frames may stand behind them. It keeps the frames before
/// the first that has no name or no pose, and the reason for that one.
class TransformsFrames {
public:
    explicit TransformsFrames(std::string const& file) : file_(file) {}

    TransformsLens common; ///< of all frames

    /// The name of a frame: its path with "/" for "\\", and without a leading "./".
    static std::string name_of(std::string_view written)
    {
        auto const path = with_slashes(written);
        return path.starts_with("./") && path.size() > 2 ? path.substr(2) : path;
    }
    /// A list of the file says what this frame is for. A frame of several lists is held out.
    void assign(std::string_view path, Split split)
    {
        auto& named = splits_[name_of(path)];
        named = std::max(named, split);
    }

    /// Forgets the frames that were read.
    void clear()
    {
        frames_.clear();
        unusable_.clear();
        there_ = true;
    }
    bool there() const { return there_; }
    std::size_t size() const { return frames_.size(); }
    /// Nothing more is needed from further frames.
    bool ended() const { return !unusable_.empty(); }

    void add(CameraField<std::string> const& path, CameraField<std::string> const& mask, CameraField<std::array<double, 16>> const& matrix,
             TransformsLens&& lens)
    {
        auto const name = std::to_string(frames_.size() + 1);
        auto const is = [&](auto const& field, char const* key) {
            if (!field.there) unusable_ = refusal(name, std::string("it has no \"") + key + "\"");
            else if (field.fault != nullptr) unusable_ = refusal(name, std::string("\"") + key + "\" is " + field.fault);
        };
        is(path, "file_path");
        if (!ended() && path.value.empty()) unusable_ = refusal(name, "\"file_path\" is empty");
        if (!ended()) is(matrix, "transform_matrix");
        if (!ended() && mask.there) is(mask, "mask_path");
        if (ended()) return;
        frames_.push_back({name_of(path.value), name_of(mask.value), {}, lens.any() ? std::make_unique<TransformsLens>(std::move(lens)) : nullptr});
        std::copy(matrix.value.begin(), matrix.value.end(), frames_.back().to_world.begin());
    }
    void add_no_object() { unusable_ = refusal(std::to_string(frames_.size() + 1), "it is not an object"); }

    /// The cameras; throws `Error` for the first that cannot be used. `size_of`, which may be empty, says the size of a picture whose frame
    /// has no w or no h.
    std::vector<NamedCamera> take(DistortedLens distorted, std::vector<std::string>* notes, PictureSizeOf const& size_of) const
    {
        std::vector<NamedCamera> cameras;
        std::set<std::string> names;
        std::size_t ignored = 0, sized = 0, contradicted = 0;
        for (auto const& frame : frames_) {
            if (!names.insert(frame.name).second) refuse(frame.name, "another frame has the same file_path");
            auto const& model = frame.lens && !frame.lens->model.empty() ? frame.lens->model : common.model;
            if (!model.empty()) throw Error(file_ + " frame " + shown(frame.name) + " " + fault_of_projection(model));
            bool const bends = bends_picture(frame);
            if (bends && distorted == DistortedLens::refused)
                throw Error(file_ + " frame " + shown(frame.name) +
                            " has a lens with distortion (a coefficient is not 0, or its camera_model is a fisheye; a pinhole camera has none); "
                            "undistort the pictures, for example with colmap image_undistorter, and name the cameras that it writes");
            ignored += bends ? 1 : 0;
            std::optional<Size> size;
            if (size_of && !(has(frame, &TransformsLens::w) && has(frame, &TransformsLens::h))) {
                size = size_of(frame.name);
                if (!size)
                    throw Error(file_ + " frame " + shown(frame.name) +
                                " is not usable (neither it nor the file has \"w\" and \"h\", and no PNG or JPEG picture of it is beside the "
                                "file); put the picture there, or give a size as in --size 800x800");
                ++sized;
            }
            cameras.push_back({"", "", frame.name, camera_of(frame, size, distorted),
                               glm::dvec3{frame.to_world[3], frame.to_world[7], frame.to_world[11]}});
            cameras.back().mask = frame.mask;
            auto const& lens = cameras.back().camera;
            using L = TransformsLens;
            contradicted += contradicts(frame, &L::fl_x, lens.fx, &L::camera_angle_x, lens.width) ||
                                    contradicts(frame, &L::fl_y, lens.fy, &L::camera_angle_y, lens.height)
                                ? 1u
                                : 0u;
        }
        if (!unusable_.empty()) throw Error(unusable_);
        set_splits(cameras, notes);
        if (distorted == DistortedLens::ignored) note_ignored_distortion(ignored, notes);
        if (contradicted != 0 && notes != nullptr)
            notes->push_back(std::to_string(contradicted) + (contradicted == 1 ? " camera has" : " cameras have") +
                             " a focal length and a camera_angle that are more than 1 % apart: the focal length counts");
        if (sized != 0 && notes != nullptr)
            notes->push_back(std::to_string(sized) + (sized == 1 ? " camera has" : " cameras have") +
                             " no \"w\" or \"h\": the size is that of the picture beside the file, or else the one that was given");
        return cameras;
    }

private:
    struct Frame {
        std::string name, mask;
        std::array<double, 16> to_world; ///< row-major
        std::unique_ptr<TransformsLens> lens; ///< what the frame itself says; null: nothing
    };

    /// Lists that hold out no frame leave that open. With lists of one kind alone, all other frames are of the other kind.
    void set_splits(std::vector<NamedCamera>& cameras, std::vector<std::string>* notes) const
    {
        auto const lists = [&](Split split) {
            return std::any_of(splits_.begin(), splits_.end(), [&](auto const& each) { return each.second == split; });
        };
        bool const trains = lists(Split::training), holds = lists(Split::held_out);
        if (!trains && !holds) return;
        std::size_t found = 0, held_out = 0;
        for (auto& camera : cameras) {
            auto const named = splits_.find(camera.name);
            found += named != splits_.end() ? 1 : 0;
            camera.split = named != splits_.end() ? named->second : trains && holds ? Split::unused : trains ? Split::held_out : Split::training;
            held_out += camera.split == Split::held_out ? 1 : 0;
        }
        for (auto& camera : cameras)
            if (held_out == 0 && camera.split == Split::training) camera.split = Split::unsaid;
        if (found < splits_.size() && notes != nullptr)
            notes->push_back(std::to_string(splits_.size() - found) + " of " + std::to_string(splits_.size()) +
                             " names in train_filenames, test_filenames and val_filenames are of no frame");
    }

    std::string refusal(std::string const& frame, std::string const& why) const
    {
        return file_ + " frame " + shown(frame) + " is not usable (" + why + "); correct the camera file";
    }
    [[noreturn]] void refuse(std::string const& frame, std::string const& why) const { throw Error(refusal(frame, why)); }

    bool bends_picture(Frame const& frame) const
    {
        auto const given = frame.lens ? frame.lens->given : 0, bent = frame.lens ? frame.lens->bent : 0;
        return (bent | (common.bent & ~given)) != 0;
    }

    bool has(Frame const& frame, CameraField<double> TransformsLens::*field) const
    {
        return (frame.lens && (frame.lens.get()->*field).there) || (common.*field).there;
    }

    CameraField<double> const& field_of(Frame const& frame, CameraField<double> TransformsLens::*field) const
    {
        return frame.lens && (frame.lens.get()->*field).there ? frame.lens.get()->*field : common.*field;
    }
    /// Is the field of view beside a focal length another one, by more than 1 %? Files round both to at least five digits.
    bool contradicts(Frame const& frame, CameraField<double> TransformsLens::*focal_length, double pixels, CameraField<double> TransformsLens::*angle,
                     std::uint32_t side) const
    {
        auto const& of_view = field_of(frame, angle);
        if (!field_of(frame, focal_length).there || !of_view.there || of_view.fault != nullptr || !(of_view.value > 0.0 && of_view.value < 3.14))
            return false;
        return std::fabs(0.5 * side / std::tan(0.5 * of_view.value) - pixels) > 0.01 * pixels;
    }

    /// A number of the frame, or else of the file; empty if neither has it.
    std::optional<double> number(Frame const& frame, CameraField<double> TransformsLens::*field, char const* key) const
    {
        auto const& found = field_of(frame, field);
        if (!found.there) return {};
        if (found.fault != nullptr) refuse(frame.name, std::string("\"") + key + "\" is " + found.fault);
        return found.value;
    }
    std::uint32_t side(Frame const& frame, CameraField<double> TransformsLens::*field, char const* key) const
    {
        auto const pixels = number(frame, field, key);
        if (!pixels)
            refuse(frame.name, std::string("neither it nor the file has \"") + key + "\", the size of its picture in pixels");
        if (!(*pixels >= 1.0 && *pixels <= 65535.0) || *pixels != std::floor(*pixels))
            refuse(frame.name, std::string("\"") + key + "\" is not a whole number from 1 to 65535");
        return static_cast<std::uint32_t>(*pixels);
    }
    /// The focal length, in pixels, of a field of view; empty for no field of view.
    std::optional<double> focal(Frame const& frame, CameraField<double> TransformsLens::*field, char const* key, std::uint32_t side) const
    {
        auto const angle = number(frame, field, key);
        if (!angle) return {};
        constexpr double pi = 3.14159265358979323846;
        if (!(*angle > 0.0 && *angle < pi)) refuse(frame.name, std::string("\"") + key + "\" is not between 0 and pi");
        return 0.5 * side / std::tan(0.5 * *angle);
    }

    /// `size` stands for a missing w or h.
    splat::Camera camera_of(Frame const& frame, std::optional<Size> const& size, DistortedLens distorted) const
    {
        using L = TransformsLens;
        auto const& m = frame.to_world;
        if (!ends_in_0_0_0_1(m))
            refuse(frame.name, "the last row of \"transform_matrix\" is not 0 0 0 1");
        // The matrix takes a camera that looks along -z, with y up, to the world; ours looks along z, with y down.
        Pose pose{glm::dmat3{1.0}, {m[3], m[7], m[11]}};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                pose.rotation[row][column] = (column == 0 ? 1.0 : -1.0) * m[static_cast<std::size_t>(4 * row + column)];

        std::uint32_t const width = size && !has(frame, &L::w) ? size->width : side(frame, &L::w, "w");
        std::uint32_t const height = size && !has(frame, &L::h) ? size->height : side(frame, &L::h, "h");
        auto fx = number(frame, &L::fl_x, "fl_x"), fy = number(frame, &L::fl_y, "fl_y");
        if (!fx) {
            fx = focal(frame, &L::camera_angle_x, "camera_angle_x", width);
            if (!fy) fy = focal(frame, &L::camera_angle_y, "camera_angle_y", height);
        }
        if (!fx) refuse(frame.name, "neither it nor the file has \"fl_x\" or \"camera_angle_x\"");
        splat::Lens bend{};
        std::string fault;
        if (distorted == DistortedLens::kept) bend = lens_of_values(frame.lens ? merged(frame.lens->values, common.values) : common.values, fault);
        if (!fault.empty()) refuse(frame.name, fault);
        Intrinsics const lens{*fx, fy.value_or(*fx), number(frame, &L::cx, "cx").value_or(0.5 * width),
                              number(frame, &L::cy, "cy").value_or(0.5 * height), default_near, width, height, bend};
        if (auto const why = fault_of(pose, lens); !why.empty()) refuse(frame.name, why);
        return make_camera(pose, lens);
    }

    std::string const& file_;
    bool there_ = false;
    std::vector<Frame> frames_;
    std::map<std::string, Split> splits_; ///< by the names of frames
    std::string unusable_; ///< the error of the first frame that has no name or pose; empty: there is none
};

}}} // namespace tilemesh::scene::detail

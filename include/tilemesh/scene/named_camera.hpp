#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// What a camera file says a view is for (the lists train_filenames, test_filenames and val_filenames of a transforms.json). `unused`: the
/// file has such lists, and none of them names the view.
enum class Split : unsigned char { unsaid, training, held_out, unused };

/// A camera of a camera file. `file` is the map for which it was made; it may be empty. `scene` may be empty too; then the camera belongs
/// to every map.
struct NamedCamera {
    std::string scene, file, name;
    splat::Camera camera;
    std::optional<glm::dvec3> position{}; ///< the position with the digits of its file; readers set it
    bool names_near = false;              ///< the file says the near plane; otherwise it is `default_near`, and `choose_near` chooses one
    std::string mask{};                   ///< a picture of the photograph's size, white where that counts; empty: all of it counts
    Split split = Split::unsaid;
};

/// The cameras for a map from which a reader subtracted this origin (`Map::origin`). The difference is computed in double. An origin of 0 changes
/// no bit.
TILEMESH_HOST std::vector<NamedCamera> relative_to_origin(std::vector<NamedCamera> cameras, std::array<double, 3> const& origin);

/// The near plane of cameras whose file names none, in world units. It is the near plane of the 3DGS rasteriser.
inline constexpr float default_near = 0.2f;

/// What a reader does with a camera whose lens bends the picture: it throws `Error`, or it takes the lens for a pinhole of the same focal
/// lengths and notes how many cameras it did that to, or the camera has the lens (splat/lens.hpp). A lens that there is not (thin prisms)
/// is refused in any case but `ignored`.
enum class DistortedLens { refused, ignored, kept };

/// The name by which a camera is shown and selected: "SCENE/NAME", or NAME if there is no scene.
TILEMESH_HOST std::string label(NamedCamera const& camera);

namespace detail {

/// What a camera file says about its lens: k1 to k6, p1, p2; lists of coefficients by the key that names them, in OpenCV's order (k1 k2 p1 p2 k3 k4
/// k5 k6; a fisheye's k1 k2 k3 k4), but "distortion_params", which is nerfstudio's, in its order (k1 k2 k3 k4 p1 p2); and the camera
/// model in lower case.
struct LensValues {
    std::array<double, 8> coefficients{};
    std::array<std::vector<double>, 4> lists{};
    std::string model{};
    bool fisheye = false;    ///< a word of its own says so
    std::uint32_t given = 0; ///< bit i: the file has distortion key i (distortion_keys)
    std::uint32_t odd = 0;   ///< bit i: it bends the picture in a form that is not read, as true for k1
};
/// The lens of these values. If there is none, `fault` says why.
TILEMESH_HOST splat::Lens lens_of_values(LensValues const& values, std::string& fault);
/// The values of `own`, and where it has none those of `common`.
TILEMESH_HOST LensValues merged(LensValues own, LensValues const& common);

/// What to say about a camera model that no undistortion makes a pinhole: "has an orthographic camera (...); ..."; empty for any other model.
TILEMESH_HOST std::string fault_of_projection(std::string const& model);

/// Notes that the distortion of `cameras` lenses is ignored, if there are any. `notes` may be null.
TILEMESH_HOST void note_ignored_distortion(std::size_t cameras, std::vector<std::string>* notes);

/// Is the last row of a 4x4 pose, of which `m` has the 16 numbers row by row, 0 0 0 1? A millionth off in all: numbers in a text of six
/// decimals.
TILEMESH_HOST bool ends_in_0_0_0_1(std::array<double, 16> const& m);

/// The names in one line, separated by commas. It shows at most the first twenty and counts the rest.
TILEMESH_HOST std::string list_of(std::vector<std::string> const& names);

} // namespace detail

/// Returns the cameras that `selector` selects. A selector is a label, or a NAME that only one camera of the file, or only one of the map's
/// own cameras, has. An empty selector selects every camera of the map: the cameras without a scene, those whose scene is `map_name`, and
/// those whose file is `map_name`, with or without its extension. The result is never empty: if no camera fits or a name is ambiguous, it
/// throws an `Error` that lists the choices.
TILEMESH_HOST std::vector<NamedCamera> select_cameras(std::vector<NamedCamera> const& cameras, std::string const& selector,
                                                      std::string const& map_name);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/named_camera_code.hpp>
#endif

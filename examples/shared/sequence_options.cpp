#include "sequence_options.hpp"
#include "input_rows.hpp"
#include "photographs_of.hpp"
#include "rgbd_photo.hpp"
#include <algorithm>
#include <cstddef>
#include <tilemesh/scene/camera_json.hpp>
#include <utility>

namespace shared {

namespace {
constexpr Option<SequenceOptions> result_rows[] = {option<&SequenceOptions::out>("out", "DIR", "folder for the results [.]"),
                                                   option<&SequenceOptions::report>("report", "FILE", "a report as JSON")};
} // namespace

void add_sequence(OptionTable& table, SequenceOptions& o, std::string_view size, std::string_view out)
{
    o.bends = true;
    table.add("The map", o, map_rows);
    table.add("The camera", o, camera_rows, camera_pairings);
    table.says("cameras", "a camera file, for the lens and the first pose");
    table.says("camera", "the camera of that file");
    table.says("size", size);
    table.says("near", "the near plane, in world units [the file's; 0.2, or a tenth of the first picture's median depth]");
    table.without("scale", "the depths of a recording are not divided; --size is for rendered pictures");
    table.add("Its motion", o, motion_rows, motion_pairings);
    table.without("orbit", "a tracker follows a camera that is held by hand; --trajectory takes the poses of an orbit");
    table.says("frames", "at most so many frames [60]");
    table.says("trajectory", "poses, camera to world: TUM, EuRoC, KITTI or Replica; of --photos, the truth [a hand-held motion]");
    table.says("every", "every N-th pose or picture [1]");
    table.says("relative", "apply the trajectory's motion from its first pose to the camera");
    table.add("Its pictures", o, recording_rows);
    table.add("Its pictures", o, depth_rows);
    table.add("What comes out", o, result_rows);
    table.says("out", out);
    table.pair({{Pairing::excludes, "photos", "size", "--size is for rendered pictures, and --photos has its own"}});
}

void add_masks(SequenceOptions const& o, tilemesh::scene::Size size, std::vector<tilemesh::scene::RgbdFrame>& photos, std::vector<std::string>& notes)
{
    if (!o.cameras || photos.empty()) return;
    std::vector<std::string> names;
    std::vector<std::filesystem::path> masks;
    std::vector<tilemesh::scene::Size> sizes;
    for (auto const& camera : tilemesh::scene::load_cameras(*o.cameras, nullptr, o.lens(), size)) {
        names.push_back(camera.name);
        masks.emplace_back(camera.mask);
        sizes.push_back({camera.camera.width, camera.camera.height});
    }
    if (std::all_of(masks.begin(), masks.end(), [](auto const& mask) { return mask.empty(); })) return;
    auto const cameras = cameras_of(pictures_of(photos), names);
    std::size_t found = 0;
    for (std::size_t k = 0; k < photos.size(); ++k) {
        if (cameras[k] == names.size() || masks[cameras[k]].empty()) continue;
        require_mask(photos[k].mask = masks[cameras[k]], size, sizes[cameras[k]]);
        ++found;
    }
    notes.push_back(found != 0 ? mask_note(found, photos.size()) : o.cameras->filename().string() + ": its masks belong to no picture of --photos");
}

std::vector<std::filesystem::path> files_read(SequenceOptions const& o, std::vector<std::optional<std::filesystem::path>> const& maps,
                                              std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> sized_by)
{
    auto files = std::move(sized_by);
    if (o.photos)
        for (auto const* const list : rgbd_lists) files.push_back(*o.photos / list);
    for (auto const& frame : photos) {
        files.push_back(frame.colour.file);
        if (!frame.depth.file.empty()) files.push_back(frame.depth.file);
        if (!frame.mask.empty()) files.push_back(frame.mask);
    }
    std::vector<std::filesystem::path> named;
    for (auto const& map : maps)
        if (map) named.push_back(*map);
    return files_read(o.inputs, o, named, std::move(files));
}

} // namespace shared

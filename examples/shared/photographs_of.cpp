#include "photographs_of.hpp"
#include "picture_input.hpp"
#include "text.hpp"
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/resample.hpp>
#include <utility>

namespace shared {

namespace fs = std::filesystem;
using tilemesh::Error;
using tilemesh::scene::Size;

namespace {

std::vector<fs::path> parts_of(fs::path const& path)
{
    std::vector<fs::path> parts;
    for (auto const& part : path)
        if (!part.empty() && part != "..") parts.push_back(part);
    return parts;
}

/// A file that may be the photograph of a camera. The key: folders of the name that are not in the path, and how far the extension is.
struct Candidate {
    std::pair<std::size_t, std::size_t> key;
    std::string const* name;
    fs::path file;
};
void find(fs::path const& folder, std::string const& name, std::vector<Candidate>& out)
{
    static constexpr std::array<char const*, 6> extensions{".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};
    std::error_code ignored;
    auto const above = parts_of(fs::absolute(folder, ignored).lexically_normal());
    auto const parts = parts_of(fs::path(name).relative_path().lexically_normal()); // "./train/r_0" is "train/r_0"
    for (std::size_t first = 0; first < parts.size(); ++first) {
        fs::path below;
        for (std::size_t i = first; i < parts.size(); ++i) below /= parts[i];
        std::size_t missing = first; // folders of the name that are neither below the folder nor its own
        while (missing > 0 && first - missing < above.size() && parts[missing - 1] == above[above.size() - 1 - (first - missing)]) --missing;
        auto const add = [&](fs::path const& path, std::size_t far) {
            auto const file = folder / path;
            if (fs::exists(file, ignored) && !fs::is_directory(file, ignored)) out.push_back({{missing, far}, &name, file});
        };
        add(below, 0);
        for (auto const* extension : extensions) add(fs::path(below).concat(extension), 1);
        for (auto const* extension : extensions) add(fs::path(below).replace_extension(extension), 2);
    }
}

} // namespace

std::string PhotographOf::why() const
{
    if (others.size() == 1) return "it is the photograph of \"" + one_line(others.front(), 200) + "\"";
    return "it may be that of \"" + one_line(others.front(), 200) + "\" or of \"" + one_line(others.back(), 200) + "\"";
}

std::vector<PhotographOf> photographs_of(fs::path const& folder, std::vector<std::string> const& names, std::vector<std::string> const& all,
                                         std::vector<fs::path> const& listed)
{
    std::error_code refused;
    if (!fs::is_directory(folder, refused))
        throw Error("--photos cannot be " + one_line(folder.string()) + " (it is no directory" +
                    (refused ? ": " + refused.message() : std::string()) + "); name the folder of the photographs");
    std::map<std::string, PhotographOf> found;
    for (auto const* list : {&names, &all})
        for (auto const& name : *list) found.emplace(name, PhotographOf{});
    std::vector<Candidate> candidates;
    for (auto const& [name, none] : found) find(folder, name, candidates);
    std::set<fs::path> only;
    for (auto const& file : listed) only.insert(fs::weakly_canonical(file, refused));
    if (!listed.empty()) std::erase_if(candidates, [&](auto const& each) { return only.count(fs::weakly_canonical(each.file, refused)) == 0; });
    std::stable_sort(candidates.begin(), candidates.end(), [](auto const& a, auto const& b) { return a.key < b.key; });

    std::map<fs::path, std::string const*> owners;
    std::error_code ignored;
    for (auto begin = candidates.begin(); begin != candidates.end();) {
        auto const end = std::find_if(begin, candidates.end(), [&](auto const& each) { return each.key != begin->key; });
        std::map<fs::path, std::set<std::string>> claims; // equally good ones, of files that nobody owns
        for (auto at = begin; at != end; ++at) {
            auto& own = found[*at->name];
            if (own.found()) continue;
            auto const owner = owners.find(at->file);
            if (owner == owners.end()) claims[at->file].insert(*at->name);
            else if (own.path.empty()) own = {at->file, {*owner->second}};
        }
        for (auto const& [file, claimants] : claims)
            for (auto const& name : claimants) {
                auto const& key = found.find(name)->first;
                if (found[name].found()) { // a file of the same key; .png and .PNG may be one file
                    if (claimants.size() > 1 || fs::equivalent(found[name].path, file, ignored)) continue;
                    throw Error(one_line(folder.string()) + " has two photographs of \"" + one_line(name, 200) + "\" (" +
                                one_line(found[name].path.filename().string()) + " and " + one_line(file.filename().string()) +
                                ", and nothing says which); take one of them away, or name cameras with the extension");
                }
                found[name] = {file, claimants.size() == 1 ? std::vector<std::string>{} : std::vector{*claimants.begin(), *claimants.rbegin()}};
                owners.emplace(file, &key);
            }
        begin = end;
    }
    std::vector<PhotographOf> out;
    for (auto const& name : names) out.push_back(found[name]);
    return out;
}

std::vector<std::size_t> cameras_of(std::vector<fs::path> const& pictures, std::vector<std::string> const& names)
{
    auto const folder = pictures.front().parent_path();
    auto const photographs = photographs_of(folder.empty() ? "." : folder, names, names, pictures);
    std::error_code ignored;
    std::map<fs::path, std::size_t> camera_of;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (photographs[i].found()) camera_of.emplace(fs::weakly_canonical(photographs[i].path, ignored), i);
    std::vector<std::size_t> out;
    for (auto const& picture : pictures) {
        auto const at = camera_of.find(fs::weakly_canonical(picture, ignored));
        out.push_back(at == camera_of.end() ? names.size() : at->second);
    }
    return out;
}

bool is_reduced(fs::path const& photograph, Size own, Size camera, std::uint32_t scale, std::string const& what)
{
    auto const fits = [scale](std::uint32_t side, std::uint32_t of) { return side == of / scale || side == (of + scale - 1) / scale; };
    if (fits(own.width, camera.width) && fits(own.height, camera.height)) return true;
    if (same(own, camera)) return false;
    throw Error(one_line(photograph.string()) + what + " (it has " + by(own) + " pixels, its camera " + by(camera) +
                (scale == 1 ? "" : ", or divided by " + std::to_string(scale)) +
                "); name the photographs of these cameras, or choose another --scale");
}

void require_mask(fs::path const& mask, Size photograph, Size camera)
{
    auto const own = picture_size(mask);
    if (!same(own, photograph) && !same(own, camera))
        throw Error(one_line(mask.string()) + " is no mask of its photograph (it has " + by(own) + " pixels, the photograph " + by(photograph) +
                    "); name masks of its size, or take them out of the camera file");
}

std::string mask_note(std::size_t masks, std::size_t pictures)
{
    return std::to_string(masks) + " of " + std::to_string(pictures) + " pictures have masks: only what is white in a mask counts";
}

void add_picture_notes(std::vector<fs::path> const& pictures, char const* meaning, std::vector<std::string>& notes)
{
    std::size_t transparent = 0, turned = 0;
    for (auto const& picture : pictures) {
        auto const facts = picture_facts(picture);
        transparent += facts.transparent ? 1u : 0u;
        turned += facts.turned ? 1u : 0u;
    }
    auto const note = [&](std::size_t n, std::string const& what) {
        if (n != 0) notes.push_back(std::to_string(n) + " of " + std::to_string(pictures.size()) + " pictures have " + what);
    };
    note(transparent, std::string("an alpha channel: ") + meaning);
    note(turned, "an Exif orientation, which is not applied: their pixels count as they are stored, as in COLMAP");
}

void apply_mask(tilemesh::report::Image& picture, fs::path const& mask)
{
    if (mask.empty()) return;
    auto image = read_picture(mask, picture_size(mask), {});
    float const white = *std::max_element(image.rgb.begin(), image.rgb.end());
    if (!(white > 0.0f)) throw Error(one_line(mask.string()) + " leaves nothing of its photograph (no pixel of it is white); correct the mask");
    for (float& value : image.rgb) value = value > 0.5f * white ? 1.0f : 0.0f; // masks of levels 0 and 1 too
    if (!same({image.width, image.height}, {picture.width, picture.height}))
        image = tilemesh::report::resized_as_photograph(image, picture.width, picture.height);
    std::size_t left = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
        if (image.rgb[i] + image.rgb[i + 1] + image.rgb[i + 2] < 2.99f)
            std::fill_n(picture.rgb.begin() + static_cast<std::ptrdiff_t>(i), 3, std::numeric_limits<float>::quiet_NaN());
        else ++left;
    if (left == 0) throw Error(one_line(mask.string()) + " leaves nothing of its photograph (no pixel is white, or white all around); correct the mask");
}

} // namespace shared

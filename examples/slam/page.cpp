#include "page.hpp"
#include "../shared/png.hpp"
#include <cstdint>
#include <tilemesh/report/html.hpp>

namespace slam_program {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace slam = tilemesh::slam;

Growth::Growth(scene::Pose const& first, scene::Intrinsics lens)
{
    lens.fx /= 2, lens.fy /= 2;
    lens.bend = {}; // the wide view of the page is a pinhole's
    camera_ = scene::make_camera(first, lens);
}

Growth::Picture Growth::picture_of(slam::Mapper& mapper, std::size_t frame) const
{
    return {frame, mapper.map().gaussians.size(), shared::png_bytes(mapper.render(camera_).colour)};
}

void Growth::see(slam::Mapper& mapper, std::size_t frame)
{
    constexpr std::size_t most = 64;
    if (keyframes_++ % every_ != 0) return;
    seen_.push_back(picture_of(mapper, frame));
    if (seen_.size() < most) return;
    for (std::size_t i = 0; 2 * i < most; ++i) seen_[i] = std::move(seen_[2 * i]);
    seen_.resize(most / 2);
    every_ *= 2;
}

void Growth::save(slam::StateWriter& out) const
{
    out.put(std::uint64_t{every_});
    out.put(std::uint64_t{keyframes_});
    out.put(std::uint64_t{seen_.size()});
    for (auto const& p : seen_) {
        out.put(std::uint64_t{p.frame});
        out.put(std::uint64_t{p.gaussians});
        out.put_text(p.png);
    }
}

void Growth::load(slam::StateReader& in)
{
    every_ = static_cast<std::size_t>(in.get<std::uint64_t>());
    keyframes_ = static_cast<std::size_t>(in.get<std::uint64_t>());
    seen_.clear();
    for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
        auto const frame = in.get<std::uint64_t>(), gaussians = in.get<std::uint64_t>();
        seen_.push_back({static_cast<std::size_t>(frame), static_cast<std::size_t>(gaussians), std::string(in.text())});
    }
}

std::vector<Growth::Picture> Growth::three(slam::Mapper& mapper, std::size_t frames) const
{
    std::vector<Picture> out;
    if (seen_.empty()) return out;
    out.push_back(seen_.front());
    if (seen_.size() > 2) out.push_back(seen_[seen_.size() / 2]);
    out.push_back(picture_of(mapper, frames - 1));
    return out;
}

std::string page_of(std::vector<std::pair<std::string, std::string>> const& numbers, std::vector<Growth::Picture> const& pictures,
                    std::string const& path_svg)
{
    report::HtmlReport page("A map from nothing");
    page.lead("The map grew while its camera moved, from pictures with depth alone.").figures(numbers);
    std::vector<report::HtmlCard> cards;
    for (auto const& p : pictures)
        cards.push_back({"after frame " + std::to_string(p.frame), std::to_string(p.gaussians) + " Gaussians", p.png,
                         "the map after frame " + std::to_string(p.frame)});
    if (!cards.empty())
        page.section("The map").paragraph("From the first pose, with a lens that is twice as wide.").gallery({}, cards);
    page.section("The path").svg(path_svg);
    return page.str();
}

} // namespace slam_program

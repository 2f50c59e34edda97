#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/lens.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A lens as one word of text: "pinhole", or its kind and coefficients with commas. The order is OpenCV's:
/// "opencv,k1,k2,p1,p2,k3,k4,k5,k6", "fisheye,k1,k2,k3,k4", "fov,omega", "equirectangular". Coefficients that are missing at the end are 0.
inline std::string text_of(splat::Lens const& lens)
{
    std::string text = splat::lens_names[static_cast<std::size_t>(lens.kind)];
    std::vector<float> values;
    if (lens.kind == splat::LensKind::opencv)
        values = {lens.k[0], lens.k[1], lens.p[0], lens.p[1], lens.k[2], lens.k[3], lens.k[4], lens.k[5]};
    else if (lens.kind == splat::LensKind::fisheye || lens.kind == splat::LensKind::fov)
        values.assign(lens.k, lens.k + (lens.kind == splat::LensKind::fov ? 1 : 4));
    while (!values.empty() && values.back() == 0.0f) values.pop_back();
    for (float const v : values) text += "," + significant(double{v}, 9); // so many digits give the float again
    return text;
}

/// The lens of such a text. Throws `Error` for another text.
inline splat::Lens lens_of_text(std::string_view text)
{
    auto const refuse = [&](std::string const& why) {
        throw Error("the lens \"" + detail::shown(text, 80) + "\" (" + why +
                    "); write opencv,k1,k2,p1,p2,k3,k4,k5,k6 or fisheye,k1,k2,k3,k4 or fov,omega or equirectangular; numbers at the end may be left "
                    "out");
    };
    detail::LensValues values;
    auto rest = text.substr(std::min(text.size(), text.find(',')));
    values.model = text.substr(0, text.size() - rest.size());
    while (!rest.empty()) {
        rest.remove_prefix(1);
        auto const word = rest.substr(0, rest.find(','));
        if (double value = 0; detail::parse_number(word, value)) values.lists[0].push_back(value);
        else refuse("a coefficient is no number");
        rest.remove_prefix(word.size());
    }
    bool const opencv = values.model == "opencv", fisheye = values.model == "fisheye", fov = values.model == "fov";
    if (!opencv && !fisheye && !fov && values.model != "pinhole" && values.model != "equirectangular") refuse("there is no such lens");
    if (auto const most = opencv ? 8u : fisheye ? 4u : fov ? 1u : 0u; values.lists[0].size() > most)
        refuse("it has at most " + std::to_string(most) + " numbers");
    std::string fault;
    auto const lens = detail::lens_of_values(values, fault);
    if (!fault.empty()) refuse(fault);
    return lens;
}

/// The focal length of a lens, in pixels, with which a picture spans `degrees` over `pixels` from side to side, with the centre in the middle.
/// Throws `Error` if the lens sees no such angle.
inline double focal_of(splat::Lens const& lens, double degrees, double pixels)
{
    double const half = 0.5 * degrees * 3.14159265358979323846 / 180.0;
    bool const angle = lens.kind == splat::LensKind::fisheye;
    double distance = 0, slope = 0;
    if (lens.kind == splat::LensKind::equirectangular) distance = half, slope = 1;
    else if (angle || half < 1.55) splat::lens_radius<double>(lens, angle ? half : std::tan(half), distance, slope);
    if (!(distance > 0 && slope > 0 && (!angle || half < 3.13) && half < 3.1416))
        throw Error("a field of view of " + significant(degrees, 6) + " degrees through the lens " + text_of(lens) +
                    " (it does not see that far); choose a smaller angle or another lens");
    return 0.5 * pixels / distance;
}

}}} // namespace tilemesh::scene

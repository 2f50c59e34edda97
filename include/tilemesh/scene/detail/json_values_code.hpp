#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/json_values.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST bool JsonValues::read_distortion(std::string& model, LensValues& values, std::size_t key, bool* named)
{
    values.given |= 1u << key;
    bool odd = false;
    constexpr std::size_t all = std::size(distortion_keys);
    bool const one = key < values.coefficients.size(), yes_or_no = key + 1 == all, names = key + 2 == all;
    auto* const list = one || yes_or_no || names ? nullptr : &values.lists[key - values.coefficients.size()];
    if (one) values.coefficients[key] = 0;
    else if (yes_or_no) values.fisheye = false;
    else if (names) values.model.clear();
    else list->clear();
    bool bends = false, bends_otherwise = false;
    std::size_t open = 0;
    do {
        JsonPart const part = next();
        if (part == JsonPart::begin_object || part == JsonPart::begin_list) ++open;
        if (part == JsonPart::end_object || part == JsonPart::end_list) --open;
        auto const word = part == JsonPart::text ? in_lower_case(text()) : std::string();
        bool const coefficients = word == "opencv" || word == "full_opencv" || word == "radial" || word == "simple_radial";
        bool const pinhole = word.empty() || word == "none" || word == "pinhole" || word == "simple_pinhole" || word == "perspective";
        bool const bent = (part == JsonPart::number && number() != 0.0) || (part == JsonPart::other && text() == "true");
        if (part == JsonPart::number && one) values.coefficients[key] = number();
        else if (part == JsonPart::number && list != nullptr && (list->size() < 6 || number() != 0.0) && list->size() < 9) list->push_back(number());
        if (part == JsonPart::text && names) values.model = word;
        odd = odd || part == JsonPart::begin_object || open > 1 || (part == JsonPart::begin_list && one) ||
              (part == JsonPart::number && (yes_or_no || names)) ||
              (part == JsonPart::text && !names) || (part == JsonPart::other && text() == "true" && !yes_or_no);
        if (part == JsonPart::other && text() == "true") values.fisheye = yes_or_no;
        if (part == JsonPart::text && !fault_of_projection(text()).empty()) model = text();
        bends = bends || bent || !pinhole;
        bends_otherwise = bends_otherwise || bent || !(pinhole || coefficients);
    } while (open != 0);
    values.odd = (values.odd & ~(1u << key)) | (odd && bends ? 1u : 0u) << key;
    if (named != nullptr) *named = bends_otherwise;
    return bends;
}

TILEMESH_HOST void JsonValues::read(CameraField<double>& field)
{
    field.there = true;
    field.fault = read_number(next(), field.value);
}

TILEMESH_HOST JsonPart JsonValues::read(CameraField<std::string>& field)
{
    JsonPart const part = next();
    field.there = true;
    field.fault = part != JsonPart::text ? "not a string" : !is_plain(text()) ? "not one line of text" : nullptr;
    if (field.fault == nullptr) field.value = text();
    else skip(part);
    return part;
}

TILEMESH_HOST void JsonValues::read_id(CameraField<std::string>& id)
{
    JsonPart const part = next();
    id.there = true;
    id.fault = "not a whole number";
    std::uint64_t natural = 0;
    std::int64_t whole = 0;
    if (part != JsonPart::number) return skip(part);
    if (!parse_number(text(), natural) && !parse_number(text(), whole)) return;
    id.fault = nullptr;
    id.value = text() == "-0" ? "0" : text();
}

TILEMESH_HOST std::string JsonValues::in_lower_case(std::string text)
{
    for (auto& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return text;
}

TILEMESH_HOST char const* JsonValues::read_number(JsonPart part, double& value)
{
    skip(part);
    if (part != JsonPart::number) return "not a number";
    value = number();
    return std::fabs(value) <= largest_number ? nullptr : "not a number within 1e37";
}

}}} // namespace tilemesh::scene

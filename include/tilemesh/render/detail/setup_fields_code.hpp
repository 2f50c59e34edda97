#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/render/setup_fields.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {

/// Digits without an exponent where the number is whole.
TILEMESH_HOST std::string digits(double value)
{
    return value == std::floor(value) && std::fabs(value) < 1e15 ? std::to_string(static_cast<std::int64_t>(value)) : number_text(value);
}

/// "hold or drop"; of more than two, "float, rgbx8, other".
TILEMESH_HOST std::string list_of(std::span<Word const> words)
{
    std::string text;
    for (auto const& [one, number] : words) text.append(text.empty() ? "" : words.size() == 2 ? " or " : ", ").append(one);
    return text;
}

/// The least number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
TILEMESH_HOST std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> before_last, last, row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before_last = std::exchange(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
    }
    return row.back();
}

inline constexpr splat::Setup const* preset_setups[] = {&splat::lossless, &splat::paper, &splat::prototype}; // in the order of `presets`
inline constexpr double no_word = -1;

TILEMESH_HOST double preset_of(splat::Setup const& setup)
{
    for (auto const& [word, number] : presets)
        if (word == setup.name) return static_cast<double>(number);
    return no_word;
}
TILEMESH_HOST void set_preset(splat::Setup& setup, double preset)
{
    setup = *preset_setups[static_cast<std::size_t>(preset)];
}
TILEMESH_HOST double machine_of(splat::Setup const& setup)
{
    for (auto const& [word, number] : machines)
        if (word == setup.machine.name) return static_cast<double>(number);
    return no_word;
}
TILEMESH_HOST void set_machine(splat::Setup& setup, double machine)
{
    setup.machine = machine == 0 ? size_of_machine<Mk2>() : size_of_machine<splat::RoomyMachine>();
    if (machine != 0) setup.sizes = splat::roomy(setup.sizes);
}
TILEMESH_HOST double quality_of(splat::Setup const& setup)
{
    for (auto const& [word, number] : qualities) {
        if (number == no_quality) continue;
        auto const rules = splat::with_quality(setup.rules, static_cast<splat::Quality>(number));
        if (std::memcmp(&rules, &setup.rules, sizeof rules) == 0) return static_cast<double>(number);
    }
    return no_quality;
}
TILEMESH_HOST void set_quality(splat::Setup& setup, double quality)
{
    if (quality != no_quality) setup.rules = splat::with_quality(setup.rules, static_cast<splat::Quality>(static_cast<std::uint32_t>(quality)));
}

} // namespace detail

TILEMESH_HOST std::string Values::takes() const
{
    if (kind == word) return "there are " + detail::list_of(words);
    bool const any = most >= any_number - 1 && least <= 1;
    auto const range = (any ? ", " : " from ") + detail::digits(least) + (any ? " or more" : " to " + detail::digits(most)) +
                       (unit.empty() ? "" : ", in " + std::string(unit));
    if (kind == whole) return "it takes a whole number" + range;
    return "it takes " + (least < most ? "a number" + range : std::string(unit) + ", a number");
}

TILEMESH_HOST std::optional<double> Values::read(std::string_view text) const
{
    for (auto const& one : words)
        if (text == one.word) return static_cast<double>(one.number);
    auto const in_limits = [&](auto from, double low, double high) -> std::optional<double> {
        if (std::is_same_v<decltype(from), double> && text.starts_with('+')) text.remove_prefix(1);
        auto const [end, error] = read_number(text.data(), text.data() + text.size(), from);
        auto const value = static_cast<double>(from);
        if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < low || value > high) return {};
        return value;
    };
    if (kind == whole) return in_limits(std::uint64_t{}, least, most);
    if (kind == number) return in_limits(0.0, least < most ? least : -HUGE_VAL, least < most ? most : HUGE_VAL);
    return {};
}

TILEMESH_HOST std::string Values::text(double value) const
{
    for (auto const& one : words)
        if (value == static_cast<double>(one.number)) return std::string(one.word);
    return detail::digits(value);
}

TILEMESH_HOST std::string_view nearest(std::string_view unknown, std::vector<std::string_view> const& names)
{
    std::string_view best;
    std::size_t least = 100; // more than every name's length
    if (unknown.size() < least)
        for (auto const name : names) {
            auto distance = detail::edit_distance(unknown, name);
            if (unknown.size() > 1 && name.starts_with(unknown)) distance = 1;
            if (distance < least && 3 * distance <= name.size() + 2) {
                least = distance;
                best = name;
            }
        }
    return best;
}

TILEMESH_HOST SetupField const* find_setup_field(std::string_view name)
{
    auto const same = [](char a, char b) { return a == b || (a == '-' && b == '_'); };
    for (auto const& field : setup_fields)
        if (std::equal(field.name.begin(), field.name.end(), name.begin(), name.end(), same)) return &field;
    return nullptr;
}

}}} // namespace tilemesh::render

namespace tilemesh { inline namespace v0_2 { namespace splat {

TILEMESH_HOST Setup with(Setup setup, std::span<render::SetupValue const> values)
{
    for (auto const& [name, text] : values) {
        auto const* const field = render::find_setup_field(name);
        if (field == nullptr) {
            std::vector<std::string_view> names;
            for (auto const& other : render::setup_fields) names.push_back(other.name);
            auto const near = render::nearest(name, names);
            throw Error("there is no field \"" + name + "\" (a setup does not have it); " +
                        (near.empty() ? "choose one of render::setup_fields" : "write \"" + std::string(near) + "\""));
        }
        if (!field->values.read(text))
            throw Error("the field " + std::string(field->name) + " cannot be \"" + text + "\" (" + field->values.takes() + "); " +
                        (field->values.kind == render::Values::word ? "choose one of these" : "choose such a number"));
    }
    for (auto const& field : render::setup_fields)
        for (auto const& [name, text] : values)
            if (render::find_setup_field(name) == &field) field.set(setup, *field.values.read(text));
    return setup;
}

}}} // namespace tilemesh::splat

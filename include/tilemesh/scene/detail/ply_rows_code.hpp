#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_rows.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST void require_rows(PlyHeader const& header, std::uint64_t body_bytes, std::string const& file)
{
    // The last line of an ASCII file may lack its end.
    std::uint64_t left = body_bytes + (header.format == PlyFormat::ascii ? 1 : 0);
    for (auto const& element : header.elements) {
        std::uint64_t const least = least_row_bytes(element, header.format);
        if (least == 0) continue;
        if (std::uint64_t const most = left / least; most < element.count) {
            if (header.format != PlyFormat::ascii && !element.has_lists) refuse_short_body(file, element, most + 1);
            throw Error(file + " is too short for element " + in_quotes(element.name) + " (the header promises " +
                        std::to_string(element.count) + " rows, there is room for " + std::to_string(most) +
                        " at most); copy or export the map again");
        }
        left -= element.count * least;
    }
}

TILEMESH_HOST std::vector<int> slots_of(PlyElement const& element, PlyColumns const& columns)
{
    std::vector<int> slots(element.properties.size(), -1);
    for (std::size_t k = 0; k < columns.size(); ++k)
        if (columns[k]) slots[static_cast<std::size_t>(columns[k] - element.properties.data())] = static_cast<int>(k);
    return slots;
}

TILEMESH_HOST void AsciiRows::skip(PlyElement const& element)
{
    read(element, {}, [](std::uint64_t, GaussianRow const&) {});
}

TILEMESH_HOST bool AsciiRows::find_row()
{
    while (skip_blanks() == '\n') source_.get(), ++line_;
    return source_.peek() >= 0;
}

TILEMESH_HOST void AsciiRows::refuse(std::string const& why) const
{
    throw Error(file_ + " cannot be read (line " + std::to_string(line_) + ", row " + std::to_string(number_) +
                " of element " + in_quotes(element_->name) + ": " + why + "); export the map again");
}

TILEMESH_HOST int AsciiRows::skip_blanks()
{
    while (is_blank(source_.peek())) source_.get();
    return source_.peek();
}

TILEMESH_HOST void AsciiRows::next_word()
{
    skip_blanks();
    length_ = 0;
    for (int c; (c = source_.peek()) >= 0 && c != '\n' && !is_blank(c); source_.get()) {
        if (length_ == word_.size()) refuse("a word of more than " + std::to_string(word_.size()) + " characters");
        word_[length_++] = static_cast<char>(c);
    }
    if (length_ != 0) return;
    if (source_.peek() < 0) refuse_short_body(file_, *element_, number_);
    refuse("fewer numbers than the header has columns");
}

TILEMESH_HOST void AsciiRows::end_row()
{
    int const c = skip_blanks();
    if (c >= 0 && c != '\n') refuse("more numbers than the header has columns");
    open_end_ = c < 0;
    source_.get();
    ++line_;
}

TILEMESH_HOST std::uint64_t AsciiRows::count() const
{
    auto const n = number_of<std::uint64_t>({word_.data(), length_});
    if (!n) refuse("a list of " + in_quotes(word()) + " items");
    return *n;
}

TILEMESH_HOST double AsciiRows::number(PlyType type) const
{
    double value = 0.0;
    auto const last = word_.data() + length_;
    bool const plus = word_[0] == '+' && length_ > 1 && word_[1] != '-';
    auto const [end, error] = read_number(word_.data() + (plus ? 1 : 0), last, value);
    if (end == last && error == std::errc::result_out_of_range) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        if (is_tiny(word())) return 0.0;
        return word_[0] == '-' ? -infinity : infinity;
    }
    if (error != std::errc{} || end != last) refuse(in_quotes(word()) + " is not a number");
    constexpr double too_large = 0x1.ffffffp127; // rounds to 2^128
    return type == PlyType::float32 && std::fabs(value) < too_large ? static_cast<double>(static_cast<float>(value)) : value;
}

}}} // namespace tilemesh::scene::detail

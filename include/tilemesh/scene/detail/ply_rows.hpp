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
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

[[noreturn]] inline void refuse_short_body(std::string const& file, PlyElement const& element, std::uint64_t row)
{
    throw Error(file + " ends inside row " + std::to_string(row) + " of element " + in_quotes(element.name) + " (the header promises " +
                std::to_string(element.count) + " rows, " + std::to_string(row - 1) + " are there); copy or export the map again");
}

/// Checks that the body is long enough for the rows that the header promises. It divides and never multiplies, because a count may be any
/// number. A list counts as empty, so for a file with lists the check is only a lower bound.
inline void require_rows(PlyHeader const& header, std::uint64_t body_bytes, std::string const& file)
{
    // The last line of an ASCII file may lack its end.
    std::uint64_t left = body_bytes + (header.format == PlyFormat::ascii ? 1 : 0);
    for (auto const& element : header.elements) {
        std::uint64_t const least = least_row_bytes(element, header.format);
        if (least == 0) continue;
        if (std::uint64_t const most = left / least; most < element.count) {
            if (header.format != PlyFormat::ascii && !element.has_lists) refuse_short_body(file, element, most + 1);
            throw Error(file + " is too short for element " + in_quotes(element.name) + " (the header promises " + std::to_string(element.count) +
                        " rows, there is room for " + std::to_string(most) + " at most); copy or export the map again");
        }
        left -= element.count * least;
    }
}

/// For each property of an element: the index of its field in a row; -1: none.
inline std::vector<int> slots_of(PlyElement const& element, PlyColumns const& columns)
{
    std::vector<int> slots(element.properties.size(), -1);
    for (std::size_t k = 0; k < columns.size(); ++k)
        if (columns[k]) slots[static_cast<std::size_t>(columns[k] - element.properties.data())] = static_cast<int>(k);
    return slots;
}

template <std::endian order>
double read_scalar(unsigned char const* bytes, PlyType type)
{
    switch (type) {
    case PlyType::int8:
        return number_at<std::int8_t, order>(bytes);
    case PlyType::uint8:
        return number_at<std::uint8_t, order>(bytes);
    case PlyType::int16:
        return number_at<std::int16_t, order>(bytes);
    case PlyType::uint16:
        return number_at<std::uint16_t, order>(bytes);
    case PlyType::int32:
        return number_at<std::int32_t, order>(bytes);
    case PlyType::uint32:
        return number_at<std::uint32_t, order>(bytes);
    case PlyType::float32:
        return static_cast<double>(number_at<float, order>(bytes));
    case PlyType::float64:
        break;
    }
    return number_at<double, order>(bytes);
}

/// Reads the rows of a binary body, one element after the other. Throws `Error` if a row is cut off or a list has a count below 0.
template <std::endian order>
class BinaryRows {
public:
    BinaryRows(ByteSource& source, std::string const& file) : source_(source), file_(file) {}

    void skip(PlyElement const& element)
    {
        // The rows of an element without lists fit: this product of `require_rows` did not wrap.
        if (element.has_lists) read(element, {}, [](std::uint64_t, GaussianRow const&) {});
        else if (!source_.skip(element.count * element.row_bytes)) refuse_short_body(file_, element, source_.left() / element.row_bytes + 1);
    }

    /// Calls `keep(number, row)` for every row; numbers count from 1. It may leave out the rows up to `first` and after `last`; then it does
    /// not read them.
    template <class Keep>
    void read(PlyElement const& element, PlyColumns const& columns, Keep keep, std::uint64_t first = 0,
              std::uint64_t last = std::numeric_limits<std::uint64_t>::max())
    {
        GaussianRow row{};
        auto const slots = slots_of(element, columns);
        if (element.has_lists) first = 0, last = element.count;
        last = std::min(last, element.count);
        skip_rows(element, 0, first);
        for (std::uint64_t number = first + 1; number <= last; ++number) {
            if (element.has_lists) {
                read_with_lists(element, slots, number, row);
            } else {
                auto const* const bytes = source_.take(static_cast<std::size_t>(element.row_bytes));
                if (!bytes) refuse_short_body(file_, element, number);
                for (std::size_t k = 0; k < columns.size(); ++k) row[k] = read_scalar<order>(bytes + columns[k]->offset, columns[k]->type);
            }
            keep(number, row);
        }
        skip_rows(element, last, element.count - last);
    }

private:
    /// Skips rows of an element without lists, of which `before` are read.
    void skip_rows(PlyElement const& element, std::uint64_t before, std::uint64_t rows)
    {
        if (rows != 0 && !source_.skip(rows * element.row_bytes)) refuse_short_body(file_, element, before + source_.left() / element.row_bytes + 1);
    }
    void read_with_lists(PlyElement const& element, std::vector<int> const& slots, std::uint64_t number, GaussianRow& row)
    {
        for (std::size_t i = 0; i < slots.size(); ++i) {
            auto const& property = element.properties[i];
            PlyType const type = property.count_type.value_or(property.type);
            auto const* const bytes = source_.take(size_of(type));
            if (!bytes) refuse_short_body(file_, element, number);
            double const value = read_scalar<order>(bytes, type);
            if (!property.is_list()) {
                if (slots[i] >= 0) row[static_cast<std::size_t>(slots[i])] = value;
                continue;
            }
            if (value < 0)
                throw Error(file_ + " has a list of " + std::to_string(static_cast<std::int64_t>(value)) + " items (row " + std::to_string(number) +
                            " of element " + in_quotes(element.name) + "); export the map again");
            if (!source_.skip(static_cast<std::uint64_t>(value) * size_of(property.type))) refuse_short_body(file_, element, number);
        }
    }

    ByteSource& source_;
    std::string const& file_;
};

/// Reads the rows of an ASCII body: one row per line, numbers separated by blanks, lines that end in LF or CR LF. Blank lines are skipped.
/// `read_number` reads the numbers, for any type in the header; a leading +, inf and nan are valid. In columns that are not used any word
/// is valid. Throws `Error` for other lines, and names row and line.
class AsciiRows {
public:
    /// `lines` is the number of lines of the header.
    AsciiRows(ByteSource& source, std::string const& file, std::uint64_t lines) : source_(source), file_(file), line_(lines + 1) {}

    /// Did the last line have no end? Then its last number may be cut off.
    bool open_end() const { return open_end_; }

    void skip(PlyElement const& element)
    {
        read(element, {}, [](std::uint64_t, GaussianRow const&) {});
    }

    /// Calls `keep(number, row)` for every row; numbers count from 1. An element without properties has no lines. Every row is read: lines
    /// have any length.
    template <class Keep>
    void read(PlyElement const& element, PlyColumns const& columns, Keep keep, std::uint64_t = 0, std::uint64_t = 0)
    {
        if (element.properties.empty()) return;
        element_ = &element;
        GaussianRow row{};
        auto const slots = slots_of(element, columns);
        for (number_ = 1; number_ <= element.count; ++number_) {
            if (!find_row()) refuse_short_body(file_, element, number_);
            for (std::size_t i = 0; i < slots.size(); ++i) {
                next_word();
                if (element.properties[i].is_list())
                    for (auto n = count(); n > 0; --n) next_word();
                else if (slots[i] >= 0) row[static_cast<std::size_t>(slots[i])] = number(element.properties[i].type);
            }
            end_row();
            keep(number_, row);
        }
    }

    /// Skips blank lines; false at the end of the file.
    bool find_row()
    {
        while (skip_blanks() == '\n') source_.get(), ++line_;
        return source_.peek() >= 0;
    }

private:
    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " cannot be read (line " + std::to_string(line_) + ", row " + std::to_string(number_) + " of element " +
                    in_quotes(element_->name) + ": " + why + "); export the map again");
    }
    static bool is_blank(int c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

    int skip_blanks()
    {
        while (is_blank(source_.peek())) source_.get();
        return source_.peek();
    }
    void next_word()
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
    void end_row()
    {
        int const c = skip_blanks();
        if (c >= 0 && c != '\n') refuse("more numbers than the header has columns");
        open_end_ = c < 0;
        source_.get();
        ++line_;
    }
    std::string_view word() const { return {word_.data(), length_}; }

    std::uint64_t count() const
    {
        auto const n = number_of<std::uint64_t>({word_.data(), length_});
        if (!n) refuse("a list of " + in_quotes(word()) + " items");
        return *n;
    }
    /// A `float` is rounded as in a binary file, so that both formats give the same records.
    double number(PlyType type) const
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

    ByteSource& source_;
    std::string const& file_;
    std::uint64_t line_;
    bool open_end_ = false;
    PlyElement const* element_ = nullptr; ///< being read, for messages
    std::uint64_t number_ = 0;            ///< of the row
    std::array<char, 512> word_{};        ///< the largest double has 316 characters in %f
    std::size_t length_ = 0;
};

}}} // namespace tilemesh::v0_2::scene::detail

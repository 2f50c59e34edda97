#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
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
    throw Error(file + " ends inside row " + std::to_string(row) + " of element " + in_quotes(element.name) +
                " (the header promises " + std::to_string(element.count) + " rows, " + std::to_string(row - 1) +
                " are there); copy or export the map again");
}

/// Checks that the body is long enough for the rows that the header promises. It divides and never multiplies, because a count may be any
/// number. A list counts as empty, so for a file with lists the check is only a lower bound.
TILEMESH_HOST void require_rows(PlyHeader const& header, std::uint64_t body_bytes, std::string const& file);

/// For each property of an element: the index of its field in a row; -1: none.
TILEMESH_HOST std::vector<int> slots_of(PlyElement const& element, PlyColumns const& columns);

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
        else if (!source_.skip(element.count * element.row_bytes))
            refuse_short_body(file_, element, source_.left() / element.row_bytes + 1);
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
                for (std::size_t k = 0; k < columns.size(); ++k)
                    row[k] = read_scalar<order>(bytes + columns[k]->offset, columns[k]->type);
            }
            keep(number, row);
        }
        skip_rows(element, last, element.count - last);
    }

private:
    /// Skips rows of an element without lists, of which `before` are read.
    void skip_rows(PlyElement const& element, std::uint64_t before, std::uint64_t rows)
    {
        if (rows != 0 && !source_.skip(rows * element.row_bytes))
            refuse_short_body(file_, element, before + source_.left() / element.row_bytes + 1);
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
                throw Error(file_ + " has a list of " + std::to_string(static_cast<std::int64_t>(value)) + " items (row " +
                            std::to_string(number) + " of element " + in_quotes(element.name) + "); export the map again");
            if (!source_.skip(static_cast<std::uint64_t>(value) * size_of(property.type)))
                refuse_short_body(file_, element, number);
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
    AsciiRows(ByteSource& source, std::string const& file, std::uint64_t lines)
        : source_(source), file_(file), line_(lines + 1)
    {}

    /// Did the last line have no end? Then its last number may be cut off.
    bool open_end() const { return open_end_; }

    TILEMESH_HOST void skip(PlyElement const& element);

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
    TILEMESH_HOST bool find_row();

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;
    static bool is_blank(int c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

    TILEMESH_HOST int skip_blanks();
    TILEMESH_HOST void next_word();
    TILEMESH_HOST void end_row();
    std::string_view word() const { return {word_.data(), length_}; }

    TILEMESH_HOST std::uint64_t count() const;
    /// A `float` is rounded as in a binary file, so that both formats give the same records.
    TILEMESH_HOST double number(PlyType type) const;

    ByteSource& source_;
    std::string const& file_;
    std::uint64_t line_;
    bool open_end_ = false;
    PlyElement const* element_ = nullptr; ///< being read, for messages
    std::uint64_t number_ = 0;            ///< of the row
    std::array<char, 512> word_{};        ///< the largest double has 316 characters in %f
    std::size_t length_ = 0;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_rows_code.hpp>
#endif

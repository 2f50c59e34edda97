#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// 1440 as "1,440".
inline std::string thousands(std::uint64_t number)
{
    auto text = std::to_string(number);
    for (std::size_t place = text.size(); place > 3; place -= 3) text.insert(place - 3, 1, ',');
    return text;
}

/// A small table for terminals. Every column is right-aligned and as wide as its widest cell. Two spaces separate columns, and a rule
/// follows the headers. Width is counted in UTF-8 code points.
class Table {
public:
    explicit Table(std::vector<std::string> headers) : rows_{std::move(headers)} {}

    /// Adds a row with one cell per header, left to right. Any other number of cells throws `tilemesh::Error`.
    Table& add_row(std::vector<std::string> cells)
    {
        if (cells.size() != rows_.front().size())
            throw Error("cannot add a row of " + std::to_string(cells.size()) + " cells (the table has " + std::to_string(rows_.front().size()) +
                        " columns); give one cell a header");
        rows_.push_back(std::move(cells));
        return *this;
    }

    friend std::ostream& operator<<(std::ostream& out, Table const& table)
    {
        std::vector<std::size_t> widths(table.rows_.front().size(), 0);
        for (auto const& row : table.rows_)
            for (std::size_t column = 0; column < row.size(); ++column) widths[column] = std::max(widths[column], width_of(row[column]));

        std::string text;
        for (std::size_t row = 0; row < table.rows_.size(); ++row) {
            auto const& cells = table.rows_[row];
            for (std::size_t column = 0; column < cells.size(); ++column) {
                text.append(column == 0 ? 0 : gap, ' ');
                text.append(widths[column] - width_of(cells[column]), ' ');
                text += cells[column];
            }
            text += '\n';
            if (row != 0) continue;
            for (std::size_t column = 0; column < widths.size(); ++column) {
                text.append(column == 0 ? 0 : gap, ' ');
                text.append(widths[column], '-');
            }
            text += '\n';
        }
        out.width(0);
        return out.write(text.data(), static_cast<std::streamsize>(text.size()));
    }

private:
    static constexpr std::size_t gap = 2;

    static std::size_t width_of(std::string_view text)
    {
        // Every byte except the continuation bytes 10xxxxxx starts a code point.
        auto const starts = [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; };
        return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), starts));
    }

    std::vector<std::vector<std::string>> rows_; ///< the first row holds the headers
};

}}} // namespace tilemesh::report

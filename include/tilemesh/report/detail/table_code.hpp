#pragma once
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string thousands(std::uint64_t number)
{
    auto text = std::to_string(number);
    for (std::size_t place = text.size(); place > 3; place -= 3) text.insert(place - 3, 1, ',');
    return text;
}

TILEMESH_HOST auto Table::add_row(std::vector<std::string> cells) -> Table&
{
    if (cells.size() != rows_.front().size())
        throw Error("cannot add a row of " + std::to_string(cells.size()) + " cells (the table has " + std::to_string(rows_.front().size()) +
                    " columns); give one cell a header");
    rows_.push_back(std::move(cells));
    return *this;
}

TILEMESH_HOST std::size_t Table::width_of(std::string_view text)
{
    // Every byte except the continuation bytes 10xxxxxx starts a code point.
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

}}} // namespace tilemesh::report

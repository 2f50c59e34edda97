#include "tables.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <string_view>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace paper {

namespace {

/// Integers without decimals, other numbers with `digits` significant digits.
std::string number(double value, int digits)
{
    bool const whole = value == std::floor(value) && std::fabs(value) < 1e15;
    return whole ? tilemesh::decimals(value, 0) : tilemesh::significant(value, digits);
}
std::string shown(double value)
{
    bool const whole = value == std::floor(value) || value >= 1000;
    return whole && value >= 0 && value < 1e15 ? tilemesh::report::thousands(static_cast<std::uint64_t>(value + 0.5))
                                               : number(value, 4);
}
/// Our figure over the paper's; empty if one is missing.
std::string ratio(Row const& row, int digits)
{
    return row.paper && row.ours && *row.paper != 0 ? number(*row.ours / *row.paper, digits) : std::string();
}
/// A name for the CSV: lower case, words joined by `_`. Of the text in brackets it keeps only a unit.
std::string token(std::string const& text)
{
    static constexpr std::pair<char const*, char const*> units[] = {{"(ms)", " ms"}, {"(%)", " percent"}, {"(B)", " bytes"},
                                                                    {"(MB)", " mb"}, {"(W)", " w"},       {"(dB)", " db"}};
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '(') {
            plain += text[i];
            continue;
        }
        for (auto const& [unit, name] : units)
            if (text.compare(i, std::string_view(unit).size(), unit) == 0) plain += name;
        i = std::min(text.find(')', i), text.size());
    }
    std::string out;
    for (char const c : plain) {
        bool const upper = c >= 'A' && c <= 'Z';
        if (upper || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.') out += static_cast<char>(upper ? c - 'A' + 'a' : c);
        else if (!out.empty() && out.back() != '_') out += '_';
    }
    while (!out.empty() && out.back() == '_') out.pop_back();
    return out;
}
/// One of five kinds: a counted figure is `measured`; a figure computed from prices or arithmetic is `modelled`.
std::string kind_of(Row const& row)
{
    if (!row.paper) return "no_figure";
    if (row.kind == "counted") return "measured";
    if (row.kind == "fitted") return "fitted";
    return row.kind == "null model" ? "null_model" : "modelled";
}
std::string field(std::string const& text)
{
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string out = "\"";
    for (char const c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

} // namespace

void print(std::ostream& out, Rows const& rows)
{
    tilemesh::report::Table table{{"table", "row", "quantity", "paper", "ours", "ratio", "kind"}};
    for (auto const& r : rows)
        table.add_row({r.table, r.row, r.quantity, r.paper ? shown(*r.paper) : "no figure in the source",
                       r.ours ? shown(*r.ours) : "skipped", ratio(r, 3), r.kind});
    out << table;
    for (auto const& r : rows)
        if (r.broken) out << "BROKEN: " << r.table << ", " << r.row << ", " << r.quantity << ": " << r.note << '\n';
}

std::string csv(Rows const& rows)
{
    std::string out = "table,row,quantity,paper,ours,ratio,kind,how,note\n";
    for (auto const& r : rows)
        out += r.table + "," + token(r.row) + "," + token(r.quantity) + "," + (r.paper ? number(*r.paper, 8) : "") + "," +
               (r.ours ? number(*r.ours, 8) : "") + "," + ratio(r, 6) + "," + kind_of(r) + "," + field(r.kind) + "," + field(r.note) + "\n";
    return out;
}

} // namespace paper

#pragma once
#include <algorithm>
#include <tilemesh/report/detail/plot_code.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/html.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::string base64(std::string_view bytes)
{
    constexpr char const* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        auto const byte = [&](std::size_t k) -> std::uint32_t { return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u; };
        std::uint32_t const word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[word >> (18 - 6 * k) & 63u];
    }
    return out;
}

TILEMESH_HOST std::string html_text(std::string_view text)
{
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\'') out += "&#39;";
        else if (text[i] == '\n') out += '\n';
        else if (text[i] == 127) out += ' ';
        else out += detail::plot_text(text.substr(i, 1));
    }
    return out;
}

namespace detail {

/// The style sheet has rules for words in this many columns of a table.
inline constexpr std::size_t most_left_columns = 16;
/// Does a table's cell hold a number: digits with signs, separators or a percent sign?
inline bool is_number_cell(std::string_view cell) noexcept
{
    return cell.find_first_of("0123456789") != cell.npos && cell.find_first_not_of("0123456789.,+-e% ") == cell.npos && cell[0] != 'e';
}
/// The style sheet of a report.
inline std::string html_style()
{
    std::string colours;
    for (int i = 0; i <= 8; ++i) {
        colours += i == 0 ? "rgb(" : ", rgb(";
        auto const colour = heat_colour(i / 8.0);
        for (std::size_t c = 0; c < 3; ++c) colours.append(c == 0 ? "" : " ").append(plot_number(255.0 * static_cast<double>(colour[c]), 0));
        colours += ')';
    }
    std::string left, wide;
    for (std::size_t column = 1; column <= most_left_columns; ++column) {
        auto const n = std::to_string(column), cells = n + " tr > :nth-child(" + n + ")", comma = std::string(column == 1 ? "" : ", ");
        left += comma + ".l" + cells;
        wide += comma + ".w" + cells;
    }
    return R"(:root { color-scheme: light dark; --line: color-mix(in srgb, CanvasText 20%, Canvas);
  --soft: color-mix(in srgb, CanvasText 6%, Canvas); --dim: color-mix(in srgb, CanvasText 70%, Canvas); }
* { box-sizing: border-box; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 1760px; margin: 0 auto; padding: 16px clamp(14px, 3vw, 48px) 48px;
  background: Canvas; color: CanvasText; overflow-wrap: break-word; }
h1 { font-size: clamp(24px, 2.6vw, 38px); line-height: 1.2; margin: 0.4em 0 0.5em; }
h2 { font-size: clamp(20px, 1.9vw, 27px); line-height: 1.25; margin: 1.7em 0 0.6em; }
h3 { font-size: 18px; margin: 1.5em 0 0.5em; }
p { max-width: 62em; margin: 0.7em 0; }
.lead { font-size: clamp(18px, 1.8vw, 25px); line-height: 1.35; max-width: 50em; border-left: 5px solid #d55e00; padding: 0.15em 0 0.15em 0.8em; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(165px, 1fr)); gap: 10px; margin: 1.1em 0; }
.figures div { background: var(--soft); border-radius: 8px; padding: 0.55em 0.8em; }
.figures dt { font-size: 13px; color: var(--dim); }
.figures dd { margin: 0; font-size: 20px; font-weight: 600; line-height: 1.25; }
.scroll { overflow-x: auto; margin: 0.7em 0; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: 0.25em 0.5em; text-align: right; vertical-align: top; white-space: nowrap; }
th { color: var(--dim); font-weight: 600; }
th { white-space: normal; }
.pairs th, .pairs td, )" + left + R"( { text-align: left; white-space: normal; }
)" + wide + R"( { min-width: 15em; white-space: pre-line; }
.scroll tr > :first-child { position: sticky; left: 0; background: Canvas; }
@media (min-width: 680px) { .pairs th { white-space: nowrap; } }
@media (max-width: 679.98px) { .pairs, .pairs tbody, .prose, .prose tbody { display: block; }
  .pairs tr, .prose tr { display: flex; flex-wrap: wrap; border-bottom: 1px solid var(--line); padding: 0.25em 0; }
  .pairs tr > *, .prose tr > * { flex: 1 1 0; min-width: 0; border: 0; padding: 0.1em 0.4em; overflow-wrap: anywhere; }
  .pairs tr > *, .prose tr > :last-child { flex-basis: 100%; } }
figure { margin: 0.8em 0; break-inside: avoid; }
.chart svg { width: 100%; max-width: 1500px; min-width: 1000px; height: auto; border-radius: 8px; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 300px), 1fr)); gap: 20px; margin: 1.1em 0; align-items: start; }
.gallery figure { margin: 0; }
@media (min-width: 680px) { .gallery .large { grid-column: span 2; grid-row: span 2; } }
.frame { position: relative; overflow: hidden; border-radius: 4px; background: var(--soft); }
.frame img { position: absolute; left: 0; top: 0; width: 100%; height: 100%; }
.frame img.map { image-rendering: pixelated; }
.frame i { position: absolute; outline: 2px solid #ff3b1f; outline-offset: 1px; }
.scale { height: 10px; border-radius: 3px; margin-top: 6px; background: linear-gradient(to right, )" + colours + R"(); }
.ticks { display: flex; column-gap: 0.6em; white-space: nowrap; font-size: 13px; font-variant-numeric: tabular-nums; }
.ticks span { flex: 1; text-align: center; } .ticks :first-child { text-align: left; } .ticks :last-child { text-align: right; }
figcaption { font-size: 14px; line-height: 1.4; margin-top: 4px; }
figcaption b { display: block; font-size: 15px; }
details { margin: 0.9em 0; }
summary { cursor: pointer; margin: 0.6em 0; }
summary h2, summary h3 { display: inline; }
@media print { @page { margin: 12mm; } body { font-size: 11px; padding: 0; } table { font-size: 10px; } th, td { padding: 0.15em 0.5em; }
  .lead { font-size: 15px; } h1 { font-size: 21px; } h2 { font-size: 16px; } h3 { font-size: 13px; } .figures dd { font-size: 14px; }
  .figures dt, figcaption, .ticks { font-size: 9px; } figcaption b { font-size: 11px; } .scroll { overflow: visible; }
  .scroll tr > :first-child { position: static; } .chart svg { min-width: 0; } h2, h3 { break-after: avoid; }
  tr, .figures { break-inside: avoid; } .figures { grid-template-columns: repeat(5, 1fr); } .gallery { grid-template-columns: repeat(3, 1fr); }
  .gallery .large { grid-column: span 2; grid-row: span 2; } details::details-content { content-visibility: visible; } }
)";
}

} // namespace detail

TILEMESH_HOST auto HtmlReport::figures(std::span<std::pair<std::string, std::string> const> pairs) -> HtmlReport&
{
    body_ += "<dl class=\"figures\">\n";
    for (auto const& [what, number] : pairs) body_ += "<div><dt>" + html_text(what) + "</dt><dd>" + html_text(number) + "</dd></div>\n";
    return add("</dl>\n");
}

TILEMESH_HOST auto HtmlReport::key_values(std::span<std::pair<std::string, std::string> const> pairs) -> HtmlReport&
{
    body_ += "<div class=\"scroll\"><table class=\"pairs\">\n";
    for (auto const& [key, value] : pairs) body_ += "<tr><th>" + html_text(key) + "</th><td>" + html_text(value) + "</td></tr>\n";
    return add("</table></div>\n");
}

TILEMESH_HOST auto HtmlReport::table(std::vector<std::string> const& headers, std::span<std::vector<std::string> const> rows) -> HtmlReport&
{
    std::vector<std::ptrdiff_t> words(headers.size(), 0); // cells with words minus cells with numbers
    std::vector<bool> sentences(headers.size(), false);
    std::string text = "<tr>";
    for (auto const& header : headers) text += "<th>" + html_text(header) + "</th>";
    text += "</tr>\n";
    for (auto const& row : rows) {
        if (row.size() != headers.size())
            throw Error("a table of the report cannot be written (a row has " + std::to_string(row.size()) +
                        " cells and " + std::to_string(headers.size()) + " columns); give one cell a header");
        text += "<tr>";
        for (std::size_t column = 0; column < row.size(); ++column) {
            text += "<td>" + html_text(row[column]) + "</td>";
            sentences[column] = sentences[column] || (column != 0 && row[column].size() > 32);
            if (!row[column].empty()) words[column] += detail::is_number_cell(row[column]) ? -1 : 1;
        }
        text += "</tr>\n";
    }
    std::string classes;
    for (std::size_t column = 0; column < words.size(); ++column)
        if (words[column] > 0) {
            auto const n = std::to_string(column + 1);
            classes += (classes.empty() ? "l" : " l") + n + (sentences[column] ? " w" + n : "");
        }
    if (!words.empty() && words.size() <= 4 && words.back() > 0 && sentences.back()) classes += " prose";
    return add("<div class=\"scroll\"><table class=\"" + classes + "\">\n" + text + "</table></div>\n");
}

TILEMESH_HOST auto HtmlReport::svg(std::string_view document) -> HtmlReport&
{
    if (!document.starts_with("<svg"))
        throw Error("a diagram of the report cannot be written (it does not begin with <svg); give the text that svg() returns");
    for (char const* element : {"<script", "<image", "<use", "<foreignObject", "<a ", "<style"})
        if (document.find(element) != std::string_view::npos)
            throw Error("a diagram of the report cannot be written (it has an element " + std::string(element + 1) +
                        "); draw with lines, shapes and text");
    auto const number = "-" + std::to_string(++diagrams_);
    std::string text;
    while (!document.empty()) {
        auto const skip = [&](std::string_view what) {
            if (!document.starts_with(what)) return false;
            document.remove_prefix(what.size());
            return true;
        };
        // Copies a name up to its end and appends the diagram's number: ` id="area"`, `url(#area)`.
        auto const renamed = [&](std::string_view before, char end) {
            if (!skip(before)) return false;
            auto const length = std::min(document.find(end), document.size());
            text.append(before).append(document.substr(0, length)).append(number);
            document.remove_prefix(length);
            return true;
        };
        if (skip(" xmlns=\"http://www.w3.org/2000/svg\"") || renamed(" id=\"", '"') || renamed("url(#", ')')) continue;
        text += document.front();
        document.remove_prefix(1);
    }
    return add("<figure class=\"chart scroll\">" + text + "</figure>\n");
}

TILEMESH_HOST auto HtmlReport::gallery(HtmlFrame const& frame, std::span<HtmlCard const> cards) -> HtmlReport&
{
    auto const percent = [](double part, double whole) { return detail::plot_number(100 * part / whole, 3) + "%"; };
    body_ += "<div class=\"gallery\">\n";
    for (auto const& card : cards) {
        bool const is_map = !card.scale.empty();
        body_ += !is_map && &card == cards.data() ? "<figure class=\"large\">" : "<figure>";
        body_ += "<div class=\"frame\" style=\"aspect-ratio: " + detail::plot_number(frame.width, 3) + " / " +
                 detail::plot_number(frame.height, 3) + "\"><img alt=\"" + html_text(card.alt) + "\"";
        if (is_map)
            body_ += " class=\"map\" style=\"width: " + percent(frame.map_width, frame.width) + "; height: " +
                     percent(frame.map_height, frame.height) + "\"";
        body_ += std::string(" src=\"data:image/") + (card.image.starts_with("BM") ? "bmp" : "png") + ";base64," + base64(card.image) + "\">";
        if (auto const& mark = frame.mark)
            body_ += "<i style=\"left: " + percent((*mark)[0], frame.width) + "; top: " + percent((*mark)[1], frame.height) +
                     "; width: " + percent((*mark)[2], frame.width) + "; height: " + percent((*mark)[3], frame.height) + "\"></i>";
        body_ += "</div>\n";
        if (is_map) {
            body_ += "<div class=\"scale\"></div><div class=\"ticks\">";
            for (auto const& number : card.scale) body_ += "<span>" + html_text(number) + "</span>";
            body_ += "</div>\n";
        }
        body_ += "<figcaption><b>" + html_text(card.title) + "</b>" + html_text(card.text) + "</figcaption></figure>\n";
    }
    return add("</div>\n");
}

TILEMESH_HOST std::string HtmlReport::str() const
{
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta http-equiv=\"Content-Security-Policy\" "
           "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           title_ + "</title>\n<style>\n" + detail::html_style() + "</style>\n</head>\n<body>\n" + body_ + "</body>\n</html>\n";
}

TILEMESH_HOST auto HtmlReport::add(std::string_view text) -> HtmlReport&
{
    body_ += text;
    return *this;
}

}}} // namespace tilemesh::report

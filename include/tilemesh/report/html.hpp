#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/report/plot.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Bytes in base 64 with padding, on one line (RFC 4648, section 4).
inline std::string base64(std::string_view bytes)
{
    constexpr char const* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        auto const byte = [&](std::size_t k) -> std::uint32_t {
            return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
        };
        std::uint32_t const word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[word >> (18 - 6 * k) & 63u];
    }
    return out;
}

/// A text for HTML, between tags or in a quoted attribute. Control characters but line feed become spaces; a byte that is not
/// UTF-8 stays, and readers show it as U+FFFD.
inline std::string html_text(std::string_view text)
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

/// How large a picture is shown: as wide as the page, or with others in a row, without smoothing.
enum class HtmlPicture { whole, small };

/// A report as one HTML file that needs nothing else: pictures are inside, there is no script, and a content security policy
/// forbids a browser to ask any network for anything. It is light or dark as the reader's browser is set. Each call adds an
/// element at the end; every text is escaped. The same calls give the same bytes.
///
/// Cost: the file's bytes in memory; a picture takes 4/3 of its PNG.
class HtmlReport {
public:
    explicit HtmlReport(std::string_view title) : title_(html_text(title)) { body_ = "<h1>" + title_ + "</h1>\n"; }

    HtmlReport& section(std::string_view heading) { return add("<h2>" + html_text(heading) + "</h2>\n"); }
    HtmlReport& subsection(std::string_view heading) { return add("<h3>" + html_text(heading) + "</h3>\n"); }
    HtmlReport& paragraph(std::string_view text) { return add("<p>" + html_text(text) + "</p>\n"); }

    /// Names and what they stand for, a line each.
    HtmlReport& key_values(std::span<std::pair<std::string, std::string> const> pairs)
    {
        body_ += "<table class=\"pairs\">\n";
        for (auto const& [key, value] : pairs)
            body_ += "<tr><th>" + html_text(key) + "</th><td>" + html_text(value) + "</td></tr>\n";
        return add("</table>\n");
    }

    /// The first column is for names, the others for numbers. One cell a header; any other number throws `Error`.
    HtmlReport& table(std::vector<std::string> const& headers, std::span<std::vector<std::string> const> rows)
    {
        std::string text = "<table>\n<tr>";
        for (auto const& header : headers) text += "<th>" + html_text(header) + "</th>";
        text += "</tr>\n";
        for (auto const& row : rows) {
            if (row.size() != headers.size())
                throw Error("a table of the report cannot be written (a row has " + std::to_string(row.size()) +
                            " cells and " + std::to_string(headers.size()) + " columns); give one cell a header");
            text += "<tr>";
            for (auto const& cell : row) text += "<td>" + html_text(cell) + "</td>";
            text += "</tr>\n";
        }
        return add(text + "</table>\n");
    }

    /// Adds a diagram that `svg` of plot.hpp or stacked_bars.hpp made. Its ids are made unique in the report, and its name
    /// space is left out, because HTML knows it. Throws `Error` for a text that is no SVG document, and for one with an
    /// element that runs or loads something.
    HtmlReport& svg(std::string_view document)
    {
        if (!document.starts_with("<svg"))
            throw Error(
                "a diagram of the report cannot be written (it does not begin with <svg); give the text that svg() returns");
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
            // Up to the end of a name: ` id="area"`, `url(#area)`.
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
        return add("<figure>" + text + "</figure>\n");
    }

    /// A picture, from the bytes of a PNG file. `alt` says in words what it shows.
    HtmlReport& picture(std::string_view png, std::string_view alt, std::string_view caption,
                        HtmlPicture size = HtmlPicture::whole)
    {
        body_ += size == HtmlPicture::small ? "<figure class=\"small\">" : "<figure>";
        body_ += "<img alt=\"" + html_text(alt) + "\" src=\"data:image/png;base64," + base64(png) + "\">";
        return add("<figcaption>" + html_text(caption) + "</figcaption></figure>\n");
    }

    /// Bytes of the body so far.
    std::size_t bytes() const noexcept { return body_.size(); }

    /// The whole file.
    std::string str() const
    {
        return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
               "<meta http-equiv=\"Content-Security-Policy\" "
               "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
               title_ +
               "</title>\n<style>\n"
               ":root { color-scheme: light dark; }\n"
               "body { font: 15px/1.45 sans-serif; max-width: 1320px; margin: 1em auto; padding: 0 1em; "
               "background: Canvas; color: CanvasText; }\n"
               "p { max-width: 60em; }\n"
               "table { border-collapse: collapse; margin: 0.7em 0; font-variant-numeric: tabular-nums; }\n"
               "th, td { border-bottom: 1px solid GrayText; padding: 0.15em 0.7em; text-align: right; vertical-align: top; }\n"
               "th:first-child, td:first-child, .pairs td { text-align: left; }\n"
               "figure { margin: 0.7em 0; }\n"
               "figure.small { display: inline-block; width: 300px; margin-right: 12px; vertical-align: top; }\n"
               "figure.small img { width: 100%; image-rendering: pixelated; }\n"
               "img, svg { max-width: 100%; height: auto; }\n"
               "figcaption { font-size: 13px; }\n"
               "</style>\n</head>\n<body>\n" +
               body_ + "</body>\n</html>\n";
    }

private:
    HtmlReport& add(std::string_view text)
    {
        body_ += text;
        return *this;
    }

    std::string title_, body_;
    std::uint32_t diagrams_ = 0;
};

}}} // namespace tilemesh::report

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/plot.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Bytes in base 64 with padding, on one line (RFC 4648, section 4).
TILEMESH_HOST std::string base64(std::string_view bytes);

/// A text for HTML, between tags or in a quoted attribute. Control characters except line feed become spaces. A byte that is not
/// UTF-8 stays, and browsers show it as U+FFFD.
TILEMESH_HOST std::string html_text(std::string_view text);

/// A picture in a gallery, with its title, a text, and a scale of heat colours if it is a map.
struct HtmlCard {
    std::string title, text;
    std::string image;                ///< the bytes of a PNG or BMP file
    std::string alt;                  ///< describes the picture in words
    std::vector<std::string> scale{}; ///< numbers below the scale, evenly spaced, the least first; empty: the picture is no map
};

/// The frame that all pictures of a gallery have, so that they line up. All lengths are in one unit, and above 0.
struct HtmlFrame {
    double width = 1, height = 1;
    double map_width = 1, map_height = 1;     ///< size of a map; parts beyond the frame's right or lower edge are cut off
    std::optional<std::array<double, 4>> mark{}; ///< a rectangle that is outlined in each picture: left, top, width, height
};

/// Is a part that the reader can fold away open at first?
enum class HtmlFold { open, closed };

/// A report as one HTML file that needs no other file: pictures are inside, there is no script, and a content security policy forbids
/// the browser any network access. It is light or dark, as the reader's browser prefers, and fits windows of 400 pixels, projectors
/// and paper. Each call adds an element at the end. Every text is escaped. Equal calls give equal bytes.
///
/// Cost: the file's bytes in memory. A picture takes 4/3 of the bytes of its file.
class HtmlReport {
public:
    explicit HtmlReport(std::string_view title) : title_(html_text(title)) { body_ = "<h1>" + title_ + "</h1>\n"; }

    HtmlReport& section(std::string_view heading) { return add("<h2>" + html_text(heading) + "</h2>\n"); }
    HtmlReport& subsection(std::string_view heading) { return add("<h3>" + html_text(heading) + "</h3>\n"); }
    HtmlReport& paragraph(std::string_view text) { return add("<p>" + html_text(text) + "</p>\n"); }
    /// Adds the main sentence of the page, or of a part of it, in large letters.
    HtmlReport& lead(std::string_view text) { return add("<p class=\"lead\">" + html_text(text) + "</p>\n"); }

    /// Adds a section that a reader can fold away: its heading stays, and the elements that `fill` adds are shown or hidden.
    template <class Fill>
    HtmlReport& folded_section(std::string_view heading, HtmlFold fold, Fill fill)
    {
        return folded("h2", heading, fold, fill);
    }
    /// Adds a subsection that a reader can fold away.
    template <class Fill>
    HtmlReport& folded_subsection(std::string_view heading, HtmlFold fold, Fill fill)
    {
        return folded("h3", heading, fold, fill);
    }

    /// Adds a few important numbers in large letters: pairs of a name, and the number with its unit.
    TILEMESH_HOST HtmlReport& figures(std::span<std::pair<std::string, std::string> const> pairs);

    /// Adds names with their values, one line each.
    TILEMESH_HOST HtmlReport& key_values(std::span<std::pair<std::string, std::string> const> pairs);

    /// Adds a table. A column is right-aligned if at least half of its cells are numbers, otherwise left-aligned; columns from the
    /// seventeenth on are right-aligned. In a narrow window the first column stays visible when a reader scrolls. Another column with
    /// sentences (a cell of more than 32 bytes) has room for some words per line, and a line feed in it starts a new line. If the last of at
    /// most four columns has sentences, a narrow window shows them below the row's other cells. A row must have one cell per header,
    /// otherwise it throws `Error`.
    TILEMESH_HOST HtmlReport& table(std::vector<std::string> const& headers, std::span<std::vector<std::string> const> rows);

    /// Adds a diagram that `svg` of plot.hpp or stacked_bars.hpp made. Its ids become unique in the report, and its name space is
    /// left out, because HTML knows it. Throws `Error` for a text that is no SVG document, and for a document with an element that
    /// runs or loads something.
    TILEMESH_HOST HtmlReport& svg(std::string_view document);

    /// Adds pictures beside each other, all in one frame, so a place has the same position in each. The first card, if it is no map, is
    /// larger than the others in a wide window.
    TILEMESH_HOST HtmlReport& gallery(HtmlFrame const& frame, std::span<HtmlCard const> cards);

    /// The number of bytes of the body so far.
    std::size_t bytes() const noexcept { return body_.size(); }

    /// The whole file.
    TILEMESH_HOST std::string str() const;

private:
    TILEMESH_HOST HtmlReport& add(std::string_view text);
    template <class Fill>
    HtmlReport& folded(std::string const& tag, std::string_view heading, HtmlFold fold, Fill fill)
    {
        body_ += fold == HtmlFold::open ? "<details open>" : "<details>";
        body_ += "<summary><" + tag + ">" + html_text(heading) + "</" + tag + "></summary>\n";
        fill();
        return add("</details>\n");
    }

    std::string title_, body_;
    std::uint32_t diagrams_ = 0;
};

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/html_code.hpp>
#endif

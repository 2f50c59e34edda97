#include "option_table.hpp"
#include "text.hpp"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>

namespace shared {

using tilemesh::Error;

namespace {

/// The user's text, short enough that the rest of the error stays visible: 60 bytes show any typing error.
std::string in_quotes(std::string_view text)
{
    return "\"" + one_line(text, 60) + "\"";
}

std::string digits(double value)
{
    if (value == std::floor(value) && std::fabs(value) < 1e15) return std::to_string(static_cast<std::int64_t>(value));
    std::array<char, 32> text{};
    return {text.data(), tilemesh::write_number(text.data(), text.data() + text.size(), value).ptr};
}

/// A whole number that fills the text, within limits.
std::optional<std::uint64_t> whole_of(std::string_view text, double least, double most)
{
    std::uint64_t value = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    bool const good = error == std::errc{} && end == text.data() + text.size() && static_cast<double>(value) >= least && static_cast<double>(value) <= most;
    return good ? std::optional(value) : std::nullopt;
}
/// A number that fills the text, within limits. A sign + is allowed.
std::optional<double> number_of(std::string_view text, double least, double most)
{
    double value = 0;
    if (text.starts_with('+')) text.remove_prefix(1);
    auto const [end, error] = tilemesh::read_number(text.data(), text.data() + text.size(), value);
    bool const good = error == std::errc{} && end == text.data() + text.size() && std::isfinite(value) && value >= least && value <= most;
    return good ? std::optional(value) : std::nullopt;
}

/// Two: "hold or drop". More: "float, rgbx8, other".
std::string list_of(std::span<Word const> words, std::string_view between)
{
    std::string text;
    for (auto const& [word, number] : words) text.append(text.empty() ? "" : between).append(word);
    return text;
}

/// The least number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b)
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

} // namespace

std::string_view nearest(std::string_view unknown, std::vector<std::string_view> const& names)
{
    std::string_view best;
    std::size_t least = 100; // more than every name's length
    if (unknown.size() < least)
        for (auto const name : names) {
            auto distance = edit_distance(unknown, name);
            if (unknown.size() > 1 && name.starts_with(unknown)) distance = 1;
            if (distance < least && 3 * distance <= name.size() + 2) {
                least = distance;
                best = name;
            }
        }
    return best;
}

std::string OptionRow::takes() const
{
    if (!why.empty()) return std::string(why);
    auto const range = most >= any_number - 1 && least <= 1 ? ", 1 or more" : " from " + digits(least) + " to " + digits(most);
    auto const in_unit = unit.empty() ? std::string() : ", in " + std::string(unit);
    switch (form) {
    case Form::whole:
        return "it takes a whole number" + range + in_unit;
    case Form::number:
        return "it takes " + (least < most ? "a number" + range + in_unit : std::string(unit) + ", a number");
    case Form::word:
        return "there are " + list_of(words, words.size() == 2 ? " or " : ", ");
    case Form::size:
        return "it takes WxH, a width and a height: two whole numbers" + range;
    case Form::three:
        return "it takes " + std::string(value) + ", three numbers" + range + in_unit;
    default:
        return "it takes " + std::string(value);
    }
}

std::string OptionRow::help() const
{
    std::string text(meaning);
    if (auto const at = text.find("{}"); at != std::string::npos)
        text.replace(at, 2, words.empty() ? digits(least) + " to " + digits(most) : list_of(words, " | "));
    return text;
}

OptionValue OptionRow::read(std::string_view text) const
{
    OptionValue out{.text = text};
    for (auto const& [word, number] : words)
        if (text == word) {
            out.whole = number;
            return out;
        }
    bool good = true;
    auto const parts = [&](std::size_t n, char between, auto const& read) {
        for (std::size_t i = 0; i < n && good; ++i) {
            auto const at = i + 1 < n ? text.find(between) : text.size();
            auto const part = at != text.npos ? read(text.substr(0, at)) : std::nullopt;
            good = part.has_value();
            if (good) out.three[i] = static_cast<double>(*part);
            if (good) text.remove_prefix(std::min(at + 1, text.size()));
        }
    };
    switch (form) {
    case Form::flag:
        out.whole = 1;
        break;
    case Form::whole:
        if (auto const n = whole_of(text, least, most)) out.whole = *n;
        else good = false;
        break;
    case Form::number:
        if (auto const n = number_of(text, least < most ? least : -HUGE_VAL, least < most ? most : HUGE_VAL)) out.number = *n;
        else good = false;
        break;
    case Form::word:
        good = false;
        break;
    case Form::size:
        parts(2, 'x', [&](std::string_view part) { return whole_of(part, least, most); });
        break;
    case Form::three:
        parts(3, ',', [&](std::string_view part) { return number_of(part, least, most); });
        break;
    case Form::text:
        if (text.empty() || (most > 0 && static_cast<double>(text.size()) > most)) good = false;
        break;
    default:
        if (text.empty()) throw Misfit{"it takes a name in the file system"};
    }
    if (!good) throw Misfit{takes()};
    return out;
}

OptionTable::Entry& OptionTable::entry(std::string_view name)
{
    auto const at = std::find_if(entries_.begin(), entries_.end(), [name](Entry const& e) { return e.row.name == name; });
    if (at == entries_.end()) throw std::logic_error(program_ + " has no option " + std::string(name));
    return *at;
}

void OptionTable::take_word(std::string_view word)
{
    auto const shown = word.empty() ? std::string("an empty word") : one_line(word, 200);
    if (most_words_ == 0) throw Error(shown + " is no option (" + program_ + " takes no word without one); see " + program_ + " --help");
    if (word.empty()) throw Error("the " + what_ + "'s name cannot be empty (it takes a name in the file system); name one");
    if (words_++ == most_words_) throw Error(shown + " is a second " + what_ + " (" + program_ + " takes one); leave one out");
    inputs_.emplace_back(word);
    take_(word);
}

void OptionTable::refuse_unknown(std::string_view name) const
{
    std::vector<std::string_view> names;
    for (auto const& e : entries_)
        if (e.without.empty()) names.push_back(e.row.name);
    auto const bare = name.substr(std::min<std::size_t>(name.find_first_not_of('-'), name.size()));
    auto const near = nearest(bare, names);
    throw Error("there is no option " + one_line(name, 60) + " (" + program_ + " does not know it); " +
                (near.empty() ? "see " : "write --" + std::string(near) + ", or see ") + program_ + " --help");
}

void OptionTable::require(Pairing const& pairing) const
{
    auto const& [kind, option, other, why] = pairing;
    if (!is_given(option) || is_given(other) != (kind == Pairing::excludes)) return;
    auto const a = "--" + std::string(option), b = "--" + std::string(other), because = " (" + std::string(why) + "); ";
    if (kind == Pairing::needs) throw Error(a + " is given without " + b + because + "add " + b + " or leave it out");
    throw Error(a + " and " + b + " are both given" + because + "leave one of them out");
}

bool OptionTable::is_given(std::string_view name) const
{
    return std::any_of(given_.begin(), given_.end(), [name](Given const& g) { return g.row->name == name; });
}

bool OptionTable::read(std::span<char const* const> words)
{
    bool options_end = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
        std::string_view const word = words[i];
        if (options_end || !word.starts_with('-')) {
            take_word(word);
            continue;
        }
        if (word == "--") {
            options_end = true;
            continue;
        }
        auto const equals = word.find('=');
        auto const name = word == "-h" ? std::string_view("--help") : word.substr(0, equals);
        auto const at = std::find_if(entries_.begin(), entries_.end(), [&](Entry const& e) { return name.starts_with("--") && e.row.name == name.substr(2); });
        if (at == entries_.end()) refuse_unknown(name);
        auto const& row = at->row;
        auto const option = "--" + std::string(row.name);
        if (!at->without.empty()) throw Error(program_ + " has no " + option + " (" + std::string(at->without) + "); leave it out");
        if (is_given(row.name)) {
            if (!repeats_) throw Error(option + " is given twice (which one counts is not said); leave one out");
            std::erase_if(given_, [&](Given const& g) { return g.row == &row; });
        }
        std::string_view text;
        if (row.form == Form::flag) {
            if (equals != word.npos) throw Error(option + " takes no value (it is there or not); write " + option + " alone");
        } else if (equals != word.npos) {
            text = word.substr(equals + 1);
        } else if (i + 1 < words.size() && !std::string_view(words[i + 1]).starts_with("--")) {
            text = words[++i];
        } else {
            throw Error(option + " has no value (it takes " + std::string(row.value) + "); write it behind the option, or behind = where it begins with --");
        }
        given_.push_back({&row, std::string(text)});
        try {
            at->set(row.read(text));
        } catch (Misfit const& misfit) {
            if (row.form >= Form::input && text.empty()) throw Error(option + " cannot be empty (" + misfit.why + "); name one");
            auto const example = row.example.empty() ? digits(std::max(row.least, std::min(1.0, row.most))) : std::string(row.example);
            throw Error(option + " cannot be " + in_quotes(text) + " (" + misfit.why + "); " +
                        (misfit.why.starts_with("there are") ? "choose one of these" : "write for example " + option + " " + example));
        }
        if (row.form == Form::input) inputs_.emplace_back(text);
        if (row.name == "help" || row.name == "version") return false;
    }
    for (auto const& pairing : pairings_) require(pairing);
    return true;
}

std::string OptionTable::help() const
{
    constexpr std::size_t indent = 24, width = 100;
    auto text = usage_, refused = std::string();
    std::string_view title;
    for (auto const& e : entries_) {
        if (e.without.empty() && e.title != title) text.append("\n").append(title = e.title).append("\n");
        std::string lines = "  --" + std::string(e.row.name) + " " + std::string(e.row.value);
        lines.resize(std::max(lines.size() + 1, indent), ' ');
        auto const meaning = e.without.empty() ? e.row.help() : std::string(e.without);
        std::size_t column = lines.size();
        for (std::size_t at = 0; at < meaning.size();) { // word by word
            auto const end = std::min(meaning.find(' ', at), meaning.size());
            bool const begins = lines.ends_with(' ');
            if (column + (begins ? 0 : 1) + end - at > width) {
                lines.append("\n").append(indent, ' ');
                column = indent;
            } else if (!begins) {
                lines += ' ';
                ++column;
            }
            lines.append(meaning, at, end - at);
            column += end - at;
            at = end + 1;
        }
        (e.without.empty() ? text : refused) += lines + "\n";
    }
    return text + (refused.empty() ? "" : "\nNot taken, and why\n" + refused) + end_;
}

} // namespace shared

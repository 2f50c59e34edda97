#include "option_table.hpp"
#include "text.hpp"
#include <stdexcept>
#include <tilemesh/error.hpp>

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
    return tilemesh::render::Values{}.text(value);
}

} // namespace

tilemesh::render::Values OptionRow::values() const
{
    using tilemesh::render::Values;
    bool const is_whole = form == Form::whole || form == Form::size;
    return {is_whole ? Values::whole : form == Form::word ? Values::word : Values::number, least, most, unit, words};
}

std::string OptionRow::takes() const
{
    if (!why.empty()) return std::string(why);
    auto const range = " from " + digits(least) + " to " + digits(most);
    switch (form) {
    case Form::whole:
    case Form::number:
    case Form::word:
        return values().takes();
    case Form::size:
        return "it takes WxH, a width and a height: two whole numbers" + range;
    case Form::three:
        return "it takes " + std::string(value) + ", three numbers" + range + (unit.empty() ? "" : ", in " + std::string(unit));
    default:
        return "it takes " + std::string(value);
    }
}

std::string OptionRow::help() const
{
    std::string text(meaning);
    std::string list;
    for (auto const& one : words) list.append(list.empty() ? "" : " | ").append(one.word);
    if (auto const at = text.find("{}"); at != std::string::npos) text.replace(at, 2, words.empty() ? digits(least) + " to " + digits(most) : list);
    return standard.empty() ? text : text + " [" + std::string(standard) + "]";
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
        if (auto const n = values().read(text)) out.whole = static_cast<std::uint64_t>(*n);
        else good = false;
        break;
    case Form::number:
        if (auto const n = values().read(text)) out.number = *n;
        else good = false;
        break;
    case Form::word:
        good = false;
        break;
    case Form::size:
        parts(2, 'x', [&](std::string_view part) { return values().read(part); });
        break;
    case Form::three:
        parts(3, ',', [&](std::string_view part) { return values().read(part); });
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
        if (!row.repeats && is_given(row.name)) {
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

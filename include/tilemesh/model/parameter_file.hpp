#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>
#include <vector>

// The numbers of a model as text: `KEYWORD NAME`, then one parameter a line, `name value unit source`; `#` begins a comment line.
namespace tilemesh { inline namespace v0_2 { namespace model_detail {

/// A number of a model, as a file holds it.
struct ParameterRule {
    std::string name;
    std::string_view unit;
    std::uint64_t least, most;
    bool optional = false; ///< a file may leave it out
};
inline std::string range_text(ParameterRule const& rule)
{
    return "from " + std::to_string(rule.least) + " to " + std::to_string(rule.most);
}

inline constexpr std::string_view file_blanks = " \t\r\v\f";
/// A limit that no program reaches: a program counts at most eight operations per step. It bounds the memory: about 40 MB with the longest
/// sources.
inline constexpr std::size_t most_operations = 16384;
/// The longest line that is read, and the longest name and source that are written, in bytes: a sentence or two.
inline constexpr std::size_t most_line_bytes = 4096, most_text_bytes = 2048;

inline bool is_control(char c) noexcept
{
    auto const byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f;
}
/// A text for one line of an error.
inline std::string shown(std::string_view text)
{
    constexpr std::size_t most = 200;
    std::string out(text.substr(0, most));
    for (char& c : out)
        if (is_control(c) || static_cast<unsigned char>(c) >= 0x80) c = '?';
    return text.size() > most ? out + "..." : out;
}
/// Can the text be the rest of a line, so that reading returns what was written?
inline bool fits_a_line(std::string_view text)
{
    return !text.empty() && text.size() <= most_text_bytes && std::none_of(text.begin(), text.end(), is_control) && text.front() != ' ' &&
           text.back() != ' ';
}
inline std::string_view without_blanks(std::string_view text)
{
    text.remove_prefix(std::min(text.find_first_not_of(file_blanks), text.size()));
    return text.substr(0, text.find_last_not_of(file_blanks) + 1);
}
inline std::string_view take_word(std::string_view& text)
{
    text = without_blanks(text);
    std::string_view const word = text.substr(0, text.find_first_of(file_blanks));
    text = without_blanks(text.substr(word.size()));
    return word;
}
/// Can this text name an operation in a file? It must be a word of printable ASCII that does not begin a comment.
inline bool is_operation_name(std::string_view name)
{
    constexpr std::size_t most = 64;
    return !name.empty() && name.size() <= most && name.front() != '#' &&
           std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 0x7f; });
}
/// Throws an `Error` that names the parameter if its source is not one line of text.
inline void expect_source(std::string_view name, std::string_view source)
{
    if (!fits_a_line(source))
        throw Error("parameter " + std::string(name) + " has no source that a file can hold (one line of 1 to " + std::to_string(most_text_bytes) +
                    " bytes, without blanks around it); say where its value is from");
}
inline void expect_in_range(ParameterRule const& rule, std::uint64_t value)
{
    if (value < rule.least || value > rule.most)
        throw Error("parameter " + rule.name + " cannot be " + std::to_string(value) + " (it goes " + range_text(rule) + " " +
                    std::string(rule.unit) + "); give it a value in this range");
}
/// The line of a parameter. Its columns are as wide as the longest names and units of a cost model.
inline std::string parameter_line(std::string_view name, std::string_view value, std::string_view unit, std::string_view source)
{
    std::string line(name);
    line.resize(std::max<std::size_t>(line.size(), 13), ' ');
    (line += ' ') += value;
    line.resize(std::max<std::size_t>(line.size(), 23), ' ');
    (line += ' ') += unit;
    line.resize(std::max<std::size_t>(line.size(), 35), ' ');
    return ((line += ' ') += source) += '\n';
}

/// Reads such a file: each parameter at most once, in any order. Throws `Error`, one line that names the file and the line, for any other
/// text.
class ParameterFile {
public:
    /// The beginning of a file, and the names of its content in errors.
    struct Kind {
        std::string keyword, what, a_what;
        std::string_view unit;  ///< a line with this unit and a name without a rule is an operation's; empty: there are none
        std::uint64_t most = 0; ///< the largest value of an operation
        bool network = false;   ///< `network` and names that begin with `network.` are no operations
    };
    ParameterFile(std::istream& in, std::string const& file_name, Kind kind, std::vector<ParameterRule> rules)
        : in_(in), file_name_(file_name), kind_(std::move(kind)), rules_(std::move(rules)), known_(rules_.size()), seen_(known_, 0)
    {
        for (std::size_t i = 0; i < known_; ++i) places_.emplace(rules_[i].name, i);
    }

    std::string const& name() const noexcept { return name_; }

    /// `word(index, text, refuse)` returns the value of a parameter that is not a number, and nothing for a number. `set(Parameter)` takes
    /// each parameter.
    template <class Word, class Set>
    void read(Word const& word, Set const& set)
    {
        std::string buffer(most_line_bytes + 1, '\0');
        for (;;) {
            in_.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
            auto const taken = static_cast<std::size_t>(in_.gcount());
            if (in_.bad())
                throw Error(shown(file_name_) + " cannot be read to its end (the system reports a read error after line " + std::to_string(number_) +
                            "); check the disk or copy the file");
            if (in_.fail() && taken == 0) break;
            ++number_;
            if (in_.fail())
                refuse("is too long", "more than " + std::to_string(most_line_bytes) + " bytes", "shorten its source, or name " + kind_.a_what);
            line(std::string_view(buffer).substr(0, taken - (in_.eof() ? 0 : 1)), word, set);
        }
        if (name_.empty()) refuse("ends the file", "it holds no " + kind_.what, "begin it with \"" + kind_.keyword + " NAME\"");
    }
    /// Throws `Error` if a parameter was left out that is not optional.
    void expect_all() const
    {
        for (std::size_t i = 0; i < rules_.size(); ++i)
            if (seen_[i] == 0 && !rules_[i].optional) {
                auto const& name = rules_[i].name;
                refuse("ends the file", "parameter " + name + " is missing", "add \"" + name + " VALUE " + std::string(rules_[i].unit) + " SOURCE\"");
            }
    }

private:
    [[noreturn]] void refuse(std::string const& problem, std::string const& why, std::string const& todo) const
    {
        throw Error(shown(file_name_) + " line " + std::to_string(number_) + " " + problem + " (" + why + "); " + todo);
    }
    /// The names of the parameters that have a rule: those that a file must have, or the optional ones.
    std::string all_names(bool optional = false) const
    {
        std::string all;
        for (std::size_t i = 0; i < known_; ++i)
            if (rules_[i].optional == optional) all += (all.empty() ? "" : ", ") + rules_[i].name;
        return all;
    }

    template <class Word, class Set>
    void line(std::string_view rest, Word const& word, Set const& set)
    {
        rest = without_blanks(rest);
        if (rest.empty() || rest.front() == '#') return;
        if (std::any_of(rest.begin(), rest.end(), [](char c) { return is_control(c) && c != '\t'; }))
            refuse("cannot be read", "it holds a control character", "name a text file");

        auto const first = take_word(rest);
        if (name_.empty()) {
            if (first != kind_.keyword)
                refuse("begins no " + kind_.what, "it is not \"" + kind_.keyword + " NAME\"", "put that before the parameters");
            if (!fits_a_line(rest)) refuse("names no model", "after \"" + kind_.keyword + "\" is no name of 1 to 2,048 bytes", "name the model");
            name_ = rest;
            return;
        }
        if (first == kind_.keyword) refuse("names a second model", "a file holds one", "remove this line, or split the file");
        auto const [place, is_new] = places_.emplace(first, rules_.size());
        if (is_new) {
            auto after = rest;
            take_word(after);
            bool const of_network = first == "network" || first.substr(0, 8) == "network.";
            auto const unit = take_word(after);
            if (!kind_.unit.empty() && !of_network && is_operation_name(first) && unit != kind_.unit && unit.ends_with(kind_.unit.substr(1)))
                refuse("has another unit", shown(first) + " is in " + std::string(kind_.unit) + ", not in \"" + shown(unit) + "\"",
                       "convert the value");
            if (kind_.unit.empty() || (kind_.network && of_network) || !is_operation_name(first) || unit != kind_.unit)
                refuse("has an unknown parameter", "\"" + shown(first) + "\"",
                       "use " + all_names(of_network) +
                           (kind_.unit.empty() ? "" : ", or the name of an operation and the unit " + std::string(kind_.unit)));
            if (rules_.size() == known_ + most_operations)
                refuse("has one operation more than " + std::to_string(most_operations), "\"" + shown(first) + "\"",
                       "name those that the program counts");
            rules_.push_back({std::string(first), kind_.unit, 0, kind_.most});
            seen_.push_back(0);
        }
        std::size_t const at = place->second;
        auto const& rule = rules_[at];
        std::string const known = rule.name, unit(rule.unit);
        if (seen_[at] != 0) refuse("repeats a parameter", known + " is in line " + std::to_string(seen_[at]), "remove one of them");
        seen_[at] = number_;

        auto const text = take_word(rest);
        auto const refuse_this = [this](auto const&... why) { refuse(why...); };
        auto const known_word = word(at, text, refuse_this);
        auto const value = known_word ? *known_word : whole_number(rule, text);
        auto const said = take_word(rest);
        if (said.empty()) refuse("has no unit", known + " is in " + unit, "write it after the value");
        if (said != unit) refuse("has another unit", known + " is in " + unit + ", not in \"" + shown(said) + "\"", "convert the value");
        std::string source(rest);
        std::replace(source.begin(), source.end(), '\t', ' ');
        if (source.empty()) refuse("has no source", known + " is from nowhere", "write after the unit where the value is from, or \"fitted to ...\"");
        if (source.size() > most_text_bytes)
            refuse("has too long a source", std::to_string(source.size()) + " bytes", "shorten it to " + std::to_string(most_text_bytes));
        set(ModelParameter{known, value, unit, std::move(source)});
    }
    std::uint64_t whole_number(ParameterRule const& rule, std::string_view word) const
    {
        auto const& known = rule.name;
        std::uint64_t value = 0;
        auto const [end, error] = read_number(word.data(), word.data() + word.size(), value);
        bool const whole = end == word.data() + word.size();
        if (!whole || error == std::errc::invalid_argument)
            refuse("has no whole number", known + " is \"" + shown(word) + "\"", "write digits only, " + range_text(rule));
        if (error != std::errc{} || value < rule.least || value > rule.most)
            refuse("is out of range", known + " is " + shown(word), "write a value " + range_text(rule) + " " + std::string(rule.unit));
        return value;
    }

    std::istream& in_;
    std::string const& file_name_;
    Kind kind_;
    std::vector<ParameterRule> rules_;
    std::size_t known_;                         ///< number of rules from the constructor; the rules of operations follow them
    std::vector<std::uint64_t> seen_;           ///< the line of each rule; 0: none
    std::map<std::string, std::size_t> places_; ///< of each rule, by name
    std::string name_;
    std::uint64_t number_ = 0; ///< of the line
};

}}} // namespace tilemesh::v0_2::model_detail

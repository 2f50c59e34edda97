#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
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
TILEMESH_HOST std::string range_text(ParameterRule const& rule);

inline constexpr std::string_view file_blanks = " \t\r\v\f";
/// A limit that no program reaches: a program counts at most eight operations per step. It bounds the memory: about 40 MB with the longest
/// sources.
inline constexpr std::size_t most_operations = 16384;
/// The longest line that is read, and the longest name and source that are written, in bytes: a sentence or two.
inline constexpr std::size_t most_line_bytes = 4096, most_text_bytes = 2048;

TILEMESH_HOST bool is_control(char c) noexcept;
/// A text for one line of an error.
TILEMESH_HOST std::string shown(std::string_view text);
/// Can the text be the rest of a line, so that reading returns what was written?
TILEMESH_HOST bool fits_a_line(std::string_view text);
TILEMESH_HOST std::string_view without_blanks(std::string_view text);
TILEMESH_HOST std::string_view take_word(std::string_view& text);
/// Can this text name an operation in a file? It must be a word of printable ASCII that does not begin a comment.
TILEMESH_HOST bool is_operation_name(std::string_view name);
/// Throws an `Error` that names the parameter if its source is not one line of text.
TILEMESH_HOST void expect_source(std::string_view name, std::string_view source);
TILEMESH_HOST void expect_in_range(ParameterRule const& rule, std::uint64_t value);
/// The line of a parameter. Its columns are as wide as the longest names and units of a cost model.
TILEMESH_HOST std::string parameter_line(std::string_view name, std::string_view value, std::string_view unit,
                                         std::string_view source);

/// Reads such a file: each parameter at most once, in any order. Throws `Error`, one line that names the file and the line, for any other
/// text.
class ParameterFile {
public:
    /// The beginning of a file, and the names of its content in errors.
    struct Kind {
        std::string keyword, what, a_what;
        std::string_view unit;   ///< a line with this unit and a name without a rule is an operation's; empty: there are none
        std::uint64_t most = 0;  ///< the largest value of an operation
        bool network = false;    ///< `network` and names that begin with `network.` are no operations
    };
    TILEMESH_HOST ParameterFile(std::istream& in, std::string const& file_name, Kind kind,
                                std::vector<ParameterRule> rules);

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
                throw Error(shown(file_name_) + " cannot be read to its end (the system reports a read error after line " +
                            std::to_string(number_) + "); check the disk or copy the file");
            if (in_.fail() && taken == 0) break;
            ++number_;
            if (in_.fail())
                refuse("is too long", "more than " + std::to_string(most_line_bytes) + " bytes",
                       "shorten its source, or name " + kind_.a_what);
            line(std::string_view(buffer).substr(0, taken - (in_.eof() ? 0 : 1)), word, set);
        }
        if (name_.empty())
            refuse("ends the file", "it holds no " + kind_.what, "begin it with \"" + kind_.keyword + " NAME\"");
    }
    /// Throws `Error` if a parameter was left out that is not optional.
    TILEMESH_HOST void expect_all() const;

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& problem, std::string const& why,
                                           std::string const& todo) const;
    /// The names of the parameters that have a rule: those that a file must have, or the optional ones.
    TILEMESH_HOST std::string all_names(bool optional = false) const;

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
            if (!fits_a_line(rest))
                refuse("names no model", "after \"" + kind_.keyword + "\" is no name of 1 to 2,048 bytes", "name the model");
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
        if (seen_[at] != 0)
            refuse("repeats a parameter", known + " is in line " + std::to_string(seen_[at]), "remove one of them");
        seen_[at] = number_;

        auto const text = take_word(rest);
        auto const refuse_this = [this](auto const&... why) { refuse(why...); };
        auto const known_word = word(at, text, refuse_this);
        auto const value = known_word ? *known_word : whole_number(rule, text);
        auto const said = take_word(rest);
        if (said.empty()) refuse("has no unit", known + " is in " + unit, "write it after the value");
        if (said != unit)
            refuse("has another unit", known + " is in " + unit + ", not in \"" + shown(said) + "\"", "convert the value");
        std::string source(rest);
        std::replace(source.begin(), source.end(), '\t', ' ');
        if (source.empty())
            refuse("has no source", known + " is from nowhere",
                   "write after the unit where the value is from, or \"fitted to ...\"");
        if (source.size() > most_text_bytes)
            refuse("has too long a source", std::to_string(source.size()) + " bytes",
                   "shorten it to " + std::to_string(most_text_bytes));
        set(ModelParameter{known, value, unit, std::move(source)});
    }
    TILEMESH_HOST std::uint64_t whole_number(ParameterRule const& rule, std::string_view word) const;

    std::istream& in_;
    std::string const& file_name_;
    Kind kind_;
    std::vector<ParameterRule> rules_;
    std::size_t known_;                         ///< number of rules from the constructor; the rules of operations follow them
    std::vector<std::uint64_t> seen_;           ///< the line of each rule; 0: none
    std::map<std::string, std::size_t> places_; ///< of each rule, by name
    std::string name_;
    std::uint64_t number_ = 0;                  ///< of the line
};

}}} // namespace tilemesh::model_detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/parameter_file_code.hpp>
#endif

#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <tilemesh/number_text.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace model_detail {

TILEMESH_HOST std::string range_text(ParameterRule const& rule)
{
    return "from " + std::to_string(rule.least) + " to " + std::to_string(rule.most);
}

TILEMESH_HOST bool is_control(char c) noexcept
{
    auto const byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f;
}

TILEMESH_HOST std::string shown(std::string_view text)
{
    constexpr std::size_t most = 200;
    std::string out(text.substr(0, most));
    for (char& c : out)
        if (is_control(c) || static_cast<unsigned char>(c) >= 0x80) c = '?';
    return text.size() > most ? out + "..." : out;
}

TILEMESH_HOST bool fits_a_line(std::string_view text)
{
    return !text.empty() && text.size() <= most_text_bytes && std::none_of(text.begin(), text.end(), is_control) &&
           text.front() != ' ' && text.back() != ' ';
}

TILEMESH_HOST std::string_view without_blanks(std::string_view text)
{
    text.remove_prefix(std::min(text.find_first_not_of(file_blanks), text.size()));
    return text.substr(0, text.find_last_not_of(file_blanks) + 1);
}

TILEMESH_HOST std::string_view take_word(std::string_view& text)
{
    text = without_blanks(text);
    std::string_view const word = text.substr(0, text.find_first_of(file_blanks));
    text = without_blanks(text.substr(word.size()));
    return word;
}

TILEMESH_HOST bool is_operation_name(std::string_view name)
{
    constexpr std::size_t most = 64;
    return !name.empty() && name.size() <= most && name.front() != '#' &&
           std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 0x7f; });
}

TILEMESH_HOST void expect_source(std::string_view name, std::string_view source)
{
    if (!fits_a_line(source))
        throw Error("parameter " + std::string(name) + " has no source that a file can hold (one line of 1 to " +
                    std::to_string(most_text_bytes) + " bytes, without blanks around it); say where its value is from");
}

TILEMESH_HOST void expect_in_range(ParameterRule const& rule, std::uint64_t value)
{
    if (value < rule.least || value > rule.most)
        throw Error("parameter " + rule.name + " cannot be " + std::to_string(value) + " (it goes " +
                    range_text(rule) + " " + std::string(rule.unit) + "); give it a value in this range");
}

TILEMESH_HOST std::string parameter_line(std::string_view name, std::string_view value, std::string_view unit, std::string_view source)
{
    std::string line(name);
    line.resize(std::max<std::size_t>(line.size(), 13), ' ');
    (line += ' ') += value;
    line.resize(std::max<std::size_t>(line.size(), 23), ' ');
    (line += ' ') += unit;
    line.resize(std::max<std::size_t>(line.size(), 35), ' ');
    return ((line += ' ') += source) += '\n';
}

TILEMESH_HOST ParameterFile::ParameterFile(std::istream& in, std::string const& file_name, Kind kind, std::vector<ParameterRule> rules)
    : in_(in), file_name_(file_name), kind_(std::move(kind)), rules_(std::move(rules)), known_(rules_.size()), seen_(known_, 0)
{
    for (std::size_t i = 0; i < known_; ++i) places_.emplace(rules_[i].name, i);
}

TILEMESH_HOST void ParameterFile::expect_all() const
{
    for (std::size_t i = 0; i < rules_.size(); ++i)
        if (seen_[i] == 0 && !rules_[i].optional) {
            auto const& name = rules_[i].name;
            refuse("ends the file", "parameter " + name + " is missing",
                   "add \"" + name + " VALUE " + std::string(rules_[i].unit) + " SOURCE\"");
        }
}

TILEMESH_HOST void ParameterFile::refuse(std::string const& problem, std::string const& why, std::string const& todo) const
{
    throw Error(shown(file_name_) + " line " + std::to_string(number_) + " " + problem + " (" + why + "); " + todo);
}

TILEMESH_HOST std::string ParameterFile::all_names(bool optional) const
{
    std::string all;
    for (std::size_t i = 0; i < known_; ++i)
        if (rules_[i].optional == optional) all += (all.empty() ? "" : ", ") + rules_[i].name;
    return all;
}

TILEMESH_HOST std::uint64_t ParameterFile::whole_number(ParameterRule const& rule, std::string_view word) const
{
    auto const& known = rule.name;
    std::uint64_t value = 0;
    auto const [end, error] = read_number(word.data(), word.data() + word.size(), value);
    bool const whole = end == word.data() + word.size();
    if (!whole || error == std::errc::invalid_argument)
        refuse("has no whole number", known + " is \"" + shown(word) + "\"", "write digits only, " + range_text(rule));
    if (error != std::errc{} || value < rule.least || value > rule.most)
        refuse("is out of range", known + " is " + shown(word),
               "write a value " + range_text(rule) + " " + std::string(rule.unit));
    return value;
}

}}} // namespace tilemesh::model_detail

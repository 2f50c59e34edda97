#include "option_values.hpp"
#include "text.hpp"
#include <charconv>
#include <cstdlib>
#include <system_error>
#include <tilemesh/error.hpp>

namespace shared {

using tilemesh::Error;

void OptionValues::refuse(std::string_view option, std::string_view text, std::string const& why) const
{
    throw Error(std::string(option) + " cannot be \"" + one_line(text, 200) + "\" (" + why + "); see " + program_ + " --help");
}

std::uint32_t OptionValues::whole(std::string_view option, std::string_view text, std::uint32_t least, std::uint32_t most) const
{
    std::uint32_t value = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < least || value > most)
        refuse(option, text, "it takes a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return value;
}

double OptionValues::number(std::string_view option, std::string_view text, double least, double most, std::string const& range) const
{
    std::string const copy(text); // it ends with 0
    char* end = nullptr;
    double const out = std::strtod(copy.c_str(), &end);
    if (text.empty() || end != copy.c_str() + copy.size() || !(out >= least && out <= most)) refuse(option, text, "it takes a number " + range);
    return out;
}

std::string_view OptionValues::next(int argc, char** argv, int& i) const
{
    if (i + 1 == argc || argv[i + 1][0] == '\0') throw Error(std::string(argv[i]) + " has no value (it takes one); see " + program_ + " --help");
    return argv[++i];
}

} // namespace shared

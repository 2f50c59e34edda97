#include "options.hpp"
#include <cstdlib>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>

namespace bench {

namespace {

using tilemesh::Error;

std::string in_quotes(std::string const& text)
{
    return "\"" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "\"";
}

} // namespace

bool Words::next()
{
    if (at_ == words_.size()) return false;
    auto const equals = words_[at_].find('=');
    has_value_ = equals != std::string::npos;
    option_ = words_[at_++].substr(0, equals);
    return true;
}

void Words::flag() const
{
    if (has_value_) throw Error(option_ + " has a value (it takes none); leave out what is behind =");
}

std::string Words::value()
{
    if (has_value_) return words_[at_ - 1].substr(words_[at_ - 1].find('=') + 1);
    if (at_ == words_.size()) throw Error(option_ + " has no value (it is the last word); write one behind it");
    return words_[at_++];
}

std::filesystem::path Words::path()
{
    auto const text = value();
    if (text.empty()) throw Error(option_ + " has an empty value (it takes a path); write one behind it");
    return text;
}

std::uint32_t Words::number(std::uint32_t least, std::uint32_t most)
{
    auto const text = value();
    auto const n = tilemesh::number_of<std::uint32_t>(text);
    if (!n || *n < least || *n > most)
        throw Error(option_ + " cannot be " + in_quotes(text) + " (it takes a whole number from " + std::to_string(least) +
                    " to " + std::to_string(most) + "); write for example " + option_ + " " +
                    std::to_string(std::min(most, least + 1)));
    return *n;
}

std::string Words::one_of(std::vector<std::string> const& names)
{
    auto text = value();
    if (std::find(names.begin(), names.end(), text) != names.end()) return text;
    std::string all;
    for (auto const& name : names) all += (all.empty() ? "" : ", ") + name;
    throw Error(option_ + " cannot be " + in_quotes(text) + " (it is one of " + all + "); choose one of these");
}

void Words::refuse() const
{
    throw Error(in_quotes(words_[at_ - 1]) + " is no option (see --help); leave it out");
}

bool Options::take(Words& words, bool may_spoil)
{
    if (words.option() == "--help" || words.option() == "--quick") {
        words.flag();
        (words.option() == "--help" ? help : quick) = true;
    } else if (may_spoil && words.option() == "--spoil") {
        words.flag();
        spoil = true;
    } else if (words.option() == "--csv") {
        csv = words.path();
    } else if (words.option() == "--data") {
        data = words.path();
        data_given_ = true;
    } else {
        return false;
    }
    return true;
}

void Options::finish()
{
    if (!data_given_ && !help) {
        if (char const* const folder = std::getenv("TILEMESH_DATA")) data = folder;
    }
    if (!data.empty() && std::filesystem::is_directory(data / "maps")) return;
    if (data_given_)
        throw Error("--data cannot be " + in_quotes(data.string()) +
                    " (there is no folder maps in it); name the folder that holds maps/, "
                    "trajectories/ and cameras.json");
    data.clear();
}

void expect_folder_of(std::filesystem::path const& file)
{
    if (!file.empty() && file.has_parent_path() && !std::filesystem::is_directory(file.parent_path()))
        throw Error("cannot write " + file.string() + " (its folder is not there); make the folder, or name another file");
    if (std::filesystem::is_directory(file)) throw Error("cannot write " + file.string() + " (it is a folder); name a file");
}

} // namespace bench

#pragma once
#include <algorithm>
#include <cerrno>
#include <new>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/text_input.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST std::size_t character_bytes(std::string_view text)
{
    auto const byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    unsigned const lead = byte(0);
    if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
    if (lead < 0xc2 || lead > 0xf4) return 0;
    std::size_t const bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    unsigned code = lead & (0x7fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        code = (code << 6) | (byte(i) & 0x3f);
    }
    unsigned const least = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0xa0;
    bool const surrogate = code >= 0xd800 && code <= 0xdfff;
    bool const separator = code == 0x2028 || code == 0x2029;
    return code < least || code > 0x10ffff || surrogate || separator ? 0 : bytes;
}

TILEMESH_HOST std::string shown(std::string_view text, std::size_t most)
{
    std::string out;
    while (!text.empty() && out.size() < most) {
        std::size_t const bytes = character_bytes(text);
        if (bytes == 0) out += '?';
        else out.append(text.substr(0, bytes));
        text.remove_prefix(bytes == 0 ? 1 : bytes);
    }
    if (!text.empty()) out += "...";
    return out;
}

TILEMESH_HOST std::string shown_path(std::filesystem::path const& path)
{
    std::string const text = path.string();
    return shown(text, text.size());
}

TILEMESH_HOST bool is_plain(std::string_view text)
{
    while (!text.empty()) {
        std::size_t const bytes = character_bytes(text);
        if (bytes == 0) return false;
        text.remove_prefix(bytes);
    }
    return true;
}

TILEMESH_HOST std::string with_slashes(std::string_view name)
{
    std::string out(name);
    std::replace(out.begin(), out.end(), '\\', '/');
    return out;
}

TILEMESH_HOST std::string_view take_word(std::string_view& text)
{
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    std::string_view const word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

TILEMESH_HOST bool is_tiny(std::string_view number)
{
    std::size_t const e = std::min(number.find_first_of("eE"), number.size());
    std::string_view const digits = number.substr(0, e);
    auto const first = static_cast<std::int64_t>(std::min(digits.find_first_of("123456789"), digits.size()));
    auto const point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
    std::int64_t const place = first < point ? point - first - 1 : point - first;

    std::string_view written = number.substr(std::min(e + 1, number.size()));
    if (written.starts_with('+')) written.remove_prefix(1);
    std::int64_t exponent = 0;
    auto const [end, error] = read_number(written.data(), written.data() + written.size(), exponent);
    if (error == std::errc::result_out_of_range) return written.starts_with('-');
    return exponent < -place;
}

TILEMESH_HOST void refuse_stand_in(std::string_view begin, std::string const& file)
{
    if (begin.starts_with(stand_ins.front()))
        throw Error(file + " is a pointer of git LFS (the file itself is not here); run git lfs pull, or download the file");
    if (std::any_of(stand_ins.begin() + 1, stand_ins.end(), [&](std::string_view each) { return begin.starts_with(each); }))
        throw Error(file + " is a web page (a server or a viewer wrote HTML in place of the file); "
                           "download the file itself, or export it from the viewer");
}

TILEMESH_HOST std::ifstream open_file(std::filesystem::path const& path, std::uint64_t most_bytes, std::string const& wanted)
{
    namespace fs = std::filesystem;
    std::string const name = shown_path(path);
    std::error_code failed;
    fs::file_status const status = fs::status(path, failed);
    if (status.type() == fs::file_type::not_found) throw Error(name + " cannot be opened (no such file); check the path");
    if (status.type() == fs::file_type::none) throw Error(name + " cannot be opened (" + failed.message() + "); check the path");
    if (fs::is_directory(status)) throw Error(name + " cannot be read (it is a directory); name " + wanted);
    if (!fs::is_regular_file(status)) throw Error(name + " cannot be read (it is a pipe or a device); copy it to a file, and name " + wanted);
    std::uint64_t const bytes = fs::file_size(path, failed);
    if (!failed && bytes > most_bytes)
        throw Error(name + " is too long (" + std::to_string(bytes) + " bytes, " + std::to_string(most_bytes) + " are read); name " + wanted);
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    if (stream) {
        std::array<char, 24> begin{};
        stream.read(begin.data(), begin.size());
        refuse_stand_in({begin.data(), static_cast<std::size_t>(stream.gcount())}, name);
        stream.clear();
        stream.seekg(0);
        return stream;
    }
    if (errno == ENOMEM) throw std::bad_alloc();
    if (errno == EACCES) throw Error(name + " cannot be opened (no permission); check its access rights");
    throw Error(name + " cannot be opened (" + std::generic_category().message(errno) + "); try again, or copy the file");
}

TILEMESH_HOST bool LineReader::next()
{
    bool const there = next_part();
    if (!whole_) throw Error(place() + " is too long (more than " + std::to_string(most_bytes) + " bytes); name a text file");
    return there;
}

TILEMESH_HOST bool LineReader::next_part()
{
    if (whole_) ++number_;
    stream_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    auto const taken = static_cast<std::size_t>(stream_.gcount());
    if (stream_.bad()) throw Error(name_ + " cannot be read to its end (the system reports a read error); check the disk or copy the file");
    bool const first = number_ == 1 && whole_;
    whole_ = !stream_.fail() || taken == 0;
    bool const there = !stream_.fail() || taken > 0;
    if (!whole_) stream_.clear(stream_.rdstate() & ~std::ios::failbit);
    bool const ends_in_lf = there && whole_ && !stream_.eof();
    text_ = std::string_view(buffer_).substr(0, taken - (ends_in_lf ? 1 : 0));
    if (whole_ && text_.ends_with('\r')) text_.remove_suffix(1);
    if (first && text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
    return there;
}

}}} // namespace tilemesh::scene

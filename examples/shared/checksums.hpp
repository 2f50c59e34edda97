#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace shared {

namespace detail {
constexpr std::array<std::uint32_t, 256> make_crc_table()
{
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < 256; ++n) {
        table[n] = n;
        for (int bit = 0; bit < 8; ++bit) table[n] = (table[n] & 1u) != 0 ? 0xedb88320u ^ table[n] >> 1 : table[n] >> 1;
    }
    return table;
}
inline constexpr auto crc_table = make_crc_table();
} // namespace detail

/// The CRC-32 of a chunk's name and bytes (PNG specification, annex D).
constexpr std::uint32_t crc32(std::string_view bytes) noexcept
{
    std::uint32_t crc = 0xffffffffu;
    for (char const c : bytes) crc = detail::crc_table[(crc ^ static_cast<unsigned char>(c)) & 0xffu] ^ crc >> 8;
    return crc ^ 0xffffffffu;
}
static_assert(crc32("123456789") == 0xcbf43926u, "the check value of CRC-32");

/// The Adler-32 of bytes that come piece by piece (RFC 1950, section 9).
class Adler32 {
public:
    constexpr void add(std::string_view bytes) noexcept
    {
        while (!bytes.empty()) {
            auto const piece = bytes.substr(0, 5552); // the longest piece whose sums stay below 2^32, as zlib computes it
            for (char const c : piece) {
                a_ += static_cast<unsigned char>(c);
                b_ += a_;
            }
            a_ %= 65521u;
            b_ %= 65521u;
            bytes.remove_prefix(piece.size());
        }
    }
    constexpr std::uint32_t value() const noexcept { return b_ << 16 | a_; }

private:
    std::uint32_t a_ = 1, b_ = 0;
};

} // namespace shared

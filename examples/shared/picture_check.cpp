#include "picture_check.hpp"
#include "checksums.hpp"
#include "jpeg_scan.hpp"
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace shared {

namespace {

using Bytes = std::span<unsigned char const>;

/// Damage that is found deep inside. It ends in `picture_damage`.
struct Damage {
    char const* what;
};

std::uint32_t word_at(Bytes bytes, std::size_t at)
{
    return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 | std::uint32_t{bytes[at + 2]} << 8 | bytes[at + 3];
}
std::string_view text_of(Bytes bytes)
{
    return {reinterpret_cast<char const*>(bytes.data()), bytes.size()};
}

// --- JPEG --------------------------------------------------------------------------------------

constexpr char const* impossible_table = "a Huffman table has more codes than there can be";

/// Where a JPEG goes on behind its first marker, FF D8. The FF may stand several times. 0: it is no JPEG.
std::size_t begin_of_jpeg(Bytes bytes)
{
    std::size_t at = 0;
    while (at < bytes.size() && bytes[at] == 0xff) ++at;
    return at > 0 && at < bytes.size() && bytes[at] == 0xd8 ? at + 1 : 0;
}

/// The tables that a JPEG has defined so far, and those that its components are multiplied by.
struct JpegTables {
    std::array<std::array<bool, 4>, 2> huffman{}; ///< of DC, of AC
    std::array<bool, 4> quantization{}, multiplied{};
    bool progressive = false;

    /// Can the tables of a segment DHT be? A table is a byte, the numbers of codes of 1 to 16 bits, and a byte for each code (ITU T.81,
    /// B.2.4.2). There are at most 256 symbols, and no more codes than the shorter ones leave room for. Segments are without their lengths.
    bool add_huffman(Bytes segment, JpegScans* scans = nullptr)
    {
        while (!segment.empty()) {
            if (segment.size() < 17) return false;
            std::uint32_t codes = 0, free = 1;
            for (std::size_t bits = 1; bits <= 16; ++bits) {
                free = 2 * free;
                if (segment[bits] > free) return false;
                free -= segment[bits];
                codes += segment[bits];
            }
            if (codes > 256 || segment.size() < 17 + codes) return false;
            if (segment[0] < 32 && segment[0] % 16 < 4) huffman[segment[0] / 16][segment[0] % 16] = true;
            if (scans != nullptr) scans->add_code(segment[0], segment.subspan(1, 16), segment.subspan(17, codes));
            segment = segment.subspan(17 + codes);
        }
        return true;
    }
    void add_quantization(Bytes segment) // B.2.4.1: 64 numbers of 8 or 16 bits
    {
        while (!segment.empty()) {
            quantization[segment[0] % 4] = true;
            segment = segment.subspan(std::min<std::size_t>(segment.size(), segment[0] < 16 ? 65 : 129));
        }
    }
    void add_frame(Bytes segment, bool is_progressive) // B.2.2: each component has three bytes
    {
        progressive = is_progressive;
        for (std::size_t at = 8; at < segment.size(); at += 3) multiplied[segment[at] % 4] = true;
    }
    /// Has a scan (B.2.3) the Huffman tables that it reads? A progressive one reads a table for DC or for AC, and for the later bits of DC
    /// none (G.1.1).
    bool has_those_of(Bytes scan) const
    {
        std::size_t const count = scan.empty() ? 0 : scan[0];
        if (scan.size() < 4 + 2 * count) return false;
        bool const first_bits = scan[3 + 2 * count] < 16, begins_with_dc = scan[1 + 2 * count] == 0;
        bool const reads_dc = !progressive || (begins_with_dc && first_bits), reads_ac = !progressive || !begins_with_dc;
        for (std::size_t i = 0; i < count; ++i) {
            auto const tables = scan[2 + 2 * i];
            if ((reads_dc && !huffman[0][tables / 16 % 4]) || (reads_ac && !huffman[1][tables % 4])) return false;
        }
        return true;
    }
    bool has_quantization() const
    {
        for (std::size_t i = 0; i < multiplied.size(); ++i)
            if (multiplied[i] && !quantization[i]) return false;
        return true;
    }
};

/// A segment's length is in its first two bytes; in the data of a scan, FF stands before 00 or a restart marker (ITU T.81, annex B). A
/// decoder fills what a file that is cut short lacks with grey.
std::string_view jpeg_damage(Bytes bytes, std::size_t begin, std::size_t most_bytes)
{
    constexpr std::string_view cut_short = "the file is cut short";
    constexpr std::string_view no_table = "a table that its pixels need is missing";
    JpegTables tables;
    JpegScans scans;
    for (std::size_t at = begin; at + 1 < bytes.size();) {
        unsigned const marker = bytes[at + 1];
        if (bytes[at] != 0xff || marker == 0x00 || (marker >= 0xd0 && marker <= 0xd7)) { // data of a scan
            ++at;
            continue;
        }
        if (marker == 0xff) { // a fill byte
            ++at;
            continue;
        }
        if (marker == 0xd9) return !tables.has_quantization() ? no_table : !scans.complete() ? std::string_view("a part of its pixels is missing") : std::string_view();
        if (at + 3 >= bytes.size()) return cut_short;
        auto const length = std::size_t{bytes[at + 2]} << 8 | bytes[at + 3];
        if (length < 2) return "a segment has no length";
        if (at + 2 + length > bytes.size()) return cut_short;
        auto const segment = bytes.subspan(at + 4, length - 2);
        if (marker == 0xc4 && !tables.add_huffman(segment, &scans)) return impossible_table;
        if (marker == 0xdb) tables.add_quantization(segment);
        if (marker == 0xdd) scans.set_restarts(segment);
        if (marker >= 0xc0 && marker <= 0xc2) {
            tables.add_frame(segment, marker == 0xc2);
            if (!scans.begin(segment, marker == 0xc2, most_bytes)) return "its frame is impossible";
        }
        if (marker == 0xda && !tables.has_those_of(segment)) return no_table;
        at += 2 + length;
        if (marker == 0xda && !scans.read(segment, bytes.subspan(at), at)) return scans.at_end() ? cut_short : "its compressed pixels are damaged";
    }
    return cut_short;
}

// --- PNG ---------------------------------------------------------------------------------------

constexpr std::string_view png_signature("\x89PNG\r\n\x1a\n", 8);

/// The bits of a deflate stream, from the lowest bit of each byte.
class BitReader {
public:
    explicit BitReader(Bytes bytes) : bytes_(bytes) {}

    /// The next 16 bits. Behind the end of the stream they are 0; `take` notices.
    std::uint32_t peek()
    {
        for (; count_ < 16 && at_ < bytes_.size(); count_ += 8) bits_ |= std::uint32_t{bytes_[at_++]} << count_;
        return bits_ & 0xffffu;
    }
    std::uint32_t take(unsigned count)
    {
        auto const bits = peek() & ((1u << count) - 1);
        drop(count);
        return bits;
    }
    /// Of the bits that `peek` has shown.
    void drop(unsigned count)
    {
        if (count > count_) throw Damage{"its compressed pixels end early"};
        bits_ >>= count;
        count_ -= count;
    }
    void drop_to_byte() { drop(count_ % 8); }

private:
    Bytes bytes_;
    std::size_t at_ = 0;
    std::uint32_t bits_ = 0;
    unsigned count_ = 0;
};

/// A canonical Huffman code (RFC 1951, section 3.2.2).
class HuffmanCode {
public:
    /// `lengths`: bits of the code of each symbol, 0 to 15; 0: it has none. A code may be incomplete only if it has one symbol or none, as
    /// zlib's rule is.
    explicit HuffmanCode(Bytes lengths)
    {
        for (auto const length : lengths) ++count_[length];
        count_[0] = 0;
        std::int32_t free = 1;
        std::uint32_t codes = 0;
        for (std::size_t bits = 1; bits < count_.size(); ++bits) {
            free = 2 * free - count_[bits];
            codes += count_[bits];
            if (free < 0) throw Damage{"a code of its compressed pixels is impossible"};
        }
        if (free > 0 && (codes > 1 || count_[1] != codes)) throw Damage{"a code of its compressed pixels is incomplete"};
        std::array<std::uint16_t, 16> next{}; // the place of the next symbol of each length
        for (std::size_t bits = 1; bits + 1 < next.size(); ++bits) next[bits + 1] = static_cast<std::uint16_t>(next[bits] + count_[bits]);
        for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol)
            if (lengths[symbol] != 0) symbols_[next[lengths[symbol]]++] = static_cast<std::uint16_t>(symbol);
        make_short_codes();
    }

    std::uint32_t read(BitReader& from) const
    {
        auto bits = from.peek();
        if (auto const entry = short_[bits % short_.size()]; entry != 0) {
            from.drop(entry & 15u);
            return entry >> 4;
        }
        std::uint32_t code = 0, first = 0, index = 0; // of the codes of this length: the first one, and the place of its symbol
        for (unsigned length = 1; length < count_.size(); ++length, bits >>= 1) {
            code |= bits & 1u;
            if (code < first + count_[length]) {
                from.drop(length);
                return symbols_[index + code - first];
            }
            index += count_[length];
            first = (first + count_[length]) << 1;
            code <<= 1;
        }
        throw Damage{"its compressed pixels have a code that does not exist"};
    }

private:
    /// The codes of up to 9 bits stand in a table, by the next 9 bits of the stream. It makes reading several times as fast.
    void make_short_codes()
    {
        std::uint32_t code = 0, index = 0;
        for (unsigned length = 1; length <= 9; ++length, code <<= 1)
            for (std::uint32_t k = 0; k < count_[length]; ++k, ++code, ++index) {
                std::uint32_t reversed = 0;
                for (unsigned bit = 0; bit < length; ++bit) reversed |= (code >> bit & 1u) << (length - 1 - bit);
                for (auto at = reversed; at < short_.size(); at += 1u << length) short_[at] = static_cast<std::uint16_t>(std::uint32_t{symbols_[index]} << 4 | length);
            }
    }
    std::array<std::uint16_t, 16> count_{};
    std::array<std::uint16_t, 288> symbols_{};
    std::array<std::uint16_t, 512> short_{}; ///< symbol and length; 0: the code is longer, or there is none
};

/// Unpacks a zlib stream into its checksum. A window of 32 KiB is all that it keeps.
class Unpacker {
public:
    Unpacker(Bytes stream, std::size_t most_bytes) : from_(stream), most_(most_bytes) {}

    void check()
    {
        auto const method = from_.take(8), flags = from_.take(8); // RFC 1950, section 2.2
        if ((method & 15u) != 8 || method >> 4 > 7 || (method << 8 | flags) % 31 != 0 || (flags & 32u) != 0) throw Damage{"its compressed pixels have no header of zlib"};
        for (bool last = false; !last;) {
            last = from_.take(1) != 0;
            switch (from_.take(2)) {
            case 0: copy_stored(); break;
            case 1: unpack_with_fixed_codes(); break;
            case 2: unpack_with_own_codes(); break;
            default: throw Damage{"its compressed pixels have a block of no kind"};
            }
        }
        add_window();
        from_.drop_to_byte();
        std::uint32_t sum = 0;
        for (int i = 0; i < 4; ++i) sum = sum << 8 | from_.take(8);
        if (sum != sum_.value()) throw Damage{"the checksum of its pixels is wrong"};
    }

private:
    void put(std::uint32_t byte)
    {
        if (size_ == most_) throw Damage{"it unpacks to more than its pixels"};
        window_[size_++ % window_.size()] = static_cast<unsigned char>(byte);
        if (size_ % window_.size() == 0) sum_.add(text_of(window_));
    }
    void add_window() { sum_.add(text_of(Bytes(window_).first(size_ % window_.size()))); }

    void copy_stored()
    {
        from_.drop_to_byte();
        auto const length = from_.take(16), inverted = from_.take(16);
        if (length != (inverted ^ 0xffffu)) throw Damage{"a stored block of its pixels has two lengths"};
        for (std::uint32_t i = 0; i < length; ++i) put(from_.take(8));
    }
    void unpack_with_fixed_codes() // RFC 1951, section 3.2.6
    {
        std::array<unsigned char, 288> literals{};
        for (std::size_t i = 0; i < literals.size(); ++i) literals[i] = i < 144 || i > 279 ? 8 : i < 256 ? 9 : 7;
        std::array<unsigned char, 32> distances{};
        distances.fill(5);
        unpack(HuffmanCode(literals), HuffmanCode(distances));
    }
    void unpack_with_own_codes() // RFC 1951, section 3.2.7
    {
        auto const literals = from_.take(5) + 257, distances = from_.take(5) + 1, count = from_.take(4) + 4;
        static constexpr std::array<unsigned char, 19> order{16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
        if (literals > 286 || distances > 30) throw Damage{"a code of its compressed pixels is impossible"};
        std::array<unsigned char, 19> of_lengths{};
        for (std::uint32_t i = 0; i < count; ++i) of_lengths[order[i]] = static_cast<unsigned char>(from_.take(3));
        HuffmanCode const code(of_lengths);
        std::array<unsigned char, 286 + 30> lengths{};
        for (std::uint32_t i = 0; i < literals + distances;) {
            auto const symbol = code.read(from_);
            if (symbol < 16) {
                lengths[i++] = static_cast<unsigned char>(symbol);
                continue;
            }
            if (symbol == 16 && i == 0) throw Damage{"a code of its compressed pixels repeats nothing"};
            auto const value = symbol == 16 ? lengths[i - 1] : static_cast<unsigned char>(0);
            auto const times = symbol == 16 ? 3 + from_.take(2) : symbol == 17 ? 3 + from_.take(3) : 11 + from_.take(7);
            if (i + times > literals + distances) throw Damage{"a code of its compressed pixels is too long"};
            std::fill_n(lengths.begin() + i, times, value);
            i += times;
        }
        if (lengths[256] == 0) throw Damage{"a block of its compressed pixels has no end"};
        unpack(HuffmanCode(Bytes(lengths).first(literals)), HuffmanCode(Bytes(lengths).subspan(literals, distances)));
    }
    void unpack(HuffmanCode const& literals, HuffmanCode const& distances) // RFC 1951, section 3.2.5
    {
        static constexpr std::array<std::uint16_t, 29> first_length{3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
        static constexpr std::array<unsigned char, 29> length_bits{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
        static constexpr std::array<std::uint16_t, 30> first_distance{1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
        for (;;) {
            auto const symbol = literals.read(from_);
            if (symbol == 256) return;
            if (symbol < 256) {
                put(symbol);
                continue;
            }
            if (symbol > 285) throw Damage{"its compressed pixels have a code that does not exist"};
            auto const length = first_length[symbol - 257] + from_.take(length_bits[symbol - 257]);
            auto const step = distances.read(from_);
            if (step > 29) throw Damage{"its compressed pixels have a code that does not exist"};
            auto const distance = first_distance[step] + from_.take(step < 4 ? 0 : step / 2 - 1);
            if (distance > size_) throw Damage{"its compressed pixels repeat bytes before the first"};
            for (std::uint32_t i = 0; i < length; ++i) put(window_[(size_ - distance) % window_.size()]);
        }
    }

    BitReader from_;
    std::size_t most_, size_ = 0;
    Adler32 sum_;
    std::array<unsigned char, 32768> window_{}; // a distance is at most this
};

/// A chunk: its length, 4 letters, its bytes, and the CRC-32 of letters and bytes (PNG specification, section 5.3).
std::string_view png_damage(Bytes bytes, std::size_t most_bytes)
{
    std::vector<unsigned char> packed;
    bool without_header = false; // Apple's form of PNG: pixels without the header and the checksum of zlib
    for (std::size_t at = png_signature.size(); bytes.size() - at >= 12;) {
        auto const length = word_at(bytes, at);
        if (length > bytes.size() - at - 12) break;
        auto const content = bytes.subspan(at + 4, 4 + std::size_t{length});
        auto const name = text_of(content.first(4));
        if (crc32(text_of(content)) != word_at(bytes, at + 8 + length)) return "the checksum of a chunk is wrong";
        without_header = without_header || name == "CgBI";
        if (name == "IDAT") packed.insert(packed.end(), content.begin() + 4, content.end());
        if (name == "IEND") {
            if (!without_header) Unpacker(packed, most_bytes).check();
            return {};
        }
        at += 12 + std::size_t{length};
    }
    return "the file is cut short";
}

} // namespace

std::string_view header_damage(std::FILE* file)
{
    std::rewind(file);
    std::array<unsigned char, 33> head{}; // signature, and the chunk of a PNG's header
    auto const read = std::fread(head.data(), 1, head.size(), file);
    Bytes const bytes = Bytes(head).first(read);
    if (read >= 4 && text_of(bytes).substr(1, 3) == "PNG") {
        if (read < head.size()) return "the file is cut short";
        if (!text_of(bytes).starts_with(png_signature)) return "its signature is damaged";
        if (text_of(bytes).substr(12, 4) == "CgBI") return {};
        if (word_at(bytes, 8) != 13 || text_of(bytes).substr(12, 4) != "IHDR" || crc32(text_of(bytes.subspan(12, 17))) != word_at(bytes, 29)) return "its header is damaged";
        return {};
    }
    std::rewind(file);
    int first = std::fgetc(file);
    if (first != 0xff) return {};
    while (first == 0xff) first = std::fgetc(file);
    if (first != 0xd8) return {};
    for (int before = 0, marker = 0; (marker = std::fgetc(file)) != EOF; before = marker) {
        if (before != 0xff || marker == 0xff) continue;
        bool const skipped = marker == 0xdb || marker == 0xdd || marker == 0xfe || (marker >= 0xe0 && marker <= 0xef);
        if (marker != 0xc4 && !skipped) return {}; // the size of the picture, or the decoder refuses the file here
        int const high = std::fgetc(file), low = std::fgetc(file);
        if (low == EOF) return {};
        auto const length = (high << 8 | low) - 2;
        if (length < 0) return "a segment has no length";
        if (marker == 0xc4) {
            std::vector<unsigned char> tables(static_cast<std::size_t>(length));
            if (std::fread(tables.data(), 1, tables.size(), file) != tables.size()) return "the file is cut short";
            if (!JpegTables().add_huffman(tables)) return impossible_table;
        } else if (std::fseek(file, length, SEEK_CUR) != 0) {
            return {};
        }
        marker = 0; // the next one needs its own FF
    }
    return {};
}

std::string_view picture_damage(Bytes bytes, std::size_t most_bytes)
{
    try {
        if (text_of(bytes).starts_with(png_signature)) return png_damage(bytes, most_bytes);
        if (auto const begin = begin_of_jpeg(bytes); begin != 0) return jpeg_damage(bytes, begin, most_bytes);
        return {};
    } catch (Damage const& damage) {
        return damage.what;
    }
}

} // namespace shared

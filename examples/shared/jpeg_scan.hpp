#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// The structure of a JPEG's compressed pixels (ITU T.81). A JPEG has no checksum: a changed bit of a value is another value. But a changed
/// bit may also move the codes after it. Then often the blocks end before or behind their data, or a code does not exist. Of single bits
/// changed in photographs, a sixth to a half are found so.
namespace shared {

/// The codes of a table for reading bit by bit (F.2.2.3).
class JpegCode {
public:
    JpegCode() = default;
    /// `lengths`: the numbers of codes of 1 to 16 bits; then `symbols`, one a code. They must fit (JpegTables::add_huffman).
    JpegCode(std::span<unsigned char const> lengths, std::span<unsigned char const> symbols) : symbols_(symbols.begin(), symbols.end())
    {
        for (std::size_t bits = 0; bits < count_.size(); ++bits) count_[bits] = lengths[bits];
    }
    /// The next symbol; nothing: below 0. `next_bit` returns 0 or 1, or below 0 at the end.
    template <class NextBit>
    int read(NextBit const& next_bit) const
    {
        std::uint32_t code = 0, first = 0, index = 0; // of the codes of this length: the first one, and the place of its symbol
        for (auto const count : count_) {
            int const bit = next_bit();
            if (bit < 0) return -1;
            code = code << 1 | static_cast<std::uint32_t>(bit);
            first <<= 1;
            if (code < first + count) return symbols_[index + code - first];
            first += count;
            index += count;
        }
        return -1;
    }

private:
    std::array<unsigned char, 16> count_{};
    std::vector<unsigned char> symbols_;
};

/// Reads the scans of one picture, and forgets the values. Functions return false for damage.
class JpegScans {
public:
    using Bytes = std::span<unsigned char const>;

    void add_code(unsigned char kind_and_number, Bytes lengths, Bytes symbols)
    {
        if (kind_and_number < 32 && kind_and_number % 16 < 4) codes_[kind_and_number / 16][kind_and_number % 16] = {lengths, symbols};
    }
    void set_restarts(Bytes segment) { interval_ = segment.size() < 2 ? 0 : static_cast<std::uint32_t>(segment[0] << 8 | segment[1]); }
    /// A frame's header (B.2.2), behind its length. `most_bytes`: what a progressive picture may take, 8 bytes a block. Sampling factors
    /// that are none are left to the decoder: then no scan is read.
    bool begin(Bytes segment, bool progressive, std::size_t most_bytes)
    {
        known_ = false;
        if (segment.size() < 6 || segment.size() < 6 + 3 * std::size_t{segment[5]}) return false;
        progressive_ = progressive;
        parts_.clear();
        auto const height = static_cast<std::uint32_t>(segment[1] << 8 | segment[2]), width = static_cast<std::uint32_t>(segment[3] << 8 | segment[4]);
        std::uint32_t most_x = 1, most_y = 1;
        for (std::size_t i = 0; i < segment[5]; ++i) {
            Part part;
            part.id = segment[6 + 3 * i];
            part.across = segment[7 + 3 * i] >> 4;
            part.down = segment[7 + 3 * i] & 15u;
            if (part.across - 1 > 3 || part.down - 1 > 3) return true;
            most_x = std::max(most_x, part.across);
            most_y = std::max(most_y, part.down);
            parts_.push_back(part);
        }
        auto const ceil = [](std::uint32_t n, std::uint32_t by) { return (n + by - 1) / by; };
        units_x_ = ceil(width, 8 * most_x);
        units_y_ = ceil(height, 8 * most_y);
        std::size_t blocks = 0;
        for (auto& part : parts_) {
            part.blocks_x = ceil(ceil(width * part.across, most_x), 8);
            part.blocks_y = ceil(ceil(height * part.down, most_y), 8);
            blocks += std::size_t{units_x_} * part.across * units_y_ * part.down;
        }
        if (progressive && blocks > most_bytes / 8) return false;
        if (progressive)
            for (auto& part : parts_) part.not_zero.assign(std::size_t{units_x_} * part.across * units_y_ * part.down, 0);
        known_ = width != 0 && height != 0 && segment[0] == 8;
        return true;
    }
    /// Reads a scan: `header` behind its length (B.2.3), `data` from its first byte on. Adds the bytes that it took to `at`.
    bool read(Bytes header, Bytes data, std::size_t& at)
    {
        if (!known_) return true;
        std::size_t const count = header.empty() ? 0 : header[0];
        if (count < 1 || count > 4 || header.size() < 4 + 2 * count) return false;
        scan_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            Part* found = nullptr;
            for (auto& part : parts_)
                if (part.id == header[1 + 2 * i]) found = &part;
            if (found == nullptr || header[2 + 2 * i] / 16 > 3 || header[2 + 2 * i] % 16 > 3) return false;
            found->dc = header[2 + 2 * i] / 16;
            found->ac = header[2 + 2 * i] % 16;
            scan_.push_back(found);
        }
        first_ = header[1 + 2 * count];
        last_ = header[2 + 2 * count];
        high_ = header[3 + 2 * count] >> 4;
        if (progressive_ ? last_ > 63 || first_ > last_ || (first_ == 0 ? last_ != 0 : count != 1) : first_ != 0 || last_ != 63 || header[3 + 2 * count] != 0) return false;
        data_ = data;
        at_ = 0;
        begin_interval();
        bool const alone = count == 1;
        std::uint32_t const across = alone ? scan_[0]->blocks_x : units_x_, down = alone ? scan_[0]->blocks_y : units_y_;
        std::uint32_t restarts = 0, units = 0;
        for (std::uint32_t y = 0; y < down; ++y)
            for (std::uint32_t x = 0; x < across; ++x, ++units) {
                if (interval_ != 0 && units == interval_) {
                    if (!ends_interval() || !takes_restart(restarts++ % 8)) return false;
                    units = 0;
                }
                for (auto* const part : scan_) {
                    std::uint32_t const n = alone ? 1 : part->across, m = alone ? 1 : part->down;
                    for (std::uint32_t j = 0; j < m; ++j)
                        for (std::uint32_t i = 0; i < n; ++i)
                            if (!block(*part, (std::size_t{y} * m + j) * units_x_ * part->across + x * n + i)) return false;
                }
            }
        if (!ends_interval() || (!at_end() && data_[at_ + 1] >= 0xd0 && data_[at_ + 1] <= 0xd7)) return false; // no restart is left
        for (auto* const part : scan_) part->seen = part->seen || first_ == 0;
        at += at_;
        return true;
    }
    /// Did the last scan that was read end with the file?
    bool at_end() const { return at_ + 1 >= data_.size(); }
    /// Has each part of the picture had a scan?
    bool complete() const
    {
        bool all = true;
        for (auto const& part : parts_) all = all && part.seen;
        return !known_ || all;
    }

private:
    struct Part { // a component
        unsigned id = 0, dc = 0, ac = 0;
        std::uint32_t across = 1, down = 1;          ///< blocks in a unit of an interleaved scan
        std::uint32_t blocks_x = 0, blocks_y = 0;    ///< in a scan of its own
        std::vector<std::uint64_t> not_zero;         ///< progressive: a bit for each coefficient
        bool seen = false;
    };

    void begin_interval()
    {
        bits_ = 0;
        zero_blocks_ = 0;
    }
    /// Fewer than 8 bits are left before the next marker, and no block is owed.
    bool ends_interval() const { return zero_blocks_ == 0 && (at_ >= data_.size() || (data_[at_] == 0xff && at_ + 1 < data_.size() && data_[at_ + 1] != 0)); }
    bool takes_restart(unsigned number)
    {
        while (at_ + 1 < data_.size() && data_[at_ + 1] == 0xff) ++at_; // fill bytes
        if (at_ + 1 >= data_.size() || data_[at_ + 1] != 0xd0 + number) return false;
        at_ += 2;
        begin_interval();
        return true;
    }
    /// Below 0 at a marker, or at the end.
    int bit()
    {
        if (bits_ == 0) {
            if (at_ >= data_.size()) return -1;
            byte_ = data_[at_];
            if (byte_ == 0xff) {
                if (at_ + 1 >= data_.size() || data_[at_ + 1] != 0) return -1;
                ++at_;
            }
            ++at_;
            bits_ = 8;
        }
        return static_cast<int>(byte_ >> --bits_ & 1u);
    }
    /// Below 0 at the end.
    int bits(unsigned count)
    {
        int value = 0;
        for (unsigned i = 0; i < count; ++i) {
            int const next = bit();
            if (next < 0) return -1;
            value = value << 1 | next;
        }
        return value;
    }
    int symbol(JpegCode const& code)
    {
        return code.read([this] { return bit(); });
    }
    bool block(Part& part, std::size_t index)
    {
        if (!progressive_) {
            if (!dc(part)) return false;
            std::uint64_t ignored = 0;
            return first_ac(part, ignored, 1, 63);
        }
        if (first_ == 0) return high_ == 0 ? dc(part) : bit() >= 0;
        return high_ == 0 ? first_ac(part, part.not_zero[index], first_, last_) : later_ac(part, part.not_zero[index]);
    }
    /// Differences of 8-bit pictures have up to 11 bits (table F.1).
    bool dc(Part const& part)
    {
        int const size = symbol(codes_[0][part.dc]);
        return size >= 0 && size <= 11 && bits(static_cast<unsigned>(size)) >= 0;
    }
    /// Coefficients have up to 10 bits (table F.2). Without a size, a run of 15 is 16 zeros; a shorter one ends 2^run blocks and more (G.1.2.2).
    bool first_ac(Part const& part, std::uint64_t& not_zero, unsigned from, unsigned to)
    {
        if (zero_blocks_ != 0) {
            --zero_blocks_;
            return true;
        }
        for (unsigned k = from; k <= to; ++k) {
            int const both = symbol(codes_[1][part.ac]);
            if (both < 0) return false;
            auto const run = static_cast<unsigned>(both) >> 4, size = static_cast<unsigned>(both) & 15u;
            if (size == 0 && run < 15) return ends_blocks(run);
            k += run;
            if (k > to || size > 10 || bits(size) < 0) return false;
            if (size != 0) not_zero |= std::uint64_t{1} << k;
        }
        return true;
    }
    bool ends_blocks(unsigned run)
    {
        if (!progressive_) return run == 0;
        int const more = bits(run);
        zero_blocks_ = (1u << run) - 1 + static_cast<std::uint32_t>(more);
        return more >= 0;
    }
    /// One bit more for each coefficient that is not 0, and new ones of one bit (G.1.2.3).
    bool later_ac(Part const& part, std::uint64_t& not_zero)
    {
        unsigned k = first_;
        for (; zero_blocks_ == 0 && k <= last_; ++k) {
            int const both = symbol(codes_[1][part.ac]);
            if (both < 0) return false;
            auto run = static_cast<unsigned>(both) >> 4, size = static_cast<unsigned>(both) & 15u;
            if (size > 1 || (size == 1 && bit() < 0)) return false;
            if (size == 0 && run < 15) {
                if (!ends_blocks(run)) return false;
                ++zero_blocks_; // this one, too
                break;
            }
            for (; k <= last_; ++k) { // behind `run` zeros
                if ((not_zero >> k & 1u) != 0) {
                    if (bit() < 0) return false;
                } else if (run-- == 0) {
                    break;
                }
            }
            if (k > last_ && size != 0) return false;
            if (size != 0) not_zero |= std::uint64_t{1} << k;
        }
        if (zero_blocks_ == 0) return true;
        for (; k <= last_; ++k)
            if ((not_zero >> k & 1u) != 0 && bit() < 0) return false;
        --zero_blocks_;
        return true;
    }

    std::array<std::array<JpegCode, 4>, 2> codes_; ///< of DC, of AC
    std::vector<Part> parts_;
    std::vector<Part*> scan_;
    std::uint32_t units_x_ = 0, units_y_ = 0, interval_ = 0, zero_blocks_ = 0;
    unsigned first_ = 0, last_ = 63, high_ = 0;
    bool progressive_ = false, known_ = false;
    Bytes data_;
    std::size_t at_ = 0;
    unsigned byte_ = 0, bits_ = 0;
};

} // namespace shared

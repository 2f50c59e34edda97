// Computes the error of one picture against another. Both are colour PFM files, from any programs: use it to compare another renderer's
// picture with one of tilemesh, or a picture of tilemesh with its reference. The measures have the names and the meaning of the reports of
// tilemesh. The program shares no code with the library (it uses only the standard library, its own reader and its own loops), so it checks
// the library's numbers to the last digit. Exit status 2 if it cannot measure.
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/number_text.hpp>
#include <utility>
#include <vector>

namespace {

constexpr char const* usage = R"(usage: pfm_error [--csv] PICTURE.pfm REFERENCE.pfm
How far PICTURE is from REFERENCE: two colour PFM files of one size, whose values are linear and 1 is white. Prints, one a line:
  rmse                  root mean square error over all channel values
  max_levels            largest error of a channel value, in levels of 1/255
  p999_levels           error that 99.9 % of the channel values do not exceed (nearest rank), in levels of 1/255
  psnr_db               -20 log10(rmse), for a peak of 1; inf for equal pictures
  ssim                  structural similarity (Wang et al. 2004): Gaussian window of 11 x 11 and sigma 1.5 around every pixel,
                        border pixels repeated, K1 0.01, K2 0.03, range 1; mean over pixels and channels
  mae                   mean absolute error over all channel values
  share_over_one_level  share of pixels, 0 to 1, with a channel that is off by more than one level of 1/255
  max_x, max_y          column and row of the pixel with the largest error, from 0 at the left and at the top; of several such
                        pixels, the first in the order of reading
Values are compared as they are: nothing is clamped, and no gamma is applied.
  --csv    a line of names and a line of values, separated by commas
  --help   this text
Exit status: 0 measured, 2 not measured, with one line that says why.
)";

/// An error for the user in one line: "<problem> (<why>); <what to do>".
class Refusal : public std::exception {
public:
    Refusal(std::string const& problem, std::string const& why, std::string const& remedy)
        : text_(problem + " (" + why + "); " + remedy)
    {
        for (char& c : text_) // a file name may contain a line break, or bytes that are no text
            if (static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~') c = '?';
    }
    char const* what() const noexcept override { return text_.c_str(); }

private:
    std::string text_;
};

std::string system_error() { return errno != 0 ? std::generic_category().message(errno) : "the stream failed"; }

/// A colour picture with three values per pixel. Its rows are in the order of the file, from the bottom to the top.
struct Picture {
    std::string path;
    std::uint64_t width = 0, height = 0;
    std::vector<float> values;
};

struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

/// Reads a colour PFM: "PF", width, height and scale as words of text, one white space, then floats. The sign of the scale gives the byte
/// order (negative: little endian). A scale other than 1 or -1 is refused, because programs disagree whether values are multiplied by it.
/// It allocates at most about twice the size of the file, for any header.
class Reader {
public:
    explicit Reader(std::string const& path) : path_(path)
    {
        errno = 0;
        file_.reset(std::fopen(path.c_str(), "rb"));
        if (!file_) refuse(system_error(), "name a PFM file that can be read");
    }

    Picture read()
    {
        auto const magic = word();
        if (magic == "Pf") refuse("a grey PFM, magic \"Pf\"", "write it as a colour PFM, magic \"PF\"");
        if (magic != "PF") refuse("it does not begin with \"PF\"", "name a colour PFM file");
        Picture picture;
        picture.path = path_;
        picture.width = side("width");
        picture.height = side("height");
        bool const little = little_endian();
        fill(picture, little);
        return picture;
    }

private:
    [[noreturn]] void refuse(std::string const& why, std::string const& remedy) const
    {
        throw Refusal("cannot read " + path_, why, remedy);
    }

    /// Returns the next byte, or a negative number at the end.
    int byte()
    {
        errno = 0;
        int const next = std::fgetc(file_.get());
        if (next < 0 && std::ferror(file_.get()) != 0) refuse(system_error(), "name a PFM file that can be read");
        return next;
    }

    static bool is_space(int c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

    /// Returns the next word of the header, and takes the white space after it. A header has no word of 32 characters.
    std::string word()
    {
        std::string word;
        int next = byte();
        while (is_space(next) && word_count_ > 0) next = byte();
        for (; next >= 0 && !is_space(next) && word.size() < 32; next = byte()) word += static_cast<char>(next);
        if (word_count_ > 0 && !is_space(next)) refuse_header();
        ++word_count_;
        return word;
    }

    [[noreturn]] void refuse_header() const
    {
        refuse("its header is not \"PF width height scale\"", "it is cut short or no PFM file: write it again");
    }

    std::uint64_t side(std::string const& name)
    {
        auto const text = word();
        auto const value = tilemesh::number_of<std::uint32_t>(text);
        if (!value) refuse_header();
        // So that 3 * width * height fits into 64 bits.
        if (*value == 0 || *value > 0x7fffffffu) refuse("its " + name + " is " + text, "write a picture that has pixels");
        return *value;
    }

    bool little_endian()
    {
        auto const text = word();
        auto const scale = tilemesh::number_of<double>(text).value_or(NAN);
        if (!std::isfinite(scale)) refuse_header();
        if (std::abs(scale) != 1.0) refuse("its scale is " + text, "write it again with scale 1 or -1");
        return scale < 0.0;
    }

    void fill(Picture& picture, bool little)
    {
        auto const count = 3 * picture.width * picture.height;
        auto const size = std::to_string(picture.width) + " x " + std::to_string(picture.height);
        std::array<unsigned char, 49152> chunk;
        while (picture.values.size() < count) {
            auto const wanted = 4 * std::min<std::uint64_t>(chunk.size() / 4, count - picture.values.size());
            errno = 0;
            auto const got = std::fread(chunk.data(), 1, static_cast<std::size_t>(wanted), file_.get());
            if (got < wanted) {
                if (std::ferror(file_.get()) != 0) refuse(system_error(), "name a PFM file that can be read");
                refuse("it ends after " + std::to_string(4 * picture.values.size() + got) + " bytes of the pixels of " + size,
                       "it is truncated: write it again");
            }
            for (std::size_t i = 0; i < got; i += 4) {
                std::uint32_t bits = 0;
                for (std::size_t k = 0; k < 4; ++k) bits = bits << 8 | chunk[little ? i + 3 - k : i + k];
                picture.values.push_back(std::bit_cast<float>(bits));
            }
        }
        if (byte() >= 0)
            refuse("it goes on after its " + size + " pixels", "its header or its bytes are wrong: write it again");
    }

    std::string path_;
    std::unique_ptr<std::FILE, Close> file_;
    int word_count_ = 0;
};

/// Refuses NaN and infinity, for which no measure is defined. The error names the first such pixel, counted from the top left.
void expect_finite(Picture const& picture)
{
    for (std::uint64_t row = 0; row < picture.height; ++row)
        for (std::uint64_t i = 0; i < 3 * picture.width; ++i) {
            float const value = picture.values[(picture.height - 1 - row) * 3 * picture.width + i];
            if (std::isfinite(value)) continue;
            throw Refusal("cannot compare " + picture.path,
                          "its pixel " + std::to_string(i / 3) + ", " + std::to_string(row) + " is not finite in channel " +
                              std::to_string(i % 3),
                          "find what rendered it: no measure covers it");
        }
}

/// One channel of a picture. Its border is repeated outwards `margin` times, so that every window lies inside.
class Plane {
public:
    Plane(Picture const& picture, std::uint64_t channel, std::uint64_t margin) : stride_(picture.width + 2 * margin)
    {
        auto const inside = [&](std::uint64_t padded, std::uint64_t size) {
            return padded < margin ? 0 : std::min(padded - margin, size - 1);
        };
        values_.reserve(stride_ * (picture.height + 2 * margin));
        for (std::uint64_t y = 0; y < picture.height + 2 * margin; ++y)
            for (std::uint64_t x = 0; x < stride_; ++x)
                values_.push_back(
                    picture.values[3 * (inside(y, picture.height) * picture.width + inside(x, picture.width)) + channel]);
    }
    /// The values of row y from column x on, where (0, 0) is the first value of the margin.
    float const* at(std::uint64_t x, std::uint64_t y) const { return &values_[y * stride_ + x]; }

private:
    std::uint64_t stride_;
    std::vector<float> values_;
};

/// The mean structural similarity, window by window: weights in both directions at once, then means, then central moments.
double structural_similarity(Picture const& picture, Picture const& reference)
{
    constexpr std::size_t side = 11;
    constexpr std::uint64_t margin = side / 2;
    constexpr double sigma = 1.5;
    constexpr double c1 = (0.01 * 1.0) * (0.01 * 1.0); // (K1 L)^2 and (K2 L)^2 of Wang et al. 2004, with a range L of 1
    constexpr double c2 = (0.03 * 1.0) * (0.03 * 1.0);

    std::array<std::array<double, side>, side> weights;
    double total = 0.0;
    for (std::size_t j = 0; j < side; ++j)
        for (std::size_t i = 0; i < side; ++i) {
            double const x = static_cast<double>(i) - static_cast<double>(margin);
            double const y = static_cast<double>(j) - static_cast<double>(margin);
            weights[j][i] = std::exp(-(x * x + y * y) / (2.0 * sigma * sigma));
            total += weights[j][i];
        }
    for (auto& row : weights)
        for (double& weight : row) weight /= total;

    double sum = 0.0;
    for (std::uint64_t channel = 0; channel < 3; ++channel) {
        Plane const a(picture, channel, margin), b(reference, channel, margin);
        for (std::uint64_t y = 0; y < picture.height; ++y)
            for (std::uint64_t x = 0; x < picture.width; ++x) {
                double mean_a = 0.0, mean_b = 0.0;
                for (std::size_t j = 0; j < side; ++j) {
                    float const *const row_a = a.at(x, y + j), *const row_b = b.at(x, y + j);
                    for (std::size_t i = 0; i < side; ++i) {
                        mean_a += weights[j][i] * double{row_a[i]};
                        mean_b += weights[j][i] * double{row_b[i]};
                    }
                }
                double variance_a = 0.0, variance_b = 0.0, covariance = 0.0;
                for (std::size_t j = 0; j < side; ++j) {
                    float const *const row_a = a.at(x, y + j), *const row_b = b.at(x, y + j);
                    for (std::size_t i = 0; i < side; ++i) {
                        double const off_a = double{row_a[i]} - mean_a, off_b = double{row_b[i]} - mean_b;
                        variance_a += weights[j][i] * off_a * off_a;
                        variance_b += weights[j][i] * off_b * off_b;
                        covariance += weights[j][i] * off_a * off_b;
                    }
                }
                sum += (2.0 * mean_a * mean_b + c1) * (2.0 * covariance + c2) /
                       ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
            }
    }
    return sum / static_cast<double>(picture.values.size());
}

/// The name of a measure, and its value as text.
using Measure = std::pair<char const*, std::string>;

std::vector<Measure> measure(Picture const& picture, Picture const& reference)
{
    auto const count = picture.values.size();
    std::vector<double> off(count);
    double squares = 0.0, absolute = 0.0;
    std::uint64_t pixels_over = 0;
    for (std::size_t i = 0; i < count; ++i) {
        off[i] = std::abs(double{picture.values[i]} - double{reference.values[i]});
        squares += off[i] * off[i];
        absolute += off[i];
        if (i % 3 == 2 && 255.0 * std::max({off[i - 2], off[i - 1], off[i]}) > 1.0) ++pixels_over;
    }
    auto const row_values = 3 * picture.width;
    std::uint64_t worst = 0; // the value with the largest error, counted from the top left
    double most = 0.0;
    for (std::uint64_t read = 0; read < count; ++read) { // the file's last row is the top row
        auto const value = off[(picture.height - 1 - read / row_values) * row_values + read % row_values];
        if (value > most) most = value, worst = read;
    }
    std::sort(off.begin(), off.end());
    auto const rank = (999 * count + 999) / 1000; // 0.999 of them, rounded up

    double const n = static_cast<double>(count);
    double const rmse = std::sqrt(squares / n);
    double const psnr = -20.0 * std::log10(rmse); // for 0 it is +infinity, printed as "inf"
    auto const print = [](char const* format, double value) {
        std::array<char, 400> text; // the largest float in levels has 42 digits before the point
        std::snprintf(text.data(), text.size(), format, value);
        return std::string(text.data());
    };
    return {{"rmse", print("%.4e", rmse)},
            {"max_levels", print("%.4f", 255.0 * off.back())},
            {"p999_levels", print("%.4f", 255.0 * off[rank - 1])},
            {"psnr_db", print("%.3f", psnr)},
            {"ssim", print("%.6f", structural_similarity(picture, reference))},
            {"mae", print("%.4e", absolute / n)},
            {"share_over_one_level", print("%.6f", 3.0 * static_cast<double>(pixels_over) / n)},
            {"max_x", std::to_string(worst % row_values / 3)},
            {"max_y", std::to_string(worst / row_values)}};
}

std::string table(std::vector<Measure> const& measures, bool csv)
{
    std::string names, values, lines;
    for (auto const& [name, value] : measures) {
        char const* const comma = names.empty() ? "" : ",";
        names.append(comma).append(name);
        values.append(comma).append(value);
        lines.append(name).append(" ").append(value).append("\n");
    }
    return csv ? names + "\n" + values + "\n" : lines;
}

std::string answer(std::vector<std::string> const& words)
{
    bool csv = false;
    std::vector<std::string> paths;
    for (auto const& word : words) {
        if (word == "--help") return usage;
        if (word == "--csv")
            csv = true;
        else if (word.size() > 1 && word[0] == '-')
            throw Refusal("no option " + word, "there are --csv and --help", "see pfm_error --help");
        else
            paths.push_back(word);
    }
    if (paths.size() != 2)
        throw Refusal("a picture and its reference are needed",
                      std::to_string(paths.size()) + (paths.size() == 1 ? " file is named" : " files are named"),
                      "write pfm_error PICTURE.pfm REFERENCE.pfm");

    auto const picture = Reader(paths[0]).read(), reference = Reader(paths[1]).read();
    if (picture.width != reference.width || picture.height != reference.height) {
        auto const size_of = [](Picture const& of) { return std::to_string(of.width) + " x " + std::to_string(of.height); };
        throw Refusal("cannot compare " + paths[0] + " with " + paths[1],
                      size_of(picture) + " pixels against " + size_of(reference), "render both at one size");
    }
    expect_finite(picture);
    expect_finite(reference);
    return table(measure(picture, reference), csv);
}

} // namespace

int main(int argc, char** argv)
try {
    auto const text = answer({argv + 1, argv + argc});
    errno = 0;
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
        throw Refusal("cannot write the measures", system_error(), "free the place that standard output goes to");
    return 0;
} catch (Refusal const& refusal) {
    std::fprintf(stderr, "%s\n", refusal.what());
    return 2;
} catch (std::bad_alloc const&) {
    std::fputs("cannot hold the pictures (memory does not suffice); compare smaller ones\n", stderr);
    return 2;
}

// Reads files of n and of 8 n entries. The longer file may take at most ten times the steps, and at most the memory in .github/SECURITY.md.
// A step is one of these: an edge in the control flow of the readers and of the standard library's templates
// (-fsanitize-coverage=trace-pc); 16 bytes that the C library copies, sets or compares; 16 allocated bytes; a byte from the stream (each
// time it is read). linear_readers.sh compiles this file twice.
#include <cstddef>
#include <cstdint>

/// The steps so far, and the most that are allowed. `case_name` is the case that takes them.
extern std::uint64_t steps, most_steps;
extern char const* case_name;
/// The bytes that are allocated now, and the most at one time.
extern std::uint64_t live_bytes, peak_bytes;

#ifdef COUNTER
#include <cstdio>
#include <cstdlib>
#include <malloc.h>
#include <new>

std::uint64_t live_bytes = 0, peak_bytes = 0;
std::uint64_t steps = 0, most_steps = ~std::uint64_t{0};
char const* case_name = "";

extern "C" {
void __sanitizer_cov_trace_pc()
{
    if (++steps <= most_steps) return;
    std::printf("%s: not linear: more than ten times the steps for eight times the file\n", case_name);
    std::exit(1);
}
void* __real_memcpy(void*, void const*, std::size_t);
void* __real_memmove(void*, void const*, std::size_t);
void* __real_memset(void*, int, std::size_t);
void* __real_memchr(void const*, int, std::size_t);
int __real_memcmp(void const*, void const*, std::size_t);
void* __wrap_memcpy(void* to, void const* from, std::size_t n) { return steps += n / 16, __real_memcpy(to, from, n); }
void* __wrap_memmove(void* to, void const* from, std::size_t n) { return steps += n / 16, __real_memmove(to, from, n); }
void* __wrap_memset(void* to, int value, std::size_t n) { return steps += n / 16, __real_memset(to, value, n); }
void* __wrap_memchr(void const* in, int value, std::size_t n)
{
    void* const found = __real_memchr(in, value, n);
    steps += (found == nullptr ? n : static_cast<std::size_t>(static_cast<char*>(found) - static_cast<char const*>(in))) / 16;
    return found;
}
int __wrap_memcmp(void const* a, void const* b, std::size_t n) { return steps += n / 16, __real_memcmp(a, b, n); }
}

void* operator new(std::size_t n)
{
    steps += 1 + n / 16;
    void* const p = std::malloc(n);
    if (p == nullptr) throw std::bad_alloc();
    live_bytes += malloc_usable_size(p);
    if (live_bytes > peak_bytes) peak_bytes = live_bytes;
    return p;
}
void operator delete(void* p) noexcept
{
    live_bytes -= malloc_usable_size(p);
    std::free(p);
}
void operator delete(void* p, std::size_t) noexcept { operator delete(p); }

#else
#include "../scene/map_writers.hpp"
#include <algorithm>
#include <cstdio>
#include <functional>
#include <istream>
#include <streambuf>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/colmap.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <unordered_map>
#include <vector>

namespace {

using namespace tilemesh;

/// A text as a stream that counts the bytes taken from it.
class CountedText : public std::streambuf {
public:
    explicit CountedText(std::string text) : text_(std::move(text)) {}

private:
    int_type underflow() override
    {
        std::size_t const at = place();
        if (at == text_.size()) return traits_type::eof();
        window(at, std::min(at + 256, text_.size()));
        steps += static_cast<std::uint64_t>(egptr() - gptr());
        return traits_type::to_int_type(*gptr());
    }
    pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override
    {
        auto const base = from == std::ios_base::beg ? 0 : static_cast<off_type>(from == std::ios_base::cur ? place() : text_.size());
        return seekpos(base + by, std::ios_base::in);
    }
    pos_type seekpos(pos_type to, std::ios_base::openmode) override
    {
        if (to < 0 || to > static_cast<off_type>(text_.size())) return pos_type(off_type(-1));
        window(static_cast<std::size_t>(off_type(to)), static_cast<std::size_t>(off_type(to)));
        return to;
    }
    std::size_t place() const { return gptr() == nullptr ? 0 : static_cast<std::size_t>(gptr() - text_.data()); }
    void window(std::size_t begin, std::size_t end) { setg(text_.data() + begin, text_.data() + begin, text_.data() + end); }

    std::string text_;
};

std::string number(std::size_t i) { return std::to_string(i); }
std::string repeated(std::size_t n, std::function<std::string(std::size_t)> const& entry)
{
    std::string text;
    for (std::size_t i = 0; i < n; ++i) text += entry(i);
    return text;
}
/// The text with this number for each $.
std::string filled(std::string_view text, std::size_t value)
{
    std::string out;
    for (char const c : text) c == '$' ? out += number(value) : out += c;
    return out;
}
/// Entry after entry, with its index for each $. An entry that ends with a comma is one of a list, whose last entry has none.
std::string repeated(std::size_t n, std::string_view entry)
{
    auto text = repeated(n, [&](std::size_t i) { return filled(entry, i); });
    if (text.ends_with(',')) text.pop_back();
    return text;
}

using Reader = std::function<void(std::istream&)>;
using Text = std::function<std::string(std::size_t)>;
int failures = 0, cases = 0;
/// The memory that a reader may take: bytes per byte of the file, and a constant.
std::uint64_t most_a_byte = 0, most_beside = 0;

/// The memory that the last text took.
std::uint64_t memory = 0;

/// Counts the steps to read this text and ends the program above `limit`. `refused`: the reader must refuse the text.
std::uint64_t steps_of(std::string text, bool refused, std::uint64_t limit, Reader const& read, std::string const& name)
{
    CountedText buffer(std::move(text));
    std::istream stream(&buffer);
    bool was_refused = false;
    std::string why;
    case_name = name.c_str();
    std::uint64_t const before = peak_bytes = live_bytes;
    steps = 0;
    most_steps = limit;
    try {
        read(stream);
    } catch (Error const& error) {
        was_refused = true;
        why = error.what();
    }
    most_steps = ~std::uint64_t{0};
    std::uint64_t const taken = steps;
    memory = peak_bytes - before;
    if (was_refused == refused && why.size() < 2000) return taken;
    std::printf("%s: %s %.300s\n", name.c_str(), refused ? "must be refused, in a short line" : "must be read", why.c_str());
    ++failures;
    return taken;
}

enum class Ends { well, refused };

void expect_linear(std::string const& name, Ends ends, Reader const& read, Text const& text, std::size_t n = 1000)
{
    bool const refused = ends == Ends::refused;
    std::uint64_t const one = steps_of(text(n), refused, ~std::uint64_t{0}, read, name);
    std::string const eight_times = text(8 * n);
    std::uint64_t const eight = steps_of(eight_times, refused, 10 * one, read, name);
    double const bytes = static_cast<double>(eight_times.size());
    std::printf("%-58s %9llu %10llu steps: x %5.2f, %5.1f a byte; %9llu bytes of memory, %5.1f a byte\n", name.c_str(),
                static_cast<unsigned long long>(one), static_cast<unsigned long long>(eight),
                static_cast<double>(eight) / static_cast<double>(one), static_cast<double>(eight) / bytes,
                static_cast<unsigned long long>(memory), static_cast<double>(memory) / bytes);
    ++cases;
    if (one <= n || memory == 0) {
        std::printf("%s: nothing is counted\n", name.c_str());
        ++failures;
    }
    if (memory > most_beside + most_a_byte * eight_times.size()) {
        std::printf("%s: more memory than %llu bytes for each of the file and %llu\n", name.c_str(),
                    static_cast<unsigned long long>(most_a_byte), static_cast<unsigned long long>(most_beside));
        ++failures;
    }
}

/// A text of `times` entries for each of n, with their number for each $ of the text before and after them.
struct Row {
    char const* name;
    Ends ends;
    std::string before, entry, after = "";
    std::size_t times = 1, n = 1000;
};
void expect_linear(Reader const& read, std::vector<Row> const& rows)
{
    for (auto const& row : rows)
        expect_linear(row.name, row.ends, read, [&](std::size_t n) {
            return filled(row.before, row.times * n) + repeated(row.times * n, row.entry) + filled(row.after, row.times * n);
        }, row.n);
}

void camera_json()
{
    most_a_byte = 24, most_beside = 1 << 18;
    auto const read = [](std::istream& in) {
        std::vector<std::string> notes;
        scene::read_cameras_json(in, "cameras.json", &notes);
    };
    std::string const own = R"({"name":"c$","width":640,"height":480,"fx":500.25,"fy":510,"cx":320.5,"cy":240,"world_to_camera":)"
                            "[[1,0,0,0.125],[0,1,0,2],[0,0,1,-3e-1],[0,0,0,1]]},";
    std::string const of_training = R"("width":640,"height":480,"fx":500.25,"fy":510,"position":[1,2,3],"rotation":[[1,0,0],[0,1,0],[0,0,1]]},)";
    std::string const training = R"({"id":$,"img_name":"c$",)" + of_training, cameras = R"({"cameras":[)";
    std::string const lens = R"({"w":1,"h":1,"fl_x":1,"frames":[)", no_lens = R"({"frames":[)";
    std::string const pose = R"("transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])", frame = R"({"file_path":"$",)" + pose;
    expect_linear(read, {
        {"JSON: own cameras", Ends::well, cameras, own, "]}"},
        {"JSON: own cameras, all of one name", Ends::refused, cameras, filled(own, 0), "]}"},
        {"JSON: cameras of a training", Ends::well, "[", training, "]"},
        {"JSON: cameras of a training that share a name", Ends::well, "[", R"({"id":$,"img_name":"same",)" + of_training, "]"},
        {"JSON: cameras of a training after one that is not usable", Ends::refused, R"([{"img_name":"first"},)", training, "]"},
        {"JSON: the shortest cameras of a training", Ends::well, "[",
         R"({"img_name":"$","width":1,"height":1,"fx":1,"fy":1,"position":[0,0,0],"rotation":[[1,0,0],[0,1,0],[0,0,1]]},)", "]"},
        {"transforms.json: the shortest frames", Ends::well, lens, frame + "},", "]}"},
        {"transforms.json: the lens behind the frames", Ends::well, no_lens, frame + "},", R"(],"w":640,"h":480,"camera_angle_x":0.75})"},
        {"transforms.json: a lens for each frame", Ends::well, lens, frame + R"(,"w":2},)", "]}"},
        {"transforms.json: frames of one name", Ends::refused, lens, filled(frame, 0) + "},", "]}"},
        {"transforms.json: keys of a frame that nobody reads", Ends::well, lens, frame + R"(,"k$":0},)", "]}"},
        {"transforms.json: {} in frames[]", Ends::refused, no_lens, "{},", "]}"},
        {"transforms.json: frames[] again and again", Ends::refused, "{", R"("frames":[)" + frame + "}],", "}"},
        {"JSON: names and nothing else", Ends::refused, "[", R"({"img_name":"$"},)", "]"},
        {"JSON: {} in a list", Ends::refused, "[", "{},", "]"},
        {"JSON: {} in cameras[]", Ends::refused, cameras, "{},", "]}"},
        {"JSON: [] in a list", Ends::refused, "[", "[],", "]"},
        {"JSON: numbers in a list", Ends::refused, "[", "0,", "]"},
        {"JSON: lists without an end", Ends::refused, "[", "[0],"},
        {"JSON: keys that nobody reads", Ends::well, "{", R"("u$":[{"a":1}],)", R"(,"cameras":[]})"},
        {"JSON: keys of a camera that nobody reads", Ends::well, cameras + filled(own, 0).substr(0, filled(own, 0).size() - 2) + ",",
         R"("k10$":0,)", "}]}"},
        {"JSON: a long list of distortion", Ends::well, R"({"distortion":[[)", "0,", R"(]],"cameras":[]})", 16},
        {"JSON: the same key again and again", Ends::well, "{", R"("cameras":[],)", "}"},
        {"JSON: fields of one camera again and again", Ends::refused, cameras + "{", R"("name":"a","fx":1,)", "}]}"},
        {"JSON: a matrix of many rows", Ends::refused, cameras + R"({"name":"a","world_to_camera":[)", "[1,2,3,4],", "]}]}"},
        {"JSON: a long name", Ends::refused, cameras + R"({"name":")", "x\\u00e9", "\"}]}", 64},
        {"JSON: a long number", Ends::refused, cameras + R"({"name":"a","fx":0.)", "3", "}]}", 64},
        {"JSON: a number that is too long", Ends::refused, "[", "9", "]", 64},
        {"JSON: blanks", Ends::well, "[", " \n\t", "]", 16},
        {"JSON: blanks and no end", Ends::refused, "[", "\n", "", 16},
    });
}

void colmap()
{
    most_a_byte = 32, most_beside = 1 << 18;
    static std::string const a_lens = "1 PINHOLE 640 480 500 510 320 240\n";
    auto const images = [](std::istream& in) {
        CountedText lens(a_lens);
        std::istream cameras_txt(&lens);
        scene::read_colmap(cameras_txt, in);
    };
    auto const lenses = [](std::istream& in) {
        CountedText none("");
        std::istream images_txt(&none);
        scene::read_colmap(in, images_txt);
    };
    std::string const lens = "$ PINHOLE 640 480 500 510 320 240\n", image = " 1 0 0 0 0.5 1e-3 2 1 image";
    expect_linear(lenses, {
        {"COLMAP: cameras", Ends::well, "", lens},
        {"COLMAP: comments and blank lines", Ends::well, "", "# comment\n \n"},
    });
    // As many keys as a hash table of this size puts into one bucket.
    expect_linear("COLMAP: cameras whose ids collide", Ends::well, lenses, [&](std::size_t n) {
        std::unordered_map<std::uint32_t, int> table;
        for (std::uint32_t i = 0; i < n; ++i) table.emplace(i, 0);
        return repeated(n, [&](std::size_t i) { return filled(lens, i * table.bucket_count()); });
    });
    expect_linear(images, {
        {"COLMAP: images", Ends::well, "", "$" + image + "$.png\n\n"},
        {"COLMAP: the shortest images", Ends::well, "", "1 1 0 0 0 0 0 0 1 $\n\n"},
        {"COLMAP: images with points", Ends::well, "", "$" + image + "$.png\n10.5 20.25 -1 30 4e1 77\n"},
        {"COLMAP: an image of many points", Ends::well, "1" + image + "1.png\n", "10.5 20.25 -1 ", "\n", 16},
        {"COLMAP: a line that is too long", Ends::refused, "", "1", "", 100},
    });
}

std::string bits_of(double value)
{
    std::string bytes;
    scene_test::put_little(bytes, std::bit_cast<std::uint64_t>(value), 8);
    return bytes;
}
std::string word(std::uint64_t value, std::size_t bytes = 4)
{
    std::string out;
    scene_test::put_little(out, value, bytes);
    return out;
}

void colmap_binary()
{
    most_a_byte = 16, most_beside = 3 << 20;
    // SIMPLE_PINHOLE, 640 x 480
    static auto const lens = [](std::size_t id) { return word(id) + word(0) + word(640, 8) + word(480, 8) + bits_of(500) + bits_of(320) + bits_of(240); };
    auto const image = [](std::size_t i, std::size_t points) {
        std::string pose;
        for (double v : {1.0, 0.0, 0.0, 0.0, 0.5, 1e-3, 2.0}) pose += bits_of(v);
        return word(i) + pose + word(1) + number(i) + std::string(1, '\0') + word(points, 8) + std::string(24 * points, '\1');
    };
    auto const images = [](std::istream& in) {
        CountedText one(word(1, 8) + lens(1));
        std::istream cameras_bin(&one);
        scene::read_colmap_binary(cameras_bin, in);
    };
    auto const lenses = [](std::istream& in) {
        CountedText none(word(0, 8));
        std::istream images_bin(&none);
        scene::read_colmap_binary(in, images_bin);
    };
    expect_linear("COLMAP, binary: cameras", Ends::well, lenses, [](std::size_t n) { return word(n, 8) + repeated(n, lens); });
    expect_linear("COLMAP, binary: cameras, the last first", Ends::well, lenses,
                  [](std::size_t n) { return word(n, 8) + repeated(n, [&](std::size_t i) { return lens(n - i); }); });
    expect_linear("COLMAP, binary: images", Ends::well, images,
                  [&](std::size_t n) { return word(n, 8) + repeated(n, [&](std::size_t i) { return image(i, 0); }); });
    expect_linear("COLMAP, binary: images with points", Ends::well, images,
                  [&](std::size_t n) { return word(n, 8) + repeated(n, [&](std::size_t i) { return image(i, 5); }); });
    expect_linear("COLMAP, binary: an image without an end of its name", Ends::refused, images,
                  [&](std::size_t n) { return word(1, 8) + image(1, 0).substr(0, 65) + std::string(64 * n, 'x'); });
    expect_linear("COLMAP, binary: fewer images than promised", Ends::refused, images,
                  [&](std::size_t n) { return word(n + 1, 8) + repeated(n, [&](std::size_t i) { return image(i, 0); }); });
}

void trajectories()
{
    most_a_byte = 24, most_beside = 1 << 18;
    auto const read = [](std::istream& in) { scene::trajectory_notes(scene::read_tum(in, "walk.tum")); };
    expect_linear("TUM: poses that go back in time", Ends::well, read,
                  [](std::size_t n) { return repeated(n, [&](std::size_t i) { return number(n - i) + " 1 2 3 0 0 0 1\n"; }); });
    expect_linear(read, {
        {"TUM: poses", Ends::well, "", "$.25 1 2 3 0 0 0 1\n"},
        {"TUM: poses of one time", Ends::well, "", "1 1 2 3 0 0 0 1\n"},
        {"TUM: the shortest poses", Ends::well, "", "0 0 0 0 0 0 0 1\n", "", 1, 5000},
        {"TUM: comments", Ends::refused, "", "# comment\n\n"},
        {"TUM: many fields", Ends::refused, "", "1 1 2\n1 "},
    });
    std::string const euroc = "0,0,0,0,1,0,0,0\n", kitti = "1 0 0 0 0 1 0 0 0 0 1 0";
    expect_linear([](std::istream& in) { scene::trajectory_notes(scene::read_trajectory(in, "walk")); }, {
        {"EuRoC: poses", Ends::well, "", "$000000000,1,2,3,1,0,0,0,0.5,0.5\n"},
        {"EuRoC: the shortest poses", Ends::well, "qw qx\n", euroc, "", 1, 5000},
        {"TUM or EuRoC: poses that say neither", Ends::refused, "", euroc, "", 1, 5000},
        {"EuRoC: a line of many fields", Ends::refused, "0,0,0,0,1,0,0,0", ",0", "\n", 100},
        {"KITTI: the shortest poses", Ends::well, "", kitti + "\n", "", 1, 5000},
        {"KITTI: the last pose is short", Ends::refused, "", kitti + "\n", "1 0 0\n"},
        {"Replica: the shortest poses", Ends::well, "", kitti + " 0 0 0 1\n", "", 1, 5000},
    });
}

/// `rows`: their number, or $.
std::string header(std::string const& format, std::string const& before, std::string const& rows, std::string const& more = "")
{
    std::string text = "ply\nformat " + format + " 1.0\n" + before + "element vertex " + rows + "\n";
    for (auto const& name : scene::detail::needed_properties) text += "property float " + std::string(name) + "\n";
    return text + more + "end_header\n";
}

void maps()
{
    most_a_byte = 5, most_beside = 8 << 20;
    auto const read = [](std::istream& in) { scene::read_ply(in, "map.ply"); };
    static std::string const row = "0.5 1 2 0.25 -1 1 2.5 -3 -3 -3 1 0 0 0";
    std::string const rest = repeated(45, "property float f_rest_$\n"), faces = "element face $\nproperty list uchar int i\n";
    std::string const zeros(14 * 4, '\0'), nan(14 * 4, '\xff');
    std::string ones;
    for (int i = 0; i < 14; ++i) ones += std::string("\x00\x00\x80\x3f", 4);
    std::string const big(ones.rbegin(), ones.rend());
    std::string const little_endian = "binary_little_endian", big_endian = "binary_big_endian";
    expect_linear(read, {
        {"PLY: ASCII", Ends::well, header("ascii", "", "$"), row + "\n"},
        {"PLY: ASCII with harmonics", Ends::well, header("ascii", "", "$", rest), row + repeated(45, " 0.5") + "\n"},
        {"PLY: ASCII with blank lines", Ends::well, header("ascii", "", "$"), "\n \n" + row + "\n"},
        {"PLY: ASCII, one long list", Ends::well, header("ascii", "", "1", "property list int float l\n") + row + " $", " 0", "\n", 64},
        {"PLY: little-endian", Ends::well, header(little_endian, "", "$"), ones},
        {"PLY: little-endian with harmonics", Ends::well, header(little_endian, "", "$", rest), ones + std::string(45 * 4, '\0')},
        {"PLY: big-endian", Ends::well, header(big_endian, "", "$"), big},
        {"PLY: rejected rows", Ends::well, header(little_endian, "", "$"), nan},
        {"PLY: rows of zeros", Ends::well, header(big_endian, "", "$"), zeros},
        // Each list is longer than the buffer of a file, so each is skipped in the stream.
        {"PLY: lists that are longer than the buffer", Ends::well, header(little_endian, "element big $\nproperty list int uchar l\n", "1"),
         std::string("\x00\x00\x11\x00", 4) + std::string(0x110000, '\0'), ones, 1, 2},
        {"PLY: an element that is passed over", Ends::well, header(little_endian, "element skipped $\nproperty double a\n", "1"), "12345678", ones, 1,
         100000},
        {"PLY: comments", Ends::well, "ply\nformat ascii 1.0\n", "comment a b c\n", header("ascii", "", "1").substr(21) + row + "\n"},
        {"PLY: elements", Ends::well, "ply\nformat ascii 1.0\n", "element e$ 0\n", header("ascii", "", "1").substr(21) + row + "\n"},
        {"PLY: a header without an end", Ends::refused, "ply\n", "comment 23456789 123456789 12\n"},
        {"PLY: words in a header's line", Ends::refused, "ply\nelement ", "a ", "\n", 8},
    });
    auto const columns = [&](std::string const& property) {
        return [=](std::size_t n) { return header("ascii", "", "1", repeated(n, property)) + row + repeated(n, " 7") + "\n"; };
    };
    expect_linear("PLY: columns that nobody reads", Ends::well, read, columns("property uchar c$\n"));
    expect_linear("PLY: columns f_rest_", Ends::well, read, columns("property float f_rest_$\n"));
    auto const lists = [&](std::string const& format, std::string const& property, std::string const& list, std::string const& each) {
        return [=](std::size_t n) { return filled(header(format, faces, "$", property), n) + repeated(n, list) + repeated(n, each); };
    };
    expect_linear("PLY: ASCII with lists", Ends::well, read, lists("ascii", "property list int float l\n", "3 1 2 3\n", row + " 2 0 1\n"));
    expect_linear("PLY: binary with lists", Ends::well, read,
                  lists(little_endian, "property list uchar short l\n", "\x02" + std::string(8, '\0'), ones + "\x03" + std::string(6, '\0')));
}

void compressed_maps()
{
    using namespace scene_test;
    using scene::Codecs;
    auto const read_with = [](Codecs const& codecs) { return [codecs](std::istream& in) { scene::read_map(in, "map.splat", codecs); }; };
    auto const read = read_with(plain_codecs());
    Numbers numbers(9);
    // As PLY.
    most_a_byte = 5, most_beside = 8 << 20;
    for (std::uint32_t degree : {0u, 3u})
        for (bool big : {false, true})
            expect_linear("compressed PLY of degree " + number(degree) + (big ? ", big-endian" : ""), Ends::well, read, [&](std::size_t n) {
                auto packed = PackedPly::random(n, degree, true, numbers);
                packed.big = big;
                return packed.bytes();
            });
    expect_linear("compressed PLY: rejected rows", Ends::well, read, [&](std::size_t n) {
        auto packed = PackedPly::random(n, 1, true, numbers);
        for (auto& chunk : packed.chunks) chunk[0] = std::numeric_limits<float>::infinity();
        return packed.bytes();
    });
    expect_linear(".splat", Ends::well, read, [&](std::size_t n) { return PackedSplat::random(n, numbers).bytes(); });
    expect_linear(".splat: rejected rows", Ends::well, read, [](std::size_t n) { return std::string(32 * n, '\xff'); });

    most_a_byte = 400, most_beside = 48 << 20;
    for (std::uint32_t version = 1; version <= 4; ++version)
        for (std::uint32_t degree : {0u, 4u})
            expect_linear("SPZ " + number(version) + " of degree " + number(degree), Ends::well, read,
                          [&](std::size_t n) { return PackedSpz::random(n, version, degree, numbers).bytes({}); });
    expect_linear("SPZ 3, not compressed", Ends::well, read, [&](std::size_t n) { return PackedSpz::random(n, 3, 3, numbers).plain(); });
    expect_linear("SPZ 2: bytes after the last row", Ends::well, read,
                  [&](std::size_t n) { return PackedSpz::random(1, 2, 0, numbers).plain() + std::string(64 * n, 'x'); });
    expect_linear("SPZ 4: bytes between header and table", Ends::well, read, [&](std::size_t n) {
        auto packed = PackedSpz::random(1, 4, 0, numbers);
        packed.after = std::string(64 * n, 'x');
        return packed.bytes({});
    });
    for (std::uint32_t version = 1; version <= 2; ++version)
        for (std::uint32_t degree : {0u, 3u})
            for (bool deflate : {false, true})
                expect_linear("SOG " + number(version) + " of degree " + number(degree) + (deflate ? ", deflated" : ""), Ends::well, read,
                              [&](std::size_t n) { return write_zip(PackedSog::random(n, version, degree, numbers).files({}), {}, deflate); });
    auto const few = PackedSog::random(4, 2, 1, numbers);
    auto const with_entries = [&](std::size_t n, std::string const& before) {
        auto files = few.files({});
        for (std::size_t i = 0; i < n; ++i) files[before + number(i)] = "x";
        return write_zip(files, {}, false);
    };
    expect_linear("SOG: an archive of many files", Ends::well, read, [&](std::size_t n) { return with_entries(n, "a"); });
    expect_linear("SOG: no file of an archive is meta.json", Ends::refused, read, [&](std::size_t n) {
        std::map<std::string, Bytes> files;
        for (std::size_t i = 0; i < n; ++i) files["file" + number(i)] = "x";
        return write_zip(files, {}, false);
    });
    expect_linear("SOG: keys of meta.json that nobody reads", Ends::well, read, [&](std::size_t n) {
        auto files = few.files({});
        auto& meta = files["meta.json"];
        meta.insert(1, repeated(n, "\"k$\":[0],") + ",");
        return write_zip(files, {}, false);
    });
    expect_linear("SOG: a long list in meta.json", Ends::refused, read, [&](std::size_t n) {
        auto files = few.files({});
        files["meta.json"] = "{\"means\":{\"mins\":[" + repeated(64 * n, "0,") + "]}}";
        return write_zip(files, {}, false);
    });

    // Streams and pictures that compress as no map does: the reader refuses more than 65,536 rows beside one a byte, and has to hold those.
    Codecs bombs = plain_codecs();
    bombs.gzip = bombs.zstd = +[](std::span<unsigned char const> in, std::span<unsigned char> out) {
        std::size_t const given = std::min<std::size_t>(16, out.size()); // the header; then zeros without an end
        std::copy_n(in.begin() + 3, given, out.begin());
        std::fill(out.begin() + static_cast<std::ptrdiff_t>(given), out.end(), static_cast<unsigned char>(0));
        Codecs::Result result;
        result.bytes = out.size();
        result.ended = true;
        return result;
    };
    bombs.webp_read = +[](std::span<unsigned char const>, std::span<unsigned char> rgba) {
        for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = i % 4 == 3 ? 252 : 0;
        return true;
    };
    expect_linear("SPZ: as many rows as the file may promise", Ends::well, read_with(bombs), [&](std::size_t n) {
        PackedSpz packed{3, 4, 12, 0, {}, {}};
        return "\x1f\x8b\x08" + packed.header(0, n + 65536) + std::string(n - 19, 'x');
    }, 20000);
    expect_linear("SPZ: one row more", Ends::refused, read_with(bombs), [&](std::size_t n) {
        PackedSpz packed{3, 4, 12, 0, {}, {}};
        return "\x1f\x8b\x08" + packed.header(0, n + 65537) + std::string(n - 19, 'x');
    }, 20000);
    expect_linear("SOG: as many rows, and pixels, as the files may promise", Ends::well, read_with(bombs), [&](std::size_t n) {
        auto packed = PackedSog::random(1, 2, 3, numbers);
        packed.palette.resize(65536);
        auto files = packed.files({});
        std::size_t const rows = n + 65536, height = (65536 + 4 * rows) / 4096;
        for (auto& [name, content] : files)
            if (name != "meta.json") content = name == "shN_centroids.webp" ? plain_picture(960, 1024, "") : plain_picture(4096, static_cast<std::uint32_t>(height), "");
        files["means_l.webp"] += std::string(n, 'x');
        auto& meta = files["meta.json"];
        meta.replace(meta.find("\"count\":1,"), 10, "\"count\":" + number(rows) + ",");
        return write_zip(files, {}, false);
    }, 20000);
}

void parameters()
{
    most_a_byte = 64, most_beside = 1 << 18;
    std::string const costs = "model m\nclock 1000 kHz a\nexchange_cost live kind a\nrun 1 cycles a\nexchange 1 cycles a\n"
                              "exchange_byte 1 millicycles a\nsync 1 cycles a\nvote 1 cycles a\n";
    std::string const operation = "operation_$ 5 millicycles measured\n";
    expect_linear([](std::istream& in) { read_cost_model(in, "costs.txt"); }, {
        {"cost model: operations", Ends::well, costs, operation},
        {"cost model: operations, then an unknown parameter", Ends::refused, costs, operation, "what 1 cycles a\n"},
        {"cost model: comments", Ends::well, costs, "# comment\n\n"},
        {"cost model: more operations than a file may have", Ends::refused, costs, operation, "", 16, 2000},
    });
    expect_linear([](std::istream& in) { read_energy_model(in, "energy.txt"); }, {
        {"energy model: events", Ends::well, "energy e\n", "operation_$ 5 fJ measured\n"},
        {"energy model: the shortest events", Ends::well, "energy e\n", "$ 0 fJ a\n"},
        {"energy model: a long line", Ends::refused, "", "x", "", 100},
    });
}

} // namespace

int main()
{
    for (auto const read : {camera_json, colmap, colmap_binary, trajectories, maps, compressed_maps, parameters}) read();
    std::printf("%d files of n and 8 n entries, %d failures\n", cases, failures);
    return failures == 0 ? 0 : 1;
}
#endif

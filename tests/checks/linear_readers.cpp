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

std::string repeated(std::size_t n, std::function<std::string(std::size_t)> const& entry)
{
    std::string text;
    for (std::size_t i = 0; i < n; ++i) text += entry(i);
    return text;
}
std::string repeated(std::size_t n, std::string_view entry)
{
    return repeated(n, [&](std::size_t) { return std::string(entry); });
}
/// With commas between the entries.
template <class Entry>
std::string listed(std::size_t n, Entry const& entry)
{
    std::string text = repeated(n, entry);
    if (!text.empty()) text.pop_back();
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

std::string number(std::size_t i) { return std::to_string(i); }

void camera_json()
{
    most_a_byte = 24, most_beside = 1 << 18;
    auto const read = [](std::istream& in) {
        std::vector<std::string> notes;
        scene::read_cameras_json(in, "cameras.json", &notes);
    };
    auto const own = [](std::size_t i) {
        return R"({"name":"c)" + number(i) + R"(","width":640,"height":480,"fx":500.25,"fy":510,"cx":320.5,"cy":240,"world_to_camera":)"
               "[[1,0,0,0.125],[0,1,0,2],[0,0,1,-3e-1],[0,0,0,1]]},";
    };
    auto const training = [](std::string const& name, std::size_t i) {
        return R"({"id":)" + number(i) + R"(,"img_name":")" + name + R"(","width":640,"height":480,"fx":500.25,"fy":510,)"
               R"("position":[1,2,3],"rotation":[[1,0,0],[0,1,0],[0,0,1]]},)";
    };
    auto const of = [](std::string const& list) { return R"({"cameras":[)" + list + "]}"; };
    expect_linear("JSON: own cameras", Ends::well, read, [&](std::size_t n) { return of(listed(n, own)); });
    expect_linear("JSON: own cameras, all of one name", Ends::refused, read,
                  [&](std::size_t n) { return of(listed(n, [&](std::size_t) { return own(0); })); });
    expect_linear("JSON: cameras of a training", Ends::well, read,
                  [&](std::size_t n) { return "[" + listed(n, [&](std::size_t i) { return training("c" + number(i), i); }) + "]"; });
    expect_linear("JSON: cameras of a training that share a name", Ends::well, read,
                  [&](std::size_t n) { return "[" + listed(n, [&](std::size_t i) { return training("same", i); }) + "]"; });
    expect_linear("JSON: cameras of a training after one that is not usable", Ends::refused, read, [&](std::size_t n) {
        return R"([{"img_name":"first"},)" + listed(n, [&](std::size_t i) { return training("c" + number(i), i); }) + "]";
    });
    std::string const short_matrix = R"("rotation":[[1,0,0],[0,1,0],[0,0,1]])", short_lens = R"("width":1,"height":1,"fx":1,"fy":1)";
    expect_linear("JSON: the shortest cameras of a training", Ends::well, read, [&](std::size_t n) {
        return "[" + listed(n, [&](std::size_t i) {
                   return R"({"img_name":")" + number(i) + "\"," + short_lens + R"(,"position":[0,0,0],)" + short_matrix + "},";
               }) + "]";
    });
    std::string const short_pose = R"("transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
    auto const frame = [&](std::size_t i, std::string const& more) { return R"({"file_path":")" + number(i) + "\"," + short_pose + more + "},"; };
    auto const transforms = [](std::string const& lens, std::string const& frames, std::string const& end = "") {
        return "{" + lens + R"("frames":[)" + frames + "]" + end + "}";
    };
    std::string const short_transforms_lens = R"("w":1,"h":1,"fl_x":1,)";
    expect_linear("transforms.json: the shortest frames", Ends::well, read,
                  [&](std::size_t n) { return transforms(short_transforms_lens, listed(n, [&](std::size_t i) { return frame(i, ""); })); });
    expect_linear("transforms.json: the lens behind the frames", Ends::well, read, [&](std::size_t n) {
        return transforms("", listed(n, [&](std::size_t i) { return frame(i, ""); }), R"(,"w":640,"h":480,"camera_angle_x":0.75)");
    });
    expect_linear("transforms.json: a lens for each frame", Ends::well, read,
                  [&](std::size_t n) { return transforms(short_transforms_lens, listed(n, [&](std::size_t i) { return frame(i, R"(,"w":2)"); })); });
    expect_linear("transforms.json: frames of one name", Ends::refused, read,
                  [&](std::size_t n) { return transforms(short_transforms_lens, listed(n, [&](std::size_t) { return frame(0, ""); })); });
    expect_linear("transforms.json: keys of a frame that nobody reads", Ends::well, read, [&](std::size_t n) {
        return transforms(short_transforms_lens, listed(n, [&](std::size_t i) { return frame(i, ",\"k" + number(i) + "\":0"); }));
    });
    expect_linear("transforms.json: {} in frames[]", Ends::refused, read, [&](std::size_t n) { return transforms("", listed(n, "{},")); });
    expect_linear("transforms.json: frames[] again and again", Ends::refused, read,
                  [&](std::size_t n) { return "{" + listed(n, [&](std::size_t i) { auto const one = frame(i, ""); return R"("frames":[)" + one.substr(0, one.size() - 1) + "],"; }) + "}"; });
    expect_linear("JSON: names and nothing else", Ends::refused, read, [&](std::size_t n) {
        return "[" + listed(n, [&](std::size_t i) { return R"({"img_name":")" + number(i) + "\"},"; }) + "]";
    });
    expect_linear("JSON: {} in a list", Ends::refused, read, [](std::size_t n) { return "[" + listed(n, "{},") + "]"; });
    expect_linear("JSON: {} in cameras[]", Ends::refused, read, [&](std::size_t n) { return of(listed(n, "{},")); });
    expect_linear("JSON: [] in a list", Ends::refused, read, [](std::size_t n) { return "[" + listed(n, "[],") + "]"; });
    expect_linear("JSON: numbers in a list", Ends::refused, read, [](std::size_t n) { return "[" + listed(n, "0,") + "]"; });
    expect_linear("JSON: lists without an end", Ends::refused, read, [](std::size_t n) { return "[" + repeated(n, "[0],"); });
    expect_linear("JSON: keys that nobody reads", Ends::well, read, [](std::size_t n) {
        return "{" + repeated(n, [](std::size_t i) { return "\"u" + number(i) + "\":[{\"a\":1}],"; }) + R"("cameras":[]})";
    });
    expect_linear("JSON: keys of a camera that nobody reads", Ends::well, read, [&](std::size_t n) {
        auto const camera = listed(1, own);
        return of(camera.substr(0, camera.size() - 1) + repeated(n, [](std::size_t i) { return ",\"k" + number(100 + i) + "\":0"; }) + "}");
    });
    expect_linear("JSON: a long list of distortion", Ends::well, read,
                  [](std::size_t n) { return R"({"distortion":[[)" + listed(16 * n, "0,") + R"(]],"cameras":[]})"; });
    expect_linear("JSON: the same key again and again", Ends::well, read,
                  [](std::size_t n) { return "{" + listed(n, R"("cameras":[],)") + "}"; });
    expect_linear("JSON: fields of one camera again and again", Ends::refused, read,
                  [&](std::size_t n) { return of("{" + listed(n, R"("name":"a","fx":1,)") + "}"); });
    expect_linear("JSON: a matrix of many rows", Ends::refused, read,
                  [&](std::size_t n) { return of(R"({"name":"a","world_to_camera":[)" + listed(n, "[1,2,3,4],") + "]}"); });
    expect_linear("JSON: a long name", Ends::refused, read,
                  [&](std::size_t n) { return of(R"({"name":")" + repeated(64 * n, "x\\u00e9") + "\"}"); });
    expect_linear("JSON: a long number", Ends::refused, read,
                  [&](std::size_t n) { return of(R"({"name":"a","fx":0.)" + std::string(64 * n, '3') + "}"); });
    expect_linear("JSON: a number that is too long", Ends::refused, read,
                  [](std::size_t n) { return "[" + std::string(64 * n, '9') + "]"; });
    expect_linear("JSON: blanks", Ends::well, read, [](std::size_t n) { return "[" + repeated(16 * n, " \n\t") + "]"; });
    expect_linear("JSON: blanks and no end", Ends::refused, read, [](std::size_t n) { return "[" + repeated(16 * n, "\n"); });
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
    auto const lens = [](std::size_t id) { return number(id) + " PINHOLE 640 480 500 510 320 240\n"; };
    auto const image = [](std::size_t i) { return number(i) + " 1 0 0 0 0.5 1e-3 2 1 image" + number(i) + ".png\n"; };
    expect_linear("COLMAP: cameras", Ends::well, lenses, [&](std::size_t n) { return repeated(n, lens); });
    // As many keys as a hash table of this size puts into one bucket.
    expect_linear("COLMAP: cameras whose ids collide", Ends::well, lenses, [&](std::size_t n) {
        std::unordered_map<std::uint32_t, int> table;
        for (std::uint32_t i = 0; i < n; ++i) table.emplace(i, 0);
        return repeated(n, [&](std::size_t i) { return lens(i * table.bucket_count()); });
    });
    expect_linear("COLMAP: comments and blank lines", Ends::well, lenses, [](std::size_t n) { return repeated(n, "# comment\n \n"); });
    expect_linear("COLMAP: images", Ends::well, images, [&](std::size_t n) { return repeated(n, [&](std::size_t i) { return image(i) + "\n"; }); });
    expect_linear("COLMAP: the shortest images", Ends::well, images, [&](std::size_t n) {
        return repeated(n, [&](std::size_t i) { return "1 1 0 0 0 0 0 0 1 " + number(i) + "\n\n"; });
    });
    expect_linear("COLMAP: images with points", Ends::well, images, [&](std::size_t n) {
        return repeated(n, [&](std::size_t i) { return image(i) + "10.5 20.25 -1 30 4e1 77\n"; });
    });
    expect_linear("COLMAP: an image of many points", Ends::well, images,
                  [&](std::size_t n) { return image(1) + repeated(16 * n, "10.5 20.25 -1 ") + "\n"; });
    expect_linear("COLMAP: a line that is too long", Ends::refused, images, [](std::size_t n) { return std::string(100 * n, '1'); });
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
    expect_linear("TUM: poses", Ends::well, read,
                  [](std::size_t n) { return repeated(n, [](std::size_t i) { return number(i) + ".25 1 2 3 0 0 0 1\n"; }); });
    expect_linear("TUM: poses that go back in time", Ends::well, read,
                  [](std::size_t n) { return repeated(n, [&](std::size_t i) { return number(n - i) + " 1 2 3 0 0 0 1\n"; }); });
    expect_linear("TUM: poses of one time", Ends::well, read, [](std::size_t n) { return repeated(n, "1 1 2 3 0 0 0 1\n"); });
    expect_linear("TUM: the shortest poses", Ends::well, read, [](std::size_t n) { return repeated(n, "0 0 0 0 0 0 0 1\n"); }, 5000);
    expect_linear("TUM: comments", Ends::refused, read, [](std::size_t n) { return repeated(n, "# comment\n\n"); });
    expect_linear("TUM: many fields", Ends::refused, read, [](std::size_t n) { return repeated(n, "1 1 2\n1 "); });
    auto const read_any = [](std::istream& in) { scene::trajectory_notes(scene::read_trajectory(in, "walk")); };
    expect_linear("EuRoC: poses", Ends::well, read_any,
                  [](std::size_t n) { return repeated(n, [](std::size_t i) { return number(i) + "000000000,1,2,3,1,0,0,0,0.5,0.5\n"; }); });
    expect_linear("EuRoC: the shortest poses", Ends::well, read_any, [](std::size_t n) { return "qw qx\n" + repeated(n, "0,0,0,0,1,0,0,0\n"); }, 5000);
    expect_linear("TUM or EuRoC: poses that say neither", Ends::refused, read_any, [](std::size_t n) { return repeated(n, "0,0,0,0,1,0,0,0\n"); }, 5000);
    expect_linear("EuRoC: a line of many fields", Ends::refused, read_any, [](std::size_t n) { return "0,0,0,0,1,0,0,0" + repeated(100 * n, ",0") + "\n"; });
    expect_linear("KITTI: the shortest poses", Ends::well, read_any, [](std::size_t n) { return repeated(n, "1 0 0 0 0 1 0 0 0 0 1 0\n"); }, 5000);
    expect_linear("KITTI: the last pose is short", Ends::refused, read_any,
                  [](std::size_t n) { return repeated(n, "1 0 0 0 0 1 0 0 0 0 1 0\n") + "1 0 0\n"; });
    expect_linear("Replica: the shortest poses", Ends::well, read_any, [](std::size_t n) { return repeated(n, "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"); }, 5000);
}

std::string header(std::string const& format, std::string const& before, std::size_t rows, std::string const& more = "")
{
    std::string text = "ply\nformat " + format + " 1.0\n" + before + "element vertex " + number(rows) + "\n";
    for (auto const& name : scene::detail::needed_properties) text += "property float " + std::string(name) + "\n";
    return text + more + "end_header\n";
}
std::string rest(std::size_t columns)
{
    return repeated(columns, [](std::size_t i) { return "property float f_rest_" + number(i) + "\n"; });
}

void maps()
{
    most_a_byte = 5, most_beside = 8 << 20;
    auto const read = [](std::istream& in) { scene::read_ply(in, "map.ply"); };
    static std::string const row = "0.5 1 2 0.25 -1 1 2.5 -3 -3 -3 1 0 0 0";
    std::string const zeros(14 * 4, '\0'), nan(14 * 4, '\xff');
    std::string ones;
    for (int i = 0; i < 14; ++i) ones += std::string("\x00\x00\x80\x3f", 4);
    std::string const big(ones.rbegin(), ones.rend());
    std::string const little_endian = "binary_little_endian", big_endian = "binary_big_endian";
    expect_linear("PLY: ASCII", Ends::well, read, [](std::size_t n) { return header("ascii", "", n) + repeated(n, row + "\n"); });
    expect_linear("PLY: ASCII with harmonics", Ends::well, read,
                  [](std::size_t n) { return header("ascii", "", n, rest(45)) + repeated(n, row + repeated(45, " 0.5") + "\n"); });
    expect_linear("PLY: ASCII with blank lines", Ends::well, read,
                  [](std::size_t n) { return header("ascii", "", n) + repeated(n, "\n \n" + row + "\n"); });
    expect_linear("PLY: ASCII with lists", Ends::well, read, [](std::size_t n) {
        return header("ascii", "element face " + number(n) + "\nproperty list uchar int i\n", n, "property list int float l\n") +
               repeated(n, "3 1 2 3\n") + repeated(n, row + " 2 0 1\n");
    });
    expect_linear("PLY: ASCII, one long list", Ends::well, read, [](std::size_t n) {
        return header("ascii", "", 1, "property list int float l\n") + row + " " + number(64 * n) + repeated(64 * n, " 0") + "\n";
    });
    expect_linear("PLY: little-endian", Ends::well, read, [&](std::size_t n) { return header(little_endian, "", n) + repeated(n, ones); });
    expect_linear("PLY: little-endian with harmonics", Ends::well, read,
                  [&](std::size_t n) { return header(little_endian, "", n, rest(45)) + repeated(n, ones + std::string(45 * 4, '\0')); });
    expect_linear("PLY: big-endian", Ends::well, read, [&](std::size_t n) { return header(big_endian, "", n) + repeated(n, big); });
    expect_linear("PLY: rejected rows", Ends::well, read, [&](std::size_t n) { return header(little_endian, "", n) + repeated(n, nan); });
    expect_linear("PLY: rows of zeros", Ends::well, read, [&](std::size_t n) { return header(big_endian, "", n) + repeated(n, zeros); });
    expect_linear("PLY: binary with lists", Ends::well, read, [&](std::size_t n) {
        return header(little_endian, "element face " + number(n) + "\nproperty list uchar int i\n", n, "property list uchar short l\n") +
               repeated(n, std::string("\x02") + std::string(8, '\0')) + repeated(n, ones + "\x03" + std::string(6, '\0'));
    });
    // Each list is longer than the buffer of a file, so each is skipped in the stream.
    expect_linear("PLY: lists that are longer than the buffer", Ends::well, read, [&](std::size_t n) {
        return header(little_endian, "element big " + number(n) + "\nproperty list int uchar l\n", 1) +
               repeated(n, std::string("\x00\x00\x11\x00", 4) + std::string(0x110000, '\0')) + ones;
    }, 2);
    expect_linear("PLY: an element that is passed over", Ends::well, read, [&](std::size_t n) {
        return header(little_endian, "element skipped " + number(n) + "\nproperty double a\n", 1) + repeated(n, "12345678") + ones;
    }, 100000);
    expect_linear("PLY: columns that nobody reads", Ends::well, read, [](std::size_t n) {
        return header("ascii", "", 1, repeated(n, [](std::size_t i) { return "property uchar c" + number(i) + "\n"; })) + row +
               repeated(n, " 7") + "\n";
    });
    expect_linear("PLY: columns f_rest_", Ends::well, read, [](std::size_t n) {
        return header("ascii", "", 1, rest(n)) + row + repeated(n, " 7") + "\n";
    });
    expect_linear("PLY: elements", Ends::well, read, [](std::size_t n) {
        return header("ascii", repeated(n, [](std::size_t i) { return "element e" + number(i) + " 0\n"; }), 1) + row + "\n";
    });
    expect_linear("PLY: comments", Ends::well, read,
                  [](std::size_t n) { return header("ascii", repeated(n, "comment a b c\n"), 1) + row + "\n"; });
    expect_linear("PLY: a header without an end", Ends::refused, read,
                  [](std::size_t n) { return "ply\n" + repeated(n, "comment 23456789 123456789 12\n"); });
    expect_linear("PLY: words in a header's line", Ends::refused, read,
                  [](std::size_t n) { return "ply\nelement " + repeated(8 * n, "a ") + "\n"; });
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
        meta.insert(1, repeated(n, [](std::size_t i) { return "\"k" + number(i) + "\":[0],"; }));
        return write_zip(files, {}, false);
    });
    expect_linear("SOG: a long list in meta.json", Ends::refused, read, [&](std::size_t n) {
        auto files = few.files({});
        files["meta.json"] = "{\"means\":{\"mins\":[" + listed(64 * n, "0,") + "]}}";
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
    auto const read_costs = [](std::istream& in) { read_cost_model(in, "costs.txt"); };
    auto const read_energy = [](std::istream& in) { read_energy_model(in, "energy.txt"); };
    auto const operation = [](std::string const& unit) {
        return [unit](std::size_t i) { return "operation_" + number(i) + " 5 " + unit + " measured\n"; };
    };
    expect_linear("cost model: operations", Ends::well, read_costs,
                  [&](std::size_t n) { return costs + repeated(n, operation("millicycles")); });
    expect_linear("cost model: operations, then an unknown parameter", Ends::refused, read_costs,
                  [&](std::size_t n) { return costs + repeated(n, operation("millicycles")) + "what 1 cycles a\n"; });
    expect_linear("cost model: comments", Ends::well, read_costs, [&](std::size_t n) { return costs + repeated(n, "# comment\n\n"); });
    expect_linear("cost model: more operations than a file may have", Ends::refused, read_costs,
                  [&](std::size_t n) { return costs + repeated(16 * n, operation("millicycles")); }, 2000);
    expect_linear("energy model: events", Ends::well, read_energy,
                  [&](std::size_t n) { return "energy e\n" + repeated(n, operation("fJ")); });
    expect_linear("energy model: the shortest events", Ends::well, read_energy, [&](std::size_t n) {
        return "energy e\n" + repeated(n, [](std::size_t i) { return number(i) + " 0 fJ a\n"; });
    });
    expect_linear("energy model: a long line", Ends::refused, read_energy, [](std::size_t n) { return std::string(100 * n, 'x'); });
}

} // namespace

int main()
{
    for (auto const read : {camera_json, colmap, colmap_binary, trajectories, maps, compressed_maps, parameters}) read();
    std::printf("%d files of n and 8 n entries, %d failures\n", cases, failures);
    return failures == 0 ? 0 : 1;
}
#endif

// How long the host takes to load a map in each format, beside reading the bytes alone, and how much memory. Exit status 1 if a check fails.
#include <algorithm>
#include <array>
#include <common/options.hpp>
#include <common/program.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <shared/codecs.hpp>
#include <scene/real_packing.hpp>
#include <string>
#include <sys/resource.h>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/map_file.hpp>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace scene_test;
using tilemesh::Error;

double cpu_seconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The largest resident memory of this process so far, in bytes.
double peak_bytes()
{
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    return 1024.0 * static_cast<double>(use.ru_maxrss);
}

/// The process that loads one file: prints the CPU seconds of the load and of reading all bytes, the peak of memory over what the process had
/// before, and the number of Gaussians and of bytes of their records.
int load_one(fs::path const& path)
{
    auto const codecs = shared::codecs();
    double const before = cpu_seconds(), memory_before = peak_bytes();
    auto const map = tilemesh::scene::load_map(path, codecs);
    double const loaded = cpu_seconds(), peak = peak_bytes() - memory_before;
    std::uintmax_t bytes = 0;
    unsigned sum = 0;
    std::vector<fs::path> files{path};
    if (fs::is_directory(path)) {
        files.clear();
        for (auto const& entry : fs::directory_iterator(path)) files.push_back(entry.path());
    }
    double const start = cpu_seconds();
    for (auto const& file : files) {
        std::ifstream in(file, std::ios::binary);
        std::vector<char> buffer(1 << 20);
        while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || in.gcount() > 0) {
            bytes += static_cast<std::uintmax_t>(in.gcount());
            sum += static_cast<unsigned char>(buffer[0]);
        }
    }
    double const read = cpu_seconds();
    auto const records = 60.0 * static_cast<double>(map.gaussians.size()) + 4.0 * static_cast<double>(map.harmonics.size());
    std::printf("%.6f %.6f %.0f %zu %.0f %ju %u\n", loaded - before, read - start, peak, map.gaussians.size(), records, bytes, sum & 1u);
    return 0;
}

/// Random Gaussians in clusters.
PlainMap make_map(std::size_t n, std::uint32_t degree)
{
    Numbers numbers(40);
    PlainMap map{degree, std::vector<PlainRow>(n)};
    std::array<double, 3> centre{};
    for (std::size_t i = 0; i < n; ++i) {
        PlainRow& row = map.rows[i];
        if (i % 500 == 0)
            for (double& v : centre) v = numbers.between(-4, 4);
        for (std::size_t k = 0; k < 3; ++k) {
            row.mean[k] = centre[k] + numbers.between(-0.1, 0.1);
            row.f_dc[k] = numbers.between(-1.5, 2);
            row.scale[k] = numbers.between(-8, -2);
        }
        for (double& v : row.rotation) v = numbers.between(-1, 1);
        row.logit = numbers.between(-4, 4);
        for (std::size_t k = 0; k < coefficients_of(degree); ++k) row.rest[k] = numbers.between(-0.3, 0.3);
    }
    return map;
}

/// A palette has at most 65,536 entries.
[[maybe_unused]] PackedSog sog_of(PlainMap const& map, std::uint32_t version)
{
    auto packed = PackedSog::of(map, version);
    if (packed.palette.size() > 65536) packed.palette.resize(65536);
    for (std::size_t i = 0; i < packed.rows.size(); ++i) packed.rows[i].label = static_cast<std::uint16_t>(i * 7919 % 65536 % std::max<std::size_t>(packed.palette.size(), 1));
    return packed;
}

struct Loaded {
    double load_s = 1e9, bytes_s = 1e9, peak = 0, records = 0;
    std::size_t gaussians = 0;
    std::uintmax_t bytes = 0;
};
Loaded load(std::string const& program, fs::path const& path, int rounds)
{
    Loaded out;
    for (int i = 0; i < rounds; ++i) {
        std::FILE* const pipe = popen(("'" + program + "' --one '" + path.string() + "'").c_str(), "r");
        if (!pipe) throw Error("no process can be started (popen failed); try again");
        double load_s = 0, bytes_s = 0, peak = 0;
        int const found = std::fscanf(pipe, "%lf %lf %lf %zu %lf %ju", &load_s, &bytes_s, &peak, &out.gaussians, &out.records, &out.bytes);
        if (pclose(pipe) != 0 || found != 6) throw Error(path.string() + " was not loaded (the process that loads it failed); run load --one FILE");
        out.load_s = std::min(out.load_s, load_s);
        out.bytes_s = std::min(out.bytes_s, bytes_s);
        out.peak = std::max(out.peak, peak);
    }
    return out;
}

shared::OptionTable table_of(bench::Options& own)
{
    auto table = bench::table_of(
        {"load", "Writes 500,000 Gaussians without and with harmonics of degree 3 in each format, and loads each file in a\nprocess of its own.\n",
         "5,000 Gaussians, and one load of each file", "write the table: format,degree,gaussians,file_bytes,load_s,bytes_s,peak_over_records", false, false},
        own);
    table.says("data", "accepted, not needed: this program makes its maps");
    return table;
}

int run(bench::Options const& options)
{
    bench::expect_folder_of(options.csv);
    std::size_t const n = options.quick ? 5000 : 500000;
    fs::path const folder = fs::temp_directory_path() / ("tilemesh_load_" + std::to_string(getpid()));
    fs::create_directory(folder);
    std::string csv = "format,degree,gaussians,file_bytes,load_s,bytes_s,peak_over_records\n";
    bool good = true;
    std::printf("%-16s %6s %12s %9s %9s %15s\n", "format", "degree", "file, bytes", "load, s", "bytes, s", "peak / records");
    try {
        [[maybe_unused]] Packing const packing = real_packing();
        auto const measure = [&](std::string const& format, std::uint32_t degree, Bytes const& bytes, char const* extension) {
            fs::path const path = folder / (std::string("map") + extension);
            std::ofstream(path, std::ios::binary) << bytes;
            Loaded const found = load(fs::read_symlink("/proc/self/exe").string(), path, options.quick ? 1 : 5);
            fs::remove(path);
            double const ratio = found.peak / found.records;
            std::printf("%-16s %6u %12ju %9.3f %9.4f %15.2f\n", format.c_str(), degree, found.bytes, found.load_s, found.bytes_s, ratio);
            char line[200];
            std::snprintf(line, sizeof line, "%s,%u,%zu,%ju,%.6f,%.6f,%.3f\n", format.c_str(), degree, found.gaussians, found.bytes, found.load_s, found.bytes_s, ratio);
            csv += line;
            if (found.gaussians != n) std::printf("BROKEN: %zu of %zu Gaussians are loaded\n", found.gaussians, n), good = false;
            // A small map is smaller than the buffers of the readers.
            if (!options.quick && ratio > 2.5) std::printf("BROKEN: the peak of memory is above 2.5 times the records\n"), good = false;
        };
        for (std::uint32_t degree : {0u, 3u}) {
            PlainMap const map = make_map(n, degree);
            measure("PLY", degree, write_plain_ply(map), ".ply");
            measure("compressed PLY", degree, PackedPly::of(map).bytes(), ".ply");
            if (degree == 0) measure(".splat", degree, PackedSplat::of(map).bytes(), ".splat");
#if defined(TILEMESH_HAS_ZLIB)
            measure("SPZ 2 (gzip)", degree, PackedSpz::of(map, 2).bytes(packing), ".spz");
            measure("SPZ 3 (gzip)", degree, PackedSpz::of(map, 3).bytes(packing), ".spz");
#endif
#if defined(TILEMESH_HAS_ZSTD)
            measure("SPZ 4 (zstd)", degree, PackedSpz::of(map, 4).bytes(packing), ".spz");
#endif
#if defined(TILEMESH_HAS_WEBP) && defined(TILEMESH_HAS_ZLIB)
            for (std::uint32_t version : {1u, 2u})
                measure("SOG " + std::to_string(version) + " (archive)", degree, write_zip(sog_of(map, version).files(packing), packing, false), ".sog");
#endif
        }
    } catch (...) {
        fs::remove_all(folder);
        throw;
    }
    fs::remove_all(folder);
    if (!options.csv.empty()) {
        std::ofstream out(options.csv);
        out << csv;
        if (!out.flush()) throw Error(options.csv.string() + " cannot be written (the disk is full or the folder is read-only); name another file");
    }
    return good ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc == 3 && std::string(argv[1]) == "--one")
        return bench::guarded([&] { return load_one(argv[2]); }, "out of memory (the map is too large); load a smaller one");
    return bench::program(argc, argv, table_of, run, "out of memory (the maps are too large for this machine); use --quick");
}

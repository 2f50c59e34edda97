#include "require.hpp"
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size);

namespace {

/// Random numbers that are the same on every machine.
class Dice {
public:
    std::size_t below(std::size_t n)
    {
        state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17; // xorshift64 (Marsaglia 2003)
        return static_cast<std::size_t>(state_ % n);
    }

private:
    std::uint64_t state_ = 88172645463325252u;
};

/// A file with one to four changes: a byte, a piece that is cut out, doubled or taken from another file, a number or a sign of a grammar.
std::string mutated(std::string text, std::vector<std::string> const& files, Dice& dice)
{
    static std::vector<std::string> const words{"0", "-1", "1e37", "-1e300", "1e-400", "4294967296", "65535", "65536", "nan", "-inf", "+", "e", ".",
                                                " ", "\n", "\t", "\r\n", "#", ",", ":", "\"", "[", "]", "{", "}", "\\u00e9", std::string(1, '\0')};
    for (std::size_t changes = 1 + dice.below(4); changes > 0; --changes) {
        std::size_t const at = dice.below(text.size() + 1), length = dice.below(std::min<std::size_t>(text.size() - at, 40) + 1);
        std::string const& other = files[dice.below(files.size())];
        std::size_t const from = dice.below(other.size() + 1);
        switch (dice.below(6)) {
        case 0:
            if (at < text.size()) text[at] = static_cast<char>(dice.below(256));
            break;
        case 1:
            text.erase(at, length);
            break;
        case 2:
            text.insert(at, text.substr(at, length));
            break;
        case 3:
            text.replace(at, length, other.substr(from, dice.below(200)));
            break;
        case 4:
            text.insert(at, words[dice.below(words.size())]);
            break;
        default:
            text.replace(at, std::min<std::size_t>(length, 4), words[dice.below(words.size())]);
        }
    }
    return text;
}

} // namespace

/// Gives every file of the given folders, in the order of their names, to the fuzz target. With "--mutated N" it also gives N mutations of
/// these files, the same in every run. Fails if there is no file: a missing corpus tests nothing; and if no mutation got to what is `reached`.
int main(int count, char** arguments)
{
    std::vector<std::filesystem::path> paths;
    unsigned long mutants = 0;
    for (int i = 1; i < count; ++i) {
        if (std::string(arguments[i]) == "--mutated" && i + 1 < count) {
            mutants = std::strtoul(arguments[++i], nullptr, 10);
            continue;
        }
        for (auto const& entry : std::filesystem::directory_iterator(arguments[i]))
            if (entry.is_regular_file()) paths.push_back(entry.path());
    }
    std::sort(paths.begin(), paths.end());
    auto const feed = [](std::string const& bytes) { LLVMFuzzerTestOneInput(reinterpret_cast<std::uint8_t const*>(bytes.data()), bytes.size()); };
    std::vector<std::string> files;
    for (auto const& path : paths) {
        std::ifstream stream(path, std::ios::binary);
        files.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
        // Flushed, so that the last name printed is that of an input that ends the program.
        std::printf("%s: %zu bytes\n", path.filename().string().c_str(), files.back().size());
        std::fflush(stdout);
        feed(files.back());
    }
    std::printf("%zu inputs\n", files.size());
    if (files.empty()) return 1;
    for (auto& [what, inputs] : reached) inputs = 0;
    Dice dice;
    for (unsigned long i = 0; i < mutants; ++i) {
        std::string const text = mutated(files[dice.below(files.size())], files, dice);
        std::ofstream("last_mutated", std::ios::binary) << text; // the input that ends the program
        feed(text);
    }
    std::printf("%lu mutated inputs\n", mutants);
    bool all = true;
    for (auto const& [what, inputs] : reached) {
        std::printf("%s: reached by %lu of them\n", what.c_str(), inputs);
        all = all && (mutants == 0 || inputs > 0);
    }
    return all ? 0 : 1;
}

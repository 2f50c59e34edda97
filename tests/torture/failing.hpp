#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// In a program with failing.cpp, allocations and mappings fail when a test says so: the k-th alone, and the k-th with all after it.
namespace torture {

/// What is done while calls fail, on an object that was made before. `act` may throw; then `after_failure` is called, with memory.
class Act {
public:
    virtual ~Act() = default;
    virtual void act() = 0;
    virtual std::string result() = 0; ///< of the last act
    /// After an act that threw: what is not as it must be, before and after it acts once more; empty: all is. May throw Error: it refuses.
    virtual std::string after_failure(std::string const& right)
    {
        act();
        return result() == right ? "" : "another result afterwards";
    }
};

/// What fails: operator new and mmap, or the start of a thread.
enum class What { memory, thread };

struct Case {
    std::string name;
    std::function<std::unique_ptr<Act>()> make;
    What what = What::memory;
};

/// False under a sanitizer, which starts threads by itself.
bool has_threads_that_fail() noexcept;

/// Does each case once for every call that fails, or for some of them where they are many and the environment
/// variable TILEMESH_TORTURE is not "all". Each
/// time it throws std::bad_alloc or Error or has the right result, leaks nothing, and is right or refuses afterwards. Prints a table.
void torture(std::vector<Case> const& cases);

} // namespace torture

#pragma once
#include "../standard.hpp"

/// In a program with failing.cpp, allocations and mappings fail when a test asks for it: the k-th alone, or the k-th and all after it.
namespace torture {

/// An action on an object that exists already; calls fail during the action. If `act` throws, `after_failure` is called, with memory.
class Act {
public:
    virtual ~Act() = default;
    virtual void act() = 0;
    virtual std::string result() = 0; ///< of the last act
    /// Called after an act that threw. Returns what is wrong before or after the object acts once more; empty: nothing. May throw Error: it
    /// refuses.
    virtual std::string after_failure(std::string const& right)
    {
        act();
        return result() == right ? "" : "another result afterwards";
    }
};

/// The calls that fail: operator new and mmap, or the start of a thread.
enum class What { memory, thread };

struct Case {
    std::string name;
    std::function<std::unique_ptr<Act>()> make;
    What what = What::memory;
};

/// False under a sanitizer, because a sanitizer starts threads itself.
bool has_threads_that_fail() noexcept;

/// Runs each case once for every call that can fail. If there are many calls, it tries only some of them, unless the environment variable
/// TILEMESH_TORTURE is "all". Each time, the case must throw std::bad_alloc or Error, or give the right result. It must leak nothing, and
/// afterwards give the right result or refuse. Prints a table.
void torture(std::vector<Case> const& cases);

} // namespace torture

#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace slam {

/// Values as bytes, one after the other, in the layout of this machine and compiler: for a state that the same program reads again.
class StateWriter {
public:
    template <class T>
    void put(T const& value)
    {
        static_assert(std::is_trivially_copyable_v<T>, "a value of a state is copied as bytes");
        bytes_.append(reinterpret_cast<char const*>(&value), sizeof value);
    }
    void put_text(std::string_view text)
    {
        put(std::uint64_t{text.size()});
        bytes_.append(text);
    }
    template <class T>
    void put_all(std::vector<T> const& values)
    {
        static_assert(std::is_trivially_copyable_v<T>, "a value of a state is copied as bytes");
        put_text({reinterpret_cast<char const*>(values.data()), values.size() * sizeof(T)});
    }
    std::string take() { return std::exchange(bytes_, {}); }

private:
    std::string bytes_;
};

/// Reads what a `StateWriter` wrote, in the same order. Throws `Error` where the bytes end too early. The bytes must outlive it.
class StateReader {
public:
    explicit StateReader(std::string_view bytes) noexcept : bytes_(bytes) {}

    template <class T>
    T get()
    {
        static_assert(std::is_trivially_copyable_v<T>, "a value of a state is copied as bytes");
        T value;
        std::memcpy(static_cast<void*>(&value), next(sizeof value).data(), sizeof value);
        return value;
    }
    std::string_view text() { return next(get<std::uint64_t>()); }
    template <class T>
    std::vector<T> all()
    {
        static_assert(std::is_trivially_copyable_v<T>, "a value of a state is copied as bytes");
        auto const bytes = text();
        if (bytes.size() % sizeof(T) != 0) fail();
        std::vector<T> values(bytes.size() / sizeof(T));
        if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
        return values;
    }
    /// Throws `Error` if bytes are left.
    void finish() const
    {
        if (!bytes_.empty()) fail();
    }

    /// Throws the `Error` of a state that does not fit.
    [[noreturn]] static void fail()
    {
        throw Error("a run cannot go on from this state (it is damaged, or of another run); begin the run anew");
    }

private:
    std::string_view next(std::uint64_t size)
    {
        if (size > bytes_.size()) fail();
        auto const out = bytes_.substr(0, static_cast<std::size_t>(size));
        bytes_.remove_prefix(out.size());
        return out;
    }

    std::string_view bytes_;
};

}}} // namespace tilemesh::slam

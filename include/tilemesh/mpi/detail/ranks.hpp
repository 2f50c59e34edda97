#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <mpi.h>
#include <new>
#include <string>
#include <tilemesh/error.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mpi::detail {

/// An exception as a text of fixed length: to describe it to other ranks takes no memory.
struct Mistake {
    static constexpr std::size_t most_bytes = 2048;
    char text[most_bytes] = {};
    bool made = false;

    void set(char const* what) noexcept
    {
        made = true;
        std::strncpy(text, what, most_bytes - 1);
    }
    /// Runs f and keeps the text of its exception.
    template <class F>
    void watch(F const& f) noexcept
    {
        try {
            f();
        } catch (std::bad_alloc const&) {
            set("out of memory (a rank has not enough for its tiles); use more ranks, or smaller lists and channels");
        } catch (std::exception const& e) {
            set(e.what());
        } catch (...) {
            set("an exception that is no std::exception");
        }
    }
};

/// The ranks of a communicator, with a copy of the communicator, so that no message is mixed up with the user's. An error of MPI itself
/// ends the job. All functions but rank() and size() are collective: every rank calls them in the same order. MpiMesh
/// says of those that it shows what they do.
class Ranks {
public:
    explicit Ranks(MPI_Comm comm)
    {
        int initialized = 0, finalized = 0;
        MPI_Initialized(&initialized);
        MPI_Finalized(&finalized);
        if (initialized == 0 || finalized != 0)
            throw Error("an MpiMesh outside of MPI (MPI_Init_thread was not called, or MPI_Finalize was); build it between the two");
        MPI_Comm_dup(comm, &comm_);
        MPI_Comm_set_errhandler(comm_, MPI_ERRORS_ARE_FATAL);
        int n = 0;
        MPI_Comm_rank(comm_, &n);
        rank_ = static_cast<std::uint32_t>(n);
        MPI_Comm_size(comm_, &n);
        size_ = static_cast<std::uint32_t>(n);
    }
    ~Ranks()
    {
        int finalized = 0;
        MPI_Finalized(&finalized);
        if (finalized == 0) MPI_Comm_free(&comm_);
    }
    Ranks(Ranks const&) = delete;
    Ranks& operator=(Ranks const&) = delete;

    MPI_Comm comm() const noexcept { return comm_; }
    std::uint32_t rank() const noexcept { return rank_; }
    std::uint32_t size() const noexcept { return size_; }

    void least(std::uint64_t* words, std::size_t n) const { reduce(words, n, MPI_MIN); }
    void most(std::uint64_t* words, std::size_t n) const { reduce(words, n, MPI_MAX); }
    void sum(std::uint64_t* words, std::size_t n) const { reduce(words, n, MPI_SUM); }

    /// The least word is the complement of the least complement only then, in signed order too.
    bool same(std::uint64_t word) const
    {
        std::uint64_t words[] = {word, ~word};
        least(words, 2);
        return words[0] == ~words[1];
    }
    template <class F>
    void together(F const& f) const
    {
        Mistake mistake;
        mistake.watch(f);
        agree(mistake, [] { return std::string(); });
    }
    /// If some ranks have a mistake, every rank throws the Error of the lowest of them: its text, `where()`, and the rank. If all ranks have
    /// one, they have done the same, and the Error names no rank. Without a mistake it takes no memory.
    template <class Where>
    void agree(Mistake& mistake, Where const& where) const
    {
        std::uint64_t ranks[] = {mistake.made ? rank_ : none, mistake.made ? none : rank_};
        least(ranks, 2);
        if (ranks[0] == none) return;
        MPI_Bcast(mistake.text, static_cast<int>(Mistake::most_bytes), MPI_CHAR, static_cast<int>(ranks[0]), comm_);
        throw Error(mistake.text + where() + (ranks[1] == none ? "" : of_rank(ranks[0])));
    }
    /// Every rank gets the text of rank `of`.
    std::string text_of(std::uint32_t of, char const* text) const
    {
        Mistake carrier;
        if (of == rank_) carrier.set(text);
        MPI_Bcast(carrier.text, static_cast<int>(Mistake::most_bytes), MPI_CHAR, static_cast<int>(of), comm_);
        return carrier.text;
    }
    template <class F>
    std::uint64_t in_turn(std::uint64_t word, F const& f) const
    {
        Mistake mistake;
        for (std::uint32_t r = 0; r < size_; ++r) {
            if (r == rank_) mistake.watch([&] { word = f(word); });
            MPI_Bcast(&word, 1, MPI_UINT64_T, static_cast<int>(r), comm_);
        }
        agree(mistake, [] { return std::string(); });
        return word;
    }
    template <class T>
    void join(std::vector<T>& items) const
    {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<std::uint64_t> sizes;
        together([&] {
            sizes.resize(size_);
            sizes[rank_] = items.size();
        });
        sum(sizes.data(), sizes.size());
        together([&] {
            std::uint64_t all = 0;
            for (auto n : sizes) all += n;
            if (rank_ == 0) items.resize(all);
        });
        join(items.data(), [&](std::uint32_t r) { return sizes[r]; });
        if (rank_ != 0) items.clear();
    }
    template <class T, class N>
    void join(T* items, N const& n) const
    {
        static_assert(std::is_trivially_copyable_v<T>);
        if (rank_ != 0) {
            in_pieces(items, n(rank_), [&](unsigned char* at, int bytes) { MPI_Send(at, bytes, MPI_BYTE, 0, tag_of_items, comm_); });
            return;
        }
        auto at = items + n(0);
        for (std::uint32_t r = 1; r < size_; at += n(r++))
            in_pieces(at, n(r), [&](unsigned char* to, int bytes) {
                MPI_Recv(to, bytes, MPI_BYTE, static_cast<int>(r), tag_of_items, comm_, MPI_STATUS_IGNORE);
            });
    }
    template <class T>
    void share(std::vector<T>& items) const
    {
        static_assert(std::is_trivially_copyable_v<T>);
        std::uint64_t n = items.size();
        MPI_Bcast(&n, 1, MPI_UINT64_T, 0, comm_);
        together([&] { items.resize(n); });
        in_pieces(items.data(), n, [&](unsigned char* at, int bytes) { MPI_Bcast(at, bytes, MPI_BYTE, 0, comm_); });
    }
    template <class T>
    std::vector<T> deal(std::vector<T> items, std::vector<std::uint64_t>& counts) const
    {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<int> out, in;
        std::vector<T> got;
        std::vector<std::uint64_t> from;
        together([&] {
            out.resize(2 * std::size_t{size_});
            in.resize(2 * std::size_t{size_});
            from.resize(size_);
        });
        MPI_Alltoall(counts.data(), 1, MPI_UINT64_T, from.data(), 1, MPI_UINT64_T, comm_);
        together([&] {
            auto const place = [&](std::vector<std::uint64_t> const& n, std::vector<int>& at) {
                std::uint64_t all = 0;
                for (std::size_t r = 0; r < size_; all += n[r++]) {
                    at[r] = static_cast<int>(n[r]);
                    at[size_ + r] = static_cast<int>(all);
                }
                if (all > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
                    throw Error("a rank with " + std::to_string(all) + " items for other ranks (MPI counts to " +
                                std::to_string(std::numeric_limits<int>::max()) + "); use more ranks");
                return all;
            };
            place(counts, out);
            got.resize(place(from, in));
        });
        MPI_Datatype item;
        MPI_Type_contiguous(static_cast<int>(sizeof(T)), MPI_BYTE, &item);
        MPI_Type_commit(&item);
        MPI_Alltoallv(items.data(), out.data(), out.data() + size_, item, got.data(), in.data(), in.data() + size_, item, comm_);
        MPI_Type_free(&item);
        counts = std::move(from);
        return got;
    }
    static std::string of_rank(std::uint64_t rank) { return " [rank " + std::to_string(rank) + "]"; }

private:
    /// More than any rank. It is positive as a signed number too, because MPICH 4.0 takes the least MPI_UINT64_T of signed numbers.
    static constexpr std::uint64_t none = ~std::uint64_t{0} >> 1;

    static constexpr int tag_of_items = 4;

    /// Calls f(bytes, number) for pieces of the items that MPI can count.
    template <class T, class F>
    static void in_pieces(T* items, std::uint64_t n, F const& f)
    {
        constexpr std::uint64_t most = std::uint64_t{1} << 30;
        auto* const bytes = reinterpret_cast<unsigned char*>(items);
        for (std::uint64_t at = 0, end = n * sizeof(T); at < end; at += most) f(bytes + at, static_cast<int>(std::min(most, end - at)));
    }
    void reduce(std::uint64_t* words, std::size_t n, MPI_Op op) const
    {
        MPI_Allreduce(MPI_IN_PLACE, words, static_cast<int>(n), MPI_UINT64_T, op, comm_);
    }

    MPI_Comm comm_ = MPI_COMM_NULL;
    std::uint32_t rank_ = 0, size_ = 1;
};

}}} // namespace tilemesh::mpi::detail

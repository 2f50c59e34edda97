// Small codelets in the style of public codelets, written for this test. They compile and execute every kind of field and
// every habit of that code: templates with explicit instances, bare pointers with a count, lists, private edges,
// constraints, bytes cast to a struct, workers that wait for each other. They include only headers of codelets, and no
// test header.
#pragma once
#include <cmath>
#include <ipu_builtins.h>
#include <ipu_memory_intrinsics>
#include <ipu_vector_math>
#include <ipudef.h>
#include <poplar/AvailableVTypes.h>
#include <poplar/HalfFloat.hpp>
#include <poplar/StackSizeDefs.hpp>
#include <poplar/Vertex.hpp>
#include <type_traits>

using namespace poplar;

static constexpr auto SPAN = VectorLayout::SPAN;
static constexpr auto SHORT_SPAN = VectorLayout::SHORT_SPAN;
static constexpr auto ONE_PTR = VectorLayout::ONE_PTR;
static constexpr auto SCALED_PTR64 = VectorLayout::SCALED_PTR64;
static constexpr auto COMPACT_PTR = VectorLayout::COMPACT_PTR;
#ifdef VECTORLIST_AVAIL_DELTAN
static constexpr auto DELTAN = VectorListLayout::DELTAN;
#endif

#ifdef __IPU__
#define ON_SUPERVISOR __attribute__((target("supervisor")))
#else
#define ON_SUPERVISOR
#endif

DEF_STACK_USAGE(64, "__runCodelet_orchard__Polynomial");

namespace orchard {

/// A template with explicit instances; `void compute()`; a plain member of each element type.
template <typename T>
class Scale : public Vertex {
public:
    Scale();

    Input<Vector<T>> in;
    Output<Vector<T>> out;
    T const factor;

    void compute()
    {
        for (unsigned i = 0; i < out.size(); ++i) {
            if constexpr (std::is_integral_v<T>) out[i] = static_cast<T>(in[i] * factor);
            else out[i] = in[i] * factor;
        }
    }
};
template class Scale<float>;
template class Scale<int>;
template class Scale<half>;
template class Scale<unsigned short>;

/// Bare pointers with a count beside them, and a short span of at most 2,047 indices of 16 bits.
class Pick : public Vertex {
public:
    Input<Vector<float, ONE_PTR>> table;
    Input<Vector<unsigned short, SHORT_SPAN>> indices;
    Output<Vector<float, ONE_PTR>> picked;
    Output<Vector<signed char, COMPACT_PTR, 4>> even;
    unsigned tableSize;

    bool compute()
    {
        bool inside = true;
        for (auto i = 0u; i != indices.size(); ++i) {
            const auto index = indices[i];
            const bool there = index < tableSize;
            picked[i] = there ? table[index] : -1.0f;
            even[i] = index % 2 == 0 ? 1 : -1;
            inside &= there;
        }
        return inside;
    }
};

/// A two-dimensional input in a range-based loop, and a scalar that is read and written.
class RowSums : public Vertex {
public:
    Vector<Input<Vector<int>>> rows;
    Output<Vector<int>> sums;
    InOut<int> total;

    bool compute()
    {
        int row = 0;
        for (const auto& r : rows) {
            int sum = 0;
            for (const int x : r) sum += x;
            sums[row++] = sum;
            total += sum;
        }
        return true;
    }
};

/// A list of bare pointers behind a bare pointer: only the count gives its size.
class Deal : public Vertex {
public:
    Input<Vector<unsigned>> deck;
    Vector<Output<Vector<unsigned, ONE_PTR>>, ONE_PTR> hands;
    Vector<InOut<Vector<unsigned, SPAN, 8>>> piles;
    unsigned char players;

    bool compute()
    {
        for (unsigned i = 0; i < deck.size(); ++i) {
            const unsigned player = i % players, card = i / players;
            hands[player][card] = deck[i];
            piles[player][0] += deck[i];
            piles[player].back() = card + 1;
        }
        return true;
    }
};

/// VectorList fields, and private edges, which Poplar sees too.
class Largest : public Vertex {
    Input<VectorList<int, VectorListLayout::DELTANELEMENTS>> groups;
    InOut<VectorList<float, DELTAN, 8>> weights;
    Output<Vector<int>> largest;

    static int larger(int a, int b) { return a < b ? b : a; }

public:
    bool compute()
    {
        for (unsigned g = 0; g < groups.size(); ++g) {
            auto&& group = groups[g];
            int best = group[0];
            for (unsigned i = 1; i < group.size(); ++i) best = larger(best, group[i]);
            largest[g] = best;
            for (auto& w : weights[g]) w *= 0.5f;
        }
        return true;
    }
};

/// A constraint attribute, pairs of floats, and loads that move their pointer. The workers share the pairs.
class [[poplar::constraint("elem(*x) != elem(*y)")]] PairAxpy : public MultiVertex {
public:
    Input<Vector<float, ONE_PTR, 8>> x;
    InOut<Vector<float, SCALED_PTR64, 8>> y;
    Output<Vector<float, SPAN, 8>> partial; // one pair per worker
    unsigned short pairs;
    float a;

    bool compute(unsigned workerId)
    {
        const float2* from = reinterpret_cast<const float2*>(x.data()) + workerId;
        float2* to = reinterpret_cast<float2*>(&y[0]) + workerId;
        float2* sums = reinterpret_cast<float2*>(&partial[0]);
        const float2 scale{a, a};
        float2 sum{0.0f, 0.0f};
        for (unsigned i = workerId; i < pairs; i += numWorkers()) {
            const float2 v = ipu::fma(scale, ipu::load_postinc(&from, CTXT_WORKERS), *to);
            sum += v;
            ipu::store_postinc(&to, v, CTXT_WORKERS);
        }
        sums[workerId] = sum;
        return true;
    }
};

/// Workers that wait for each other: a prefix sum in two phases around a barrier that spins on shared words. The workers
/// must run at once.
class PrefixSum : public MultiVertex {
public:
    InOut<Vector<unsigned>> values;
    InOut<Vector<unsigned, ONE_PTR>> sums;
    InOut<Vector<unsigned, ONE_PTR>> arrived; // zero before the call
    unsigned perWorker;

    bool compute(unsigned workerId)
    {
        const unsigned first = workerId * perWorker;
        const unsigned end = first + perWorker < values.size() ? first + perWorker : values.size();
        for (unsigned i = first + 1; i < end; ++i) values[i] += values[i - 1];
        sums[workerId] = first < end ? values[end - 1] : 0;
        barrier(workerId);
        unsigned before = 0;
        for (unsigned w = 0; w < workerId; ++w) before += sums[w];
        for (unsigned i = first; i < end; ++i) values[i] += before;
        return true;
    }

private:
    void barrier(unsigned workerId)
    {
        volatile unsigned* flags = arrived.data();
        asm volatile("" ::: "memory");
        flags[workerId] = 1;
        for (unsigned w = 0; w < numWorkers(); ++w) {
            while (flags[w] == 0) {
            }
        }
        asm volatile("" ::: "memory");
    }
};

/// A supervisor vertex, which moves integers. Fill is a vertex through SupervisorVertexIf.
class Reverse : public SupervisorVertex {
public:
    Input<Vector<unsigned, SPAN, 4>> in;
    Output<Vector<unsigned, ONE_PTR, 4>> out;

    ON_SUPERVISOR bool compute()
    {
        for (unsigned i = 0; i < in.size(); ++i) out[in.size() - 1 - i] = in[i];
        return true;
    }
};

template <class T, bool assembly>
class Fill : public SupervisorVertexIf<assembly> {
public:
    Output<Vector<T>> out;
    T with;

    bool compute()
    {
        for (auto& x : out) x = with;
        return true;
    }
};
template class Fill<unsigned, false>;
template class Fill<bool, true>;

/// Arithmetic on halves: each step rounds to 11 bits.
class HalfDot : public Vertex {
public:
    Input<Vector<half, SPAN, 8>> a;
    Input<Vector<half, ONE_PTR, 8>> b;
    Output<half> dot;
    Output<float> exact;
    half bias;

    bool compute()
    {
        const half4* pa = reinterpret_cast<const half4*>(&a[0]);
        const half4* pb = reinterpret_cast<const half4*>(&b[0]);
        half4 sum{0, 0, 0, 0};
        float precise = 0.0f;
        for (unsigned i = 0; i < a.size() / 4; ++i) {
            const half4 u = ipu::load_postinc(&pa, 1), v = ipu::load_postinc(&pb, 1);
            sum += u * v;
            for (unsigned j = 0; j < 4; ++j) precise += float(u[j]) * float(v[j]);
        }
        *dot = sum[0] + sum[1] + (sum[2] + sum[3]) + bias;
        *exact = precise;
        return true;
    }
};

/// Truth values as inputs and outputs, one and many.
class Above : public Vertex {
public:
    Input<Vector<float>> in;
    Input<float> threshold;
    Input<bool> strict;
    Output<Vector<bool>> above;
    Output<bool> any;

    bool compute()
    {
        bool found = false;
        for (unsigned i = 0; i < in.size(); ++i) {
            above[i] = strict ? in[i] > threshold : in[i] >= *threshold;
            found = found || above[i];
        }
        any = found;
        return found;
    }
};

/// Structured bindings and, in C++20, designated initialisers.
class Extent : public Vertex {
    struct Ends {
        float low, high;
    };
    static Ends ends(const float* values, unsigned n)
    {
#if __cplusplus >= 202002L
        Ends e{.low = values[0], .high = values[0]};
#else
        Ends e{values[0], values[0]};
#endif
        for (unsigned i = 1; i < n; ++i) {
            e.low = __builtin_ipu_min(e.low, values[i]);
            e.high = __builtin_ipu_max(e.high, values[i]);
        }
        return e;
    }

public:
    Input<Vector<float>> in;
    Output<float> low, high;
    InOut<unsigned> calls;

    void compute()
    {
        const auto [l, h] = ends(in.data(), in.size());
        low = l;
        *high = h;
        ++calls;
    }
};

/// A table in the code, a table in the vertex, and a table of vectors in the vertex.
class Polynomial : public Vertex {
    static constexpr float signs[4] = {1.0f, -1.0f, 1.0f, -1.0f};

public:
    Polynomial();

    Input<Vector<float>> x;
    Output<Vector<float>> y;
    const Vector<half> coefficients;
    Vector<Vector<unsigned short, ONE_PTR>> exponents;

    bool compute()
    {
        for (unsigned i = 0; i < x.size(); ++i) {
            float sum = 0.0f;
            for (unsigned c = 0; c < coefficients.size(); ++c) {
                float power = 1.0f;
                for (unsigned short e = 0; e < exponents[c][0]; ++e) power *= x[i];
                sum += signs[c % 4] * coefficients[c] * power;
            }
            y[i] = sum;
        }
        return true;
    }
};

/// A struct cannot be a field: the codelet casts bytes to it.
struct Seed {
    unsigned id;
    float ripeness;
};
class Ripen : public Vertex {
public:
    InOut<Vector<char, ONE_PTR, 8>> storage;
    int count;
    float by;

    bool compute()
    {
        auto* seeds = reinterpret_cast<Seed*>(&storage[0]);
        for (int i = 0; i < count; ++i) {
            seeds[i].ripeness += by;
            if (seeds[i].ripeness >= 1.0f) seeds[i].id = 0;
        }
        return true;
    }
};

/// Static functions that take vectors by reference.
class Sort : public Vertex {
    static void swapAt(Vector<unsigned>& v, unsigned i, unsigned j)
    {
        const unsigned t = v[i];
        v[i] = v[j];
        v[j] = t;
    }
    static unsigned count(const Vector<unsigned>& v, unsigned x)
    {
        unsigned n = 0;
        for (auto it = v.begin(); it != v.end(); ++it) n += *it == x;
        return n;
    }

public:
    InOut<Vector<unsigned>> keys;
    Output<unsigned> zeros;

    bool compute()
    {
        for (unsigned i = 1; i < keys.size(); ++i)
            for (unsigned j = i; j > 0 && keys[j - 1] > keys[j]; --j) swapAt(keys, j - 1, j);
        *zeros = count(keys, 0);
        return true;
    }
};

/// Integers of the other widths.
class Widths : public Vertex {
public:
    Input<Vector<unsigned char>> bytes;
    Input<Vector<short>> shorts;
    Output<Vector<unsigned long long>> wide;
    InOut<long long> sum;
    signed char sign;
    bool twice;

    bool compute()
    {
        for (unsigned i = 0; i < bytes.size(); ++i) {
            wide[i] = static_cast<unsigned long long>(bytes[i]) << 32;
            sum += sign * shorts[i] * (twice ? 2 : 1);
        }
        return true;
    }
};

/// Each worker writes its own words. A worker without words still runs. compute() returns whether the worker has words.
class Stripes : public MultiVertex {
public:
    Output<Vector<unsigned>> out;
    Output<Vector<unsigned>> byWorker;
    static constexpr unsigned marks[MultiVertex::numWorkers()] = {10, 20, 30, 40, 50, 60};

    bool compute(unsigned workerId)
    {
        unsigned n = 0;
        for (unsigned i = workerId; i < out.size(); i += numWorkers(), ++n) out[i] = marks[workerId] + i;
        byWorker[workerId] = n;
        return n != 0;
    }
};

} // namespace orchard

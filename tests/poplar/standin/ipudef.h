// A stand-in for the header of the same name in popc: short vectors. Vectors of halves are classes, because a host compiler
// has no vector of a software type. Their arithmetic rounds each element as `half` does.
#pragma once
#include <poplar/HalfFloat.hpp>

typedef float float2 __attribute__((vector_size(8)));
typedef float float4 __attribute__((vector_size(16)));
typedef int int2 __attribute__((vector_size(8)));
typedef int int4 __attribute__((vector_size(16)));
typedef unsigned uint2 __attribute__((vector_size(8)));
typedef unsigned uint4 __attribute__((vector_size(16)));
typedef short short2 __attribute__((vector_size(4)));
typedef short short4 __attribute__((vector_size(8)));
typedef unsigned short ushort2 __attribute__((vector_size(4)));
typedef unsigned short ushort4 __attribute__((vector_size(8)));
typedef signed char char4 __attribute__((vector_size(4)));
typedef unsigned char uchar4 __attribute__((vector_size(4)));

/// The type of a loop counter that a hardware loop can hold.
typedef unsigned rptsize_t;

namespace standin {

/// N halves, aligned to their size.
template <unsigned N>
struct alignas(2 * N) HalfVector {
    half element[N];

    constexpr half& operator[](unsigned i) { return element[i]; }
    constexpr half const& operator[](unsigned i) const { return element[i]; }

    friend constexpr HalfVector operator+(HalfVector a, HalfVector b)
    {
        for (unsigned i = 0; i < N; ++i) a[i] = a[i] + b[i];
        return a;
    }
    friend constexpr HalfVector operator-(HalfVector a, HalfVector b)
    {
        for (unsigned i = 0; i < N; ++i) a[i] = a[i] - b[i];
        return a;
    }
    friend constexpr HalfVector operator*(HalfVector a, HalfVector b)
    {
        for (unsigned i = 0; i < N; ++i) a[i] = a[i] * b[i];
        return a;
    }
    friend constexpr HalfVector operator/(HalfVector a, HalfVector b)
    {
        for (unsigned i = 0; i < N; ++i) a[i] = a[i] / b[i];
        return a;
    }
    friend constexpr HalfVector operator*(half s, HalfVector v)
    {
        for (unsigned i = 0; i < N; ++i) v[i] = s * v[i];
        return v;
    }
    friend constexpr HalfVector operator*(HalfVector v, half s) { return s * v; }
    constexpr HalfVector& operator+=(HalfVector b) { return *this = *this + b; }
    constexpr HalfVector& operator-=(HalfVector b) { return *this = *this - b; }
    constexpr HalfVector& operator*=(HalfVector b) { return *this = *this * b; }
    constexpr HalfVector& operator/=(HalfVector b) { return *this = *this / b; }
};

} // namespace standin

using half2 = standin::HalfVector<2>;
using half4 = standin::HalfVector<4>;
using half8 = standin::HalfVector<8>;

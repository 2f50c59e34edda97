// A stand-in for the header of the same name in popc: the builtins of public codelets that have a meaning on a host.
// It has no instructions of the AMP unit, of 64- and 128-bit transfers to it, or of the exchange. Code that needs them does
// not compile here.
#pragma once
#include <cstdint>
#include <ipu_vector_math>

namespace standin {
/// The tile of the calling vertex: 0, unless the code that executes the vertex sets it.
inline thread_local unsigned tile_id = 0;
/// Grows by one at each read. It orders events on a thread; it does not measure time.
inline thread_local unsigned cycle_count = 0;
inline thread_local std::uint32_t random_state = 1;
} // namespace standin

template <class V>
inline V __builtin_ipu_exp(V v)
{
    return ipu::exp(v);
}
template <class V>
inline V __builtin_ipu_ln(V v)
{
    return ipu::log(v);
}
template <class V>
inline V __builtin_ipu_rsqrt(V v)
{
    return ipu::rsqrt(v);
}
template <class V>
inline V __builtin_ipu_max(V a, V b)
{
    return ipu::max(a, b);
}
template <class V>
inline V __builtin_ipu_min(V a, V b)
{
    return ipu::min(a, b);
}
inline half __builtin_ipu_f32tof16(float value)
{
    return half(value);
}
inline float __builtin_ipu_f16tof32(half value)
{
    return value;
}
inline unsigned __builtin_ipu_get_scount_l()
{
    return ++standin::cycle_count;
}
inline unsigned __builtin_ipu_get_tile_id()
{
    return standin::tile_id;
}
/// Uniform in [-0.5, 0.5), by xorshift32. The sequence is repeatable, but it is not that of an IPU.
inline float __builtin_ipu_urand_f32()
{
    std::uint32_t s = standin::random_state;
    s ^= s << 13;
    s ^= s >> 17;
    s ^= s << 5;
    standin::random_state = s;
    return static_cast<float>(s >> 8) * 0x1p-24f - 0.5f;
}
/// Writes to control registers have no effect here.
inline void __builtin_ipu_put(unsigned, unsigned) {}
inline void __builtin_ipu_uput(unsigned, unsigned) {}

#pragma once
/// Version, and every compiler switch of the library. Kernel code: valid as C++17 and C++20.
///
/// Macros: TILEMESH_VERSION, TILEMESH_KERNEL, TILEMESH_HOST, TILEMESH_EXPECT, TILEMESH_EXACT_BEGIN, TILEMESH_EXACT_END,
/// TILEMESH_INSTRUCTION_SETS. The target tilemesh::compiled defines TILEMESH_COMPILED. A program of headers alone may define
/// TILEMESH_ALL_PROGRAMS (all_programs.hpp). Codelet files also have TILEMESH_VERTEX and TILEMESH_MULTI_VERTEX (poplar/codelet.hpp).

#define TILEMESH_VERSION 200 // major * 10000 + minor * 100 + patch

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0) || defined(__ASSOCIATIVE_MATH__) ||  \
    defined(__RECIPROCAL_MATH__)
#    error "tilemesh: -ffast-math, or a part of it, breaks the promise of equal bits and of finite pictures; build without it"
#endif

#if defined(min) || defined(max)
#    error "tilemesh: min or max is a macro, as <windows.h> makes them; define NOMINMAX before it, or undefine both before the library's headers"
#endif

/// For views and rules that must be inlined into the tile loop (host) or the vertex (IPU). Do not use it for floating-point arithmetic: see
/// TILEMESH_EXACT_BEGIN.
#if defined(__GNUC__) || defined(__clang__)
#    define TILEMESH_KERNEL [[gnu::always_inline]] inline
#else
#    define TILEMESH_KERNEL inline
#endif

/// Marks host functions that the compiled library defines too. A program that links the library (CMake: tilemesh::compiled) only
/// declares these functions. In every other program, the definitions in PART/detail/*_code.hpp follow the declarations.
#if defined(TILEMESH_COMPILED)
#    define TILEMESH_HOST
#else
#    define TILEMESH_HOST inline
#endif

/// Between these two macros, `a * b + c` is rounded twice, for any default of the compiler (GCC fuses by default if the target can). A
/// fused operation occurs only where the code calls `multiply_add`. Clang's explicit `-ffp-contract=fast` overrides this rule. Functions
/// between the macros that do arithmetic must not be `always_inline`, because GCC gives an inlined body the options of the function into
/// which it is inlined. On some targets Clang cannot restore the earlier rule (it warns; an IPU's compiler may be one); there the rule
/// holds to the end of the file.
#if defined(__clang__) && (defined(__x86_64__) || defined(__i386__) || defined(__aarch64__))
#    define TILEMESH_EXACT_BEGIN _Pragma("float_control(push)") _Pragma("clang fp contract(off)")
#    define TILEMESH_EXACT_END _Pragma("float_control(pop)")
#elif defined(__clang__)
#    define TILEMESH_EXACT_BEGIN _Pragma("clang fp contract(off)")
#    define TILEMESH_EXACT_END
#elif defined(__GNUC__)
#    define TILEMESH_EXACT_BEGIN                                                                                               \
        _Pragma("GCC push_options") _Pragma("GCC optimize(\"fp-contract=off\")")
#    define TILEMESH_EXACT_END _Pragma("GCC pop_options")
#else
#    define TILEMESH_EXACT_BEGIN
#    define TILEMESH_EXACT_END
#endif

/// 1 if the hot functions are compiled for several instruction sets (splat/instruction_sets.hpp), otherwise 0. A user may define it as 0. It
/// is 0 for codelets, for processors other than x86-64, and if the compiler may use AVX, because then the user has chosen a processor.
#if !defined(__x86_64__) || defined(__AVX__) || defined(__POPC__) || defined(__IPU__)
#    undef TILEMESH_INSTRUCTION_SETS
#    define TILEMESH_INSTRUCTION_SETS 0
#elif !defined(TILEMESH_INSTRUCTION_SETS)
#    define TILEMESH_INSTRUCTION_SETS 1
#endif

/// Every name of the library is in `tilemesh::v0_2`: programs write `tilemesh::Mesh`, and two versions in one program do not collide.
/// Each header opens both namespaces, because Clang leaves v0_2 out of the symbols of a `namespace tilemesh::splat`, although that
/// extends `tilemesh::v0_2::splat` (CWG 2061). Outside are the vertices of poplar/control_vertices.hpp alone.
namespace tilemesh { inline namespace v0_2 {}}

/// Called when a kernel breaks a contract of the library. A program has one definition of this function. The definition of the
/// host engines (engine/contract.hpp) keeps the first text and counts the calls; after the barrier the engine reports both with tile and
/// superstep. The function returns, so the code after the call must be safe.
extern "C" void tilemesh_contract_broken(char const* text) noexcept;

namespace tilemesh { inline namespace v0_2 { namespace detail {
[[gnu::cold, gnu::noinline]] inline bool broken(char const* text) noexcept
{
    tilemesh_contract_broken(text);
    return false;
}
}}} // namespace tilemesh::detail

/// True if `condition` holds. Otherwise it reports `text` and is false, so the code that it guards does not run. On a host, NDEBUG
/// changes nothing. In a codelet with NDEBUG it only tests the condition, because a tile cannot report. popc, the compiler of codelets,
/// defines __POPC__; for an IPU it also defines __IPU__.
///
/// Cost: nothing while contracts hold, if the code tests the condition anyway. `unchecked_push`, `[]`, `truncate` and `swap_remove` test
/// nothing, so their conditions are no contracts. CheckedMesh notices some mistakes with them.
#if defined(NDEBUG) && (defined(__POPC__) || defined(__IPU__))
#    define TILEMESH_EXPECT(condition, text) (static_cast<bool>(condition))
#else
#    define TILEMESH_EXPECT(condition, text) ((condition) || ::tilemesh::detail::broken(text))
#endif

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 {
/// a * b + c. It is rounded once if the target has a fused operation, otherwise twice; so a build has one rule. Without hardware, the fused
/// form would cost a library call for every term.
inline float multiply_add(float a, float b, float c) noexcept
{
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
    return __builtin_fmaf(a, b, c);
#else
    return a * b + c;
#endif
}
}} // namespace tilemesh
TILEMESH_EXACT_END

#if defined(TILEMESH_COMPILED)
namespace tilemesh { inline namespace v0_2 { namespace detail {
/// A program and the compiled library that it links must agree on `multiply_add`, or pictures would mix two roundings. The library defines
/// one of these two symbols. A program that is built for another kind of processor (`-march`) does not link.
#    if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
extern char const the_compiled_library_fuses_multiply_add;
[[gnu::used]] constexpr char const* rounds_as_the_library = &the_compiled_library_fuses_multiply_add;
#    else
extern char const the_compiled_library_does_not_fuse_multiply_add;
[[gnu::used]] constexpr char const* rounds_as_the_library = &the_compiled_library_does_not_fuse_multiply_add;
#    endif
}}} // namespace tilemesh::detail
#endif

// Part of the stand-in for the Poplar SDK (never installed). Like popc and the loader, it finds the fields of a codelet and
// points them at tile memory. The fields are named by hand, in POPLAR_STANDIN_VERTEX.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <new>
#include <poplar/Vertex.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace standin {

enum class Access { input, output, inout, value };
enum class Kind { worker, multi, supervisor };

/// One contiguous piece of tile memory.
struct Edge {
    void* data;
    std::size_t elements;
};

/// One field of a vertex type.
struct Field {
    std::string name;
    Access access;    // value: setInitialValue fills the field, and nothing is connected to it
    unsigned rank;    // 0: one element, 1: a vector, 2: a list of vectors
    std::string type; // the type of an element: "unsigned", "float", "half", ...
    unsigned element_bytes, align;
    unsigned state_bytes;       // bytes in the vertex on an IPU, without inner vectors
    unsigned inner_state_bytes; // bytes for each inner vector
    /// Points the field at n edges (1 if rank < 2). Values are copied into the vertex (rank 0) or into memory that belongs to
    /// it. Throws std::invalid_argument if an edge does not fit: wrong number, misaligned, too long for its layout.
    void (*bind)(void* vertex, Edge const* edges, std::size_t n);
    std::size_t max_elements; // the most elements that the layout can count in one vector; 0: no limit
};

/// A vertex type. `make` returns an object as Poplar makes it: memory of the class's size, filled with zeros, without a constructor
/// call.
struct VertexType {
    std::string name;
    Kind kind;
    void* (*make)();
    void (*destroy)(void* vertex);
    bool (*compute)(void* vertex, unsigned worker); // worker is ignored unless kind is multi; a void compute() returns true
    std::vector<Field> fields;
};

/// All vertex types of this program, by name.
inline std::map<std::string, VertexType, std::less<>>& vertex_types()
{
    static std::map<std::string, VertexType, std::less<>> types;
    return types;
}

/// The type of that name, or nullptr if no linked source registers it. Safe from main() on.
inline VertexType const* find_vertex(std::string_view name)
{
    auto const& types = vertex_types();
    auto const found = types.find(name);
    return found == types.end() ? nullptr : &found->second;
}

/// The name of an element type; empty for a type that cannot be an element.
template <class T>
constexpr char const* element_name()
{
    if constexpr (std::is_same_v<T, bool>) return "bool";
    else if constexpr (std::is_same_v<T, char>) return "char";
    else if constexpr (std::is_same_v<T, signed char>) return "signed char";
    else if constexpr (std::is_same_v<T, unsigned char>) return "unsigned char";
    else if constexpr (std::is_same_v<T, short>) return "short";
    else if constexpr (std::is_same_v<T, unsigned short>) return "unsigned short";
    else if constexpr (std::is_same_v<T, int>) return "int";
    else if constexpr (std::is_same_v<T, unsigned>) return "unsigned";
    else if constexpr (std::is_same_v<T, long long>) return "long long";
    else if constexpr (std::is_same_v<T, unsigned long long>) return "unsigned long long";
    else if constexpr (std::is_same_v<T, half>) return "half";
    else if constexpr (std::is_same_v<T, float>) return "float";
    else if constexpr (std::is_same_v<T, quarter>) return "quarter";
    else return "";
}
template <class T>
constexpr bool is_element = element_name<T>()[0] != '\0';

/// Bytes of a vector in the vertex. SPAN is a pointer and a size. All others are one word: pointer and size in one word, a
/// pointer, or a pointer in 16 bits, which counts as a word.
constexpr unsigned layout_bytes(poplar::VectorLayout layout)
{
    return layout == poplar::VectorLayout::SPAN ? 8 : 4;
}

/// The alignment in bytes that a scaled pointer needs.
constexpr unsigned layout_align(poplar::VectorLayout layout)
{
    return layout == poplar::VectorLayout::SCALED_PTR32    ? 4
           : layout == poplar::VectorLayout::SCALED_PTR64  ? 8
           : layout == poplar::VectorLayout::SCALED_PTR128 ? 16
                                                           : 1;
}
constexpr std::size_t layout_max(poplar::VectorLayout layout)
{
    return layout == poplar::VectorLayout::SHORT_SPAN ? 2047 : 0;
}

/// The facts of a field type. The primary template is a plain member.
template <class T>
struct FieldTraits {
    static_assert(is_element<T>, "a field is a number, an edge, or a vector of these: no struct, array, pointer or long");
    using Element = T;
    static constexpr Access access = Access::value;
    static constexpr unsigned rank = 0, align = alignof(T), state_bytes = sizeof(T) < 4 ? 4 : sizeof(T),
                              inner_state_bytes = 0;
    static constexpr std::size_t max_elements = 0;
};
template <class T, Access A>
struct ScalarTraits {
    static_assert(is_element<T>, "an edge of one element is a number");
    using Element = T;
    static constexpr Access access = A;
    static constexpr unsigned rank = 0, align = alignof(T), state_bytes = 4, inner_state_bytes = 0;
    static constexpr std::size_t max_elements = 0;
};
template <class T>
struct FieldTraits<poplar::Input<T>> : ScalarTraits<T, Access::input> {};
template <class T>
struct FieldTraits<poplar::Output<T>> : ScalarTraits<T, Access::output> {};
template <class T>
struct FieldTraits<poplar::InOut<T>> : ScalarTraits<T, Access::inout> {};

template <class T, poplar::VectorLayout L, unsigned MinAlign, Access A>
struct VectorTraits {
    static_assert(is_element<T>, "a vector edge holds numbers");
    using Element = T;
    static constexpr Access access = A;
    static constexpr unsigned rank = 1, inner_state_bytes = 0, state_bytes = layout_bytes(L);
    static constexpr unsigned align = MinAlign > layout_align(L) ? MinAlign : layout_align(L);
    static constexpr std::size_t max_elements = layout_max(L);
};
template <class T, poplar::VectorLayout L, unsigned M, bool I>
struct FieldTraits<poplar::Input<poplar::Vector<T, L, M, I>>> : VectorTraits<T, L, M, Access::input> {};
template <class T, poplar::VectorLayout L, unsigned M, bool I>
struct FieldTraits<poplar::Output<poplar::Vector<T, L, M, I>>> : VectorTraits<T, L, M, Access::output> {};
template <class T, poplar::VectorLayout L, unsigned M, bool I>
struct FieldTraits<poplar::InOut<poplar::Vector<T, L, M, I>>> : VectorTraits<T, L, M, Access::inout> {};

/// A list of vectors, each of which is one edge. A vector whose elements are numbers is a table of values.
template <class T, poplar::VectorLayout L>
struct ListTraits : FieldTraits<T> {
    static_assert(FieldTraits<T>::rank == 1, "a list holds vectors, and no list goes deeper");
    static constexpr unsigned rank = 2, state_bytes = layout_bytes(L), inner_state_bytes = FieldTraits<T>::state_bytes;
};
template <class T, poplar::VectorLayout L, unsigned M, bool I>
struct FieldTraits<poplar::Vector<T, L, M, I>>
    : std::conditional_t<is_element<T>, VectorTraits<T, L, M, Access::value>, ListTraits<T, L>> {};

/// A base and a count, and one word for each vector, which holds its offset and its size.
template <class T, unsigned MinAlign, Access A>
struct VectorListTraits {
    static_assert(is_element<T>, "a list of vectors holds numbers");
    using Element = T;
    static constexpr Access access = A;
    static constexpr unsigned rank = 2, align = MinAlign, state_bytes = 8, inner_state_bytes = 4;
    static constexpr std::size_t max_elements = 0;
};
template <class T, poplar::VectorListLayout L, unsigned M, bool I>
struct FieldTraits<poplar::VectorList<T, L, M, I>> : VectorListTraits<T, M, Access::value> {};
template <class T, poplar::VectorListLayout L, unsigned M, bool I>
struct FieldTraits<poplar::Input<poplar::VectorList<T, L, M, I>>> : VectorListTraits<T, M, Access::input> {};
template <class T, poplar::VectorListLayout L, unsigned M, bool I>
struct FieldTraits<poplar::Output<poplar::VectorList<T, L, M, I>>> : VectorListTraits<T, M, Access::output> {};
template <class T, poplar::VectorListLayout L, unsigned M, bool I>
struct FieldTraits<poplar::InOut<poplar::VectorList<T, L, M, I>>> : VectorListTraits<T, M, Access::inout> {};

/// Memory of one field outside the class: handles of inner vectors, and values that the field keeps.
struct FieldMemory {
    std::vector<std::byte> handles;
    std::vector<std::vector<std::byte>> values;
};

struct Binding {
    /// Checks whether the field can hold the edges.
    template <class Traits>
    static void check(Edge const* edges, std::size_t n)
    {
        if (Traits::rank < 2 && n != 1)
            throw std::invalid_argument("a field that is not a list takes one edge, not " + std::to_string(n));
        for (Edge const* edge = edges; edge != edges + n; ++edge) {
            if (Traits::rank == 0 && edge->elements != 1) {
                throw std::invalid_argument("a field of one element got " + std::to_string(edge->elements));
            }
            if (Traits::max_elements != 0 && edge->elements > Traits::max_elements) {
                throw std::invalid_argument("a vector of " + std::to_string(edge->elements) +
                                            " elements, but its layout counts up to " +
                                            std::to_string(Traits::max_elements));
            }
            if (Traits::access != Access::value && edge->elements != 0 &&
                reinterpret_cast<std::uintptr_t>(edge->data) % Traits::align != 0) {
                throw std::invalid_argument("an edge that is not aligned to " + std::to_string(Traits::align) + " bytes");
            }
        }
    }

    /// Points a field of any kind at its edges. check() must have accepted them.
    template <class T>
    static void bind(T& field, FieldMemory& memory, Edge const* edges, std::size_t n)
    {
        using Plain = std::remove_const_t<T>;
        using Traits = FieldTraits<Plain>;
        using Element = typename Traits::Element;
        Plain& plain = const_cast<Plain&>(field); // a member may be const for the codelet, but its memory is not
        if constexpr (is_element<Plain>) {
            std::memcpy(&plain, edges->data, sizeof plain);
        } else if constexpr (Traits::rank == 0) {
            plain.data_ = static_cast<Element*>(edges->data);
        } else if constexpr (Traits::access == Access::value) {
            set(plain, memory, on_copies(memory, edges, n, sizeof(Element)).data(), n);
        } else {
            set(plain, memory, edges, n);
        }
    }

private:
    template <class T, poplar::VectorLayout L, unsigned M, bool I>
    static void set(poplar::Vector<T, L, M, I>& vector, FieldMemory& memory, Edge const* edges, std::size_t n)
    {
        if constexpr (is_element<std::remove_const_t<T>>) {
            vector.data_ = static_cast<T*>(edges->data);
            vector.size_ = static_cast<unsigned>(edges->elements);
        } else {
            vector.data_ = handles<T>(memory, edges, n);
            vector.size_ = static_cast<unsigned>(n);
        }
    }
    template <class T, poplar::VectorListLayout L, unsigned M, bool I>
    static void set(poplar::VectorList<T, L, M, I>& list, FieldMemory& memory, Edge const* edges, std::size_t n)
    {
        list.vectors_ = handles<typename poplar::VectorList<T, L, M, I>::value_type>(memory, edges, n);
        list.size_ = static_cast<unsigned>(n);
    }
    template <class Handle>
    static Handle* handles(FieldMemory& memory, Edge const* edges, std::size_t n)
    {
        memory.handles.assign(n * sizeof(Handle), std::byte{});
        auto* const first = reinterpret_cast<Handle*>(memory.handles.data());
        for (std::size_t i = 0; i < n; ++i) set(first[i], memory, edges + i, 1);
        return first;
    }

    /// Edges on copies of the values.
    static std::vector<Edge> on_copies(FieldMemory& memory, Edge const* edges, std::size_t n, std::size_t element_bytes)
    {
        memory.values.resize(n);
        std::vector<Edge> copies;
        for (std::size_t i = 0; i < n; ++i) {
            auto const* const bytes = static_cast<std::byte const*>(edges[i].data);
            memory.values[i].assign(bytes, bytes + edges[i].elements * element_bytes);
            copies.push_back({memory.values[i].data(), edges[i].elements});
        }
        return copies;
    }
};

template <class Class, std::size_t Fields>
struct MadeVertex {
    alignas(Class) std::byte bytes[sizeof(Class)];
    std::array<FieldMemory, Fields> memory;
};

template <class T>
struct MemberType;
template <class Class, class T>
struct MemberType<T Class::*> {
    using Type = T;
};

/// The members of a derived class begin where the last member of the base class ends, even inside the base's padding.
template <class Class, std::size_t Bytes>
struct Extended : Class {
    char more[Bytes];
};

/// Do fields in this order, with the padding of C++, fill the class? A missing field shows as a difference in size, unless
/// the field would lie in the padding between two others.
template <class Class, class... Types>
constexpr bool fields_fill()
{
    constexpr std::size_t bytes = [] {
        std::size_t sum = 0;
        ((sum = (sum + alignof(Types) - 1) / alignof(Types) * alignof(Types) + sizeof(Types)), ...);
        return sum;
    }();
    constexpr std::size_t rounded = (bytes + alignof(Class) - 1) / alignof(Class) * alignof(Class);
    if constexpr (bytes == 0) return sizeof(Class) == 1;
    else if constexpr (rounded != sizeof(Class)) return false;
    else if constexpr (rounded == bytes) return true;
    else return sizeof(Extended<Class, rounded - bytes>) == sizeof(Class);
}

/// Enters a class and its fields into vertex_types(). An explicit instantiation may name private members, which Poplar sees too.
template <class Class, class Tag, auto... Members>
struct Registration {
    using Made = MadeVertex<Class, sizeof...(Members)>;
    static_assert(std::is_trivially_copy_constructible_v<Class> && std::is_trivially_destructible_v<Class>,
                  "a vertex is plain memory: nothing of it is constructed or destroyed");
    static_assert(std::is_standard_layout_v<Made>, "the class is found at the address of what was made");
    static_assert(fields_fill<Class, typename MemberType<decltype(Members)>::Type...>(),
                  "POPLAR_STANDIN_VERTEX names all fields, in the order of their declaration");

    static Class& vertex(void* made) { return *std::launder(reinterpret_cast<Class*>(made)); }
    static void* make() { return (new Made{})->bytes; }
    static void destroy(void* made) { delete reinterpret_cast<Made*>(made); }
    static bool compute(void* made, unsigned worker)
    {
        Class& self = vertex(made);
        if constexpr (std::is_base_of_v<poplar::MultiVertex, Class>) {
            if constexpr (std::is_void_v<decltype(self.compute(worker))>) return self.compute(worker), true;
            else return self.compute(worker);
        } else {
            static_cast<void>(worker);
            if constexpr (std::is_void_v<decltype(self.compute())>) return self.compute(), true;
            else return self.compute();
        }
    }
    template <auto Member, std::size_t Index>
    static void bind(void* made, Edge const* edges, std::size_t n)
    {
        Binding::check<FieldTraits<std::remove_cv_t<typename MemberType<decltype(Member)>::Type>>>(edges, n);
        Binding::bind(vertex(made).*Member, reinterpret_cast<Made*>(made)->memory[Index], edges, n);
    }
    template <auto Member, std::size_t Index>
    static Field field(std::string name)
    {
        using Traits = FieldTraits<std::remove_cv_t<typename MemberType<decltype(Member)>::Type>>;
        using Element = std::remove_const_t<typename Traits::Element>;
        return {std::move(name),           Traits::access,      Traits::rank,        element_name<Element>(),
                unsigned{sizeof(Element)}, Traits::align,       Traits::state_bytes, Traits::inner_state_bytes,
                &bind<Member, Index>,      Traits::max_elements};
    }
    static bool enter()
    {
        std::array<std::string, sizeof...(Members) + 1> names;
        std::size_t n = 0;
        for (char c : std::string_view(Tag::fields())) {
            if (c == ',') ++n;
            else if (c != ' ') names[n] += c;
        }
        VertexType type{Tag::name(), kind(), &make, &destroy, &compute, {}};
        add(type, names, std::make_index_sequence<sizeof...(Members)>());
        if (!vertex_types().emplace(type.name, type).second) throw std::logic_error("two vertex types named " + type.name);
        return true;
    }
    static bool const entered;

private:
    static constexpr Kind kind()
    {
        return std::is_base_of_v<poplar::MultiVertex, Class>        ? Kind::multi
               : std::is_base_of_v<poplar::SupervisorVertex, Class> ? Kind::supervisor
                                                                    : Kind::worker;
    }
    template <class Names, std::size_t... Indices>
    static void add(VertexType& type, Names const& names, std::index_sequence<Indices...>)
    {
        static_cast<void>(names);
        (type.fields.push_back(field<Members, Indices>(names[Indices])), ...);
    }
};
template <class Class, class Tag, auto... Members>
bool const Registration<Class, Tag, Members...>::entered = enter();

} // namespace standin

/// Registers a vertex class under its own name. Use it in the global namespace, after the class:
/// POPLAR_STANDIN_VERTEX(Class, field, ...).
#define POPLAR_STANDIN_VERTEX(class_, ...) POPLAR_STANDIN_VERTEX_NAMED(#class_, class_, __VA_ARGS__)
/// POPLAR_STANDIN_VERTEX under another name, for an instance of a template. The class must be written without commas, by an
/// alias if necessary.
#define POPLAR_STANDIN_VERTEX_NAMED(name_, class_, ...) POPLAR_STANDIN_ENTER(__COUNTER__, name_, class_, __VA_ARGS__)

#define POPLAR_STANDIN_ENTER(n, name_, class_, ...) POPLAR_STANDIN_ENTER_TAG(n, name_, class_, __VA_ARGS__)
#define POPLAR_STANDIN_ENTER_TAG(n, name_, class_, ...)                                                                    \
    namespace {                                                                                                            \
    struct StandinVertexTag##n {                                                                                           \
        static char const* name() { return name_; }                                                                        \
        static char const* fields() { return #__VA_ARGS__; }                                                               \
    };                                                                                                                     \
    }                                                                                                                      \
    template struct standin::Registration<class_, StandinVertexTag##n POPLAR_STANDIN_EACH(class_, __VA_ARGS__)>

// `, &Class::field` for each field. Each pass expands the macro once, and 4 * 4 * 4 passes are enough for 64 fields.
#define POPLAR_STANDIN_PARENS ()
#define POPLAR_STANDIN_PASS(...)                                                                                           \
    POPLAR_STANDIN_PASS2(POPLAR_STANDIN_PASS2(POPLAR_STANDIN_PASS2(POPLAR_STANDIN_PASS2(__VA_ARGS__))))
#define POPLAR_STANDIN_PASS2(...)                                                                                          \
    POPLAR_STANDIN_PASS1(POPLAR_STANDIN_PASS1(POPLAR_STANDIN_PASS1(POPLAR_STANDIN_PASS1(__VA_ARGS__))))
#define POPLAR_STANDIN_PASS1(...)                                                                                          \
    POPLAR_STANDIN_PASS0(POPLAR_STANDIN_PASS0(POPLAR_STANDIN_PASS0(POPLAR_STANDIN_PASS0(__VA_ARGS__))))
#define POPLAR_STANDIN_PASS0(...) __VA_ARGS__
#define POPLAR_STANDIN_EACH(class_, ...) __VA_OPT__(POPLAR_STANDIN_PASS(POPLAR_STANDIN_NEXT(class_, __VA_ARGS__)))
#define POPLAR_STANDIN_NEXT(class_, field_, ...)                                                                           \
    , &class_::field_ __VA_OPT__(POPLAR_STANDIN_AGAIN POPLAR_STANDIN_PARENS(class_, __VA_ARGS__))
#define POPLAR_STANDIN_AGAIN() POPLAR_STANDIN_NEXT

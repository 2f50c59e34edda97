#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tilemesh/render/renderer_fields.hpp>
#include <tilemesh/render/setup_fields.hpp>
#include <type_traits>
#include <utility>
#include <vector>

/// Tables of options: a row says all that an option is. Command lines, their --help and their errors, the settings of C and Python and the
/// keys of studies come from such rows.
namespace shared {

using tilemesh::render::any_number, tilemesh::render::nearest, tilemesh::render::Word;

/// What an option takes: nothing, a whole number (or one of its words), a number, one of its words, WxH, three numbers, a text, the path of
/// a file that is read, another path.
enum class Form : unsigned char { flag, whole, number, word, size, three, text, input, path };

/// The value of an option. Which members count depends on the form.
struct OptionValue {
    std::string_view text;         ///< as the user wrote it
    std::uint64_t whole = 0;       ///< of whole, word and flag (1)
    double number = 0;
    std::array<double, 3> three{}; ///< of size, too
};

/// Thrown for a value that an option cannot have: "it takes a whole number from 1 to 64".
struct Misfit {
    std::string why;
};

/// A row: name, what --help calls the value, meaning, limits, words. "{}" in the meaning stands for the words or the limits.
struct OptionRow {
    std::string_view name;      ///< without "--"
    std::string_view value;     ///< "N"; empty for a flag
    std::string_view meaning;   ///< one line; ends with the default in []
    Form form = Form::flag;
    double least = 0, most = 0; ///< of numbers; `most` is `any_number` where no bound is worth a word
    std::span<Word const> words{};
    std::string_view unit{};    ///< of the number
    std::string_view example{}; ///< a value for errors; empty: the least one
    std::string_view why{};     ///< what an error says that the option takes; empty: form, limits and words say it
    std::string_view standard{}; ///< the default, which --help shows in []; empty: the meaning ends with it
    bool repeats = false;        ///< it may be given several times; each value counts

    /// "it takes a whole number from 1 to 64"
    std::string takes() const;
    tilemesh::render::Values values() const;
    /// The meaning with its words or limits.
    std::string help() const;
    /// Throws `Misfit` for a text that is no such value.
    OptionValue read(std::string_view text) const;
};

/// A row of the options that are members of `Of`.
template <class Of>
struct Option : OptionRow {
    using Owner = Of;
    void (*set)(Of&, OptionValue const&) = nullptr;
    OptionValue (*get)(Of const&) = nullptr; ///< null for a row with a reader of its own
};

namespace detail {

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <class T>
concept Sides = requires(T t)
{
    t.width, t.height;
};
template <class T>
concept Three = requires(T t) { requires std::tuple_size<T>::value == 3; };

template <class T>
constexpr Form form_of(bool has_words)
{
    if constexpr (is_optional<T> || is_list<T>) return form_of<typename T::value_type>(has_words);
    else if (has_words) return std::is_integral_v<T> && !std::is_same_v<T, bool> ? Form::whole : Form::word;
    else if constexpr (std::is_same_v<T, bool>) return Form::flag;
    else if constexpr (std::is_integral_v<T>) return Form::whole;
    else if constexpr (std::is_floating_point_v<T>) return Form::number;
    else if constexpr (Sides<T>) return Form::size;
    else if constexpr (Three<T>) return Form::three;
    else if constexpr (std::is_same_v<T, std::string>) return Form::text;
    else return Form::path;
}

template <class T>
void assign(T& to, OptionValue const& v)
{
    if constexpr (is_optional<T>) assign(to.emplace(), v);
    else if constexpr (is_list<T>) assign(to.emplace_back(), v);
    else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) to = static_cast<T>(v.whole);
    else if constexpr (std::is_floating_point_v<T>) to = static_cast<T>(v.number);
    else if constexpr (Sides<T>) to = T{static_cast<std::uint32_t>(v.three[0]), static_cast<std::uint32_t>(v.three[1])};
    else if constexpr (Three<T>)
        for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<typename T::value_type>(v.three[i]);
    else to = v.text;
}

template <class T>
OptionValue value_of(T const& of)
{
    OptionValue v;
    if constexpr (is_optional<T>) return of ? value_of(*of) : v;
    else if constexpr (is_list<T>) return of.empty() ? v : value_of(of.back());
    else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) v.whole = static_cast<std::uint64_t>(of);
    else if constexpr (std::is_floating_point_v<T>) v.number = static_cast<double>(of);
    else if constexpr (Sides<T>) v.three = {static_cast<double>(of.width), static_cast<double>(of.height), 0};
    else if constexpr (Three<T>)
        for (std::size_t i = 0; i < 3; ++i) v.three[i] = static_cast<double>(of[i]);
    else if constexpr (std::is_same_v<T, std::string>) v.text = of;
    else v.text = of.native();
    return v;
}

/// The owner of the first member of a path, the type of the last one, and the way there.
template <auto First, auto... Rest>
struct Path;
template <class Of, class T, T Of::*Member>
struct Path<Member> {
    using Owner = Of;
    using Type = T;
    static auto& in(auto& of) { return of.*Member; }
};
template <class Of, class T, T Of::*Member, auto Next, auto... Rest>
struct Path<Member, Next, Rest...> {
    using Owner = Of;
    using Type = typename Path<Next, Rest...>::Type;
    static auto& in(auto& of) { return Path<Next, Rest...>::in(of.*Member); }
};

} // namespace detail

struct Limits {
    double least = 0, most = 0;
    std::string_view unit{};
};

/// The row of a member, or of a member of a member. Its type gives the form.
template <auto... Members, class P = detail::Path<Members...>>
constexpr Option<typename P::Owner> option(std::string_view name, std::string_view value, std::string_view meaning, Limits limits = {},
                                           std::span<Word const> words = {}, std::string_view example = {}, std::string_view why = {})
{
    auto const form = detail::form_of<typename P::Type>(!words.empty());
    return {{name, value, meaning, form, limits.least, limits.most, words, limits.unit, example, why, {}, detail::is_list<typename P::Type>},
            [](typename P::Owner& o, OptionValue const& v) { detail::assign(P::in(o), v); },
            [](typename P::Owner const& o) { return detail::value_of(P::in(o)); }};
}
/// The row of a field of setups (render/setup_fields.hpp): its name, values and meaning, with another member that it sets.
template <std::size_t Field, auto... Members, class P = detail::Path<Members...>>
constexpr Option<typename P::Owner> field(std::string_view value, std::string_view standard, std::string_view meaning = {}, std::size_t first_word = 0)
{
    auto const& of = tilemesh::render::setup_fields[Field];
    auto row = option<Members...>(of.name, value, meaning.empty() ? of.meaning : meaning, {of.values.least, of.values.most, of.values.unit},
                                  of.values.words.subspan(std::min(first_word, of.values.words.size())));
    if (!of.values.words.empty()) row.form = Form::word;
    row.standard = standard;
    return row;
}
/// The row of a field whose value, if one is given, goes into a list of values.
template <std::size_t Field, auto... Members, class P = detail::Path<Members...>>
constexpr Option<typename P::Owner> listed(std::string_view standard)
{
    using tilemesh::render::Values;
    constexpr auto const& of = tilemesh::render::setup_fields[Field];
    constexpr auto form = of.values.kind == Values::word ? Form::word : of.values.kind == Values::whole ? Form::whole : Form::number;
    Option<typename P::Owner> row{{of.name, form == Form::word ? "NAME" : "N", of.meaning, form, of.values.least, of.values.most, of.values.words, of.values.unit},
                                  [](typename P::Owner& o, OptionValue const& v) { P::in(o).emplace_back(of.name, v.text); }};
    row.standard = standard;
    return row;
}
/// The rows of the fields that every program has: `row(std::integral_constant<std::size_t, Field>())` makes one.
constexpr auto rows_of_everyone(auto const& row)
{
    using tilemesh::render::setup_fields, tilemesh::render::SetupField;
    constexpr auto count = std::count_if(std::begin(setup_fields), std::end(setup_fields), [](auto const& f) { return f.use == SetupField::everyone; });
    constexpr auto fields = [] {
        std::array<std::size_t, std::size_t{count}> numbers{};
        for (std::size_t i = 0, n = 0; i < std::size(setup_fields); ++i)
            if (setup_fields[i].use == SetupField::everyone) numbers[n++] = i;
        return numbers;
    }();
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return std::array{row(std::integral_constant<std::size_t, fields[I]>())...};
    }(std::make_index_sequence<std::size_t{count}>());
}
namespace detail {
/// "N|quiet": what --help calls the value of a field of RendererOptions.
template <std::size_t Field>
constexpr auto value_name = [] {
    constexpr auto word = tilemesh::render::renderer_fields[Field].values.words[0].word;
    std::array<char, word.size() + 2> name{'N', '|'};
    std::copy(word.begin(), word.end(), name.begin() + 2);
    return name;
}();
template <std::size_t Field, auto... Members, class P = Path<Members...>>
constexpr Option<typename P::Owner> renderer_row()
{
    using tilemesh::render::renderer_fields;
    constexpr auto const& of = renderer_fields[Field];
    constexpr bool is_word = of.values.kind == tilemesh::render::Values::word;
    Option<typename P::Owner> row{{of.name, is_word ? "NAME" : std::string_view(value_name<Field>.data(), value_name<Field>.size()), of.meaning,
                                   is_word ? Form::word : Form::whole, of.values.least, of.values.most, of.values.words, of.values.unit},
                                  [](typename P::Owner& o, OptionValue const& v) { renderer_fields[Field].set(P::in(o), static_cast<double>(v.whole)); },
                                  [](typename P::Owner const& o) {
                                      return OptionValue{.text = {}, .whole = static_cast<std::uint64_t>(renderer_fields[Field].get(P::in(o)))};
                                  }};
    for (auto const& [word, number] : of.values.words)
        if (row.standard.empty() && static_cast<double>(number) == of.get({})) row.standard = word;
    return row;
}
} // namespace detail
/// The rows of the fields of RendererOptions (render/renderer_fields.hpp), which the members lead to.
template <auto... Members>
constexpr auto rows_of_renderer()
{
    return []<std::size_t... I>(std::index_sequence<I...>)
    {
        return std::array{detail::renderer_row<I, Members...>()...};
    }
    (std::make_index_sequence<std::size(tilemesh::render::renderer_fields)>());
}
/// The names as words.
template <std::size_t N>
constexpr auto words_of(char const* const (&names)[N])
{
    return [&]<std::size_t... I>(std::index_sequence<I...>)
    {
        return std::array{Word(names[I], I)...};
    }
    (std::make_index_sequence<N>());
}
/// A row whose words are the only values.
template <auto... Members>
constexpr auto words(std::string_view name, std::string_view value, std::string_view meaning, std::span<Word const> all)
{
    auto row = option<Members...>(name, value, meaning, {}, all);
    row.form = Form::word;
    return row;
}
/// A file or a folder that the program reads.
template <auto... Members>
constexpr auto input(std::string_view name, std::string_view value, std::string_view meaning)
{
    auto row = option<Members...>(name, value, meaning);
    row.form = Form::input;
    return row;
}

/// Two options of which the first needs the second, or excludes it, and why.
struct Pairing {
    enum Kind : unsigned char { needs, excludes } kind;
    std::string_view option, other, why;
};

/// The options of a program: groups of rows over the parts of its Options.
class OptionTable {
public:
    /// `usage` is the help's beginning. `repeats`: of an option that is given twice, the last one counts; otherwise it is refused.
    OptionTable(std::string program, std::string usage, bool repeats = false) : program_(std::move(program)), usage_(std::move(usage)), repeats_(repeats) {}

    /// Adds a group of rows with its title. `of` must outlive the table.
    template <class Rows, class Of = typename std::remove_cvref_t<decltype(*std::begin(std::declval<Rows const&>()))>::Owner>
    void add(std::string_view title, std::type_identity_t<Of>& of, Rows const& rows, std::span<Pairing const> pairings = {})
    {
        for (auto const& row : rows) entries_.push_back({row, title, {}, [&of, set = row.set](OptionValue const& value) { set(of, value); }});
        pairings_.insert(pairings_.end(), pairings.begin(), pairings.end());
    }
    /// The program does not take an option of its groups, and why: "no slope of it is known".
    void without(std::string_view name, std::string_view why) { entry(name).without = why; }
    /// The meaning, with the default, that an option of a group has in this program.
    void says(std::string_view name, std::string_view meaning) { entry(name).row.meaning = meaning; }
    /// Words without an option: `what` is "a map". More than `most` are refused.
    void takes_words(std::string_view what, std::size_t most, std::function<void(std::string_view)> take)
    {
        what_ = what, most_words_ = most, take_ = std::move(take);
    }
    void pair(std::initializer_list<Pairing> all) { pairings_.insert(pairings_.end(), all.begin(), all.end()); }
    /// The text of --help behind the options.
    void ends_with(std::string text) { end_ = std::move(text); }

    /// Reads the words of a command line, and sets what they say. False after --help or --version, which it does not print; then the words
    /// behind it are not read. After "--" no word is an option. Throws `tilemesh::Error`, one line, for an unknown option (with the
    /// nearest one), a repeated one, one that the program does not take, a value that does not fit, and options that do not fit together.
    bool read(std::span<char const* const> words);
    /// Throws `tilemesh::Error` unless the options that were given fit this pairing.
    void require(Pairing const& pairing) const;
    bool is_given(std::string_view name) const;
    std::string help() const;

    /// The options that were given, in this order, with their values; and all paths of files that are read.
    struct Given {
        OptionRow const* row;
        std::string text;
    };
    std::vector<Given> const& given() const noexcept { return given_; }
    std::vector<std::string> const& inputs() const noexcept { return inputs_; }

private:
    struct Entry {
        OptionRow row;
        std::string_view title, without;
        std::function<void(OptionValue const&)> set;
    };
    Entry& entry(std::string_view name);
    void take_word(std::string_view word);
    [[noreturn]] void refuse_unknown(std::string_view name) const;

    std::string program_, usage_, end_, what_;
    bool repeats_;
    std::size_t most_words_ = 0;
    std::function<void(std::string_view)> take_;
    std::vector<Entry> entries_;
    std::vector<Pairing> pairings_;
    std::vector<Given> given_;
    std::vector<std::string> inputs_;
    std::size_t words_ = 0;
};

} // namespace shared

module;
#include <tl/expected.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
/// Outcomes and errors; options of commands; words of enumerations.
export module camber.core:outcome;

/// Texts of the input in messages, which stay short whatever the input is.
export namespace camber {

/// Bytes of a text of the input that a message has place for.
constexpr std::size_t longest_quote = 80;

/// A text of at most `longest` bytes: of a longer one the beginning and the end, with "…" between. Letters of UTF-8 are
/// whole.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t longest = longest_quote);

/// A text of the input between quotation marks, shortened, with "?" for control characters.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// What went wrong, coarsely: the shell maps it to an exit code.
enum class ErrorKind {
    usage,        ///< a wrong option or config: exit code 2
    input,        ///< a bad input file or mesh: 3
    unsupported,  ///< well-formed, but not something that Camber can hold: 3
    write,        ///< an output could not be written: 3
    stopped,      ///< the caller asked to stop: 130
    memory,       ///< not enough memory: 4
    internal,     ///< a broken promise of Camber itself: 4
};

/// A mesh entity as its file numbers it (from 1): `tetrahedron 1234`.
struct Entity {
    std::string kind;
    std::uint64_t number = 0;
};

/// Why a stage gave no value. `what` is one sentence without a full stop; `where` is a file with its
/// place (line or byte) or a JSON path; `remedy` says what the user can do. Printed by `describe`.
/// Its constructors are not inline: each function that returns an Outcome contains several.
struct Error {
    ErrorKind kind = ErrorKind::internal;
    std::string what;
    std::string where;
    std::optional<Entity> entity;
    std::string remedy;

    Error();
    Error(ErrorKind kind, std::string what, std::string where = {}, std::optional<Entity> entity = {},
          std::string remedy = {});
    Error(const Error&);
    Error(Error&&) noexcept;
    Error& operator=(const Error&);
    Error& operator=(Error&&) noexcept;
    ~Error();
};

/// A value, or why there is none.
template <class T>
using Outcome = tl::expected<T, Error>;

/// The value of a successful stage that returns nothing else.
struct Done {};

/// An outcome without a value.
[[nodiscard]] tl::unexpected<Error> fail(Error error);

/// The same from the parts of an Error.
[[nodiscard]] tl::unexpected<Error> fail(ErrorKind kind, std::string what, std::string where = {},
                                         std::optional<Entity> entity = {}, std::string remedy = {});

/// One line: `where: entity: what (remedy)`. Each part is at most 4096 bytes long, as paths are.
[[nodiscard]] std::string describe(const Error& e);

// How a struct of options describes its members, once for all who read, check, write or explain them: a static
// function `options()` that returns a tuple of `Option`. A default is the member's own initialiser.

/// What an option may hold beyond its type; of an array: its items and their number.
struct Limits {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    bool low_open = false, high_open = false;
    std::size_t min_count = 0, max_count = std::numeric_limits<std::size_t>::max();

    [[nodiscard]] constexpr bool hold(double x) const {
        return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high);
    }
    /// "at least 0 and below 1"; empty without limits.
    [[nodiscard]] std::string text() const;
    /// "[0, 1)", "(0, inf)".
    [[nodiscard]] std::string interval() const;
};

/// A member of S (or of a base of it) as an option: its name in a config, a sentence without a full stop, the unit in
/// words (empty: none), and its limits. Texts live as long as the program.
template <class S, class T>
struct Option {
    using Value = T;

    std::string_view name;
    T S::* member = nullptr;
    std::string_view sentence, unit_name = {};
    Limits limits = {};
    bool is_required = false;

    [[nodiscard]] constexpr Option unit(std::string_view text) const {
        Option o = *this;
        o.unit_name = text;
        return o;
    }
    [[nodiscard]] constexpr Option at_least(double x) const { return low(x, false); }
    [[nodiscard]] constexpr Option above(double x) const { return low(x, true); }
    [[nodiscard]] constexpr Option at_most(double x) const { return high(x, false); }
    [[nodiscard]] constexpr Option below(double x) const { return high(x, true); }
    [[nodiscard]] constexpr Option count(std::size_t least, std::size_t most) const {
        Option o = *this;
        o.limits.min_count = least;
        o.limits.max_count = most;
        return o;
    }
    /// It has no default that could be meant.
    [[nodiscard]] constexpr Option required() const {
        Option o = *this;
        o.is_required = true;
        return o;
    }
    /// The same option as a member of another struct that hands it on.
    template <class R>
    [[nodiscard]] constexpr Option<R, T> as(T R::* other) const {
        return {name, other, sentence, unit_name, limits, is_required};
    }

  private:
    [[nodiscard]] constexpr Option low(double x, bool open) const {
        Option o = *this;
        o.limits.low = x;
        o.limits.low_open = open;
        return o;
    }
    [[nodiscard]] constexpr Option high(double x, bool open) const {
        Option o = *this;
        o.limits.high = x;
        o.limits.high_open = open;
        return o;
    }
};

template <class S, class T>
[[nodiscard]] constexpr Option<S, T> option(std::string_view name, T S::* member, std::string_view sentence) {
    return {.name = name, .member = member, .sentence = sentence};
}

/// A struct that describes its options.
template <class S>
concept HasOptions = requires { std::tuple_size<decltype(S::options())>::value; };

/// f(option) for each option of S, in the order in which S lists them.
template <HasOptions S, class F>
constexpr void each_option(F&& f) {
    constexpr auto options = S::options();
    std::apply([&](const auto&... o) { (f(o), ...); }, options);
}

/// What S says of a member. That the member is no option does not compile.
template <HasOptions S, class T>
[[nodiscard]] consteval Option<S, T> option_of(T S::* member) {
    Option<S, T> found;
    each_option<S>([&](const auto& o) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(o)>, Option<S, T>>)
            if (o.member == member) found = o;
    });
    if (found.member == nullptr) throw "this member is not among the struct's options()";
    return found;
}

/// "must be at least 0 and below 1, got 2".
[[nodiscard]] std::string out_of_limits(const Limits& limits, std::string_view got);

/// Whether a number is finite and within the limits of its option. Errors (usage): it is not; by the option's name.
[[nodiscard]] Outcome<Done> check_limits(std::string_view name, double value, const Limits& limits);

/// The same of all numbers among the options of a struct; the first that is not is told.
template <HasOptions S>
[[nodiscard]] Outcome<Done> check_limits(const S& options) {
    Outcome<Done> result = Done{};
    each_option<S>([&](const auto& o) {
        using T = typename std::remove_cvref_t<decltype(o)>::Value;
        if constexpr (std::is_convertible_v<T, double>)
            if (result) result = check_limits(o.name, static_cast<double>(options.*o.member), o.limits);
    });
    return result;
}

// Words of enumerations, bound to their enumerators by name. Beside an enumeration E stands
//     constexpr auto words(E) { return words_of(Word{E::a, "a"}, Word{E::b, "b"}); }

/// One enumerator and its word.
template <class E>
struct Word {
    E value;
    std::string_view word;
};
template <class E>
Word(E, std::string_view) -> Word<E>;

/// Whether a value of an enumeration has a name there. clang and gcc print one that has not as a cast: (E)7.
template <auto Value>
[[nodiscard]] consteval bool is_enumerator() {
    const std::string_view text = __PRETTY_FUNCTION__;  // … [Value = space::E::name]
    const char first = text[text.find_last_of(" :)") + 1];
    return first != '-' && (first < '0' || first > '9');
}

/// How many names an enumeration of one byte has.
template <class E>
    requires(sizeof(E) == 1)
[[nodiscard]] consteval std::size_t enumerator_count() {
    return []<std::size_t... I>(std::index_sequence<I...>) {
        return (std::size_t{0} + ... + (is_enumerator<static_cast<E>(I)>() ? 1 : 0));
    }(std::make_index_sequence<256>{});
}

/// The words of an enumeration, in this order wherever they are listed. An enumerator without a word, with two, or a
/// word of two enumerators does not compile.
template <class E, std::same_as<Word<E>>... Others>
[[nodiscard]] consteval std::array<Word<E>, 1 + sizeof...(Others)> words_of(Word<E> first, Others... others) {
    const std::array all{first, others...};
    if (all.size() != enumerator_count<E>()) throw "not one word for each enumerator";
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (all[i].value == all[j].value || all[i].word == all[j].word) throw "a word or an enumerator twice";
    return all;
}

/// An enumeration with words.
template <class E>
concept HasWords = std::is_enum_v<E> && requires(E e) { words(e); };

/// The word of a value.
template <HasWords E>
[[nodiscard]] constexpr std::string_view word_of(E value) {
    for (const auto& w : words(E{}))
        if (w.value == value) return w.word;
    return {};
}

/// All words.
template <HasWords E>
[[nodiscard]] std::vector<std::string> all_words() {
    std::vector<std::string> all;
    for (const auto& w : words(E{})) all.emplace_back(w.word);
    return all;
}

/// The error of an allocation that failed. Of an array in a file it is the system's reason: a full disk, a limit of the
/// size of files (kind write).
[[nodiscard]] Error out_of_memory(const std::bad_alloc& failure);

/// The error of the exception that is being handled if memory or a thread is not to be had. Throws others again.
[[nodiscard]] Error out_of_resources();

/// Runs f() → Outcome at a module's face: memory or a thread that is not to be had becomes an error of kind memory.
/// Other exceptions are broken promises and pass.
template <class F>
[[nodiscard]] auto guarded(F&& f) -> decltype(f()) {
    try {
        return f();
    } catch (const std::exception&) {
        return fail(out_of_resources());
    }
}

}  // namespace camber

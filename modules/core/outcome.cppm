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
/// Outcomes and errors, descriptions of options, words of enumerations.
export module camber.core:outcome;

export namespace camber {

/// Maximum number of bytes that a message quotes from the input.
constexpr std::size_t longest_quote = 80;

/// Returns a text of at most `longest` bytes: its beginning, "…" and its end. UTF-8 characters are not split.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t longest = longest_quote);

/// Shortened text in quotation marks, with "?" for control characters.
[[nodiscard]] std::string in_quotes(std::string_view text);

enum class ErrorKind {
    usage,        ///< invalid option or configuration: exit code 2
    input,        ///< invalid input file or mesh: exit code 3
    unsupported,  ///< valid input that Camber does not support: exit code 3
    write,        ///< an output cannot be written: exit code 3
    stopped,      ///< stopped on request: exit code 130
    memory,       ///< out of memory: exit code 4
    internal,     ///< internal error: exit code 4
};

/// A mesh entity with its number in the file, from 1. Example: `tetrahedron 1234`.
struct Entity {
    std::string kind;
    std::uint64_t number = 0;
};

/// `what`: a sentence without a full stop; `where`: file with line or byte, or JSON path; `remedy`: advice.
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

template <class T>
using Outcome = tl::expected<T, Error>;

struct Done {};

[[nodiscard]] tl::unexpected<Error> fail(Error error);

[[nodiscard]] tl::unexpected<Error> fail(ErrorKind kind, std::string what, std::string where = {},
                                         std::optional<Entity> entity = {}, std::string remedy = {});

/// Returns `where: entity: what (remedy)`. Each part has at most 4096 bytes, the maximum path length.
[[nodiscard]] std::string describe(const Error& e);

// Description of the members of a struct of options, for parsing, checks, output and help. The struct has a static
// function `options()` that returns a tuple of `Option`. The default is the member's initialiser.

/// Range of a value. For an array: range of its items, and of their number.
struct Limits {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    bool low_open = false, high_open = false;
    std::size_t min_count = 0, max_count = std::numeric_limits<std::size_t>::max();

    [[nodiscard]] constexpr bool permit(double x) const {
        return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high);
    }
    /// Returns the range as in "at least 0 and below 1", or an empty text without limits.
    [[nodiscard]] std::string text() const;
    /// Returns the range as in "[0, 1)" or "(0, inf)".
    [[nodiscard]] std::string interval() const;
};

/// An option: a member of S or of its base class. It has a name in the configuration, a description (a sentence without
/// a full stop), a unit in words (may be empty) and limits. Texts have static lifetime.
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
    [[nodiscard]] constexpr Option required() const {
        Option o = *this;
        o.is_required = true;
        return o;
    }
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

template <class S>
concept HasOptions = requires { std::tuple_size<decltype(S::options())>::value; };

template <HasOptions S, class F>
constexpr void each_option(F&& f) {
    constexpr auto options = S::options();
    std::apply([&](const auto&... o) { (f(o), ...); }, options);
}

/// Does not compile for a member that is not an option.
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

/// Returns a message as in "must be at least 0 and below 1, got 2".
[[nodiscard]] std::string out_of_limits(const Limits& limits, std::string_view got);

/// Errors (usage): the value is not finite or not within the limits.
[[nodiscard]] Outcome<Done> check_limits(std::string_view name, double value, const Limits& limits);

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

// Words of enumerations, bound to enumerators by name. Declare beside an enumeration E:
//     constexpr auto words(E) { return words_of(Word{E::a, "a"}, Word{E::b, "b"}); }

template <class E>
struct Word {
    E value;
    std::string_view word;
};
template <class E>
Word(E, std::string_view) -> Word<E>;

/// True for enumerators. clang and gcc print other values as a cast: (E)7.
template <auto Value>
[[nodiscard]] consteval bool is_enumerator() {
    const std::string_view text = __PRETTY_FUNCTION__;  // ends with [Value = space::E::name]
    const char first = text[text.find_last_of(" :)") + 1];
    return first != '-' && (first < '0' || first > '9');
}

template <class E>
    requires(sizeof(E) == 1)
[[nodiscard]] consteval std::size_t enumerator_count() {
    return []<std::size_t... I>(std::index_sequence<I...>) {
        return (std::size_t{0} + ... + (is_enumerator<static_cast<E>(I)>() ? 1 : 0));
    }(std::make_index_sequence<256>{});
}

/// Words of an enumeration, in listing order. Does not compile unless each enumerator has one unique word.
template <class E, std::same_as<Word<E>>... Others>
[[nodiscard]] consteval std::array<Word<E>, 1 + sizeof...(Others)> words_of(Word<E> first, Others... others) {
    const std::array all{first, others...};
    if (all.size() != enumerator_count<E>()) throw "the number of words differs from the number of enumerators";
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (all[i].value == all[j].value || all[i].word == all[j].word)
                throw "a word or an enumerator occurs twice";
    return all;
}

template <class E>
concept HasWords = std::is_enum_v<E> && requires(E e) { words(e); };

template <HasWords E>
[[nodiscard]] constexpr std::string_view word_of(E value) {
    for (const auto& w : words(E{}))
        if (w.value == value) return w.word;
    return {};
}

template <HasWords E>
[[nodiscard]] std::vector<std::string> all_words() {
    std::vector<std::string> all;
    for (const auto& w : words(E{})) all.emplace_back(w.word);
    return all;
}

/// Returns the error of a failed allocation. For an array in a file, the error has the kind `write` and the system's
/// reason.
[[nodiscard]] Error out_of_memory(const std::bad_alloc& failure);

/// Returns the current exception as an error if memory or a thread is not available; rethrows other exceptions.
[[nodiscard]] Error out_of_resources();

/// Runs f() → Outcome at a module's interface. Lack of memory or threads becomes an error (out_of_resources); other
/// exceptions become internal errors.
template <class F>
[[nodiscard]] auto guarded(F&& f) -> decltype(f()) {
    try {
        return f();
    } catch (const std::exception&) {
        return fail(out_of_resources());
    }
}

}  // namespace camber

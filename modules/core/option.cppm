module;
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
export module camber.core:option;
import :outcome;

/// How a struct of options describes its members, once for all who read, check, write or explain them: a static
/// function `options()` that returns a tuple of `Option`. A default is the member's own initialiser.
export namespace camber {

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
    std::apply([&](const auto&... o) { (f(o), ...); }, S::options());
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

}  // namespace camber

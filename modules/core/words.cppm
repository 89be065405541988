module;
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.core:words;

/// Words of enumerations, bound to their enumerators by name. Beside an enumeration E stands
///     constexpr auto words(E) { return words_of(Word{E::a, "a"}, Word{E::b, "b"}); }
export namespace camber {

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

}  // namespace camber

#pragma once
#include <span>
#include <string_view>

namespace camber::app {

/// A word of the tables that the commands print.
struct Term {
    std::string_view names;  ///< in small letters, but for the first; with "|" between them
    std::string_view text;
};

[[nodiscard]] std::span<const Term> all_terms();

/// Returns the term with that name, or the longest one whose name is part of the phrase; null: there is none.
[[nodiscard]] const Term* find_term(std::string_view phrase);

}  // namespace camber::app

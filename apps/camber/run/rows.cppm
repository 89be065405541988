module;
#include <cstddef>
#include <string>
#include <string_view>
module camber.run:rows;

namespace camber::run {

/// 1234567 → "1 234 567".
[[nodiscard]] std::string grouped(std::size_t n);

/// One line of a table for a terminal.
[[nodiscard]] std::string table_row(std::string_view name, const std::string& value);
[[nodiscard]] std::string table_row(std::string_view name, std::size_t n);

/// A lower bound in four digits, and an upper one: what is read back is not above the former, not below the latter.
[[nodiscard]] std::string lower_bound_text(double x);
[[nodiscard]] std::string upper_bound_text(double x);

/// The lower bound of a scaled Jacobian; "> 0" where its sign is certain and no number above 0 is.
[[nodiscard]] std::string scaled_jacobian_text(double least, bool is_positive);

}  // namespace camber::run

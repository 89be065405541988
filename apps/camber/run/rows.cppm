module;
#include <cstddef>
#include <string>
#include <string_view>
export module camber.run:rows;

namespace camber::run {

/// 1234567 → "1 234 567".
[[nodiscard]] std::string grouped(std::size_t n);

/// One line of a table for a terminal.
[[nodiscard]] std::string table_row(std::string_view name, const std::string& value);
[[nodiscard]] std::string table_row(std::string_view name, std::size_t n);

}  // namespace camber::run

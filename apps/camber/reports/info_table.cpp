// Contents of files as JSON and as a table
module;
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import :json;

namespace camber::run {

namespace {

std::string row(std::string_view name, std::string_view value) { return fmt::format("  {:<26}{}\n", name, value); }

/// "1 inlet: 170, 2 wall: 734".
std::string counts_text(std::string_view key, const ReferenceCounts& counts, const Groups& groups) {
    const int dimension = key.starts_with("edges") ? 1 : key.starts_with("triangles") ? 2 : 3;
    std::string text;
    for (const auto& [reference, count] : counts)
        text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", called(groups, dimension, reference), count);
    return text;
}

/// A row for each item, the first with the key.
std::string rows_of_list(std::string_view key, const auto& items, auto&& text_of_item) {
    std::string text;
    for (const auto& item : items) text += row(text.empty() ? key : "", text_of_item(item));
    return text;
}

/// The row of a value; empty for 0, false and empty ones.
std::string row_of(std::string_view key, const Json& value) {
    if ((value.is_number() && value == 0) || (value.is_structured() && value.empty()) || value == false) return {};
    return row(
        key, value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

template <class Info>
std::string rows_of(const Info& info, const Groups& groups) {
    std::string text;
    each_shown_field(info, Reported::volume, [&](const auto& field, const auto& value) {
        using T = std::remove_cvref_t<decltype(value)>;
        if constexpr (std::same_as<T, ReferenceCounts>)
            text += value.empty() ? std::string() : row(field.key, counts_text(field.key, value, groups));
        else if constexpr (std::same_as<T, Groups>)
            text += rows_of_list(field.key, value, [](const Group& group) {
                return fmt::format("{}D {} {}", group.dimension, group.reference, group.name);
            });
        else if constexpr (std::same_as<T, std::vector<std::string>>)
            text += rows_of_list(field.key, value, [](const std::string& notice) { return notice; });
        else
            text += row_of(field.key, json_of(value));
    });
    return text;
}

}  // namespace

std::string info_json(const FileInfo& info) {
    const Json json = std::visit([](const auto& i) { return json_of(i); }, info);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string info_table(const FileInfo& info) {
    const auto* const mesh = std::get_if<MeshInfo>(&info);
    return std::visit([&](const auto& i) { return rows_of(i, mesh ? mesh->groups : Groups()); }, info);
}

}  // namespace camber::run

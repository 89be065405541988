module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:legal_names;
import camber.core;
import :mesh_fields;
import :notice;
import :solution;

/// Names of fields and groups as formats have them: legal, and each one's own.
namespace camber {

/// What a format requires of names.
struct NameRule {
    std::string (*legal)(std::string_view name);  ///< the nearest name of letters that the format has
    std::size_t longest = std::string::npos;      ///< in bytes
    std::vector<std::string> reserved = {};       ///< names of what is no field or group
    std::string_view unnamed = "unnamed";         ///< the name of what has none
};

/// A name, and the endings with which the file lists it: of a vector by its components several.
struct ListedName {
    std::string name;
    std::vector<std::string> endings{{}};
};

/// A name for each, as the rule has it, so that nothing is listed twice. Names that the rule has stay, the first of
/// equal ones; the others lose what is not legal, and end in _2, _3 and so on where another has their name.
[[nodiscard]] std::vector<std::string> legal_names(std::span<const ListedName> names, const NameRule& rule);

/// The name with `_` for control characters and for bytes that are no UTF-8.
[[nodiscard]] std::string readable_name(std::string_view name);
/// The name on one line, with ' for ".
[[nodiscard]] std::string quotable_name(std::string_view name);

/// The rules of a format for its fields.
struct FieldNames {
    NameRule at_nodes, at_cells;
    std::vector<std::string> (*endings)(FieldKind kind) = nullptr;  ///< none: each field is listed once
};
/// The fields with their names in the format.
[[nodiscard]] MeshFields with_legal_names(const MeshFields& fields, const FieldNames& rules);
/// A notice of the names that become others.
[[nodiscard]] std::vector<Notice> renamed_fields(const MeshFields& fields, const FieldNames& rules,
                                                 std::string_view format);

/// The groups with their names in the format: names that differ within a dimension stay different.
[[nodiscard]] Column<Group> with_legal_names(const Column<Group>& groups, const NameRule& rule);

/// An old name and the new one; the same where it stays.
using Renaming = std::pair<std::string, std::string>;
/// A notice of those that change: "VTU has other names for 2 fields: …".
[[nodiscard]] std::vector<Notice> note_renamed(std::string_view format, std::string_view kind,
                                               const std::vector<Renaming>& names);
[[nodiscard]] std::vector<Notice> renamed_groups(const Column<Group>& groups, const Column<Group>& in_file,
                                                 std::string_view format);

}  // namespace camber

// Fields of meshes: legal names in a format, and conversion between 2D and space.
module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

MeshFields::MeshFields(std::vector<MeshField> fields) {
    // The keys are copies of the names, because names are moved together with their fields.
    std::map<std::pair<std::string, Centring>, std::size_t> rows;
    for (MeshField& field : fields) {
        const auto [at, is_new] = rows.try_emplace({field.name, field.centring}, fields_.size());
        if (is_new)
            fields_.push_back(std::move(field));
        else
            fields_[at->second] = std::move(field);
    }
}

Outcome<Solution> solution_of(const MeshFields& fields, int dimension, std::size_t vertices,
                              const Execution& execution) {
    Solution solution{.dimension = dimension, .rows = vertices};
    std::vector<const MeshField*> taken;
    for (const MeshField& field : fields)
        if (field.centring == Centring::node) taken.push_back(&field);
    if (taken.empty())
        return fail(ErrorKind::usage, "the mesh has no fields at its nodes", {}, {},
                    "give a file with fields at the nodes");
    for (const MeshField* const field : taken) solution.fields.push_back(field->kind);
    const std::size_t stride = row_width(solution);
    Buffer<double> values(vertices * stride);
    std::size_t begin = 0;
    for (const MeshField* const field : taken) {
        const auto width = static_cast<std::size_t>(values_per_vertex(field->kind, dimension));
        auto copied = std::visit(
            [&](const auto& column) {
                return each(execution, vertices, [&](std::size_t v) {
                    for (std::size_t c = 0; c < width; ++c)
                        values[v * stride + begin + c] = static_cast<double>(column[v * width + c]);
                });
            },
            field->values);
        if (!copied) return fail(std::move(copied.error()));
        begin += width;
    }
    solution.values = std::move(values);
    return solution;
}

namespace {

/// Number of bytes of the UTF-8 character at position `at`; 0 if the bytes are not valid UTF-8.
std::size_t character_at(std::string_view text, std::size_t at) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(at);
    const std::size_t width = first < 0x80                    ? 1
                              : first >= 0xC2 && first < 0xE0 ? 2
                              : first >= 0xE0 && first < 0xF0 ? 3
                              : first >= 0xF0 && first < 0xF5 ? 4
                                                              : 0;
    if (width == 0 || at + width > text.size()) return 0;
    for (std::size_t i = 1; i < width; ++i)
        if ((byte(at + i) & 0xC0U) != 0x80U) return 0;
    const bool is_too_long = (first == 0xE0 && byte(at + 1) < 0xA0) || (first == 0xF0 && byte(at + 1) < 0x90);
    const bool is_none = (first == 0xED && byte(at + 1) >= 0xA0) || (first == 0xF4 && byte(at + 1) >= 0x90);
    return is_too_long || is_none ? 0 : width;
}

std::string cut_to_length(std::string_view name, std::size_t longest) {
    if (name.size() <= longest) return std::string(name);
    std::size_t end = longest;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) --end;
    return std::string(name.substr(0, end));
}

class UsedNames {
  public:
    explicit UsedNames(const std::vector<std::string>& reserved) : taken_(reserved.begin(), reserved.end()) {}

    bool take(const std::string& name, const std::vector<std::string>& endings) {
        const auto listed = [&](const std::string& ending) { return taken_.contains(name + ending); };
        if (std::ranges::any_of(endings, listed)) return false;
        for (const std::string& ending : endings) taken_.insert(name + ending);
        return true;
    }

  private:
    std::set<std::string> taken_;
};

std::size_t longest_ending(const ListedName& name) {
    std::size_t longest = 0;
    for (const std::string& ending : name.endings) longest = std::max(longest, ending.size());
    return longest;
}

std::map<std::string, std::string> names_in_file(const MeshFields& fields, Centring centring, const FieldNames& rules) {
    std::vector<ListedName> names;
    for (const MeshField& field : fields) {
        if (field.centring != centring) continue;
        names.push_back({field.name});
        if (rules.endings) names.back().endings = rules.endings(field.kind);
    }
    const auto legal = legal_names(names, centring == Centring::node ? rules.at_nodes : rules.at_cells);
    std::map<std::string, std::string> all;
    for (std::size_t i = 0; i < names.size(); ++i) all[names[i].name] = legal[i];
    return all;
}

}  // namespace

std::vector<std::string> legal_names(std::span<const ListedName> names, const NameRule& rule) {
    UsedNames taken(rule.reserved);
    std::vector<std::string> legal(names.size());
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < names.size(); ++i) {
        // `legal` is called twice: after shortening, a name may end with a character that is not allowed at the end.
        legal[i] = rule.legal(cut_to_length(rule.legal(names[i].name), rule.longest - longest_ending(names[i])));
        if (legal[i].empty()) legal[i] = rule.unnamed;
        if (legal[i] != names[i].name || !taken.take(legal[i], names[i].endings)) others.push_back(i);
    }
    for (const std::size_t i : others) {
        const std::string stem = legal[i];
        for (std::size_t n = 2; !taken.take(legal[i], names[i].endings); ++n) {
            const std::string number = "_" + std::to_string(n);
            legal[i] = cut_to_length(stem, rule.longest - longest_ending(names[i]) - number.size()) + number;
        }
    }
    return legal;
}

std::string readable_name(std::string_view name) {
    std::string text;
    for (std::size_t i = 0; i < name.size();) {
        const std::size_t width = character_at(name, i);
        const auto code = static_cast<unsigned char>(name[i]);
        if (width == 0 || code < ' ' || code == 0x7F)
            text += '_';
        else
            text += name.substr(i, width);
        i += std::max<std::size_t>(width, 1);
    }
    return text;
}

std::string quotable_name(std::string_view name) {
    std::string text(name);
    for (char& c : text) c = c == '"' ? '\'' : c == '\n' || c == '\r' ? ' ' : c;
    return text;
}

MeshFields with_legal_names(const MeshFields& fields, const FieldNames& rules) {
    const auto at_nodes = names_in_file(fields, Centring::node, rules);
    const auto at_cells = names_in_file(fields, Centring::cell, rules);
    std::vector<MeshField> all(fields.begin(), fields.end());
    for (MeshField& field : all) field.name = (field.centring == Centring::node ? at_nodes : at_cells).at(field.name);
    return MeshFields(std::move(all));
}

std::vector<Notice> renamed_fields(const MeshFields& fields, const FieldNames& rules, std::string_view format) {
    const MeshFields named = with_legal_names(fields, rules);
    std::vector<Renaming> names;
    std::transform(fields.begin(), fields.end(), named.begin(), std::back_inserter(names),
                   [](const MeshField& a, const MeshField& b) { return Renaming{a.name, b.name}; });
    return note_renamed(format, "fields", names);
}

Column<Group> with_legal_names(const Column<Group>& groups, const NameRule& rule) {
    std::map<int, std::vector<ListedName>> names;
    std::set<std::pair<int, std::string>> visited;
    for (const Group& group : groups)
        if (visited.insert({group.dimension, group.name}).second) names[group.dimension].push_back({group.name});
    std::map<std::pair<int, std::string>, std::string> in_file;
    for (const auto& [dimension, all] : names) {
        const auto legal = legal_names(all, rule);
        for (std::size_t i = 0; i < all.size(); ++i) in_file[{dimension, all[i].name}] = legal[i];
    }
    Buffer<Group> renamed(groups.begin(), groups.end());
    for (Group& group : renamed) group.name = in_file.at({group.dimension, group.name});
    return renamed;
}

std::vector<Notice> note_renamed(std::string_view format, std::string_view kind, const std::vector<Renaming>& names) {
    constexpr std::size_t shown = 8;
    std::string text;
    std::size_t count = 0;
    std::set<Renaming> noted;
    for (const Renaming& name : names) {
        if (name.first == name.second || !noted.insert(name).second) continue;
        if (count++ < shown)
            text += (count > 1 ? ", " : "") + in_quotes(name.first) + " becomes " + in_quotes(name.second);
    }
    if (count == 0) return {};
    if (count > shown) text += " and " + std::to_string(count - shown) + " more";
    return {{std::string(format) + " cannot hold " + std::to_string(count) + " names of " + std::string(kind) + ": " +
             text}};
}

std::vector<Notice> renamed_groups(const Column<Group>& groups, const Column<Group>& in_file, std::string_view format) {
    std::vector<Renaming> names;
    std::transform(groups.begin(), groups.end(), in_file.begin(), std::back_inserter(names),
                   [](const Group& a, const Group& b) { return Renaming{a.name, b.name}; });
    return note_renamed(format, "references", names);
}

namespace {

constexpr std::size_t row_grain = 4096;

/// Component k of a new row is component `sources[k]` of the old row, or zero if `sources[k]` is −1.
template <class T>
Outcome<Column<T>> chosen(const Column<T>& rows, std::size_t width, const std::vector<int>& sources,
                          const Execution& execution) {
    const std::size_t wide = sources.size();
    return map_each(
               execution, rows.size() / width * wide,
               [&](std::size_t i) {
                   const int source = sources[i % wide];
                   return source < 0 ? T{} : rows[i / wide * width + static_cast<std::size_t>(source)];
               },
               row_grain)
        .map([](Buffer<T> result) { return Column<T>(std::move(result)); });
}

/// A row has the components of a field at one point. For each component of a 2D row, returns its index in a row in
/// space. Symmetric tensors are stored as in `Sym`.
std::vector<int> in_plane(FieldKind kind) {
    switch (kind) {
        case FieldKind::scalar: return {0};
        case FieldKind::vector: return {0, 1};
        case FieldKind::symmetric_tensor: return {0, 1, 2};
        case FieldKind::full_tensor: return {0, 1, 3, 4};
    }
    return {};
}

/// For each component of a row in space, returns its index in a 2D row; −1 for z components.
std::vector<int> in_space(FieldKind kind) {
    std::vector<int> sources(static_cast<std::size_t>(values_per_vertex(kind, 3)), -1);
    const std::vector<int> places = in_plane(kind);
    for (std::size_t i = 0; i < places.size(); ++i) sources[static_cast<std::size_t>(places[i])] = static_cast<int>(i);
    return sources;
}

Outcome<MeshFields> with_values_at(const MeshFields& fields, int dimension, std::vector<int> (*sources)(FieldKind),
                                   const Execution& execution) {
    std::vector<MeshField> result;
    for (const MeshField& field : fields) {
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, dimension));
        auto values = std::visit(
            [&](const auto& column) {
                return chosen(column, width, sources(field.kind), execution).map([](auto taken) {
                    return FieldValues(std::move(taken));
                });
            },
            field.values);
        if (!values) return fail(std::move(values.error()));
        result.push_back({field.name, field.centring, field.kind, std::move(*values)});
    }
    return MeshFields(std::move(result));
}

}  // namespace

Outcome<MeshFields> raised(const MeshFields& fields, const Execution& execution) {
    return guarded([&] { return with_values_at(fields, 2, in_space, execution); });
}

std::vector<bool> involves_z(FieldKind kind) {
    std::vector<bool> involved(static_cast<std::size_t>(values_per_vertex(kind, 3)), true);
    for (const int place : in_plane(kind)) involved[static_cast<std::size_t>(place)] = false;
    return involved;
}

Outcome<MeshFields> flattened(const MeshFields& fields, const Execution& execution) {
    return guarded([&] { return with_values_at(fields, 3, in_plane, execution); });
}

Outcome<Solution> flattened(Solution solution, const Execution& execution) {
    return guarded([&]() -> Outcome<Solution> {
        if (solution.dimension != 3) return std::move(solution);
        std::vector<int> sources;
        int begin = 0;
        for (const FieldKind kind : solution.fields) {
            for (const int place : in_plane(kind)) sources.push_back(begin + place);
            begin += values_per_vertex(kind, 3);
        }
        if (begin > 0) {
            auto values = chosen(solution.values, static_cast<std::size_t>(begin), sources, execution);
            if (!values) return fail(std::move(values.error()));
            solution.values = std::move(*values);
        }
        solution.dimension = 2;
        return std::move(solution);
    });
}

}  // namespace camber

module;
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

constexpr std::size_t row_grain = 4096;

/// Rows of other values: of the old row those that stand at `sources`; −1: zero.
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
        .map([](Buffer<T> made) { return Column<T>(std::move(made)); });
}

/// Where the values of a field in 2D stand in one in space; symmetric tensors are in the order of `Sym`.
std::vector<int> in_plane(FieldKind kind) {
    switch (kind) {
        case FieldKind::scalar: return {0};
        case FieldKind::vector: return {0, 1};
        case FieldKind::symmetric_tensor: return {0, 1, 2};
        case FieldKind::full_tensor: return {0, 1, 3, 4};
    }
    return {};
}

/// The other way round; −1: there is none.
std::vector<int> in_space(FieldKind kind) {
    std::vector<int> sources(static_cast<std::size_t>(values_per_vertex(kind, 3)), -1);
    const std::vector<int> places = in_plane(kind);
    for (std::size_t i = 0; i < places.size(); ++i) sources[static_cast<std::size_t>(places[i])] = static_cast<int>(i);
    return sources;
}

/// Fields of a mesh in so many dimensions with other values a row: see `chosen`.
Outcome<MeshFields> with_values_at(const MeshFields& fields, int dimension, std::vector<int> (*sources)(FieldKind),
                                   const Execution& execution) {
    std::vector<MeshField> made;
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
        made.push_back({field.name, field.centring, field.kind, std::move(*values)});
    }
    return MeshFields(std::move(made));
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

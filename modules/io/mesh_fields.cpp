module;
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

MeshFields::MeshFields(std::vector<MeshField> fields) {
    // Keys are copies: the names move with their fields.
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
        return fail(ErrorKind::usage, "the mesh has no fields at its nodes", {}, {}, "give a file that has some");
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

}  // namespace camber

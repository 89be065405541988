module;
#include <cstddef>
#include <string>
module camber.io:field_rows;
import camber.core;
import :mesh_fields;

namespace camber {

/// Whether fields have a row for each node, or cell, of the mesh that they are written with. Errors: usage.
template <int D>
[[nodiscard]] Outcome<Done> check_rows(const MeshFields& fields, std::size_t nodes, std::size_t cells) {
    for (const MeshField& field : fields) {
        const bool is_of_nodes = field.centring == Centring::node;
        const std::size_t rows = is_of_nodes ? nodes : cells;
        if (field.size() != rows * static_cast<std::size_t>(values_per_vertex(field.kind, D)))
            return fail(ErrorKind::usage, "the field " + in_quotes(field.name) +
                                              " does not have one row for each of the " + std::to_string(rows) +
                                              (is_of_nodes ? " nodes" : " cells") + " of the mesh");
    }
    return Done{};
}

}  // namespace camber

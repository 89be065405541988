module;
#include <cstddef>
#include <cstdint>
#include <optional>
export module camber.recovery:material_rows;
import camber.core;

export namespace camber {

/// Rows for values at vertices that may break where materials meet: a vertex has one for each reference among its
/// elements. One inside of a material has one row, one of no element none; rows count on from vertex to vertex.
struct MaterialRows {
    Incidence<Reference> materials;  ///< around each vertex, rising: those of its rows

    [[nodiscard]] std::size_t size() const { return materials.items.size(); }
    [[nodiscard]] std::size_t vertices() const { return materials.size(); }
    /// The first row of a vertex; the others follow.
    [[nodiscard]] std::size_t first(VertexId v) const { return materials.offsets[v.index()]; }
    /// The row of a vertex on the side of a material; none where it has no element there.
    [[nodiscard]] std::optional<std::size_t> row(VertexId v, Reference material) const {
        const auto around = materials[v];
        for (std::size_t i = 0; i < around.size(); ++i)
            if (around[i] == material) return first(v) + i;
        return {};
    }
    friend bool operator==(const MaterialRows& a, const MaterialRows& b) {
        return a.materials.offsets == b.materials.offsets && a.materials.items == b.materials.items;
    }
};

/// The row that element e sees at its local vertex i: that of its own material. For rows of the same mesh.
template <int D>
[[nodiscard]] std::size_t row_of(const MaterialRows& rows, const LinearMesh<D>& mesh, ElementId e, int i) {
    return *rows.row(mesh.elements.vertices[e][i], mesh.elements.references[e]);
}

/// The rows of a mesh with its balls. Errors: input (not one reference an element; more rows than 32 bits count);
/// memory; stopped.
template <int D>
[[nodiscard]] Outcome<MaterialRows> material_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution);

/// 1 for the rows on the boundary of their material: at a face of an element of it that no other element of it shares,
/// where the mesh ends or another material begins. Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<std::uint8_t>> boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          const MaterialRows& rows, const Execution& execution);

}  // namespace camber

namespace camber {

/// Errors: input (not one reference an element).
[[nodiscard]] Outcome<Done> check_materials(std::size_t references, std::size_t elements);

}  // namespace camber

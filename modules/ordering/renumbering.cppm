module;
#include <cstddef>
#include <utility>
export module camber.ordering:renumbering;
import camber.core;

/// Other ids for the vertices and elements of a mesh. Facets and feature edges keep theirs: few and read in turn, their
/// order costs little.
export namespace camber {

/// Other ids for all entities of one kind, and the way back.
template <class EntityId>
struct Permutation {
    Column<EntityId> before;  ///< of each id the one that it was
    Column<EntityId> after;   ///< of each id that was the one that it is
};

/// From the ids that were, each once, in the order of the new ones. Errors: memory, stopped.
template <class EntityId>
[[nodiscard]] Outcome<Permutation<EntityId>> permutation(Column<EntityId> before, const Execution& execution) {
    Buffer<EntityId> after;
    auto done = guarded([&]() -> Outcome<Done> {
        after = Buffer<EntityId>(before.size());
        return each(execution, before.size(), [&](std::size_t id) { after[before[id].index()] = EntityId(id); });
    });
    if (!done) return fail(std::move(done.error()));
    return Permutation<EntityId>{std::move(before), std::move(after)};
}

struct Renumbering {
    Permutation<VertexId> vertices;
    Permutation<ElementId> elements;
};

/// From the new ids to those that were.
[[nodiscard]] inline Renumbering inverse(const Renumbering& r) {
    return {{r.vertices.after, r.vertices.before}, {r.elements.after, r.elements.before}};
}

/// A column whose rows are of entities, `width` values each, in the order of the new ids; without rows it stays so.
/// Errors: memory, stopped.
template <class T, class EntityId>
[[nodiscard]] Outcome<Column<T>> renumbered_rows(const Column<T>& rows, const Column<EntityId>& before,
                                                 const Execution& execution, std::size_t width = 1) {
    if (rows.empty()) return rows;
    return map_each(execution, before.size() * width,
                    [&](std::size_t i) { return rows[before[i / width].index() * width + i % width]; })
        .map([](Buffer<T> made) { return Column<T>(std::move(made)); });
}

/// The same mesh by the new ids. The vertices of a simplex keep their turn, and lists of entities theirs, so that what
/// is renumbered by the inverse is what it was. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> renumbered(LinearMesh<D> mesh, const Renumbering& renumbering,
                                                const Execution& execution);

/// The same of a mesh of degree 2, whose unique edges get other ids by the way.
template <int D>
struct RenumberedQuadratic {
    QuadraticMesh<D> mesh;
    Column<EdgeId> edges;  ///< of each edge the one that it was
};
template <int D>
[[nodiscard]] Outcome<RenumberedQuadratic<D>> renumbered(QuadraticMesh<D> mesh, const Renumbering& renumbering,
                                                         const Execution& execution);

}  // namespace camber

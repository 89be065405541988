module;
#include <cstddef>
#include <optional>
module camber.metric:location_start;
import camber.core;
import :back_mesh;

/// What is known of a point before it is looked for.
namespace camber {

/// A hint comes of whatever mesh: one that is no element of this is none.
template <int D>
[[nodiscard]] ElementId element_or_none(const LinearMesh<D>& mesh, ElementId hint) {
    return hint.valid() && hint.index() < mesh.elements.size() ? hint : ElementId{};
}

/// A point that is a vertex of the element to the last bit is there. Vertices of a mesh are asked for in the field that
/// lives on it; at walls rounding would put half of them beyond.
template <int D>
[[nodiscard]] std::optional<Location<D>> at_vertex_of(const LinearMesh<D>& mesh, ElementId e, const Vec<D>& p) {
    if (!e.valid()) return {};
    const auto& vertices = mesh.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        if (mesh.points[vertices[i]] != p) continue;
        Location<D> there{.element = e, .xi = {}, .placement = Placement::inside};
        there.xi[i] = 1;
        return there;
    }
    return {};
}

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>
export module camber.cad:geometry;
import camber.core;
import camber.surface;
import :model;

/// A model in a plane z = constant as geometry of 2D meshes; its edges are curves.
export namespace camber {

/// Checks that the model is in a plane z = constant. Errors (input): no edges; heights differ by more than 1e-7 of the
/// model's size.
[[nodiscard]] Outcome<Done> check_flatness(const CadModel& model);

/// Returns the model's edges, ascending; of coincident edges of touching faces, only the first.
[[nodiscard]] std::vector<std::size_t> curves_of(const CadModel& model);

/// Closest point of an edge, with the unit normal there. The normal points to the right of the edge.
struct CadCurveFoot {
    Vec<2> point, normal;
    double t = 0, distance = 0;
};
/// A point that is on the curve within rounding is returned unchanged.
[[nodiscard]] CadCurveFoot closest_on_curve(const CadModel& model, std::size_t edge, const Vec<2>& p);
[[nodiscard]] EntityPoint<2> point_on_curve(const CadModel& model, std::size_t edge, double t);

/// Returns the closest edge to p, or the first of equally near edges. Empty without edges.
[[nodiscard]] std::optional<std::size_t> nearest_curve(const CadModel& model, std::span<const std::size_t> edges,
                                                       const Vec<2>& p);
/// Like `best_face`, for a 2D facet. The fit error compares tangents instead of normals.
[[nodiscard]] CadFit best_curve(const CadModel& model, std::span<const std::size_t> edges,
                                const std::array<Vec<2>, 2>& ends);

/// Model entities on which facets can lie: faces (2D: curves).
template <int D>
[[nodiscard]] std::vector<std::size_t> candidates(const CadModel& model) {
    if constexpr (D == 2) return curves_of(model);
    std::vector<std::size_t> faces(model.faces());
    std::iota(faces.begin(), faces.end(), std::size_t{0});
    return faces;
}
template <int D>
[[nodiscard]] CadFit best_fit(const CadModel& model, std::span<const std::size_t> candidates,
                              const std::array<Vec<D>, D>& corners) {
    if constexpr (D == 2)
        return best_curve(model, candidates, corners);
    else
        return best_face(model, candidates, corners);
}

/// Returns the closest vertex at which one of these edges (ascending, at least one) ends. Empty for a single edge,
/// unless it is closed and has a kink at its vertex.
[[nodiscard]] std::optional<std::size_t> end_between(const CadModel& model, std::span<const std::size_t> edges,
                                                     const Vec<2>& p);
[[nodiscard]] Vec<2> vertex_in_plane(const CadModel& model, std::size_t vertex);

}  // namespace camber

namespace camber {

[[nodiscard]] inline Vec<2> in_plane(const Vec<3>& p) { return {{p[0], p[1]}}; }
[[nodiscard]] inline Box<2> in_plane(const Box<3>& box) {
    Box<2> out;
    out.low = in_plane(box.low);
    out.high = in_plane(box.high);
    return out;
}

}  // namespace camber

export namespace camber {

/// A CAD model as the geometry of a mesh. Entities have the numbers of the model: surfaces are faces (2D: edges),
/// curves are edges, corners are vertices.
/// - A facet of the mesh lies on its associated face. A facet of a derived mesh lies on the best-fitting face of its
///   reference.
/// - A mesh edge between two faces lies on a model edge, even a smooth one, if it follows that model edge. Otherwise it
///   lies on the closest face.
/// - Joined faces (`CadAssociation::joined`) are one surface for projections.
template <int D>
struct CadGeometry {
    CadModel model;
    CadAssociation association;
    LinearMesh<D> mesh;  ///< associated mesh

    [[nodiscard]] bool is_whole() const { return association.facets == mesh.facets.size(); }
    /// True if the facet is on the model and has the number and corners of a facet of `mesh`.
    [[nodiscard]] bool has(const FacetSite<D>& facet) const {
        return facet.id.valid() && facet.id.index() < mesh.facets.size() && association.faces[facet.id] != no_face &&
               facet_site(mesh, facet.id).corners == facet.corners;
    }
    /// Faces (2D: edges) with facets of a reference.
    [[nodiscard]] std::span<const std::size_t> of_reference(Reference reference) const {
        const auto& all = association.of_references;
        const auto row = std::lower_bound(all.begin(), all.end(), reference,
                                          [](const auto& entry, Reference r) { return entry.first < r; });
        if (row == all.end() || row->first != reference) return {};
        return row->second;
    }
    [[nodiscard]] std::vector<std::size_t> met() const {
        std::vector<std::size_t> all;
        for (const auto& [reference, faces] : association.of_references)
            all.insert(all.end(), faces.begin(), faces.end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    }
};
[[nodiscard]] std::shared_ptr<const GeometryModel<2>> model_of(CadGeometry<2> cad);
[[nodiscard]] std::shared_ptr<const GeometryModel<3>> model_of(CadGeometry<3> cad);

/// Samples the faces and edges of a model, including seams. Samples on faces are uniform by area, about `target_count`
/// in all, with a minimum for small faces. Entities have the model's numbers. In 2D, samples only curves (`curves_of`),
/// uniformly by length. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of(const CadModel& model, std::size_t target_count,
                                                     const Execution& execution);

template <int D, class IsSelected>
[[nodiscard]] Outcome<GeometrySamples<D>> part_of_samples(const GeometrySamples<D>& whole, IsSelected&& is_selected) {
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        GeometrySamples<D> part;
        for (const auto& [entity, begin, end] : whole.entities) {
            if (!is_selected(entity)) continue;
            part.begin(entity);
            for (std::size_t i = begin; i < end; ++i) part.add(whole.points[i], whole.weights[i]);
        }
        return part;
    });
}

/// Treatment of boundary vertices that are off the model.
enum class CadVertices : std::uint8_t { keep, move };
[[nodiscard]] constexpr auto words(CadVertices) {
    return words_of(Word{CadVertices::keep, "keep"}, Word{CadVertices::move, "move"});
}

template <int D>
struct VerticesOnModel {
    Column<Vec<D>> points;
    std::size_t moved = 0;
    std::size_t constrained = 0;  ///< vertices that did not reach their targets, because a simplex would become flat
    double largest = 0;           ///< largest move
    VertexId farthest = {};       ///< vertex of the largest move
};

/// Moves each vertex of facets on the model to the closest point of a model entity:
/// - One face at the vertex: its virtual face.
/// - Two faces: their edge.
/// - Three or more faces (2D: two curves): their model vertex.
/// - At the end of the part of the boundary on the model: the rim of the face.
/// - Beside another surface that `geometry` prescribes: the curve of both surfaces. `geometry` contains the model.
///
/// Each element keeps at least a fifth of its volume, each facet a fifth of its area along its normal. Moves that
/// violate this are halved up to six times, then dropped. Required vertices are fixed. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VerticesOnModel<D>> vertices_onto(const CadModel& model, const CadAssociation& association,
                                                        const LinearMesh<D>& mesh, const Geometry<D>& geometry,
                                                        const Execution& execution);

/// Checks that the mesh fits the model. Errors (input): too many vertices are off a face or an edge
/// (`CadAssociation::fit_error`). The error names the farthest vertex, its distance, the number of off vertices, and,
/// unless `vertices` is `move`, how to move them.
template <int D>
[[nodiscard]] Outcome<Done> check_vertices(const CadAssociation& association, CadVertices vertices);

}  // namespace camber

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

/// A model in a plane z = constant as the geometry of 2D meshes: its edges are the curves, at whichever height.
export namespace camber {

/// Errors (input): the model has no edges, or reaches out of a plane z = constant by more than 1e-7 of its size.
[[nodiscard]] Outcome<Done> check_flatness(const CadModel& model);

/// The model's edges, rising; of those that coincide (of faces that touch, each with its own) the first.
[[nodiscard]] std::vector<std::size_t> curves_of(const CadModel& model);

/// The point of an edge nearest to a point of the plane, and the unit normal there, to the right of the edge.
struct CadCurveFoot {
    Vec<2> point, normal;
    double t = 0, distance = 0;
};
/// As closest_on_edge: a point that lies there but for rounding stays as it is.
[[nodiscard]] CadCurveFoot closest_on_curve(const CadModel& model, std::size_t edge, const Vec<2>& p);
[[nodiscard]] EntityPoint<2> point_on_curve(const CadModel& model, std::size_t edge, double t);

/// The nearest of some edges, the lowest of equally near ones; nothing of none.
[[nodiscard]] std::optional<std::size_t> nearest_curve(const CadModel& model, std::span<const std::size_t> edges,
                                                       const Vec<2>& p);
/// As best_face; the misfit's last part is the length by the sine of the angle between the tangents.
[[nodiscard]] CadFit best_curve(const CadModel& model, std::span<const std::size_t> edges,
                                const std::array<Vec<2>, 2>& ends);

/// What facets can lie on: faces, in 2D curves; and the best of some.
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

/// The end nearest to p at which edges around a point (rising, at least one) meet: any of two edges or more, of one
/// alone where it is closed with a kink. Nothing where there is none.
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

/// A CAD model as the geometry of a mesh: surfaces are its faces, curves its edges, corners its vertices, by the
/// model's numbers. Facets of the mesh lie on what they are associated with; other facets (of a mesh that was made from
/// it) on that face which fits them best of those that their reference lies on. An edge between two faces is on the
/// model's edge there, even where both are smooth, if it lies along that edge; else on the nearest face. Faces that the
/// mesh joins (CadAssociation::joined) are one surface for projections.
/// In 2D surfaces are its edges, corners its vertices.
template <int D>
struct CadGeometry {
    CadModel model;
    CadAssociation association;
    LinearMesh<D> mesh;  ///< that of the association

    /// Whether all of the mesh's boundary is on the model.
    [[nodiscard]] bool is_whole() const { return association.facets == mesh.facets.size(); }
    /// Whether a facet is the one of its number of that mesh, and on the model.
    [[nodiscard]] bool has(const FacetSite<D>& facet) const {
        return facet.id.valid() && facet.id.index() < mesh.facets.size() && association.faces[facet.id] != no_face &&
               facet_site(mesh, facet.id).corners == facet.corners;
    }
    /// The faces (in 2D edges) that facets of a reference lie on; none of an unknown one.
    [[nodiscard]] std::span<const std::size_t> of_reference(Reference reference) const {
        const auto& all = association.of_references;
        const auto row = std::lower_bound(all.begin(), all.end(), reference,
                                          [](const auto& entry, Reference r) { return entry.first < r; });
        if (row == all.end() || row->first != reference) return {};
        return row->second;
    }
    /// The faces (in 2D edges) that the mesh has facets on, rising.
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

/// Points of a model's faces, by parameters within their trims, and of its edges: about `wanted` on faces, as many a
/// unit of area on each, but for small ones, which have some. Numbers of entities are those of the model; seams, along
/// which a face meets itself, are among its edges. In 2D points of its curves alone (curves_of), as many a unit of
/// length. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of(const CadModel& model, std::size_t wanted,
                                                     const Execution& execution);

/// Those of the entities of which `is_wanted(entity)`.
template <int D, class IsWanted>
[[nodiscard]] Outcome<GeometrySamples<D>> part_of_samples(const GeometrySamples<D>& whole, IsWanted&& is_wanted) {
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        GeometrySamples<D> part;
        for (const auto& [entity, begin, end] : whole.entities) {
            if (!is_wanted(entity)) continue;
            part.begin(entity);
            for (std::size_t i = begin; i < end; ++i) part.add(whole.points[i], whole.weights[i]);
        }
        return part;
    });
}

/// What is done about vertices of the boundary that are off the model.
enum class CadVertices : std::uint8_t { keep, move };
[[nodiscard]] constexpr auto words(CadVertices) {
    return words_of(Word{CadVertices::keep, "keep"}, Word{CadVertices::move, "move"});
}

/// Vertices where they are brought onto the model.
template <int D>
struct VerticesOnModel {
    Column<Vec<D>> points;   ///< of all vertices
    std::size_t moved = 0;   ///< that are elsewhere than they were
    std::size_t held = 0;    ///< of those that were off: short of their places, which an element does not allow
    double largest = 0;      ///< of the moves
    VertexId farthest = {};  ///< that made it
};

/// Moves vertices of facets on the model, each to the nearest point of what it lies on: of the model's vertex where
/// three faces (in 2D two curves) meet, of its edge where two do, else of the virtual face; at the end of the part that
/// is on the model of that face's rim, or, beside a surface that `geometry` (the model with those) prescribes, of the
/// curve of both. No element keeps less than a fifth of its volume, no facet less than a fifth of its area seen along
/// its normal: where one would, its vertices go half of the way, six times, and then not at all. Required vertices
/// stay. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VerticesOnModel<D>> vertices_onto(const CadModel& model, const CadAssociation& association,
                                                        const LinearMesh<D>& mesh, const Geometry<D>& geometry,
                                                        const Execution& execution);

/// Checks that the mesh belongs to the model. Errors (input): too many of its vertices are off a face or an edge
/// (CadAssociation::misfit); the farthest is named, with its distance, the number of vertices that are off, and how to
/// move them onto the model, unless `vertices` says that they were moved.
template <int D>
[[nodiscard]] Outcome<Done> check_vertices(const CadAssociation& association, CadVertices vertices);

}  // namespace camber

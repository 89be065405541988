module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.cad:association;
import camber.core;
import camber.surface;
import :model;

export namespace camber {

/// Of a facet that is not on the model.
inline constexpr std::uint32_t no_face = 0xffffffffU;

/// A face (in 2D an edge) or an edge of a model off which too many vertices of a mesh are.
struct CadMisfit {
    bool is_edge = false;  ///< of the model, between two faces; in 2D edges take the part of faces
    std::size_t number = 0;
    VertexFit fit;
};

/// Facets of a mesh that span a ridge of the model: some of their vertices lie beyond it on another face.
struct FacetsAcrossRidges {
    std::size_t count = 0;
    FacetId first = {};
    Vec<3> place;  ///< on the ridge; in 2D at z = 0
};

/// Which face of a CAD model each facet of a mesh stands for. In 2D the model's edges take the part of faces, and its
/// vertices are where two of them meet.
struct CadAssociation {
    Column<std::uint32_t> faces;  ///< one a facet; no_face: that lies elsewhere
    /// Parameters of the point of its face that is nearest to the middle of each facet, where searches for others
    /// begin; in 2D none.
    Column<std::array<double, 2>> middles;
    /// The faces that facets of each reference lie on, both rising.
    std::vector<std::pair<Reference, std::vector<std::size_t>>> of_references;

    std::size_t facets = 0;  ///< on the model

    /// Edges of the mesh between facets of two faces, on the model's edge there, and vertices on vertices of the model
    /// where three faces or more meet; both rising. Some are smooth: the mesh alone does not tell them.
    std::vector<EdgeId> ridges;
    std::vector<VertexId> corners;

    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;  ///< entities that the mesh has something on
    std::size_t coincident_facets = 0;   ///< another face is at the same place, where solids touch: the first is taken
    std::size_t doubtful_facets = 0;     ///< another face fits them nearly as well, that is not joined to it
    std::size_t settled_facets = 0;      ///< of those: by what the sure ones of their reference lie on
    std::size_t doubtful_edges = 0;      ///< between facets of two faces that have no edge in common
    std::size_t doubtful_vertices = 0;   ///< where three faces or more meet, and the model has no vertex near
    std::size_t vertices = 0;            ///< of facets on the model
    std::size_t stray_vertices = 0;      ///< of those: farther from it than the longest edge around
    std::size_t torn_vertices = 0;       ///< between faces: as far from the edge or vertex that these have in common
    double largest_vertex_distance = 0;  ///< of a vertex of the boundary from its face, edge or vertex
    VertexId farthest_vertex = {};

    /// Faces that meet smoothly and that the mesh treats as one, each list rising: facets span them, or leave out a
    /// face among them.
    std::vector<std::vector<std::size_t>> joined;
    FacetsAcrossRidges across;
    std::optional<CadMisfit> misfit;  ///< the one that most vertices are off; none: the mesh belongs to the model
};

/// The face of each facet: that to which its vertices and its middle are nearest and its normal is nearest, of those in
/// doubt the one that the sure facets of the same reference and entity lie on, where that is one. Errors (input): more
/// than a tenth of the boundary is farther from the model than half of its edges or across its faces, or more than
/// half of a reference is (told by some facets of each, then by all vertices), with the unit in which it would lie
/// there; the model has no faces, in 2D it is not in a plane z = constant.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, const Execution& execution);

/// The same of a model of a part of the boundary: facets of the references `elsewhere` (rising) lie on something else.
/// The model may have more than the mesh, too.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, std::span<const Reference> elsewhere,
                                                const Execution& execution);

/// The model in the unit of the mesh's coordinates: its own if some facets of each reference lie on the model as it is,
/// else the only other unit in which they do. Where they lie there in none or in several, the model as it is, which
/// `associate` refuses. Errors: stopped, and as of in_unit.
template <int D>
[[nodiscard]] Outcome<CadModel> in_unit_of(const LinearMesh<D>& mesh, const CadModel& model,
                                           std::span<const Reference> elsewhere, const Execution& execution);

/// Returns the references of facets that lie within one material and not on the model, rising: each of these facets has
/// elements of one and the same reference on both sides, and more than half of some of them have a corner farther from
/// the model than `off_limit` of their longest side. The model need not know of such facets: they are sheets (2D:
/// lines) that somebody put into the mesh. Facets of the references `elsewhere` (rising) are left out. Errors: stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<std::vector<Reference>> references_within_materials(const LinearMesh<D>& mesh,
                                                                          const CadModel& model,
                                                                          std::span<const Reference> elsewhere,
                                                                          const Execution& execution);

/// How well a face of a model fits a facet, in model units.
struct CadFit {
    std::size_t face = 0;
    double misfit = 0;  ///< 0: its vertices and its middle lie there, with its normal
    double second = 0;  ///< that of the next best face where it is at most twice as large; else more than that
    double other = 0;   ///< the same of the faces that do not meet the best one smoothly
    std::array<double, 2> middle{};  ///< parameters of the face's point nearest to the facet's middle; in 2D none
    bool has_twin = false;           ///< another face has the same points there; it does not count as the next best
};
/// The best of some faces (at least one); the lowest of those that are at one place, and of equally good ones.
[[nodiscard]] CadFit best_face(const CadModel& model, std::span<const std::size_t> faces,
                               const std::array<Vec<3>, 3>& corners);

/// The curve of the model where these faces (rising, at least two) meet that is nearest to these points, else the one
/// face's boundary curve that is. Where they have no edge in common, since solids that touch have edges of their own,
/// one of any of them through the points; nothing where there is none.
[[nodiscard]] std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                                      std::span<const Vec<3>> points);
/// The vertex of the model nearest to p among those of the edges of these faces; nothing where they have none.
[[nodiscard]] std::optional<std::size_t> vertex_between(const CadModel& model, std::span<const std::size_t> faces,
                                                        const Vec<3>& p);

}  // namespace camber

namespace camber {

/// Returns the faces (2D: edges) of the model that facets are on, each once, rising. Facets elsewhere have none.
[[nodiscard]] std::vector<std::size_t> faces_of(const CadAssociation& association, std::span<const FacetId> facets);

}  // namespace camber

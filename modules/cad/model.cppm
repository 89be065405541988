module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.cad:model;
import camber.core;
import camber.surface;

namespace camber {
struct CadParts;
}  // namespace camber

export namespace camber {

/// Unit of a mesh. `automatic`: determined from the mesh's boundary (`in_unit_of`); without a mesh, the file's unit.
enum class CadUnit : std::uint8_t { automatic, file, m, cm, mm, um, in, ft };
[[nodiscard]] constexpr auto words(CadUnit) {
    return words_of(Word{CadUnit::automatic, "auto"}, Word{CadUnit::file, "file"}, Word{CadUnit::m, "m"},
                    Word{CadUnit::cm, "cm"}, Word{CadUnit::mm, "mm"}, Word{CadUnit::um, "um"}, Word{CadUnit::in, "in"},
                    Word{CadUnit::ft, "ft"});
}
/// Length of a unit in millimetres; 0 for the file's unit.
[[nodiscard]] constexpr double millimetres_of(CadUnit unit) {
    switch (unit) {
        case CadUnit::automatic:
        case CadUnit::file: return 0;
        case CadUnit::m: return 1000;
        case CadUnit::cm: return 10;
        case CadUnit::mm: return 1;
        case CadUnit::um: return 1e-3;
        case CadUnit::in: return 25.4;
        case CadUnit::ft: return 304.8;
    }
    return 0;
}

struct CadOptions {
    CadUnit unit = CadUnit::automatic;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("unit", &CadOptions::unit,
                                 "unit of the mesh's coordinates, to which the model is converted. auto: the file's "
                                 "unit if the mesh's boundary then lies on the model, else the only unit for which it "
                                 "does; file: no conversion of the file's coordinates"));
    }
    friend bool operator==(const CadOptions&, const CadOptions&) = default;
};

/// Numbers of entities in the file that are missing in the model.
struct CadLosses {
    std::size_t faces = 0;        ///< faces that were not converted
    std::size_t entities = 0;     ///< entities whose transfer failed
    std::size_t open_shells = 0;  ///< open shells in solids
};

/// A CAD model: immutable, thread-safe. Faces, edges and vertices are numbered from 0, in the order of their first
/// visit in a walk through the file's shape. Edges without a curve (at a sphere's pole) are omitted.
class CadModel {
  public:
    explicit CadModel(std::shared_ptr<const CadParts> parts);

    [[nodiscard]] std::size_t faces() const;
    [[nodiscard]] std::size_t edges() const;
    [[nodiscard]] std::size_t vertices() const;
    [[nodiscard]] Box<3> bounds() const;
    [[nodiscard]] Vec<3> vertex(std::size_t vertex) const;
    /// Name of the unit in the file; empty if the file has none.
    [[nodiscard]] std::string file_unit() const;
    /// Unit of the model's coordinates: a word of `CadUnit`, or the name in the file.
    [[nodiscard]] std::string unit() const;
    [[nodiscard]] bool is_in_file_unit() const;
    [[nodiscard]] CadLosses losses() const;

    [[nodiscard]] const CadParts& parts() const { return *parts_; }

  private:
    std::shared_ptr<const CadParts> parts_;
};

[[nodiscard]] bool has_cad_support();

inline constexpr std::string_view cad_endings = ".step, .stp, .iges, .igs or .brep";

/// Reads a STEP, IGES or BREP file; the extension selects the format. Faces of IGES files are sewn at edges that
/// coincide within 1e-5 of the model's size. A file without a unit is in millimetres. Errors: other extension (usage);
/// no OpenCASCADE (unsupported); a broken file, or a file without faces and edges (input). On damaged files the library
/// may crash, hang or exhaust memory; read them in a separate process, with the functions below.
[[nodiscard]] Outcome<CadModel> read_cad(const std::string& path, const CadOptions& options);

/// Convert a model to bytes and back, in any unit. The restored model is bitwise equal. Both processes must run the
/// same version of Camber. Errors of `unpacked_cad`: those of `read_cad`.
[[nodiscard]] Outcome<std::string> packed_cad(const CadModel& model);
[[nodiscard]] Outcome<CadModel> unpacked_cad(const std::string& bytes, const CadOptions& options);

/// Converts a model to another unit. Errors: those of `unpacked_cad`.
[[nodiscard]] Outcome<CadModel> in_unit(const CadModel& model, CadUnit unit);

/// Closest point of a face or edge. On an edge `normal` is zero, and the first parameter is t.
struct CadFoot {
    Vec<3> point, normal;
    std::array<double, 2> parameters{};
    double distance = 0;
};

/// Returns the closest point of a face. If the closest point of the untrimmed surface is outside the face, returns the
/// closest point of the face's edges. The result is exact within rounding for points nearer than the radius of
/// curvature. A point on the face within rounding is returned unchanged.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p);

/// Starts the search at `near`, the parameters of a nearby point of the face. This is faster; the result is equal up to
/// rounding.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                      const std::array<double, 2>& near);

[[nodiscard]] CadFoot closest_on_edge(const CadModel& model, std::size_t edge, const Vec<3>& p);

/// Point at (u, v) with the outward unit normal (at poles: the normal's limit).
[[nodiscard]] EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv);
[[nodiscard]] EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t);

/// Returns the closest face to p, or the lowest of equally near faces. Empty without faces.
[[nodiscard]] std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces,
                                                      const Vec<3>& p);

/// Face number of facets off the model.
inline constexpr std::uint32_t no_face = 0xffffffffU;

/// A face or edge of the model from which too many mesh vertices are too far away.
struct CadFitError {
    bool is_edge = false;  ///< true: an edge between two faces; 2D: always false
    std::size_t number = 0;
    VertexFit fit;
};

/// Facets that cross a ridge of the model: some of their vertices are on a face on the other side of the ridge.
struct FacetsAcrossRidges {
    std::size_t count = 0;
    FacetId first = {};
    Vec<3> place;  ///< a point on the ridge; 2D: z = 0
};

/// Face of the model for each facet of a mesh. In 2D, edges have the role of faces, and corners are vertices where two
/// edges meet.
struct CadAssociation {
    Column<std::uint32_t> faces;  ///< one per facet; `no_face`: off the model
    /// For each facet: parameters of the face at the closest point to the facet's middle, where searches start. Unused
    /// in 2D.
    Column<std::array<double, 2>> middles;
    /// Each reference with the faces of its facets. Both are ascending.
    std::vector<std::pair<Reference, std::vector<std::size_t>>> of_references;

    std::size_t facets = 0;  ///< facets on the model

    /// `ridges`: mesh edges on a model edge between two faces. `corners`: mesh vertices on a model vertex of three or
    /// more faces. Both are ascending. Some model edges are smooth, so the mesh alone does not show them.
    std::vector<EdgeId> ridges;
    std::vector<VertexId> corners;

    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;  ///< number of model faces, edges and vertices on which
                                                                 ///< the mesh has facets, edges and vertices
    std::size_t coincident_facets = 0;   ///< facets that fit two coincident faces (touching solids); the first is used
    std::size_t ambiguous_facets = 0;    ///< facets that a second face, not joined to the best one, fits nearly as well
    std::size_t settled_facets = 0;      ///< ambiguous facets that got the face of the other facets of their reference
    std::size_t ambiguous_edges = 0;     ///< mesh edges between faces without a common edge
    std::size_t ambiguous_vertices = 0;  ///< mesh vertices between three or more faces, far from any model vertex
    std::size_t vertices = 0;            ///< vertices of facets on the model
    std::size_t off_vertices = 0;        ///< vertices farther from the model than their longest edge
    std::size_t detached_vertices = 0;   ///< vertices farther than their longest edge from the common edge or vertex of
                                         ///< their faces
    double largest_vertex_distance = 0;  ///< largest distance of a vertex from its model face, edge or vertex
    VertexId farthest_vertex = {};

    /// Lists of faces (ascending) that meet smoothly and count as one face: a facet spans them, or one of them has no
    /// facets.
    std::vector<std::vector<std::size_t>> joined;
    FacetsAcrossRidges across;
    std::optional<CadFitError> fit_error;  ///< entity with the largest share of off vertices; empty: the mesh fits
};

/// Associates each facet with the face that fits its vertices, middle and normal best. A facet is ambiguous if two
/// faces fit it similarly well. It then gets the face that nearly all unambiguous facets of its reference and entity
/// have, if there is one.
///
/// Errors (input):
/// - More than a tenth of the sampled facets, or more than half of those of one reference, are off the model. Such
///   facets are farther from the model than half of their longest edge, or transverse to it.
/// - A vertex is detached, or more than a tenth of the vertices are off (see `CadAssociation`).
/// - The mesh has no boundary, or the model no faces. 2D: the model is not in a plane z = constant.
///
/// The error names the unit that would fit.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, const Execution& execution);

/// Associates facets with a model of only part of the boundary, or of more than the mesh. Facets with a reference in
/// `excluded` (ascending) get no face.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, std::span<const Reference> excluded,
                                                const Execution& execution);

/// Returns the model in the unit of the mesh. If the sampled facets of each reference lie on the model, it is
/// unchanged. Otherwise it is converted to the only other unit for which they do. If no unit or several units fit, it
/// is unchanged, and `associate` fails. Errors: stopped, and those of `in_unit`.
template <int D>
[[nodiscard]] Outcome<CadModel> in_unit_of(const LinearMesh<D>& mesh, const CadModel& model,
                                           std::span<const Reference> excluded, const Execution& execution);

/// Returns the references (ascending) of facets inside one material and off the model, such as sheets (2D: lines) added
/// to the mesh. Each facet of such a reference has elements of equal reference on both sides. More than half of its
/// sampled facets have a corner farther from the model than `off_limit` times the longest side. `excluded`: references
/// (ascending) that are not tested. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::vector<Reference>> references_within_materials(const LinearMesh<D>& mesh,
                                                                          const CadModel& model,
                                                                          std::span<const Reference> excluded,
                                                                          const Execution& execution);

/// Fit of the best face to a facet (model units).
struct CadFit {
    std::size_t face = 0;
    double fit_error = 0;            ///< 0: vertices, middle and normal agree with the face
    double second = 0;               ///< fit error of the second-best face, exact up to twice `fit_error`
    double other = 0;                ///< like `second`, but without faces that meet the best one smoothly
    std::array<double, 2> middle{};  ///< parameters of the best face at the facet's middle; unused in 2D
    bool has_twin = false;           ///< another face coincides with the best one; it is not the second-best
};
/// Returns the best-fitting of these faces (at least one), or the lowest if several coincide or fit equally well.
[[nodiscard]] CadFit best_face(const CadModel& model, std::span<const std::size_t> faces,
                               const std::array<Vec<3>, 3>& corners);

/// Returns the edge of the model that is closest to the points. For a single face, it is one of this face's edges. For
/// several faces, it is a common edge of two faces: of the first pair, in ascending order, that has one. Touching
/// solids have separate edges, so faces may have no common edge. The result is then an edge of one face through the
/// points.
[[nodiscard]] std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                                      std::span<const Vec<3>> points);
[[nodiscard]] std::optional<std::size_t> vertex_between(const CadModel& model, std::span<const std::size_t> faces,
                                                        const Vec<3>& p);

}  // namespace camber

namespace camber {

/// Distinct faces (2D: edges) of the facets, ascending, without `no_face`.
[[nodiscard]] std::vector<std::size_t> faces_of(const CadAssociation& association, std::span<const FacetId> facets);

}  // namespace camber

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
/// Internal data: the library's kernel and search structures.
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
/// Millimetres of a unit; 0: the file's unit.
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

/// Parts of a file that the model lacks.
struct CadLosses {
    std::size_t faces = 0;        ///< that could not be converted
    std::size_t entities = 0;     ///< with failed transfer
    std::size_t open_shells = 0;  ///< open shells in solids
};

/// A CAD model: immutable, thread-safe. Faces, edges and vertices are numbered from 0 in the order of a walk through
/// the file's shape. Edges without a curve (at a sphere's pole) are omitted.
class CadModel {
  public:
    explicit CadModel(std::shared_ptr<const CadParts> parts);

    [[nodiscard]] std::size_t faces() const;
    [[nodiscard]] std::size_t edges() const;
    [[nodiscard]] std::size_t vertices() const;
    [[nodiscard]] Box<3> bounds() const;
    [[nodiscard]] Vec<3> vertex(std::size_t vertex) const;
    /// The file's name for it; empty: none.
    [[nodiscard]] std::string file_unit() const;
    /// Unit of coordinates: a word of CadUnit, else the file's name.
    [[nodiscard]] std::string unit() const;
    [[nodiscard]] bool is_in_file_unit() const;
    [[nodiscard]] CadLosses losses() const;

    [[nodiscard]] const CadParts& parts() const { return *parts_; }

  private:
    std::shared_ptr<const CadParts> parts_;
};

/// True if this build can read CAD files.
[[nodiscard]] bool knows_cad();

/// File extensions, for messages.
inline constexpr std::string_view cad_endings = ".step, .stp, .iges, .igs or .brep";

/// Reads a STEP, IGES or BREP file, by its extension. Faces of IGES files are sewn at edges that coincide within 1e-5
/// of the size. Without a unit the file is in millimetres. Errors: other extension (usage); no OpenCASCADE
/// (unsupported); a broken file, or one without faces and edges (input). On damaged files the library may crash, hang
/// or exhaust memory; a separate process with the functions below is safe.
[[nodiscard]] Outcome<CadModel> read_cad(const std::string& path, const CadOptions& options);

/// Model as bytes and back: bitwise equal in any unit, for processes of one version. Errors of `unpacked_cad`: as
/// `read_cad`.
[[nodiscard]] Outcome<std::string> packed_cad(const CadModel& model);
[[nodiscard]] Outcome<CadModel> unpacked_cad(const std::string& bytes, const CadOptions& options);

/// Errors: as `unpacked_cad`.
[[nodiscard]] Outcome<CadModel> in_unit(const CadModel& model, CadUnit unit);

/// Closest point of a face or edge. On an edge `normal` is zero, and t is the first parameter.
struct CadFoot {
    Vec<3> point, normal;
    std::array<double, 2> parameters{};
    double distance = 0;
};

/// Closest point of a face; if the foot on the whole surface is outside, that of the face's edges. Exact within
/// rounding for points nearer than the radius of curvature. Points on the face within rounding are returned bit for
/// bit.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p);

/// Faster with parameters of a nearby point of the face; equal up to rounding.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                      const std::array<double, 2>& near);

[[nodiscard]] CadFoot closest_on_edge(const CadModel& model, std::size_t edge, const Vec<3>& p);

/// Point at (u, v) with the outward unit normal (at poles: its limit).
[[nodiscard]] EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv);
[[nodiscard]] EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t);

/// The lowest of equally near ones; empty if there are none.
[[nodiscard]] std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces,
                                                      const Vec<3>& p);

/// Facet off the model.
inline constexpr std::uint32_t no_face = 0xffffffffU;

/// A face or edge of the model that too many vertices of the mesh are off.
struct CadMisfit {
    bool is_edge = false;  ///< between two faces; in 2D edges are faces
    std::size_t number = 0;
    VertexFit fit;
};

/// Facets across a ridge of the model: some of their vertices are on another face.
struct FacetsAcrossRidges {
    std::size_t count = 0;
    FacetId first = {};
    Vec<3> place;  ///< on the ridge; 2D: z = 0
};

/// Face of the model for each facet of a mesh. In 2D, edges have the role of faces, and vertices are where two of them
/// meet.
struct CadAssociation {
    Column<std::uint32_t> faces;  ///< one a facet, or no_face
    /// Parameters on the face closest to each facet's middle, as search starts; unused in 2D.
    Column<std::array<double, 2>> middles;
    /// Faces by reference, both rising.
    std::vector<std::pair<Reference, std::vector<std::size_t>>> of_references;

    std::size_t facets = 0;  ///< on the model

    /// Mesh edges between two faces, on the model's edge, and mesh vertices on vertices of three or more faces; both
    /// rising. Some are smooth, so not visible in the mesh.
    std::vector<EdgeId> ridges;
    std::vector<VertexId> corners;

    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;  ///< entities used by the mesh
    std::size_t coincident_facets = 0;   ///< another face coincides (touching solids); the first is used
    std::size_t doubtful_facets = 0;     ///< another face, not joined to it, fits nearly as well
    std::size_t settled_facets = 0;      ///< doubtful ones, settled by sure facets of their reference
    std::size_t doubtful_edges = 0;      ///< between faces without a common edge
    std::size_t doubtful_vertices = 0;   ///< between three or more faces, without a near model vertex
    std::size_t vertices = 0;            ///< vertices of facets on the model
    std::size_t stray_vertices = 0;      ///< farther from it than the longest edge at them
    std::size_t torn_vertices = 0;       ///< that far from the common edge or vertex of their faces
    double largest_vertex_distance = 0;  ///< from face, edge or vertex
    VertexId farthest_vertex = {};

    /// Smoothly meeting faces that the mesh treats as one (each list rising): facets span them, or omit one among them.
    std::vector<std::vector<std::size_t>> joined;
    FacetsAcrossRidges across;
    std::optional<CadMisfit> misfit;  ///< with most vertices off; empty: the mesh fits
};

/// Associates each facet with the face that fits its vertices, middle and normal best. Doubtful facets get the face of
/// the sure facets of their reference and entity, if unique.
///
/// Errors (input): of sampled facets, more than a tenth, or half of a reference, is farther from the model than half of
/// its edges or transverse to it; of all vertices, any is torn, or more than a tenth are stray. The error names the
/// unit that would fit. Also: no faces; 2D: not in a plane z = constant.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, const Execution& execution);

/// For a model of part of the boundary, or more than the mesh: facets of references in `elsewhere` (rising) are not on
/// it.
template <int D>
[[nodiscard]] Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const CadModel& model, std::span<const Reference> elsewhere,
                                                const Execution& execution);

/// Returns the model in the mesh's unit: unchanged if sampled facets of each reference fit, else in the only other unit
/// that fits. If none or several fit, unchanged (`associate` then fails). Errors: stopped, and as `in_unit`.
template <int D>
[[nodiscard]] Outcome<CadModel> in_unit_of(const LinearMesh<D>& mesh, const CadModel& model,
                                           std::span<const Reference> elsewhere, const Execution& execution);

/// References (rising) of facets within one material and off the model, for example sheets (2D: lines) added to the
/// mesh. All their facets have elements of equal reference on both sides. Over half of the sampled ones have a corner
/// farther from the model than `off_limit` of their longest side. `elsewhere` (rising) is excluded. Errors: stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<std::vector<Reference>> references_within_materials(const LinearMesh<D>& mesh,
                                                                          const CadModel& model,
                                                                          std::span<const Reference> elsewhere,
                                                                          const Execution& execution);

/// Fit of a face to a facet (model units).
struct CadFit {
    std::size_t face = 0;
    double misfit = 0;               ///< 0: same vertices, middle and normal
    double second = 0;               ///< misfit of the second-best face, exact up to twice `misfit`
    double other = 0;                ///< the same among faces that do not meet the best one smoothly
    std::array<double, 2> middle{};  ///< parameters at the facet's middle; unused in 2D
    bool has_twin = false;           ///< a coincident face exists; it does not count as second
};
/// Best of at least one face; the lowest of coincident or equally good ones.
[[nodiscard]] CadFit best_face(const CadModel& model, std::span<const std::size_t> faces,
                               const std::array<Vec<3>, 3>& corners);

/// Closest common edge of these faces (rising, at least two), or of one face's rim, to these points. Touching solids
/// have separate edges: without a common edge, any of their edges through the points.
[[nodiscard]] std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                                      std::span<const Vec<3>> points);
/// Closest vertex at edges of these faces.
[[nodiscard]] std::optional<std::size_t> vertex_between(const CadModel& model, std::span<const std::size_t> faces,
                                                        const Vec<3>& p);

}  // namespace camber

namespace camber {

/// Distinct faces (2D: edges) of facets, rising, without `no_face`.
[[nodiscard]] std::vector<std::size_t> faces_of(const CadAssociation& association, std::span<const FacetId> facets);

}  // namespace camber

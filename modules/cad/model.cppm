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
/// What a model is made of: the library's kernel, and what searches begin with.
struct CadParts;
}  // namespace camber

export namespace camber {

/// The length that is 1 in a mesh. `automatic`: found by the mesh's boundary (in_unit_of); a model that is read
/// without a mesh is in the unit of its file.
enum class CadUnit : std::uint8_t { automatic, file, m, cm, mm, um, in, ft };
[[nodiscard]] constexpr auto words(CadUnit) {
    return words_of(Word{CadUnit::automatic, "auto"}, Word{CadUnit::file, "file"}, Word{CadUnit::m, "m"},
                    Word{CadUnit::cm, "cm"}, Word{CadUnit::mm, "mm"}, Word{CadUnit::um, "um"}, Word{CadUnit::in, "in"},
                    Word{CadUnit::ft, "ft"});
}
/// Millimetres of a unit; 0: the unit of the file.
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
                                 "the unit of the mesh's coordinates, to which the model is converted; auto: that of "
                                 "the file if the mesh's boundary lies on the model in it, else the only unit in which "
                                 "it does; file: coordinates are as the file has them"));
    }
    friend bool operator==(const CadOptions&, const CadOptions&) = default;
};

/// What a file has and the model made of it has not.
struct CadLosses {
    std::size_t faces = 0;        ///< that no face could be made of
    std::size_t entities = 0;     ///< whose transfer failed
    std::size_t open_shells = 0;  ///< of solids
};

/// A CAD model, an immutable value that any number of threads may ask. Faces, edges and vertices are numbered from 0 in
/// the order in which a walk through the file's shape meets them first; edges without a curve (at the pole of a sphere)
/// are left out.
class CadModel {
  public:
    explicit CadModel(std::shared_ptr<const CadParts> parts);

    [[nodiscard]] std::size_t faces() const;
    [[nodiscard]] std::size_t edges() const;
    [[nodiscard]] std::size_t vertices() const;
    [[nodiscard]] Box<3> bounds() const;
    [[nodiscard]] Vec<3> vertex(std::size_t vertex) const;
    /// As the file calls it; empty: it says none.
    [[nodiscard]] std::string file_unit() const;
    /// The unit of the model's coordinates: its word in CadUnit, else as the file calls it.
    [[nodiscard]] std::string unit() const;
    /// Whether the coordinates are as the file has them.
    [[nodiscard]] bool is_in_file_unit() const;
    [[nodiscard]] CadLosses losses() const;

    [[nodiscard]] const CadParts& parts() const { return *parts_; }

  private:
    std::shared_ptr<const CadParts> parts_;
};

/// Whether this build of Camber can read CAD files at all.
[[nodiscard]] bool knows_cad();

/// The endings of files that are read, as messages list them.
inline constexpr std::string_view cad_endings = ".step, .stp, .iges, .igs or .brep";

/// The model of a file: STEP, IGES or BREP, by its ending. (The reader takes a path, not bytes: so does the library
/// that it stands on.) Faces of an IGES file are sewn together at edges that coincide within 1e-5 of the size. A file
/// that says no unit counts as one in millimetres. Errors: of another ending (usage); OpenCASCADE is not there
/// (unsupported); broken, or without a face and without an edge (input).
/// The library may crash, run without end or take all memory on a file that is damaged: where that matters, read in
/// another process and hand the model over by the two below, as the program does.
[[nodiscard]] Outcome<CadModel> read_cad(const std::string& path, const CadOptions& options);

/// A model as bytes, and the model of such bytes: the same, to the last bit, in any unit. They are for a process of the
/// same version. Errors: of the second, as of read_cad.
[[nodiscard]] Outcome<std::string> packed_cad(const CadModel& model);
[[nodiscard]] Outcome<CadModel> unpacked_cad(const std::string& bytes, const CadOptions& options);

/// The same model in another unit. Errors: as of unpacked_cad.
[[nodiscard]] Outcome<CadModel> in_unit(const CadModel& model, CadUnit unit);

/// The point of a face or an edge nearest to a point; on an edge `normal` is zero, and t the first parameter.
struct CadFoot {
    Vec<3> point, normal;
    std::array<double, 2> parameters{};
    double distance = 0;
};

/// The nearest point of a face: where the nearest of its whole surface is beyond the face's edges, that of the edges.
/// Within rounding, for points that are nearer to the face than its curvature turns away; a point that lies there but
/// for rounding stays as it is, to the last bit.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p);

/// The same with the parameters of a point of the face that is not far: found sooner, and equal up to rounding.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                      const std::array<double, 2>& near);

/// The nearest point of an edge, its ends included.
[[nodiscard]] CadFoot closest_on_edge(const CadModel& model, std::size_t edge, const Vec<3>& p);

/// The point of a face at (u, v), with the unit normal out of the model; at a pole of the surface that of its limit.
[[nodiscard]] EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv);
[[nodiscard]] EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t);

/// The nearest of some faces, the lowest of equally near ones; nothing of none.
[[nodiscard]] std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces,
                                                      const Vec<3>& p);

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

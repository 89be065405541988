module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad:parts;
import camber.core;
import camber.box_tree;
import camber.surface;
import :geometry;
import :model;

namespace camber {

/// Parameter range of a part of a face, or of an edge (first parameter only).
struct Cell {
    std::array<double, 2> low{}, high{};
};

struct OrientedBox {
    Vec<3> centre;
    std::array<Vec<3>, 3> axes{};
    std::array<double, 3> half{};  ///< half lengths along the axes

    [[nodiscard]] double distance_squared(const Vec<3>& p) const {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double beyond = std::abs(dot(p - centre, axes[k])) - half[k];
            if (beyond > 0) sum += beyond * beyond;
        }
        return sum;
    }
};

struct EntityCells {
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    std::vector<OrientedBox> oriented;  ///< for faces: boxes along the tangent plane, tighter for thin oblique cells
    BoxTree<3> tree;
    Box<3> bounds;  ///< box of sampled points
    Box<3> reach;   ///< box that encloses the entity
};

/// Groups of faces (2D: edges) that meet smoothly. Each group is a virtual face.
struct VirtualFaces {
    std::vector<std::uint32_t> groups;             ///< one per face: lowest face of its group
    std::vector<std::vector<std::size_t>> beside;  ///< one per face: smooth neighbours, ascending

    [[nodiscard]] bool are_joined(std::size_t a, std::size_t b) const { return groups[a] == groups[b]; }
};

struct CadParts {
    std::unique_ptr<const occ::Kernel> kernel;
    std::vector<EntityCells> faces, edges;
    BoxTree<3> tree_of_faces;  ///< over the boxes `reach`
    VirtualFaces virtual_faces, virtual_curves;
    Box<3> bounds;  ///< box of all faces; without faces, of all edges
    Box<3> of_edges;
    double size = 0;  ///< diagonal of `bounds`
};

/// Returns a lower bound of the distance of p from the face, from boxes of cells.
[[nodiscard]] double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p);

/// Computes distances from a face, equal to those of `closest_on_face` up to rounding. Each search starts at an earlier
/// closest point, so pass neighbouring points consecutively.
class FaceDistances {
  public:
    /// `start`: parameters near the first point, or null.
    FaceDistances(const CadModel& model, std::size_t face, const std::array<double, 2>* start);

    [[nodiscard]] double distance(const Vec<3>& p);
    /// Distance of p if it exceeds `bound`, else empty (usually without a search).
    [[nodiscard]] std::optional<double> distance_beyond(double bound, const Vec<3>& p);
    [[nodiscard]] std::size_t searches() const { return searches_; }

  private:
    struct Place {
        Vec<3> from;  ///< point that was projected to this place
        std::array<double, 2> uv{};
        occ::SurfaceJet jet{};
    };
    [[nodiscard]] bool is_surface_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool is_face_within(double bound, const Vec<3>& p, const std::array<double, 2>& uv);
    [[nodiscard]] bool is_edge_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool search_edge_within(double bound, const Vec<3>& p);
    void set_start(const Vec<3>& p);
    void remember(const Place& place);
    [[nodiscard]] Place place_at(const Vec<3>& from, const std::array<double, 2>& uv) const;

    const CadModel* model_;
    std::size_t face_;
    std::optional<Place> last_, first_of_row_;
    std::optional<std::size_t> edge_;  ///< last edge that contained a closest point
    double on_edge_ = 0;
    std::size_t searches_ = 0;
};

[[nodiscard]] EntityCells cells_of_face(const occ::Kernel& kernel, std::size_t face);
[[nodiscard]] EntityCells cells_of_edge(const occ::Kernel& kernel, std::size_t edge);

[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format format,
                                                                      double millimetres);

[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string& bytes, double millimetres);

[[nodiscard]] inline Vec<3> vec(const occ::Point& p) { return {p}; }

/// Two faces fit similarly well if their fit errors differ at most by this factor.
inline constexpr double ambiguity_ratio = 2;

/// Largest distance between matching entities of mesh and model, divided by the length of a mesh edge. For boxes, the
/// distance is divided by the box's diagonal.
inline constexpr double match_tolerance = 0.1;

/// Vertices farther from the model than this times their longest edge are off the model. Smaller distances may be due
/// to omitted fillets.
inline constexpr double stray_limit = 1;

/// Largest distance of coincident points: the accuracy with which a model's edges fit its faces.
[[nodiscard]] inline double coincidence_tolerance(const CadParts& parts) { return 1e-6 * parts.size; }

/// Checks for `associate` on sampled facets (`check_sample`) and on all vertices (`check_part`).
template <int D>
[[nodiscard]] Outcome<Done> check_sample(const LinearMesh<D>& mesh, const CadModel& model,
                                         std::span<const std::size_t> candidates, std::span<const Reference> excluded,
                                         const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> check_part(const LinearMesh<D>& mesh, const CadModel& model,
                                       const CadAssociation& association);

template <int D, std::size_t N>
[[nodiscard]] double longest_side(const std::array<Vec<D>, N>& facet) {
    double longest = 0;
    for (std::size_t i = 0; i < N; ++i) longest = std::max(longest, distance(facet[i], facet[(i + 1) % N]));
    return longest;
}

/// Bound on rounding errors of distances.
[[nodiscard]] inline double rounding(const CadParts& parts, const Vec<3>& p) { return 1e-15 * (parts.size + norm(p)); }

}  // namespace camber

/// Virtual faces: groups of faces that meet smoothly. Meshers merge sliver and split faces, so facets can span several.
namespace camber {

/// Largest angle (degrees) between the normals of smooth neighbours along their edge (2D: between tangents).
inline constexpr double smooth_angle_degrees = 3;

[[nodiscard]] VirtualFaces virtual_faces(const occ::Kernel& kernel);
[[nodiscard]] VirtualFaces virtual_curves(const occ::Kernel& kernel);

/// Returns true for a face in which a search may continue.
using MayTake = std::function<bool(std::size_t)>;

struct VirtualFoot {
    std::size_t face = 0;
    CadFoot foot;
    std::vector<std::size_t> through = {};  ///< faces that the search passed through before it reached `face`
};
/// Returns the closest point to p of the virtual face that contains `face`. The search starts in `face`. At a rim it
/// continues in smooth neighbours that are nearer.
[[nodiscard]] VirtualFoot closest_on_virtual_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                                  const MayTake& may_take = {});
/// In 2D curves have the role of faces.
struct VirtualCurveFoot {
    std::size_t face = 0;
    CadCurveFoot foot;
    std::vector<std::size_t> through = {};
};

[[nodiscard]] VirtualCurveFoot closest_on_virtual_face(const CadModel& model, std::size_t curve, const Vec<2>& p,
                                                       const MayTake& may_take = {});

/// Model entity where mesh facets on two or more faces meet.
struct Junction {
    enum class On { nothing, face, edge, vertex };

    On on = On::nothing;
    std::size_t number = 0;
    double distance = 0;           ///< largest distance of a point from the entity
    bool is_within_group = false;  ///< not on an edge; all faces belong to one virtual face
    bool is_chain = false;         ///< true: a chain of edges; `number` is the edge nearest to the middle of the points
};
/// Points within these distances count as on an edge or vertex. `ridge`: for sharp model edges; `smooth`: for edges at
/// which faces meet smoothly.
struct Reach {
    double ridge = 0, smooth = 0;
};
/// Largest distance between a smooth model edge and a mesh edge that follows it, divided by the length of the mesh
/// edge.
inline constexpr double smooth_reach = 0.005;
[[nodiscard]] inline Reach reach_along(const std::array<Vec<3>, 2>& ends) {
    const double length = distance(ends[0], ends[1]);
    return {match_tolerance * length, smooth_reach * length};
}

/// Returns the entity where two or more faces (ascending) meet. It is the first of these that exists:
/// - The edge between the faces, if all points are within reach and no chain (see below) is nearer.
/// - For one virtual face: its face nearest to the middle of the points.
/// - For two virtual faces: the chain of edges between them, if within reach.
/// - The closest edge between two of the faces, beyond reach.
[[nodiscard]] Junction junction_at(const CadModel& model, std::span<const std::size_t> faces,
                                   std::span<const Vec<3>> points, const Reach& reach);
/// Like `junction_at`, for a mesh vertex at p. For more than two faces, it is the first of these that exists:
/// - The closest model vertex, if within reach. For one or two virtual faces, `Reach::smooth` is the limit.
/// - For one or two virtual faces: the result of `junction_at`, unless it is an edge beyond reach.
/// - The closest model vertex, beyond reach.
[[nodiscard]] Junction junction_at_vertex(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p,
                                          const Reach& reach);
/// Returns the closest edge to p where exactly the virtual faces of `faces` meet. Searches the edges of `faces` and of
/// faces at most two smooth edges away.
[[nodiscard]] std::optional<std::size_t> chain_edge(const CadModel& model, std::span<const std::size_t> faces,
                                                    const Vec<3>& p);

/// Sets `joined` and `across` of `association`. `fits`: one per facet. `pairs`: the two faces at each mesh edge (2D:
/// vertex) inside a virtual face. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> find_spans(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                                       std::span<const std::array<std::size_t, 2>> pairs, const Execution& execution,
                                       CadAssociation& association);

/// Returns the number of each face's list in `CadAssociation::joined`, or `no_face`.
[[nodiscard]] std::vector<std::uint32_t> joined_lists(const CadAssociation& association, std::size_t faces);

template <int D>
[[nodiscard]] const VirtualFaces& virtual_faces_of(const CadParts& parts) {
    if constexpr (D == 2)
        return parts.virtual_curves;
    else
        return parts.virtual_faces;
}

}  // namespace camber

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
    Box<3> bounds;  ///< box of the samples
    Box<3> reach;   ///< encloses the entity
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
    Box<3> bounds;  ///< bounds of faces, else of edges
    Box<3> of_edges;
    double size = 0;  ///< bounds' diagonal
};

/// Lower bound of the distance, from boxes of cells.
[[nodiscard]] double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p);

/// Computes distances from a face, equal to those of `closest_on_face` up to rounding. Each search starts at an earlier
/// closest point: pass neighbouring points consecutively.
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
        Vec<3> from;  ///< point whose closest point this is
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
    std::optional<std::size_t> edge_;  ///< last edge with a closest point
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

/// Largest distance of a match, as a share of the length of a mesh edge (boxes: of the diagonal).
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

/// True for a face in which the search may continue.
using MayTake = std::function<bool(std::size_t)>;

struct VirtualFoot {
    std::size_t face = 0;
    CadFoot foot;
    std::vector<std::size_t> through = {};  ///< faces that the search passed before
};
/// Closest point of the virtual face of `face`, where the search starts. While the closest point is on a rim, the
/// search continues in smooth neighbours if they are nearer.
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

/// Model entity of points between facets on two or more faces.
struct Junction {
    enum class On { nothing, face, edge, vertex };

    On on = On::nothing;
    std::size_t number = 0;
    double distance = 0;           ///< largest distance of the points
    bool is_within_group = false;  ///< on no edge, between faces of one virtual face
    bool is_chain = false;         ///< chain of edges; `number` is the edge nearest to the middle
};
/// Largest distances that count as on an edge or vertex: where faces meet sharply, and smoothly.
struct Reach {
    double ridge = 0, smooth = 0;
};
/// Largest distance from a smooth model edge that a mesh edge follows, as a share of the mesh edge's length.
inline constexpr double smooth_reach = 0.005;
[[nodiscard]] inline Reach reach_along(const std::array<Vec<3>, 2>& ends) {
    const double length = distance(ends[0], ends[1]);
    return {match_tolerance * length, smooth_reach * length};
}

/// Returns the first of these entities that exists, for at least two faces (ascending):
/// - Edge between the faces within reach of all points.
/// - For one virtual face: its face nearest to the middle of the points.
/// - For two virtual faces: the chain of edges between them within reach.
/// - Closest edge between any of the faces, beyond reach.
[[nodiscard]] Junction junction_at(const CadModel& model, std::span<const std::size_t> faces,
                                   std::span<const Vec<3>> points, const Reach& reach);
/// Like `junction_at`, for a mesh vertex. With more than two faces, a model vertex within reach comes first (within one
/// or two virtual faces, within the smooth reach). With three or more virtual faces, or if the edge found is beyond
/// reach, the result is the closest vertex.
[[nodiscard]] Junction junction_at_vertex(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p,
                                          const Reach& reach);
/// Closest edge between the virtual faces of these faces. Searches edges of faces at most two smooth edges away.
[[nodiscard]] std::optional<std::size_t> chain_edge(const CadModel& model, std::span<const std::size_t> faces,
                                                    const Vec<3>& p);

/// Sets joined faces and facets across ridges in `association`. `fits`: one per facet. `pairs`: faces on both sides of
/// mesh edges (2D: vertices) inside virtual faces. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> find_spans(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                                       std::span<const std::array<std::size_t, 2>> pairs, const Execution& execution,
                                       CadAssociation& association);

/// For each face, the number of its list in `joined`, or `no_face`.
[[nodiscard]] std::vector<std::uint32_t> joined_lists(const CadAssociation& association, std::size_t faces);

template <int D>
[[nodiscard]] const VirtualFaces& virtual_faces_of(const CadParts& parts) {
    if constexpr (D == 2)
        return parts.virtual_curves;
    else
        return parts.virtual_faces;
}

}  // namespace camber

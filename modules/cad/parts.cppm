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

/// A piece of a face's or an edge's parameters: of an edge the first alone.
struct Cell {
    std::array<double, 2> low{}, high{};
};

/// A box along three orthonormal axes.
struct OrientedBox {
    Vec<3> centre;
    std::array<Vec<3>, 3> axes{};
    std::array<double, 3> half{};  ///< half of its length along each axis

    [[nodiscard]] double distance_squared(const Vec<3>& p) const {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double beyond = std::abs(dot(p - centre, axes[k])) - half[k];
            if (beyond > 0) sum += beyond * beyond;
        }
        return sum;
    }
};

/// The pieces of one entity, and boxes that hold what lies on them.
struct EntityCells {
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    std::vector<OrientedBox> oriented;  ///< of a face, along its tangent plane: tighter for thin cells askew
    BoxTree<3> tree;
    Box<3> bounds;  ///< of samples
    Box<3> reach;   ///< beyond all of it
};

/// Groups of faces (in a plane: of edges) that meet smoothly: one virtual face each.
struct VirtualFaces {
    std::vector<std::uint32_t> groups;             ///< of each face, the number of the lowest face of its group
    std::vector<std::vector<std::size_t>> beside;  ///< of each face those that it meets smoothly, rising

    [[nodiscard]] bool are_joined(std::size_t a, std::size_t b) const { return groups[a] == groups[b]; }
};

struct CadParts {
    std::unique_ptr<const occ::Kernel> kernel;
    std::vector<EntityCells> faces, edges;
    BoxTree<3> tree_of_faces;  ///< over their `reach`
    VirtualFaces virtual_faces, virtual_curves;
    Box<3> bounds;  ///< of the faces; of the edges where there is none
    Box<3> of_edges;
    double size = 0;  ///< the diagonal of the bounds
};

/// Lower bound of the distance from p to a face, by the boxes of its cells.
[[nodiscard]] double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p);

/// How far points are from a face: a search starts at the parameters of the nearest of the last points, so that
/// consecutive points should be neighbours. Distances are those of closest_on_face up to rounding.
class FaceWalk {
  public:
    /// `start`: parameters of a point of the face that is not far from the first one; null: not known.
    FaceWalk(const CadModel& model, std::size_t face, const std::array<double, 2>* start);

    [[nodiscard]] double distance(const Vec<3>& p);
    /// Whether p is farther away than a bound: its distance then. Nothing where some point of the face is near enough,
    /// which costs no search as a rule.
    [[nodiscard]] std::optional<double> distance_beyond(double bound, const Vec<3>& p);
    /// Number of searches of distance_beyond.
    [[nodiscard]] std::size_t searches() const { return searches_; }

  private:
    struct Place {
        Vec<3> from;  ///< the point whose foot is there
        std::array<double, 2> uv{};
        occ::SurfaceJet jet{};
    };
    [[nodiscard]] bool is_surface_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool is_face_within(double bound, const Vec<3>& p, const std::array<double, 2>& uv);
    [[nodiscard]] bool is_edge_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool leads_within(double bound, const Vec<3>& p);
    void go_near(const Vec<3>& p);
    void remember(const Place& place);
    [[nodiscard]] Place place_at(const Vec<3>& from, const std::array<double, 2>& uv) const;

    const CadModel* model_;
    std::size_t face_;
    std::optional<Place> last_, first_of_row_;
    std::optional<std::size_t> edge_;  ///< on which the search for the last point that is not on the face ended
    double on_edge_ = 0;
    std::size_t searches_ = 0;
};

[[nodiscard]] EntityCells cells_of_face(const occ::Kernel& kernel, std::size_t face);
[[nodiscard]] EntityCells cells_of_edge(const occ::Kernel& kernel, std::size_t edge);

/// A kernel, or why there is none.
[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format format,
                                                                      double millimetres);

[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string& bytes, double millimetres);

[[nodiscard]] inline Vec<3> vec(const occ::Point& p) { return {p}; }

/// A face fits nearly as well as the best one if its misfit is at most so many times that of the best.
inline constexpr double doubt = 2;

/// A place farther away than this share of the facets' size is none.
inline constexpr double near_enough = 0.1;

/// A vertex farther away than so many of the longest edge around is not on the model; one nearer may be so since the
/// mesh leaves out fillets that the model has.
inline constexpr double astray = 1;

/// Points at most so far apart are one: so well do edges and faces of a model fit each other.
[[nodiscard]] inline double at_one_place(const CadParts& parts) { return 1e-6 * parts.size; }

/// See associate: before faces are known, by some facets of each reference; and after, by all vertices.
template <int D>
[[nodiscard]] Outcome<Done> check_sample(const LinearMesh<D>& mesh, const CadModel& model,
                                         std::span<const std::size_t> candidates, std::span<const Reference> elsewhere,
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

/// Distances that rounding alone makes.
[[nodiscard]] inline double rounding(const CadParts& parts, const Vec<3>& p) { return 1e-15 * (parts.size + norm(p)); }

}  // namespace camber

/// Faces that meet smoothly as one virtual face: meshers merge sliver faces and split faces, so that facets span them.
namespace camber {

/// Faces that meet at an edge are joined if their normals differ by at most this angle along all of the edge (in a
/// plane: edges at a vertex, by their tangents).
inline constexpr double smooth_angle_degrees = 3;

[[nodiscard]] VirtualFaces virtual_faces(const occ::Kernel& kernel);
[[nodiscard]] VirtualFaces virtual_curves(const occ::Kernel& kernel);

/// Whether a face may be taken in place of one that it meets smoothly.
using MayTake = std::function<bool(std::size_t)>;

/// The nearest point of a virtual face, and the face that it lies on.
struct VirtualFoot {
    std::size_t face = 0;
    CadFoot foot;
    std::vector<std::size_t> through = {};  ///< faces on the way there
};
/// The point near p of the virtual face that has `face`: where the nearest point of a face is on its rim, the search
/// goes on in those that it meets smoothly there, as long as they are nearer.
[[nodiscard]] VirtualFoot closest_on_virtual_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                                  const MayTake& may_take = {});
/// The same in a plane, where curves take the part of faces.
struct VirtualCurveFoot {
    std::size_t face = 0;
    CadCurveFoot foot;
    std::vector<std::size_t> through = {};
};

[[nodiscard]] VirtualCurveFoot closest_on_virtual_face(const CadModel& model, std::size_t curve, const Vec<2>& p,
                                                       const MayTake& may_take = {});

/// Where a point lies, or all points of a list, between facets of two faces or more.
struct Junction {
    enum class On { nothing, face, edge, vertex };

    On on = On::nothing;
    std::size_t number = 0;
    double distance = 0;           ///< the largest of the points
    bool is_within_group = false;  ///< between faces of one virtual face, on no edge of the model
    bool is_chain = false;         ///< on a chain of edges; `number`: the one nearest to the middle of the points
};
/// Largest distances from edges and vertices of the model at which the model turns, and from smooth ones.
struct Reach {
    double ridge = 0, smooth = 0;
};
/// A mesh edge farther than this share of its length from a smooth edge of the model does not lie along it.
inline constexpr double smooth_reach = 0.005;
[[nodiscard]] inline Reach reach_along(const std::array<Vec<3>, 2>& ends) {
    const double length = distance(ends[0], ends[1]);
    return {near_enough * length, smooth_reach * length};
}

/// The edge of the model between these faces (rising, at least two) within reach of all points. Without one: of faces
/// of one virtual face the nearest to their middle; of faces of two virtual faces the chain of edges between these,
/// within reach of all points; else the nearest edge between any of the faces, farther away, if there is one.
[[nodiscard]] Junction junction_at(const CadModel& model, std::span<const std::size_t> faces,
                                   std::span<const Vec<3>> points, const Reach& reach);
/// The same at a vertex of the mesh: where three faces or more meet, the vertex of the model within reach comes first
/// (a smooth one between two virtual faces or within one); without one, and without an edge within reach, of three
/// virtual faces or more the nearest vertex.
[[nodiscard]] Junction junction_at_vertex(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p,
                                          const Reach& reach);
/// The edge nearest to p of the chain between the two virtual faces of these faces. The chain is searched for among the
/// edges of the faces and of those that are at most two smooth edges away.
[[nodiscard]] std::optional<std::size_t> chain_edge(const CadModel& model, std::span<const std::size_t> faces,
                                                    const Vec<3>& p);

/// Records in `association` which faces are joined, since facets span them, and the facets across ridges of the model.
/// `fits`: of each facet. `pairs`: faces on both sides of edges (in a plane: vertices) of the mesh within virtual
/// faces. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> find_spans(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                                       std::span<const std::array<std::size_t, 2>> pairs, const Execution& execution,
                                       CadAssociation& association);

/// One a face of the model: the number of its list among the joined ones, or no_face.
[[nodiscard]] std::vector<std::uint32_t> joined_lists(const CadAssociation& association, std::size_t faces);

/// The virtual faces of the model that facets lie on, in a plane those of curves.
template <int D>
[[nodiscard]] const VirtualFaces& virtual_faces_of(const CadParts& parts) {
    if constexpr (D == 2)
        return parts.virtual_curves;
    else
        return parts.virtual_faces;
}

}  // namespace camber

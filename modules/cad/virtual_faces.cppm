module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad:virtual_faces;
import camber.core;
import camber.surface;
import :association;
import :closest;
import :in_plane;
import :model;
import :parts;

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

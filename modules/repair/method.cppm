// Interfaces of the repair methods, and reasons why elements stay invalid.
module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
export module camber.repair:method;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.crossing;
import camber.optimisation;
import camber.surface;
import :options;

export namespace camber {

/// An element that is still not valid after the repair, with the reason.
struct RemainingElement {
    ElementId element;
    std::string reason;
    VertexId at = {};            ///< vertex that the reason concerns, if any
    bool is_unresolved = false;  ///< the work limit was reached
};

/// Describes the defect, for example "the boundary alone makes its scaled Jacobian -1.24 at vertex 64". `vertex` is the
/// text for the vertex `at`.
[[nodiscard]] std::string sentence_of(const RemainingElement& element, std::string_view vertex);

/// Returns the elements that are not certified valid, ascending. Each has the first reason of this list that applies:
///
/// - required entities; flat or inverted straight element;
/// - a determinant at a vertex that depends on boundary nodes only; folded boundary facet; all nodes on the boundary;
/// - undecided verdict; no position found.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining(const Repaired<D>& repaired);

/// Like `remaining`, for meshes whose boundary may leave the geometry. Returns only elements with required entities or
/// an exhausted work limit.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining_by_limits(const Repaired<D>& repaired);

struct BoundaryShift {
    std::size_t moved_nodes = 0;
    double largest = 0;           ///< maximum displacement (model units)
    double largest_relative = 0;  ///< maximum displacement, relative to the chord
};
template <int D>
[[nodiscard]] BoundaryShift boundary_shift(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

/// Returns a proposal with the nodes of the mesh, in which required edges are fixed.
template <int D>
[[nodiscard]] Proposal<D> proposal_from_mesh(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& boundary_kinds,
                                             RequiredBoundary required);

struct MeshRepairOptions {
    RepairOptions repair = {};
    double ridge_angle_degrees = FeatureOptions<3>{}.ridge_angle_degrees;
    RequiredBoundary required_boundary = RequiredBoundary::keep;
};

template <int D>
struct RepairedMesh {
    Mesh<D> mesh;
    Validation<D> before, after;
    RepairStatistics statistics;
    BoundaryShift boundary;
    std::vector<RemainingElement> remaining;
    std::vector<std::string> notices;  ///< messages of `prepare`, without a final full stop
};

/// Prepares a mesh (`prepare`), finds its features, judges its nodes, repairs it (`repair_within`) and commits the
/// positions, even if elements remain invalid. Errors: input (no mesh, see `prepare`), unsupported (no simplices of
/// degree 2), options out of range (usage), stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairedMesh<D>> repair_mesh(Mesh<D> mesh, const MeshRepairOptions& options,
                                                   const Execution& execution);

/// Repairs invalid elements by the method of the options until all are valid or the work limit is reached. The
/// validation of the result shows which elements stay invalid. Nothing changes if all are valid. A proposal judged for
/// another bound is judged again. The result does not depend on the number of threads. Errors: options out of range
/// (usage), columns that do not fit the mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution);

/// Calls `repair`. If invalid elements remain, tries to relax them towards the straight mesh, surface edges last, and
/// accepts this if it repairs any of them. Then calls `restore_input`. An element stays invalid only if it is valid
/// neither straight nor with the nodes of the input. For meshes whose boundary nodes may leave the geometry.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                                        const RepairOptions& options, const Execution& execution);

/// Repairs with a fixed boundary. If invalid elements remain, boundary nodes slide on the guide's geometry, then in
/// planes, then move by at most `boundary_tolerance`. Nodes that would move farther are fixed, and the repair is
/// repeated. Boundary vertices move only if the guide has `vertices_onto`. If the bound cannot be reached, this
/// function and `repair_or_straighten` select the result with the fewest invalid elements, at most as many as in the
/// input mesh.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_within(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                                 const RepairOptions& options, const Execution& execution);

/// True if `raise` applies: method `extension`, and a target above the bound and above `default_bound`.
[[nodiscard]] bool raises(const RepairOptions& options);

/// Improves elements below the target by moves of volume nodes (`repair`). Restores the nodes of valid elements that
/// end below both the target and their previous value. `input` is judged for the bound. Does nothing on standalone
/// surface meshes. Errors: those of `repair`.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> raise(const JudgedProposal<D>& input, Repaired<D> repaired,
                                         const RepairGuide<D>& guide, const RepairOptions& options,
                                         const Execution& execution);

/// Calls repair(options, execution) with the default target, then `raise` with the target of `options`.
template <int D, class Repair>
[[nodiscard]] Outcome<Repaired<D>> repair_then_raise(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                                     const RepairOptions& options, const Execution& execution,
                                                     const Repair& repair) {
    RepairOptions to_bound = options;
    to_bound.target = {};
    auto repaired = repair(to_bound, part_of(execution, 0, 0.7));
    if (!repaired) return repaired;
    return raise(input, std::move(*repaired), guide, options, part_of(execution, 0.7, 1));
}

/// Returns the elements around each edge or, for a standalone surface mesh, the triangles. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> elements_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution);

/// Returns a guide for a curved mesh without a metric field. Cost models use the implied metric. The targets are the
/// current nodes or, for volume nodes of invalid elements, a local extension of the boundary displacement. Errors:
/// stopped.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> guide_from_mesh(const JudgedProposal<D>& judged,
                                                      const Incidence<ElementId>& shells, const Execution& execution);

/// Returns a function that projects boundary nodes onto the geometry. Nodes may slide only if all facets of their edge
/// have a prescribed surface (`GeometryModel::prescribes`). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                                 const QuadraticMesh<D>& mesh, const Execution& execution);

/// Like `feet_on`, but for all surface and ridge edges, prescribed or not. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on_any(const Geometry<D>& geometry,
                                                     const Column<EdgeKind>& boundary_kinds,
                                                     const QuadraticMesh<D>& mesh, const Execution& execution);

/// Returns a function that projects boundary vertices onto the common surface of their edges or, on a ridge, onto the
/// common curve. Vertices do not move at corners, between different entities, or next to a facet that is not
/// prescribed. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VertexOnGeometry<D>> vertex_feet_on(const Geometry<D>& geometry, const Features<D>& features,
                                                          const QuadraticMesh<D>& mesh, const Execution& execution);

/// Returns the nodes of the mesh, projected onto the geometry on edges that are prescribed and not required. Errors:
/// stopped.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> mesh_nodes_on(const Geometry<D>& geometry,
                                                             const Column<EdgeKind>& boundary_kinds,
                                                             const QuadraticMesh<D>& mesh, RequiredBoundary required,
                                                             const Execution& execution);

/// Moves the nodes of invalid elements towards the chord midpoints until every element is valid, those of surface and
/// ridge edges last. Elements that become invalid are treated too. `backtracking` multiplies offsets by θ; other
/// methods use linear programs on segments. Calls `restore_input` at the end. Succeeds if the straight or the input
/// mesh is valid for the bound. Other preconditions and errors: see `repair`.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> relax(const JudgedProposal<D>& input, const RepairOptions& options,
                                         const Execution& execution);

/// Moves elements below the bound towards the input mesh in steps, the last one exact: volume nodes, boundary nodes,
/// then vertices. Elements that become invalid are treated too. Then the moved nodes approach their positions in
/// `input` as far as possible. No more elements remain below the bound than in the better of the input mesh and
/// `repaired`. Does nothing if the input mesh is straight, or if all invalid elements of `repaired` are invalid in the
/// input mesh too. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> restore_input(const JudgedProposal<D>& input, Repaired<D> repaired,
                                                 const RepairOptions& options, const Execution& execution);

template <int D>
struct UncrossedNodes {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;  ///< new positions, ascending
    Crossings crossings;  ///< crossings that remain at the new positions: facets that cross even with straight edges
};

/// Moves boundary nodes towards the chord midpoints until no facets cross. First the nodes of all crossing facets move
/// back in steps of 1/8. Then each node advances again as far as possible, in steps of 1/16 and successive halves. The
/// result depends only on facets. Facets that cross with straight edges remain; nodes of edges of kind `fixed` do not
/// move. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<UncrossedNodes<D>> uncrossed_nodes(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                         std::span<const LagrangeNode<D>> mid_nodes,
                                                         std::span<const EdgeKind> kinds, const Execution& execution);

template <int D>
struct MoveBackStatistics {
    std::size_t nodes = 0;
    double largest = 0;   ///< largest displacement
    Vec<D> largest_at{};  ///< current position of the node with displacement `largest`

    void add(const LagrangeNode<D>& before, const LagrangeNode<D>& after) {
        if (before == after) return;
        ++nodes;
        if (const double moved = distance(before.point, after.point); moved > largest) {
            largest = moved;
            largest_at = after.point;
        }
    }
};

/// A proposal whose boundary does not cross itself, except where the straight boundary does.
template <int D>
struct UncrossedWalls {
    JudgedProposal<D> judged;
    MoveBackStatistics<D> moved;
    std::optional<Crossings> crossings = {};  ///< nothing if the last repair may have changed the crossings
};

/// Calls `uncrossed_nodes`, then repairs elements that became invalid (`repair_or_straighten`) with the moved nodes
/// fixed; at most three iterations. Errors: those of `repair_or_straighten`.
template <int D>
[[nodiscard]] Outcome<UncrossedWalls<D>> uncross_walls(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                                       const RepairOptions& options, const Execution& execution);

}  // namespace camber

namespace camber {

/// Permission to leave the geometry, and maximum distance from the initial position.
struct SurfaceLimits {
    bool may_leave = true;
    double most = 0;  ///< model units; 0: only a share of the chord limits the distance
};

/// Repairs invalid triangles of a standalone surface mesh one after the other, in sweeps. Each triangle gets the
/// shortest move of the first kind in this list that makes it valid (N · n: see SurfaceTriangle):
///
/// 1. A node slides on the geometry (`guide.onto`). The coefficients of N · n are affine in one node, so the minimum
///    displacement in its tangent plane is a quadratic program. The node is projected, and the step is repeated.
/// 2. A node moves to the projection of its chord midpoint.
/// 3. A node leaves the geometry by the minimum displacement in space.
/// 4. All nodes of the triangle move towards their chords by θ until it is valid, and later back as far as possible.
///
/// Only move 4 may invalidate other triangles. Moves 3 and 4 leave the geometry; if the bound is only recommended, they
/// are used only where N · n is not positive. Methods without models use only move 4.
[[nodiscard]] Outcome<Repaired<3>> repair_surface(const JudgedProposal<3>& input, const RepairGuide<3>& guide,
                                                  const RepairOptions& options, const SurfaceLimits& leave,
                                                  const Execution& execution);

/// The same as `remaining`, for the triangles of a standalone surface mesh.
[[nodiscard]] std::vector<RemainingElement> remaining_triangles(const Repaired<3>& repaired);

}  // namespace camber

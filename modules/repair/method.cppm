// Interfaces of the methods of repair, and reasons for elements that remain.
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

/// An element that could not be repaired, and why, as far as that can be told.
struct RemainingElement {
    ElementId element;
    std::string reason;
    VertexId at = {};          ///< where the reason is; not valid: nowhere in particular
    bool is_given_up = false;  ///< the work that may be spent was spent
};

/// "the boundary alone makes its scaled Jacobian -1.24 at vertex 64": `vertex` is what that vertex is called.
[[nodiscard]] std::string sentence_of(const RemainingElement& element, std::string_view vertex);

/// The elements that are not certified valid, in the mesh's order, and why, as far as that can be told: a straight
/// element without volume; a determinant at a vertex that boundary nodes alone decide (there the columns are
/// 4 P_ij − 3 P_i − P_j); required edges and vertices; a facet of the boundary that is folded, seen from its straight
/// form; nodes that are all on the boundary; else nothing that forbids it is known.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining(const Repaired<D>& repaired);

/// Those of them that hold something required, or on which the work was spent, with that reason: for a mesh whose
/// boundary may leave the geometry, where the others had all the freedom there is.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining_but_for_shape(const Repaired<D>& repaired);

/// How far boundary nodes are from where the mesh has them.
struct BoundaryShift {
    std::size_t moved_nodes = 0;
    double largest = 0;           ///< of a node (model units)
    double largest_relative = 0;  ///< the same by the length of its edge's chord
};
template <int D>
[[nodiscard]] BoundaryShift boundary_shift(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

/// The mesh's own nodes as a proposal, with the kinds that its boundary gives them; what is required stays.
template <int D>
[[nodiscard]] Proposal<D> own_proposal(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& boundary_kinds,
                                       RequiredBoundary required);

/// How a mesh is repaired that brings its own curves.
struct MeshRepairOptions {
    RepairOptions repair = {};
    double ridge_angle_degrees = FeatureOptions<3>{}.ridge_angle_degrees;  ///< as FeatureOptions has it
    RequiredBoundary required_boundary = RequiredBoundary::keep;
};

/// A mesh after its repair, and what became of it.
template <int D>
struct RepairedMesh {
    Mesh<D> mesh;
    Validation<D> before, after;
    RepairStatistics statistics;
    BoundaryShift boundary;
    std::vector<RemainingElement> remaining;
    std::vector<std::string> notices;  ///< of what `prepare` did: sentences without a full stop
};

/// All that `camber repair` does, in one call: the mesh is made sound (`prepare`), its boundary's features are found,
/// its nodes are judged, what is not valid is repaired with the boundary given (`repair_within`), and the places become
/// the mesh's, valid or not: `after` and `remaining` tell. Errors: input (no mesh, see `prepare`), unsupported (no
/// simplices of degree 2), options out of range (usage), stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairedMesh<D>> repair_mesh(Mesh<D> mesh, const MeshRepairOptions& options,
                                                   const Execution& execution);

/// Repairs elements that are not valid, by the method of the options, until all are or the work is spent; what
/// cannot be repaired remains, and the validation says so. Nothing changes when all elements are valid. `guide`: what
/// methods go by. A proposal that was judged for another bound is judged again. The result is the
/// same for any number of threads. Errors: options out of range (usage), columns that do not fit the mesh (internal),
/// stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution);

/// Repairs as `repair` does. Elements that cavities leave are relaxed towards the straight mesh, surface edges last, if
/// that repairs any, then restored towards the input mesh (`restore_input`): an element remains only if it is valid
/// neither straight nor with the input's nodes. For meshes whose boundary nodes may leave the geometry.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                        const RepairOptions& options, const Execution& execution);

/// The same with the boundary given: its nodes stay while that is enough; then they slide in planes, then they move, by
/// no more than the options' boundary_tolerance; its vertices always stay. A node that would go further is held where
/// it was, and what is left is repaired again without it. Where the bound cannot be had, both take what leaves fewest
/// invalid elements, and never more than the input mesh has.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair_within(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                 const RepairOptions& options, const Execution& execution);

/// True if the method raises elements above the bound, to its target (`raise`).
[[nodiscard]] bool raises(const RepairOptions& options);

/// Raises the elements of a repaired proposal to the target, by the passes that move volume nodes alone (`repair`).
/// Where an element that was valid ends below both the target and its value before, its nodes are put back. `wanted` is
/// judged for the bound. Does nothing on standalone surface meshes. Errors: those of `repair`.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> raise(const JudgedProposal<D>& wanted, Repaired<D> repaired,
                                         const RepairGuide<D>& guide, const RepairOptions& options,
                                         const Execution& execution);

/// Calls repair(options, execution) with the default target, then raises the elements to that of `options`.
template <int D, class Repair>
[[nodiscard]] Outcome<Repaired<D>> repair_then_raise(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                                     const RepairOptions& options, const Execution& execution,
                                                     const Repair& repair) {
    RepairOptions to_bound = options;
    to_bound.target = {};
    auto repaired = repair(to_bound, part_of(execution, 0, 0.7));
    if (!repaired) return repaired;
    return raise(wanted, std::move(*repaired), guide, options, part_of(execution, 0.7, 1));
}

/// Returns what holds each edge: elements, or the triangles of a surface alone. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> holders_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution);

/// The guide of a mesh that was read with its curves and has no field: models in the mesh's implied metric, about where
/// its nodes are, but for the volume nodes of elements that are not valid, whose places say nothing: there, by the
/// displacement around them extended inwards. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<RepairGuide<D>> own_guide(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                                const Execution& execution);

/// The feet of boundary edges' nodes on a geometry, for edges all of whose facets have a prescribed surface
/// (`GeometryModel::prescribes`); others are not to slide. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                                 const QuadraticMesh<D>& mesh, const Execution& execution);

/// The same for all boundary edges, whoever made the geometry of their facets.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on_any(const Geometry<D>& geometry,
                                                     const Column<EdgeKind>& boundary_kinds,
                                                     const QuadraticMesh<D>& mesh, const Execution& execution);

/// The feet of the boundary's vertices: on the surface that all their edges lie on, or, on a ridge, on the curve that
/// both of its edges lie on. Those at corners, where surfaces or curves differ, and where any is not prescribed are not
/// to slide. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VertexOnGeometry<D>> vertex_feet_on(const Geometry<D>& geometry, const Features<D>& features,
                                                          const QuadraticMesh<D>& mesh, const Execution& execution);

/// The mesh's own nodes, those of such edges brought onto the geometry, but for required ones. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> own_nodes_on(const Geometry<D>& geometry,
                                                            const Column<EdgeKind>& boundary_kinds,
                                                            const QuadraticMesh<D>& mesh, RequiredBoundary required,
                                                            const Execution& execution);

/// The fourth verb: moves nodes of elements that are not valid (and of those that break by it) towards the middle of
/// their chords, volume edges first, surface and ridge edges last, until every element is valid. By theta if that is
/// the method of the options, else by segments. Elements that this leaves go back towards the input mesh
/// (`restore_input`). Succeeds whenever the straight mesh, or the input mesh, is valid to the bound; what cannot be
/// repaired remains, and the validation says so. Nothing changes when all elements are valid. A proposal that was
/// judged for another bound is judged again. Errors: options out of range (usage), columns that do not fit the mesh
/// (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> relax(const JudgedProposal<D>& wanted, const RepairOptions& options,
                                         const Execution& execution);

/// Repairs elements that a repair left below the bound by moving their nodes back towards where the input mesh has
/// them, in few steps, the last one exactly there: volume nodes first, then boundary nodes, then vertices; elements
/// that become invalid by it are next. Then these nodes return towards `wanted` as far as the elements around them
/// allow. The result has no more elements below the bound than the input mesh or `repaired`, whichever has fewer. Does
/// nothing if the input mesh is straight, or is valid nowhere `repaired` is not. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> restore_input(const JudgedProposal<D>& wanted, Repaired<D> repaired,
                                                 const RepairOptions& options, const Execution& execution);

/// Nodes of boundary edges that are moved back because facets cross.
template <int D>
struct UncrossedNodes {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;  ///< new positions, rising by edges
    Crossings crossings;                                    ///< with them: pairs that cross still are straight
};

/// Moves nodes of boundary edges towards the middles of their chords until no facets cross: first all edges of facets
/// that cross, by eighths of their way; then each goes as near to its position as the others allow, by sixteenths and
/// halves of these. Only facets are read, so a surface without its elements will do. Pairs that cross with all of their
/// edges straight are left. Edges of the kind `fixed` stay. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<UncrossedNodes<D>> uncrossed_nodes(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                         std::span<const LagrangeNode<D>> mid_nodes,
                                                         std::span<const EdgeKind> kinds, const Execution& execution);

/// Nodes that were moved back, and the largest distance.
template <int D>
struct MovedBack {
    std::size_t nodes = 0;
    double largest = 0;   ///< distance from the position before
    Vec<D> largest_at{};  ///< position of that node now

    void add(const LagrangeNode<D>& before, const LagrangeNode<D>& after) {
        if (before == after) return;
        ++nodes;
        if (const double moved = distance(before.point, after.point); moved > largest) {
            largest = moved;
            largest_at = after.point;
        }
    }
};

/// A proposal whose walls do not cross, as far as its straight walls do not.
template <int D>
struct UncrossedWalls {
    JudgedProposal<D> judged;
    MovedBack<D> moved;
    std::optional<Crossings> crossings = {};  ///< those of the proposal; none where a last repair may have changed them
};

/// `uncrossed_nodes` of a proposal; elements that become invalid by it are repaired (`repair_or_straighten`) with these
/// nodes fixed, at most three times over. Nothing changes where no facets cross. Errors: those of repair.
template <int D>
[[nodiscard]] Outcome<UncrossedWalls<D>> uncross_walls(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                                       const RepairOptions& options, const Execution& execution);

}  // namespace camber

namespace camber {

/// Whether nodes may leave the geometry, and how far they may go from where they are.
struct SurfaceLeave {
    bool may_leave = true;
    double most = 0;  ///< 0: a share of the chord alone
};

/// The triangles of a surface alone that are not good enough corrected, by the least change that helps, one after the
/// other, in turns:
///
/// 1. the node of one edge slides on the geometry (`guide.onto`): the coefficients of N · n are affine in one node, so
///    the least displacement in its tangent plane is a quadratic programme over those of the triangles beside it; then
///    the foot, and from there again;
/// 2. a node goes to the foot of its chord's middle;
/// 3. it leaves the geometry, by the least displacement in space;
/// 4. all nodes of the triangle go towards their chords by theta, until it holds; they return as far as they may.
///
/// No triangle that holds the bound ceases to. 3 and 4 leave the geometry, and are not for a recommended bound: where
/// none was asked for they are done for N · n > 0 alone. By `segment` and `relax` there is only 4.
[[nodiscard]] Outcome<Repaired<3>> repair_surface(const JudgedProposal<3>& wanted, const RepairGuide<3>& guide,
                                                  const RepairOptions& options, const SurfaceLeave& leave,
                                                  const Execution& execution);

/// The triangles that are not certified valid, and why, as far as that can be told.
[[nodiscard]] std::vector<RemainingElement> remaining_triangles(const Repaired<3>& repaired);

}  // namespace camber

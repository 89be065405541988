module;
#include <cstddef>
#include <vector>
export module camber.repair:repaired;
import camber.core;
import camber.validity;

export namespace camber {

/// What a repair changed.
struct RepairStatistics {
    std::size_t corrected_elements = 0;   ///< not valid before, valid now
    std::size_t moved_volume_nodes = 0;   ///< edges whose node is not where it was
    std::size_t moved_surface_nodes = 0;  ///< the same, of surface and ridge edges: they may have left the geometry
    std::size_t moved_vertices = 0;       ///< in the volume
    double work = 0;                      ///< of its programmes, as `RepairOptions::effort` counts it
    std::size_t by_edges = 0, by_cavities = 0, by_extension = 0, by_vertices = 0, by_slides = 0,
                by_surface = 0;  ///< elements
};

/// A proposal after a repair, and what that changed.
template <int D>
struct Repaired {
    JudgedProposal<D> judged;
    RepairStatistics statistics = {};
    std::vector<ElementId> given_up = {};  ///< not valid when the work that may be spent was spent; rising
};

/// What is otherwise in a later judgement of the same mesh: elements, and nodes and vertices, by the kinds of `before`.
template <int D>
[[nodiscard]] RepairStatistics changes_between(const JudgedProposal<D>& before, const JudgedProposal<D>& after);

/// The later state with all that changed since `before` counted, and with its kinds; the work is that of `after`.
template <int D>
[[nodiscard]] Repaired<D> with_all_changes(const JudgedProposal<D>& before, Repaired<D> after);

/// The elements that are not valid, rising.
template <int D>
[[nodiscard]] std::vector<ElementId> elements_not_valid(const Validation<D>& validation);

/// The changes with those of edges whose node is not where it was: straightened, where it is in the middle now, else
/// relaxed.
template <int D>
[[nodiscard]] Column<EdgeChange> changes_after(const QuadraticMesh<D>& mesh, const Proposal<D>& before,
                                               const Column<Vec<D>>& points, const Column<LagrangeNode<D>>& mid_nodes);

}  // namespace camber

module;
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.repair:uncross;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.validity;
import :guide;
import :options;
import :repaired;

export namespace camber {

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

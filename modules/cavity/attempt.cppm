module;
#include <cstddef>
#include <functional>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>
module camber.cavity:attempt;
import camber.core;
import camber.validity;
import camber.programmes;
import camber.repair;
import :reinsert;
import :star;

namespace camber {

/// A patch that wins less than this over all its nodes is not worth a commit.
inline constexpr double least_gain = 1e-3;

/// Sums of misfits over the edges at a cavity's point; the surface comes before the volume.
struct Misfits {
    double surface = 0, volume = 0;
    void add(EdgeKind kind, double misfit) { (kind == EdgeKind::volume ? volume : surface) += misfit; }
    [[nodiscard]] bool better_than(const Misfits& other) const {
        if (surface < other.surface - least_gain) return true;
        return surface < other.surface + least_gain && volume < other.volume - least_gain;
    }
};

/// The edges of a cavity in its small mesh, and which edges of the large one they are.
struct CavityEdges {
    std::vector<EdgeId> of_mesh;  ///< for each edge of the star
    std::vector<EdgeId> inner;    ///< edges of the star at its point: theirs is the freedom
};

/// One reinsertion under way: the star, elevated, of a cavity.
template <int D>
struct Operation {
    const Curving<D>& curving;
    const StarMesh<D>& star;
    const QuadraticMesh<D>& small;
    const CavityEdges& edges;

    /// The star with the nodes that the mesh has now, those at the point excepted: they are where `choose` says.
    template <class Choose>
    [[nodiscard]] Proposal<D> proposal(Choose&& choose) const {
        const std::size_t n = small.edges.size();
        Buffer<LagrangeNode<D>> nodes(n);
        Buffer<EdgeKind> kinds(n, EdgeKind::fixed);
        Buffer<EdgeChange> changes(n, EdgeChange::straight);
        for (std::size_t e = 0; e < n; ++e) nodes[e] = curving.mesh.mid_nodes[edges.of_mesh[e]];
        for (const EdgeId e : edges.inner) {
            const EdgeId of_mesh = edges.of_mesh[e.index()];
            kinds[e.index()] = curving.kinds[of_mesh];
            std::tie(nodes[e.index()], changes[e.index()]) = choose(of_mesh);
        }
        return {small.linear.points, std::move(nodes), std::move(kinds), std::move(changes)};
    }

    [[nodiscard]] Misfits misfits(const Proposal<D>& nodes, const Proposal<D>& targets) const {
        Misfits sum;
        for (const EdgeId e : edges.inner)
            sum.add(targets.kinds[e], misfit(small, e, nodes.mid_nodes[e], targets.mid_nodes[e]));
        return sum;
    }
};

/// Nodes for the star that break no element, if there are some.
template <int D>
struct Attempt {
    std::optional<Proposal<D>> planned;  ///< none when an element would break
    ElementId broken;                    ///< the first that would
    Misfits misfits;

    [[nodiscard]] bool serves_surface_better_than(const Attempt& other) const {
        return planned && misfits.surface < other.misfits.surface - least_gain;
    }
};

/// The wanted nodes repaired by the method of the options until the star's elements hold `asked`, which may be more
/// than the bound of the options: elements that fall short of it with the nodes `present` may stay so, but none may
/// fall below the bound. What that leaves is relaxed.
template <int D>
[[nodiscard]] Outcome<Attempt<D>> repaired_from_targets(const Operation<D>& op, const Proposal<D>& wanted,
                                                        const Proposal<D>& present, const EdgeModels<D>& models,
                                                        double asked, RepairOptions options);

/// Where repair from the targets fails, since the straight star does not fit its curved surroundings: from the nodes
/// as they are, one edge after the other a part of its way, as far as nothing breaks. Volume edges first: they make
/// room for those of the surface. Always gives nodes.
template <int D>
[[nodiscard]] Attempt<D> stepped_from_present(const Operation<D>& op, const Proposal<D>& wanted,
                                              const Proposal<D>& present, double bound);

/// Whether planned nodes are worth a commit: nearer to their targets, or of fewer elements that are not valid.
template <int D>
[[nodiscard]] bool is_worth_a_commit(const Operation<D>& op, const Attempt<D>& attempt, const Proposal<D>& wanted,
                                     const Proposal<D>& present, double bound);

}  // namespace camber

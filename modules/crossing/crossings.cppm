module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.crossing:crossings;
import camber.core;
import camber.bezier;
import :pair;

export namespace camber {

/// Two facets that are not clear of each other; one that is not of itself.
struct FacetCrossing {
    FacetId first, second;  ///< the lower one first; the same twice: of itself
    Crossing verdict = Crossing::undecided;
    friend bool operator==(const FacetCrossing&, const FacetCrossing&) = default;
};

/// What became of all pairs of a mesh's facets.
struct Crossings {
    std::size_t pairs = 0;  ///< whose boxes meet, and that were looked at; the others are clear by their boxes
    std::size_t crossing = 0, undecided = 0;
    std::vector<FacetCrossing> found = {};  ///< those that are not clear, by rising facets

    [[nodiscard]] bool all_clear() const { return found.empty(); }
    friend bool operator==(const Crossings&, const Crossings&) = default;
};

/// Whether the mesh's facets (boundary and interfaces) cross each other or themselves. Elements may all be valid and
/// walls yet pass through each other: det J > 0 speaks of each element alone. Time: n log n and what pairs of near
/// facets take. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution);

/// The same with other places of vertices and mid nodes: those of a proposal.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution);

}  // namespace camber

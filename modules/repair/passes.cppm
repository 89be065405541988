module;
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>
export module camber.repair:passes;
import camber.core;
import camber.validity;
import camber.programmes;
import :relax;

export namespace camber {

/// How far repair goes.
enum class RepairScope : std::uint8_t {
    edges,     ///< one volume node at a time, by the programmes of camber.validity
    cavities,  ///< several together first; larger cavities, vertices, and, last, surface nodes
};

enum class VertexMoves : std::uint8_t { allowed, never };
[[nodiscard]] constexpr auto words(VertexMoves) {
    return words_of(Word{VertexMoves::allowed, "move"}, Word{VertexMoves::never, "keep"});
}

/// What repair asks of the elements.
struct RepairOptions {
    double min_scaled_jacobian = default_bound;
    double target = RelaxOptions{}.target;  ///< the same as relaxation's
    RepairScope scope = RepairScope::cavities;
    double surface_tolerance = 0;
    VertexMoves vertices = VertexMoves::allowed;
    /// A step of a programme with ten unknown points counts 1, others with the square of their number. So repair ends
    /// where what is asked cannot be had; counts, not seconds, so that the result is the same on any machine.
    double effort = 500;
    double most_work = std::numeric_limits<double>::infinity();  ///< what may be spent in all

    [[nodiscard]] static constexpr auto options() {
        using S = RepairOptions;
        return std::tuple(
            bound_option<S>(), option_of(&RelaxOptions::target).as(&S::target),
            option("surface_tolerance", &S::surface_tolerance,
                   "how far a surface node may go, last, from where it is wanted: to the distance of the middle of "
                   "its chord, as relaxation takes it, or to this one if that is more")
                .unit("model units")
                .at_least(0),
            option("vertices", &S::vertices,
                   "vertices of the volume: move, where nodes alone do not mend an element; keep, all stay. Required "
                   "ones never move"),
            option("effort", &S::effort,
                   "work that cavity and edge may spend for each element that is not good enough, in steps of "
                   "programmes of ten nodes; easily mended ones leave theirs to others, and what is not mended when "
                   "it is spent is listed")
                .at_least(0));
    }
    friend bool operator==(const RepairOptions&, const RepairOptions&) = default;
};

/// The work that a repair of so many elements that are not good enough may take: effort · (200 + elements). Where there
/// are few, one may take more.
[[nodiscard]] constexpr double allowed_work(std::size_t elements, double effort) {
    return (200 + static_cast<double>(elements)) * effort;
}

/// How repair went.
struct RepairStatistics {
    std::size_t corrected_elements = 0;     ///< not good enough before, good enough now
    std::size_t moved_volume_nodes = 0;     ///< edges whose node is not where it was
    std::size_t moved_vertices = 0;         ///< in the volume
    std::size_t relaxed_surface_nodes = 0;  ///< surface and ridge edges that left the geometry
    double work = 0;                        ///< of its programmes
    std::size_t by_edges = 0, by_cavities = 0, by_extension = 0, by_vertices = 0, by_surface = 0;  ///< elements
};

/// What `repair` made of a proposal; vertices may have moved, too.
template <int D>
struct Repaired {
    JudgedProposal<D> judged;
    RepairStatistics statistics;
    std::vector<ElementId> given_up;  ///< not good enough when the work that may be spent was spent; rising
};

/// Mends what is not good enough in a mesh with the places of `wanted`, at the least cost by the models: for each such
/// element a cavity, its volume nodes, which move together (joint_programme) while its surroundings and the boundary
/// stay; then one volume node; then the nodes around it extend the boundary's displacement, as far out as they must;
/// then larger cavities, and the vertices of the volume; last, surface nodes, which are counted. Then nodes return as
/// near to their places as they may, one at a time and together. No element that is good enough ever stops being so.
/// Cavities that do not overlap are planned in parallel; the result is the same for any number of threads. What cannot
/// be mended remains, and the validation says so. Where a vertex moves, det J is to be above bound · |det of the
/// mesh's straight element| too, and the mean ratio at least min(before, 0.05), or the vertex stays. `models`: one an
/// edge, about where its node is wanted while its vertices are where the mesh has them. A proposal that was judged for
/// another bound is judged again. Errors: options out of range (usage), columns that do not fit (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                          const RepairOptions& options, const Execution& execution);

}  // namespace camber

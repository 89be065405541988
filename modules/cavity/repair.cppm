module;
#include <cstddef>
export module camber.cavity:repair;
import camber.core;
import camber.validity;
import :edge_models;

export namespace camber {

/// What cavity repair asks of the elements.
struct RepairOptions {
    double min_scaled_jacobian = 1e-12;  ///< det J / |det straight| that makes an element good enough
    /// What is aimed at where it can be had: keeps mended elements off the very edge of validity.
    double target = 1e-2;
};

/// How cavity repair went.
struct RepairStatistics {
    std::size_t corrected_elements = 0;      ///< not good enough before, good enough now
    std::size_t moved_volume_nodes = 0;      ///< edges whose node is not where it was wanted
    std::size_t moved_vertices = 0;          ///< in the volume
    std::size_t relaxed_surface_nodes = 0;   ///< surface and ridge edges that left the geometry
    std::size_t cavities = 0, failures = 0;  ///< programmes that mended their element, and that did not
};

/// A mesh that was repaired: its vertices may have moved.
template <int D>
struct Repaired {
    LinearMesh<D> linear;
    Proposal<D> proposal;
    Validation<D> validation;
    RepairStatistics statistics;
};

/// Mends what is not good enough in a mesh with the nodes of `proposal`, at the least cost by the models: for each such
/// element a cavity, whose volume nodes move together (see joint_programme) while its surroundings and the boundary
/// stay; where that does not do, a larger cavity; then the vertices of the volume in it, too; last, surface nodes,
/// which are counted. No element that is good enough ever stops being so. Cavities that do not overlap are planned in
/// parallel; the result is the same for any number of threads. What cannot be mended remains, and the validation says
/// so. `models`: one an edge. Errors: options out of range (usage), columns that do not fit (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Repaired<D>> repair(const QuadraticMesh<D>& mesh, Proposal<D> proposal,
                                          const Validation<D>& validation, const Column<EdgeModel<D>>& models,
                                          const RepairOptions& options, const Execution& execution);

}  // namespace camber

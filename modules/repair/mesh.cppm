module;
#include <string>
#include <vector>
export module camber.repair:mesh;
import camber.core;
import camber.surface;
import camber.validity;
import :options;
import :remaining;
import :repaired;

export namespace camber {

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
    QuadraticMesh<D> mesh;
    Validation<D> before, after;
    RepairStatistics statistics;
    BoundaryShift boundary;
    std::vector<RemainingElement> remaining;
    std::vector<std::string> notices;  ///< of what `prepare` did: sentences without a full stop
};

/// All that `camber repair` does, in one call: the mesh is made sound (`prepare`), its boundary's features are found,
/// its nodes are judged, what is not valid is repaired with the boundary given (`repair_within`), and the places become
/// the mesh's, valid or not: `after` and `remaining` tell. Errors: input (no mesh, see `prepare`), options out of range
/// (usage), stopped, memory.
template <int D>
[[nodiscard]] Outcome<RepairedMesh<D>> repair_mesh(QuadraticMesh<D> mesh, const MeshRepairOptions& options,
                                                   const Execution& execution);

}  // namespace camber

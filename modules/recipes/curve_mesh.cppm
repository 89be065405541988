module;
#include <string>
#include <vector>
export module camber.recipes:curve_mesh;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.repair;
import camber.validity;
import :goal;
import :propose;

export namespace camber {

struct CurveMeshOptions {
    ProposeOptions curve = {};
    RepairOptions repair = {};
};

/// A mesh of degree 2, and what became of it.
template <int D>
struct CurvedMesh {
    QuadraticMesh<D> mesh;
    Validation<D> before, after;  ///< of the nodes as they were wanted; of the mesh
    CurveStatistics curving;
    RepairStatistics repair;
    std::vector<RemainingElement> remaining;  ///< which repair could not help, and why
    std::vector<std::string> notices;         ///< of what `prepare` did: sentences without a full stop
};

/// All that `camber curve` does, in one call: the mesh is made sound (`prepare`) and of degree 2, its boundary goes
/// onto the geometry, its inner edges where the metric wants them, what is not valid is repaired, and the places become
/// the mesh's, valid or not: `after` and `remaining` tell. Its order is the caller's (camber.ordering makes a better
/// one). Steps: prepare, elevate, surface, extension, metric, curve, validate, relax. Errors: input (no mesh, see
/// `prepare`), options out of range (usage), those of the goal, stopped, memory.
template <int D>
[[nodiscard]] Outcome<CurvedMesh<D>> curve_mesh(LinearMesh<D> mesh, const MeshGoal<D>& goal,
                                                const CurveMeshOptions& options, const Around& around);

}  // namespace camber

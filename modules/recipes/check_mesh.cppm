module;
#include <optional>
export module camber.recipes:check_mesh;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.soundness;
import camber.validity;

export namespace camber {

/// What is asked of a mesh that may be anyone's: the bound is 0, not that of the meshes which Camber makes.
struct MeshCheckOptions {
    double min_scaled_jacobian = 0;
    ExamineOptions examine = {};
};

/// Walls that pass through each other, and elements that overlap; `mesh` is the one that was looked at, with its
/// boundary listed.
template <int D>
struct CheckedWalls {
    QuadraticMesh<D> mesh;
    Crossings crossings;
    Overlaps<D> overlaps = {};  ///< not looked at where the mesh lists elements twice
};

/// What is right and wrong with a mesh, as it is.
template <int D>
struct MeshCheck {
    Soundness soundness;
    QuadraticMesh<D> mesh;  ///< a linear one elevated
    Validation<D> validation;
    /// None where fatal defects forbid the look, or the boundary is not listed and cannot be.
    std::optional<CheckedWalls<D>> walls;

    [[nodiscard]] bool all_good() const {
        return soundness.sound() && validation.all_valid() && walls && walls->crossings.crossing == 0 &&
               walls->overlaps.overlapping == 0;
    }
};

/// What `camber check` looks at, in one call. Steps: examine, validate, cross. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<MeshCheck<D>> check_mesh(const LinearMesh<D>& mesh, const MeshCheckOptions& options,
                                               const Around& around);
template <int D>
[[nodiscard]] Outcome<MeshCheck<D>> check_mesh(const QuadraticMesh<D>& mesh, const MeshCheckOptions& options,
                                               const Around& around);

}  // namespace camber

module;
#include <span>
module camber.cavity:check_patches;
import camber.core;
import :mesh;
import :patch;

namespace camber {

/// Asked before anything is changed: patches of this mesh that do not get into each other's way. Errors: those of
/// replace_cavities.
template <int D>
[[nodiscard]] Outcome<Done> check_patches(const DynamicMesh<D>& mesh, std::span<const Patch<D>> patches);

}  // namespace camber

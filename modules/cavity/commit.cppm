module;
#include <span>
export module camber.cavity:commit;
import camber.core;
import :patch;
import :reinsert;

export namespace camber {

/// The last verb for cavities: the patches' nodes become the mesh's; the cost is that of the patches. Their cavities
/// must not overlap, or one would undo what the other was planned against (see Schedule of camber.core). Errors
/// (internal): a patch with an edge that the mesh does not have.
template <int D>
[[nodiscard]] Outcome<Curving<D>> commit(Curving<D> curving, std::span<const Patch<D>> patches);

}  // namespace camber

module camber.distributed:part_layout;
import camber.core;
import :ranks;
import :ringed_parts;
import :rows;

namespace camber {

/// Where the blocks of a mesh begin, and who has which: see `split`. Errors: those of the rows, of any rank.
template <int D>
[[nodiscard]] Outcome<PartLayout> part_layout(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks);

}  // namespace camber

export module camber.distributed:check_blocks;
import camber.core;
import :blocks;
import :ranks;

namespace camber {

/// Whether the elements of these blocks are as `prepare` of camber.soundness leaves them: positive, at most two on a
/// face, and a facet where there is one, or where both have other references. Errors (input) name the first element, as
/// the rows count, from 1.
template <int D>
[[nodiscard]] Outcome<Done> check_blocks(const Blocks<D>& blocks, const Execution& execution);

}  // namespace camber

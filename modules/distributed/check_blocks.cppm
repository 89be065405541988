export module camber.distributed:check_blocks;
import camber.core;
import :ringed_parts;
import :ranks;

namespace camber {

/// Whether the elements of these parts are as `prepare` of camber.soundness leaves them: positive, at most two on a
/// face, and a facet where there is one, or where both have other references. Errors (input) name the first element, as
/// the rows count, from 1.
template <int D>
[[nodiscard]] Outcome<Done> check_blocks(const RingedParts<D>& parts, const Execution& execution);

}  // namespace camber

export module camber.distributed:check_part;
import camber.core;
import :ringed_parts;
import :ranks;

namespace camber {

/// Whether a part's elements are as `prepare` of camber.soundness leaves them: positive, at most two on a
/// face, and a facet where there is one, or where both have other references. Errors (input) name the first element, as
/// the rows count, from 1.
template <int D>
[[nodiscard]] Outcome<Done> check_part(const RingedPart<D>& part, const Execution& execution);

}  // namespace camber

module camber.repair:slides;
import camber.core;
import camber.validity;

namespace camber {

/// Volume nodes around elements that are not valid, and nodes of the boundary's plane pieces within their planes by at
/// most the tolerance, go where a linear extension of all other boundary nodes' displacements has them, as far out as
/// that breaks elements. The boundary's shape stays. The proposal need not be better. Errors: stopped.
[[nodiscard]] Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance,
                                                  const Execution& execution);

}  // namespace camber

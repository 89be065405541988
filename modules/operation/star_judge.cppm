module;
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>
module camber.operation:star_judge;
import camber.core;
import camber.cavity;
import :quality_bar;
import :request;

/// What the edges and elements of a star must be: the one judge of them, for straight ones and curved ones.
namespace camber {

inline constexpr std::size_t no_face = std::numeric_limits<std::size_t>::max();

/// What is wrong with a star, and at which joined face; no_face: at none of them.
struct StarFault {
    RejectionReason reason = RejectionReason::none;
    std::size_t joined = no_face;
    double worst_shape = std::numeric_limits<double>::infinity();  ///< of the elements, where there is none
};

/// What an element of a star comes to.
struct ElementState {
    bool is_valid = false, is_flat = false;
    double shape = 0;           ///< of a valid one
    bool is_tolerated = false;  ///< not valid, as before
};

/// Whether the edges at the point that a request makes, or moves, are within its limits, as far as they are placed.
template <class ToPoint, class Nodes>
[[nodiscard]] bool lengths_fit(std::span<const ToPoint> to_point, bool point_moves, const PatchLimits& limits,
                               const Nodes& nodes) {
    for (std::size_t s = 0; s < to_point.size(); ++s) {
        if (to_point[s].is_there && !point_moves) continue;  // no edge that is made
        if (!nodes.is_placed(s)) continue;
        const double length = nodes.length_to(s);
        if (!(length >= limits.shortest && length <= limits.longest)) return false;
    }
    return true;
}

/// volume, height, quality: the first that an element fails at.
template <int D>
[[nodiscard]] RejectionReason fault_of(const ElementState& e, QualityBar<D>& bar) {
    if (e.is_tolerated) return RejectionReason::none;
    if (!e.is_valid) return RejectionReason::volume;
    if (e.is_flat) return RejectionReason::height;
    return bar.is_met(e.shape) ? RejectionReason::none : RejectionReason::quality;
}

/// The gravest fault of a star's elements; or, of elements that are judged one by one, the first. `faulty`: which have
/// it, as far as they were judged. `shapes`: of the elements, where there is none.
template <int D, class Nodes>
[[nodiscard]] StarFault find_faults(std::size_t elements, const Nodes& nodes, QualityBar<D>& bar,
                                    std::vector<std::size_t>& faulty, std::vector<double>& shapes) {
    shapes.clear();
    faulty.clear();
    StarFault found;
    const auto rank = [](RejectionReason reason) {
        return reason == RejectionReason::volume ? 0 : reason == RejectionReason::height ? 1 : 2;
    };
    const auto add = [&](RejectionReason reason, std::size_t j) {
        if (found.reason == RejectionReason::none || rank(reason) < rank(found.reason)) {
            found = {reason, j};
            faulty.clear();
        }
        if (rank(reason) == rank(found.reason)) faulty.push_back(j);
    };
    if constexpr (!Nodes::is_judged_by_element) {  // what is not valid first: it needs no shapes
        for (std::size_t j = 0; j < elements; ++j)
            if (nodes.is_broken(j)) add(RejectionReason::volume, j);
        if (!faulty.empty()) return found;
    }
    for (std::size_t j = 0; j < elements; ++j) {
        const ElementState element = nodes.element(j);
        if (const RejectionReason reason = fault_of(element, bar); reason != RejectionReason::none) {
            add(reason, j);
            if (Nodes::is_judged_by_element) return found;
            continue;
        }
        shapes.push_back(element.shape);
        if (found.reason == RejectionReason::none) found.worst_shape = std::min(found.worst_shape, element.shape);
    }
    return found;
}

}  // namespace camber

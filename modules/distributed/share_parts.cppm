module;
#include <cstddef>
#include <vector>
export module camber.distributed:share_parts;
import camber.core;
import camber.adapt;
import :adaptation_rows;
import :ranks;

export namespace camber {

/// What was made of a part.
template <int D>
struct ChangedPart {
    AdaptationRows<D> rows;
    ToMetricStatistics statistics;
};

/// Of so many parts those [first, last) are this rank's work: runs, as even as their number allows.
struct OwnParts {
    std::size_t first = 0, last = 0;
};
[[nodiscard]] OwnParts own_parts(const Ranks& ranks, std::size_t parts);

/// What every rank has made by itself, if all have: none goes on and waits for one that has failed. Errors: of any
/// rank.
template <class T>
[[nodiscard]] Outcome<T> agreed(Ranks& ranks, Outcome<T> made) {
    if (ranks.size() == 1) return made;
    const auto heard =
        ranks.exchange(made ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size())) : fail(made.error()));
    if (!heard) return fail(heard.error());
    return made;
}

/// The parts of all ranks on all of them, in their order, from those of each. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<std::vector<ChangedPart<D>>> shared_parts(Ranks& ranks, Outcome<std::vector<ChangedPart<D>>> own);

}  // namespace camber

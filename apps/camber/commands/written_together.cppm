module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <vector>
export module camber.commands:written_together;
import camber.core;
import camber.distributed;
import camber.io;

export namespace camber::app {

/// A file of so many bytes that all ranks write, each its pieces; it has its name once all have done so. All ranks call
/// it, also one whose pieces failed: none writes then. Errors: of any rank; write, stopped.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           const Outcome<std::span<const FilePiece>>& pieces,
                                           const Execution& execution);

/// The same of pieces that are made a few at a time, in so many turns; all ranks make theirs in each turn together.
[[nodiscard]] Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                                           std::size_t turns,
                                           const std::function<Outcome<std::vector<FilePiece>>(std::size_t)>& pieces_of,
                                           const Execution& execution);

/// A .meshb of these totals and lists that all ranks write so: in each turn a part of its rows, and along with the
/// first rank's first what the file begins and ends with.
template <int D, int Degree>
[[nodiscard]] Outcome<Done> write_meshb_together(
    Ranks& ranks, const std::string& path, const PartTotals& totals, const LinearMesh<D>& lists, std::size_t turns,
    const std::function<Outcome<FilePart<D, Degree>>(std::size_t)>& part_of, const Execution& execution) {
    const auto frame = gmf_frame<D, Degree>(totals, lists);
    if (!frame) return fail(frame.error());
    const Execution quiet = without_progress(execution);
    const auto pieces_of = [&](std::size_t turn) -> Outcome<std::vector<FilePiece>> {
        const auto part = part_of(turn);
        if (!part) return fail(part.error());
        auto pieces = encode_gmf_part<D, Degree>(*frame, *part, quiet);
        if (!pieces || turn > 0 || ranks.rank() > 0) return pieces;
        auto rest = encode_gmf_frame<D, Degree>(*frame, lists, quiet);
        if (!rest) return rest;
        std::ranges::move(*rest, std::back_inserter(*pieces));
        return pieces;
    };
    return write_together(ranks, path, frame->bytes, turns, pieces_of, execution);
}

}  // namespace camber::app

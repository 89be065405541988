module;
#include <cstddef>
#include <cstdint>
#include <functional>
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

}  // namespace camber::app

module;
#include <cstdint>
#include <span>
#include <string>
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

}  // namespace camber::app

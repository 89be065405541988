module;
#include <cstddef>
#include <optional>
#include <string>
export module camber.commands:generate_rows;
import camber.core;
import camber.config;
import camber.distributed;
import camber.io;
import camber.run;

export namespace camber::app {

/// Whether the shape is made by rows, and so by several ranks. Errors: those of the shape; unsupported, with what to
/// do.
[[nodiscard]] Outcome<Done> check_goes_by_rows(const config::Shape& shape);

/// The shape's mesh in a .meshb, to which each rank writes the rows that it makes, a few at a time: the bytes are those
/// of the mesh as a whole. What it is, on all ranks. Errors: of any rank; those of the shape, write, stopped.
[[nodiscard]] Outcome<run::PlanSize> write_by_rows(Ranks& ranks, const config::Shape& shape, const std::string& path,
                                                   const Execution& execution);

}  // namespace camber::app

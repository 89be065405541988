module;
#include <cstddef>
export module camber.cad:samples;
import camber.core;
import camber.surface;
import :model;

export namespace camber {

/// Points of a model's faces, by parameters within their trims, and of its edges: about `wanted` on faces, as many a
/// unit of area on each, but for small ones, which have some. Numbers of entities are those of the model; seams, along
/// which a face meets itself, are among its edges. Errors: stopped.
[[nodiscard]] Outcome<GeometrySamples<3>> samples_of(const CadModel& model, std::size_t wanted,
                                                     const Execution& execution);

}  // namespace camber

module;
#include <cstddef>
export module camber.cad:samples;
import camber.core;
import camber.surface;
import :model;

export namespace camber {

/// Points of a model's faces, by parameters within their trims, and of its edges: about `wanted` on faces, as many a
/// unit of area on each, but for small ones, which have some. Numbers of entities are those of the model; seams, along
/// which a face meets itself, are among its edges. In 2D points of its curves alone (curves_of), as many a unit of
/// length. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of(const CadModel& model, std::size_t wanted,
                                                     const Execution& execution);

/// Those of the entities of which `is_wanted(entity)`.
template <int D, class IsWanted>
[[nodiscard]] Outcome<GeometrySamples<D>> part_of_samples(const GeometrySamples<D>& whole, IsWanted&& is_wanted) {
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        GeometrySamples<D> part;
        for (const auto& [entity, begin, end] : whole.entities) {
            if (!is_wanted(entity)) continue;
            part.begin(entity);
            for (std::size_t i = begin; i < end; ++i) part.add(whole.points[i], whole.weights[i]);
        }
        return part;
    });
}

}  // namespace camber

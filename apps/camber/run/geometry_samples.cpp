module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.surface;
import :distances_report;

namespace camber::run {

namespace {

std::size_t samples_for(std::size_t facets) {
    constexpr std::size_t a_facet = 16, least = 4096, most = 4000000;
    return std::clamp(a_facet * facets, least, most);
}

/// Surfaces and numbered curves that there are points of.
class Sampled {
  public:
    template <int D>
    explicit Sampled(const GeometrySamples<D>& samples) {
        keys_.reserve(samples.entities.size());
        for (const auto& [entity, begin, end] : samples.entities) keys_.emplace_back(entity.kind, entity.id);
        std::sort(keys_.begin(), keys_.end());
    }
    [[nodiscard]] bool has(const GeometryEntity& entity) const {
        return entity.id != GeometryEntity::unnumbered &&
               std::binary_search(keys_.begin(), keys_.end(), std::pair(entity.kind, entity.id));
    }

  private:
    std::vector<std::pair<GeometryKind, std::int64_t>> keys_;
};

}  // namespace

template <int D>
Outcome<GeometrySamples<D>> samples_of_geometry(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    auto own = geometry->own_samples(samples_for(mesh.linear.facets.size()), part_of(execution, 0, 0.5));
    if (!own) return own;
    if (own->entities.empty()) return samples_over(mesh, features, geometry, part_of(execution, 0.5, 1));
    const Sampled sampled(*own);
    const auto elsewhere = reduce_each(
        part_of(execution, 0.5, 0.6), mesh.linear.facets.size(), std::size_t{0},
        [&](std::size_t& count, std::size_t f) {
            count += sampled.has(geometry->surface_at(facet_site(mesh.linear, FacetId(f)))) ? 0 : 1;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
    if (!elsewhere) return fail(elsewhere.error());
    if (*elsewhere == 0) return own;
    const auto over = samples_over(mesh, features, geometry, part_of(execution, 0.6, 1));
    if (!over) return fail(over.error());
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        for (const auto& [entity, begin, end] : over->entities) {
            if (sampled.has(entity)) continue;
            own->begin(entity);
            for (std::size_t i = begin; i < end; ++i) own->add(over->points[i], over->weights[i], over->near[i]);
        }
        return std::move(*own);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<GeometrySamples<D>> samples_of_geometry<D>(const QuadraticMesh<D>&, const Features<D>&, \
                                                                const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.solution_metric;
import camber.surface;
import :geometry_sizes;

namespace camber {

namespace {

/// The patches of those facets that ask; others have none.
template <int D>
Outcome<Column<std::uint32_t>> asking_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                              const std::vector<Reference>& references) {
    if (references.empty()) return features.patches;
    const auto& of = mesh.facets.references;
    for (const Reference r : references)
        if (std::ranges::find(of, r) == of.end())
            return fail(ErrorKind::usage, "no facet has the reference " + std::to_string(r), {}, {},
                        "see which references the mesh has: camber info");
    Buffer<std::uint32_t> patches(of.size());
    for (std::size_t f = 0; f < patches.size(); ++f)
        patches[f] = std::ranges::find(references, of[f]) == references.end() ? no_patch : features.patches[f];
    return Column<std::uint32_t>(std::move(patches));
}

template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> sizes_of(const auto& mesh, const LinearMesh<D>& linear,
                                                    const Features<D>& features, const GeometrySizes& asked,
                                                    double largest, const Execution& execution) {
    if (!asked.are_asked())
        return fail(ErrorKind::usage, "nothing is asked of the geometry", {}, {},
                    "give chord_error, angle or gap_elements");
    const auto patches = asking_patches(linear, features, asked.references);
    if (!patches) return fail(patches.error());
    std::vector<MetricsAtVertices<D>> parts;
    if (asked.gap_elements > 0) {
        auto across =
            gap_metrics(linear, *patches, {.elements = asked.gap_elements}, largest, part_of(execution, 0, 0.5));
        if (!across) return fail(across.error());
        parts.push_back(std::move(*across));
    }
    if (!(asked.chord_error > 0) && !(asked.angle > 0)) return parts;
    const ChordOptions options{asked.chord_error, asked.angle, asked.normal_ratio};
    auto chords = chord_metrics(mesh, *patches, options, largest, part_of(execution, 0.5, 1));
    if (!chords) return fail(chords.error());
    parts.push_back(std::move(*chords));
    return parts;
}

}  // namespace

template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const LinearMesh<D>& mesh, const Features<D>& features,
                                                          const GeometrySizes& asked, double largest,
                                                          const Execution& execution) {
    return sizes_of(mesh, mesh, features, asked, largest, execution);
}
template <int D>
Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                          const GeometrySizes& asked, double largest,
                                                          const Execution& execution) {
    return sizes_of(mesh, mesh.linear, features, asked, largest, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes<D>(                         \
        const LinearMesh<D>&, const Features<D>&, const GeometrySizes&, double, const Execution&); \
    template Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes<D>(                         \
        const QuadraticMesh<D>&, const Features<D>&, const GeometrySizes&, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

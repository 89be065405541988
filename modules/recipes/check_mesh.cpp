module;
#include <optional>
#include <utility>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.soundness;
import camber.validity;
import :check_mesh;

namespace camber {

namespace {

template <int D>
Outcome<QuadraticMesh<D>> of_degree_2(const LinearMesh<D>& mesh, const Execution& execution) {
    return elevate(mesh, execution);
}
template <int D>
Outcome<QuadraticMesh<D>> of_degree_2(const QuadraticMesh<D>& mesh, const Execution&) {
    return mesh;
}

/// Finds overlaps in a mesh whose crossings are known. Where `prepare` turns elements or adds facets, its mesh is
/// examined, the elements of which have the same numbers.
template <int D>
Outcome<Overlaps<D>> checked_overlaps(const CheckedWalls<D>& walls, bool is_listed, const Soundness& soundness,
                                      const Execution& execution) {
    if (soundness[Defect::repeated_element].count > 0) return Overlaps<D>{};
    const bool is_prepared =
        !is_listed || (soundness[Defect::reversed_element].count == 0 && soundness[Defect::repeated_facet].count == 0 &&
                       soundness[Defect::missing_facet].count == 0);
    if (is_prepared) return find_overlaps(walls.mesh, walls.crossings, execution);
    const Execution quiet = without_progress(execution);
    const auto prepared = prepare(walls.mesh, quiet);
    if (!prepared) return Overlaps<D>{};
    const auto crossings = find_crossings(prepared->mesh, quiet);
    if (!crossings) return fail(crossings.error());
    return find_overlaps(prepared->mesh, *crossings, quiet);
}

/// What has fatal defects may be all at one place, each facet near each other one.
template <int D>
Outcome<std::optional<CheckedWalls<D>>> checked_walls(const QuadraticMesh<D>& mesh, const Soundness& soundness,
                                                      const Execution& execution) {
    if (refusal(soundness)) return std::nullopt;
    const bool is_listed = mesh.linear.facets.size() > 0 || mesh.linear.elements.size() == 0;
    const double of_listing = is_listed ? 0 : 0.7;
    CheckedWalls<D> walls{mesh, {}};
    if (!is_listed) {
        auto listed = prepare(mesh, part_of(execution, 0, of_listing));
        if (!listed) return std::nullopt;
        walls.mesh = std::move(listed->mesh);
    }
    auto crossings = find_crossings(walls.mesh, part_of(execution, of_listing, 0.9));
    if (!crossings) return fail(crossings.error());
    walls.crossings = std::move(*crossings);
    auto overlaps = checked_overlaps(walls, is_listed, soundness, part_of(execution, 0.9, 1));
    if (!overlaps) return fail(overlaps.error());
    walls.overlaps = std::move(*overlaps);
    return walls;
}

template <int D, class Mesh>
Outcome<MeshCheck<D>> checked(const Mesh& mesh, double of_elevation, const MeshCheckOptions& options,
                              const Around& around) {
    MeshCheck<D> check;
    auto soundness = run_step(around, "examine", [&](const Execution& e) { return examine(mesh, options.examine, e); });
    if (!soundness) return fail(soundness.error());
    check.soundness = std::move(*soundness);
    auto validation = run_step(around, "validate", [&](const Execution& e) -> Outcome<Validation<D>> {
        auto quadratic = of_degree_2(mesh, part_of(e, 0, of_elevation));
        if (!quadratic) return fail(quadratic.error());
        check.mesh = std::move(*quadratic);
        return validate(check.mesh, options.min_scaled_jacobian, part_of(e, of_elevation, 1));
    });
    if (!validation) return fail(validation.error());
    check.validation = std::move(*validation);
    auto walls =
        run_step(around, "cross", [&](const Execution& e) { return checked_walls(check.mesh, check.soundness, e); });
    if (!walls) return fail(walls.error());
    check.walls = std::move(*walls);
    return check;
}

}  // namespace

template <int D>
Outcome<MeshCheck<D>> check_mesh(const LinearMesh<D>& mesh, const MeshCheckOptions& options, const Around& around) {
    return checked<D>(mesh, 0.7, options, around);
}
template <int D>
Outcome<MeshCheck<D>> check_mesh(const QuadraticMesh<D>& mesh, const MeshCheckOptions& options, const Around& around) {
    return checked<D>(mesh, 0, options, around);
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<MeshCheck<D>> check_mesh<D>(const LinearMesh<D>&, const MeshCheckOptions&, const Around&); \
    template Outcome<MeshCheck<D>> check_mesh<D>(const QuadraticMesh<D>&, const MeshCheckOptions&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <optional>
#include <span>
#include <utility>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.surface;
import :boundary;

namespace camber {

namespace {

template <int D>
Outcome<Geometry<D>> surrogate_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                  std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    auto straight =
        build_surrogate(mesh, edges, features, SurrogateOptions{}, part_of(execution, 0, nodes.empty() ? 1 : 0.3));
    if (!straight) return fail(straight.error());
    if (nodes.empty()) return Geometry<D>(std::move(*straight));
    auto curved = with_curves<D>(std::move(*straight), mesh, edges, features, nodes, StraightGeometry<D>{},
                                 SurrogateOptions{}, part_of(execution, 0.3, 1));
    if (!curved) return fail(curved.error());
    return Geometry<D>(std::move(curved->surrogate));
}

}  // namespace

template <int D>
Outcome<Boundary<D>> find_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const std::optional<Geometry<D>>& given, const BoundaryOptions<D>& options,
                                   const Execution& execution, std::span<const LagrangeNode<D>> nodes) {
    auto features = find_features(mesh, edges, options.features, part_of(execution, 0, given ? 1 : 0.3));
    if (!features) return fail(features.error());
    if (given) return Boundary<D>{std::move(*features), options.required, *given};
    auto made = surrogate_of(mesh, edges, *features, nodes, part_of(execution, 0.3, 1));
    if (!made) return fail(made.error());
    return Boundary<D>{std::move(*features), options.required, std::move(*made)};
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<Boundary<D>> find_boundary<D>(const LinearMesh<D>&, const EdgeSet<D>&,                      \
                                                   const std::optional<Geometry<D>>&, const BoundaryOptions<D>&, \
                                                   const Execution&, std::span<const LagrangeNode<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

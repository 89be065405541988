module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>
module camber.repair;
import :by_optimisation;
import :guide;
import :min_invalid;
import :local_extension;
import :moved_mesh;
import :surface_alone;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.curving;

namespace camber {

namespace {

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RepairGuide<D>& guide) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges ||
        guide.shells.size() != edges || (!guide.home.empty() && guide.home.size() != edges))
        return fail(ErrorKind::internal, "the proposal or the guide has another number of edges than the mesh");
    if (!guide.models || !guide.wanted)
        return fail(ErrorKind::internal, "the guide has no models, which this method of repair needs");
    return Done{};
}

/// Effort of each repair after the first, as a share.
constexpr double share_of_retries = 0.25;

/// What is prescribed is left that elements be valid, for no higher bound.
template <int D>
bool stays_on_geometry(const RepairGuide<D>& guide, double bound) {
    return guide.onto && bound > min_bound;
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide, const RepairOptions& options,
                            const Execution& execution) {
    if constexpr (D == 3)
        if (is_surface_alone(wanted.mesh().linear))
            return repair_surface(wanted, guide, options, {guide.surface == SurfaceMoves::off_geometry}, execution);
    if (!needs_models(options.method)) return relax(wanted, options, execution);
    if (auto fits = check_limits(options); !fits) return fail(fits.error());
    if (wanted.validation().bound != options.min_scaled_jacobian.value) {
        const auto again =
            validate(wanted.mesh(), wanted.proposal(), options.min_scaled_jacobian, without_progress(execution));
        if (!again) return fail(again.error());
        return repair(*again, guide, options, execution);
    }
    if (wanted.validation().all_valid()) return Repaired<D>{wanted};
    if (auto fits = check(wanted.mesh(), wanted.proposal(), guide); !fits) return fail(fits.error());
    return guarded([&] { return repair_by_optimisation(wanted, guide, options, execution); });
}

template <int D>
Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution) {
    const auto to = [&](const JudgedProposal<D>& judged, const RepairOptions& of) {
        RepairGuide<D> by = guide;
        if (stays_on_geometry(guide, of.min_scaled_jacobian)) by.surface = SurfaceMoves::on_geometry;
        return repair(judged, by, of, execution);
    };
    const auto again = [&](const JudgedProposal<D>& judged, RepairOptions of) {
        of.effort *= share_of_retries;
        return to(judged, of);
    };
    auto kept = min_invalid(wanted, to(wanted, options), options, execution, again);
    if (is_surface_alone(wanted.mesh().linear)) return kept;  // chords were tried
    if (!kept || kept->judged.validation().all_valid()) return kept;
    // The surface is not left for a bound that is only recommended.
    RepairOptions demanded = options;
    if (!options.min_scaled_jacobian.is_asked || stays_on_geometry(guide, options.min_scaled_jacobian))
        demanded.min_scaled_jacobian = min_bound;
    const Execution quiet = without_progress(execution);
    const auto restored = [&] { return restore_input(wanted, std::move(*kept), demanded, quiet); };
    if (!has_cavities(options.method)) return restored();
    const auto judged_for = [&](const JudgedProposal<D>& judged, double bound) {
        return validate(judged.mesh(), judged.proposal(), bound, quiet);
    };
    const auto before = judged_for(kept->judged, demanded.min_scaled_jacobian);
    if (!before) return fail(before.error());
    auto done = relax(*before, demanded, quiet);
    if (!done) return fail(done.error());
    if (done->judged.validation().not_valid() >= before->validation().not_valid()) return restored();
    auto judged = judged_for(done->judged, options.min_scaled_jacobian);
    if (!judged) return fail(judged.error());
    kept->judged = std::move(*judged);
    std::erase_if(kept->given_up, [&](ElementId e) { return kept->judged.validation().verdicts[e] == Verdict::valid; });
    kept = with_all_changes(wanted, std::move(*kept));
    return restored();
}

template <int D>
Outcome<Incidence<ElementId>> holders_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution) {
    if (!is_surface_alone(mesh.linear)) return shells(mesh.edges, execution);
    auto triangles = facet_shells(mesh.edges, execution);
    if (!triangles) return fail(triangles.error());
    return guarded([&]() -> Outcome<Incidence<ElementId>> {
        Buffer<ElementId> items;
        items.reserve(triangles->items.size());
        for (const FacetId f : triangles->items) items.emplace_back(f.index());
        return Incidence<ElementId>{triangles->offsets, std::move(items)};
    });
}

template <int D>
Outcome<RepairGuide<D>> own_guide(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                  const Execution& execution) {
    const MovedMesh<D> moved(judged);
    const auto broken = elements_not_valid(judged.validation());
    auto extended = extend_around(moved, judged.proposal().kinds, shells, broken, 1, execution);
    if (!extended) return fail(extended.error());
    SparseMap<EdgeId, LagrangeNode<D>> wanted;
    for (const ElementId e : broken)
        for (const EdgeId edge : judged.mesh().edges.of_elements[e])
            if (const auto* node = extended->nodes.find(edge)) wanted.at(edge) = *node;
    // Models are about places of the mesh's own vertices.
    const auto centre = [moved, wanted = std::move(wanted)](EdgeId edge) {
        const LagrangeNode<D>* node = wanted.find(edge);
        return LagrangeNode<D>{(node ? *node : moved.nodes[edge]).point - moved.shift(edge)};
    };
    return RepairGuide<D>{shells, centre, [mesh = judged.mesh(), shells, centre](EdgeId edge) {
                              return implied_edge_model(mesh, edge, centre(edge), shells[edge]);
                          }};
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Repaired<D>> repair<D>(const JudgedProposal<D>&, const RepairGuide<D>&, const RepairOptions&, \
                                            const Execution&);                                                     \
    template Outcome<Repaired<D>> repair_or_straighten<D>(const JudgedProposal<D>&, const RepairGuide<D>&,         \
                                                          const RepairOptions&, const Execution&);                 \
    template Outcome<Incidence<ElementId>> holders_of_edges<D>(const QuadraticMesh<D>&, const Execution&);         \
    template Outcome<RepairGuide<D>> own_guide<D>(const JudgedProposal<D>&, const Incidence<ElementId>&,           \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <optional>
#include <string>
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.metric;
import camber.programmes;
import camber.validity;
import :mend;
import :parts;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

template <int D>
Outcome<Column<QuadraticModel<D>>> models_for(const Column<LagrangeNode<D>>& wanted, const Incidence<ElementId>& shells,
                                              const JudgedProposal<D>& judged, const BackMesh<D>* field,
                                              const Execution& execution) {
    auto models = field ? edge_models(judged.mesh(), wanted, judged.validation(), shells, *field, execution)
                        : implied_edge_models(judged.mesh(), wanted, shells, execution);
    if (!models) return fail(models.error());
    return Column<QuadraticModel<D>>(std::move(*models));
}

template <int D>
RelaxReport relax_report(const Mended<D>& mended, config::Repair repair) {
    return {std::string(word_of(repair)), mended.corrected_elements, mended.moved_volume_nodes,
            mended.moved_surface_nodes,   mended.moved_vertices,     mended.work,
            mended.given_up.size()};
}

}  // namespace

template <int D>
Outcome<Column<QuadraticModel<D>>> models_of(const Plan<D>& plan, const JudgedProposal<D>& judged,
                                             const BackMesh<D>* field, config::Repair repair,
                                             const Execution& execution) {
    if (!needs_models(repair)) return Column<QuadraticModel<D>>();
    if (const Wanted<D>* wanted = plan.wanted())
        return models_for(wanted->curved.proposal.mid_nodes, wanted->shells, judged, field, execution);
    const auto around = shells(judged.mesh().edges, execution);
    if (!around) return fail(around.error());
    const auto wishes = own_wishes(judged, *around, execution);
    if (!wishes) return fail(wishes.error());
    return models_for(*wishes, *around, judged, field, execution);
}

template <int D>
Outcome<Relaxed<D>> relax_stage(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                                const config::Relax& options, const Execution& execution) {
    auto mended = mend_or_straighten(judged, models, options, execution);
    if (!mended) return fail(mended.error());
    CorrectionReport report{relax_report(*mended, options.repair), {}, remaining_but_for_shape(*mended)};
    return Relaxed<D>{std::move(mended->judged), std::move(report)};
}

template <int D>
Outcome<Relaxed<D>> relax_within_stage(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                                       const config::Relax& options, const Execution& execution) {
    auto mended = mend_within(judged, models, options, execution);
    if (!mended) return fail(mended.error());
    CorrectionReport report{relax_report(*mended, options.repair),
                            kept_boundary(judged.mesh(), mended->judged.proposal(), options.boundary_tolerance),
                            remaining(*mended)};
    return Relaxed<D>{std::move(mended->judged), std::move(report)};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<Column<QuadraticModel<D>>> models_of<D>(const Plan<D>&, const JudgedProposal<D>&,              \
                                                             const BackMesh<D>*, config::Repair, const Execution&); \
    template Outcome<Relaxed<D>> relax_stage<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,         \
                                                const config::Relax&, const Execution&);                            \
    template Outcome<Relaxed<D>> relax_within_stage<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,  \
                                                       const config::Relax&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

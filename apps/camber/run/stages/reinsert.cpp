module;
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
module camber.run;
import camber.core;
import camber.cavity;
import camber.config;
import camber.metric;
import camber.validity;
import :mend;
import :parts;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

/// What the cavities' relaxations came to, in the figures of a relaxation of the whole.
template <int D>
RelaxReport relax_report(const Validation<D>& wanted, const Validation<D>& now, const Reinserted<D>& done,
                         config::Repair repair) {
    RelaxReport r{.repair = std::string(word_of(repair))};
    for (std::size_t e = 0; e < now.verdicts.size(); ++e)
        r.corrected_elements += wanted.verdicts[e] != Verdict::valid && now.verdicts[e] == Verdict::valid;
    for (std::size_t e = 0; e < done.proposal.mid_nodes.size(); ++e) {
        if (done.proposal.mid_nodes[e] == done.wanted.proposal.mid_nodes[e]) continue;
        ++(done.proposal.kinds[e] == EdgeKind::volume ? r.relaxed_volume_edges : r.relaxed_surface_edges);
    }
    return r;
}

/// The repair that a cavity's relaxation stands for.
config::Repair repair_of(const config::Relax& options) {
    return options.repair == config::Repair::relax ? config::Repair::relax : config::Repair::segment;
}

}  // namespace

template <int D>
Outcome<Walked<D>> reinsert_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input, const BackMesh<D>& field,
                                  const config::Reinsert& options, const Execution& execution) {
    const ReinsertAllOptions all{{edge_options(options.curve), relax_options(options.relax)}, options.max_turns};
    auto done = reinsert_all(mesh, input.kinds, input.boundary_nodes, field, all, execution);
    if (!done) return fail(done.error());
    const double bound = options.relax.min_scaled_jacobian;
    const auto judged = validate(mesh, done->wanted.proposal, bound, execution);
    if (!judged) return fail(judged.error());
    const Validation<D>& wanted = judged->validation();
    auto validation = validate(done->mesh, bound, execution);
    if (!validation) return fail(validation.error());

    const ReinsertStatistics& s = done->statistics;
    CavitiesReport report{curve_report(mesh, done->wanted), verdicts_report(wanted).summary,
                          relax_report(wanted, *validation, *done, repair_of(options.relax)),
                          ReinsertReport{s.turns, s.rounds, s.patches, s.not_valid, s.no_gain}};
    Notices notices;
    if (s.left > 0) notices.push_back(std::to_string(s.left) + " vertices could have another turn: max_turns ended it");
    return Walked<D>{std::move(*done), wanted, std::move(*validation), std::move(report), std::move(notices)};
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<Walked<D>> reinsert_stage<D>(const QuadraticMesh<D>&, const CurveInput<D>&, const BackMesh<D>&, \
                                                  const config::Reinsert&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

module;
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.validity;
import :parts;
import :runner;
import :state;
import :steps;

namespace camber::run {

namespace {

/// The proposal becomes the mesh's, valid or not: what is not is in the report, and the program's exit code.
template <int D>
Outcome<QuadraticMesh<D>> committed(const JudgedProposal<D>& judged) {
    if (!judged.validation().certified()) return commit_uncertified(judged).mesh;
    auto done = commit(judged);
    if (!done) return fail(done.error());
    return std::move(done->mesh);
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Commit& options) {
    if (auto adopted = adopt_own_nodes(run); !adopted) return adopted;
    return run.step_of(options, [&](const Execution& e) -> Outcome<Done> {
        if (!run.plan().judged())
            if (auto done = judge_plan(run, bound_for(run, {}), e); !done) return done;
        const JudgedProposal<D> judged = *run.plan().judged();
        auto mesh = committed(judged);
        if (!mesh) return fail(mesh.error());
        run.quadratic().mesh = std::move(*mesh);
        run.plan().places = CommittedPlaces<D>{judged.proposal(), judged.validation()};
        run.report(CommitReport{});
        return Done{};
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> apply<D>(Runner<D>&, const config::Commit&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

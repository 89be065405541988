module;
#include <utility>
module camber.run;
import camber.core;
import camber.validity;
import :stages;

namespace camber::run {

template <int D>
Outcome<QuadraticMesh<D>> commit_stage(const JudgedProposal<D>& judged) {
    if (!judged.validation().certified()) return commit_uncertified(judged).mesh;
    auto committed = commit(judged);
    if (!committed) return fail(committed.error());
    return std::move(committed->mesh);
}

template Outcome<QuadraticMesh<2>> commit_stage<2>(const JudgedProposal<2>&);
template Outcome<QuadraticMesh<3>> commit_stage<3>(const JudgedProposal<3>&);

}  // namespace camber::run

module;
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import :runner;
import :state;
import :steps;

namespace camber::run {

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Elevate& options) {
    auto mesh =
        run.step_of(options, [&](const Execution& e) { return elevate(std::get<LinearMesh<D>>(run.state.mesh), e); });
    if (!mesh) return fail(mesh.error());
    run.state.mesh = Quadratic<D>{std::move(*mesh), NodesOf::elevation, Unplanned<D>{}};
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> apply<D>(Runner<D>&, const config::Elevate&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

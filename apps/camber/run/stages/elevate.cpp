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

template Outcome<Done> apply<2>(Runner<2>&, const config::Elevate&);
template Outcome<Done> apply<3>(Runner<3>&, const config::Elevate&);

}  // namespace camber::run

module;
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.soundness;
import :stages;
import :state;

namespace camber::run {

template <int D>
Outcome<Sound<D>> prepare_stage(GivenMesh<D> mesh, const Execution& execution) {
    return std::visit(
        [&](auto given) -> Outcome<Sound<D>> {
            auto prepared = prepare(std::move(given), execution);
            if (!prepared) return fail(prepared.error());
            return Sound<D>{std::move(prepared->mesh), std::move(prepared->notices)};
        },
        std::move(mesh));
}

template Outcome<Sound<2>> prepare_stage<2>(GivenMesh<2>, const Execution&);
template Outcome<Sound<3>> prepare_stage<3>(GivenMesh<3>, const Execution&);

}  // namespace camber::run

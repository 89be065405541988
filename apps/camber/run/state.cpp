module;
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.operation;
import camber.adapt;
import camber.surface;
import camber.recipes;
import camber.validity;
import camber.curving;
import :state;

namespace camber::run {

template <int D>
const Features<D>& Plan<D>::features() const {
    const Wanted<D>* const there = wanted();
    return there ? there->boundary.features : std::get<OwnNodes<D>>(origin).features;
}

template <int D>
const Proposal<D>& Plan<D>::proposal() const {
    if (const auto* there = judged()) return there->proposal();
    if (const auto* committed = std::get_if<CommittedPlaces<D>>(&places)) return committed->proposal;
    return std::get<Proposal<D>>(places);
}

template <int D>
const Validation<D>* Plan<D>::validation() const {
    if (const auto* there = judged()) return &there->validation();
    const auto* committed = std::get_if<CommittedPlaces<D>>(&places);
    return committed ? &committed->validation : nullptr;
}

template <int D>
const Validation<D>* Quadratic<D>::validation() const {
    if (const Plan<D>* there = planned()) return there->validation();
    const auto& own = std::get<Unplanned<D>>(plan).validation;
    return own ? &*own : nullptr;
}

template <int D>
bool Quadratic<D>::boundary_is_given() const {
    if (nodes != NodesOf::input) return false;
    const Wanted<D>* const wanted = planned() ? planned()->wanted() : nullptr;
    return !wanted || !wanted->boundary.geometry->prescribes_any();
}

template <int D>
bool Quadratic<D>::has_uncommitted() const {
    if (!planned()) return false;
    const Proposal<D>& proposal = planned()->proposal();
    return proposal.points != mesh.linear.points || proposal.mid_nodes != mesh.mid_nodes;
}

template <int D>
State<D> beginning_with(GivenMesh<D> mesh) {
    State<D> state;
    if (auto* curves = std::get_if<QuadraticMesh<D>>(&mesh)) {
        state.given_points = curves->linear.points;
        state.given_nodes = curves->mid_nodes;
        state.mesh = Quadratic<D>{std::move(*curves), NodesOf::input, Unplanned<D>{}};
    } else {
        auto& straight = std::get<LinearMesh<D>>(mesh);
        state.given_points = straight.points;
        state.mesh = std::move(straight);
    }
    return state;
}

#define CAMBER_INSTANTIATE(D)     \
    template struct Plan<D>;      \
    template struct Quadratic<D>; \
    template State<D> beginning_with<D>(GivenMesh<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

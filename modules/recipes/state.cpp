module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.surface;
import camber.operation;
import camber.curving;
import camber.stages;

namespace camber::run {

template <int D>
const Features<D>& Plan<D>::features() const {
    const CurvingTarget<D>* const there = target();
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
bool Quadratic<D>::is_boundary_from_input() const {
    if (nodes != NodesOf::input) return false;
    const CurvingTarget<D>* const target = planned() ? planned()->target() : nullptr;
    return !target || !target->boundary.geometry->prescribes_any();
}

template <int D>
bool Quadratic<D>::has_uncommitted() const {
    if (!planned()) return false;
    const Proposal<D>& proposal = planned()->proposal();
    return proposal.points != mesh.linear.points || proposal.mid_nodes != mesh.mid_nodes;
}

template <int D>
Outcome<State<D>> beginning_with(Mesh<D> mesh) {
    State<D> state;
    state.input_points = mesh.points;
    state.input_nodes = mesh.edge_nodes;
    auto started = on_simplices(std::move(mesh), [&](auto simplices) -> Outcome<Done> {
        if constexpr (std::is_same_v<decltype(simplices), LinearMesh<D>>)
            state.mesh = std::move(simplices);
        else
            state.mesh = Quadratic<D>{std::move(simplices), NodesOf::input, Unplanned<D>{}};
        return Done{};
    });
    if (!started) return fail(std::move(started.error()));
    return state;
}

namespace {

struct Row {
    std::string name;
    RunContent least, most;
    std::optional<RunContent> result_content;
    Places places;
};

Row row_of(const config::Stage& stage) {
    return std::visit(
        []<class Options>(const Options&) {
            const auto& row = std::get<Step<Options>>(step_table);
            return Row{std::string(row.name), row.least, row.most, row.result_content, row.places};
        },
        stage);
}

std::string_view first_stage_for(RunContent target) {
    std::string_view stage_name;
    std::apply(
        [&](const auto&... rows) {
            ((stage_name = stage_name.empty() && rows.result_content == target ? rows.name : stage_name), ...);
        },
        step_table);
    return stage_name;
}

Error too_little(const Row& row, RunContent now) {
    // A stage that makes no new content needs a quadratic mesh; before others, `elevate` is missing.
    if (now == RunContent::straight_mesh && !row.result_content)
        return {ErrorKind::input,
                "the mesh has degree 1, but stage \"" + row.name + "\" requires degree 2",
                {},
                {},
                "curve the mesh with camber curve; in a config, add \"elevate\" before this stage"};
    const RunContent missing = now == RunContent::straight_mesh ? RunContent::curved_mesh : row.least;
    return {ErrorKind::usage,
            "stage \"" + row.name + "\" needs \"" + std::string(first_stage_for(missing)) + "\" before it",
            {},
            {},
            {}};
}

/// Error of `elevate` on a mesh that is quadratic.
Error too_much(int degree) {
    if (degree == 1)
        return {ErrorKind::usage,
                "the mesh is quadratic already, since an earlier stage is \"elevate\"",
                {},
                {},
                "remove one of these stages"};
    return {ErrorKind::input,
            "the mesh is quadratic already",
            {},
            {},
            "give the straight mesh, or remove the stage \"elevate\": stages=[\"curve\", \"validate\", \"relax\", "
            "\"commit\"]"};
}

Error not_committed(const Row& row) {
    return {ErrorKind::usage,
            "stage \"" + row.name + "\" changes the mesh, but planned positions of its nodes are not committed",
            {},
            {},
            "add \"commit\" before it"};
}

}  // namespace

Outcome<Done> check_order(std::span<const config::Stage> stages, int degree) {
    RunContent now = degree == 1 ? RunContent::straight_mesh : RunContent::planned_nodes;
    bool committed = true;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        const Row row = row_of(stages[i]);
        const bool fits = row.least <= now && now <= row.most;
        if (fits && (committed || row.places != Places::refuses)) {
            now = row.result_content.value_or(now);
            if (row.places == Places::plans) committed = false;
            if (row.places == Places::commits) committed = true;
            continue;
        }
        Error error = fits ? not_committed(row) : now < row.least ? too_little(row, now) : too_much(degree);
        if (error.kind == ErrorKind::usage) error.where = "/stages/" + std::to_string(i);
        return fail(std::move(error));
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)     \
    template struct Plan<D>;      \
    template struct Quadratic<D>; \
    template Outcome<State<D>> beginning_with<D>(Mesh<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run

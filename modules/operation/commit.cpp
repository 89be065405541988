module;
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.operation;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.surface;

namespace camber {

namespace {

/// What was known of each patch, one after the other.
struct Known {
    std::vector<double> shapes;   ///< of created elements
    std::vector<double> lengths;  ///< of edges at the points
    std::vector<EdgeId> bent;     ///< other edges, which have new nodes
};

template <int D>
void follow_shapes(Adaptation<D>& state, std::span<const ElementId> created, std::span<const double> judged) {
    if (state.shapes.empty()) return;
    auto shapes = take(std::move(state.shapes));
    shapes.resize(state.mesh.elements.size(), -1.0);
    for (std::size_t i = 0; i < created.size(); ++i) shapes[created[i].index()] = judged[i];
    state.shapes = std::move(shapes);
}
template <int D>
void follow_lengths(Adaptation<D>& state, std::span<const EdgeId> spokes, std::span<const double> judged,
                    std::span<const EdgeId> bent) {
    if (!state.mesh.is_curved()) return;
    auto lengths = take(std::move(state.lengths));
    lengths.resize(state.mesh.edges.size());
    for (std::size_t i = 0; i < spokes.size(); ++i) lengths[spokes[i].index()] = judged[i];
    for (const EdgeId edge : bent) lengths[edge.index()] = measured_length(state, edge);
    state.lengths = std::move(lengths);
}

}  // namespace

template <int D>
Outcome<CommittedState<D>> commit(Adaptation<D> state, std::vector<JudgedPatch<D>> judged) {
    return guarded([&]() -> Outcome<CommittedState<D>> {
        std::vector<VertexRow<D>> rows;
        std::vector<bool> are_short;
        Known known;
        std::vector<Patch<D>> patches;
        for (JudgedPatch<D>& patch : judged) {
            rows.push_back(patch.vertex());
            are_short.push_back(patch.is_short_of_geometry());
            known.shapes.insert(known.shapes.end(), patch.shapes().begin(), patch.shapes().end());
            known.lengths.insert(known.lengths.end(), patch.lengths().begin(), patch.lengths().end());
            for (const FollowingNode<D>& edge : patch.patch().following) known.bent.push_back(edge.edge);
            patches.push_back(std::move(patch).take_patch());
        }
        auto changed = replace_cavities<D>(std::move(state.mesh), patches);
        if (!changed) return fail(changed.error());
        auto& [mesh, changes] = *changed;
        state.mesh = std::move(mesh);
        state.vertices.put(changes.points, rows, state.mesh.points.size());
        auto off_geometry = take(std::move(state.off_geometry));
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (are_short[i]) off_geometry.push_back(changes.points[i]);
        state.off_geometry = std::move(off_geometry);
        state.refusals.follow(state.mesh, std::span(std::as_const(changes.elements.created)));
        follow_shapes<D>(state, changes.elements.created, known.shapes);
        follow_lengths<D>(state, changes.spokes, known.lengths, known.bent);
        follow_walls(state.walls, state.mesh, changes.facets);
        return CommittedState<D>{std::move(state), std::move(changes)};
    });
}

template <int D>
Adaptation<D> commit(Adaptation<D> state, std::span<const JudgedNode<D>> judged) {
    if (judged.empty()) return state;
    auto nodes = take(std::move(state.mesh.nodes));
    for (const JudgedNode<D>& node : judged) nodes[node.edge().index()] = node.node();
    state.mesh.nodes = std::move(nodes);
    std::vector<EdgeId> bent;
    bent.reserve(judged.size());
    for (const JudgedNode<D>& node : judged) bent.push_back(node.edge());
    follow_lengths<D>(state, {}, {}, bent);
    state.mesh.stamp = new_stamp();
    state.refusals.forget();
    state.shapes = {};
    return state;
}

#define CAMBER_INSTANTIATE(D)                                                                  \
    template Outcome<CommittedState<D>> commit<D>(Adaptation<D>, std::vector<JudgedPatch<D>>); \
    template Adaptation<D> commit<D>(Adaptation<D>, std::span<const JudgedNode<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.validity;

namespace camber {

namespace {

/// Whether the node of each edge stays.
template <int D>
std::vector<std::uint8_t> fixed_edges(const DynamicMesh<D>& mesh) {
    std::vector<std::uint8_t> fixed(mesh.edges.size(), 0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e))) continue;
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (is_node_fixed(mesh, ElementId(e), k)) fixed[mesh.edges_of[ElementId(e)][k].index()] = 1;
    }
    return fixed;
}

/// The elements around each edge that may change; none around the others.
template <int D>
Incidence<ElementId> free_shells(const DynamicMesh<D>& mesh) {
    const std::vector<std::uint8_t> fixed = fixed_edges(mesh);
    Buffer<std::uint32_t> offsets(mesh.edges.size() + 1, 0);
    const auto each_free = [&](const auto& visit) {
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
            if (mesh.is_free(ElementId(e))) continue;
            for (const EdgeId edge : mesh.edges_of[e])
                if (fixed[edge.index()] == 0) visit(edge, ElementId(e));
        }
    };
    each_free([&](EdgeId edge, ElementId) { ++offsets[edge.index() + 1]; });
    for (std::size_t i = 1; i < offsets.size(); ++i) offsets[i] += offsets[i - 1];
    Buffer<ElementId> items(offsets.back());
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    each_free([&](EdgeId edge, ElementId e) { items[next[edge.index()]++] = e; });
    return {std::move(offsets), std::move(items)};
}

template <int D>
class NodeSweeps {
  public:
    NodeSweeps(Adaptation<D>& r, double wanted)
        : r_(r), wanted_(wanted), shells_(free_shells(r.mesh)), schedule_(r.mesh.elements.size()) {
        for (std::size_t e = 0; e < r.mesh.edges.size(); ++e)
            if (!shells_[e].empty()) edges_.emplace_back(e);
        std::ranges::sort(edges_, {}, [](EdgeId e) { return spread_rank(e); });
        touched_.assign(r.mesh.elements.size(), 1);
    }
    /// All edges whose elements have changed since the last sweep.
    [[nodiscard]] Outcome<NodeMoves> sweep(const Execution& execution) {
        std::vector<EdgeId> now;
        now.reserve(edges_.size());
        for (const EdgeId e : edges_)
            if (std::ranges::any_of(shells_[e], [&](ElementId s) { return touched_[s.index()] != 0; }))
                now.push_back(e);
        touched_.assign(touched_.size(), 0);
        NodeMoves moves;
        auto done = in_rounds(
            schedule_, std::move(now), execution, [](EdgeId) { return false; },
            [&](EdgeId e) { return Claim(shells_[e]); },
            [&](std::span<const EdgeId> edges) { return move_all(edges, execution, moves); });
        if (!done) return fail(done.error());
        return moves;
    }

  private:
    /// What came of an edge.
    struct Tried {
        bool has_reason = false;
        std::optional<JudgedNode<D>> moved;
    };

    /// Edges that share no element.
    [[nodiscard]] Outcome<bool> move_all(std::span<const EdgeId> edges, const Execution& execution, NodeMoves& moves) {
        constexpr std::size_t grain = 16;  // tens of microseconds each
        std::vector<Tried> tried(edges.size());
        const auto done = each_chunk(
            without_progress(execution), edges.size(),
            [&](std::size_t begin, std::size_t end) {
                NodeShell<D> shell;
                for (std::size_t i = begin; i < end; ++i) tried[i] = move(edges[i], shell);
            },
            grain);
        if (!done) return fail(done.error());
        std::vector<JudgedNode<D>> moved;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            moves.tried += tried[i].has_reason ? 1 : 0;
            if (!tried[i].moved) continue;
            moved.push_back(*tried[i].moved);
            for (const ElementId e : shells_[edges[i]]) touched_[e.index()] = 1;
        }
        moves.moved += moved.size();
        r_ = commit<D>(std::move(r_), moved);
        return true;
    }
    [[nodiscard]] Tried move(EdgeId edge, NodeShell<D>& shell) const {
        gather(edge, shell);
        const auto& [a, b] = r_.mesh.edges[edge];
        shell.begin(r_.mesh.nodes[edge].point,
                    LogMetric<D>{0.5 * (r_.vertices.metrics[a].log_metric.l + r_.vertices.metrics[b].log_metric.l)});
        const NodePlace<D> here = shell.at({});
        if (!(here.worst > 0 && here.worst < wanted_) || !bound(shell)) return {};
        NodePlace<D> there = shell.better(here);
        for (int halving = 0; halving < 6 && is_gain(here, there); ++halving) {
            if (auto moved = shell.judged(edge, there.point)) return {true, moved};
            there = shell.at(0.5 * there.y);
        }
        return {true, {}};
    }
    [[nodiscard]] static bool is_gain(const NodePlace<D>& here, const NodePlace<D>& there) {
        constexpr double least = 1e-3;
        return there.worst >= here.worst && there.sum < (1 - least) * here.sum;
    }
    void gather(EdgeId edge, NodeShell<D>& shell) const {
        shell.elements.clear();
        for (const ElementId e : shells_[edge]) {
            DistortedElement<D>& element = shell.elements.emplace_back();
            VertexLogMetrics<D> logs;
            const auto& vertices = r_.mesh.elements.vertices[e];
            for (int i = 0; i <= D; ++i) {
                element.nodes[i] = r_.mesh.points[vertices[i]];
                logs[i] = r_.vertices.metrics[vertices[i]].log_metric;
            }
            for (int k = 0; k < edges_per_simplex<D>; ++k) {
                const EdgeId of_element = r_.mesh.edges_of[e][k];
                element.nodes[D + 1 + k] = r_.mesh.nodes[of_element].point;
                if (of_element == edge) element.node = D + 1 + k;
            }
            element.metric = element_metric<D>(logs);
        }
    }
    /// What each element is to keep; false where one is not valid.
    [[nodiscard]] static bool bound(NodeShell<D>& shell) {
        return std::ranges::all_of(shell.elements, [](DistortedElement<D>& e) {
            for (const double bound : {PatchLimits{}.min_jacobian, 0.0}) {
                e.bound = bound;
                if (decide(NodalSimplex<D>{e.nodes}, bound) == Verdict::valid) return true;
            }
            return false;
        });
    }

    Adaptation<D>& r_;
    double wanted_;  ///< a quality
    Incidence<ElementId> shells_;
    Schedule schedule_;
    std::vector<EdgeId> edges_;
    std::vector<std::uint8_t> touched_;  ///< of each element: it has changed
};

}  // namespace

template <int D>
Outcome<NodeMoves> smooth_nodes(Adaptation<D>& r, const SmoothOptions& options, const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    if (!r.mesh.is_curved()) return NodeMoves{};
    return guarded([&]() -> Outcome<NodeMoves> {
        NodeSweeps<D> sweeps(r, options.wanted);
        NodeMoves all;
        for (int sweep = 0; sweep < options.sweeps; ++sweep) {
            const auto moves = sweeps.sweep(execution);
            if (!moves) return moves;
            all.tried += moves->tried;
            all.moved += moves->moved;
            if (moves->moved == 0) break;
        }
        return all;
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<NodeMoves> smooth_nodes<D>(Adaptation<D>&, const SmoothOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;

namespace camber {

CurveStatistics& CurveStatistics::operator+=(const CurveStatistics& other) {
    volume_edges += other.volume_edges;
    curved_edges += other.curved_edges;
    polished += other.polished;
    exhausted += other.exhausted;
    shortened += other.shortened;
    outside += other.outside;
    lost += other.lost;
    relaxed += other.relaxed;
    by_walls += other.by_walls;
    by_metric += other.by_metric;
    loss_limited += other.loss_limited;
    return *this;
}

namespace {

template <int D>
Outcome<Done> check_columns(const QuadraticMesh<D>& mesh, std::size_t kinds, std::size_t nodes) {
    if (kinds == mesh.edges.size() && nodes == mesh.edges.size()) return Done{};
    return fail(ErrorKind::internal, "curve needs an edge kind and a boundary node for each of the " +
                                         std::to_string(mesh.edges.size()) + " edges, not " + std::to_string(kinds) +
                                         " and " + std::to_string(nodes));
}

void count(CurveStatistics& s, const SearchFlags& f) {
    s.volume_edges += f.volume;
    s.curved_edges += f.curved;
    s.polished += f.polished;
    s.exhausted += f.exhausted;
    s.shortened += f.shortened;
    s.outside += f.outside;
    s.lost += f.lost;
    s.by_walls += f.by_walls;
    s.by_metric += f.by_metric;
}
CurveStatistics operator+(CurveStatistics a, const CurveStatistics& b) { return a += b; }

template <int D>
class Columns {
  public:
    explicit Columns(std::size_t n) : nodes_(n), changes_(n), straight_(n), lengths_(n) {}

    void place(std::size_t e, const EdgeTarget<D>& target) {
        nodes_[e] = target.node;
        changes_[e] = target.change;
    }
    void measure(std::size_t e, const EdgeTarget<D>& target) {
        straight_[e] = target.straight_length;
        lengths_[e] = target.length;
    }
    [[nodiscard]] const LagrangeNode<D>& node(std::size_t e) const { return nodes_[e]; }
    [[nodiscard]] Curved<D> curved(const LinearMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                   const CurveStatistics& statistics) && {
        return {{mesh.points, std::move(nodes_), kinds, std::move(changes_)},
                std::move(straight_),
                std::move(lengths_),
                statistics};
    }

  private:
    Buffer<LagrangeNode<D>> nodes_;
    Buffer<EdgeChange> changes_;
    Buffer<double> straight_, lengths_;
};

}  // namespace

template <int D>
Curved<D> in_columns(const LinearMesh<D>& mesh, std::span<const EdgeTarget<D>> targets, const Column<EdgeKind>& kinds) {
    Columns<D> columns(targets.size());
    CurveStatistics statistics;
    for (std::size_t e = 0; e < targets.size(); ++e) {
        columns.place(e, targets[e]);
        columns.measure(e, targets[e]);
        count(statistics, targets[e].flags);
    }
    return std::move(columns).curved(mesh, kinds, statistics);
}

namespace {

template <int D>
[[nodiscard]] bool is_noticeable(const Vec<D>& offset, const Vec<D>& chord) {
    return norm_squared(offset) > 1e-6 * norm_squared(chord);
}

template <int D>
class Curving {
  public:
    Curving(const MeshEdges<D>& edges, const Column<LagrangeNode<D>>& base, const BackMesh<D>& back,
            const CurveOptions& options)
        : edges_(edges),
          mesh_(edges.mesh),
          kinds_(edges.kinds),
          shells_(edges.shells),
          base_(base),
          back_(back),
          options_(options),
          rules_(edge_rules(options)),
          columns_(mesh_.edges.size()) {}

    Outcome<Curved<D>> run(const Execution& execution) {
        const auto statistics = options_.aim == CurvingAim::accuracy ? curve_accurately(execution) : search(execution);
        if (!statistics) return fail(statistics.error());
        return std::move(columns_).curved(mesh_.linear, kinds_, *statistics);
    }

  private:
    static CurveStatistics sum(const CurveStatistics& a, const CurveStatistics& b) { return a + b; }

    [[nodiscard]] bool is_searched(std::size_t e) const { return kinds_[e] == EdgeKind::volume && !shells_[e].empty(); }

    Outcome<CurveStatistics> search(const Execution& execution) {
        std::vector<CurveStatistics> of_chunks((mesh_.edges.size() + searched_together - 1) / searched_together);
        const auto done = each_chunk(
            execution, mesh_.edges.size(),
            [&](std::size_t begin, std::size_t end) { of_chunks[begin / searched_together] = search(begin, end); },
            searched_together);
        if (!done) return fail(done.error());
        return std::accumulate(of_chunks.begin(), of_chunks.end(), CurveStatistics{}, sum);
    }

    CurveStatistics search(std::size_t begin, std::size_t end) {
        CurveStatistics statistics;
        const auto assign = [&](EdgeId e, const EdgeTarget<D>& target) {
            columns_.place(e.index(), target);
            columns_.measure(e.index(), target);
            count(statistics, target.flags);
        };
        std::vector<EdgeId> edges;
        edges.reserve(end - begin);
        for (EdgeId e(begin); e.index() < end; e = EdgeId(e.index() + 1)) {
            if (is_searched(e.index()))
                edges.push_back(e);
            else
                assign(e, boundary_target(mesh_, e, kinds_[e] == EdgeKind::volume ? mesh_.mid_nodes[e] : base_[e]));
        }
        std::vector<EdgeTarget<D>> targets(edges.size());
        searched_targets<D>({edges_, edges, base_}, back_, rules_, options_, targets);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            if (is_measured(options_.measured, edges[i].index(), mesh_.edges.size()))
                measure(mesh_, {edges[i], shells_[edges[i]].front()}, back_, rules_.report, targets[i]);
            assign(edges[i], targets[i]);
        }
        return statistics;
    }

    Outcome<CurveStatistics> curve_accurately(const Execution& execution) {
        const double of_nodes = options_.measured == MeasuredEdges::all ? 0.1 : 0.48;  // fraction of the progress bar
                                                                                       // for placing nodes; if all
                                                                                       // lengths are measured,
                                                                                       // measuring takes longer than
                                                                                       // placing
        const auto placed = place_accurately(part_of(execution, 0, of_nodes));
        if (!placed) return placed;
        const auto measured = measure_placed(part_of(execution, of_nodes, 1));
        if (!measured) return measured;
        return *placed + *measured;
    }

    struct LimitedOffsets {
        Buffer<Vec<D>> offsets;
        std::size_t loss_limited = 0, relaxed = 0;
    };
    Outcome<LimitedOffsets> offsets_by_element(const Execution& execution) {
        auto offsets = accurate_offsets(edges_, EdgeKind::volume, back_, options_, part_of(execution, 0, 0.7));
        if (!offsets) return fail(offsets.error());
        std::size_t loss_limited = 0;
        if (options_.metric_kind == MetricKind::natural) {
            const auto limited_by_loss =
                limit_smooth_loss<D>(mesh_, shells_, options_.smooth_loss, *offsets, part_of(execution, 0.7, 0.84));
            if (!limited_by_loss) return fail(limited_by_loss.error());
            loss_limited = *limited_by_loss;
        }
        auto limited = limit_by_jacobian<D>(mesh_, base_.view(), shells_, options_.min_jacobian, *offsets,
                                            part_of(execution, 0.84, 1));
        if (!limited) return fail(limited.error());
        return LimitedOffsets{std::move(*offsets), loss_limited, *limited};
    }

    Outcome<CurveStatistics> place_accurately(const Execution& execution) {
        const auto limited_offsets = offsets_by_element(execution);
        if (!limited_offsets) return fail(limited_offsets.error());
        const auto target_of = [&](std::size_t e) {
            if (kinds_[e] != EdgeKind::volume) return boundary_target(mesh_, EdgeId(e), base_[e]);
            if (shells_[e].empty()) return boundary_target(mesh_, EdgeId(e), mesh_.mid_nodes[e]);
            EdgeTarget<D> target = node_target(mesh_, EdgeId(e), {base_[e].point + limited_offsets->offsets[e]});
            const auto& [a, b] = mesh_.edges.vertices[EdgeId(e)];
            const Vec<D>& p = mesh_.linear.points[a];
            const Vec<D>& q = mesh_.linear.points[b];
            target.flags.by_walls = is_noticeable(base_[e].point - midpoint(p, q), q - p);
            target.flags.by_metric = is_noticeable(limited_offsets->offsets[e], q - p);
            return target;
        };
        auto statistics = reduce_each(
            without_progress(execution), mesh_.edges.size(), CurveStatistics{},
            [&](CurveStatistics& met, std::size_t e) {
                const EdgeTarget<D> target = target_of(e);
                columns_.place(e, target);
                count(met, target.flags);
            },
            sum);
        if (statistics) {
            statistics->relaxed = limited_offsets->relaxed;
            statistics->loss_limited = limited_offsets->loss_limited;
        }
        return statistics;
    }

    Outcome<CurveStatistics> measure_placed(const Execution& execution) {
        return reduce_each(
            execution, mesh_.edges.size(), CurveStatistics{},
            [&](CurveStatistics& met, std::size_t e) {
                EdgeTarget<D> target{.node = columns_.node(e), .flags = {}};
                if (is_searched(e) && is_measured(options_.measured, e, mesh_.edges.size()))
                    measure(mesh_, {EdgeId(e), shells_[e].front()}, back_, rules_.report, target);
                columns_.measure(e, target);
                count(met, target.flags);
            },
            sum, 64);
    }

    const MeshEdges<D>& edges_;
    const QuadraticMesh<D>& mesh_;
    const Column<EdgeKind>& kinds_;
    const Incidence<ElementId>& shells_;
    const Column<LagrangeNode<D>>& base_;
    const BackMesh<D>& back_;
    const CurveOptions& options_;
    EdgeRules rules_;
    Columns<D> columns_;
};

}  // namespace

template <int D>
Outcome<Curved<D>> curve(const MeshEdges<D>& edges, const Column<LagrangeNode<D>>& base, const BackMesh<D>& back,
                         const CurveOptions& options, const Execution& execution) {
    if (auto fits = check_columns(edges.mesh, edges.kinds.size(), base.size()); !fits) return fail(fits.error());
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&] { return Curving<D>(edges, base, back, options).run(execution); });
}

template <int D>
Outcome<Buffer<Vec<D>>> accurate_offsets(const MeshEdges<D>& mesh_edges, EdgeKind kind, const BackMesh<D>& back,
                                         const EdgeAccuracyOptions& options, const Execution& execution) {
    const auto& [mesh, kinds, shells] = mesh_edges;
    return guarded([&]() -> Outcome<Buffer<Vec<D>>> {
        Buffer<Vec<D>> offsets(mesh.edges.size(), Vec<D>{});
        auto found = each_chunk(
            execution, offsets.size(),
            [&](std::size_t begin, std::size_t end) {
                std::vector<std::size_t> chosen;
                std::vector<BackEdge> edges;
                for (std::size_t e = begin; e < end; ++e) {
                    if (kinds[e] != kind || shells[e].empty()) continue;
                    chosen.push_back(e);
                    edges.push_back({mesh.edges.vertices[e][0], mesh.edges.vertices[e][1], shells[e]});
                }
                std::vector<Vec<D>> of_edges(edges.size());
                accurate_offsets<D>(mesh, edges, back, options, of_edges);
                for (std::size_t i = 0; i < chosen.size(); ++i) offsets[chosen[i]] = of_edges[i];
            },
            64);
        if (!found) return fail(found.error());
        return offsets;
    });
}

template <int D>
Outcome<Curved<D>> curve_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                  const Column<LagrangeNode<D>>& boundary_nodes, const Execution& execution) {
    if (auto fits = check_columns(mesh, kinds.size(), boundary_nodes.size()); !fits) return fail(fits.error());
    auto targets = map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const bool volume = kinds[e] == EdgeKind::volume;
        auto target = boundary_target(mesh, EdgeId(e), volume ? mesh.mid_nodes[e] : boundary_nodes[e]);
        target.flags.volume = volume;
        return target;
    });
    if (!targets) return fail(targets.error());
    return in_columns<D>(mesh.linear, *targets, kinds);
}

namespace {

struct Lengths {
    double straight = 0, curved = 0;
};

template <class Of>
Outcome<EdgeLengths> in_columns(std::size_t edges, const Execution& execution, const Of& of) {
    return guarded([&]() -> Outcome<EdgeLengths> {
        Buffer<double> chords(edges);
        Buffer<double> curves(edges);
        auto done = each(execution, edges, [&](std::size_t e) {
            const Lengths lengths = of(e);
            chords[e] = lengths.straight;
            curves[e] = lengths.curved;
        });
        if (!done) return fail(done.error());
        return EdgeLengths{std::move(chords), std::move(curves)};
    });
}

/// Returns the length of a chord that is an edge of a straight back mesh; the field is linear along it.
template <int D>
std::optional<double> chord_in_straight_field(const EdgeSet<D>& edges, EdgeId edge, const Proposal<D>& proposal,
                                              const BackMesh<D>& back, const Quadrature& rule) {
    const auto [straight, bent] = back->packed();
    if (!straight || bent) return std::nullopt;
    const auto& [a, b] = edges.vertices[edge];
    const BackVertex<D> from = back->vertex(a), to = back->vertex(b);
    if (from.point != proposal.points[a] || to.point != proposal.points[b]) return std::nullopt;
    const LogMetric<D> mid{0.5 * (from.log_metric.l + to.log_metric.l)};
    return riemannian_length(EdgeField<D>{from.log_metric, mid, to.log_metric},
                             QuadraticEdge<D>{from.point, {midpoint(from.point, to.point)}, to.point}, rule);
}

template <int D>
Lengths lengths_of(const EdgeSet<D>& edges, const EdgeOfElement& source, const Proposal<D>& proposal,
                   const BackMesh<D>& back, const Quadrature& rule, std::optional<double> chord) {
    const auto [edge, element_at] = source;
    const auto& [a, b] = edges.vertices[edge];
    const Vec<D>& p = proposal.points[a];
    const Vec<D>& q = proposal.points[b];
    const LagrangeNode<D> middle{midpoint(p, q)};
    const auto length = [&](const LagrangeNode<D>& node) {
        return riemannian_length(back, QuadraticEdge<D>{p, node, q}, rule, element_at).length;
    };
    if (!chord) chord = length(middle);
    return {*chord, proposal.mid_nodes[edge] == middle ? *chord : length(proposal.mid_nodes[edge])};
}

}  // namespace

template <int D>
Outcome<EdgeLengths> edge_lengths(const EdgesOfElements<D>& source, const Proposal<D>& proposal,
                                  const BackMesh<D>& back, MeasuredEdges measured, const Execution& execution) {
    const auto& [edges, shells] = source;
    const Quadrature rule = gauss_legendre(report_points);
    return in_columns(edges.size(), execution, [&](std::size_t e) {
        if (proposal.kinds[e] != EdgeKind::volume || shells[e].empty()) return Lengths{};
        if (!is_measured(measured, e, edges.size())) return Lengths{};
        return lengths_of(edges, {EdgeId(e), shells[e].front()}, proposal, back, rule,
                          chord_in_straight_field(edges, EdgeId(e), proposal, back, rule));
    });
}

template <int D>
Outcome<EdgeLengths> updated_lengths(const EdgesOfElements<D>& source, const Curved<D>& curved,
                                     const Proposal<D>& after, const BackMesh<D>& back, MeasuredEdges measured,
                                     const Execution& execution) {
    const auto& [edges, shells] = source;
    const Quadrature rule = gauss_legendre(report_points);
    return in_columns(edges.size(), execution, [&](std::size_t e) {
        const Lengths before{curved.straight_lengths[e], curved.lengths[e]};
        if (after.kinds[e] != EdgeKind::volume || shells[e].empty()) return before;
        if (!is_measured(measured, e, edges.size())) return before;
        const auto& [a, b] = edges.vertices[e];
        const bool same_chord =
            after.points[a] == curved.proposal.points[a] && after.points[b] == curved.proposal.points[b];
        if (same_chord && after.mid_nodes[e] == curved.proposal.mid_nodes[e]) return before;
        const auto chord = same_chord ? std::optional(before.straight) : std::nullopt;
        return lengths_of(edges, {EdgeId(e), shells[e].front()}, after, back, rule, chord);
    });
}

namespace {

/// Displacements below this length in the metric are ignored.
constexpr double negligible = 0.01;
constexpr double min_back_jacobian = 0.1;

template <int D>
LagrangeNode<D> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
}

}  // namespace

template <int D>
Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                  std::span<const LagrangeNode<D>> extended,
                                                  const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<LagrangeNode<D>>> {
        Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
        auto done = each_chunk(execution, nodes.size(), [&](std::size_t begin, std::size_t end) {
            // Displacements of the moved nodes, each listed twice to be measured in the metrics of both ends of the
            // edge.
            std::vector<std::size_t> moved;
            std::vector<LogMetric<D>> metrics;
            std::vector<Vec<D>> displacements;
            for (std::size_t e = begin; e < end; ++e) {
                nodes[e] = middle_of(mesh, e);
                if (extended[e] == nodes[e]) continue;
                moved.push_back(e);
                for (const VertexId v : mesh.edges.vertices[e]) {
                    metrics.push_back(log_metrics[v]);
                    displacements.push_back(extended[e].point - nodes[e].point);
                }
            }
            std::vector<double> lengths(metrics.size());
            metric_norms<D>(metrics, displacements, lengths);
            for (std::size_t i = 0; i < moved.size(); ++i)
                if (!(lengths[2 * i] < negligible && lengths[2 * i + 1] < negligible))
                    nodes[moved[i]] = extended[moved[i]];
        });
        if (!done) return fail(done.error());
        return nodes;
    });
}

namespace {

template <int D>
Outcome<Buffer<Vec<D>>> displacements_of(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                         const Execution& execution) {
    return map_each(execution, mesh.edges.size(),
                    [&](std::size_t e) { return nodes[e].point - middle_of(mesh, e).point; });
}

}  // namespace

template <int D>
Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, PartCommunication<D>& between,
                                 const Execution& execution) {
    return guarded([&]() -> Outcome<Done> {
        std::vector<Buffer<Vec<D>>> displacements;
        std::vector<PartOffsets<D>> offsets;
        for (const PartNodes<D>& of : parts) {
            auto displaced = displacements_of<D>(of.mesh, of.nodes, part_of(execution, 0, 0.5));
            if (!displaced) return fail(displaced.error());
            displacements.push_back(std::move(*displaced));
        }
        offsets.reserve(parts.size());
        for (std::size_t p = 0; p < parts.size(); ++p)
            offsets.push_back({parts[p].mesh, {}, parts[p].shells, parts[p].owned, displacements[p]});
        const auto limited = limit_by_jacobian<D>(offsets, min_back_jacobian, between, part_of(execution, 0.5, 0.8));
        if (!limited) return fail(limited.error());
        for (std::size_t p = 0; p < parts.size(); ++p) {
            const std::span<LagrangeNode<D>> nodes = parts[p].nodes;
            auto done = each(part_of(execution, 0.8, 1), nodes.size(), [&](std::size_t e) {
                const Vec<D>& u = displacements[p][e];
                const Vec<D> middle = middle_of(parts[p].mesh, e).point;
                if (u != nodes[e].point - middle) nodes[e] = {middle + u};
            });
            if (!done) return done;
        }
        return Done{};
    });
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                                 const Incidence<ElementId>& shells, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<LagrangeNode<D>>> {
        Buffer<LagrangeNode<D>> limited(nodes.begin(), nodes.end());
        OnePart<D> alone;
        const PartNodes<D> all{mesh, shells, whole(mesh.linear), limited};
        auto done = limit_to_back_mesh<D>(std::span(&all, 1), alone, execution);
        if (!done) return fail(done.error());
        return limited;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Curved<D> in_columns<D>(const LinearMesh<D>&, std::span<const EdgeTarget<D>>, const Column<EdgeKind>&);  \
    template Outcome<Curved<D>> curve<D>(const MeshEdges<D>&, const Column<LagrangeNode<D>>&, const BackMesh<D>&,     \
                                         const CurveOptions&, const Execution&);                                      \
    template Outcome<Buffer<Vec<D>>> accurate_offsets<D>(const MeshEdges<D>&, EdgeKind, const BackMesh<D>&,           \
                                                         const EdgeAccuracyOptions&, const Execution&);               \
    template Outcome<Curved<D>> curve_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,                   \
                                                  const Column<LagrangeNode<D>>&, const Execution&);                  \
    template Outcome<EdgeLengths> edge_lengths<D>(const EdgesOfElements<D>&, const Proposal<D>&, const BackMesh<D>&,  \
                                                  MeasuredEdges, const Execution&);                                   \
    template Outcome<EdgeLengths> updated_lengths<D>(const EdgesOfElements<D>&, const Curved<D>&, const Proposal<D>&, \
                                                     const BackMesh<D>&, MeasuredEdges, const Execution&);            \
    template Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes<D>(                                                    \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Column<LogMetric<D>>&, const Execution&);    \
    template Outcome<Done> limit_to_back_mesh<D>(std::span<const PartNodes<D>>, PartCommunication<D>&,                \
                                                 const Execution&);                                                   \
    template Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes<D>(                                                     \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Incidence<ElementId>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

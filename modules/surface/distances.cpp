// Distances between a curved boundary and its geometry, both ways and by entity.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.box_tree;
import camber.bezier;

namespace camber {

namespace {

/// Raises the degree of a quadratic simplex with control points P: c_α = Σ_i α_i/3 P_{α − e_i}.
template <int K, int D>
CubicSimplex<K, D> raised(const QuadraticSimplex<K, D>& simplex) {
    CubicSimplex<K, D> out;
    for (const MultiIndex<K>& alpha : multi_indices<3, K>) {
        Vec<D> point;
        for (int i = 0; i <= K; ++i) {
            if (alpha[static_cast<std::size_t>(i)] == 0) continue;
            MultiIndex<K> rest = alpha;
            --rest[static_cast<std::size_t>(i)];
            int first = 0, last = K;
            while (rest[static_cast<std::size_t>(first)] == 0) ++first;
            while (rest[static_cast<std::size_t>(last)] == 0) --last;
            point += alpha[static_cast<std::size_t>(i)] / 3.0 * simplex.at(first, last);
        }
        out.at(alpha) = point;
    }
    return out;
}

template <int D>
Box<D> box_of(const CubicSimplex<D - 1, D>& facet) {
    Box<D> box;
    for (const Vec<D>& c : facet.control) box.include(c);
    return box;
}

template <int D>
BoundaryFoot<D> on_facet(const CurvedBoundary<D>& boundary, std::size_t f, const Vec<D>& p) {
    const auto foot = closest_on(boundary.facets[f], p);
    return {FacetId(f), foot.xi, foot.point, foot.distance_squared};
}

}  // namespace

template <int D>
Outcome<CurvedBoundary<D>> curved_boundary(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                           const Execution& execution) {
    auto facets = map_each(execution, mesh.linear.facets.size(), [&](std::size_t f) {
        return raised<D - 1, D>(bezier_form<D - 1, D>(mesh.linear.points, mid_nodes, mesh.linear.facets.vertices[f],
                                                      mesh.edges.of_facets[f]));
    });
    if (!facets) return fail(facets.error());
    auto boxes =
        map_each(without_progress(execution), facets->size(), [&](std::size_t f) { return box_of<D>((*facets)[f]); });
    if (!boxes) return fail(boxes.error());
    return guarded(
        [&]() -> Outcome<CurvedBoundary<D>> { return CurvedBoundary<D>{std::move(*facets), BoxTree<D>(*boxes)}; });
}

template <int D>
BoundaryFoot<D> closest_on(const CurvedBoundary<D>& boundary, const Vec<D>& p, FacetId near) {
    BoundaryFoot<D> best;
    if (near.valid()) best = on_facet(boundary, near.index(), p);
    const auto distance_squared = [&](std::size_t f) {
        if (FacetId(f) == best.facet) return best.distance_squared;
        const double beyond = box_of<D>(boundary.facets[f]).distance_squared(p);
        if (beyond > best.distance_squared) return std::numeric_limits<double>::infinity();
        const BoundaryFoot<D> foot = on_facet(boundary, f, p);
        if (foot.distance_squared < best.distance_squared ||
            (foot.distance_squared == best.distance_squared && f < best.facet.index()))
            best = foot;
        return foot.distance_squared;
    };
    (void)boundary.tree.nearest(p, distance_squared, best.distance_squared);
    return best;
}

namespace {

auto entity_order(const GeometryEntity& entity) {
    const int rank = entity.kind == GeometryKind::surface ? 0 : entity.kind == GeometryKind::curve ? 1 : 2;
    const bool by_sides = entity.id == GeometryEntity::unnumbered;
    return std::tuple<int, std::int64_t, std::array<std::int64_t, 2>>(
        rank, entity.id, by_sides ? entity.sides : std::array<std::int64_t, 2>{});
}

template <int D>
struct PiecesOfEntities {
    struct Entity {
        GeometryEntity entity;
        std::vector<std::uint32_t> pieces;  ///< ascending
    };
    std::vector<Entity> surfaces, curves;
    Incidence<FacetId> shells;

    [[nodiscard]] EdgeSite<D> site(const QuadraticMesh<D>& mesh, const Features<D>& features, std::size_t e) const {
        const auto& [low, high] = mesh.edges.vertices[e];
        return {EdgeId(e),
                features.edge_kinds[e],
                {mesh.linear.points[low], mesh.linear.points[high]},
                facet_sites<D>(mesh.linear, shells[e])};
    }
};

/// The facet lattice of this degree contains the centroid and the edge middles.
constexpr int facet_degree = 6, edge_samples = 10;

template <int D, class Predicate>
auto sorted_by_entity(const Buffer<GeometryEntity>& entities, Predicate&& predicate) {
    using Key = decltype(entity_order(GeometryEntity{}));
    std::map<Key, typename PiecesOfEntities<D>::Entity> sorted;
    for (std::size_t i = 0; i < entities.size(); ++i) {
        if (!predicate(entities[i])) continue;
        auto& entry = sorted[entity_order(entities[i])];
        entry.entity = entities[i];
        entry.pieces.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<typename PiecesOfEntities<D>::Entity> list;
    list.reserve(sorted.size());
    for (auto& [key, entry] : sorted) list.push_back(std::move(entry));
    return list;
}

/// Projects the curved facet, not the straight one: beside a ridge the straight facet may project beyond the domain,
/// where the surface continues.
template <int D>
void project_curved(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry, const GeometryEntity& entity,
                    const FacetSite<D>& site, std::span<Vec<D>> out) {
    constexpr const auto& lattice = facet_lattice<facet_degree, D>;
    const auto shape = bezier_form<D - 1, D>(mesh.linear.points, mesh.mid_nodes.view(),
                                             mesh.linear.facets.vertices[site.id], mesh.edges.of_facets[site.id]);
    for (std::size_t k = 0; k < lattice.size(); ++k)
        out[k] = geometry->project({.reference = site.reference, .entity = entity}, shape.point(lattice[k])).point;
}

template <int D>
Outcome<PiecesOfEntities<D>> find_on_entities(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                              const Geometry<D>& geometry, const Execution& execution) {
    if (features.patches.size() != mesh.linear.facets.size() || features.edge_kinds.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features belong to another mesh");
    auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    PiecesOfEntities<D> found{{}, {}, std::move(*shells)};
    auto of_facets = map_each(part_of(execution, 0, 0.5), mesh.linear.facets.size(),
                              [&](std::size_t f) { return geometry->surface_at(facet_site(mesh.linear, FacetId(f))); });
    if (!of_facets) return fail(of_facets.error());
    found.surfaces = sorted_by_entity<D>(*of_facets, [](const GeometryEntity&) { return true; });
    if constexpr (D == 3) {
        auto of_edges = map_each(part_of(execution, 0.5, 1), mesh.edges.size(), [&](std::size_t e) {
            return found.shells[e].empty() ? GeometryEntity{} : geometry->entity_at_edge(found.site(mesh, features, e));
        });
        if (!of_edges) return fail(of_edges.error());
        found.curves = sorted_by_entity<D>(
            *of_edges, [](const GeometryEntity& entity) { return entity.kind == GeometryKind::curve; });
    }
    return found;
}

}  // namespace

template <int D>
Outcome<GeometrySamples<D>> sample_over_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                             const Geometry<D>& geometry, const Execution& execution) {
    constexpr const auto& lattice = facet_lattice<facet_degree, D>;
    constexpr std::size_t n = lattice.size();
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        const auto on = find_on_entities(mesh, features, geometry, part_of(execution, 0, 0.3));
        if (!on) return fail(on.error());
        GeometrySamples<D> samples;
        const auto take = [&](const auto& entity, std::size_t per_piece, const Execution& part, auto&& sample) {
            samples.begin(entity.entity);
            const std::size_t begin = samples.points.size(), all = begin + entity.pieces.size() * per_piece;
            samples.points.resize(all);
            samples.weights.resize(all);
            samples.near.resize(all);
            samples.entities.back().end = all;
            return each(part, entity.pieces.size(),
                        [&](std::size_t i) { sample(entity.pieces[i], begin + i * per_piece); });
        };
        for (const auto& entity : on->surfaces) {
            if (entity.entity.kind == GeometryKind::none) continue;
            auto done = take(entity, n, without_progress(execution), [&](std::size_t f, std::size_t at) {
                const FacetSite<D> site = facet_site(mesh.linear, FacetId(f));
                const double weight = straight_measure(site) / n;
                const auto points = std::span(samples.points).subspan(at, n);
                if (geometry->prescribes(site.reference))
                    project_curved(mesh, geometry, entity.entity, site, points);
                else
                    (void)geometry->surface_points(site, lattice, points);
                for (std::size_t k = at; k < at + n; ++k) {
                    samples.weights[k] = weight;
                    samples.near[k] = FacetId(f);
                }
            });
            if (!done) return fail(done.error());
        }
        for (const auto& entity : on->curves) {
            auto done = take(entity, edge_samples, without_progress(execution), [&](std::size_t e, std::size_t at) {
                const EdgeSite<D> site = on->site(mesh, features, e);
                const double length = distance(site.ends[0], site.ends[1]);
                for (std::size_t k = 0; k < edge_samples; ++k) {
                    const double t = (static_cast<double>(k) + 0.5) / edge_samples;
                    samples.points[at + k] = geometry->on_edge(site, (1 - t) * site.ends[0] + t * site.ends[1]).point;
                    samples.weights[at + k] = length / edge_samples;
                    samples.near[at + k] = site.facets.front().id;
                }
            });
            if (!done) return fail(done.error());
        }
        return samples;
    });
}

namespace {

constexpr int edge_intervals = 10;
template <int D>
constexpr const auto& tenths = facet_lattice<10, D>;

template <int D>
struct Part {
    double largest = 0, sum = 0, weight = 0;
    Vec<D> from, to;
    FacetId facet = {};
};

template <int D>
class Sum {
  public:
    void add(const Part<D>& part, std::size_t samples) {
        if (part.largest > way_.largest || way_.samples == 0) {
            way_.largest = part.largest;
            way_.from = part.from;
            way_.to = part.to;
            way_.facet = part.facet;
        }
        way_.samples += samples;
        sum_ += part.sum;
        weight_ += part.weight;
    }
    [[nodiscard]] DirectedDistance<D> way() const {
        DirectedDistance<D> way = way_;
        way.mean = weight_ > 0 ? sum_ / weight_ : 0;
        return way;
    }

  private:
    DirectedDistance<D> way_;
    double sum_ = 0, weight_ = 0;
};

template <int D>
struct DistanceProblem {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> mid_nodes;
    const Features<D>& features;
    const Geometry<D>& geometry;
};

template <int D>
Part<D> measure_facet(const DistanceProblem<D>& q, const GeometryEntity& entity, std::size_t f) {
    constexpr std::size_t n = tenths<D>.size();
    const FacetSite<D> site = facet_site(q.mesh.linear, FacetId(f));
    const auto shape = bezier_form<D - 1, D>(q.mesh.linear.points, q.mid_nodes, q.mesh.linear.facets.vertices[f],
                                             q.mesh.edges.of_facets[f]);
    std::array<Vec<D>, n> points;
    for (std::size_t i = 0; i < n; ++i) points[i] = shape.point(tenths<D>[i]);
    std::array<double, n> found{};
    const Plane<D> plane = plane_through(site.corners);
    const bool has_surface = q.geometry->distances(site, tenths<D>, points, found);
    if (!has_surface)
        for (std::size_t i = 0; i < n; ++i) found[i] = distance(foot(plane, points[i]).point, points[i]);
    const auto worst = static_cast<std::size_t>(std::max_element(found.begin(), found.end()) - found.begin());
    Part<D> part;
    part.largest = found[worst];
    part.weight = straight_measure(site);
    part.facet = FacetId(f);
    for (const double d : found) part.sum += d * part.weight / n;
    part.from = points[worst];
    part.to = has_surface ? q.geometry->project({.reference = site.reference, .entity = entity}, points[worst]).point
                          : foot(plane, points[worst]).point;
    return part;
}

template <int D>
Part<D> measure_edge(const DistanceProblem<D>& q, const PiecesOfEntities<D>& on, std::size_t e) {
    const EdgeSite<D> site = on.site(q.mesh, q.features, e);
    const Vec<D> control = control_point(site.ends[0], q.mid_nodes[e], site.ends[1]).point;
    Part<D> part;
    part.largest = -1;
    part.weight = distance(site.ends[0], site.ends[1]);
    part.facet = site.facets.front().id;
    for (int k = 0; k <= edge_intervals; ++k) {
        const double t = static_cast<double>(k) / edge_intervals;
        const Vec<D> p = (1 - t) * (1 - t) * site.ends[0] + 2 * t * (1 - t) * control + t * t * site.ends[1];
        const Vec<D> there = q.geometry->on_edge(site, p).point;
        const double d = distance(there, p);
        part.sum += d * part.weight / (edge_intervals + 1);
        if (d <= part.largest) continue;
        part.largest = d;
        part.from = p;
        part.to = there;
    }
    return part;
}

template <int D>
struct CurvedEdges {
    std::vector<CubicSimplex<1, D>> curves;
    BoxTree<D> tree;
};
template <int D>
CurvedEdges<D> curved_edges(const DistanceProblem<D>& q, std::span<const std::uint32_t> edges) {
    CurvedEdges<D> out;
    std::vector<Box<D>> boxes;
    out.curves.reserve(edges.size());
    boxes.reserve(edges.size());
    for (const std::uint32_t e : edges) {
        const auto& [low, high] = q.mesh.edges.vertices[e];
        const Vec<D>&a = q.mesh.linear.points[low], &b = q.mesh.linear.points[high];
        const Vec<D> c = control_point(a, q.mid_nodes[e], b).point;
        out.curves.push_back({{a, a + 2.0 / 3 * (c - a), b + 2.0 / 3 * (c - b), b}});
        Box<D> box;
        for (const Vec<D>& p : out.curves.back().control) box.include(p);
        boxes.push_back(box);
    }
    out.tree = BoxTree<D>(boxes);
    return out;
}
template <int D>
Vec<D> closest_on(const CurvedEdges<D>& edges, const Vec<D>& p) {
    const auto found =
        edges.tree.nearest(p, [&](std::size_t i) { return camber::closest_on(edges.curves[i], p).distance_squared; });
    return camber::closest_on(edges.curves[found.item], p).point;
}

template <int D>
struct Feet {
    Buffer<Vec<D>> points;
    Buffer<FacetId> facets;
};
template <int D>
Outcome<Feet<D>> feet_of(const DistanceProblem<D>& q, const PiecesOfEntities<D>& on, const GeometrySamples<D>& samples,
                         const Execution& execution) {
    const auto boundary = curved_boundary(q.mesh, q.mid_nodes, part_of(execution, 0, 0.1));
    if (!boundary) return fail(boundary.error());
    const std::size_t n = samples.points.size();
    Feet<D> feet{Buffer<Vec<D>>(n), Buffer<FacetId>(n)};
    const auto to_facets = [&](std::size_t i) {
        const BoundaryFoot<D> foot = closest_on(*boundary, samples.points[i], samples.near[i]);
        feet.points[i] = foot.point;
        feet.facets[i] = foot.facet;
    };
    for (const auto& [entity, begin, end] : samples.entities) {
        const auto curve = std::find_if(on.curves.begin(), on.curves.end(), [&, &e = entity](const auto& c) {
            return entity_order(c.entity) == entity_order(e);
        });
        const bool has_edges = entity.kind == GeometryKind::curve && curve != on.curves.end();
        const auto edges = has_edges ? curved_edges<D>(q, curve->pieces) : CurvedEdges<D>{};
        auto done = each(without_progress(execution), end - begin, [&, first = begin](std::size_t i) {
            if (!has_edges) return to_facets(first + i);
            feet.points[first + i] = closest_on(edges, samples.points[first + i]);
            feet.facets[first + i] = samples.near[first + i];
        });
        if (!done) return fail(done.error());
    }
    return feet;
}

template <int D>
std::vector<Reference> references_of(const QuadraticMesh<D>& mesh, const std::vector<FacetId>& facets) {
    std::vector<Reference> references;
    references.reserve(facets.size());
    for (const FacetId f : facets) references.push_back(mesh.linear.facets.references[f]);
    std::sort(references.begin(), references.end());
    references.erase(std::unique(references.begin(), references.end()), references.end());
    return references;
}

template <int D>
class Measuring {
  public:
    Measuring(const DistanceProblem<D>& q, const PiecesOfEntities<D>& on)
        : q_(q), on_(on), of_facets_(q.mesh.linear.facets.size()), to_facets_(q.mesh.linear.facets.size()) {
        std::fill(to_facets_.begin(), to_facets_.end(), 0.0);
    }

    Outcome<Done> from_boundary(const Execution& execution) {
        for (const auto& entity : on_.surfaces) {
            auto parts = map_each(
                without_progress(execution), entity.pieces.size(),
                [&](std::size_t i) { return measure_facet(q_, entity.entity, entity.pieces[i]); }, 64);
            if (!parts) return fail(parts.error());
            std::vector<FacetId> facets(entity.pieces.size());
            for (std::size_t i = 0; i < parts->size(); ++i) {
                of_facets_[entity.pieces[i]] = (*parts)[i].largest;
                facets[i] = FacetId(entity.pieces[i]);
                to_geometry_.add((*parts)[i], tenths<D>.size());
            }
            add(entity, *parts, tenths<D>.size(), references_of(q_.mesh, facets));
            entities_.back().is_flat =
                entity.entity.kind == GeometryKind::surface &&
                q_.geometry->plane_at(facet_site(q_.mesh.linear, FacetId(entity.pieces.front()))).has_value();
        }
        for (const auto& entity : on_.curves) {
            auto parts = map_each(
                without_progress(execution), entity.pieces.size(),
                [&](std::size_t i) { return measure_edge(q_, on_, entity.pieces[i]); }, 64);
            if (!parts) return fail(parts.error());
            std::vector<FacetId> facets;
            for (const std::uint32_t e : entity.pieces)
                facets.insert(facets.end(), on_.shells[e].begin(), on_.shells[e].end());
            add(entity, *parts, edge_intervals + 1, references_of(q_.mesh, facets));
        }
        return Done{};
    }

    void from_geometry(const GeometrySamples<D>& samples, const Feet<D>& feet) {
        for (const auto& [entity, begin, end] : samples.entities) {
            Sum<D> sum;
            for (std::size_t i = begin; i < end; ++i) {
                const double d = distance(samples.points[i], feet.points[i]), weight = samples.weights[i];
                const Part<D> part{d, d * weight, weight, samples.points[i], feet.points[i], feet.facets[i]};
                sum.add(part, 1);
                if (entity.kind == GeometryKind::curve) continue;
                to_boundary_.add(part, 1);
                if (part.facet.valid()) to_facets_[part.facet.index()] = std::max(to_facets_[part.facet.index()], d);
            }
            entry_of(entity).to_boundary = sum.way();
        }
    }

    GeometryDistances<D> distances() {
        std::sort(entities_.begin(), entities_.end(),
                  [](const auto& a, const auto& b) { return entity_order(a.entity) < entity_order(b.entity); });
        return {std::move(entities_), to_geometry_.way(), to_boundary_.way(), std::move(of_facets_),
                std::move(to_facets_)};
    }

  private:
    void add(const typename PiecesOfEntities<D>::Entity& entity, const Buffer<Part<D>>& parts, std::size_t samples,
             std::vector<Reference> references) {
        Sum<D> sum;
        EntityDistances<D> entry{.entity = entity.entity,
                                 .pieces = entity.pieces.size(),
                                 .references = std::move(references),
                                 .to_geometry = {},
                                 .to_boundary = {}};
        for (const Part<D>& part : parts) {
            sum.add(part, samples);
            entry.measure += part.weight;
        }
        entry.to_geometry = sum.way();
        entities_.push_back(std::move(entry));
    }

    EntityDistances<D>& entry_of(const GeometryEntity& entity) {
        const auto same = [&](const auto& e) { return entity_order(e.entity) == entity_order(entity); };
        const auto found = std::find_if(entities_.begin(), entities_.end(), same);
        if (found != entities_.end()) return *found;
        entities_.push_back({.entity = entity, .references = {}, .to_geometry = {}, .to_boundary = {}});
        return entities_.back();
    }

    const DistanceProblem<D>& q_;
    const PiecesOfEntities<D>& on_;
    std::vector<EntityDistances<D>> entities_;
    Sum<D> to_geometry_, to_boundary_;
    Buffer<double> of_facets_, to_facets_;
};

}  // namespace

template <int D>
Outcome<GeometryDistances<D>> two_sided_distances(const QuadraticMesh<D>& mesh,
                                                  std::span<const LagrangeNode<D>> mid_nodes,
                                                  const Features<D>& features, const Geometry<D>& geometry,
                                                  const GeometrySamples<D>& samples, const Execution& execution) {
    if (mid_nodes.size() != mesh.edges.size()) return fail(ErrorKind::internal, "the nodes belong to another mesh");
    if (mesh.linear.facets.size() == 0) return GeometryDistances<D>{};
    const DistanceProblem<D> question{mesh, mid_nodes, features, geometry};
    return guarded([&]() -> Outcome<GeometryDistances<D>> {
        const auto on = find_on_entities(mesh, features, geometry, part_of(execution, 0, 0.2));
        if (!on) return fail(on.error());
        Measuring<D> measuring(question, *on);
        if (auto done = measuring.from_boundary(part_of(execution, 0.2, 0.5)); !done) return fail(done.error());
        const auto feet = feet_of(question, *on, samples, part_of(execution, 0.5, 1));
        if (!feet) return fail(feet.error());
        measuring.from_geometry(samples, *feet);
        return measuring.distances();
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<CurvedBoundary<D>> curved_boundary<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, \
                                                           const Execution&);                                         \
    template BoundaryFoot<D> closest_on<D>(const CurvedBoundary<D>&, const Vec<D>&, FacetId);                         \
    template Outcome<GeometrySamples<D>> sample_over_mesh<D>(const QuadraticMesh<D>&, const Features<D>&,             \
                                                             const Geometry<D>&, const Execution&);                   \
    template Outcome<GeometryDistances<D>> two_sided_distances<D>(                                                    \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Features<D>&, const Geometry<D>&,            \
        const GeometrySamples<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

// Locates new points in old elements, interpolates fields and integrates residuals.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import camber.core;
import camber.bezier;
import camber.metric;
import :materials;
import :projection;

namespace camber {

namespace {

/// Makes a submesh. All entries of `number` are invalid before and after the call.
template <int D>
QuadraticMesh<D> part_of_mesh(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                              Buffer<VertexId>& number) {
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D>> simplices(elements.size());
    Buffer<std::array<EdgeId, edges_per_simplex<D>>> of_elements(elements.size());
    Buffer<Reference> references(elements.size());
    std::vector<VertexId> used;
    for (std::size_t i = 0; i < elements.size(); ++i) {
        for (int k = 0; k <= D; ++k) {
            const VertexId v = mesh.linear.elements.vertices[elements[i]][k];
            VertexId& own = number[v.index()];
            if (!own.valid()) {
                own = VertexId(points.size());
                points.push_back(mesh.linear.points[v]);
                used.push_back(v);
            }
            simplices[i][k] = own;
        }
        of_elements[i] = mesh.edges.of_elements[elements[i]];
        references[i] = mesh.linear.elements.references[elements[i]];
    }
    for (const VertexId v : used) number[v.index()] = {};
    QuadraticMesh<D> part;
    part.linear.points = std::move(points);
    part.linear.elements.vertices = std::move(simplices);
    part.linear.elements.references = std::move(references);
    part.edges.of_elements = std::move(of_elements);
    part.mid_nodes = mesh.mid_nodes;  // edges keep their numbers, because location only uses their nodes
    return part;
}

template <int D>
bool is_near(const QuadraticMesh<D>& mesh, std::size_t e, const Vec<D>& p) {
    Box<D> box;
    for (const VertexId v : mesh.linear.elements.vertices[e]) box.include(mesh.linear.points[v]);
    const Vec<D> size = box.high - box.low;
    return box.distance_squared(p) <= 4 * norm_squared(size);
}

}  // namespace

template <int D>
Outcome<Done> Sources<D>::add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                                   const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                                   const Execution& execution) {
    const bool is_all = elements.empty();
    QuadraticMesh<D> part = is_all ? mesh : part_of_mesh(mesh, elements, number);
    const auto around = balls(part.linear, execution);
    if (!around) return fail(around.error());
    auto locator = make_curved_locator(std::move(part), *around, execution);
    if (!locator) return fail(locator.error());
    parts_[material].locator = std::move(*locator);
    if (is_all) return Done{};
    for (std::size_t i = 0; i < elements.size(); ++i) number_in_part_[elements[i]] = static_cast<std::uint32_t>(i);
    parts_[material].elements = Buffer<std::uint32_t>(elements.begin(), elements.end());
    return Done{};
}

template <int D>
Outcome<Sources<D>> Sources<D>::make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                     const std::vector<std::uint8_t>& is_requested, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    return guarded([&]() -> Outcome<Sources> {
        Sources sources;
        sources.parts_.resize(materials.size());
        std::vector<std::vector<std::uint32_t>> elements(materials.size());
        Buffer<VertexId> number;
        if (materials.size() > 1) {
            const std::size_t n = mesh.linear.elements.size();
            sources.number_in_part_.assign(n, none);
            sources.material_.assign(n, none);
            number.assign(mesh.linear.points.size(), VertexId{});
            for (std::size_t e = 0; e < n; ++e) {
                const std::size_t material = materials.of(mesh.linear, e);
                sources.material_[e] = static_cast<std::uint32_t>(material);
                if (material != materials.rest()) elements[material].push_back(static_cast<std::uint32_t>(e));
            }
        }
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (is_requested[m] == 0) continue;
            if (auto added = sources.add_part(mesh, m, elements[m], number, quiet); !added) return fail(added.error());
            report_progress(execution, m + 1, materials.size());
        }
        return sources;
    });
}

template <int D>
ElementId Sources<D>::hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const {
    if (hint == none) return part.locator.hint_for(p);
    ElementId near(hint);
    if (!part.elements.empty()) {
        if (material_[hint] != material) return part.locator.hint_for(p);
        near = ElementId(number_in_part_[hint]);
    }
    return is_near(part.locator.mesh, near.index(), p) ? near : part.locator.hint_for(p);
}

template <int D>
OldPosition<D> Sources<D>::find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const {
    const Part& part = parts_[material];
    const Location<D> found = part.locator.locate(p, hint_in(part, material, p, hint));
    OldPosition<D> place{.element = found.element.value, .xi = found.xi, .placement = found.placement};
    if (found.placement != Placement::inside) {
        const ElementMap<D> map = element_map(part.locator.mesh, found.element.index());
        place.distance = norm(p - map.origin - map.relative.point(found.xi));
    }
    if (!part.elements.empty()) place.element = part.elements[place.element];
    return place;
}

template <int D>
std::uint32_t Sources<D>::across(std::size_t material, std::uint32_t element, std::size_t opposite) const {
    const Part& part = parts_[material];
    const bool is_all = part.elements.empty();
    const ElementId next = part.locator.neighbours[is_all ? element : number_in_part_[element]][opposite];
    if (!next.valid()) return none;
    return is_all ? next.value : part.elements[next.index()];
}

/// Solves F(ξ) = p by Newton's method from the centre. In curved elements, the Jacobian is updated.
template <int D>
bool Nearby<D>::is_inside(const Tried& here, const Vec<D>& p, Barycentric<D>& xi) {
    constexpr int most_steps = 6;
    constexpr double far = 0.2, small = 1e-6;  // after a step of 10⁻⁶, the error is about its square
    const Vec<D> r = p - here.map.origin;
    xi.fill(1.0 / (D + 1));
    Vec<D> step = here.inverse * (r - here.centre);
    for (int k = 0; k < most_steps; ++k) {
        double rest = 1, largest = 0;
        for (int i = 0; i < D; ++i) {
            xi[i + 1] += step[i];
            rest -= xi[i + 1];
            largest = std::max(largest, std::abs(step[i]));
        }
        xi[0] = rest;
        if (k > 0 && largest < small) return std::ranges::all_of(xi, [](double u) { return u >= 0; });
        for (const double u : xi)
            if (!(u > -far)) return false;
        if (here.map.is_straight) {
            Vec<D> x;
            for (int i = 0; i < D; ++i) x[i] = xi[i + 1];
            step = here.inverse * (r - here.jacobian * x);
        } else {
            step = inverse(Mat<D>{here.map.relative.derivatives(xi)}) * (r - here.map.relative.point(xi));
        }
    }
    return false;
}

/// Returns the neighbour across the face for which p has the lowest barycentric coordinate, by the linear map at the
/// centre.
template <int D>
std::uint32_t Nearby<D>::next_towards(const Tried& here, const Vec<D>& p) const {
    const Vec<D> step = here.inverse * (p - here.map.origin - here.centre);
    std::size_t face = 0;
    double least = 0, rest = 0;
    for (int i = 0; i < D; ++i) {
        rest -= step[i];
        if (!(step[i] < least)) continue;
        least = step[i];
        face = static_cast<std::size_t>(i) + 1;
    }
    if (rest < least) face = 0;
    return sources_.across(material_, here.element, face);
}

template <int D>
OldPosition<D> Nearby<D>::find(const Vec<D>& p) {
    constexpr int short_walk = 6;
    OldPosition<D> place;
    for (std::size_t i = 0; i < tried_.size(); ++i)
        if (is_inside(tried_[i], p, place.xi)) return found(i, place);
    std::size_t at = 0;
    for (int step = 0; step < short_walk && at < tried_.size(); ++step) {
        const std::uint32_t next = next_towards(tried_[at], p);
        if (next == none || std::ranges::find(tried_, next, &Tried::element) != tried_.end()) break;
        at = remember(next);
        if (is_inside(tried_[at], p, place.xi)) return found(at, place);
    }
    place = sources_.find(p, material_, hint_);
    const auto known = std::ranges::find(tried_, place.element, &Tried::element);
    const auto i = static_cast<std::size_t>(known - tried_.begin());
    return found(known == tried_.end() ? remember(place.element) : i, place);
}

template <int D>
OldPosition<D> Nearby<D>::found(std::size_t i, OldPosition<D> place) {
    Tried& here = tried_[i];
    place.element = here.element;
    hint_ = here.element;
    if (!here.is_visited) visited_.push_back(here.element);
    here.is_visited = true;
    if (i > 0) std::swap(here, tried_[0]);
    return place;
}

template <int D>
std::size_t Nearby<D>::remember(std::uint32_t element) {
    Tried here{.element = element, .map = element_map(mesh_, element), .centre = {}, .jacobian = {}, .inverse = {}};
    Barycentric<D> centre{};
    centre.fill(1.0 / (D + 1));
    here.centre = here.map.relative.point(centre);
    here.jacobian = {here.map.relative.derivatives(centre)};
    here.inverse = inverse(here.jacobian);
    tried_.push_back(here);
    return tried_.size() - 1;
}

namespace {

struct Counts {
    std::size_t preserved = 0, inside = 0, outside = 0, lost = 0;
    double largest_distance = 0;
};
Counts together(Counts a, const Counts& b) {
    a.preserved += b.preserved;
    a.inside += b.inside;
    a.outside += b.outside;
    a.lost += b.lost;
    a.largest_distance = std::max(a.largest_distance, b.largest_distance);
    return a;
}

template <int D>
Buffer<std::uint32_t> elements_at_nodes(const QuadraticMesh<D>& mesh) {
    Buffer<std::uint32_t> at(node_count_of(mesh, 2), none);
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        for (const std::size_t n : nodes_of<D, 2>(mesh, e)) at[n] = static_cast<std::uint32_t>(e);
    return at;
}

template <int D>
class Interpolation {
  public:
    Interpolation(const TransferMeshes<D>& meshes, std::span<const TransferField> fields)
        : old_(meshes.old_mesh),
          fields_(fields),
          new_(meshes.new_mesh),
          same_(meshes.same),
          sources_(meshes.sources),
          materials_(new_, meshes.materials),
          old_element_at_(elements_at_nodes(old_)) {
        for (const TransferField& field : fields) {
            nodes_ = std::max(nodes_, node_count_of(new_, field.degree));
            out_.values.emplace_back(node_count_of(new_, field.degree) * static_cast<std::size_t>(field.components));
        }
        out_.near.assign(new_.linear.points.size(), none);
    }

    [[nodiscard]] Outcome<Interpolated> run(const Execution& execution) {
        const std::size_t vertices = new_.linear.points.size();
        auto of_vertices = values_of(0, vertices, part_of(execution, 0, 0.15));
        if (!of_vertices) return fail(of_vertices.error());
        auto of_edges = values_of(vertices, std::max(nodes_, vertices), part_of(execution, 0.15, 1));
        if (!of_edges) return fail(of_edges.error());
        const Counts all = together(*of_vertices, *of_edges);
        TransferStatistics& statistics = out_.statistics;
        statistics.preserved = all.preserved;
        statistics.interpolated = all.inside;
        statistics.outside = all.outside;
        statistics.lost = all.lost;
        statistics.largest_distance = all.largest_distance;
        return std::move(out_);
    }

  private:
    [[nodiscard]] Outcome<Counts> values_of(std::size_t begin, std::size_t end, const Execution& execution) {
        return reduce_each(
            execution, end - begin, Counts{}, [&](Counts& counts, std::size_t i) { put(begin + i, counts); }, together,
            default_grain);
    }

    void put(std::size_t n, Counts& counts) {
        const std::uint32_t same = same_.old_node[n];
        const std::size_t vertices = new_.linear.points.size();
        if (same != none) {
            if (n < vertices) out_.near[n] = old_element_at_[same];
            if (copy_old_values(n, same)) {
                ++counts.preserved;
                return;
            }
        }
        const OldPosition<D> place = find(n);
        if (n < vertices) out_.near[n] = place.element;
        if (place.placement == Placement::inside) {
            ++counts.inside;
        } else {
            ++counts.outside;
            counts.lost += place.placement == Placement::lost ? 1 : 0;
            counts.largest_distance = std::max(counts.largest_distance, place.distance);
        }
        const auto linear = lagrange<D, 1>(place.xi);
        const auto quadratic = lagrange<D, 2>(place.xi);
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            if (!has_node(f, n) || (same != none && old_has_node(f, same))) continue;
            const auto out = row(f, n);
            std::ranges::fill(out, 0.0);
            if (fields_[f].degree == 1)
                add_field<D, 1>(old_, place.element, linear, fields_[f].values.data(), out);
            else
                add_field<D, 2>(old_, place.element, quadratic, fields_[f].values.data(), out);
        }
    }
    /// Copies the values of the old node. Returns false if a field has none (degree 1 at an edge node).
    [[nodiscard]] bool copy_old_values(std::size_t n, std::uint32_t same) {
        bool all = true;
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            if (!has_node(f, n)) continue;
            all = all && old_has_node(f, same);
            if (!old_has_node(f, same)) continue;
            const auto out = row(f, n);
            std::copy_n(fields_[f].values.data() + same * out.size(), out.size(), out.data());
        }
        return all;
    }

    /// Old position of new node n: in an element of one of the node's materials, or in the nearest such element.
    [[nodiscard]] OldPosition<D> find(std::size_t n) const {
        const Vec<D>& p = place_of(new_, n);
        OldPosition<D> best;
        materials_.visit(n, [&](std::size_t material) {
            const OldPosition<D> here = sources_.find(p, material, hint_of(n));
            if (best.element == none || here.placement == Placement::inside || here.distance < best.distance)
                best = here;
            return here.placement == Placement::inside;
        });
        return best;
    }
    [[nodiscard]] std::uint32_t hint_of(std::size_t n) const {
        const std::size_t vertices = new_.linear.points.size();
        return n < vertices ? out_.near[n] : out_.near[new_.edges.vertices[n - vertices][0].index()];
    }

    [[nodiscard]] bool has_node(std::size_t f, std::size_t n) const {
        return fields_[f].degree == 2 || n < new_.linear.points.size();
    }
    [[nodiscard]] bool old_has_node(std::size_t f, std::uint32_t n) const {
        return fields_[f].degree == 2 || n < old_.linear.points.size();
    }
    [[nodiscard]] std::span<double> row(std::size_t f, std::size_t n) {
        const auto components = static_cast<std::size_t>(fields_[f].components);
        return std::span(out_.values[f]).subspan(n * components, components);
    }

    const QuadraticMesh<D>& old_;
    std::span<const TransferField> fields_;
    const QuadraticMesh<D>& new_;
    const CommonParts& same_;
    const Sources<D>& sources_;
    NodeMaterials materials_;
    Buffer<std::uint32_t> old_element_at_;
    std::size_t nodes_ = 0;
    Interpolated out_;
};

}  // namespace

template <int D>
Outcome<Interpolated> interpolate(const TransferMeshes<D>& meshes, std::span<const TransferField> fields,
                                  const Execution& execution) {
    return guarded([&] { return Interpolation<D>(meshes, fields).run(execution); });
}

template <int D>
std::vector<std::uint8_t> requested_materials(const QuadraticMesh<D>& new_mesh, const Materials<D>& materials) {
    std::vector<std::uint8_t> is_requested(materials.size(), 0);
    std::vector<std::uint8_t> has_element(node_count_of(new_mesh, 2), 0);
    for (std::size_t e = 0; e < new_mesh.linear.elements.size(); ++e) {
        is_requested[materials.of(new_mesh.linear, e)] = 1;
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) has_element[n] = 1;
    }
    if (std::ranges::find(has_element, 0) != has_element.end()) is_requested[materials.rest()] = 1;
    return is_requested;
}

namespace {

constexpr std::size_t block_size = 16384;

template <int D, int K>
class Parts {
  public:
    static constexpr std::size_t nodes = field_nodes<D, K>;

    Parts(const ProjectionInput<D>& scene, Projection<D, K>& projection)
        : scene_(scene),
          projection_(projection),
          components_(projection.block.components),
          has_limits_(scene.options.bounds == TransferBounds::local),
          residuals_(components_ * nodes * block_size),
          limits_(has_limits_ ? 2 * components_ * block_size : 0) {
        projection.residual.assign(components_ * projection.matrix.size(), 0);
        constexpr double infinity = std::numeric_limits<double>::infinity();
        if (!has_limits_) return;
        projection.low.assign(components_ * projection.matrix.size(), infinity);
        projection.high.assign(components_ * projection.matrix.size(), -infinity);
    }

    struct Scratch {
        std::vector<double> values;
    };
    void begin(std::size_t i, std::size_t e, Scratch& scratch) {
        std::ranges::fill(row(i), 0.0);
        scratch.values.clear();
        const auto all = nodes_of<D, K>(scene_.new_mesh, e);
        for (std::size_t c = 0; c < components_; ++c)
            for (const std::size_t n : all) scratch.values.push_back(projection_.block.values[n * components_ + c]);
    }

    /// Adds weight φ (u_old − u) at quadrature point q, whose old position is `place`.
    void add(std::size_t i, std::size_t q, double weight, const OldPosition<D>& place, Scratch& scratch) {
        if (components_ == 0) return;
        const auto& phi = projection_.reference.functions[q];
        const auto old_phi = lagrange<D, K>(place.xi);
        const auto old_nodes = nodes_of<D, K>(scene_.old_mesh, place.element);
        for (std::size_t c = 0; c < components_; ++c) {
            const double* const values = scratch.values.data() + c * nodes;
            double difference = 0;
            for (std::size_t k = 0; k < nodes; ++k)
                difference +=
                    old_phi[k] * projection_.block.old_values[old_nodes[k] * components_ + c] - phi[k] * values[k];
            double* const out = residuals_.data() + (i * components_ + c) * nodes;
            for (std::size_t k = 0; k < nodes; ++k) out[k] += weight * difference * phi[k];
        }
    }
    void limit(std::size_t i, std::span<const std::uint32_t> old_elements) {
        if (!has_limits_) return;
        for (std::size_t c = 0; c < components_; ++c) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (const std::uint32_t o : old_elements)
                for (const std::size_t n : nodes_of<D, K>(scene_.old_mesh, o)) {
                    low = std::min(low, projection_.block.old_values[n * components_ + c]);
                    high = std::max(high, projection_.block.old_values[n * components_ + c]);
                }
            limits_[2 * (i * components_ + c)] = low;
            limits_[2 * (i * components_ + c) + 1] = high;
        }
    }
    void scatter(std::size_t i, std::size_t slot) {
        if (components_ == 0) return;
        const auto& unknowns = projection_.matrix.unknowns(slot);
        const auto from = row(i);
        for (std::size_t k = 0; k < nodes; ++k) {
            if (unknowns[k] == none) continue;
            for (std::size_t c = 0; c < components_; ++c) {
                projection_.residual[c * projection_.matrix.size() + unknowns[k]] += from[c * nodes + k];
                if (!has_limits_) continue;
                double& low = projection_.low[unknowns[k] * components_ + c];
                double& high = projection_.high[unknowns[k] * components_ + c];
                low = std::min(low, limits_[2 * (i * components_ + c)]);
                high = std::max(high, limits_[2 * (i * components_ + c) + 1]);
            }
        }
    }

  private:
    [[nodiscard]] std::span<double> row(std::size_t i) {
        return std::span(residuals_).subspan(i * components_ * nodes, components_ * nodes);
    }

    const ProjectionInput<D>& scene_;
    Projection<D, K>& projection_;
    std::size_t components_;
    bool has_limits_;
    Buffer<double> residuals_, limits_;
};

}  // namespace

template <int D>
Outcome<Done> integrate_residuals(const ProjectionInput<D>& scene, Projection<D, 1>& linear,
                                  Projection<D, 2>& quadratic, PatchSearch<D>& patches, const Execution& execution) {
    Parts<D, 1> linear_parts(scene, linear);
    Parts<D, 2> quadratic_parts(scene, quadratic);
    std::vector<std::vector<std::uint32_t>> visited(block_size);
    const auto& elements = scene.changed.new_elements;
    const auto& rule = quadratic.reference.rule;
    struct Scratch {
        Nearby<D> nearby;
        typename Parts<D, 1>::Scratch linear;
        typename Parts<D, 2>::Scratch quadratic;
    };
    const auto integrate = [&](std::size_t i, std::uint32_t e, Scratch& scratch) {
        auto& nearby = scratch.nearby;
        const ElementMap<D> map = element_map(scene.new_mesh, e);
        linear_parts.begin(i, e, scratch.linear);
        quadratic_parts.begin(i, e, scratch.quadratic);
        nearby.begin(scene.materials.of(scene.new_mesh.linear, e),
                     scene.near[scene.new_mesh.linear.elements.vertices[e][0].index()]);
        for (std::size_t q = 0; q < rule.size(); ++q) {
            const OldPosition<D> place = nearby.find(map.at(rule[q].xi));
            const double weight = rule[q].weight * std::abs(map.determinant(rule[q].xi));
            linear_parts.add(i, q, weight, place, scratch.linear);
            quadratic_parts.add(i, q, weight, place, scratch.quadratic);
        }
        linear_parts.limit(i, nearby.visited());
        quadratic_parts.limit(i, nearby.visited());
        visited[i].assign(nearby.visited().begin(), nearby.visited().end());
    };
    for (std::size_t begin = 0; begin < elements.size(); begin += block_size) {
        const std::size_t n = std::min(block_size, elements.size() - begin);
        report_progress(execution, begin, elements.size());
        auto done = each_chunk(
            without_progress(execution), n,
            [&](std::size_t from, std::size_t to) {
                Scratch scratch{.nearby = Nearby<D>(scene.old_mesh, scene.sources), .linear = {}, .quadratic = {}};
                for (std::size_t i = from; i < to; ++i) integrate(i, elements[begin + i], scratch);
            },
            64);
        if (!done) return done;
        for (std::size_t i = 0; i < n; ++i) {
            linear_parts.scatter(i, begin + i);
            quadratic_parts.scatter(i, begin + i);
            for (const std::uint32_t o : visited[i]) patches.found(begin + i, o);
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template class Sources<D>;                                                                                     \
    template class Nearby<D>;                                                                                      \
    template Outcome<Interpolated> interpolate<D>(const TransferMeshes<D>&, std::span<const TransferField>,        \
                                                  const Execution&);                                               \
    template std::vector<std::uint8_t> requested_materials<D>(const QuadraticMesh<D>&, const Materials<D>&);       \
    template Outcome<Done> integrate_residuals<D>(const ProjectionInput<D>&, Projection<D, 1>&, Projection<D, 2>&, \
                                                  PatchSearch<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

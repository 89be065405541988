// Derivatives of fields at vertices, and normal gradients on facets.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recovery;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Minimum `Fit::independence`. Noise of the values is amplified by 1/sqrt(independence). For fields of degree k,
/// independence inside meshes is at least 0.004 for degree k + 2, and about 0.001 for k + 3.
constexpr double min_independence = 1e-4;
/// Nodes requested for each coefficient of a polynomial of degree P. If boundary rows use a polynomial, it needs more
/// nodes, because noise grows outside the region of the nodes.
constexpr double nodes_per_coefficient = 4;
template <int D>
constexpr double nodes_per_shared_coefficient = D == 2 ? 6 : 9;
/// Numbers of nodes per coefficient for fields of degree k:
/// - `surplus_nodes`: required for polynomials of degree k + 3.
/// - `few_nodes`: required for degrees k + 2 and k + 1.
/// - `own_nodes`: requested for boundary rows without inner fits.
constexpr double surplus_nodes = 3, few_nodes = 1.3, own_nodes = 2;
constexpr std::size_t fit_grain = 64;

constexpr std::uint32_t no_slot = 0xffffffffU;

template <int D>
struct Columns {
    Buffer<Vec<D>> gradients;
    Buffer<Sym<D>> hessians;
    Buffer<CubicForm<D>> thirds;

    Columns(std::size_t rows, int degree) : gradients(rows), hessians(rows), thirds(degree == 2 ? rows : 0) {}
    void put(std::size_t row, const Derivatives<D>& d) {
        gradients[row] = d.gradient;
        hessians[row] = d.hessian;
        if (!thirds.empty()) thirds[row] = d.third;
    }
};

template <int D, int K, int P>
class Recovery {
  public:
    Recovery(const NodalMesh<D>& nodal, const MaterialRows& rows, const Buffer<std::uint8_t>& boundary,
             std::span<const Column<double>> fields, const RecoveryOptions& options)
        : nodal_(nodal),
          rows_(rows),
          boundary_(boundary),
          fields_(fields),
          options_(options),
          sources_(rows.size(), RowSource::own_fit),
          degrees_(rows.size(), 0),
          slots_(rows.size(), no_slot) {
        columns_.reserve(fields.size());
        for (std::size_t f = 0; f < fields.size(); ++f) columns_.emplace_back(rows.size(), K);
    }

    Outcome<Done> run(const Execution& execution) {
        if (auto done = find_inner(part_of(execution, 0, 0.05)); !done) return done;
        if (auto done = fit_all(part_of(execution, 0.05, 0.9)); !done) return done;
        return take_inner(part_of(execution, 0.9, 1));
    }

    RecoveredDerivatives<D> result() && {
        RecoveredDerivatives<D> out;
        out.degree = K;
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            out.from_inner_fits += sources_[r] == RowSource::inner_fits;
            out.lower_degree += degrees_[r] < K + 2;
            out.missing += degrees_[r] < K + 1;
        }
        for (auto& c : columns_)
            out.fields.push_back({std::move(c.gradients), std::move(c.hessians), std::move(c.thirds)});
        out.sources = std::move(sources_);
        out.polynomial_degrees = std::move(degrees_);
        return out;
    }

  private:
    struct StoredFrame {
        Vec<D> origin;
        Mat<D> whitened_by;
    };
    struct Polynomial {
        Coefficients<D, P> c;
        Unit unit;
    };
    struct Work {
        Rings<D> rings;
        Fit<D, P> fit;
        std::vector<Vec<D>> offsets;
        std::vector<double> values;
        std::vector<std::size_t> inner;
    };

    template <class Visit>
    Outcome<Done> each_row(const Execution& execution, const NodalMesh<D>& walked, Visit&& visit) {
        return each_chunk(
            execution, rows_.vertices(),
            [&](std::size_t begin, std::size_t end) {
                Work work{Rings<D>(walked), {}, {}, {}, {}};
                for (std::size_t v = begin; v < end; ++v)
                    for (std::size_t row = rows_.materials.offsets[v]; row < rows_.materials.offsets[v + 1]; ++row)
                        visit(work, VertexId(v), row);
            },
            fit_grain);
    }

    void find_inner_of(Work& work, VertexId v, std::size_t row) const {
        const Reference material = rows_.materials.items[row];
        work.inner.clear();
        work.rings.begin(v, material);
        for (int ring = 0; ring < options_.boundary_rings && work.inner.empty(); ++ring) {
            if (!work.rings.grow()) return;
            for (const VertexId w : work.rings.last_vertices())
                if (const std::size_t other = *rows_.row(w, material); boundary_[other] == 0)
                    work.inner.push_back(other);
        }
    }

    Outcome<Done> find_inner(const Execution& execution) {
        auto done = each_row(execution, vertex_mesh(), [&](Work& work, VertexId v, std::size_t row) {
            if (boundary_[row] == 0) return;
            find_inner_of(work, v, row);
            if (work.inner.empty()) return;
            sources_[row] = RowSource::inner_fits;
            for (const std::size_t other : work.inner)
                std::atomic_ref(slots_[other]).store(0, std::memory_order_relaxed);
        });
        if (!done) return done;
        std::uint32_t count = 0;
        for (std::uint32_t& slot : slots_)
            if (slot != no_slot) slot = count++;
        stored_ = Buffer<StoredFrame>(count);
        polynomials_ = Buffer<Polynomial>(count * fields_.size());
        return Done{};
    }

    [[nodiscard]] NodalMesh<D> vertex_mesh() const { return {nodal_.mesh, nodal_.balls, 1}; }

    void place(Work& work, VertexId v) const {
        const Vec<D> origin = nodal_.mesh.linear.points[v];
        work.offsets.clear();
        double largest = 0;
        for (const std::uint32_t node : work.rings.nodes()) {
            const Vec<D> x = nodal_.place(node);
            for (const double c : x.c) largest = std::max(largest, std::abs(c));
            work.offsets.push_back(x - origin);
        }
        work.fit.place(work.offsets, std::numeric_limits<double>::epsilon() * largest, options_.core);
    }

    struct FitRequest {
        int degree, least;
        double nodes;
    };
    [[nodiscard]] FitRequest fit_request(std::size_t row) const {
        if (boundary_[row] != 0) return {K + 1, K + 1, own_nodes * monomials_up_to<D>(K + 1)};
        return {
            P, K + 2,
            (slots_[row] == no_slot ? nodes_per_coefficient : nodes_per_shared_coefficient<D>)*monomials_up_to<D>(P)};
    }

    [[nodiscard]] static int determined(const Fit<D, P>& fit, int degree) {
        const auto nodes = static_cast<double>(fit.nodes());
        for (; degree > 0; --degree) {
            const double share = degree > K + 2 ? surplus_nodes : degree > K ? few_nodes : 1;
            if (nodes >= share * monomials_up_to<D>(degree) && fit.independence(degree) >= min_independence)
                return degree;
        }
        return 0;
    }

    /// Gathers rings of nodes around a vertex: the requested number, and more until they determine a polynomial of
    /// degree `least`. Returns the degree that the nodes determine, which is lower if the rings end.
    int gather(Work& work, VertexId v, Reference material, const FitRequest& request) const {
        const auto grow = [&] { return work.rings.count() < options_.max_rings && work.rings.grow(); };
        work.rings.begin(v, material);
        while (work.rings.count() < options_.rings && work.rings.grow()) {
        }
        while (static_cast<double>(work.rings.nodes().size()) < request.nodes && grow()) {
        }
        for (;;) {
            place(work, v);
            const int degree = determined(work.fit, request.degree);
            if (degree >= request.least || !grow()) return degree;
        }
    }

    /// Fits a polynomial of the highest degree that the nodes determine.
    int determine(Work& work, VertexId v, std::size_t row) const {
        FitRequest request = fit_request(row);
        for (;;) {
            const int degree = gather(work, v, rows_.materials.items[row], request);
            if (degree >= request.least) return degree;
            // A polynomial of lower degree needs fewer rings of nodes.
            request = {degree, degree, few_nodes * monomials_up_to<D>(degree)};
        }
    }

    Outcome<Done> fit_all(const Execution& execution) {
        return each_row(execution, nodal_, [&](Work& work, VertexId v, std::size_t row) {
            if (sources_[row] == RowSource::own_fit) fit(work, v, row);
        });
    }

    void fit(Work& work, VertexId v, std::size_t row) {
        const int degree = determine(work, v, row);
        degrees_[row] = static_cast<std::uint8_t>(degree);
        const std::uint32_t slot = slots_[row];
        if (slot != no_slot) stored_[slot] = {nodal_.mesh.linear.points[v], work.fit.whitened_by()};
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            work.values.clear();
            for (const std::uint32_t node : work.rings.nodes()) work.values.push_back(fields_[f][node]);
            Polynomial p{{}, scale(work.values)};
            if (p.unit.half > 0) p.c = work.fit.solve(work.values, degree);
            columns_[f].put(row, by_place(p, derivatives_at_origin<D, P>(p.c), work.fit.whitened_by()));
            if (slot != no_slot) polynomials_[slot * fields_.size() + f] = p;
        }
    }

    static Derivatives<D> by_place(const Polynomial& p, const Derivatives<D>& by_y, const Mat<D>& whitened_by) {
        Derivatives<D> d = pulled_back(by_y, whitened_by);
        for (double& c : d.gradient.c) c = p.unit.times(c);
        for (double& c : d.hessian.c) c = p.unit.times(c);
        for (double& c : d.third.c) c = p.unit.times(c);
        return d;
    }

    Outcome<Done> take_inner(const Execution& execution) {
        return each_row(execution, vertex_mesh(), [&](Work& work, VertexId v, std::size_t row) {
            if (sources_[row] != RowSource::inner_fits) return;
            find_inner_of(work, v, row);
            degrees_[row] = P;
            for (const std::size_t other : work.inner) degrees_[row] = std::min(degrees_[row], degrees_[other]);
            for (std::size_t f = 0; f < fields_.size(); ++f) columns_[f].put(row, mean_of_inner(work.inner, v, f));
        });
    }

    Derivatives<D> mean_of_inner(std::span<const std::size_t> inner, VertexId v, std::size_t field) const {
        Derivatives<D> mean;
        const double share = 1 / static_cast<double>(inner.size());
        for (const std::size_t other : inner) {
            const std::uint32_t slot = slots_[other];
            const StoredFrame& stored = stored_[slot];
            const Vec<D> y = stored.whitened_by * (nodal_.mesh.linear.points[v] - stored.origin);
            const auto& p = polynomials_[slot * fields_.size() + field];
            const Derivatives<D> d = by_place(p, derivatives_at<D, P>(p.c, y), stored.whitened_by);
            mean.gradient += share * d.gradient;
            mean.hessian += share * d.hessian;
            mean.third += share * d.third;
        }
        return mean;
    }

    NodalMesh<D> nodal_;
    const MaterialRows& rows_;
    const Buffer<std::uint8_t>& boundary_;
    std::span<const Column<double>> fields_;
    RecoveryOptions options_;
    std::vector<Columns<D>> columns_;
    Buffer<RowSource> sources_;
    Buffer<std::uint8_t> degrees_;
    Buffer<std::uint32_t> slots_;
    Buffer<StoredFrame> stored_;
    Buffer<Polynomial> polynomials_;
};

template <int D, int K, int P>
Outcome<RecoveredDerivatives<D>> recovered(const NodalMesh<D>& nodal, std::span<const Column<double>> fields,
                                           const RecoveryOptions& options, const Execution& execution) {
    auto rows = material_rows(nodal.mesh.linear, nodal.balls, execution);
    if (!rows) return fail(rows.error());
    const auto boundary = boundary_rows(nodal.mesh.linear, nodal.balls, *rows, without_progress(execution));
    if (!boundary) return fail(boundary.error());
    Recovery<D, K, P> recovery(nodal, *rows, *boundary, fields, options);
    if (auto done = recovery.run(execution); !done) return fail(done.error());
    RecoveredDerivatives<D> out = std::move(recovery).result();
    out.rows = std::move(*rows);
    if (auto finite = check_results(out, execution); !finite) return fail(finite.error());
    return out;
}

}  // namespace

template <int D>
Outcome<RecoveredDerivatives<D>> recover_derivatives(const QuadraticMesh<D>& mesh,
                                                     std::span<const Column<double>> fields,
                                                     const RecoveryOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<RecoveredDerivatives<D>> {
        if (auto sound = check_limits(options); !sound) return fail(sound.error());
        const auto nodes = checked_nodes(mesh, fields, execution);
        if (!nodes) return fail(nodes.error());
        const NodalMesh<D> nodal = nodes->of(mesh);
        return nodal.degree == 1 ? recovered<D, 1, 4>(nodal, fields, options, execution)
                                 : recovered<D, 2, 5>(nodal, fields, options, execution);
    });
}

template Outcome<RecoveredDerivatives<2>> recover_derivatives<2>(const QuadraticMesh<2>&,
                                                                 std::span<const Column<double>>,
                                                                 const RecoveryOptions&, const Execution&);
template Outcome<RecoveredDerivatives<3>> recover_derivatives<3>(const QuadraticMesh<3>&,
                                                                 std::span<const Column<double>>,
                                                                 const RecoveryOptions&, const Execution&);

namespace {

template <class Wrong>
Outcome<std::size_t> first_where(std::size_t n, const Execution& execution, Wrong&& wrong) {
    return reduce_each(
        without_progress(execution), n, n,
        [&](std::size_t& found, std::size_t i) {
            if (found == n && wrong(i)) found = i;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

template <int D>
Entity node_entity(const QuadraticMesh<D>& mesh, std::size_t node) {
    const std::size_t vertices = mesh.linear.points.size();
    return node < vertices ? Entity{"vertex", node + 1} : Entity{"edge", node - vertices + 1};
}

template <int D>
Outcome<int> degree_of(const QuadraticMesh<D>& mesh, std::span<const Column<double>> fields) {
    const std::size_t vertices = mesh.linear.points.size(), nodes = vertices + mesh.edges.size();
    int degree = 1;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        const std::size_t n = fields[f].size();
        if (f == 0 && n != vertices) degree = 2;
        if (n != (degree == 1 ? vertices : nodes))
            return fail(ErrorKind::usage, "field " + std::to_string(f + 1) + " has " + std::to_string(n) + " values",
                        {}, {},
                        "give all fields of a call one value per vertex (" + std::to_string(vertices) +
                            "), or one per vertex and one per edge (" + std::to_string(nodes) + ")");
    }
    if (degree == 2 &&
        (mesh.edges.of_elements.size() != mesh.linear.elements.size() || mesh.mid_nodes.size() != mesh.edges.size()))
        return fail(ErrorKind::input, "the edges of the mesh or their nodes do not match its elements", {}, {},
                    "elevate it");
    return degree;
}

template <int D>
Outcome<Done> check_finite(const NodalMesh<D>& nodal, std::span<const Column<double>> fields,
                           const Execution& execution) {
    const QuadraticMesh<D>& mesh = nodal.mesh;
    const std::size_t nodes = mesh.linear.points.size() + (nodal.degree == 2 ? mesh.mid_nodes.size() : 0);
    const auto no_position = first_where(
        nodes, execution, [&](std::size_t i) { return !is_finite(nodal.place(static_cast<std::uint32_t>(i))); });
    if (!no_position) return fail(no_position.error());
    if (*no_position < nodes)
        return fail(ErrorKind::input, "has a coordinate that is not a finite number", {},
                    node_entity(mesh, *no_position), "repair the mesh");
    for (std::size_t f = 0; f < fields.size(); ++f) {
        const auto wrong = first_where(nodes, execution, [&](std::size_t i) { return !std::isfinite(fields[f][i]); });
        if (!wrong) return fail(wrong.error());
        if (*wrong < nodes)
            return fail(ErrorKind::usage, "the value of field " + std::to_string(f + 1) + " is not a finite number", {},
                        node_entity(mesh, *wrong), "give a solution that has converged");
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<CheckedNodes<D>> checked_nodes(const QuadraticMesh<D>& mesh, std::span<const Column<double>> fields,
                                       const Execution& execution) {
    const auto degree = degree_of(mesh, fields);
    if (!degree) return fail(degree.error());
    const auto& elements = mesh.linear.elements;
    if (auto one_each = check_materials(elements.references.size(), elements.size()); !one_each)
        return fail(one_each.error());
    auto around = balls(mesh.linear, without_progress(execution));
    if (!around) return fail(around.error());
    CheckedNodes<D> nodes{*degree, std::move(*around)};
    if (auto finite = check_finite(nodes.of(mesh), fields, execution); !finite) return fail(finite.error());
    return nodes;
}

template <int D>
Outcome<Done> check_results(const RecoveredDerivatives<D>& recovered, const Execution& execution) {
    const std::size_t rows = recovered.rows.size();
    for (std::size_t f = 0; f < recovered.fields.size(); ++f) {
        const auto& field = recovered.fields[f];
        const auto wrong = first_where(rows, execution, [&](std::size_t r) {
            const auto finite = [](const auto& t) {
                return std::all_of(t.c.begin(), t.c.end(), [](double c) { return std::isfinite(c); });
            };
            return !finite(field.gradients[r]) || !finite(field.hessians[r]) ||
                   (!field.thirds.empty() && !finite(field.thirds[r]));
        });
        if (!wrong) return fail(wrong.error());
        if (*wrong == rows) continue;
        const auto& offsets = recovered.rows.materials.offsets;
        const auto after = std::upper_bound(offsets.begin(), offsets.end(), *wrong);
        return fail(ErrorKind::usage,
                    "derivatives of field " + std::to_string(f + 1) + " are too large for floating-point numbers", {},
                    Entity{"vertex", static_cast<std::size_t>(after - offsets.begin())},
                    "give the field, or the mesh, in other units");
    }
    return Done{};
}

namespace {

using ByReference = std::map<Reference, NormalGradients>;

Vec<2> normal_to(const std::array<Vec<2>, 1>& columns) { return {{columns[0][1], -columns[0][0]}}; }
Vec<3> normal_to(const std::array<Vec<3>, 2>& columns) { return cross(columns[0], columns[1]); }

template <int D>
std::array<Vec<D>, D> normals_at_corners(const QuadraticMesh<D>& mesh, FacetId f) {
    const QuadraticSimplex<D - 1, D> facet = facet_of(mesh, f);
    std::array<Vec<D>, D> normals;
    for (int i = 0; i < D; ++i) {
        Barycentric<D - 1> corner{};
        corner[i] = 1;
        normals[i] = normalised(normal_to(facet.derivatives(corner)));
    }
    return normals;
}

template <int D>
double area_of(const LinearMesh<D>& mesh, FacetId f) {
    const auto& corners = mesh.facets.vertices[f];
    std::array<Vec<D>, D - 1> sides;
    for (int i = 0; i < D - 1; ++i) sides[i] = mesh.points[corners[i + 1]] - mesh.points[corners[0]];
    return norm(normal_to(sides)) / (D - 1);
}

template <int D>
class AtFacets {
  public:
    AtFacets(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& balls,
             const RecoveredDerivatives<D>& derivatives, std::span<const double> weights)
        : mesh_(mesh), balls_(balls), derivatives_(derivatives), weights_(weights) {}

    void add(FacetId f, NormalGradients& sums) const {
        const double area = area_of(mesh_.linear, f);
        sums.area += area;
        for (const double gradient : at_corners(f)) {
            sums.integral += area / D * gradient;
            sums.squares += area / D * gradient * gradient;
        }
    }

  private:
    [[nodiscard]] std::array<double, D> at_corners(FacetId f) const {
        const auto& corners = mesh_.linear.facets.vertices[f];
        const auto normals = normals_at_corners(mesh_, f);
        std::array<double, D> gradients{};
        for (const ElementId e : balls_[corners[0]]) {
            const auto& vertices = mesh_.linear.elements.vertices[e];
            const auto has = [&](VertexId v) { return std::ranges::find(vertices, v) != vertices.end(); };
            if (!std::ranges::all_of(corners, has)) continue;
            for (int i = 0; i < D; ++i)
                if (const auto row = derivatives_.rows.row(corners[i], mesh_.linear.elements.references[e]))
                    gradients[i] = std::max(gradients[i], along(normals[i], *row));
        }
        return gradients;
    }
    [[nodiscard]] double along(const Vec<D>& normal, std::size_t row) const {
        double sum = 0;
        for (std::size_t f = 0; f < weights_.size(); ++f) {
            const double part = weights_[f] * dot(normal, derivatives_.fields[f].gradients[row]);
            sum += part * part;
        }
        return std::sqrt(sum);
    }

    const QuadraticMesh<D>& mesh_;
    const Incidence<ElementId>& balls_;
    const RecoveredDerivatives<D>& derivatives_;
    const std::span<const double> weights_;
};

}  // namespace

template <int D>
Outcome<std::vector<NormalGradients>> normal_gradients(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                       const RecoveredDerivatives<D>& derivatives,
                                                       std::span<const double> weights, const Execution& execution) {
    if (weights.size() != derivatives.fields.size())
        return fail(ErrorKind::usage, "there must be one weight per field");
    const AtFacets<D> at(mesh, balls, derivatives, weights);
    const auto found = reduce_each(
        execution, mesh.linear.facets.size(), ByReference{},
        [&](ByReference& all, std::size_t f) { at.add(FacetId(f), all[mesh.linear.facets.references[FacetId(f)]]); },
        [](ByReference a, const ByReference& b) {
            for (const auto& [reference, part] : b) {
                NormalGradients& sums = a[reference];
                sums.area += part.area;
                sums.integral += part.integral;
                sums.squares += part.squares;
            }
            return a;
        });
    if (!found) return fail(found.error());
    std::vector<NormalGradients> gradients;
    gradients.reserve(found->size());
    for (const auto& [reference, sums] : *found)
        gradients.push_back({reference, sums.area, sums.integral, sums.squares});
    return gradients;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<CheckedNodes<D>> checked_nodes<D>(const QuadraticMesh<D>&, std::span<const Column<double>>,       \
                                                       const Execution&);                                              \
    template Outcome<Done> check_results<D>(const RecoveredDerivatives<D>&, const Execution&);                         \
    template Outcome<std::vector<NormalGradients>> normal_gradients<D>(                                                \
        const QuadraticMesh<D>&, const Incidence<ElementId>&, const RecoveredDerivatives<D>&, std::span<const double>, \
        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

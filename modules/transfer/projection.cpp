// L2 projection of fields: mass matrices, patches and solution.
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
// Eigen's default is the macro alloca, which is not defined if the standard headers are imported as a module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
module camber.transfer;
import camber.core;
import camber.bezier;
import camber.interpolation;
import :materials;
import :projection;

namespace camber {

namespace {

/// Maximum number of nodes of all element types, so that Eigen's decomposition is compiled once.
constexpr int most_nodes = field_nodes<3, 2>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, most_nodes, most_nodes>;

std::array<double, 2> extremes(const Square& symmetric) {
    const Eigen::SelfAdjointEigenSolver<Square> solver(symmetric, Eigen::EigenvaluesOnly);
    return {solver.eigenvalues()[0], solver.eigenvalues()[symmetric.rows() - 1]};
}

}  // namespace

template <int D, int K>
ReferenceMass<D, K>::ReferenceMass(int points_per_direction) : rule(conical_rule<D>(points_per_direction)) {
    for (const RulePoint<D>& point : rule) {
        const Functions phi = lagrange<D, K>(point.xi);
        functions.push_back(phi);
        for (int i = 0; i < nodes; ++i)
            for (int j = 0; j <= i; ++j) matrix[packed_index(i, j)] += point.weight * phi[i] * phi[j];
    }
    const auto bounds = eigenvalues(matrix);
    low = bounds[0];
    high = bounds[1];
}

template <int D, int K>
auto ReferenceMass<D, K>::curved(const ElementMap<D>& map) const -> Curved {
    Curved out;
    out.least = std::numeric_limits<double>::infinity();
    out.largest = -out.least;
    for (std::size_t q = 0; q < rule.size(); ++q) {
        const double determinant = map.determinant(rule[q].xi);
        out.least = std::min(out.least, determinant);
        out.largest = std::max(out.largest, determinant);
        const double weight = rule[q].weight * std::abs(determinant);
        for (int i = 0; i < nodes; ++i)
            for (int j = 0; j <= i; ++j) out.matrix[packed_index(i, j)] += weight * functions[q][i] * functions[q][j];
    }
    return out;
}

template <int D, int K>
std::array<double, 2> ReferenceMass<D, K>::eigenvalues(const Matrix& matrix) {
    Square scaled(nodes, nodes);
    for (int i = 0; i < nodes; ++i)
        for (int j = 0; j < nodes; ++j)
            scaled(i, j) =
                matrix[packed_index(i, j)] / std::sqrt(matrix[packed_index(i, i)] * matrix[packed_index(j, j)]);
    if (!scaled.allFinite()) return {0, nodes};
    return extremes(scaled);
}

template <int D, int K>
Outcome<MassMatrix<D, K>> MassMatrix<D, K>::make(const QuadraticMesh<D>& mesh,
                                                 const std::vector<std::uint32_t>& elements,
                                                 const Buffer<std::uint8_t>& is_free,
                                                 const ReferenceMass<D, K>& reference, const Execution& execution) {
    return guarded([&]() -> Outcome<MassMatrix> {
        MassMatrix m;
        for (int i = 0; i < nodes; ++i)
            for (int j = 0; j < nodes; ++j) m.straight_[i * nodes + j] = reference.matrix[packed_index(i, j)];
        m.number(mesh, elements, is_free);
        m.products_ = Buffer<std::array<double, nodes>>(elements.size());
        if (auto weighed = m.weigh(mesh, elements, reference, execution); !weighed) return fail(weighed.error());
        m.inverse_diagonal_ = Buffer<double>(m.size());
        const auto diagonals = [&](std::size_t slot) {
            std::array<double, nodes> d{};
            for (int i = 0; i < nodes; ++i) d[i] = m.diagonal(slot, i);
            return d;
        };
        if (auto done = m.assemble(diagonals, m.inverse_diagonal_, execution); !done) return fail(done.error());
        for (double& d : m.inverse_diagonal_)
            d = d > 0 ? 1 / d : 0;  // 0 for nodes whose elements all vanish: their
                                    // values do not change
        return m;
    });
}

template <int D, int K>
void MassMatrix<D, K>::number(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                              const Buffer<std::uint8_t>& is_free) {
    Buffer<std::uint32_t> unknown_of(is_free.size(), none);
    for (const std::uint32_t e : elements)
        for (const std::size_t n : nodes_of<D, K>(mesh, e))
            if (is_free[n] != 0) unknown_of[n] = 0;
    for (std::size_t n = 0; n < unknown_of.size(); ++n) {
        if (unknown_of[n] == none) continue;
        unknown_of[n] = static_cast<std::uint32_t>(node_of_.size());
        node_of_.push_back(static_cast<std::uint32_t>(n));
    }
    unknowns_ = Buffer<Local>(elements.size());
    offsets_.assign(node_of_.size() + 1, 0);
    for (std::size_t slot = 0; slot < elements.size(); ++slot) {
        const auto all = nodes_of<D, K>(mesh, elements[slot]);
        for (int i = 0; i < nodes; ++i) {
            unknowns_[slot][i] = unknown_of[all[i]];
            if (unknowns_[slot][i] != none) ++offsets_[unknowns_[slot][i] + 1];
        }
    }
    for (std::size_t u = 0; u < node_of_.size(); ++u) offsets_[u + 1] += offsets_[u];
    items_ = Buffer<std::uint32_t>(offsets_.back());
    Buffer<std::uint32_t> next(offsets_.begin(), offsets_.end());
    for (std::size_t slot = 0; slot < elements.size(); ++slot)
        for (int i = 0; i < nodes; ++i)
            if (const std::uint32_t u = unknowns_[slot][i]; u != none)
                items_[next[u]++] = static_cast<std::uint32_t>(slot * nodes + i);
}

template <int D, int K>
Outcome<Done> MassMatrix<D, K>::weigh(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                                      const ReferenceMass<D, K>& reference, const Execution& execution) {
    scales_ = Buffer<double>(elements.size());
    curved_at_.assign(elements.size(), none);
    std::vector<std::uint32_t> slots;
    for (std::size_t slot = 0; slot < elements.size(); ++slot)
        if (!element_map(mesh, elements[slot]).is_straight) {
            curved_at_[slot] = static_cast<std::uint32_t>(slots.size());
            slots.push_back(static_cast<std::uint32_t>(slot));
        }
    curved_ = Buffer<typename ReferenceMass<D, K>::Matrix>(slots.size());
    struct ValueRange {
        double low = 0, high = 0;
        std::size_t turned = 0;
    };
    const auto value_range = reduce_each(
        execution, elements.size(), ValueRange{reference.low, reference.high},
        [&](ValueRange& all, std::size_t slot) {
            const ElementMap<D> map = element_map(mesh, elements[slot]);
            if (curved_at_[slot] == none) {
                const double determinant = map.determinant(reference.rule[0].xi);
                scales_[slot] = std::abs(determinant);
                all.turned += determinant > 0 ? 0 : 1;
                return;
            }
            const auto element = reference.curved(map);
            curved_[curved_at_[slot]] = element.matrix;
            scales_[slot] = 0;
            all.turned += element.least > 0 ? 0 : 1;
            // If m ≤ det J ≤ n and M̂ is the reference mass matrix, then m M̂ ≤ M ≤ n M̂. The same holds for the
            // diagonals. These bounds suffice if det J varies little.
            const double ratio = element.largest / element.least;
            std::array<double, 2> bounds{reference.low / ratio, reference.high * ratio};
            if (!(element.least > 0) || !(ratio < 1.5)) bounds = ReferenceMass<D, K>::eigenvalues(element.matrix);
            all.low = std::min(all.low, bounds[0]);
            all.high = std::max(all.high, bounds[1]);
        },
        [](ValueRange a, const ValueRange& b) {
            return ValueRange{std::min(a.low, b.low), std::max(a.high, b.high), a.turned + b.turned};
        });
    if (!value_range) return fail(value_range.error());
    low_ = value_range->low;
    high_ = value_range->high;
    turned_ = value_range->turned;
    return Done{};
}

template <int D, int K>
double MassMatrix<D, K>::diagonal(std::size_t slot, int i) const {
    const std::uint32_t at = curved_at_[slot];
    return at == none ? scales_[slot] * straight_[i * nodes + i] : curved_[at][packed_index(i, i)];
}

template <int D, int K>
auto MassMatrix<D, K>::product(std::size_t slot, std::span<const double> x) const -> std::array<double, nodes> {
    std::array<double, nodes> in{};
    for (int i = 0; i < nodes; ++i)
        if (unknowns_[slot][i] != none) in[i] = x[unknowns_[slot][i]];
    return local_product(slot, in);
}

template <int D, int K>
auto MassMatrix<D, K>::local_product(std::size_t slot, const std::array<double, nodes>& in) const
    -> std::array<double, nodes> {
    std::array<double, nodes> out{};
    const std::uint32_t at = curved_at_[slot];
    if (at == none) {
        for (int j = 0; j < nodes; ++j)
            for (int i = 0; i < nodes; ++i) out[i] += straight_[j * nodes + i] * in[j];
        for (double& y : out) y *= scales_[slot];
        return out;
    }
    const double* entry = curved_[at].data();
    for (int i = 0; i < nodes; ++i) {
        double sum = 0;
        for (int j = 0; j < i; ++j, ++entry) {
            sum += *entry * in[j];
            out[j] += *entry * in[i];
        }
        out[i] += sum + *entry++ * in[i];
    }
    return out;
}

template <int D, int K>
Outcome<Done> MassMatrix<D, K>::solve(std::span<double> r, std::span<double> x, const Execution& execution) {
    // Algorithm 12.1 of Saad, Iterative Methods for Sparse Linear Systems, for eigenvalues in θ ± δ with condition
    // number κ. The error falls as 2 q^k, q = (√κ − 1)/(√κ + 1). An element that nearly vanishes makes κ large, so the
    // number of steps is bounded.
    constexpr double share = 1e-10, least_eigenvalue = 1e-3;
    const double low = std::max(low_, least_eigenvalue * high_);
    const double root = std::sqrt(high_ / low), q = (root - 1) / (root + 1);
    const int steps = q > 1e-12 ? static_cast<int>(std::ceil(log(share / 2) / log(q))) : 1;
    const double middle = (high_ + low) / 2, half = std::max((high_ - low) / 2, 1e-12 * middle);
    const double sigma = middle / half;
    Buffer<double> d(size()), product_of_d(size());
    double rho = 1 / sigma;
    auto done = each(execution, size(), [&](std::size_t u) {
        x[u] = 0;
        d[u] = inverse_diagonal_[u] * r[u] / middle;
    });
    for (int step = 0; done && step < steps; ++step) {
        done = assemble([&](std::size_t slot) { return product(slot, d); }, product_of_d, execution);
        if (!done) break;
        const double next = 1 / (2 * sigma - rho);
        done = each(execution, size(), [&](std::size_t u) {
            x[u] += d[u];
            r[u] -= product_of_d[u];
            d[u] = next * rho * d[u] + 2 * next / half * inverse_diagonal_[u] * r[u];
        });
        rho = next;
    }
    return done;
}

template <int D>
Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const CommonParts& same) {
    Changed changed;
    changed.is_free.assign(node_count_of(new_mesh, 2), 0);
    for (std::size_t e = 0; e < same.old_element.size(); ++e) {
        if (same.old_element[e] != none) continue;
        changed.new_elements.push_back(static_cast<std::uint32_t>(e));
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) changed.is_free[n] = 1;
    }
    for (std::size_t e = 0; e < same.old_element.size(); ++e)
        if (same.old_element[e] != none)
            for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) changed.is_free[n] = 0;
    changed.old_slot.assign(old_mesh.linear.elements.size(), none);
    for (std::size_t e = 0; e < same.is_preserved.size(); ++e) {
        if (same.is_preserved[e] != 0) continue;
        changed.old_slot[e] = static_cast<std::uint32_t>(changed.old_elements.size());
        changed.old_elements.push_back(static_cast<std::uint32_t>(e));
    }
    return changed;
}

// The items of the disjoint sets are new slots, old slots, old nodes and new nodes, in this order.
template <int D>
PatchSearch<D>::PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const CommonParts& same,
                            const Changed& changed)
    : changed_(changed),
      sets_(changed.new_elements.size() + changed.old_elements.size() + node_count_of(old_mesh, 2) +
            node_count_of(new_mesh, 2)) {
    const std::size_t first_old = changed.new_elements.size();
    const std::size_t old_nodes = first_old + changed.old_elements.size();
    const std::size_t new_nodes = old_nodes + node_count_of(old_mesh, 2);
    for (std::size_t slot = 0; slot < changed.new_elements.size(); ++slot)
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, changed.new_elements[slot])) {
            if (n < new_mesh.linear.points.size() && changed.is_free[n] == 0) continue;
            const std::uint32_t old_node = same.old_node[n];
            sets_.join(slot, old_node == none ? new_nodes + n : old_nodes + old_node);
        }
    Buffer<std::uint8_t> is_preserved(node_count_of(old_mesh, 2), 0);
    for (std::size_t e = 0; e < same.is_preserved.size(); ++e)
        if (same.is_preserved[e] != 0)
            for (const std::size_t n : nodes_of<D, 2>(old_mesh, e)) is_preserved[n] = 1;
    for (std::size_t slot = 0; slot < changed.old_elements.size(); ++slot)
        for (const std::size_t n : nodes_of<D, 2>(old_mesh, changed.old_elements[slot]))
            if (n >= old_mesh.linear.points.size() || is_preserved[n] == 0) sets_.join(first_old + slot, old_nodes + n);
}

template <int D>
auto PatchSearch<D>::patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                             const Materials<D>& materials) -> Patches {
    Patches out;
    const std::size_t first_old = changed_.new_elements.size();
    // The lowest item of a patch is its first new element, or its first old one if it has no new element.
    std::vector<std::uint32_t> patch_of(first_old, none);
    std::vector<typename Patches::Group> of_new(first_old);
    for (std::size_t slot = 0; slot < first_old; ++slot) {
        const std::uint32_t lowest = sets_.lowest(static_cast<std::uint32_t>(slot));
        if (patch_of[lowest] == none) patch_of[lowest] = static_cast<std::uint32_t>(out.patches++);
        of_new[slot] = {patch_of[lowest],
                        static_cast<std::uint32_t>(materials.of(new_mesh.linear, changed_.new_elements[slot]))};
    }
    out.groups = of_new;
    std::ranges::sort(out.groups);
    const auto twice = std::ranges::unique(out.groups);
    out.groups.erase(twice.begin(), twice.end());
    const auto number = [&](const typename Patches::Group& group) {
        const auto at = std::ranges::lower_bound(out.groups, group);
        return at != out.groups.end() && *at == group ? static_cast<std::uint32_t>(at - out.groups.begin()) : no_group;
    };
    for (const auto& group : of_new) out.group_of_new.push_back(number(group));
    for (std::size_t slot = 0; slot < changed_.old_elements.size(); ++slot) {
        const std::uint32_t lowest = sets_.lowest(static_cast<std::uint32_t>(first_old + slot));
        const auto material = static_cast<std::uint32_t>(materials.of(old_mesh.linear, changed_.old_elements[slot]));
        out.group_of_old.push_back(lowest < first_old ? number({patch_of[lowest], material}) : no_group);
    }
    out.first_group.assign(out.patches + 1, 0);
    for (const auto& group : out.groups) ++out.first_group[group.patch + 1];
    for (std::size_t p = 0; p < out.patches; ++p) out.first_group[p + 1] += out.first_group[p];
    return out;
}

namespace {

template <int D, int K>
Outcome<Projection<D, K>> begin_projection(const ProjectionInput<D>& scene, std::span<const TransferField> fields,
                                           const Interpolated& interpolated, const Execution& execution) {
    Projection<D, K> projection{.block = block_of(K, fields, interpolated.values),
                                .reference = ReferenceMass<D, K>(scene.options.points),
                                .matrix = {},
                                .before = {},
                                .residual = {},
                                .low = {},
                                .high = {}};
    if (projection.block.components == 0) return projection;
    auto matrix = MassMatrix<D, K>::make(scene.new_mesh, scene.changed.new_elements, scene.changed.is_free,
                                         projection.reference, without_progress(execution));
    if (!matrix) return fail(matrix.error());
    projection.matrix = std::move(*matrix);
    return projection;
}

template <int D, int K>
Outcome<Done> finish_projection(const ProjectionInput<D>& scene, const typename PatchSearch<D>::Patches& patches,
                                Projection<D, K>& projection, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    Buffer<double> change(projection.matrix.size());
    for (std::size_t c = 0; c < projection.block.components; ++c) {
        if (auto solved = projection.matrix.solve(projection.residual_of(c), change, quiet); !solved) return solved;
        projection.add(c, change);
        report_progress(execution, c + 1, projection.block.components);
    }
    if (projection.block.components == 0) return Done{};
    auto before = integrals_before(scene, patches, projection, quiet);
    if (!before) return fail(before.error());
    projection.before = std::move(*before);
    if (auto preserved = conserve_integrals(scene, patches, projection, quiet); !preserved) return preserved;
    if (scene.options.bounds == TransferBounds::none) return Done{};
    return clip_to_limits(scene, patches, projection, quiet);
}

}  // namespace

template <int D>
Outcome<Interpolated> conserve(const ProjectionInput<D>& scene, std::span<const TransferField> fields,
                               Interpolated interpolated, const Execution& execution) {
    if (scene.changed.new_elements.empty()) return interpolated;
    auto linear = begin_projection<D, 1>(scene, fields, interpolated, execution);
    if (!linear) return fail(linear.error());
    auto quadratic = begin_projection<D, 2>(scene, fields, interpolated, execution);
    if (!quadratic) return fail(quadratic.error());
    PatchSearch<D> search(scene.old_mesh, scene.new_mesh, scene.same, scene.changed);
    auto done = integrate_residuals(scene, *linear, *quadratic, search, part_of(execution, 0, 0.7));
    if (!done) return fail(done.error());
    const auto patches = search.patches(scene.old_mesh, scene.new_mesh, scene.materials);
    done = finish_projection(scene, patches, *linear, part_of(execution, 0.7, 0.8));
    if (done) done = finish_projection(scene, patches, *quadratic, part_of(execution, 0.8, 1));
    if (!done) return fail(done.error());
    put_back(linear->block, fields, interpolated.values);
    put_back(quadratic->block, fields, interpolated.values);
    TransferStatistics& statistics = interpolated.statistics;
    statistics.projected = std::max(linear->matrix.size(), quadratic->matrix.size());
    statistics.turned = std::max(linear->matrix.turned(), quadratic->matrix.turned());
    statistics.patches = patches.patches;
    statistics.spread = std::max(linear->spread, quadratic->spread);
    statistics.unconserved_materials = std::max(linear->unconserved_materials, quadratic->unconserved_materials);
    return interpolated;
}

template class ReferenceMass<2, 1>;
template class ReferenceMass<2, 2>;
template class ReferenceMass<3, 1>;
template class ReferenceMass<3, 2>;
template class MassMatrix<2, 1>;
template class MassMatrix<2, 2>;
template class MassMatrix<3, 1>;
template class MassMatrix<3, 2>;

#define CAMBER_INSTANTIATE(D)                                                                               \
    template Changed find_changed<D>(const QuadraticMesh<D>&, const QuadraticMesh<D>&, const CommonParts&); \
    template class PatchSearch<D>;                                                                          \
    template Outcome<Interpolated> conserve<D>(const ProjectionInput<D>&, std::span<const TransferField>,   \
                                               Interpolated, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

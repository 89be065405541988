module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :key_table;
import :mass_matrix;
import :reference_mass;
import :simplex;
import camber.core;
import camber.bezier;

namespace camber {

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
        for (double& d : m.inverse_diagonal_) d = d > 0 ? 1 / d : 0;  // a node of vanishing elements alone stays
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
    struct Seen {
        double low = 0, high = 0;
        std::size_t turned = 0;
    };
    const auto seen = reduce_each(
        execution, elements.size(), Seen{reference.low, reference.high},
        [&](Seen& all, std::size_t slot) {
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
            // m M̂ ≤ M ≤ n M̂ with m ≤ det J ≤ n, and so their diagonals: rough, and enough where det J varies little.
            const double ratio = element.largest / element.least;
            std::array<double, 2> bounds{reference.low / ratio, reference.high * ratio};
            if (!(element.least > 0) || !(ratio < 1.5)) bounds = ReferenceMass<D, K>::eigenvalues(element.matrix);
            all.low = std::min(all.low, bounds[0]);
            all.high = std::max(all.high, bounds[1]);
        },
        [](Seen a, const Seen& b) {
            return Seen{std::min(a.low, b.low), std::max(a.high, b.high), a.turned + b.turned};
        });
    if (!seen) return fail(seen.error());
    low_ = seen->low;
    high_ = seen->high;
    turned_ = seen->turned;
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
    // Saad, Iterative Methods for Sparse Linear Systems, algorithm 12.1, with the eigenvalues in θ ± δ. The error falls
    // as 2 q^k, q = (√κ − 1)/(√κ + 1). An element that nearly vanishes somewhere makes κ large: then the work is
    // bounded.
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

template class MassMatrix<2, 1>;
template class MassMatrix<2, 2>;
template class MassMatrix<3, 1>;
template class MassMatrix<3, 2>;

}  // namespace camber

// Rings of nodes, and polynomials fitted to them.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recovery;
import camber.core;

namespace camber {

Outcome<Done> check_materials(std::size_t references, std::size_t elements) {
    if (references == elements) return Done{};
    return fail(ErrorKind::input,
                "there are " + std::to_string(references) + " references for " + std::to_string(elements) + " elements",
                {}, {}, "give each element the reference of its material");
}

namespace {

template <int D>
void find_materials(const LinearMesh<D>& mesh, std::span<const ElementId> ball, std::vector<Reference>& materials) {
    materials.clear();
    for (const ElementId e : ball) {
        const Reference material = mesh.elements.references[e];
        // Usually there is only one material, so duplicates are removed before sorting.
        if (std::find(materials.begin(), materials.end(), material) == materials.end()) materials.push_back(material);
    }
    std::sort(materials.begin(), materials.end());
}

template <int D>
Outcome<MaterialRows> rows_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                              const Execution& execution) {
    if (auto one_each = check_materials(mesh.elements.references.size(), mesh.elements.size()); !one_each)
        return fail(one_each.error());
    const std::size_t n = balls.size();
    Buffer<std::uint32_t> offsets(n + 1);
    offsets[0] = 0;
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<Reference>> chunks((n + grain - 1) / grain);
    auto found = each_chunk(
        without_progress(execution), n,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Reference> materials;
            auto& all = chunks[begin / grain];
            for (std::size_t v = begin; v < end; ++v) {
                find_materials(mesh, balls[v], materials);
                offsets[v + 1] = static_cast<std::uint32_t>(materials.size());
                all.insert(all.end(), materials.begin(), materials.end());
            }
        },
        grain);
    if (!found) return fail(found.error());
    std::size_t total = 0;
    for (const auto& chunk : chunks) total += chunk.size();
    if (total > max_entities)
        return fail(ErrorKind::unsupported, "a mesh of " + std::to_string(total) + " sides of vertices is too large");
    for (std::size_t v = 0; v < n; ++v) offsets[v + 1] += offsets[v];
    Buffer<Reference> materials;
    materials.reserve(total);
    for (const auto& chunk : chunks) materials.insert(materials.end(), chunk.begin(), chunk.end());
    return MaterialRows{{std::move(offsets), std::move(materials)}};
}

template <int D>
Outcome<Buffer<std::uint8_t>> find_boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                 const MaterialRows& rows, const Execution& execution) {
    const auto across = neighbours(mesh, balls, execution);
    if (!across) return fail(across.error());
    const auto& materials = mesh.elements.references;
    Buffer<std::uint8_t> marks(rows.size(), 0);
    auto marked = each(execution, balls.size(), [&](std::size_t i) {
        const VertexId v(i);
        for (const ElementId e : balls[v])
            for (int f = 0; f <= D; ++f) {
                const ElementId other = (*across)[e][f];
                if (mesh.elements.vertices[e][f] != v && (!other.valid() || materials[other] != materials[e]))
                    marks[*rows.row(v, materials[e])] = 1;
            }
    });
    if (!marked) return fail(marked.error());
    return marks;
}

}  // namespace

template <int D>
Outcome<MaterialRows> material_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                    const Execution& execution) {
    return guarded([&] { return rows_of(mesh, balls, execution); });
}

template <int D>
Outcome<Buffer<std::uint8_t>> boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                            const MaterialRows& rows, const Execution& execution) {
    return guarded([&] { return find_boundary_rows(mesh, balls, rows, execution); });
}

template <int D>
void Rings<D>::begin(std::span<const VertexId> vertices, Reference material) {
    material_ = material;
    count_ = 0;
    visited_nodes_.clear();
    visited_elements_.clear();
    nodes_.clear();
    last_.assign(vertices.begin(), vertices.end());
    for (const VertexId v : vertices) {
        visited_nodes_.insert(Id<NodeTag>(v.index()));
        nodes_.push_back(v.value);
    }
}

template <int D>
void Rings<D>::begin(VertexId v, Reference material) {
    begin({&v, 1}, material);
}

template <int D>
void Rings<D>::begin(ElementId e) {
    const auto& elements = nodal_.mesh.linear.elements;
    begin(elements.vertices[e], elements.references[e]);
}

template <int D>
bool Rings<D>::grow() {
    const LinearMesh<D>& mesh = nodal_.mesh.linear;
    const std::size_t before = nodes_.size();
    next_.clear();
    for (const VertexId v : last_)
        for (const ElementId e : nodal_.balls[v]) {
            if (mesh.elements.references[e] != material_ || !visited_elements_.insert(e)) continue;
            for (const VertexId w : mesh.elements.vertices[e])
                if (visited_nodes_.insert(Id<NodeTag>(w.index()))) {
                    nodes_.push_back(w.value);
                    next_.push_back(w);
                }
            if (nodal_.degree < 2) continue;
            for (const EdgeId edge : nodal_.mesh.edges.of_elements[e]) {
                const Id<NodeTag> node(mesh.points.size() + edge.index());
                if (visited_nodes_.insert(node)) nodes_.push_back(node.value);
            }
        }
    last_.swap(next_);
    ++count_;
    return nodes_.size() > before;
}

namespace {

using LanesOfPack = std::array<double, pack_size>;

double sum_of(const LanesOfPack& lanes) {
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

template <int D, int P>
[[gnu::always_inline]] inline void set_monomials(const std::array<Pack, D>& y, Pack first,
                                                 std::array<Pack, monomials_up_to<D>(P)>& m) {
    m[0] = first;
    for (std::size_t i = 1; i < m.size(); ++i) m[i] = m[monomials<D, P>[i].parent] * y[monomials<D, P>[i].axis];
}

template <int D, class Block>
[[gnu::always_inline]] inline std::array<Pack, D> places_of(const Block& block) {
    std::array<Pack, D> y{};
    for (int i = 0; i < D; ++i) y[i] = std::bit_cast<Pack>(block.y[i]);
    return y;
}

}  // namespace

template <int D, int P>
void Fit<D, P>::place(std::span<const Vec<D>> offsets, double noise, double core) {
    nodes_ = offsets.size();
    whitened_by_ = whitening(offsets, noise);
    blocks_.assign((nodes_ + pack_size - 1) / pack_size, Block{});
    for (std::size_t i = 0; i < nodes_; ++i) {
        Block& block = blocks_[i / pack_size];
        const Vec<D> y = whitened_by_ * offsets[i];
        const double weight = 1 / (core + norm(y));
        for (int d = 0; d < D; ++d) block.y[d][i % pack_size] = y[d];
        block.squared_weight[i % pack_size] = weight * weight;
    }
    sum_moments();
    factorise();
}

template <int D, int P>
void Fit<D, P>::sum_moments() {
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        constexpr std::size_t count = monomials_up_to<D>(2 * P);
        std::array<Pack, count> m{}, sums{};
        for (const Block& block : blocks_) {
            set_monomials<D, 2 * P>(places_of<D>(block), std::bit_cast<Pack>(block.squared_weight), m);
            for (std::size_t i = 0; i < count; ++i) sums[i] += m[i];
        }
        for (std::size_t i = 0; i < count; ++i) moments_[i] = sum_of(std::bit_cast<LanesOfPack>(sums[i]));
    });
}

/// Factorises G = S M S = Uᵀ U, where M is the moment matrix and the diagonal matrix S makes G_ii = 1. U_ii² is the
/// part of the i-th monomial that is independent of the earlier ones. Works row by row, so that items of the innermost
/// loop are independent.
template <int D, int P>
void Fit<D, P>::factorise() {
    independence_.fill(1);
    for (std::size_t i = 0; i < size; ++i) {
        const double length = moments_[products<D, P>[i][i]];
        scale_[i] = length > negligible_length ? 1 / std::sqrt(length) : 0;
    }
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        for (std::size_t i = 0; i < size; ++i) {
            std::array<double, size>& row = factor_[i];
            for (std::size_t j = i; j < size; ++j) row[j] = moments_[products<D, P>[i][j]] * scale_[i] * scale_[j];
            for (std::size_t k = 0; k < i; ++k) {
                const std::array<double, size>& above = factor_[k];
                const double share = above[i];
                for (std::size_t j = i; j < size; ++j) row[j] -= share * above[j];
            }
            const double left = std::max(row[i], 0.0);
            for (std::size_t d = static_cast<std::size_t>(monomials<D, P>[i].degree); d <= P; ++d)
                independence_[d] = std::min(independence_[d], left);
            const double inverse_root = left > negligible_length ? 1 / std::sqrt(left) : 0;
            for (std::size_t j = i + 1; j < size; ++j) row[j] *= inverse_root;
            row[i] = inverse_root;
        }
    });
}

/// Adds a correction δ to the coefficients c, with Σ w² y^α (y^β δ_β − (u − p_c)) = 0 for all exponents α. p_c:
/// polynomial with coefficients c. The sum is over β and the nodes (position y, value u, weight w).
template <int D, int P>
void Fit<D, P>::correct(Coefficients<D, P>& c, std::size_t unknowns) const {
    std::array<double, size> x{};
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        std::array<Pack, size> m{}, sums{};
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            set_monomials<D, P>(places_of<D>(blocks_[b]), packed(1), m);
            Pack value = packed(0);
            for (std::size_t i = 0; i < size; ++i) value += c[i] * m[i];
            const Pack left =
                (std::bit_cast<Pack>(values_[b]) - value) * std::bit_cast<Pack>(blocks_[b].squared_weight);
            for (std::size_t i = 0; i < size; ++i) sums[i] += left * m[i];
        }
        for (std::size_t i = 0; i < size; ++i) x[i] = scale_[i] * sum_of(std::bit_cast<LanesOfPack>(sums[i]));
    });
    for (std::size_t i = 0; i < unknowns; ++i) {
        x[i] *= factor_[i][i];
        for (std::size_t k = i + 1; k < unknowns; ++k) x[k] -= factor_[i][k] * x[i];
    }
    for (std::size_t i = unknowns; i-- > 0;) {
        for (std::size_t k = i + 1; k < unknowns; ++k) x[i] -= factor_[i][k] * x[k];
        x[i] *= factor_[i][i];
        c[i] += scale_[i] * x[i];
    }
}

template <int D, int P>
Coefficients<D, P> Fit<D, P>::solve(std::span<const double> values, int degree) {
    values_.assign(blocks_.size(), Lanes{});
    for (std::size_t i = 0; i < nodes_; ++i) values_[i / pack_size][i % pack_size] = values[i];
    const std::size_t unknowns = monomials_up_to<D>(degree);
    Coefficients<D, P> c{};
    correct(c, unknowns);
    correct(c, unknowns);
    return c;
}

template class Rings<2>;
template class Rings<3>;
template class Fit<2, 3>;
template class Fit<2, 4>;
template class Fit<2, 5>;
template class Fit<3, 3>;
template class Fit<3, 4>;
template class Fit<3, 5>;

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<MaterialRows> material_rows<D>(const LinearMesh<D>&, const Incidence<ElementId>&,         \
                                                    const Execution&);                                         \
    template Outcome<Buffer<std::uint8_t>> boundary_rows<D>(const LinearMesh<D>&, const Incidence<ElementId>&, \
                                                            const MaterialRows&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

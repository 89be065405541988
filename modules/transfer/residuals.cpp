module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
module camber.transfer;
import :interpolate;
import :key_table;
import :nearby;
import :patches;
import :projection;
import :reference_mass;
import :simplex;
import :sources;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Elements whose parts of the residuals are held at a time.
constexpr std::size_t block_size = 16384;

/// The part of one degree, for a block of elements.
template <int D, int K>
class Parts {
  public:
    static constexpr std::size_t nodes = field_nodes<D, K>;

    Parts(const TransferScene<D>& scene, Projection<D, K>& projection)
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

    /// What a thread has of an element.
    struct Scratch {
        std::vector<double> values;  ///< u at the nodes, component after component
    };
    void begin(std::size_t i, std::size_t e, Scratch& scratch) {
        std::ranges::fill(row(i), 0.0);
        scratch.values.clear();
        const auto all = nodes_of<D, K>(scene_.new_mesh, e);
        for (std::size_t c = 0; c < components_; ++c)
            for (const std::size_t n : all) scratch.values.push_back(projection_.block.values[n * components_ + c]);
    }

    /// Adds weight φ (u_old − u) at point q of the rule, where the old mesh has `place`.
    void add(std::size_t i, std::size_t q, double weight, const OldPlace<D>& place, Scratch& scratch) {
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
    /// The limits that the old elements of new element number i of the block have.
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
    /// Adds element number i of the block to the unknowns.
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

    const TransferScene<D>& scene_;
    Projection<D, K>& projection_;
    std::size_t components_;
    bool has_limits_;
    Buffer<double> residuals_, limits_;
};

}  // namespace

template <int D>
Outcome<Done> integrate_residuals(const TransferScene<D>& scene, Projection<D, 1>& linear, Projection<D, 2>& quadratic,
                                  PatchSearch<D>& patches, const Execution& execution) {
    Parts<D, 1> linear_parts(scene, linear);
    Parts<D, 2> quadratic_parts(scene, quadratic);
    std::vector<std::vector<std::uint32_t>> seen(block_size);
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
            const OldPlace<D> place = nearby.find(map.at(rule[q].xi));
            const double weight = rule[q].weight * std::abs(map.determinant(rule[q].xi));
            linear_parts.add(i, q, weight, place, scratch.linear);
            quadratic_parts.add(i, q, weight, place, scratch.quadratic);
        }
        linear_parts.limit(i, nearby.seen());
        quadratic_parts.limit(i, nearby.seen());
        seen[i].assign(nearby.seen().begin(), nearby.seen().end());
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
            for (const std::uint32_t o : seen[i]) patches.found(begin + i, o);
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<Done> integrate_residuals<D>(const TransferScene<D>&, Projection<D, 1>&, Projection<D, 2>&, \
                                                  PatchSearch<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

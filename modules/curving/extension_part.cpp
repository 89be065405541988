module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :edge_energy;
import :extension_part;
import :extension_system;
import :parts;

namespace camber {

template <int D>
struct ExtensionPart<D>::Impl : ExtensionSystem<D> {};

template <int D>
ExtensionPart<D>::ExtensionPart(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
template <int D>
ExtensionPart<D>::ExtensionPart(ExtensionPart&&) noexcept = default;
template <int D>
ExtensionPart<D>& ExtensionPart<D>::operator=(ExtensionPart&&) noexcept = default;
template <int D>
ExtensionPart<D>::~ExtensionPart() = default;

template <int D>
Outcome<ExtensionPart<D>> ExtensionPart<D>::make(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                 std::span<const LagrangeNode<D>> boundary_nodes,
                                                 const Incidence<ElementId>& shells, const OwnVertices& own,
                                                 const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (kinds.size() != n || boundary_nodes.size() != n || shells.size() != n)
        return fail(ErrorKind::internal, "an extension needs a kind, a node and a shell for each edge");
    auto given = map_each(execution, n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? Vec<D>{} : boundary_nodes[e].point - chord_middle(mesh, e);
    });
    if (!given) return fail(given.error());
    return guarded([&]() -> Outcome<ExtensionPart<D>> {
        return ExtensionPart(std::make_unique<Impl>(Impl{ExtensionSystem<D>{
            mesh, kinds, shells, own, boundary_nodes, std::move(*given), Weighting{}, Buffer<std::uint32_t>(n, 0U),
            Buffer<ElementEnergy<D>>(mesh.linear.elements.size()), Rows<D>(n, mesh.linear.elements.size())}}));
    });
}

template <int D>
bool ExtensionPart<D>::is_displaced() const {
    return std::ranges::any_of(impl_->direction, [](const Vec<D>& v) { return v != Vec<D>{}; });
}

template <int D>
Outcome<std::vector<double>> ExtensionPart<D>::volume_and_count(const Execution& execution) const {
    struct Sum {
        double volume = 0;
        std::size_t count = 0;
    };
    const LinearMesh<D>& mesh = impl_->mesh.linear;
    const auto sums = reduce_own(
        execution, mesh, impl_->owned, Sum{},
        [&](Sum& total, ElementId e) {
            total.volume += std::abs(det(edge_vectors(mesh, e)));
            ++total.count;
        },
        [](const Sum& a, const Sum& b) { return Sum{a.volume + b.volume, a.count + b.count}; });
    if (!sums) return fail(sums.error());
    std::vector<double> numbers;
    for (const Sum& s : *sums) numbers.insert(numbers.end(), {s.volume, static_cast<double>(s.count)});
    return numbers;
}

template <int D>
Outcome<Done> ExtensionPart<D>::begin(double mean, double stiffening, const Execution& execution) {
    ExtensionSystem<D>& x = *impl_;
    x.weighting = {mean, stiffening};
    std::vector<EdgeId> moved;
    for (std::size_t e = 0; e < x.direction.size(); ++e)
        if (x.kinds[e] != EdgeKind::volume && x.direction[e] != Vec<D>{}) moved.emplace_back(e);
    if (auto begun = x.begin_rows_around(moved, execution); !begun) return begun;
    auto done = each(
        execution, x.blocks.size(),
        [&](std::size_t b) {
            x.each_product(x.blocks[b], x.direction,
                           [&](std::size_t i, const Vec<D>& sum) { x.rows.residual[i] -= sum; });
        },
        blocks_at_once);
    if (!done) return done;
    for (const EdgeId edge : moved) x.direction[edge.index()] = {};
    return Done{};
}

template <int D>
Outcome<std::vector<ExtensionSums>> ExtensionPart<D>::step(double length, double tolerance,
                                                           const Execution& execution) {
    ExtensionSystem<D>& x = *impl_;
    return x.template reduce_runs<ExtensionSums>(execution, [&](ExtensionSums& sums, RowBlock& block) {
        Rows<D>& rows = x.rows;
        block.joined.clear();
        for (std::size_t i = block.begin; i < block.end; ++i) {
            if (rows.state[i] == Row::moving) rows.u[i] += length * x.direction[rows.edges[i].index()];
            if (length != 0) rows.residual[i] -= length * rows.product[i];
            const double size = rows.size(i);
            sums.largest = std::max(sums.largest, size);
            if (rows.state[i] == Row::beside) {
                if (!(size > joining * tolerance)) continue;
                rows.state[i] = Row::joined;
                block.joined.push_back(rows.edges[i]);
                sums.joined += 1;
            }
            if (length != 0) sums.by_product += dot(rows.correction(i), rows.product[i]);
            sums.by_residual += dot(rows.correction(i), rows.residual[i]);
        }
    });
}

template <int D>
Outcome<Done> ExtensionPart<D>::turn_by(double turn, const Execution& execution) {
    ExtensionSystem<D>& x = *impl_;
    x.joined.clear();
    for (const RowBlock& block : x.blocks) x.joined.insert(x.joined.end(), block.joined.begin(), block.joined.end());
    return each(
        execution, x.blocks.size(),
        [&](std::size_t b) {
            const RowBlock& block = x.blocks[b];
            Rows<D>& rows = x.rows;
            for (std::size_t i = block.begin; i < block.end; ++i) {
                if (rows.state[i] == Row::joined) rows.state[i] = Row::moving;
                if (rows.state[i] != Row::moving) continue;
                Vec<D>& direction = x.direction[rows.edges[i].index()];
                direction = rows.correction(i) + turn * direction;
            }
        },
        blocks_at_once);
}

template <int D>
Outcome<Done> ExtensionPart<D>::join(std::span<const EdgeId> of_others, const Execution& execution) {
    std::vector<EdgeId>& joined = impl_->joined;
    joined.insert(joined.end(), of_others.begin(), of_others.end());
    return joined.empty() ? Done{} : impl_->begin_rows_around(joined, execution);
}

template <int D>
Outcome<std::vector<AlongDirection>> ExtensionPart<D>::multiply(const Execution& execution) {
    ExtensionSystem<D>& x = *impl_;
    return x.template reduce_runs<AlongDirection>(execution, [&](AlongDirection& along, const RowBlock& block) {
        Rows<D>& rows = x.rows;
        x.each_product(block, x.direction, [&](std::size_t i, const Vec<D>& sum) {
            const Vec<D>& direction = x.direction[rows.edges[i].index()];
            rows.product[i] = sum;
            along.curvature += dot(direction, sum);
            along.slope += dot(direction, rows.residual[i]);
        });
    });
}

template <int D>
std::span<Vec<D>> ExtensionPart<D>::directions() {
    return impl_->direction;
}

template <int D>
const std::vector<EdgeId>& ExtensionPart<D>::joined_last() const {
    return impl_->joined;
}

template <int D>
std::size_t ExtensionPart<D>::moving() const {
    const Rows<D>& rows = impl_->rows;
    return static_cast<std::size_t>(
        std::count(rows.state.begin(), rows.state.begin() + static_cast<std::ptrdiff_t>(rows.count), Row::moving));
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> ExtensionPart<D>::nodes(const Execution& execution) && {
    const ExtensionSystem<D>& x = *impl_;
    auto nodes = map_each(execution, x.kinds.size(), [&](std::size_t e) {
        return x.kinds[e] == EdgeKind::volume ? LagrangeNode<D>{chord_middle(x.mesh, e)} : x.boundary_nodes[e];
    });
    if (!nodes) return nodes;
    for (std::size_t i = 0; i < x.rows.count; ++i) (*nodes)[x.rows.edges[i].index()].point += x.rows.u[i];
    impl_.reset();
    return nodes;
}

template class ExtensionPart<2>;
template class ExtensionPart<3>;

}  // namespace camber

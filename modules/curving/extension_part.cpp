module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
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
import :parts;

namespace camber {

namespace {

/// Rows take part once their correction is this share of the tolerance.
constexpr double joining = 0.1;

/// `beside`: its residual is kept, but it has not been moved. `joined`: it moves from the next step on.
enum class Row : std::uint8_t { beside, joined, moving };

template <int D>
Vec<D> chord_middle(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
}

/// Rows that a loop takes at once, with their entries of the matrix.
struct RowBlock {
    std::size_t begin = 0, end = 0;
    const EdgeId* columns = nullptr;
    const double* values = nullptr;
    std::vector<EdgeId> own_columns = {};  ///< where there are more than expected
    std::vector<double> own_values = {};
    std::vector<EdgeId> joined = {};  ///< in the last step
};
constexpr std::size_t block_rows = 256;
constexpr std::size_t blocks_at_once = 4;

/// Entries of the rows of a block, as they are assembled: of a row first its own, then those of edges that meet it,
/// which two elements have, then those opposite, each of one element.
struct Entries {
    std::vector<EdgeId> columns = {};
    std::vector<double> values = {};
    std::vector<std::pair<EdgeId, double>> opposite = {};

    void add_beside(std::size_t begin, EdgeId column, double value) {
        std::size_t k = begin;
        while (k < columns.size() && columns[k] != column) ++k;
        if (k == columns.size()) columns.push_back(column), values.push_back(0);
        values[k] += value;
    }
    void end_row() {
        for (const auto& [column, value] : opposite) columns.push_back(column), values.push_back(value);
        opposite.clear();
    }
};

/// The rows of the matrix, an edge each, and their parts of the vectors. There is room for all edges; what is not used
/// is never touched, and so no memory.
template <int D>
struct Rows {
    std::size_t count = 0;
    std::size_t entries = 0;
    Buffer<EdgeId> edges;
    Buffer<Row> state;
    Buffer<double> inverse_diagonal, height;
    Buffer<Vec<D>> u, residual, product;
    Buffer<std::uint32_t> ends;  ///< of each row's entries in its block
    Buffer<EdgeId> columns;
    Buffer<double> values;

    Rows(std::size_t n, std::size_t elements)
        : edges(n),
          state(n),
          inverse_diagonal(n),
          height(n),
          u(n),
          residual(n),
          product(n),
          ends(n),
          columns(n + 3 * edges_per_simplex<D> * elements),
          values(columns.size()) {}

    [[nodiscard]] Vec<D> correction(std::size_t i) const { return inverse_diagonal[i] * residual[i]; }
    /// Of the correction, as a share of the height.
    [[nodiscard]] double size(std::size_t i) const { return norm(correction(i)) / height[i]; }
};

/// The system of equations, as far as the displacement has been felt: edges beyond have no row, and do not move.
template <int D>
struct System {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<const LagrangeNode<D>> boundary_nodes;  ///< by edge; those of the volume do not count
    Buffer<Vec<D>> direction;                         ///< by edge; at first what is given
    Weighting weighting = {};
    Buffer<std::uint32_t> began;        ///< by edge: in which round its row began, from 1; 0: it has none
    Buffer<ElementEnergy<D>> energies;  ///< of the elements with a row; the others are never written
    Rows<D> rows;
    std::vector<RowBlock> blocks = {};
    std::uint32_t round = 0;
    std::vector<EdgeId> joined = {};  ///< in the last step

    /// Whether the edge's row is this part's.
    [[nodiscard]] bool owns(EdgeId edge) const { return owned.owns(mesh.edges.vertices[edge]); }

    /// The part's volume edges of elements around these that had no row yet, rising.
    Outcome<std::vector<EdgeId>> reach_out(std::span<const EdgeId> from, const Execution& execution) {
        constexpr std::size_t grain = 1024;
        std::vector<std::vector<EdgeId>> seen((from.size() + grain - 1) / grain);
        auto looked = each_chunk(
            execution, from.size(),
            [&](std::size_t begin, std::size_t end) {
                for (const EdgeId edge : from.subspan(begin, end - begin))
                    for (const ElementId e : shells[edge])
                        for (const EdgeId other : mesh.edges.of_elements[e])
                            if (began[other.index()] == 0 && kinds[other] == EdgeKind::volume && owns(other))
                                seen[begin / grain].push_back(other);
            },
            grain);
        if (!looked) return fail(looked.error());
        ++round;
        std::vector<EdgeId> reached;
        for (const auto& some : seen)
            for (const EdgeId edge : some)
                if (began[edge.index()] == 0) began[edge.index()] = round, reached.push_back(edge);
        std::sort(reached.begin(), reached.end());
        return reached;
    }

    /// Whether of all rows around the element, this edge's is the first: so each element is computed once.
    [[nodiscard]] bool is_first_of(EdgeId edge, ElementId e) const {
        const auto& edges = mesh.edges.of_elements[e];
        return std::all_of(edges.begin(), edges.end(), [&](EdgeId other) {
            const std::uint32_t in = began[other.index()];
            return in == 0 || (in == round && edge <= other);
        });
    }

    void begin_row(std::size_t i, EdgeId edge, Entries& entries) {
        const std::size_t begin = entries.columns.size();
        double height = std::numeric_limits<double>::infinity();
        entries.columns.push_back(edge);
        entries.values.push_back(0);
        for (const ElementId e : shells[edge]) {
            const auto& edges = mesh.edges.of_elements[e];
            const ElementEnergy<D>& energy = energies[e.index()];
            const int own = local_edge<D>(edges, edge);
            each_row_entry<D>(energy.gradients, own, [&](int k, double value) {
                if (k == own)
                    entries.values[begin] += value;
                else if (D == 3 && k == edges_beside<D>[own].opposite)
                    entries.opposite.emplace_back(edges[k], value);
                else
                    entries.add_beside(begin + 1, edges[k], value);
            });
            height = std::min(height, energy.height);
        }
        entries.end_row();
        const double diagonal = entries.values[begin];
        rows.edges[i] = edge;
        rows.state[i] = Row::beside;
        rows.inverse_diagonal[i] = diagonal > 0 ? 1 / diagonal : 0;
        rows.height[i] = height;
        rows.u[i] = rows.residual[i] = {};
        rows.ends[i] = static_cast<std::uint32_t>(entries.columns.size());
    }

    /// The rows of a block, with room for so many entries from `room` on.
    void begin_block(RowBlock& block, std::span<const EdgeId> edges, std::size_t room, std::size_t expected) {
        Entries entries;
        entries.columns.reserve(expected);
        entries.values.reserve(expected);
        for (std::size_t k = 0; k < edges.size(); ++k) begin_row(block.begin + k, edges[k], entries);
        if (entries.columns.size() > expected) {
            block.own_columns = std::move(entries.columns);
            block.own_values = std::move(entries.values);
            block.columns = block.own_columns.data();
            block.values = block.own_values.data();
            return;
        }
        std::copy(entries.columns.begin(), entries.columns.end(), rows.columns.data() + room);
        std::copy(entries.values.begin(), entries.values.end(), rows.values.data() + room);
        block.columns = rows.columns.data() + room;
        block.values = rows.values.data() + room;
    }

    /// All around these edges gets a row.
    Outcome<Done> begin_rows_around(std::span<const EdgeId> from, const Execution& execution) {
        const auto reached = reach_out(from, execution);
        if (!reached) return fail(reached.error());
        const std::span<const EdgeId> edges(*reached);
        auto computed = each(execution, edges.size(), [&](std::size_t i) {
            for (const ElementId e : shells[edges[i]])
                if (is_first_of(edges[i], e)) energies[e.index()] = element_energy<D>(mesh.linear, e, weighting);
        });
        if (!computed) return fail(computed.error());
        const std::size_t first = blocks.size();
        std::vector<std::size_t> room;
        for (std::size_t begin = 0; begin < edges.size(); begin += block_rows) {
            const std::size_t end = std::min(begin + block_rows, edges.size());
            room.push_back(rows.entries);
            for (std::size_t i = begin; i < end; ++i) rows.entries += 1 + 3 * shells[edges[i]].size();  // if closed
            blocks.push_back({rows.count + begin, rows.count + end});
        }
        room.push_back(rows.entries);
        rows.count += edges.size();
        return each(
            execution, blocks.size() - first,
            [&](std::size_t b) {
                const auto of_block = edges.subspan(b * block_rows, blocks[first + b].end - blocks[first + b].begin);
                begin_block(blocks[first + b], of_block, room[b], room[b + 1] - room[b]);
            },
            1);
    }

    /// visit(row, A x) for each row of a block, x by edge.
    template <class Visit>
    void each_product(const RowBlock& block, std::span<const Vec<D>> x, const Visit& visit) const {
        std::size_t k = 0;
        for (std::size_t i = block.begin; i < block.end; ++i) {
            Vec<D> sum;
            for (const std::size_t end = rows.ends[i]; k < end; ++k)
                sum += block.values[k] * x[block.columns[k].index()];
            visit(i, sum);
        }
    }
};

}  // namespace

template <int D>
struct ExtensionPart<D>::Impl : System<D> {};

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
        return ExtensionPart(std::make_unique<Impl>(Impl{System<D>{
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
    const auto sum = reduce_each(
        execution, mesh.elements.size(), Sum{},
        [&](Sum& total, std::size_t e) {
            if (!impl_->owned.owns(mesh.elements.vertices[e])) return;
            total.volume += std::abs(det(edge_vectors(mesh, ElementId(e))));
            ++total.count;
        },
        [](const Sum& a, const Sum& b) { return Sum{a.volume + b.volume, a.count + b.count}; });
    if (!sum) return fail(sum.error());
    return std::vector{sum->volume, static_cast<double>(sum->count)};
}

template <int D>
Outcome<Done> ExtensionPart<D>::begin(double mean, double stiffening, const Execution& execution) {
    System<D>& x = *impl_;
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
Outcome<ExtensionSums> ExtensionPart<D>::step(double length, double tolerance, const Execution& execution) {
    System<D>& x = *impl_;
    const auto take = [&](ExtensionSums& sums, std::size_t b) {
        RowBlock& block = x.blocks[b];
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
    };
    return reduce_each(
        execution, x.blocks.size(), ExtensionSums{}, take,
        [](const ExtensionSums& a, const ExtensionSums& b) { return a + b; }, blocks_at_once);
}

template <int D>
Outcome<Done> ExtensionPart<D>::turn_by(double turn, const Execution& execution) {
    System<D>& x = *impl_;
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
Outcome<AlongDirection> ExtensionPart<D>::multiply(const Execution& execution) {
    System<D>& x = *impl_;
    return reduce_each(
        execution, x.blocks.size(), AlongDirection{},
        [&](AlongDirection& along, std::size_t b) {
            Rows<D>& rows = x.rows;
            x.each_product(x.blocks[b], x.direction, [&](std::size_t i, const Vec<D>& sum) {
                const Vec<D>& direction = x.direction[rows.edges[i].index()];
                rows.product[i] = sum;
                along.curvature += dot(direction, sum);
                along.slope += dot(direction, rows.residual[i]);
            });
        },
        [](const AlongDirection& a, const AlongDirection& b) { return a + b; }, blocks_at_once);
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
    const System<D>& x = *impl_;
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

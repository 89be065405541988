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
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :edge_energy;

namespace camber {

namespace {

/// Rows take part once their correction is this share of the tolerance.
constexpr double joining = 0.1;
/// Corrections of this share of the first are rounding.
constexpr double rounding = 1e-14;

/// `beside`: its residual is kept, but it has not been moved. `joined`: it moves from the next step on.
enum class Row : std::uint8_t { beside, joined, moving };

/// Rows that a loop takes at once, with their entries of the matrix.
struct Block {
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
    const Execution& execution;
    Weighting weighting;
    Buffer<Vec<D>> direction;           ///< by edge; at first what is given
    Buffer<std::uint32_t> began;        ///< by edge: in which round its row began, from 1; 0: it has none
    Buffer<ElementEnergy<D>> energies;  ///< of the elements with a row; the others are never written
    Rows<D> rows;
    std::vector<Block> blocks = {};
    std::uint32_t round = 0;

    /// The volume edges of elements around these that had no row yet, rising.
    Outcome<std::vector<EdgeId>> reach_out(std::span<const EdgeId> from) {
        constexpr std::size_t grain = 1024;
        std::vector<std::vector<EdgeId>> seen((from.size() + grain - 1) / grain);
        auto looked = each_chunk(
            execution, from.size(),
            [&](std::size_t begin, std::size_t end) {
                for (const EdgeId edge : from.subspan(begin, end - begin))
                    for (const ElementId e : shells[edge])
                        for (const EdgeId other : mesh.edges.of_elements[e])
                            if (began[other.index()] == 0 && kinds[other] == EdgeKind::volume)
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
    void begin_block(Block& block, std::span<const EdgeId> edges, std::size_t room, std::size_t expected) {
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
    Outcome<Done> begin_rows_around(std::span<const EdgeId> from) {
        const auto reached = reach_out(from);
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
    void each_product(const Block& block, std::span<const Vec<D>> x, const Visit& visit) const {
        std::size_t k = 0;
        for (std::size_t i = block.begin; i < block.end; ++i) {
            Vec<D> sum;
            for (const std::size_t end = rows.ends[i]; k < end; ++k)
                sum += block.values[k] * x[block.columns[k].index()];
            visit(i, sum);
        }
    }
};

/// Before the first step: what is given is moved, and all beside it has a row.
template <int D>
Outcome<System<D>> system_of(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Buffer<Vec<D>> given,
                             const Incidence<ElementId>& shells, double stiffening, const Execution& execution) {
    const auto weighting = weighting_of(mesh.linear, stiffening, execution);
    if (!weighting) return fail(weighting.error());
    const std::size_t n = mesh.edges.size();
    System<D> x{mesh,
                kinds,
                shells,
                execution,
                *weighting,
                std::move(given),
                Buffer<std::uint32_t>(n, 0U),
                Buffer<ElementEnergy<D>>(mesh.linear.elements.size()),
                Rows<D>(n, mesh.linear.elements.size())};
    std::vector<EdgeId> moved;
    for (std::size_t e = 0; e < n; ++e)
        if (kinds[e] != EdgeKind::volume && x.direction[e] != Vec<D>{}) moved.emplace_back(e);
    if (auto begun = x.begin_rows_around(moved); !begun) return fail(begun.error());
    auto done = each(
        execution, x.blocks.size(),
        [&](std::size_t b) {
            x.each_product(x.blocks[b], x.direction,
                           [&](std::size_t i, const Vec<D>& sum) { x.rows.residual[i] -= sum; });
        },
        blocks_at_once);
    if (!done) return fail(std::move(done.error()));
    for (const EdgeId edge : moved) x.direction[edge.index()] = {};
    return x;
}

/// What the rows say after a step.
struct Sums {
    double by_product = 0;  ///< correction · product
    double by_residual = 0;
    double largest = 0;  ///< correction, as a share of the height
    std::size_t joined = 0;
};
[[nodiscard]] Sums operator+(const Sums& a, const Sums& b) {
    return {a.by_product + b.by_product, a.by_residual + b.by_residual, std::max(a.largest, b.largest),
            a.joined + b.joined};
}

/// Moves along the direction, and looks at what is left.
template <int D>
Outcome<Sums> step(System<D>& x, double length, double tolerance) {
    const auto take = [&](Sums& sums, std::size_t b) {
        Block& block = x.blocks[b];
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
                ++sums.joined;
            }
            if (length != 0) sums.by_product += dot(rows.correction(i), rows.product[i]);
            sums.by_residual += dot(rows.correction(i), rows.residual[i]);
        }
    };
    return reduce_each(
        x.execution, x.blocks.size(), Sums{}, take, [](const Sums& a, const Sums& b) { return a + b; }, blocks_at_once);
}

/// What has joined moves, and all beside it gets a row.
template <int D>
Outcome<Done> join(System<D>& x) {
    std::vector<EdgeId> joined;
    for (const Block& block : x.blocks) joined.insert(joined.end(), block.joined.begin(), block.joined.end());
    return x.begin_rows_around(joined);
}

/// The next direction, conjugate to the last.
template <int D>
Outcome<Done> turn_by(System<D>& x, double turn) {
    return each(
        x.execution, x.blocks.size(),
        [&](std::size_t b) {
            const Block& block = x.blocks[b];
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

/// The direction's product with the matrix, and its own with that and with the residual.
struct Along {
    double curvature = 0, slope = 0;
};
template <int D>
Outcome<Along> multiply(System<D>& x) {
    return reduce_each(
        x.execution, x.blocks.size(), Along{},
        [&](Along& along, std::size_t b) {
            Rows<D>& rows = x.rows;
            x.each_product(x.blocks[b], x.direction, [&](std::size_t i, const Vec<D>& sum) {
                const Vec<D>& direction = x.direction[rows.edges[i].index()];
                rows.product[i] = sum;
                along.curvature += dot(direction, sum);
                along.slope += dot(direction, rows.residual[i]);
            });
        },
        [](const Along& a, const Along& b) { return Along{a.curvature + b.curvature, a.slope + b.slope}; },
        blocks_at_once);
}

struct Solved {
    int iterations = 0;
    double correction = 0;
};

/// How far a solve is: the steps that are left, if each of them takes as much of the largest correction as those so far
/// took of the residual's norm on the mean. Where it comes no nearer for a while, nobody can know, and the share stays.
class Headway {
  public:
    Headway(double first, double tolerance, const Execution& execution)
        : first_(first), tolerance_(tolerance), execution_(execution) {}
    void after_step(const Sums& sums) {
        const double gained = 0.5 * std::log(first_ / sums.by_residual);  // in all steps, of the norm
        const double missing = std::log(sums.largest / tolerance_);
        if (gained > 0 && missing < std::numeric_limits<double>::infinity())
            share_ = std::max(share_, gained / (gained + std::max(missing, 0.0)));
        constexpr std::size_t fine = 1000;
        report_progress(execution_, static_cast<std::size_t>(share_ * fine), fine);
    }

  private:
    double first_, tolerance_, share_ = 0;
    const Execution& execution_;
};

/// Conjugate gradients with the diagonal as preconditioner; the D components share their steps. Rows join as the
/// residual reaches them, so each new direction is made conjugate to the last by the product itself (Polak, Ribière).
template <int D>
Outcome<Solved> solve(System<D>& x, const ExtensionOptions& options, const Execution& execution) {
    Solved solved;
    auto sums = step(x, 0, options.tolerance);
    if (!sums) return fail(sums.error());
    const double first = sums->by_residual;
    Headway headway(first, options.tolerance, execution);
    double turn = 0;
    for (; solved.iterations < options.max_iterations && sums->largest > options.tolerance &&
           sums->by_residual > rounding * rounding * first;
         ++solved.iterations) {
        if (sums->joined > 0)
            if (auto joined = join(x); !joined) return fail(joined.error());
        if (auto turned = turn_by(x, turn); !turned) return fail(turned.error());
        const auto along = multiply(x);
        if (!along) return fail(along.error());
        if (!(along->curvature > 0)) break;
        sums = step(x, along->slope / along->curvature, options.tolerance);
        if (!sums) return fail(sums.error());
        turn = -sums->by_product / along->curvature;
        headway.after_step(*sums);
    }
    solved.correction = sums->largest;
    return solved;
}

}  // namespace

template <int D>
Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                      const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                                      const ExtensionOptions& options, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (kinds.size() != n || boundary_nodes.size() != n || shells.size() != n)
        return fail(ErrorKind::internal, "an extension needs a kind, a node and a shell for each edge");
    const auto middle = [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    };
    // Shares of the time of shells with layers, 1 and 5 million elements.
    auto nodes = map_each(part_of(execution, 0, 0.06), n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? LagrangeNode<D>{middle(e)} : boundary_nodes[e];
    });
    if (!nodes) return fail(nodes.error());
    Extension<D> extension{std::move(*nodes)};
    auto given = map_each(part_of(execution, 0.06, 0.12), n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? Vec<D>{} : extension.nodes[e].point - middle(e);
    });
    if (!given) return fail(given.error());
    if (std::all_of(given->begin(), given->end(), [](const Vec<D>& v) { return v == Vec<D>{}; })) return extension;
    const Execution quiet = without_progress(execution);
    return guarded([&]() -> Outcome<Extension<D>> {
        auto x = system_of<D>(mesh, kinds, std::move(*given), shells, options.stiffening, quiet);
        if (!x) return fail(x.error());
        const auto solved = solve(*x, options, part_of(execution, 0.15, 1));
        if (!solved) return fail(solved.error());
        extension.iterations = solved->iterations;
        extension.correction = solved->correction;
        const Rows<D>& rows = x->rows;
        for (std::size_t i = 0; i < rows.count; ++i) {
            extension.solved += rows.state[i] == Row::moving ? 1 : 0;
            extension.nodes[rows.edges[i].index()].point += rows.u[i];
        }
        return std::move(extension);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Extension<D>> extend_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                                      const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                                      const ExtensionOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

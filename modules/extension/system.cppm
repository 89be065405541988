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
module camber.extension:system;
import camber.core;
import :displacement;
import :energy;
import :parts;

namespace camber {

/// A node starts to move when its correction exceeds this share of the tolerance.
inline constexpr double joining = 0.1;

/// State of an unknown. `beside`: its residual is computed, but its node does not move. `joined`: the node moves from
/// the next step on.
enum class Row : std::uint8_t { beside, joined, moving };

template <int S>
int local_edge(const std::array<EdgeId, edges_per_simplex<S>>& edges, EdgeId edge) {
    int own = 0;
    for (int k = 1; k < edges_per_simplex<S>; ++k) own += edges[k] == edge ? k : 0;  // a sum, to avoid a branch
    return own;
}

template <int S, int D>
std::array<Vec<D>, S + 1> corner_points(const ExtensionDomain<S, D>& domain, ElementId e) {
    std::array<Vec<D>, S + 1> points;
    for (int i = 0; i <= S; ++i) points[i] = domain.points[domain.simplices[e][i]];
    return points;
}

template <int S, int D>
Vec<D> chord_middle(const ExtensionDomain<S, D>& domain, std::size_t e) {
    const auto& [a, b] = domain.edges.vertices[e];
    return midpoint(domain.points[a], domain.points[b]);
}

struct RowBlock {
    std::size_t begin = 0, end = 0;
    const EdgeId* columns = nullptr;
    const double* values = nullptr;
    std::vector<EdgeId> own_columns = {};  ///< used if the block has more entries than expected
    std::vector<double> own_values = {};
    std::vector<EdgeId> joined = {};
};
inline constexpr std::size_t block_rows = 256;
inline constexpr std::size_t blocks_at_once = 4;

/// Matrix entries of a block of rows during assembly. The columns of a row are its own edge, then the edges that share
/// a vertex with it, then the opposite edges (one per simplex).
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

/// Matrix rows and vectors, with space for one row per edge. Unwritten pages of the arrays take no memory.
template <int S, int D>
struct Rows {
    std::size_t count = 0;
    std::size_t entries = 0;
    Buffer<EdgeId> edges;
    Buffer<Row> state;
    Buffer<double> inverse_diagonal, height;
    Buffer<Vec<D>> u, residual, product;
    Buffer<std::uint32_t> ends;  ///< end of each row's entries in its block
    Buffer<EdgeId> columns;
    Buffer<double> values;

    Rows(std::size_t n, std::size_t simplices)
        : edges(n),
          state(n),
          inverse_diagonal(n),
          height(n),
          u(n),
          residual(n),
          product(n),
          ends(n),
          columns(n + 3 * edges_per_simplex<S> * simplices),
          values(columns.size()) {}

    [[nodiscard]] Vec<D> correction(std::size_t i) const { return inverse_diagonal[i] * residual[i]; }
    /// Length of the correction divided by the smallest height of the simplices around the edge.
    [[nodiscard]] double size(std::size_t i) const { return norm(correction(i)) / height[i]; }
};

/// Linear system of a part. Nodes that the displacement has not reached have no row and do not move.
template <int S, int D>
struct ExtensionSystem {
    ExtensionDomain<S, D> domain;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<const LagrangeNode<D>> boundary_nodes;
    Buffer<Vec<D>> direction;  ///< search direction, one per edge; initially the prescribed displacement
    Weighting weighting = {};
    Buffer<std::uint32_t> batch_of_row;  ///< one per edge: number of the batch that created its row, from 1; 0: no row
    Buffer<ElementEnergy<simplex<S>, 2>> energies;  ///< unwritten for simplices without a row
    Rows<S, D> rows;
    std::vector<RowBlock> blocks = {};
    std::vector<std::vector<std::uint32_t>> of_runs = {};
    std::uint32_t round = 0;
    std::vector<EdgeId> joined = {};  ///< edges whose nodes start to move after the last step

    [[nodiscard]] bool owns(EdgeId edge) const { return owned.owns(domain.edges.vertices[edge]); }

    Outcome<std::vector<EdgeId>> unknowns_without_row(std::span<const EdgeId> from, const Execution& execution) {
        constexpr std::size_t grain = 1024;
        std::vector<std::vector<EdgeId>> visited((from.size() + grain - 1) / grain);
        auto looked = each_chunk(
            execution, from.size(),
            [&](std::size_t begin, std::size_t end) {
                for (const EdgeId edge : from.subspan(begin, end - begin))
                    for (const ElementId e : shells[edge])
                        for (const EdgeId other : domain.edges.of_elements[e])
                            if (batch_of_row[other.index()] == 0 && kinds[other] == EdgeKind::volume && owns(other))
                                visited[begin / grain].push_back(other);
            },
            grain);
        if (!looked) return fail(looked.error());
        ++round;
        std::vector<EdgeId> reached;
        for (const auto& some : visited)
            for (const EdgeId edge : some)
                if (batch_of_row[edge.index()] == 0) batch_of_row[edge.index()] = round, reached.push_back(edge);
        std::sort(reached.begin(), reached.end());
        return reached;
    }

    /// True if the energy of simplex e is computed for `edge`: no earlier batch computed it, and `edge` is its lowest
    /// edge in this batch.
    [[nodiscard]] bool is_first_of(EdgeId edge, ElementId e) const {
        const auto& edges = domain.edges.of_elements[e];
        return std::all_of(edges.begin(), edges.end(), [&](EdgeId other) {
            const std::uint32_t in = batch_of_row[other.index()];
            return in == 0 || (in == round && edge <= other);
        });
    }

    void begin_row(std::size_t i, EdgeId edge, Entries& entries) {
        const std::size_t begin = entries.columns.size();
        double height = std::numeric_limits<double>::infinity();
        entries.columns.push_back(edge);
        entries.values.push_back(0);
        for (const ElementId e : shells[edge]) {
            const auto& edges = domain.edges.of_elements[e];
            const auto& energy = energies[e.index()];
            const int own = local_edge<S>(edges, edge);
            each_row_entry<simplex<S>, 2>(energy, own, [&](int k, double value) {
                if (k == own)
                    entries.values[begin] += value;
                else if (S == 3 && k == edges_beside<S>[own].opposite)
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

    /// `room`: index of the block's first entry in `rows`. `expected`: number of entries if the elements around each
    /// edge form a closed ring.
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

    Outcome<Done> begin_rows_around(std::span<const EdgeId> from, const Execution& execution) {
        const auto reached = unknowns_without_row(from, execution);
        if (!reached) return fail(reached.error());
        const std::span<const EdgeId> edges(*reached);
        auto computed = each(execution, edges.size(), [&](std::size_t i) {
            for (const ElementId e : shells[edges[i]])
                if (is_first_of(edges[i], e))
                    energies[e.index()] = element_energy<simplex<S>, 2, D>(corner_points(domain, e), weighting);
        });
        if (!computed) return fail(computed.error());
        const std::size_t first = blocks.size(), before = rows.count;
        const std::vector<std::size_t> room = begin_blocks(edges);
        return each(
            execution, blocks.size() - first,
            [&](std::size_t b) {
                RowBlock& block = blocks[first + b];
                begin_block(block, edges.subspan(block.begin - before, block.end - block.begin), room[b],
                            room[b + 1] - room[b]);
            },
            1);
    }

    /// Divides the rows of ascending edges into blocks, each within one run. Returns the index of each block's first
    /// entry.
    std::vector<std::size_t> begin_blocks(std::span<const EdgeId> edges) {
        of_runs.resize(owned.runs());
        const auto run_of = [&](EdgeId edge) { return owned.run_of(domain.edges.vertices[edge][0]); };
        std::vector<std::size_t> room;
        for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
            room.push_back(rows.entries);
            const std::size_t run = run_of(edges[begin]);
            for (; end < edges.size() && end < begin + block_rows && run_of(edges[end]) == run; ++end)
                rows.entries += 1 + 3 * shells[edges[end]].size();  // enough for a closed shell
            of_runs[run].push_back(static_cast<std::uint32_t>(blocks.size()));
            blocks.push_back({rows.count + begin, rows.count + end});
        }
        room.push_back(rows.entries);
        rows.count += edges.size();
        return room;
    }

    template <class T>
    Outcome<std::vector<T>> reduce_runs(const Execution& execution, const auto& accumulate) {
        of_runs.resize(owned.runs());
        std::vector<T> sums;
        for (const std::vector<std::uint32_t>& of_run : of_runs) {
            auto sum = reduce_each(
                execution, of_run.size(), T{}, [&](T& value, std::size_t i) { accumulate(value, blocks[of_run[i]]); },
                [](const T& a, const T& b) { return a + b; }, blocks_at_once);
            if (!sum) return fail(sum.error());
            sums.push_back(*sum);
        }
        return sums;
    }

    /// Calls visit(i, value) for each row i of a block, with the value of A x in this row. A is the matrix; x has one
    /// vector per edge.
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

}  // namespace camber

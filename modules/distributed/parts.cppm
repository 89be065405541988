// Parts of a mesh with two rings of elements, meshes read by rows, messages to parts, and halos.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.distributed:parts;
import camber.core;
import camber.io;
import camber.extension;
import camber.curving;
import :ranks;

export namespace camber {

/// Number of a vertex, element or other entity in the whole mesh, from 0; may exceed 32 bits.
using GlobalNumber = std::uint64_t;

/// Callbacks around the work on a part, to limit memory. Each may be null.
struct PartMemory {
    std::function<void()> before = {};  ///< memory allocated after this call is released with the part
    std::function<void()> after = {};   ///< memory allocated after this call is persistent
    std::function<void()> leave = {};   ///< persistent data may be paged out
};

inline constexpr std::size_t default_block_elements = std::size_t{1} << 18U;

struct BlockOptions {
    std::size_t elements = default_block_elements;  ///< approximate number of elements in a block
    /// Maximum number of elements in a part that consists of several blocks. A rank processes its parts one after the
    /// other. Results do not depend on it.
    std::size_t elements_at_once = std::numeric_limits<std::size_t>::max();
    PartMemory memory = {};
};

/// Distribution of a mesh. A block is a run of vertices, and each rank has a run of blocks. An edge, facet or element
/// belongs to the block of its lowest vertex. A part is a run of blocks that a rank processes at once.
struct PartLayout {
    std::vector<GlobalNumber> first_of_blocks;  ///< first vertex of each block, and the total
    std::vector<GlobalNumber> first_vertices;   ///< first vertex of each part, and the total
    std::vector<std::size_t> first_parts;       ///< first part of each rank, and the total

    [[nodiscard]] std::size_t blocks() const { return first_of_blocks.empty() ? 0 : first_of_blocks.size() - 1; }
    [[nodiscard]] std::size_t size() const { return first_vertices.empty() ? 0 : first_vertices.size() - 1; }
    [[nodiscard]] std::size_t part_with(GlobalNumber vertex) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_vertices, vertex) - first_vertices.begin()) - 1;
    }
    [[nodiscard]] std::size_t rank_of(std::size_t part) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(first_parts, part) - first_parts.begin()) - 1;
    }
    [[nodiscard]] std::size_t begin_of(std::size_t rank) const { return first_parts[rank]; }
    [[nodiscard]] std::size_t end_of(std::size_t rank) const { return first_parts[rank + 1]; }
    /// Returns the first vertex of each block of a part, except the first block.
    [[nodiscard]] std::span<const GlobalNumber> later_blocks(std::size_t part) const {
        const auto begin = std::ranges::upper_bound(first_of_blocks, first_vertices[part]);
        return {begin, std::ranges::lower_bound(first_of_blocks, first_vertices[part + 1])};
    }
};

/// A run of vertices with two rings of elements. Local ids have the order of global numbers, so that loops over
/// neighbours have the same order as in the whole mesh.
template <int D>
struct RingedPart {
    LinearMesh<D> mesh;
    Column<GlobalNumber> vertices, elements, facets, edges;  ///< global numbers of entities; `edges`: feature edges
    VertexId first, last;                                    ///< own vertices are [first, last)

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
};

template <int D>
void each_array(RingedPart<D>& part, const auto& visit) {
    const auto visit_simplices = [&](auto& simplices) {
        visit(simplices.vertices);
        visit(simplices.references);
    };
    visit(part.mesh.points);
    visit(part.mesh.point_references);
    visit_simplices(part.mesh.elements);
    visit_simplices(part.mesh.facets);
    visit_simplices(part.mesh.edges);
    visit(part.vertices);
    visit(part.elements);
    visit(part.facets);
    visit(part.edges);
}
/// Returns the addresses of a value's arrays. `copy_new_arrays` copies arrays whose address is not in `before` (from
/// `arrays_of`) into new memory.
template <class T>
[[nodiscard]] std::vector<const void*> arrays_of(T& thing) {
    std::vector<const void*> arrays;
    each_array(thing, [&](const auto& array) { arrays.push_back(array.data()); });
    return arrays;
}
template <class T>
void copy_new_arrays(T& thing, std::span<const void* const> before) {
    std::size_t next = 0;
    each_array(thing, [&]<class Array>(Array& array) {
        if (array.data() == before[next++] || array.empty()) return;
        Buffer<typename Array::value_type> again(array.size());
        fill_array<typename Array::value_type>(again, {array.data(), array.size()});
        array = std::move(again);
    });
}

template <int D>
struct RingedParts {
    PartLayout layout;
    std::vector<RingedPart<D>> own;  ///< own parts, from layout.begin_of(rank) on
};

struct RowCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// K-simplices in file order, without required simplices and entities.
template <int K>
struct SimplexRows {
    Buffer<SimplexVertices<K>> vertices;
    Buffer<Reference> references;
};
template <int D>
struct PointRows {
    Buffer<Vec<D>> points;
    Buffer<Reference> references;
};

/// Thread-safe access to runs of mesh rows, in a file or in memory. Errors: input (also vertex ids out of range),
/// memory.
template <int D>
class MeshRows {
  public:
    virtual ~MeshRows() = default;
    [[nodiscard]] virtual RowCounts counts() const = 0;
    [[nodiscard]] virtual Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const = 0;
    /// Returns the small lists: corners, required entities and ridges (ascending), geometry data of the file, names of
    /// references.
    [[nodiscard]] virtual Outcome<LinearMesh<D>> lists() const = 0;

  protected:
    MeshRows() = default;
    MeshRows(const MeshRows&) = default;
    MeshRows(MeshRows&&) = default;
    MeshRows& operator=(const MeshRows&) = default;
    MeshRows& operator=(MeshRows&&) = default;
};

}  // namespace camber

namespace camber {

struct Run {
    std::size_t begin = 0, end = 0;
    [[nodiscard]] std::size_t size() const { return end - begin; }
};
[[nodiscard]] inline Run part_of(Run run, std::size_t part, std::size_t parts) {
    return {run.begin + run.size() * part / parts, run.begin + run.size() * (part + 1) / parts};
}

/// Maximum number of rows read at once, to limit the memory of data in transit.
inline constexpr std::size_t chunk_rows = std::size_t{1} << 20U;

template <int K>
struct SimplexRow {
    GlobalNumber row = 0;
    std::array<GlobalNumber, K + 1> vertices{};
    Reference reference = 0;
    std::uint32_t required = 0;
};

/// Returns unique values in order, by merging the sorted runs of the input.
template <int K>
Buffer<SimplexRow<K>> in_order(const Buffer<SimplexRow<K>>& values) {
    Buffer<SimplexRow<K>> rows(values.begin(), values.end());
    const auto precedes = [](const SimplexRow<K>& a, const SimplexRow<K>& b) { return a.row < b.row; };
    std::vector<std::size_t> runs{0};
    for (std::size_t i = 1; i < rows.size(); ++i)
        if (precedes(rows[i], rows[i - 1])) runs.push_back(i);
    runs.push_back(rows.size());
    const auto at = [&](std::size_t run) { return rows.begin() + static_cast<std::ptrdiff_t>(runs[run]); };
    const std::size_t last = runs.size() - 1;
    for (std::size_t width = 1; width < last; width *= 2)
        for (std::size_t r = 0; r + width < last; r += 2 * width)
            std::inplace_merge(at(r), at(r + width), at(std::min(r + 2 * width, last)), precedes);
    const auto again = std::ranges::unique(rows, {}, &SimplexRow<K>::row);
    rows.erase(again.begin(), again.end());
    return rows;
}

template <int K>
void append(Buffer<SimplexRow<K>>& list, const std::vector<SimplexRow<K>>& rows) {
    const std::size_t before = list.size();
    list.resize(before + rows.size());
    fill_array<SimplexRow<K>>(std::span(list).subspan(before), rows);
}

}  // namespace camber

export namespace camber {

template <class T>
struct ToPart {
    std::uint64_t part = 0;
    T what;
};

/// Sends values to the ranks of their parts. Returns a list for each own part, in the order of ranks, then of their
/// input.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<std::vector<T>>> route(Ranks& ranks, const PartLayout& layout,
                                                         Outcome<std::vector<ToPart<T>>> things) {
    Outcome<std::vector<Bytes>> to{std::vector<Bytes>{}};
    if (things) {
        std::vector<std::vector<ToPart<T>>> of_ranks(ranks.size());
        if (ranks.size() == 1)
            of_ranks.front() = std::move(*things);
        else
            for (const auto& thing : *things) of_ranks[layout.rank_of(thing.part)].push_back(thing);
        for (auto& some : of_ranks) {
            to->push_back(bytes_of<ToPart<T>>(some));
            some = {};
        }
    } else
        to = fail(things.error());
    const auto from = ranks.exchange(std::move(to));
    if (!from) return fail(from.error());
    const std::size_t begin = layout.begin_of(ranks.rank()), end = layout.end_of(ranks.rank());
    std::vector<std::vector<T>> received(end - begin);
    for (const Bytes& bytes : *from) {
        std::vector<ToPart<T>> some;
        append_values(bytes, some);
        for (ToPart<T>& thing : some) received[thing.part - begin].push_back(thing.what);
    }
    return received;
}

template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<std::vector<T>>> exchanged_lists(Ranks& ranks, std::vector<std::vector<T>> to) {
    if (ranks.size() == 1) return to;
    std::vector<Bytes> bytes;
    bytes.reserve(to.size());
    for (auto& some : to) {
        bytes.push_back(bytes_of<T>(some));
        some = {};
    }
    auto from = ranks.exchange(std::move(bytes));
    if (!from) return fail(from.error());
    std::vector<std::vector<T>> lists(from->size());
    for (std::size_t r = 0; r < lists.size(); ++r) append_values(std::exchange((*from)[r], {}), lists[r]);
    return lists;
}

/// Like exchanged_lists, but concatenates the received lists and passes on errors.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<T>> exchanged_values(Ranks& ranks, Outcome<std::vector<std::vector<T>>> to) {
    Outcome<std::vector<Bytes>> bytes = std::vector<Bytes>();
    if (!to) bytes = fail(to.error());
    if (to)
        for (auto& some : *to) bytes->push_back(bytes_of<T>(std::exchange(some, {})));
    auto from = ranks.exchange(std::move(bytes));
    if (!from) return fail(from.error());
    std::vector<T> all;
    for (Bytes& some : *from) append_values(std::exchange(some, {}), all);
    return all;
}

/// Sends questions to the ranks of the parts, which call answer(own part, key). Returns one answer for each question,
/// in order.
template <class Answer, class Key, class F>
    requires std::is_trivially_copyable_v<Key> && std::is_trivially_copyable_v<Answer>
[[nodiscard]] Outcome<std::vector<Answer>> query(Ranks& ranks, const PartLayout& layout,
                                                 const std::vector<ToPart<Key>>& questions, const F& answer) {
    std::vector<std::vector<ToPart<Key>>> of_ranks(ranks.size());
    for (const auto& question : questions) of_ranks[layout.rank_of(question.part)].push_back(question);
    std::vector<Bytes> to;
    to.reserve(of_ranks.size());
    for (const auto& some : of_ranks) to.push_back(bytes_of<ToPart<Key>>(some));
    auto requests = ranks.exchange(std::move(to));
    if (!requests) return fail(requests.error());
    std::vector<Bytes> answers;
    for (const Bytes& bytes : *requests) {
        std::vector<ToPart<Key>> some;
        append_values(bytes, some);
        std::vector<Answer> values;
        values.reserve(some.size());
        for (const auto& question : some)
            values.push_back(answer(question.part - layout.begin_of(ranks.rank()), question.what));
        answers.push_back(bytes_of<Answer>(values));
    }
    auto back = ranks.exchange(std::move(answers));
    if (!back) return fail(back.error());
    std::vector<std::vector<Answer>> by_rank(ranks.size());
    for (std::size_t r = 0; r < by_rank.size(); ++r) append_values((*back)[r], by_rank[r]);
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<Answer> out;
    out.reserve(questions.size());
    for (const auto& question : questions) {
        const std::size_t r = layout.rank_of(question.part);
        out.push_back(by_rank[r][next[r]++]);
    }
    return out;
}

/// Rows that are copied from their owners into the rings of other parts.
struct Halo {
    struct Row {
        std::uint32_t part = 0;  ///< index among own parts
        std::uint32_t row = 0;
    };
    std::vector<Buffer<Row>> send;  ///< rows sent to each rank, in the order of its `get`
    std::vector<Buffer<Row>> get;   ///< rows received from each rank
};

template <int D>
[[nodiscard]] Outcome<Halo> vertex_halo(const RingedParts<D>& parts, Ranks& ranks);

template <int D>
[[nodiscard]] Outcome<Halo> edge_halo(const RingedParts<D>& parts, std::span<const EdgeSet<D>> edges, Ranks& ranks);

/// Copies rows from their owners into rings. `columns` has the values by vertex or edge, for each own part.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<Done> update_ghost_rows(const Halo& halo, Ranks& ranks, std::span<const std::span<T>> columns) {
    std::vector<Bytes> to(ranks.size());
    for (std::size_t r = 0; r < to.size(); ++r) {
        if (r == ranks.rank()) continue;
        Buffer<T> rows(halo.send[r].size());
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = columns[halo.send[r][i].part][halo.send[r][i].row];
        to[r] = bytes_of<T>({rows.data(), rows.size()});
    }
    const auto from = ranks.exchange(std::move(to));
    if (!from) return fail(from.error());
    for (std::size_t r = 0; r < ranks.size(); ++r) {
        std::vector<T> rows;
        if (r != ranks.rank()) append_values((*from)[r], rows);
        for (std::size_t i = 0; i < halo.get[r].size(); ++i) {
            const Halo::Row& into = halo.get[r][i];
            if (r != ranks.rank())
                columns[into.part][into.row] = rows[i];
            else
                columns[into.part][into.row] = columns[halo.send[r][i].part][halo.send[r][i].row];
        }
    }
    return Done{};
}

template <int D>
class BetweenRingedParts final : public PartCommunication<D> {
  public:
    /// `ranks` and `halo` must outlive the object. `parts` is the number of own parts.
    BetweenRingedParts(Ranks& ranks, const Halo& halo, std::size_t parts);

    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override;
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const override;
    [[nodiscard]] Outcome<EdgesOfParts> exchange_rows(std::span<const std::span<Vec<D>>> rows,
                                                      const EdgesOfParts& edges) override;

  private:
    struct SentRow {
        std::uint32_t row = 0, rank = 0, at = 0;
    };
    Ranks& ranks_;
    const Halo& halo_;
    std::vector<Buffer<SentRow>> sent_;
};

/// Splits a mesh into blocks: runs of vertices that have about the requested number of elements. For this count, each
/// vertex of an element counts an equal share of it. Blocks depend only on the mesh and the requested number. Each rank
/// reads a share of the rows and gets a run of blocks, in parts with two rings. Vertex numbers are those of the rows,
/// whose order should be spatially local (camber.ordering). Required elements, facets and edges and names of references
/// are transferred, but not the geometry data of the file. Errors: those of the rows, memory, stopped.
template <int D>
[[nodiscard]] Outcome<RingedParts<D>> split(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks,
                                            const Execution& execution);

}  // namespace camber

namespace camber {

/// Rows of a rank before partitioning: runs (`part_of`) of elements and facets. Each rank has all feature edges, which
/// are few, and all lists.
template <int D>
struct RunsOfRank {
    RowCounts counts;
    SimplexRows<D> elements;
    SimplexRows<D - 1> facets;
    SimplexRows<1> edges;
    LinearMesh<D> lists;
};

/// Returns the points with the given global numbers, which must be ascending. All ranks call it.
template <int D>
using PointsAt = std::function<Outcome<PointRows<D>>(const std::vector<std::uint64_t>&)>;

template <int D>
struct PointRow {
    Vec<D> point;
    Reference reference = 0;
};
template <int D>
[[nodiscard]] PointRows<D> point_rows(const std::vector<PointRow<D>>& vertex_rows) {
    PointRows<D> rows;
    for (const PointRow<D>& row : vertex_rows) {
        rows.points.push_back(row.point);
        rows.references.push_back(row.reference);
    }
    return rows;
}

/// Reads rows with ascending numbers, in runs with small gaps. Calls take(i, rows, index of numbers[i] in rows).
template <class Read, class Take>
[[nodiscard]] Outcome<Done> read_some(const std::vector<std::uint64_t>& numbers, const Read& read, const Take& take) {
    constexpr std::uint64_t gap = 64;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && end - i < chunk_rows && numbers[end] < numbers[end - 1] + gap) ++end;
        const auto some = read(numbers[i], numbers[end - 1] + 1);
        if (!some) return fail(some.error());
        const std::uint64_t first = numbers[i];
        for (; i < end; ++i) take(i, *some, static_cast<std::size_t>(numbers[i] - first));
    }
    return Done{};
}

}  // namespace camber

export namespace camber {

/// Rows of a binary linear .meshb file. Each call decodes only its own rows, then calls `after_rows`, which may page
/// out mapped bytes. Errors: input, unsupported (io).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf(Column<std::byte> bytes, std::string_view name,
                                                                std::function<void()> after_rows = {});

/// Rows of a mesh in memory, without a copy.
template <int D>
[[nodiscard]] std::unique_ptr<MeshRows<D>> rows_of(LinearMesh<D> mesh);

/// Numbers, from 0, of the edge nodes of simplices, in the order of `local_edges`.
template <int K>
using EdgeNodeRows = Buffer<std::array<std::uint64_t, edges_per_simplex<K>>>;

/// Rows of a binary .meshb file of degree 2 whose vertices precede its edge nodes, as a straight mesh and edge nodes.
/// See `rows_of_gmf`.
template <int D>
class QuadraticRows final : public MeshRows<D> {
  public:
    /// Finds the last vertex: each rank searches a run of the simplices. Errors: input, unsupported (io; vertices after
    /// edge nodes).
    [[nodiscard]] static Outcome<std::unique_ptr<QuadraticRows>> make(Column<std::byte> bytes, std::string_view name,
                                                                      std::function<void()> after_rows, Ranks& ranks);
    QuadraticRows(Column<std::byte> bytes, GmfRuns<D, 2> runs, std::function<void()> after_rows)
        : bytes_(std::move(bytes)), runs_(std::move(runs)), after_rows_(std::move(after_rows)) {}

    [[nodiscard]] RowCounts counts() const override;
    [[nodiscard]] Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const override;
    [[nodiscard]] Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const override;
    [[nodiscard]] Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const override;
    [[nodiscard]] Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const override;
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override { return runs_.lists(); }

    /// Functions that return positions of edge nodes, and the edge nodes of simplices (K is D, D − 1, or 1 for feature
    /// edges in 3D).
    [[nodiscard]] Outcome<PointRows<D>> mid_nodes(std::size_t begin, std::size_t end) const;
    template <int K>
    [[nodiscard]] Outcome<EdgeNodeRows<K>> nodes_of(std::size_t begin, std::size_t end) const;

  private:
    template <int K>
    struct Curved {
        Buffer<typename GmfRuns<D, 2>::template Nodes<K>> nodes;
        Buffer<Reference> references;
    };
    template <int K>
    [[nodiscard]] Outcome<Curved<K>> curved(std::size_t begin, std::size_t end) const;
    template <int K>
    [[nodiscard]] Outcome<SimplexRows<K>> corners(std::size_t begin, std::size_t end) const;
    [[nodiscard]] Outcome<PointRows<D>> rows_of_points(std::size_t begin, std::size_t end) const;

    struct Ends {
        std::uint64_t of_vertices = 0, of_nodes = 0;
    };
    template <int K>
    [[nodiscard]] Outcome<Done> look_through(std::size_t count, const Ranks& ranks, Ends& ends) const;
    [[nodiscard]] Outcome<Done> find_vertices(std::string_view name, Ranks& ranks);

    Column<std::byte> bytes_;
    GmfRuns<D, 2> runs_;
    std::function<void()> after_rows_;
    std::size_t vertices_ = 0;
};

}  // namespace camber

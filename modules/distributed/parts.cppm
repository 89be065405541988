// Parts of a mesh with two rings of elements, meshes read by rows, routing and halos.
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

/// A vertex, an element … of a mesh in blocks, from 0: there may be more than 32 bits count.
using GlobalNumber = std::uint64_t;

/// What is done around the work on a part where memory is little. Null: nobody minds.
struct PartMemory {
    std::function<void()> before = {};  ///< what is made from here on is let go of with the part
    std::function<void()> after = {};   ///< and from here on it is kept
    std::function<void()> leave = {};   ///< what is kept of the part may leave memory
};

inline constexpr std::size_t default_block_elements = std::size_t{1} << 18U;

struct BlockOptions {
    std::size_t elements = default_block_elements;  ///< about so many in a block
    /// At most so many in a part, if that is a block: a rank goes through its blocks by parts. No matter to results.
    std::size_t elements_at_once = std::numeric_limits<std::size_t>::max();
    PartMemory memory = {};
};

/// Which vertices are a block's, and who has which blocks: runs of rising numbers. An edge, a facet and an element
/// belong to the block of their lowest vertex. A part is a run of blocks that a rank has and works on at once.
struct PartLayout {
    std::vector<GlobalNumber> first_of_blocks;  ///< vertices: of each block; then the number of vertices
    std::vector<GlobalNumber> first_vertices;   ///< of each part; then the number of vertices
    std::vector<std::size_t> first_parts;       ///< of each rank; then the number of parts

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
    /// Where all blocks of a part but the first begin.
    [[nodiscard]] std::span<const GlobalNumber> later_blocks(std::size_t part) const {
        const auto begin = std::ranges::upper_bound(first_of_blocks, first_vertices[part]);
        return {begin, std::ranges::lower_bound(first_of_blocks, first_vertices[part + 1])};
    }
};

/// Some of a mesh's vertices and the elements around them: those at these vertices, and a ring more. Local ids rise
/// with global numbers, so that loops over what is around something go in the same order as in the whole mesh.
template <int D>
struct RingedPart {
    LinearMesh<D> mesh;
    Column<GlobalNumber> vertices, elements, facets, edges;  ///< of each local row; edges: the feature edges
    VertexId first, last;                                    ///< its own vertices are [first, last)

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
};

/// visit(array) of all that grow with the part.
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
/// The arrays of what has them, and those that are others than before made once more: where what is kept is made.
template <class T>
[[nodiscard]] std::vector<const void*> arrays_of(T& thing) {
    std::vector<const void*> arrays;
    each_array(thing, [&](const auto& array) { arrays.push_back(array.data()); });
    return arrays;
}
template <class T>
void made_anew(T& thing, std::span<const void* const> before) {
    std::size_t next = 0;
    each_array(thing, [&]<class Array>(Array& array) {
        if (array.data() == before[next++] || array.empty()) return;
        Buffer<typename Array::value_type> again(array.size());
        fill_array<typename Array::value_type>(again, {array.data(), array.size()});
        array = std::move(again);
    });
}

/// What a rank holds of a mesh in blocks.
template <int D>
struct RingedParts {
    PartLayout layout;
    std::vector<RingedPart<D>> own;  ///< from layout.begin_of(rank) on
};

/// So many rows a mesh has in a file or in memory.
struct RowCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// K-simplices in the order of their file, without what LinearMesh says of them beside.
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

/// A mesh that is read by rows, any run of them at a time and several at once: from a file by offsets, or from memory.
/// Vertex ids are in range (`input` otherwise). Errors: input, memory.
template <int D>
class MeshRows {
  public:
    virtual ~MeshRows() = default;
    [[nodiscard]] virtual RowCounts counts() const = 0;
    [[nodiscard]] virtual Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const = 0;
    /// Feature edges of a mesh in 3D.
    [[nodiscard]] virtual Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const = 0;
    /// What is said beside the rows, which is little: corners, required entities and ridges, which rise, the given
    /// geometry, names of references.
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

/// Some rows, one after the other: of those of a kind what a rank reads, or a chunk of it.
struct Run {
    std::size_t begin = 0, end = 0;
    [[nodiscard]] std::size_t size() const { return end - begin; }
};
[[nodiscard]] inline Run part_of(Run run, std::size_t part, std::size_t parts) {
    return {run.begin + run.size() * part / parts, run.begin + run.size() * (part + 1) / parts};
}

/// Rows are read in chunks, so that what is on its way is little beside what is there.
inline constexpr std::size_t chunk_rows = std::size_t{1} << 20U;

/// Of a K-simplex, on its way to parts.
template <int K>
struct SimplexRow {
    GlobalNumber row = 0;
    std::array<GlobalNumber, K + 1> vertices{};
    Reference reference = 0;
    std::uint32_t required = 0;
};

/// Rising, each once. They come in a few runs that rise: these are merged.
template <int K>
Buffer<SimplexRow<K>> in_order(const Buffer<SimplexRow<K>>& given) {
    Buffer<SimplexRow<K>> rows(given.begin(), given.end());
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

/// Rows at the end of a list.
template <int K>
void append(Buffer<SimplexRow<K>>& list, const std::vector<SimplexRow<K>>& rows) {
    const std::size_t before = list.size();
    list.resize(before + rows.size());
    fill_array<SimplexRow<K>>(std::span(list).subspan(before), rows);
}

}  // namespace camber

export namespace camber {

/// Something for a part, wherever that is.
template <class T>
struct ToPart {
    std::uint64_t part = 0;
    T what;
};

/// Takes things to the ranks that hold their parts: a list for each of this rank's, with what lower ranks sent first,
/// in the order in which it was given. Errors: of any rank.
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

/// Lists of plain values, one to each rank, and those that each has sent to this one. Errors: of any rank.
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

/// The same, what all have sent one after the other; where a rank has an error instead, all have it.
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

/// Asks parts: answer(own part, key) is called where the part is; one a question, in the order of the questions.
/// Errors: of any rank.
template <class Answer, class Key, class F>
    requires std::is_trivially_copyable_v<Key> && std::is_trivially_copyable_v<Answer>
[[nodiscard]] Outcome<std::vector<Answer>> ask(Ranks& ranks, const PartLayout& layout,
                                               const std::vector<ToPart<Key>>& questions, const F& answer) {
    std::vector<std::vector<ToPart<Key>>> of_ranks(ranks.size());
    for (const auto& question : questions) of_ranks[layout.rank_of(question.part)].push_back(question);
    std::vector<Bytes> to;
    to.reserve(of_ranks.size());
    for (const auto& some : of_ranks) to.push_back(bytes_of<ToPart<Key>>(some));
    auto asked = ranks.exchange(std::move(to));
    if (!asked) return fail(asked.error());
    std::vector<Bytes> answers;
    for (const Bytes& bytes : *asked) {
        std::vector<ToPart<Key>> some;
        append_values(bytes, some);
        std::vector<Answer> given;
        given.reserve(some.size());
        for (const auto& question : some)
            given.push_back(answer(question.part - layout.begin_of(ranks.rank()), question.what));
        answers.push_back(bytes_of<Answer>(given));
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

/// Which rows of parts others have in their rings: a star forest, each owner's row its root.
struct Halo {
    struct Row {
        std::uint32_t part = 0;  ///< of this rank's, from 0
        std::uint32_t row = 0;
    };
    std::vector<Buffer<Row>> give;  ///< to each rank, in the order in which it has them in `get`
    std::vector<Buffer<Row>> get;   ///< from each rank
};

/// Of vertices. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<Halo> vertex_halo(const RingedParts<D>& parts, Ranks& ranks);

/// Of unique edges, of which each part has its own set.
template <int D>
[[nodiscard]] Outcome<Halo> edge_halo(const RingedParts<D>& parts, std::span<const EdgeSet<D>> edges, Ranks& ranks);

/// Rows of owners brought into the rings of others; `columns`: one row a vertex, or an edge, of each part here.
/// Errors: of any rank.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<Done> bring_all(const Halo& halo, Ranks& ranks, std::span<const std::span<T>> columns) {
    std::vector<Bytes> to(ranks.size());
    for (std::size_t r = 0; r < to.size(); ++r) {
        if (r == ranks.rank()) continue;
        Buffer<T> rows(halo.give[r].size());
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = columns[halo.give[r][i].part][halo.give[r][i].row];
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
                columns[into.part][into.row] = columns[halo.give[r][i].part][halo.give[r][i].row];
        }
    }
    return Done{};
}

/// The parts of a mesh that this rank has, and those that others have.
template <int D>
class BetweenRingedParts final : public BetweenParts<D> {
  public:
    /// Both must outlive it. The parts here are so many parts.
    BetweenRingedParts(Ranks& ranks, const Halo& halo, std::size_t parts);

    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override;
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const override;
    [[nodiscard]] Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows,
                                              const EdgesOfParts& edges) override;

  private:
    /// A row that a rank gets: as the at-th of its `get`.
    struct Given {
        std::uint32_t row = 0, rank = 0, at = 0;
    };
    Ranks& ranks_;
    const Halo& halo_;
    std::vector<Buffer<Given>> given_;  ///< of each part, by rising rows
};

/// A mesh cut into blocks, runs of its vertices with about as many elements as the options say, where a vertex has a
/// share of each around it; they depend on the mesh and on that number alone. Each rank reads its share of the rows and
/// gets a run of blocks, in parts with two rings of elements around each. Vertices are numbered as in the rows, which
/// are to be in an order in which what is near is near (camber.ordering). What elements, facets and edges the mesh
/// lists as required comes along, and its names of references; what it says of its geometry does not. Errors: those of
/// the rows, memory, stopped; of any rank.
template <int D>
[[nodiscard]] Outcome<RingedParts<D>> split(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks,
                                            const Execution& execution);

}  // namespace camber

namespace camber {

/// What a rank begins with of a mesh that ranks bring into parts: its run (`part_of`) of the elements and of the
/// facets; all feature edges, which are few, and all lists.
template <int D>
struct RunsOfRank {
    RowCounts counts;
    SimplexRows<D> elements;
    SimplexRows<D - 1> facets;
    SimplexRows<1> edges;
    LinearMesh<D> lists;
};

/// The points of these numbers, which rise; all ranks ask at once.
template <int D>
using PointsAt = std::function<Outcome<PointRows<D>>(const std::vector<std::uint64_t>&)>;

/// A vertex as one rank tells it another.
template <int D>
struct PointRow {
    Vec<D> point;
    Reference reference = 0;
};
template <int D>
[[nodiscard]] PointRows<D> point_rows(const std::vector<PointRow<D>>& told) {
    PointRows<D> rows;
    for (const PointRow<D>& row : told) {
        rows.points.push_back(row.point);
        rows.references.push_back(row.reference);
    }
    return rows;
}

/// Rows of some numbers, which rise, read by runs that leave few out: take(i, rows, place of numbers[i] in them).
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

/// Of the bytes of a binary .meshb of degree 1: each call decodes its own rows, and touches no other bytes.
/// `after_rows` is called when some have been read: bytes that are mapped may leave memory. Errors: input, unsupported
/// (io).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf(Column<std::byte> bytes, std::string_view name,
                                                                std::function<void()> after_rows = {});

/// Of a mesh in memory, which is not copied.
template <int D>
[[nodiscard]] std::unique_ptr<MeshRows<D>> rows_of(LinearMesh<D> mesh);

/// Of simplices the nodes of their edges, in the order of `local_edges`, by numbers from 0 on.
template <int K>
using EdgeNodeRows = Buffer<std::array<std::uint64_t, edges_per_simplex<K>>>;

/// The rows of a binary .meshb of degree 2 whose vertices come before the nodes of edges: as rows of a straight mesh,
/// and the nodes beside them. Each call decodes its own rows, see `rows_of_gmf`.
template <int D>
class QuadraticRows final : public MeshRows<D> {
  public:
    /// All ranks call it: each looks through a run of the simplices for where vertices end. Errors, of any rank: input,
    /// unsupported (io; vertices behind nodes of edges).
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

    /// The edges' nodes themselves, and those of simplices (K is D, D − 1 or, of feature edges in 3D, 1).
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

    /// Where vertices end, and edges' nodes begin, as far as simplices of a run say it.
    struct Ends {
        std::uint64_t of_vertices = 0, of_nodes = 0;
    };
    template <int K>
    [[nodiscard]] Outcome<Done> look_through(std::size_t count, const Ranks& ranks, Ends& ends) const;
    [[nodiscard]] Outcome<Done> find_vertices(std::string_view name, Ranks& ranks);

    Column<std::byte> bytes_;
    GmfRuns<D, 2> runs_;  ///< over those
    std::function<void()> after_rows_;
    std::size_t vertices_ = 0;
};

}  // namespace camber

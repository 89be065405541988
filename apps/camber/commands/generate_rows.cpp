module;
#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.config;
import camber.distributed;
import camber.io;
import camber.run;
import camber.shapes;
import :generate_rows;
import :written_together;

namespace camber::app {

namespace {

/// About so many elements are made at a time, but a few rows at least: points of rows around are made anew each time.
constexpr std::size_t elements_of_turn = std::size_t{1} << 20U, least_rows_of_turn = 3;

template <class Options>
constexpr int dimension_of = 0;
template <int D>
constexpr int dimension_of<BoxOptions<D>> = D;
template <int D>
constexpr int dimension_of<ShellOptions<D>> = D;

template <int K>
SimplexRun<K, 1> simplex_run(std::size_t first, const auto& simplices, Buffer<Reference> references) {
    SimplexRun<K, 1> run{first, {}, std::move(references)};
    run.nodes.reserve(simplices.size());
    for (const SimplexVertices<K>& simplex : simplices) {
        auto& nodes = run.nodes.emplace_back();
        for (std::size_t v = 0; v <= K; ++v) nodes[v] = simplex[v].value;
    }
    return run;
}

template <int D>
FilePart<D, 1> file_part(ShapeRun<D> run) {
    FilePart<D, 1> part;
    part.vertices = {run.first_vertex, std::move(run.points), std::move(run.point_references)};
    part.elements = simplex_run<D>(run.first_element, run.elements, std::move(run.materials));
    part.facets = simplex_run<D - 1>(run.first_facet, run.facets, std::move(run.facet_references));
    return part;
}

/// The rows of a shape that a rank writes, in turns.
template <int D>
class OwnRows {
  public:
    OwnRows(const ShapeRows<D>& shape, const LinearMesh<D>& lists, const Ranks& ranks)
        : shape_(shape), lists_(lists), is_first_(ranks.rank() == 0) {
        const std::size_t rows = shape.rows(), n = ranks.size();
        begin_ = rows * ranks.rank() / n;
        end_ = rows * (ranks.rank() + 1) / n;
        const std::size_t most = (rows + n - 1) / n, of_row = shape.counts().elements / rows;
        const std::size_t in_turn = std::max(least_rows_of_turn, elements_of_turn / of_row);
        turns_ = (most + in_turn - 1) / in_turn;
    }

    /// As many on each rank.
    [[nodiscard]] std::size_t turns() const { return turns_; }
    /// Edges, which are few, go along with the first rows.
    [[nodiscard]] Outcome<FilePart<D, 1>> part(std::size_t turn, const Execution& execution) const {
        const std::size_t own = end_ - begin_;
        auto run = shape_.run(begin_ + own * turn / turns_, begin_ + own * (turn + 1) / turns_, execution);
        if (!run) return fail(run.error());
        FilePart<D, 1> part = file_part<D>(std::move(*run));
        if constexpr (D == 3)
            if (turn == 0 && is_first_) {
                Buffer<Reference> references(lists_.edges.references.begin(), lists_.edges.references.end());
                part.edges = simplex_run<1>(0, lists_.edges.vertices, std::move(references));
            }
        return part;
    }

  private:
    const ShapeRows<D>& shape_;
    const LinearMesh<D>& lists_;
    bool is_first_;
    std::size_t begin_ = 0, end_ = 0, turns_ = 0;
};

template <int D>
Outcome<run::PlanSize> write_rows(Ranks& ranks, const ShapeRows<D>& shape, const std::string& path,
                                  const Execution& execution) {
    const auto lists = shape.lists();
    if (!lists) return fail(lists.error());
    const ShapeCounts counts = shape.counts();
    const PartTotals totals{
        .vertices = counts.vertices, .elements = counts.elements, .facets = counts.facets, .edges = counts.edges};
    const OwnRows<D> own(shape, *lists, ranks);
    const Execution quiet = without_progress(execution);
    auto done = write_meshb_together<D, 1>(
        ranks, path, totals, *lists, own.turns(), [&](std::size_t turn) { return own.part(turn, quiet); }, execution);
    if (!done) return fail(done.error());
    run::PlanSize size;
    size.dimension = D;
    size.degree = 1;
    size.vertices = counts.vertices;
    size.elements = counts.elements;
    size.facets = counts.facets;
    return size;
}

}  // namespace

Outcome<Done> check_goes_by_rows(const config::Shape& shape) {
    return std::visit(
        [&]<class Options>(const Options& options) -> Outcome<Done> {
            if constexpr (requires { options.structure; })
                if (options.structure == ShellStructure::prisms) return Done{};
            if constexpr (dimension_of<Options> > 0 && !requires { options.structure; }) return Done{};
            return fail(ErrorKind::unsupported, "is made as a whole, not by rows that several ranks share",
                        config::name_of(shape), {},
                        "--structure prisms of a shell or annulus, a box or a rectangle; or camber on one rank");
        },
        shape);
}

Outcome<run::PlanSize> write_by_rows(Ranks& ranks, const config::Shape& shape, const std::string& path,
                                     const Execution& execution) {
    return std::visit(
        [&]<class Options>(const Options& options) -> Outcome<run::PlanSize> {
            if constexpr (dimension_of<Options> == 0)
                return fail(ErrorKind::internal, "a shape without rows");
            else {
                const auto rows = rows_of_shape(options, execution);
                if (!rows) return fail(rows.error());
                return write_rows<dimension_of<Options>>(ranks, **rows, path, execution);
            }
        },
        shape);
}

}  // namespace camber::app

module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
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

/// A shape's rows as the pieces of a file.
template <int D>
class RowsFile {
  public:
    static Outcome<RowsFile> make(const ShapeRows<D>& shape, const Ranks& ranks) {
        auto lists = shape.lists();
        if (!lists) return fail(lists.error());
        const ShapeCounts counts = shape.counts();
        const auto frame = gmf_frame<D, 1>(
            {.vertices = counts.vertices, .elements = counts.elements, .facets = counts.facets, .edges = counts.edges},
            *lists);
        if (!frame) return fail(frame.error());
        return RowsFile(shape, ranks, std::move(*lists), *frame);
    }

    [[nodiscard]] std::uint64_t bytes() const { return frame_.bytes; }
    /// As many on each rank.
    [[nodiscard]] std::size_t turns() const {
        const std::size_t most = (shape_->rows() + ranks_->size() - 1) / ranks_->size();
        const std::size_t of_row = shape_->counts().elements / shape_->rows();
        const std::size_t rows = std::max(least_rows_of_turn, elements_of_turn / of_row);
        return (most + rows - 1) / rows;
    }
    [[nodiscard]] Outcome<std::vector<FilePiece>> pieces(std::size_t turn, const Execution& execution) const {
        const std::size_t rows = shape_->rows(), n = ranks_->size(), r = ranks_->rank();
        const std::size_t begin = rows * r / n, own = rows * (r + 1) / n - begin;
        auto run = shape_->run(begin + own * turn / turns(), begin + own * (turn + 1) / turns(), execution);
        if (!run) return fail(run.error());
        FilePart<D, 1> part = file_part<D>(std::move(*run));
        const bool is_first = turn == 0 && r == 0;
        if constexpr (D == 3)
            if (is_first) {
                Buffer<Reference> references(lists_.edges.references.begin(), lists_.edges.references.end());
                part.edges = simplex_run<1>(0, lists_.edges.vertices, std::move(references));
            }
        auto pieces = encode_gmf_part<D, 1>(frame_, part, execution);
        if (!pieces || !is_first) return pieces;
        auto rest = encode_gmf_frame<D, 1>(frame_, lists_, execution);
        if (!rest) return rest;
        std::ranges::move(*rest, std::back_inserter(*pieces));
        return pieces;
    }

  private:
    RowsFile(const ShapeRows<D>& shape, const Ranks& ranks, LinearMesh<D> lists, const GmfFrame& frame)
        : shape_(&shape), ranks_(&ranks), lists_(std::move(lists)), frame_(frame) {}

    const ShapeRows<D>* shape_;
    const Ranks* ranks_;
    LinearMesh<D> lists_;
    GmfFrame frame_;
};

template <int D>
Outcome<run::PlanSize> write_rows(Ranks& ranks, const ShapeRows<D>& shape, const std::string& path,
                                  const Execution& execution) {
    const auto file = RowsFile<D>::make(shape, ranks);
    if (!file) return fail(file.error());
    const Execution quiet = without_progress(execution);
    auto done = write_together(
        ranks, path, file->bytes(), file->turns(), [&](std::size_t turn) { return file->pieces(turn, quiet); },
        execution);
    if (!done) return fail(done.error());
    const ShapeCounts counts = shape.counts();
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

module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>
export module camber.distributed:quadratic_rows;
import camber.core;
import camber.io;
import :ranks;
import :rows;

export namespace camber {

/// Of simplices the nodes of their edges, in the order of `local_edges`, by numbers from 0 on.
template <int K>
using EdgeNodeRows = Buffer<std::array<std::uint64_t, edges_per_simplex<K>>>;

/// The rows of a binary .meshb of degree 2 whose vertices come before the nodes of edges: as rows of a straight mesh,
/// and the nodes beside them. Each call decodes its own rows, see `rows_of_gmf`.
template <int D>
class QuadraticRows final : public MeshRows<D> {
  public:
    /// All ranks call it: each looks through a run of the simplices for where vertices end. Errors, of any rank: input,
    /// unsupported (io:gmf_runs; vertices behind nodes of edges).
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

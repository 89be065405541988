module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
export module camber.shapes:box;
import camber.core;

export namespace camber {

/// An axis-aligned rectangle or box: a lattice of cells cut to simplices along random diagonals, graded and bent by a
/// map of the box to itself that leaves its sides where they are.
/// Facet references: 2i + 1 on the side of low x_i, 2i + 2 on that of high x_i.
template <int D>
struct BoxOptions {
    Vec<D> low{};
    Vec<D> high = [] {
        Vec<D> one;
        for (double& x : one.c) x = 1;
        return one;
    }();
    std::array<int, D> cells = [] {
        std::array<int, D> four{};
        for (int& n : four) n = 4;
        return four;
    }();
    std::array<double, D> grading = [] {
        std::array<double, D> even{};
        for (double& ratio : even) ratio = 1;
        return even;
    }();  ///< of each axis: the last cell's length over the first's, a geometric series
    double warp = 0;         ///< x_i moves by warp (high_i − low_i) ∏ sin(2π u_j), u the place in the unit box
    double jitter = 0.2;     ///< largest move of a vertex along each axis, in cell sizes; on a side it stays there
    std::uint64_t seed = 1;  ///< of diagonals and jitter

    [[nodiscard]] static constexpr auto options() {
        using S = BoxOptions;
        return std::tuple(
            option("low", &S::low, "corner of the least coordinates").unit("model units"),
            option("high", &S::high, "corner of the largest coordinates").unit("model units"),
            option("cells", &S::cells, "cells along each axis").at_least(1),
            option("grading", &S::grading,
                   "the last cell's length over the first's along each axis, a geometric series in between")
                .at_least(1e-6)
                .at_most(1e6),
            option("warp", &S::warp,
                   "bends the inside: each coordinate moves by this times the product of the sines of once around "
                   "along each axis")
                .unit("lengths of the box along its axis")
                .at_least(-0.05)
                .at_most(0.05),
            option("jitter", &S::jitter, "largest random move of a vertex along each axis")
                .unit("cell sizes")
                .at_least(0)
                .at_most(0.5),
            option("seed", &S::seed, "another seed, another mesh of the same kind; the same seed, the same bytes"));
    }
    friend bool operator==(const BoxOptions&, const BoxOptions&) = default;
};

/// Errors: usage (no cells, high not above low); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> generate(const BoxOptions<D>& options, const Execution& execution = {});

/// The lattice of a box before jitter: vertex (i, j, k) is i + (n_x + 1) (j + (n_y + 1) k).
template <int D>
struct Lattice {
    std::array<int, D> cells{};
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D>> elements;

    /// The vertex's place along each axis, 0 … cells.
    [[nodiscard]] std::array<int, D> place(std::size_t vertex) const {
        std::array<int, D> at{};
        for (int i = 0; i < D; ++i) {
            at[i] = static_cast<int>(vertex % (cells[i] + 1));
            vertex /= cells[i] + 1;
        }
        return at;
    }
    [[nodiscard]] bool on_boundary(std::size_t vertex) const {
        const auto at = place(vertex);
        for (int i = 0; i < D; ++i)
            if (at[i] == 0 || at[i] == cells[i]) return true;
        return false;
    }
    /// Returns the reference of a boundary facet: 2i + 1 on the side of low x_i, 2i + 2 on that of high x_i.
    [[nodiscard]] Reference side(const SimplexVertices<D - 1>& facet) const {
        for (int i = 0; i < D; ++i)
            for (const int end : {0, cells[i]}) {
                bool all = true;
                for (const VertexId v : facet) all = all && place(v.index())[i] == end;
                if (all) return 2 * i + (end == 0 ? 1 : 2);
            }
        return 0;
    }
};

/// The unit box in `cells` equal cells. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Lattice<D>> lattice_of(const std::array<int, D>& cells, std::uint64_t seed,
                                             const Execution& execution);

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad:parts;
import camber.core;
import camber.box_tree;
import :association;
import :model;

namespace camber {

/// A piece of a face's or an edge's parameters: of an edge the first alone.
struct Cell {
    std::array<double, 2> low{}, high{};
};

/// The pieces of one entity, and boxes that hold what lies on them.
struct Cells {
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    BoxTree<3> tree;
    Box<3> bounds;  ///< of samples
    Box<3> reach;   ///< beyond all of it
};

struct CadParts {
    std::unique_ptr<const occ::Kernel> kernel;
    std::vector<Cells> faces, edges;
    Box<3> bounds;  ///< of the faces; of the edges where there is none
    Box<3> of_edges;
    double size = 0;  ///< the diagonal of the bounds
};

[[nodiscard]] Cells cells_of_face(const occ::Kernel& kernel, std::size_t face);
[[nodiscard]] Cells cells_of_edge(const occ::Kernel& kernel, std::size_t edge);

/// A kernel, or why there is none.
[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format format,
                                                                      double millimetres);

[[nodiscard]] Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string& bytes, double millimetres);

[[nodiscard]] inline Vec<3> vec(const occ::Point& p) { return {p}; }

/// A face fits nearly as well as the best one if its misfit is at most so many times that of the best.
inline constexpr double doubt = 2;

/// A place farther away than this share of the facets' size is none.
inline constexpr double near_enough = 0.1;

/// A vertex farther away than so many of the longest edge around is not on the model; one nearer may be so since the
/// mesh leaves out fillets that the model has.
inline constexpr double astray = 1;

/// Points at most so far apart are one: so well do edges and faces of a model fit each other.
[[nodiscard]] inline double at_one_place(const CadParts& parts) { return 1e-6 * parts.size; }

/// See associate: before faces are known, by some facets of each reference; and after, by all vertices.
template <int D>
[[nodiscard]] Outcome<Done> check_sample(const LinearMesh<D>& mesh, const CadModel& model,
                                         std::span<const std::size_t> candidates, std::span<const Reference> elsewhere,
                                         const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> check_part(const LinearMesh<D>& mesh, const CadModel& model,
                                       const CadAssociation& association);

template <int D, std::size_t N>
[[nodiscard]] double longest_side(const std::array<Vec<D>, N>& facet) {
    double longest = 0;
    for (std::size_t i = 0; i < N; ++i) longest = std::max(longest, distance(facet[i], facet[(i + 1) % N]));
    return longest;
}

/// Distances that rounding alone makes.
[[nodiscard]] inline double rounding(const CadParts& parts, const Vec<3>& p) { return 1e-15 * (parts.size + norm(p)); }

}  // namespace camber

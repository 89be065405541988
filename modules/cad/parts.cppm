module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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

/// A box along three orthonormal axes.
struct OrientedBox {
    Vec<3> centre;
    std::array<Vec<3>, 3> axes{};
    std::array<double, 3> half{};  ///< half of its length along each axis

    [[nodiscard]] double distance_squared(const Vec<3>& p) const {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double beyond = std::abs(dot(p - centre, axes[k])) - half[k];
            if (beyond > 0) sum += beyond * beyond;
        }
        return sum;
    }
};

/// The pieces of one entity, and boxes that hold what lies on them.
struct Cells {
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    std::vector<OrientedBox> oriented;  ///< of a face, along its tangent plane: tighter for thin cells askew
    BoxTree<3> tree;
    Box<3> bounds;  ///< of samples
    Box<3> reach;   ///< beyond all of it
};

/// Groups of faces (in a plane: of edges) that meet smoothly: one virtual face each.
struct VirtualFaces {
    std::vector<std::uint32_t> groups;             ///< of each face, the number of the lowest face of its group
    std::vector<std::vector<std::size_t>> beside;  ///< of each face those that it meets smoothly, rising

    [[nodiscard]] bool are_joined(std::size_t a, std::size_t b) const { return groups[a] == groups[b]; }
};

struct CadParts {
    std::unique_ptr<const occ::Kernel> kernel;
    std::vector<Cells> faces, edges;
    BoxTree<3> tree_of_faces;  ///< over their `reach`
    VirtualFaces virtual_faces, virtual_curves;
    Box<3> bounds;  ///< of the faces; of the edges where there is none
    Box<3> of_edges;
    double size = 0;  ///< the diagonal of the bounds
};

/// Lower bound of the distance from p to a face, by the boxes of its cells.
[[nodiscard]] double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p);

/// How far points are from a face: a search starts at the parameters of the nearest of the last points, so that
/// consecutive points should be neighbours. Distances are those of closest_on_face up to rounding.
class FaceWalk {
  public:
    /// `start`: parameters of a point of the face that is not far from the first one; null: not known.
    FaceWalk(const CadModel& model, std::size_t face, const std::array<double, 2>* start);

    [[nodiscard]] double distance(const Vec<3>& p);
    /// Whether p is farther away than a bound: its distance then. Nothing where some point of the face is near enough,
    /// which costs no search as a rule.
    [[nodiscard]] std::optional<double> distance_beyond(double bound, const Vec<3>& p);
    /// Number of searches of distance_beyond.
    [[nodiscard]] std::size_t searches() const { return searches_; }

  private:
    struct Place {
        Vec<3> from;  ///< the point whose foot is there
        std::array<double, 2> uv{};
        occ::SurfaceJet jet{};
    };
    [[nodiscard]] bool is_surface_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool is_face_within(double bound, const Vec<3>& p, const std::array<double, 2>& uv);
    [[nodiscard]] bool is_edge_within(double bound, const Vec<3>& p);
    [[nodiscard]] bool leads_within(double bound, const Vec<3>& p);
    void go_near(const Vec<3>& p);
    void remember(const Place& place);
    [[nodiscard]] Place place_at(const Vec<3>& from, const std::array<double, 2>& uv) const;

    const CadModel* model_;
    std::size_t face_;
    std::optional<Place> last_, first_of_row_;
    std::optional<std::size_t> edge_;  ///< on which the search for the last point that is not on the face ended
    double on_edge_ = 0;
    std::size_t searches_ = 0;
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

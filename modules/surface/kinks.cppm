module;
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>
module camber.surface:kinks;
import camber.core;
import camber.bezier;
import :features;

namespace camber {

/// By how much a patch turns between its facets: angles in radians, at three places of each edge between two of its
/// facets (2D: at each vertex).
struct Kinks {
    double squares = 0, largest = 0;
    std::size_t count = 0;

    void add(double angle) {
        squares += angle * angle;
        largest = std::fmax(largest, angle);
        ++count;
    }
    void add(const Kinks& other) {
        squares += other.squares;
        largest = std::fmax(largest, other.largest);
        count += other.count;
    }
    [[nodiscard]] double root_mean_square() const {
        return count == 0 ? 0 : std::sqrt(squares / static_cast<double>(count));
    }
};

/// The unit normal of a facet at a place of it.
template <int D>
using NormalOfFacet = std::function<Vec<D>(FacetId, const Barycentric<D - 1>&)>;

/// Of each patch. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<Kinks>> kinks_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const Features<D>& features, const NormalOfFacet<D>& normal,
                                                   const Execution& execution);

}  // namespace camber

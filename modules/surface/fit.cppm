module;
#include <cstddef>
#include <optional>
export module camber.surface:fit;
import camber.core;

export namespace camber {

/// How far a vertex may be from its facet's surface, as a share of the facet's longest edge.
inline constexpr double fit_tolerance = 0.1;

/// A vertex that is farther than that.
struct Misfit {
    double distance = 0, allowed = 0;
    VertexId vertex = {};
    Reference reference = 0;
};
/// The farther one; of equally far ones the first, whatever the order in which they are met.
[[nodiscard]] inline Misfit worse(const Misfit& a, const Misfit& b) {
    if (a.distance != b.distance) return a.distance > b.distance ? a : b;
    return b.distance > 0 && b.vertex < a.vertex ? b : a;
}

/// Whether facets lie on the surface that they are said to lie on. Another surface, another place or another unit is
/// that of nearly all of them. A mesh that was adapted to thin layers may have left single vertices short of the
/// surface: so those of one facet in a hundred may be beyond the tolerance, but by less than half of their edges.
struct BoundaryFit {
    std::size_t facets = 0, off = 0;
    Misfit worst;

    /// One more facet; a misfit of no distance: on the surface.
    void add(const Misfit& misfit) {
        ++facets;
        off += misfit.distance > 0 ? 1 : 0;
        worst = worse(worst, misfit);
    }
    void add(const BoundaryFit& others) {
        facets += others.facets;
        off += others.off;
        worst = worse(worst, others.worst);
    }
    /// The worst one, where there are too many of them or it is too far.
    [[nodiscard]] std::optional<Misfit> refused() const {
        constexpr std::size_t most = 100;
        constexpr double farthest = 0.5 / fit_tolerance;
        if (off * most <= facets && !(worst.distance > farthest * worst.allowed)) return {};
        return worst;
    }
};

}  // namespace camber

module;
#include <array>
#include <cstddef>
#include <span>
export module camber.adapt:straight_swaps;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

export namespace camber {

/// What swaps inside of a straight mesh of tetrahedra make: shapes (metric_shape) as ConeShapes has them, in a fraction
/// of its time, since all that is around an edge is found in one walk. Here: the elements around an edge inside, of
/// either degree, and the vertices around it.
class EdgeRing {
  public:
    enum class Walk {
        closed,
        open,   ///< it ends at a facet, or is longer than there is room for
        worse,  ///< an element on it has a worse shape than the one where it began
    };
    /// `shapes`: of all elements.
    [[nodiscard]] Walk walk(const DynamicMesh<3>& mesh, std::span<const double> shapes, ElementId e, int local_edge);
    /// Of a straight mesh: the vertex around the edge to which the elements, joined to it in place of the edge, have
    /// the best worst shape, if that is above `least`.
    struct Best {
        VertexId point;
        double worst = 0;
    };
    [[nodiscard]] Best best(const Adaptation<3>& r, double least) const;
    [[nodiscard]] std::span<const ElementId> elements() const { return std::span(elements_).first(count_); }
    [[nodiscard]] std::span<const VertexId> around() const { return std::span(around_).first(count_); }
    [[nodiscard]] std::array<VertexId, 2> ends() const { return {a_, b_}; }

    static constexpr std::size_t most = 12;  ///< elements

  private:
    struct Measured;
    std::array<ElementId, most> elements_;  ///< the i-th between the i-th vertex and the next
    std::array<VertexId, most> around_;
    std::size_t count_ = 0;
    VertexId a_, b_;  ///< of the edge: (a, b, i-th vertex, next) is the right way round
};

/// The worst shape of the three elements that two without their face, joined by an edge between the vertices opposite
/// it, make, if that is above `least`; otherwise something that is not. `other`: across `face` of e.
[[nodiscard]] double worst_without_face(const Adaptation<3>& r, ElementId e, int face, ElementId other, double least);

}  // namespace camber

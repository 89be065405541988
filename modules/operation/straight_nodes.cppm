module;
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>
module camber.operation:straight_nodes;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import :heights;
import :measures;
import :operate;
import :quality_bar;
import :request;
import :star_judge;
import :state;

/// The star of degree 1 (paper §1.3): it has no nodes, and nothing that could go elsewhere.
namespace camber {

/// The corners of a new element.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> corners_of(const Adaptation<D>& r, const ElementFace& open,
                                                   const Vec<D>& place) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i)
        p[i] = i == static_cast<int>(open.opposite) ? place : r.mesh.points[r.mesh.elements.vertices[open.element][i]];
    return p;
}

template <int D>
class StraightNodes {
  public:
    StraightNodes(const Adaptation<D>& r, const AdaptationGoal<D>&, const CavityRequest<D>& request, const PatchLimits&,
                  OperationWorkspace<D>&, Patch<D>& patch, QualityBar<D>&)
        : r_(r), request_(request), star_(patch.star) {}

    static constexpr int degree = 1;
    static constexpr bool is_judged_by_element = true;  ///< shapes cost more than signs of volumes

    void place_inner() {}
    [[nodiscard]] bool place_others() { return false; }
    [[nodiscard]] bool is_placed(std::size_t) const { return true; }
    [[nodiscard]] double length_to(std::size_t i) const {
        const VertexId v = star_.boundary[i];
        if (r_.mesh.is_at_infinity(v)) return length_to_infinity;
        return edge_length(request_.metric.measure, r_.vertices.metrics[v].measure, r_.mesh.points[v] - request_.place);
    }
    void begin_elements() {}
    void judge_elements() {}
    /// The sign of the volume is exact. Of a surface alone triangles have none: which way they look is judged with the
    /// facets (Operating::judge_facets).
    [[nodiscard]] ElementState element(std::size_t joined) const {
        const ElementFace& open = star_.joined[joined];
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) return triangle(open);
        const auto corners = corners_of(r_, open, request_.place);
        if (!(signed_volume<D>(corners) > 0)) return {};
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = corners[i + 1] - corners[0];
        if (!is_above_rounding<D>(std::abs(det(sides)), corners)) return {true, true, 0, false};
        return {true, false,
                shape_with(r_, open.element, static_cast<int>(open.opposite), request_.place, request_.metric.measure),
                false};
    }
    [[nodiscard]] bool correct(RejectionReason) { return false; }
    void approach() {}
    void give(Patch<D>&) const {}
    [[nodiscard]] int programmes() const { return 0; }
    [[nodiscard]] bool has_drawn_back() const { return false; }

  private:
    [[nodiscard]] ElementState triangle(const ElementFace& open) const
        requires(D == 3)
    {
        const auto [a, b, c, infinity] = corners_of(r_, open, request_.place);
        if (is_flat(std::array{a, b, c})) return {true, true, 0, false};
        return {true, false,
                shape_with(r_, open.element, static_cast<int>(open.opposite), request_.place, request_.metric.measure),
                false};
    }

    const Adaptation<D>& r_;
    const CavityRequest<D>& request_;
    const Star<D>& star_;
};

}  // namespace camber

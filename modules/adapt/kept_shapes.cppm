module;
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
module camber.adapt:kept_shapes;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

/// The shape of each element of a mesh that changes. Taken from the state, measured where it is not known there, and
/// given back for the next pass.
template <int D>
class KeptShapes {
  public:
    [[nodiscard]] static Outcome<KeptShapes> taken_from(Adaptation<D>& r, const Execution& execution) {
        KeptShapes kept;
        kept.shapes_ = take(std::exchange(r.shapes, {}));
        kept.shapes_.resize(r.mesh.elements.size(), -1.0);
        auto measured = each(execution, kept.shapes_.size(), [&](std::size_t e) {
            if (!r.mesh.is_free(ElementId(e)) && kept.shapes_[e] < 0) kept.shapes_[e] = shape_of(r, ElementId(e));
        });
        if (!measured) return fail(measured.error());
        return kept;
    }
    void give_to(Adaptation<D>& r) && { r.shapes = std::move(shapes_); }
    void follow(const Adaptation<D>& r, const TopologyChanges& changes) {
        shapes_.resize(r.mesh.elements.size());
        for (const ElementId e : changes.elements.created)
            if (!r.mesh.is_free(e)) shapes_[e.index()] = shape_of(r, e);
    }
    [[nodiscard]] double operator[](ElementId e) const { return shapes_[e.index()]; }
    [[nodiscard]] std::span<const double> all() const { return shapes_; }
    [[nodiscard]] double worst(std::span<const ElementId> elements) const {
        double worst = std::numeric_limits<double>::infinity();
        for (const ElementId e : elements) worst = std::min(worst, shapes_[e.index()]);
        return worst;
    }

  private:
    Buffer<double> shapes_;
};

}  // namespace camber

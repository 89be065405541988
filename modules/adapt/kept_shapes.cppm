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

/// The shape of each element of a mesh that changes.
template <int D>
class KeptShapes {
  public:
    [[nodiscard]] static Outcome<KeptShapes> of(const Adaptation<D>& r, const Execution& execution) {
        auto shapes = map_each(execution, r.mesh.elements.size(), [&](std::size_t e) {
            return r.mesh.is_free(ElementId(e)) ? 0.0 : shape_of(r, ElementId(e));
        });
        if (!shapes) return fail(shapes.error());
        KeptShapes kept;
        kept.shapes_ = std::move(*shapes);
        return kept;
    }
    void follow(const Adaptation<D>& r, const TopologyChanges& changes) {
        shapes_.resize(r.mesh.elements.size());
        for (const ElementId e : changes.elements.created)
            if (!r.mesh.is_free(e)) shapes_[e.index()] = shape_of(r, e);
    }
    [[nodiscard]] double operator[](ElementId e) const { return shapes_[e.index()]; }
    [[nodiscard]] double worst(std::span<const ElementId> elements) const {
        double worst = std::numeric_limits<double>::infinity();
        for (const ElementId e : elements) worst = std::min(worst, shapes_[e.index()]);
        return worst;
    }

  private:
    Buffer<double> shapes_;
};

}  // namespace camber

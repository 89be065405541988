module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
export module camber.adapt:cone_shapes;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

export namespace camber {

/// Shapes of the simplices that faces make with one point. What the faces share is looked up and measured once, so each
/// further place costs little more than the volumes, and the lengths to it of those vertices that are asked for. The
/// faces are those of elements, the point comes to the place of the vertex opposite. See metric_shape.
template <int D>
class ConeShapes {
  public:
    explicit ConeShapes(const Adaptation<D>& r) : r_(r) {}

    void clear() {
        faces_.clear();
        vertices_.clear();
    }
    void add(ElementId e, int opposite) {
        Face face;
        const auto outward = face_opposite<D>(opposite);
        for (int i = 0; i < D; ++i) face.corners[i] = index_of(r_.mesh.elements.vertices[e][outward[i]]);
        faces_.push_back(face);
    }

    /// A vertex of the faces, and how many of them have it.
    struct Corner {
        VertexId vertex;
        std::uint32_t faces = 0;
        Vec<D> place;
        const MeasuringMetric<D>* metric = nullptr;
    };
    [[nodiscard]] std::span<const Corner> vertices() const { return vertices_; }

    /// The worst shape, where that is above `least`; otherwise something that is not. Faces that hold `without` do not
    /// count; 0 where none does.
    [[nodiscard]] double worst(const Vec<D>& place, const MeasuringMetric<D>& metric, double least,
                               VertexId without = {}) {
        // Volumes first: they are cheap, and most bad places are so by them.
        for (Face& face : faces_) {
            face.counts = !holds(face, without);
            if (!face.counts) continue;
            Mat<D> sides;
            for (int i = 0; i < D; ++i) sides.column[i] = vertices_[face.corners[i]].place - place;
            face.measure = det(sides);
            if (!(face.measure > 0) && least >= 0) return 0;
        }
        to_point_.assign(vertices_.size(), unknown);
        double worst = std::numeric_limits<double>::infinity();
        for (Face& face : faces_) {
            if (!face.counts) continue;
            worst = std::min(worst, shape(face, place, metric));
            if (!(worst > least)) return worst;
        }
        return worst < std::numeric_limits<double>::infinity() ? worst : 0;  // nothing would be left
    }

  private:
    static constexpr double unknown = -1;
    struct Face {
        std::array<std::uint32_t, D> corners{};  ///< of `vertices_`, outward
        double squares = unknown;                ///< of its edges, in the metrics of both ends
        double measure = 0;
        bool counts = true;
    };

    std::uint32_t index_of(VertexId v) {
        for (std::uint32_t i = 0; i < vertices_.size(); ++i)
            if (vertices_[i].vertex == v) {
                ++vertices_[i].faces;
                return i;
            }
        vertices_.push_back({v, 1, r_.mesh.points[v], &r_.vertices.metrics[v].measure});
        return static_cast<std::uint32_t>(vertices_.size() - 1);
    }
    [[nodiscard]] bool holds(const Face& face, VertexId v) const {
        bool found = false;
        for (const std::uint32_t c : face.corners) found |= vertices_[c].vertex == v;
        return found;
    }
    [[nodiscard]] double squares_of(Face& face) const {
        if (face.squares != unknown) return face.squares;
        face.squares = 0;
        for (const auto& [a, b] : local_edges<D - 1>) {
            const Corner& p = vertices_[face.corners[a]];
            const Corner& q = vertices_[face.corners[b]];
            const Vec<D> edge = q.place - p.place;
            face.squares += p.metric->length_squared(edge) + q.metric->length_squared(edge);
        }
        return face.squares;
    }
    [[nodiscard]] double shape(Face& face, const Vec<D>& place, const MeasuringMetric<D>& metric) {
        double squares = squares_of(face);
        double density = metric.density_root;
        for (const std::uint32_t c : face.corners) {
            const Corner& corner = vertices_[c];
            density *= corner.metric->density_root;
            if (to_point_[c] == unknown) {
                const Vec<D> edge = place - corner.place;
                to_point_[c] = metric.length_squared(edge) + corner.metric->length_squared(edge);
            }
            squares += to_point_[c];
        }
        squares /= 2;
        if (!(squares > 0)) return 0;
        if constexpr (D == 2) return 2 * std::sqrt(3.0) * face.measure * density / squares;
        return 6 * std::sqrt(12.0) * face.measure * density / (squares * std::sqrt(squares));
    }

    const Adaptation<D>& r_;
    std::vector<Face> faces_;
    std::vector<Corner> vertices_;
    std::vector<double> to_point_;
};

}  // namespace camber

module;
#include <array>
#include <cstddef>
#include <span>
export module camber.adapt:bent_swaps;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import :straight_swaps;

export namespace camber {

/// A swap inside of a mesh of degree 2: the worst shape (bent_shape) of its elements before and after.
struct BentSwap {
    VertexId point;    ///< invalid: none
    ElementId beside;  ///< of a face: the element across
    double before = 0, after = 0;
};

/// A few vertices and the curves between them, each measured once: the edges that there are as they are, new ones as
/// the closed form of accuracy bends them, which is what the star takes for their nodes (bent_edges).
class BentEdges {
  public:
    BentEdges(const Adaptation<3>& r, const AdaptationGoal<3>& goal) : r_(r), goal_(goal) {}

    /// At most `most` in all; numbered from 0.
    std::size_t add(VertexId v);
    [[nodiscard]] VertexId vertex(std::size_t i) const { return vertices_[i].id; }
    /// The edges of an element among them.
    void take_edges(ElementId e);
    /// One of them.
    void take_edge(ElementId e, std::size_t i, std::size_t j);
    /// Asks for a new edge, which is known after `bend`: at most as many as a ring may have between its vertices.
    void ask(std::size_t i, std::size_t j);
    void bend();
    /// Of the edge from one towards the other, as long as its chord.
    [[nodiscard]] Vec<3> tangent(std::size_t i, std::size_t j) const;
    /// Of a tetrahedron of them, in the order of one that is the right way round.
    [[nodiscard]] double shape(const std::array<std::size_t, 4>& corners) const;

    static constexpr std::size_t most = EdgeRing::most + 2;

  private:
    struct Vertex {
        VertexId id;
        Vec<3> place;
        const VertexMetric<3>* metric = nullptr;
    };
    struct Edge {
        Vec<3> offset;
        double squares = 0;  ///< twice its squared length
    };
    void put(std::size_t i, std::size_t j, const Edge& edge) { edges_[i][j] = edges_[j][i] = edge; }

    const Adaptation<3>& r_;
    const AdaptationGoal<3>& goal_;
    std::size_t count_ = 0, asked_ = 0;
    std::array<Vertex, most> vertices_;
    std::array<std::array<Edge, most>, most> edges_;
    static constexpr std::size_t most_asked = EdgeRing::most * (EdgeRing::most - 3) / 2;  ///< new ones of a ring
    std::array<std::array<std::size_t, 2>, most_asked> pairs_{};
    std::array<Vec<3>, most_asked> chords_, offsets_;
    std::array<EndSights<3>, most_asked> ends_;
    std::array<double, most_asked> lengths_{};
};

/// The vertex around an edge inside to which the elements of its ring, joined to it in place of the edge, have the best
/// worst shape, where that is above `gain` times what it was.
[[nodiscard]] BentSwap best_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const EdgeRing& ring,
                                        double gain);

/// The best of these faces of an element to be taken away, where its two elements become three around an edge between
/// the vertices opposite it; likewise.
[[nodiscard]] BentSwap best_without_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e,
                                         std::span<const int> faces, double gain);

}  // namespace camber

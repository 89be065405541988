module;
#include <cstdint>
export module camber.metric:edge_objective;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_length;
import :quadrature;

export namespace camber {

/// What an edge's node minimises. Length does not change under reparametrisation, so its Hessian is singular along the
/// edge and a quadrature rule turns that into false minima; the energy ∫ l'ᵀ M l' dt has the same curves as minimisers,
/// at constant speed, and a regular Hessian.
enum class EdgeObjectiveKind : std::uint8_t { energy, length };
[[nodiscard]] constexpr auto words(EdgeObjectiveKind) {
    return words_of(Word{EdgeObjectiveKind::energy, "energy"}, Word{EdgeObjectiveKind::length, "length"});
}

/// Which field the objective sees along the edge.
enum class EdgeFieldKind : std::uint8_t {
    back,  ///< the back mesh's at each quadrature point: the true field
    edge,  ///< the quadratic through the three nodes' log-metrics (paper §2.2.1, eq. 7)
};
[[nodiscard]] constexpr auto words(EdgeFieldKind) {
    return words_of(Word{EdgeFieldKind::back, "back"}, Word{EdgeFieldKind::edge, "edge"});
}

/// The objective at one node.
template <int D>
struct ObjectiveSample {
    double value = 0;
    Vec<D> gradient;  ///< with respect to P^l, in physical coordinates
    Sym<D> hessian;   ///< the SPD model: second derivative with the metric frozen (energy), or its Gauss–Newton kin
                      ///< (length)
};

/// One edge's objective as a function of its mid node.
template <int D>
struct EdgeObjective {
    const BackMesh<D>* back = nullptr;
    const Quadrature* rule = nullptr;
    EdgeObjectiveKind kind = EdgeObjectiveKind::energy;
    EdgeFieldKind field = EdgeFieldKind::back;
    Vec<D> p20, p02;
    LogMetric<D> l20, l02;  ///< at the ends; used by EdgeFieldKind::edge only
    ElementId hint;

    [[nodiscard]] double value(const Vec<D>& node) const;
    /// Value, exact gradient wherever no sample lies on a face of the back mesh, and the Hessian model. One
    /// decomposition a quadrature point.
    [[nodiscard]] ObjectiveSample<D> evaluate(const Vec<D>& node) const;
};

/// The objective of the edge from p20 to p02; the ends are located from `hint`. It refers to `back` and `rule`, which
/// must outlive it.
template <int D>
[[nodiscard]] EdgeObjective<D> edge_objective(const BackMesh<D>& back, const Quadrature& rule, EdgeObjectiveKind kind,
                                              EdgeFieldKind field, const Vec<D>& p20, const Vec<D>& p02,
                                              ElementId hint);

}  // namespace camber

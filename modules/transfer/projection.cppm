module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.transfer:projection;
import camber.core;
import camber.bezier;
import camber.metric;
import :materials;
import :transferred;

namespace camber {

/// A place in the old mesh: an element of it and ξ there.
template <int D>
struct OldPlace {
    std::uint32_t element = none;
    Barycentric<D> xi{};
    Placement placement = Placement::inside;
    double distance = 0;  ///< of the point from that place, where it is outside
};

/// The old mesh, and its parts of one material each, with what location in them needs. A point beyond a part is
/// answered by the nearest point of the part's boundary.
template <int D>
class Sources {
  public:
    /// Of the materials that `is_asked`.
    [[nodiscard]] static Outcome<Sources> make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                               const std::vector<std::uint8_t>& is_asked, const Execution& execution);

    /// The place of a point, as one of that material sees it. `hint`: an old element near it, or `none`.
    [[nodiscard]] OldPlace<D> find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const;

    /// The old element across a face of one, as that material sees it; `none` at its boundary.
    [[nodiscard]] std::uint32_t across(std::size_t material, std::uint32_t element, std::size_t opposite) const;

  private:
    struct Part {
        CurvedLocator<D> locator;
        Column<std::uint32_t> elements;  ///< their numbers in the old mesh; empty: all, with their own
    };
    Outcome<Done> add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                           const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                           const Execution& execution);
    [[nodiscard]] ElementId hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const;

    std::vector<Part> parts_;               ///< of each material; of the rest all elements
    Buffer<std::uint32_t> material_;        ///< of each old element; empty: there is but the rest
    Buffer<std::uint32_t> number_in_part_;  ///< of each old element
};

/// Σ φ_α u_α of a field of degree K in element e of its mesh: one value a component.
template <int D, int K>
void add_field(const QuadraticMesh<D>& mesh, std::size_t e, const std::array<double, field_nodes<D, K>>& phi,
               const double* values, std::span<double> out) {
    const auto nodes = nodes_of<D, K>(mesh, e);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += phi[i] * values[nodes[i] * out.size() + c];
}

/// The fields at the new nodes.
struct Interpolated {
    std::vector<Buffer<double>> values;
    /// Of each new vertex an old element near it, or `none`.
    Buffer<std::uint32_t> near;
    TransferStatistics statistics;  ///< of nodes
};

/// The meshes of a transfer, their materials and common nodes, and the location of points in the old one.
template <int D>
struct TransferMeshes {
    const QuadraticMesh<D>& old_mesh;
    const QuadraticMesh<D>& new_mesh;
    const Materials<D>& materials;
    const Same& same;
    const Sources<D>& sources;
};

/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> interpolate(const TransferMeshes<D>& meshes, std::span<const TransferField> fields,
                                                const Execution& execution);

/// Which materials are asked for by a new mesh: those of its elements, and the rest where a node has no element.
template <int D>
[[nodiscard]] std::vector<std::uint8_t> asked_materials(const QuadraticMesh<D>& new_mesh,
                                                        const Materials<D>& materials);

/// What changed from one mesh to the other: the elements that the other does not have.
struct Changed {
    std::vector<std::uint32_t> new_elements, old_elements;  ///< rising
    Buffer<std::uint32_t> old_slot;                         ///< of each old element: its place there, or `none`
    /// Of the new nodes: whether it is of changed elements alone. All others keep their values.
    Buffer<std::uint8_t> is_free;
};
template <int D>
[[nodiscard]] Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                   const Same& same);

/// Sets that are joined pair by pair.
class JoinedSets {
  public:
    explicit JoinedSets(std::size_t n) : above_(n) { std::iota(above_.begin(), above_.end(), std::uint32_t{0}); }
    void join(std::size_t a, std::size_t b) {
        const std::uint32_t p = lowest(static_cast<std::uint32_t>(a)), q = lowest(static_cast<std::uint32_t>(b));
        above_[p < q ? q : p] = p < q ? p : q;
    }
    /// The lowest of its set.
    [[nodiscard]] std::uint32_t lowest(std::uint32_t i) {
        for (; above_[i] != i; i = above_[i]) above_[i] = above_[above_[i]];
        return i;
    }

  private:
    Buffer<std::uint32_t> above_;
};

/// Connected patches of changed elements, the new ones and the old ones that were there. Elements are connected by an
/// edge, by a node that is of changed elements alone, and where a point of one lies in the other.
template <int D>
class PatchSearch {
  public:
    PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Same& same,
                const Changed& changed);
    /// A point of new element `new_slot` lies in an old element.
    void found(std::size_t new_slot, std::uint32_t old_element) {
        if (const std::uint32_t slot = changed_.old_slot[old_element]; slot != none)
            sets_.join(new_slot, changed_.new_elements.size() + slot);
    }

    /// Patches by their first new element; and groups: the elements of a patch and a material.
    struct Patches {
        std::size_t patches = 0;
        struct Group {
            std::uint32_t patch, material;
            friend auto operator<=>(const Group&, const Group&) = default;
        };
        std::vector<Group> groups;                              ///< rising; of new elements
        std::vector<std::uint32_t> group_of_new, group_of_old;  ///< of each slot; `no_group`: no new element is there
        std::vector<std::uint32_t> first_group;                 ///< of each patch, and the end
    };
    [[nodiscard]] Patches patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                  const Materials<D>& materials);

  private:
    const Changed& changed_;
    JoinedSets sets_;
};

/// The entries i ≥ j of a symmetric matrix of N rows, row after row.
template <int N>
inline constexpr int packed_size = N * (N + 1) / 2;
[[nodiscard]] constexpr int packed_index(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/// ∫ φ_i φ_j |det J| over elements, by a quadrature of which all are sums with positive weights.
template <int D, int K>
class ReferenceMass {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Matrix = std::array<double, packed_size<nodes>>;
    using Functions = std::array<double, nodes>;

    explicit ReferenceMass(int points_a_direction);

    std::vector<RulePoint<D>> rule;
    std::vector<Functions> functions;  ///< φ at the points
    Matrix matrix{};                   ///< of the reference element: that of a straight one by |det J|
    double low = 1, high = 1;          ///< eigenvalues of diag(M)⁻¹ M are between

    /// Of an element that is not straight, with the least and the largest det J at the points.
    struct Curved {
        Matrix matrix{};
        double least = 0, largest = 0;
    };
    [[nodiscard]] Curved curved(const ElementMap<D>& map) const;
    /// Bounds of the eigenvalues of diag(M)⁻¹ M of an element.
    [[nodiscard]] static std::array<double, 2> eigenvalues(const Matrix& matrix);
};

/// The mass matrix of the fields of degree K over some elements of a mesh, for those of their nodes that are free: as
/// the elements' matrices, of which a straight one is a number. It is symmetric positive definite where no element
/// vanishes.
template <int D, int K>
class MassMatrix {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Local = std::array<std::uint32_t, nodes>;

    /// `is_free` of each node of the mesh. Errors: memory, stopped.
    [[nodiscard]] static Outcome<MassMatrix> make(const QuadraticMesh<D>& mesh,
                                                  const std::vector<std::uint32_t>& elements,
                                                  const Buffer<std::uint8_t>& is_free,
                                                  const ReferenceMass<D, K>& reference, const Execution& execution);

    [[nodiscard]] std::size_t size() const { return node_of_.size(); }
    /// The node of each unknown.
    [[nodiscard]] std::span<const std::uint32_t> node_of() const { return node_of_; }
    /// The unknowns of the nodes of element number `slot` of those given; `none` where a node is not free.
    [[nodiscard]] const Local& unknowns(std::size_t slot) const { return unknowns_[slot]; }
    [[nodiscard]] std::size_t turned() const { return turned_; }
    /// ∫ φ_i over element number `slot`: the sums of its matrix's rows, since the φ sum up to 1.
    [[nodiscard]] std::array<double, nodes> integrals(std::size_t slot) const {
        std::array<double, nodes> one{};
        one.fill(1);
        return local_product(slot, one);
    }

    /// Σ over the elements of what `local(slot)` gives for their nodes, at each unknown in the order of the elements.
    template <class LocalOf>
    [[nodiscard]] Outcome<Done> assemble(const LocalOf& local, std::span<double> out, const Execution& execution);

    /// x with M x = r, by Chebyshev's iteration with the diagonal: the eigenvalues of diag(M)⁻¹ M are known beforehand
    /// (Wathen 1987; Wathen and Rees 2009), so it takes no inner products, and what is left of the error is a known
    /// share (10⁻¹⁰) in each patch by itself, of whatever size its elements are. `r` becomes the residual.
    [[nodiscard]] Outcome<Done> solve(std::span<double> r, std::span<double> x, const Execution& execution);

  private:
    void number(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                const Buffer<std::uint8_t>& is_free);
    [[nodiscard]] Outcome<Done> weigh(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                                      const ReferenceMass<D, K>& reference, const Execution& execution);
    [[nodiscard]] std::array<double, nodes> product(std::size_t slot, std::span<const double> x) const;
    [[nodiscard]] std::array<double, nodes> local_product(std::size_t slot, const std::array<double, nodes>& in) const;
    [[nodiscard]] double diagonal(std::size_t slot, int i) const;

    std::vector<std::uint32_t> node_of_;
    Buffer<Local> unknowns_;
    Buffer<double> scales_;            ///< of each element: |det J| where it is straight
    Buffer<std::uint32_t> curved_at_;  ///< of each element: its matrix among those of the curved ones, or `none`
    Buffer<typename ReferenceMass<D, K>::Matrix> curved_;
    std::array<double, nodes * nodes> straight_{};  ///< the reference element's, as a square
    Buffer<std::uint32_t> offsets_, items_;         ///< of each unknown: slot · nodes + local node, rising
    Buffer<double> inverse_diagonal_;
    Buffer<std::array<double, nodes>> products_;
    double low_ = 1, high_ = 1;
    std::size_t turned_ = 0;
};

template <int D, int K>
template <class LocalOf>
Outcome<Done> MassMatrix<D, K>::assemble(const LocalOf& local, std::span<double> out, const Execution& execution) {
    auto done = each(execution, unknowns_.size(), [&](std::size_t slot) { products_[slot] = local(slot); });
    if (!done) return done;
    return each(
        execution, size(),
        [&](std::size_t u) {
            double sum = 0;
            for (std::uint32_t k = offsets_[u]; k < offsets_[u + 1]; ++k)
                sum += products_[items_[k] / nodes][items_[k] % nodes];
            out[u] = sum;
        },
        1024);
}

/// What the projection of one degree works on.
template <int D, int K>
struct Projection {
    Block block;
    ReferenceMass<D, K> reference;
    MassMatrix<D, K> matrix;
    /// The integrals that each group is to have, those of the old field: group after group, all components.
    std::vector<Sum> before;
    Buffer<double> residual;             ///< ∫ φ_i (u_old − u): of each component all unknowns
    Buffer<double> low, high;            ///< where asked for: of each unknown the components' limits
    std::size_t spread = 0, unkept = 0;  ///< see TransferStatistics

    [[nodiscard]] std::span<double> residual_of(std::size_t c) {
        return std::span(residual).subspan(c * matrix.size(), matrix.size());
    }
    /// Adds of each component.
    void add(std::size_t c, std::span<const double> change) {
        for (std::size_t u = 0; u < change.size(); ++u)
            block.values[matrix.node_of()[u] * block.components + c] += change[u];
    }
};

/// What all of a projection reads.
template <int D>
struct TransferScene : TransferMeshes<D> {
    const Changed& changed;
    const Buffer<std::uint32_t>& near;
    const TransferOptions& options;
};

/// Fills the residuals of both degrees, those with components, and the limits where asked for, by one quadrature over
/// the changed elements; tells `patches` which old elements lie there. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Done> integrate_residuals(const TransferScene<D>& scene, Projection<D, 1>& linear,
                                                Projection<D, 2>& quadratic, PatchSearch<D>& patches,
                                                const Execution& execution);

/// Puts the integrals over each group back to those of the old field, by the least change in L2 on each patch: δ with
/// least δᵀMδ among those with Cδ = g, C the integrals of the basis by group: δ = M⁻¹Cᵀλ, (C M⁻¹Cᵀ) λ = g. What a
/// patch's free nodes cannot reach, since it has none of a material, is given to that material's other patches by the
/// least change in L2 of all of them, and `before` says so.
template <int D, int K>
[[nodiscard]] Outcome<Done> keep_integrals(const TransferScene<D>& scene,
                                           const typename PatchSearch<D>::Patches& patches,
                                           Projection<D, K>& projection, const Execution& execution);

/// Cuts the free values to their limits, and gives what that took from a group's integral to those of its nodes that
/// are within theirs, each by the same share of what it may move.
template <int D, int K>
[[nodiscard]] Outcome<Done> keep_limits(const TransferScene<D>& scene, const typename PatchSearch<D>::Patches& patches,
                                        Projection<D, K>& projection, const Execution& execution);

/// The integrals over the old elements of each group, for `Projection::before`.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<Sum>> integrals_before(const TransferScene<D>& scene,
                                                         const typename PatchSearch<D>::Patches& patches,
                                                         const Projection<D, K>& projection,
                                                         const Execution& execution);

/// By how much the new integrals over each group fall short of the old ones: group after group, all components.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<double>> missing_integrals(const TransferScene<D>& scene,
                                                             const typename PatchSearch<D>::Patches& patches,
                                                             const Projection<D, K>& projection,
                                                             const Execution& execution);

/// The values of `conserve` in place of the interpolated ones. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> conserve(const TransferScene<D>& scene, std::span<const TransferField> fields,
                                             Interpolated interpolated, const Execution& execution);

/// The points of one new element in the old mesh: most of them lie in the few old elements that points before them were
/// found in, or beside the last one. Where F(ξ) = p has a solution in one of these p is there; other points are
/// located.
template <int D>
class Nearby {
  public:
    Nearby(const QuadraticMesh<D>& old_mesh, const Sources<D>& sources) : mesh_(old_mesh), sources_(sources) {}

    /// Forgets the element before. `hint`: an old element near the next, or `none`.
    void begin(std::size_t material, std::uint32_t hint) {
        material_ = material;
        hint_ = hint;
        seen_.clear();
        tried_.clear();
    }
    [[nodiscard]] OldPlace<D> find(const Vec<D>& p);
    /// The old elements found since `begin`, each once.
    [[nodiscard]] std::span<const std::uint32_t> seen() const { return seen_; }

  private:
    struct Tried {
        std::uint32_t element = 0;
        ElementMap<D> map;
        Vec<D> centre;             ///< of the element, relative to its origin
        Mat<D> jacobian, inverse;  ///< there
        bool is_seen = false;      ///< a point was found in it
    };
    [[nodiscard]] static bool is_inside(const Tried& here, const Vec<D>& p, Barycentric<D>& xi);
    [[nodiscard]] OldPlace<D> found(std::size_t i, OldPlace<D> place);
    [[nodiscard]] std::size_t remember(std::uint32_t element);
    [[nodiscard]] std::uint32_t next_towards(const Tried& here, const Vec<D>& p) const;

    const QuadraticMesh<D>& mesh_;
    const Sources<D>& sources_;
    std::size_t material_ = 0;
    std::uint32_t hint_ = none;
    std::vector<std::uint32_t> seen_;
    std::vector<Tried> tried_;  ///< these; the one that was found last first
};

}  // namespace camber

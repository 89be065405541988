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

/// Place in the old mesh: an element and ξ.
template <int D>
struct OldPosition {
    std::uint32_t element = none;
    Barycentric<D> xi{};
    Placement placement = Placement::inside;
    double distance = 0;  ///< to the point, if that is outside
};

/// Old mesh and its parts by material. Points beyond a part map to the nearest point of its boundary.
template <int D>
class Sources {
  public:
    [[nodiscard]] static Outcome<Sources> make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                               const std::vector<std::uint8_t>& is_requested,
                                               const Execution& execution);

    /// Locates a point in a material. `hint`: an old element near it, or `none`.
    [[nodiscard]] OldPosition<D> find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const;

    /// Old element across a face, within a material; `none` at its boundary.
    [[nodiscard]] std::uint32_t across(std::size_t material, std::uint32_t element, std::size_t opposite) const;

  private:
    struct Part {
        CurvedLocator<D> locator;
        Column<std::uint32_t> elements;  ///< numbers in the old mesh; empty: all
    };
    Outcome<Done> add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                           const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                           const Execution& execution);
    [[nodiscard]] ElementId hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const;

    std::vector<Part> parts_;         ///< per material; the rest has all elements
    Buffer<std::uint32_t> material_;  ///< per old element; empty: only the rest exists
    Buffer<std::uint32_t> number_in_part_;
};

/// Adds Σ φ_α u_α of a field in element e, one value per component.
template <int D, int K>
void add_field(const QuadraticMesh<D>& mesh, std::size_t e, const std::array<double, field_nodes<D, K>>& phi,
               const double* values, std::span<double> out) {
    const auto nodes = nodes_of<D, K>(mesh, e);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += phi[i] * values[nodes[i] * out.size() + c];
}

struct Interpolated {
    std::vector<Buffer<double>> values;
    /// Per new vertex an old element near it, or `none`.
    Buffer<std::uint32_t> near;
    TransferStatistics statistics;  ///< of nodes
};

template <int D>
struct TransferMeshes {
    const QuadraticMesh<D>& old_mesh;
    const QuadraticMesh<D>& new_mesh;
    const Materials<D>& materials;
    const CommonParts& same;
    const Sources<D>& sources;
};

/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> interpolate(const TransferMeshes<D>& meshes, std::span<const TransferField> fields,
                                                const Execution& execution);

/// Materials of the new elements, and the rest if a node has none.
template <int D>
[[nodiscard]] std::vector<std::uint8_t> requested_materials(const QuadraticMesh<D>& new_mesh,
                                                            const Materials<D>& materials);

/// Elements that only one of the meshes has.
struct Changed {
    std::vector<std::uint32_t> new_elements, old_elements;  ///< ascending
    Buffer<std::uint32_t> old_slot;                         ///< per old element: its index there, or `none`
    /// Per new node: true if all its elements changed. Others keep their values.
    Buffer<std::uint8_t> is_free;
};
template <int D>
[[nodiscard]] Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                   const CommonParts& same);

/// Disjoint sets (union–find).
class JoinedSets {
  public:
    explicit JoinedSets(std::size_t n) : above_(n) { std::iota(above_.begin(), above_.end(), std::uint32_t{0}); }
    void join(std::size_t a, std::size_t b) {
        const std::uint32_t p = lowest(static_cast<std::uint32_t>(a)), q = lowest(static_cast<std::uint32_t>(b));
        above_[p < q ? q : p] = p < q ? p : q;
    }
    /// Lowest item of the set.
    [[nodiscard]] std::uint32_t lowest(std::uint32_t i) {
        for (; above_[i] != i; i = above_[i]) above_[i] = above_[above_[i]];
        return i;
    }

  private:
    Buffer<std::uint32_t> above_;
};

/// Connected patches of changed new and old elements. Elements are connected by an edge, by a node with changed
/// elements only, or if a point of one lies in the other.
template <int D>
class PatchSearch {
  public:
    PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const CommonParts& same,
                const Changed& changed);
    /// Records a point of `new_slot` in an old element.
    void found(std::size_t new_slot, std::uint32_t old_element) {
        if (const std::uint32_t slot = changed_.old_slot[old_element]; slot != none)
            sets_.join(new_slot, changed_.new_elements.size() + slot);
    }

    /// Patches by their first new element. Groups: elements of a patch and a material.
    struct Patches {
        std::size_t patches = 0;
        struct Group {
            std::uint32_t patch, material;
            friend auto operator<=>(const Group&, const Group&) = default;
        };
        std::vector<Group> groups;                              ///< ascending; of new elements
        std::vector<std::uint32_t> group_of_new, group_of_old;  ///< per slot; `no_group`: without new elements
        std::vector<std::uint32_t> first_group;                 ///< per patch, and the end
    };
    [[nodiscard]] Patches patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                  const Materials<D>& materials);

  private:
    const Changed& changed_;
    JoinedSets sets_;
};

/// Entries i ≥ j of a symmetric matrix of N rows, row by row.
template <int N>
inline constexpr int packed_size = N * (N + 1) / 2;
[[nodiscard]] constexpr int packed_index(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/// ∫ φ_i φ_j |det J| over elements, by a quadrature with positive weights.
template <int D, int K>
class ReferenceMass {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Matrix = std::array<double, packed_size<nodes>>;
    using Functions = std::array<double, nodes>;

    explicit ReferenceMass(int points_per_direction);

    std::vector<RulePoint<D>> rule;
    std::vector<Functions> functions;  ///< φ at the points
    Matrix matrix{};                   ///< of the reference element; times |det J| for straight ones
    double low = 1, high = 1;          ///< bounds of the eigenvalues of diag(M)⁻¹ M

    /// Matrix of a curved element, with bounds of det J.
    struct Curved {
        Matrix matrix{};
        double least = 0, largest = 0;
    };
    [[nodiscard]] Curved curved(const ElementMap<D>& map) const;
    [[nodiscard]] static std::array<double, 2> eigenvalues(const Matrix& matrix);
};

/// Mass matrix of degree K at the free nodes of some elements, stored by element; a straight one needs a single number.
/// Symmetric positive definite without vanishing elements.
template <int D, int K>
class MassMatrix {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Local = std::array<std::uint32_t, nodes>;

    /// `is_free` has one entry per mesh node. Errors: memory, stopped.
    [[nodiscard]] static Outcome<MassMatrix> make(const QuadraticMesh<D>& mesh,
                                                  const std::vector<std::uint32_t>& elements,
                                                  const Buffer<std::uint8_t>& is_free,
                                                  const ReferenceMass<D, K>& reference, const Execution& execution);

    [[nodiscard]] std::size_t size() const { return node_of_.size(); }
    [[nodiscard]] std::span<const std::uint32_t> node_of() const { return node_of_; }
    /// Unknowns of element `slot`; `none` for fixed nodes.
    [[nodiscard]] const Local& unknowns(std::size_t slot) const { return unknowns_[slot]; }
    [[nodiscard]] std::size_t turned() const { return turned_; }
    /// ∫ φ_i over element `slot`: row sums of its matrix, since Σ φ = 1.
    [[nodiscard]] std::array<double, nodes> integrals(std::size_t slot) const {
        std::array<double, nodes> one{};
        one.fill(1);
        return local_product(slot, one);
    }

    /// Assembles `local(slot)` at the unknowns, in element order.
    template <class LocalOf>
    [[nodiscard]] Outcome<Done> assemble(const LocalOf& local, std::span<double> out, const Execution& execution);

    /// Solves M x = r by Chebyshev's iteration with the diagonal, whose eigenvalue bounds of diag(M)⁻¹ M are known
    /// (Wathen 1987; Wathen and Rees 2009). It needs no inner products. The error falls by 10⁻¹⁰ in each patch
    /// independently. `r` becomes the residual.
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
    Buffer<double> scales_;            ///< per element: |det J| if straight
    Buffer<std::uint32_t> curved_at_;  ///< per element: index of its curved matrix, or `none`
    Buffer<typename ReferenceMass<D, K>::Matrix> curved_;
    std::array<double, nodes * nodes> straight_{};  ///< reference element, full matrix
    Buffer<std::uint32_t> offsets_, items_;         ///< per unknown: slot · nodes + local node, ascending
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

template <int D, int K>
struct Projection {
    Block block;
    ReferenceMass<D, K> reference;
    MassMatrix<D, K> matrix;
    /// Target integrals of each group, from the old field: by group, then component.
    std::vector<Sum> before;
    Buffer<double> residual;                            ///< ∫ φ_i (u_old − u): by component, then unknown
    Buffer<double> low, high;                           ///< if requested: limits by unknown, then component
    std::size_t spread = 0, unconserved_materials = 0;  ///< see TransferStatistics

    [[nodiscard]] std::span<double> residual_of(std::size_t c) {
        return std::span(residual).subspan(c * matrix.size(), matrix.size());
    }
    void add(std::size_t c, std::span<const double> change) {
        for (std::size_t u = 0; u < change.size(); ++u)
            block.values[matrix.node_of()[u] * block.components + c] += change[u];
    }
};

/// Read-only input of a projection.
template <int D>
struct ProjectionInput : TransferMeshes<D> {
    const Changed& changed;
    const Buffer<std::uint32_t>& near;
    const TransferOptions& options;
};

/// Computes the residuals of both degrees and, if requested, the limits, by one quadrature over the changed elements.
/// Reports old elements at its points to `patches`. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Done> integrate_residuals(const ProjectionInput<D>& scene, Projection<D, 1>& linear,
                                                Projection<D, 2>& quadratic, PatchSearch<D>& patches,
                                                const Execution& execution);

/// Restores each group's integral by the smallest L2 change on each patch: minimises δᵀMδ under Cδ = g, C the integrals
/// of the basis by group; δ = M⁻¹Cᵀλ, (C M⁻¹Cᵀ) λ = g. Parts that a patch cannot reach are spread over the material's
/// other patches by the smallest L2 change, and `before` is updated.
template <int D, int K>
[[nodiscard]] Outcome<Done> conserve_integrals(const ProjectionInput<D>& scene,
                                               const typename PatchSearch<D>::Patches& patches,
                                               Projection<D, K>& projection, const Execution& execution);

/// Clips free values to their limits. The lost integral goes to the group's unclipped nodes, in proportion to their
/// admissible moves.
template <int D, int K>
[[nodiscard]] Outcome<Done> clip_to_limits(const ProjectionInput<D>& scene,
                                           const typename PatchSearch<D>::Patches& patches,
                                           Projection<D, K>& projection, const Execution& execution);

/// Integrals over the old elements of each group, for `Projection::before`.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<Sum>> integrals_before(const ProjectionInput<D>& scene,
                                                         const typename PatchSearch<D>::Patches& patches,
                                                         const Projection<D, K>& projection,
                                                         const Execution& execution);

/// Old minus new integrals: by group, then component.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<double>> missing_integrals(const ProjectionInput<D>& scene,
                                                             const typename PatchSearch<D>::Patches& patches,
                                                             const Projection<D, K>& projection,
                                                             const Execution& execution);

/// Replaces interpolated values by those of `conserve`. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> conserve(const ProjectionInput<D>& scene, std::span<const TransferField> fields,
                                             Interpolated interpolated, const Execution& execution);

/// Locates points of one new element. Old elements of earlier points, and the last one's neighbours, are tried first: p
/// is inside if F(ξ) = p has a solution there.
template <int D>
class Nearby {
  public:
    Nearby(const QuadraticMesh<D>& old_mesh, const Sources<D>& sources) : mesh_(old_mesh), sources_(sources) {}

    /// Starts a new element. `hint`: an old element near it, or `none`.
    void begin(std::size_t material, std::uint32_t hint) {
        material_ = material;
        hint_ = hint;
        visited_.clear();
        tried_.clear();
    }
    [[nodiscard]] OldPosition<D> find(const Vec<D>& p);
    [[nodiscard]] std::span<const std::uint32_t> visited() const { return visited_; }

  private:
    struct Tried {
        std::uint32_t element = 0;
        ElementMap<D> map;
        Vec<D> centre;             ///< of the element, relative to its origin
        Mat<D> jacobian, inverse;  ///< at the centre
        bool is_visited = false;   ///< contains a point
    };
    [[nodiscard]] static bool is_inside(const Tried& here, const Vec<D>& p, Barycentric<D>& xi);
    [[nodiscard]] OldPosition<D> found(std::size_t i, OldPosition<D> place);
    [[nodiscard]] std::size_t remember(std::uint32_t element);
    [[nodiscard]] std::uint32_t next_towards(const Tried& here, const Vec<D>& p) const;

    const QuadraticMesh<D>& mesh_;
    const Sources<D>& sources_;
    std::size_t material_ = 0;
    std::uint32_t hint_ = none;
    std::vector<std::uint32_t> visited_;
    std::vector<Tried> tried_;  ///< most recently found first
};

}  // namespace camber

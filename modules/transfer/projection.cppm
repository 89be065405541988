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

/// A position in the old mesh: an element and barycentric coordinates ξ.
template <int D>
struct OldPosition {
    std::uint32_t element = none;
    Barycentric<D> xi{};
    Placement placement = Placement::inside;
    double distance = 0;  ///< distance to the point, if the point is outside the mesh
};

/// The old mesh, and its submeshes by material. A point outside a submesh maps to the nearest point of its boundary.
template <int D>
class Sources {
  public:
    [[nodiscard]] static Outcome<Sources> make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                               const std::vector<std::uint8_t>& is_requested,
                                               const Execution& execution);

    /// Locates a point in a material. `hint` is an old element near the point, or `none`.
    [[nodiscard]] OldPosition<D> find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const;

    /// Old element of the same material across the face opposite a local vertex; `none` at the boundary.
    [[nodiscard]] std::uint32_t across(std::size_t material, std::uint32_t element, std::size_t opposite) const;

  private:
    struct Part {
        CurvedLocator<D> locator;
        Column<std::uint32_t> elements;  ///< numbers in the old mesh; empty: all elements
    };
    Outcome<Done> add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                           const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                           const Execution& execution);
    [[nodiscard]] ElementId hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const;

    std::vector<Part> parts_;         ///< for each material; the part of `rest` has all elements
    Buffer<std::uint32_t> material_;  ///< material of each old element; empty if there is only `rest`
    Buffer<std::uint32_t> number_in_part_;
};

/// Adds the field's values Σ φ_α u_α in element e to `out`, one value for each component.
template <int D, int K>
void add_field(const QuadraticMesh<D>& mesh, std::size_t e, const std::array<double, field_nodes<D, K>>& phi,
               const double* values, std::span<double> out) {
    const auto nodes = nodes_of<D, K>(mesh, e);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += phi[i] * values[nodes[i] * out.size() + c];
}

struct Interpolated {
    std::vector<Buffer<double>> values;
    /// For each new vertex, an old element near it, or `none`.
    Buffer<std::uint32_t> near;
    TransferStatistics statistics;
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

/// Marks the materials of new elements, and `rest` if a node has no element.
template <int D>
[[nodiscard]] std::vector<std::uint8_t> requested_materials(const QuadraticMesh<D>& new_mesh,
                                                            const Materials<D>& materials);

struct Changed {
    std::vector<std::uint32_t> new_elements, old_elements;  ///< ascending
    Buffer<std::uint32_t> old_slot;  ///< for each old element: its index in `old_elements`, or `none`
    /// True for each new node all of whose elements changed. Other nodes keep their values.
    Buffer<std::uint8_t> is_free;
};
template <int D>
[[nodiscard]] Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                   const CommonParts& same);

class JoinedSets {
  public:
    explicit JoinedSets(std::size_t n) : above_(n) { std::iota(above_.begin(), above_.end(), std::uint32_t{0}); }
    void join(std::size_t a, std::size_t b) {
        const std::uint32_t p = lowest(static_cast<std::uint32_t>(a)), q = lowest(static_cast<std::uint32_t>(b));
        above_[p < q ? q : p] = p < q ? p : q;
    }
    [[nodiscard]] std::uint32_t lowest(std::uint32_t i) {
        for (; above_[i] != i; i = above_[i]) above_[i] = above_[above_[i]];
        return i;
    }

  private:
    Buffer<std::uint32_t> above_;
};

/// Finds connected patches of changed new and old elements. Two elements are connected if they share an edge, or a node
/// all of whose elements changed, or if one contains a point of the other.
template <int D>
class PatchSearch {
  public:
    PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const CommonParts& same,
                const Changed& changed);
    /// Records that an old element contains a point of the new element `new_slot`.
    void found(std::size_t new_slot, std::uint32_t old_element) {
        if (const std::uint32_t slot = changed_.old_slot[old_element]; slot != none)
            sets_.join(new_slot, changed_.new_elements.size() + slot);
    }

    /// Patches, in the order of their first new element. A group consists of the elements of one patch and one
    /// material.
    struct Patches {
        std::size_t patches = 0;
        struct Group {
            std::uint32_t patch, material;
            friend auto operator<=>(const Group&, const Group&) = default;
        };
        std::vector<Group> groups;
        std::vector<std::uint32_t> group_of_new, group_of_old;  ///< group of each slot; `no_group` if the patch has no
                                                                ///< new element of the material
        std::vector<std::uint32_t> first_group;  ///< first group of each patch; the last entry is the number of groups
    };
    [[nodiscard]] Patches patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                  const Materials<D>& materials);

  private:
    const Changed& changed_;
    JoinedSets sets_;
};

/// Number of entries i ≥ j of a symmetric matrix with N rows, stored row by row.
template <int N>
inline constexpr int packed_size = N * (N + 1) / 2;
[[nodiscard]] constexpr int packed_index(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/// ∫ φ_i φ_j |det J| over elements, by a quadrature rule with positive weights.
template <int D, int K>
class ReferenceMass {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Matrix = std::array<double, packed_size<nodes>>;
    using Functions = std::array<double, nodes>;

    explicit ReferenceMass(int points_per_direction);

    std::vector<RulePoint<D>> rule;
    std::vector<Functions> functions;
    Matrix matrix{};           ///< for the reference element; a straight element has |det J| times this matrix
    double low = 1, high = 1;  ///< bounds of the eigenvalues of diag(M)⁻¹ M

    struct Curved {
        Matrix matrix{};
        double least = 0, largest = 0;
    };
    [[nodiscard]] Curved curved(const ElementMap<D>& map) const;
    [[nodiscard]] static std::array<double, 2> eigenvalues(const Matrix& matrix);
};

/// Mass matrix of degree K at the free nodes of some elements, stored by element. A straight element needs only one
/// number. The matrix is symmetric positive definite unless elements vanish.
template <int D, int K>
class MassMatrix {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Local = std::array<std::uint32_t, nodes>;

    /// `is_free` has one entry for each node. Errors: memory, stopped.
    [[nodiscard]] static Outcome<MassMatrix> make(const QuadraticMesh<D>& mesh,
                                                  const std::vector<std::uint32_t>& elements,
                                                  const Buffer<std::uint8_t>& is_free,
                                                  const ReferenceMass<D, K>& reference, const Execution& execution);

    [[nodiscard]] std::size_t size() const { return node_of_.size(); }
    [[nodiscard]] std::span<const std::uint32_t> node_of() const { return node_of_; }
    /// Numbers of the unknowns of element `slot`; `none` at fixed nodes.
    [[nodiscard]] const Local& unknowns(std::size_t slot) const { return unknowns_[slot]; }
    [[nodiscard]] std::size_t turned() const { return turned_; }
    /// ∫ φ_i over element `slot`: the row sums of its matrix, because Σ φ = 1.
    [[nodiscard]] std::array<double, nodes> integrals(std::size_t slot) const {
        std::array<double, nodes> one{};
        one.fill(1);
        return local_product(slot, one);
    }

    /// Adds the vectors `local(slot)` of all elements at their unknowns, in element order.
    template <class LocalOf>
    [[nodiscard]] Outcome<Done> assemble(const LocalOf& local, std::span<double> out, const Execution& execution);

    /// Solves M x = r by Chebyshev's iteration with diagonal preconditioning. Bounds of the eigenvalues of diag(M)⁻¹ M
    /// are known (Wathen 1987; Wathen and Rees 2009), so no inner products are needed. The error falls by 10⁻¹⁰,
    /// independently in each patch. `r` becomes the residual.
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
    Buffer<double> scales_;            ///< |det J| of each straight element
    Buffer<std::uint32_t> curved_at_;  ///< index of each element's matrix in `curved_`, or `none`
    Buffer<typename ReferenceMass<D, K>::Matrix> curved_;
    std::array<double, nodes * nodes> straight_{};
    Buffer<std::uint32_t> offsets_, items_;  ///< for each unknown: its items slot · nodes + local node, ascending
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
    /// Target integrals from the old field: by group, then component.
    std::vector<Sum> before;
    Buffer<double> residual;   ///< ∫ φ_i (u_old − u): by component, then unknown
    Buffer<double> low, high;  ///< limits, if requested: by unknown, then component
    std::size_t spread = 0, unconserved_materials = 0;

    [[nodiscard]] std::span<double> residual_of(std::size_t c) {
        return std::span(residual).subspan(c * matrix.size(), matrix.size());
    }
    void add(std::size_t c, std::span<const double> change) {
        for (std::size_t u = 0; u < change.size(); ++u)
            block.values[matrix.node_of()[u] * block.components + c] += change[u];
    }
};

template <int D>
struct ProjectionInput : TransferMeshes<D> {
    const Changed& changed;
    const Buffer<std::uint32_t>& near;
    const TransferOptions& options;
};

/// Computes the residuals of both degrees and, if requested, the limits, by one quadrature over the changed elements.
/// Reports the old elements at the quadrature points to `patches`. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Done> integrate_residuals(const ProjectionInput<D>& scene, Projection<D, 1>& linear,
                                                Projection<D, 2>& quadratic, PatchSearch<D>& patches,
                                                const Execution& execution);

/// Restores each group's integral by the smallest L2 change δ on each patch: it minimises δᵀMδ under C δ = g. C has the
/// integrals of the basis functions by group, and g the missing integrals. The solution is δ = M⁻¹Cᵀλ with (C M⁻¹Cᵀ) λ
/// = g. Missing integrals that a patch cannot restore are spread over the material's other patches by the smallest L2
/// change, and `before` is updated.
template <int D, int K>
[[nodiscard]] Outcome<Done> conserve_integrals(const ProjectionInput<D>& scene,
                                               const typename PatchSearch<D>::Patches& patches,
                                               Projection<D, K>& projection, const Execution& execution);

/// Clips free values to their limits. The lost integral is added to the group's unclipped nodes, in proportion to their
/// admissible changes.
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

/// Replaces interpolated values by those of `TransferMethod::conserve`. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> conserve(const ProjectionInput<D>& scene, std::span<const TransferField> fields,
                                             Interpolated interpolated, const Execution& execution);

/// Locates points of one new element in the old mesh. It first tries the old elements of earlier points, and the
/// neighbours of the last one. A point p is inside an element if F(ξ) = p has a solution there.
template <int D>
class Nearby {
  public:
    Nearby(const QuadraticMesh<D>& old_mesh, const Sources<D>& sources) : mesh_(old_mesh), sources_(sources) {}

    /// Starts a new element. `hint` is an old element near it, or `none`.
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
        Vec<D> centre;  ///< element centre, relative to its vertex 0
        Mat<D> jacobian, inverse;
        bool is_visited = false;
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
    std::vector<Tried> tried_;
};

}  // namespace camber

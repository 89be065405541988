module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:interpolate;
import camber.core;
import camber.bezier;
import :fields;
import :materials;
import :same;
import :simplex;
import :sources;
import :transferred;

namespace camber {

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

/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> interpolate(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                                const QuadraticMesh<D>& new_mesh, const Materials<D>& materials,
                                                const Same& same, const Sources<D>& sources,
                                                const Execution& execution);

/// Which materials are asked for by a new mesh: those of its elements, and the rest where a node has no element.
template <int D>
[[nodiscard]] std::vector<std::uint8_t> asked_materials(const QuadraticMesh<D>& new_mesh,
                                                        const Materials<D>& materials);

}  // namespace camber

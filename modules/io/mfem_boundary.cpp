module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.io;
import camber.core;
import :mfem_boundary;

namespace camber::mfem {

namespace {

template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> vertices) {
    std::sort(vertices.begin(), vertices.end());
    return vertices;
}

/// The rows of simplices, found by their vertices in whichever order.
template <int K>
class Rows {
  public:
    explicit Rows(const Column<SimplexVertices<K>>& simplices) : simplices_(simplices) {
        for (const auto& simplex : simplices) vertices_ = std::max(vertices_, lowest(simplex).index() + 1);
        starts_ = Buffer<std::uint32_t>(vertices_ + 1, 0U);
        for (const auto& simplex : simplices) ++starts_[lowest(simplex).index() + 1];
        for (std::size_t v = 0; v < vertices_; ++v) starts_[v + 1] += starts_[v];
        rows_.resize(simplices.size());
        Buffer<std::uint32_t> next = starts_;
        for (std::size_t i = 0; i < simplices.size(); ++i)
            rows_[next[lowest(simplices[i]).index()]++] = static_cast<std::uint32_t>(i);
    }

    /// f(row) for each with these vertices.
    void find(const SimplexVertices<K>& wanted, auto&& f) const {
        const std::size_t v = lowest(wanted).index();
        if (v >= vertices_ || starts_[v] == starts_[v + 1]) return;
        const SimplexVertices<K> key = sorted(wanted);
        for (std::size_t k = starts_[v]; k < starts_[v + 1]; ++k)
            if (sorted(simplices_[rows_[k]]) == key) f(rows_[k]);
    }

  private:
    static VertexId lowest(const SimplexVertices<K>& simplex) {
        return *std::min_element(simplex.begin(), simplex.end());
    }

    const Column<SimplexVertices<K>>& simplices_;
    std::size_t vertices_ = 0;
    Buffer<std::uint32_t> starts_, rows_;  ///< rows by their lowest vertex
};

}  // namespace

template <int K>
Outcome<Simplices<K - 1>> faces_of(const Simplices<K>& elements, const Simplices<K - 1>& boundary,
                                   const Execution& execution) {
    const Rows<K - 1> rows(boundary.vertices);
    Buffer<std::uint8_t> is_face(boundary.size(), std::uint8_t{0});
    auto marked = each(execution, elements.size(), [&](std::size_t e) {
        for (int i = 0; i <= K; ++i) {
            SimplexVertices<K - 1> face;
            for (int k = 0; k < K; ++k) face[k] = elements.vertices[e][face_opposite<K>(i)[k]];
            rows.find(face,
                      [&](std::size_t row) { std::atomic_ref(is_face[row]).store(1, std::memory_order_relaxed); });
        }
    });
    if (!marked) return fail(std::move(marked.error()));
    if (std::find(is_face.begin(), is_face.end(), 0) == is_face.end()) return boundary;
    Buffer<SimplexVertices<K - 1>> vertices;
    Buffer<Reference> references;
    for (std::size_t i = 0; i < boundary.size(); ++i)
        if (is_face[i] != 0) {
            vertices.push_back(boundary.vertices[i]);
            references.push_back(boundary.references[i]);
        }
    return Simplices<K - 1>{std::move(vertices), std::move(references), {}};
}

template Outcome<Simplices<1>> faces_of<2>(const Simplices<2>&, const Simplices<1>&, const Execution&);
template Outcome<Simplices<2>> faces_of<3>(const Simplices<3>&, const Simplices<2>&, const Execution&);

}  // namespace camber::mfem

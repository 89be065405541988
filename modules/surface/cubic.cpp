module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Where index β + e_i of degree N stands, for each β of degree N − 1 and each i.
template <int N, int K>
constexpr auto raised = [] {
    std::array<std::array<int, K + 1>, node_count<N - 1, K>> table{};
    for (int n = 0; n < node_count<N - 1, K>; ++n)
        for (int i = 0; i <= K; ++i) {
            auto alpha = multi_indices<N - 1, K>[n];
            ++alpha[i];
            table[n][i] = position<N, K>(alpha);
        }
    return table;
}();

template <int N, int K, int D>
std::array<Vec<D>, node_count<N - 1, K>> reduced(const std::array<Vec<D>, node_count<N, K>>& net,
                                                 const Barycentric<K>& xi) {
    std::array<Vec<D>, node_count<N - 1, K>> out{};
    for (int n = 0; n < node_count<N - 1, K>; ++n)
        for (int i = 0; i <= K; ++i) out[n] += xi[i] * net[raised<N, K>[n][i]];
    return out;
}

/// In a net of degree 1 the point of ξ_i stands at i.
template <int K, int D>
Vec<D> combined(const std::array<Vec<D>, K + 1>& net, const Barycentric<K>& xi) {
    Vec<D> p;
    for (int i = 0; i <= K; ++i) p += xi[i] * net[i];
    return p;
}

}  // namespace

template <int K, int D>
CubicExpansion<K, D> expand(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi) {
    const auto quadratic = reduced<3, K, D>(simplex.control, xi);
    const auto linear = reduced<2, K, D>(quadratic, xi);
    const auto second = [&](int i, int j) {
        return quadratic[raised<2, K>[i][j]];  // a net of degree 1 stands in the order of its coordinates
    };
    CubicExpansion<K, D> out;
    out.point = combined<K, D>(linear, xi);
    for (int a = 0; a < K; ++a) {
        out.first[a] = 3 * (linear[a + 1] - linear[0]);
        for (int b = 0; b < K; ++b)
            out.second[a][b] = 6 * ((second(a + 1, b + 1) - second(a + 1, 0)) - (second(b + 1, 0) - second(0, 0)));
    }
    return out;
}

template <int K, int D>
Vec<D> point_at(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi) {
    return combined<K, D>(reduced<2, K, D>(reduced<3, K, D>(simplex.control, xi), xi), xi);
}

template <int D>
CubicSimplex<1, D> cubic_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b, const Vec<D>& b) {
    constexpr double min_cosine = 0.26;  // 75°
    const Vec<D> e = b - a;
    const double length = norm(e);
    const auto handle = [&](const Vec<D>& tangent) {
        const Vec<D> t = normalised(tangent);
        const double cosine = length > 0 ? dot(t, e) / length : 0;
        return cosine > min_cosine ? (length * (2.0 / 3.0) / (1 + cosine)) * t : e / 3;
    };
    return {{a, a + handle(tangent_a), b - handle(tangent_b), b}};
}

template <int D>
Vec<D> classical_centre(const CubicSimplex<2, D>& triangle) {
    Vec<D> edges, vertices;
    for (std::size_t n = 0; n < triangle.control.size(); ++n) {
        const auto& alpha = multi_indices<3, 2>[n];
        const Vec<D> from_first = triangle.control[n] - triangle.control[0];
        const bool is_vertex = alpha[0] == 3 || alpha[1] == 3 || alpha[2] == 3;
        const bool is_centre = alpha[0] == 1 && alpha[1] == 1;
        if (is_vertex)
            vertices += from_first;
        else if (!is_centre)
            edges += from_first;
    }
    return triangle.control[0] + (edges / 4 - vertices / 6);
}

template CubicExpansion<1, 2> expand(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template CubicExpansion<1, 3> expand(const CubicSimplex<1, 3>&, const Barycentric<1>&);
template CubicExpansion<2, 3> expand(const CubicSimplex<2, 3>&, const Barycentric<2>&);
template Vec<2> point_at(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template Vec<3> point_at(const CubicSimplex<1, 3>&, const Barycentric<1>&);
template Vec<3> point_at(const CubicSimplex<2, 3>&, const Barycentric<2>&);
template CubicSimplex<1, 2> cubic_edge(const Vec<2>&, const Vec<2>&, const Vec<2>&, const Vec<2>&);
template CubicSimplex<1, 3> cubic_edge(const Vec<3>&, const Vec<3>&, const Vec<3>&, const Vec<3>&);
template Vec<3> classical_centre(const CubicSimplex<2, 3>&);

}  // namespace camber

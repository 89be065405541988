// Meshes with all features generated from a seed, and bytes of encoded files.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.io;

namespace generated {

using Bytes = std::vector<std::byte>;

inline Bytes joined(const camber::Chunks& chunks) {
    Bytes bytes;
    for (const auto& chunk : chunks) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    return bytes;
}

inline Bytes bytes_of(std::string_view text) {
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

inline std::string text_of(const Bytes& bytes) {
    std::string text(bytes.size(), '\0');
    std::transform(bytes.begin(), bytes.end(), text.begin(), [](std::byte b) { return static_cast<char>(b); });
    return text;
}

class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    std::size_t below(std::size_t n) { return n == 0 ? 0 : engine_() % n; }
    camber::Reference reference() { return static_cast<camber::Reference>(engine_()); }
    /// Any magnitude, any digits, sometimes zero of either sign or the smallest subnormal number.
    double real() {
        const auto kind = below(12);
        if (kind == 0) return -0.0;
        if (kind == 1) return 5e-324;
        const double digits = std::uniform_real_distribution<double>(-1, 1)(engine_);
        return kind < 4 ? digits * 1e300 : digits;
    }
    template <int D>
    camber::Vec<D> vector() {
        camber::Vec<D> v;
        for (int i = 0; i < D; ++i) v[i] = real();
        return v;
    }

  private:
    std::mt19937_64 engine_;
};

template <class Item>
camber::Column<Item> some_of(Random& random, std::size_t n) {
    camber::Buffer<Item> items;
    for (std::size_t i = 0; i < n; ++i)
        if (random.below(3) == 0) items.push_back(static_cast<Item>(i));
    return items;
}

template <int K>
camber::Simplices<K> simplices(Random& random, camber::Buffer<camber::SimplexVertices<K>> vertices) {
    camber::Buffer<camber::Reference> references;
    for (std::size_t i = 0; i < vertices.size(); ++i) references.push_back(random.reference());
    camber::Simplices<K> result;
    result.required = some_of<std::uint32_t>(random, vertices.size());
    result.vertices = std::move(vertices);
    result.references = std::move(references);
    return result;
}

/// Appends K-faces of a simplex, each of K + 1 cyclically consecutive vertices.
template <int K, std::size_t N>
void faces(const std::array<camber::VertexId, N>& simplex, camber::Buffer<camber::SimplexVertices<K>>& into) {
    for (std::size_t left_out = 0; left_out < N; ++left_out) {
        camber::SimplexVertices<K> face;
        for (std::size_t i = 0; i <= K; ++i) face[i] = simplex[(left_out + i) % N];
        into.push_back(face);
    }
}

template <int D>
camber::InputGeometry<D> geometry(Random& random, std::size_t vertices) {
    camber::Buffer<camber::Vec<D>> normals, tangents;
    camber::Buffer<camber::DirectionRow> at;
    camber::Buffer<camber::Association<0>> on_points;
    camber::Buffer<camber::Association<1>> on_curves;
    camber::Buffer<camber::Association<2>> on_surfaces;
    for (std::size_t v = 0; v < vertices; ++v) {
        const camber::VertexId id(v);
        if (random.below(2) == 0) {
            at.push_back({id, static_cast<std::uint32_t>(normals.size())});
            normals.push_back(random.vector<D>());
            tangents.push_back(random.vector<D>());
        }
        if (random.below(3) == 0) on_points.push_back({id, random.reference()});
        if (random.below(3) == 0) on_curves.push_back({id, random.reference(), {{random.real()}}, random.real()});
        if (random.below(3) == 0)
            on_surfaces.push_back({id, random.reference(), {{random.real(), random.real()}}, random.real()});
    }
    return {{std::move(normals), at},
            {std::move(tangents), std::move(at)},
            std::move(on_points),
            std::move(on_curves),
            std::move(on_surfaces)};
}

/// A strip of `cells` simplices, each on D + 1 consecutive vertices, with features of every kind. Coordinates have no
/// geometric meaning, because decoding does not depend on them. One mesh in five has no elements and is a surface mesh.
template <int D>
camber::LinearMesh<D> mesh(std::uint64_t seed, std::size_t cells) {
    Random random(seed);
    const std::size_t n = cells == 0 ? random.below(2) : cells + D + random.below(3);
    camber::LinearMesh<D> result;
    camber::Buffer<camber::Vec<D>> points;
    camber::Buffer<camber::Reference> references;
    for (std::size_t v = 0; v < n; ++v) {
        points.push_back(random.vector<D>());
        references.push_back(random.below(2) == 0 ? 7 : random.reference());
    }
    camber::Buffer<camber::SimplexVertices<D>> elements;
    camber::Buffer<camber::SimplexVertices<D - 1>> facets;
    camber::Buffer<camber::SimplexVertices<1>> edges;
    for (std::size_t e = 0; e < cells; ++e) {
        camber::SimplexVertices<D> element;
        for (std::size_t i = 0; i <= D; ++i) element[i] = camber::VertexId(e + i);
        std::swap(element[0], element[random.below(D + 1)]);
        elements.push_back(element);
        if (random.below(2) == 0) faces<D - 1>(element, facets);
        if (D == 3 && random.below(2) == 0) faces<1>(element, edges);
    }
    if (random.below(5) == 0) elements.clear();
    result.points = std::move(points);
    result.point_references = std::move(references);
    result.corners = some_of<camber::VertexId>(random, n);
    result.required_vertices = some_of<camber::VertexId>(random, n);
    result.elements = simplices<D>(random, std::move(elements));
    result.facets = simplices<D - 1>(random, std::move(facets));
    result.ridges = some_of<std::uint32_t>(random, D == 2 ? result.facets.size() : edges.size());
    if constexpr (D == 3) result.edges = simplices<1>(random, std::move(edges));
    result.geometry = geometry<D>(random, n);
    return result;
}

template <int D>
camber::QuadraticMesh<D> quadratic(std::uint64_t seed, std::size_t cells) {
    auto result = *camber::elevate(mesh<D>(seed, cells), {});
    Random random(seed + 1);
    camber::Buffer<camber::LagrangeNode<D>> nodes;
    for (std::size_t e = 0; e < result.edges.size(); ++e) nodes.push_back({random.vector<D>()});
    result.mid_nodes = std::move(nodes);
    return result;
}

/// True if both hold the same bits; −0 differs from 0.
template <class T>
bool same_bits(const camber::Column<T>& a, const camber::Column<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// The parameters and distances of associations, in order.
template <int G>
camber::Column<double> numbers_of(const camber::Column<camber::Association<G>>& associations) {
    camber::Buffer<double> numbers;
    for (const auto& on : associations) {
        if (on.parameters) numbers.insert(numbers.end(), on.parameters->begin(), on.parameters->end());
        if (on.distance) numbers.push_back(*on.distance);
    }
    return numbers;
}

template <int D>
bool holds_simplices(const camber::LinearMesh<D>& mesh) {
    return mesh.elements.size() + mesh.facets.size() + mesh.edges.size() > 0;
}

}  // namespace generated

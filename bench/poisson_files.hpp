#pragma once
// Input meshes and output solutions of poisson.cpp. The includer imports the modules before it.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "poisson_rule.hpp"

namespace poisson {

using namespace camber;

/// A mesh of degree 2. A mesh of degree 1 gets nodes at the midpoints of its edges.
struct MeshFile {
    std::variant<QuadraticMesh<2>, QuadraticMesh<3>> mesh;
    Column<std::uint32_t> node_numbers;  ///< like `DecodedMesh::node_numbers`
};

template <int D>
Outcome<MeshFile> of_degree_2(const Mesh<D>& mesh, const Column<std::uint32_t>& numbers) {
    auto quadratic = mesh.degree == 1 ? elevate(mesh, 2, Execution{}).and_then(as_quadratic<D>) : as_quadratic(mesh);
    if (!quadratic) return fail(quadratic.error());
    return MeshFile{std::move(*quadratic), numbers};
}

inline Outcome<MeshFile> read(const std::string& path) {
    if (std::filesystem::is_directory(path)) return fail(ErrorKind::input, "is a folder", path, {}, "name a file");
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file) return fail(ErrorKind::input, "cannot be read", path, {}, "check the path");
    auto decoded = decode_mesh(std::as_bytes(std::span(bytes)), path, Execution{});
    if (decoded) decoded = with_flat_in_2d(std::move(*decoded), Execution{});
    if (!decoded) return fail(decoded.error());
    return std::visit(
        [&]<int D>(const Mesh<D>& mesh) -> Outcome<MeshFile> {
            if (count_elements(mesh) == 0)
                return fail(ErrorKind::input, std::string("has no ") + (D == 3 ? "tetrahedra" : "triangles"), path, {},
                            "give a mesh of a volume, or of the plane");
            return of_degree_2(mesh, decoded->node_numbers);
        },
        decoded->mesh);
}

/// Returns one scalar field each, with a row for each node of the file. Rows of nodes that are not in the mesh are 0.
inline Solution solution_of(const MeshFile& file, const std::vector<Eigen::VectorXd>& fields) {
    const auto nodes = static_cast<std::size_t>(fields.front().size());
    const auto row_of = [&](std::size_t node) {
        return file.node_numbers.empty() ? node + 1 : std::size_t{file.node_numbers[node]};
    };
    std::size_t rows = 0;
    for (std::size_t node = 0; node < nodes; ++node) rows = std::max(rows, row_of(node));
    Buffer<double> values(rows * fields.size(), 0.0);
    for (std::size_t node = 0; node < nodes; ++node)
        for (std::size_t f = 0; f < fields.size(); ++f)
            if (row_of(node) > 0)
                values[(row_of(node) - 1) * fields.size() + f] = fields[f][static_cast<Eigen::Index>(node)];
    const int dimension = file.mesh.index() == 0 ? 2 : 3;
    return {.dimension = dimension,
            .fields = std::vector(fields.size(), FieldKind::scalar),
            .rows = rows,
            .values = std::move(values)};
}

inline Outcome<Done> write_solution(const std::string& path, const MeshFile& mesh,
                                    const std::vector<Eigen::VectorXd>& fields) {
    const auto format = format_to_write(solution_formats(), path);
    if (!format) return fail(format.error());
    const auto chunks = (*format)->encode(solution_of(mesh, fields), Execution{});
    if (!chunks) return fail(chunks.error());
    std::ofstream file(path, std::ios::binary);
    for (const auto& chunk : *chunks)
        file.write(reinterpret_cast<const char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    file.close();
    if (!file) return fail(ErrorKind::input, "cannot be written", path, {}, "check the path");
    return Done{};
}

}  // namespace poisson

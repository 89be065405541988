#pragma once
// Meshes and fields for edge.cpp, and lengths of edges in them. The includer imports the modules before it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "paper_reference/back_field.hpp"
#include "paper_reference/of_mesh.hpp"

namespace edge_cases {

using namespace camber;

/// A mesh with a metric field, its volume edges, and the same field for the reference implementation of the paper.
struct EdgeCase {
    QuadraticMesh<3> mesh;
    Column<EdgeKind> kinds;
    Incidence<ElementId> shell;
    BackMesh<3> back;
    paper::BackField field;
    std::vector<EdgeId> edges;             ///< volume edges
    std::vector<double> straight_lengths;  ///< true_length of each edge with its node at the midpoint
};

/// Returns a rule of 16 pieces with 4 Gauss points each.
inline Quadrature true_rule() {
    constexpr int pieces = 16;
    const Quadrature gauss = gauss_legendre(4);
    Quadrature rule;
    for (int piece = 0; piece < pieces; ++piece)
        for (std::size_t q = 0; q < gauss.size(); ++q) {
            rule.t.push_back((piece + gauss.t[q]) / pieces);
            rule.w.push_back(gauss.w[q] / pieces);
        }
    return rule;
}

inline double true_length(const EdgeCase& c, EdgeId edge, const Vec<3>& node) {
    static const Quadrature rule = true_rule();
    const auto& [a, b] = c.mesh.edges.vertices[edge];
    const QuadraticEdge<3> curve{c.mesh.linear.points[a], {node}, c.mesh.linear.points[b]};
    return riemannian_length(c.back, curve, rule, c.shell[edge].front()).length;
}

inline EdgeCase case_of(const LinearMesh<3>& mesh, const Column<LogMetric<3>>& logs) {
    const Execution all;
    for (const auto& [p, q, r, s] : mesh.elements.vertices)
        if (!(signed_volume<3>(std::array{mesh.points[p], mesh.points[q], mesh.points[r], mesh.points[s]}) > 0))
            throw std::runtime_error("the mesh has inverted elements");
    EdgeCase c;
    c.mesh = elevate(mesh, all).value();
    c.kinds = find_features(mesh, c.mesh.edges, FeatureOptions<3>{}, all).value().edge_kinds;
    c.shell = shells(c.mesh.edges, all).value();
    const auto ball = balls(mesh, all).value();
    c.back = make_back_mesh(mesh, ball, logs, all).value();
    c.field = paper::field_of(mesh, neighbours(mesh, ball, all).value(), logs);
    for (std::size_t e = 0; e < c.mesh.edges.size(); ++e)
        if (c.kinds[e] == EdgeKind::volume && !c.shell[e].empty()) c.edges.emplace_back(e);
    for (const EdgeId e : c.edges) c.straight_lengths.push_back(true_length(c, e, c.mesh.mid_nodes[e].point));
    return c;
}

/// Returns the shell with layers of configs/layers.json as rows of prisms, in its natural metric.
inline EdgeCase natural_case() {
    ShellOptions<3> options;
    options.inner_size = 0.3;
    options.outer_size = 1.6;
    options.inner_layer = {.count = 8, .first_height = 0.02, .growth = 1.25};
    options.structure = ShellStructure::prisms;
    const LinearMesh<3> mesh = generate(options).value();
    const auto ball = balls(mesh, Execution{}).value();
    return case_of(mesh, Column<LogMetric<3>>(natural_log_metrics(mesh, ball, Execution{}).value()));
}

inline std::vector<std::byte> bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(path + ": cannot be read");
    const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
    const auto bytes = std::as_bytes(std::span(chars));
    return {bytes.begin(), bytes.end()};
}

/// Reads a mesh and tensors at its vertices. `paths` is "MESH,SOLUTION".
inline EdgeCase file_case(const std::string& paths) {
    const std::size_t comma = paths.find(',');
    if (comma == std::string::npos) throw std::runtime_error(paths + ": give MESH,SOLUTION");
    const std::string mesh_path = paths.substr(0, comma);
    const std::string solution_path = paths.substr(comma + 1);
    const auto decoded = decode_mesh(bytes_of(mesh_path), mesh_path, Execution{}).value();
    const auto solution = decode_solution(bytes_of(solution_path), solution_path, Execution{}).value().solution;
    const auto precision = solution.single_precision ? TensorPrecision::four_bytes : TensorPrecision::eight_bytes;
    auto logs = log_metrics_of_tensors<3>(solution.values.view(), precision, Execution{}).value();
    return case_of(mesh_as<LinearMesh<3>>(decoded.mesh).value(), Column<LogMetric<3>>(std::move(logs.log_metrics)));
}

/// Returns UGAWG polar-1 with its sizes multiplied by 0.77 (anisotropy 100), or the case of the files in
/// CAMBER_BENCH_POLAR. The mesh is a box mapped to the quarter of a pipe 0.2 ≤ r ≤ 0.9, with cells of about unit length
/// in the metric. Vertices are displaced along r and z only: chords around the layer sag by two layer sizes, so other
/// displacements would invert straight elements.
inline EdgeCase polar_case(const char* file) {
    if (file != nullptr) return file_case(file);
    const PolarOneField field{.scale = 0.77};
    const double growth = 2 * (field.size - field.min_size);
    // ∫ dr/h_r from the layer, and its inverse.
    const auto coordinate = [&](double distance) { return std::log1p(growth * distance / field.min_size) / growth; };
    const auto distance = [&](double rho) { return field.min_size / growth * std::expm1(growth * rho); };
    BoxOptions<3> box;
    box.low = {{-coordinate(0.3), 0, 0}};
    box.high = {{coordinate(0.4), 10, 1}};
    box.cells = {56, 10, 13};
    LinearMesh<3> mesh = generate(box).value();
    Buffer<Vec<3>> points = take(mesh.points);
    for (Vec<3>& p : points) {
        const double r = field.radius + std::copysign(distance(std::abs(p[0])), p[0]);
        const double angle = std::numbers::pi / 20 * std::round(p[1]);
        p = {{r * std::cos(angle), r * std::sin(angle), p[2]}};
    }
    mesh.points = std::move(points);
    return case_of(mesh, log_metrics_of<3>(AnalyticField<3>(field), mesh.points.view(), Execution{}).value());
}

/// Returns sizes 1e-7 and 0.1 whose axes rotate once across the unit box, sampled by 20 cells. The cells are much
/// larger than the requested sizes.
inline EdgeCase rotating_case() {
    BoxOptions<3> box;
    box.cells = {20, 20, 20};
    const LinearMesh<3> mesh = generate(box).value();
    const RotatingField field{.min_size = 1e-7, .size = 0.1, .period = 1};
    return case_of(mesh, log_metrics_of<3>(AnalyticField<3>(field), mesh.points.view(), Execution{}).value());
}

}  // namespace edge_cases

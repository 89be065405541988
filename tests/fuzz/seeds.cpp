#include "seeds.hpp"

#include "../io/generated.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.config;
import camber.io;
import camber.run;
import camber.shapes;

namespace fuzz {

namespace {

using namespace camber;

const std::vector<std::pair<std::string, GmfOptions>> formats{{"ascii.mesh", {GmfEncoding::ascii, 2}},
                                                              {"2.meshb", {GmfEncoding::binary, 2}},
                                                              {"3.meshb", {GmfEncoding::binary, 3}},
                                                              {"4.meshb", {GmfEncoding::binary, 4}}};

const std::vector<std::pair<std::string, MshOptions>> msh_formats{
    {"4-binary.msh", {MshVersion::v4, MshEncoding::binary}},
    {"4-ascii.msh", {MshVersion::v4, MshEncoding::ascii}},
    {"2-binary.msh", {MshVersion::v2, MshEncoding::binary}},
    {"2-ascii.msh", {MshVersion::v2, MshEncoding::ascii}}};

std::string text_of(const Chunks& chunks) { return generated::text_of(generated::joined(chunks)); }

template <class Mesh>
void add_mesh(std::vector<Seed>& seeds, const std::string& name, const Mesh& mesh) {
    for (const auto& [ending, options] : formats)
        seeds.push_back({"mesh", name + "-" + ending, text_of(*encode_gmf_mesh(mesh, options, {.threads = 1}))});
    for (const auto& [ending, options] : msh_formats)
        seeds.push_back({"mesh", name + "-" + ending, text_of(*encode_msh(mesh, {}, options, {.threads = 1}))});
}

template <int D>
void add_meshes(std::vector<Seed>& seeds) {
    const std::string dimension = std::to_string(D) + "d";
    // Coordinates without sense, and every block there is; a grid that is a mesh; its curved twin; a surface alone; in
    // 2D the grid and its twin as flat meshes.
    add_mesh(seeds, dimension + "-features", generated::mesh<D>(7, 2));
    BoxOptions<D> box;
    for (auto& cells : box.cells) cells = 1;
    const LinearMesh<D> grid = *generate(box);
    add_mesh(seeds, dimension + "-grid", grid);
    add_mesh(seeds, dimension + "-curved", *elevate(grid, {.threads = 1}));
    if constexpr (D == 2) {
        add_mesh(seeds, "flat-grid", *raised(grid, {}, {.threads = 1}));
        add_mesh(seeds, "flat-curved", *raised(*elevate(grid, {.threads = 1}), {.z = 1}, {.threads = 1}));
    }
    LinearMesh<D> surface = grid;
    surface.elements = {};
    add_mesh(seeds, dimension + "-surface", surface);
}

void add_solutions(std::vector<Seed>& seeds) {
    const std::vector<std::pair<std::string, std::vector<FieldKind>>> kinds{
        {"scalar", {FieldKind::scalar}},
        {"tensor", {FieldKind::symmetric_tensor}},
        {"all", {FieldKind::scalar, FieldKind::vector, FieldKind::symmetric_tensor, FieldKind::full_tensor}}};
    for (const int dimension : {2, 3})
        for (const auto& [kind, fields] : kinds) {
            Solution solution{.dimension = dimension, .fields = fields, .rows = 3};
            Buffer<double> values(3 * row_width(solution));
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.25 * static_cast<double>(i) - 1;
            solution.values = std::move(values);
            for (const auto& [ending, options] : formats)
                seeds.push_back({"solution", std::to_string(dimension) + "d-" + kind + "-" + ending,
                                 text_of(*encode_gmf_solution(solution, options, {.threads = 1}))});
        }
}

void add_configs(std::vector<Seed>& seeds) {
    const std::vector<std::pair<std::string, std::string>> texts{
        {"least", R"({"input": {"mesh": "a.mesh"}})"},
        {"flat", R"({"input": {"mesh": "a.mesh", "flat": "surface"}})"},
        {"shapes", R"({"input": {"generate": {"shell": {"inner_layer": {"count": 8}, "structure": "prisms"}}}})"},
        {"metric", R"({"input": {"mesh": "a"}, "metric": {"constant": {"sizes": [1, 2, 3]}},
  "metric_operations": [{"intersect": {"file": "b.sol"}}, "gradation", {"bound": {"max_size": 3}}]})"},
        {"geometry", R"({"input": {"mesh": "a"}, "geometry": {"analytic": [{"references": [1],
  "sphere": {"centre": [0, 0, 0], "radius": 5}}]}, "features": {"ridge_angle": 30}})"},
        {"stages", R"({"input": {"mesh": "a"}, "stages": ["elevate", {"curve": {"objective": "length"}},
  {"relax": {"strategy": "paper", "theta": 0.5}}, "commit"], "threads": 2, "output": {"mesh": "o.meshb"}})"},
        {"settings", "stages/curve/objective=length\noutput/vtu=a.vtu\n{\"input\": {\"mesh\": \"a\"}}"}};
    for (const auto& [name, text] : texts) seeds.push_back({"config", name + ".json", text});
    auto pipeline = config::read_pipeline(texts[0].second, "seed");
    seeds.push_back({"config", "defaults.json", config::write_pipeline(*pipeline)});
    seeds.push_back({"config", "metric-alone.json", R"({"field": {"polar-1": {"scale": 0.5}}})"});
    seeds.push_back({"config", "geometry-alone.json", R"({"analytic": [{"references": [1, 2],
  "plane": {"point": [0, 0], "normal": [0, 1]}}]})"});
}

void add_reports(std::vector<Seed>& seeds) {
    run::Report report;
    run::Histogram h{run::Quantity::length, {0.5, 1, 2}, {}};
    h.series = {run::counted("before", h.limits, std::vector<double>{0.1, 0.7, 1.3}),
                run::counted("after", h.limits, std::vector<double>{0.6, 1.1, 9})};
    report.histograms = {h};
    seeds.push_back({"report", "report.json", run::to_json(report)});
    report.histograms = {};
    seeds.push_back({"report", "none.json", run::to_json(report)});
}

}  // namespace

std::vector<Seed> seeds() {
    std::vector<Seed> all;
    add_meshes<2>(all);
    add_meshes<3>(all);
    add_solutions(all);
    add_configs(all);
    add_reports(all);
    for (const auto& [name, text] :
         std::vector<std::pair<std::string, std::string>>{{"size", "0.1 + 0.2*abs(x)"},
                                                          {"sizes", "0.1\nx < 0 ? 1 : 2^y\nmax(0.3, tanh(z))"},
                                                          {"tensor", "4\n0\n2^2\n0\n0\nsqrt(16)"}})
        all.push_back({"expression", name, text});
    return all;
}

}  // namespace fuzz

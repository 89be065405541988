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
import camber.recipes;
import camber.reports;
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

template <int D>
void add_mesh(std::vector<Seed>& seeds, const std::string& name, const Mesh<D>& mesh) {
    for (const auto& [ending, options] : formats)
        seeds.push_back({"mesh", name + "-" + ending, text_of(*encode_gmf_mesh(mesh, options, {.threads = 1}))});
    for (const auto& [ending, options] : msh_formats)
        seeds.push_back({"mesh", name + "-" + ending, text_of(*encode_msh(mesh, {}, options, {.threads = 1}))});
}

template <int D>
void add_mesh_of_others(std::vector<Seed>& seeds, const std::string& name, const Mesh<D>& mesh) {
    seeds.push_back({"mesh", name + ".vtu", text_of(*encode_vtu(mesh, {}, {}, {.threads = 1}))});
    seeds.push_back({"mesh", name + ".mfem", text_of(*encode_mfem(mesh, {.threads = 1}))});
    for (const VtkEncoding encoding : {VtkEncoding::ascii, VtkEncoding::binary})
        seeds.push_back({"mesh", name + (encoding == VtkEncoding::ascii ? "-ascii.vtk" : "-binary.vtk"),
                         text_of(*encode_vtk(mesh, {}, encoding, {.threads = 1}))});
    for (const StlEncoding encoding : {StlEncoding::ascii, StlEncoding::binary})
        seeds.push_back({"mesh", name + (encoding == StlEncoding::ascii ? "-ascii.stl" : "-binary.stl"),
                         text_of(*encode_stl(mesh, encoding, {.threads = 1}))});
}

/// Adds files in forms that Camber reads and does not write.
void add_meshes_of_others(std::vector<Seed>& seeds) {
    const std::string grid = R"(<VTKFile type="UnstructuredGrid" byte_order="BigEndian" header_type="UInt32">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="2"><PointData>
<DataArray type="Float32" Name="t" format="ascii">0 1 2 3</DataArray></PointData><CellData>
<DataArray type="Int64" Name="entity" format="ascii">7 0</DataArray></CellData><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3 0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4 7</DataArray>
)";
    const std::string end = "</Cells></Piece></UnstructuredGrid>";
    seeds.push_back(
        {"mesh", "ascii.vtu",
         grid + R"(<DataArray type="UInt8" Name="types" format="ascii">10 5</DataArray>)" + end + "</VTKFile>\n"});
    seeds.push_back(
        {"mesh", "base64.vtu",
         grid + R"(<DataArray type="UInt8" Name="types" format="binary">AAAAAgoF</DataArray>)" + end + "</VTKFile>\n"});
    seeds.push_back({"mesh", "appended.vtu",
                     grid + R"(<DataArray type="UInt8" Name="types" format="appended" offset="0"/>)" + end +
                         "<AppendedData encoding=\"base64\">_AAAAAgoF</AppendedData></VTKFile>\n"});
    seeds.push_back({"mesh", "2d.su2",
                     "% a square\nNDIME= 2\nNELEM= 2\n5 0 1 2 0\n5 0 2 3 1\nNPOIN= 4\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n"
                     "NMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\n"
                     "SEND_TO= 1\n1 0 0\n"});
    seeds.push_back({"mesh", "3d.su2",
                     "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nNMARK= 1\n"
                     "MARKER_TAG= far\nMARKER_ELEMS= 1\n5 0 2 1\n"});
    seeds.push_back({"mesh", "zones.su2",
                     "NZONE= 2\nIZONE= 1\nNDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3 3\n0 0 0 0\n1 0 1 1\n0 1 2 2\n"
                     "IZONE= 2\nNDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n5 0 0. 0\n6 0 0. 1\n5 1 1. 2"});
    seeds.push_back({"mesh", "names.mfem",
                     "MFEM mesh v1.3\ndimension\n2\nelements\n1\n1 2 0 1 2\nattribute_sets\n1\n\"a b\" 1 1\n"
                     "boundary\n1\n1 1 0 1\nbdr_attribute_sets\n1\nwall 2 1 2\nvertices\n3\n2\n0 0 1 0 0 1\n"
                     "mfem_mesh_end\n"});
    seeds.push_back({"mesh", "1.msh",
                     "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n2\n1 1 6 3 2 1 1\n"
                     "2 4 4 1 4 1 2 3 4\n$ENDELM\na remark\n"});
    seeds.push_back({"mesh", "4.0.msh",
                     "$MeshFormat\n4.0 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 4 0\n$EndEntities\n"
                     "$Nodes\n1 4\n1 3 0 4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1 1\n"
                     "1 3 4 1\n1 1 2 3 4\n$EndElements\n"});
    seeds.push_back({"mesh", "5.1.vtk",
                     "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                     "0 0 0 1 0 0 0 1 0 0 0 1\nMETADATA\nINFORMATION 0\n\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\n"
                     "CONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\nCELL_DATA 1\nSCALARS material int 1\n"
                     "LOOKUP_TABLE default\n3\nPOINT_DATA 4\nVECTORS u float\n1 2 3 4 5 6 7 8 9 10 11 12\n"});
    seeds.push_back({"mesh", "solids.stl",
                     "solid a b\nfacet normal nan nan nan\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\n"
                     "endloop\nendfacet\nendsolid\nSOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX -0 1 0\n"
                     "VERTEX 1 0 0\nVERTEX 1 1 .5\nENDLOOP\nENDFACET\nfacet normal 0 0 0\nouter loop\n"
                     "vertex 0 0 0\nvertex 0 0 0\nvertex 0 1 0\nendloop\nendfacet\nENDSOLID\n"});
    seeds.push_back({"mesh", "by-nodes.mfem",
                     "MFEM mesh v1.0\n# H1\ndimension\n2\nelements\n1\n1 2 0 1 2\nboundary\n1\n1 1 0 1\nvertices\n3\n"
                     "nodes\nFiniteElementSpace\nFiniteElementCollection: Quadratic\nVDim: 2\nOrdering: 0\n"
                     "0 1 0 .5 .5 0\n0 0 1 -.1 .5 .5\n"});
}

template <int D>
void add_meshes(std::vector<Seed>& seeds) {
    const std::string dimension = std::to_string(D) + "d";
    // A mesh with arbitrary coordinates and every block; a valid grid; the same grid curved; a standalone surface. In
    // 2D also the straight and curved grids as flat meshes.
    add_mesh(seeds, dimension + "-features", as_mesh(generated::mesh<D>(7, 2)));
    BoxOptions<D> box;
    for (auto& cells : box.cells) cells = 1;
    const LinearMesh<D> grid = *generate(box);
    add_mesh(seeds, dimension + "-grid", as_mesh(grid));
    add_mesh(seeds, dimension + "-curved", as_mesh(*elevate(grid, {.threads = 1})));
    add_mesh_of_others(seeds, dimension + "-grid", as_mesh(grid));
    add_mesh_of_others(seeds, dimension + "-curved", as_mesh(*elevate(grid, {.threads = 1})));
    if constexpr (D == 2) {
        add_mesh(seeds, "flat-grid", *raised(as_mesh(grid), {}, {.threads = 1}));
        add_mesh(seeds, "flat-curved", *raised(as_mesh(*elevate(grid, {.threads = 1})), {.z = 1}, {.threads = 1}));
    }
    LinearMesh<D> surface = grid;
    surface.elements = {};
    add_mesh(seeds, dimension + "-surface", as_mesh(surface));
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
    add_meshes_of_others(all);
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

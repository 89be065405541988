module;
#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import :mfem_curves;
import :mfem_order;
import :mfem_sections;
import :mfem_source;

namespace camber {

namespace mfem {

namespace {

/// The simplices of one dimension.
template <int K, int D>
listing::Simplices<K>& simplices_of(listing::Mesh<D>& mesh) {
    if constexpr (K == D)
        return mesh.elements;
    else if constexpr (K == D - 1)
        return mesh.facets;
    else
        return mesh.edges;
}

/// The line behind all, where the version has one. Parallel meshes have another there, and more behind it.
Outcome<Done> read_end(Source& source, std::vector<Notice>& notices) {
    if (source.has_end && !source.words.next().ends_with("mesh_end"))
        return source.fail_here("\"mfem_mesh_end\" is missing here");
    // Without a sign after it the last number may be the beginning of another.
    if (!source.has_end && source.words.at == source.words.end && !is_blank(source.text.back()))
        notices.push_back({"the last line has no end: the file may be cut off within its last number"});
    if (source.words.find()) notices.push_back({"what follows the vertices was left out"});
    return Done{};
}

/// A mesh of dimension K in D dimensions.
template <int K, int D>
Outcome<DecodedMesh> read_mesh(Source& source, const Vertices& vertices, Topology<K> topology,
                               const Execution& execution) {
    auto& [elements, boundary, groups, refused] = topology;
    listing::Mesh<D> mesh;
    mesh.name = source.name;
    EdgeNumbers numbers;
    const bool quadratic = vertices.field.order == 2;
    // Only vertices that there are have edges: a node further on would be taken for a vertex.
    const auto known = [&](const auto& rows) {
        return std::all_of(rows.nodes.begin(), rows.nodes.end(), [&](const auto& simplex) {
            return std::all_of(simplex.begin(), simplex.end(),
                               [&](VertexId v) { return v.valid() && v.index() < vertices.count; });
        });
    };
    const bool sound = known(elements.straight) && known(boundary.straight);
    if (quadratic && sound) numbers = number_edges<K>(elements.straight);
    auto points = read_points<D>(source, vertices.count + numbers.size(), vertices.field.by_components);
    if (!points) return fail(std::move(points.error()));
    mesh.points = std::move(*points);
    mesh.point_references = Buffer<Reference>(mesh.points.size(), 0);
    simplices_of<K>(mesh) = std::move(elements);
    simplices_of<K - 1>(mesh) = std::move(boundary);
    mesh.groups = std::move(groups);
    if (auto checked = listing::check(mesh, execution); !checked) return fail(std::move(checked.error()));
    std::vector<Notice> notices;
    if (quadratic) {
        if (const std::size_t strays = drop_strays<K - 1>(simplices_of<K - 1>(mesh).straight, numbers); strays > 0)
            notices.push_back({std::to_string(strays) +
                               " boundary elements with an edge of no element were left out: MFEM has no nodes of it"});
        auto curved = curve<K>(simplices_of<K>(mesh), numbers, vertices.count).and_then([&](Done) {
            return curve<K - 1>(simplices_of<K - 1>(mesh), numbers, vertices.count);
        });
        if (!curved) return fail(std::move(curved.error()));
    }
    if (auto ended = read_end(source, notices); !ended) return fail(std::move(ended.error()));
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
}

/// How many there are of what, where not all of it is held: the nodes of curved ones cannot be told apart then.
template <int K>
DecodedMesh counted(const Topology<K>& topology) {
    DecodedMesh decoded{LinearMesh<3>{}, {}};
    Refused all = topology.refused;
    const auto add = [&](const auto& simplices, int dimension) {
        if (simplices.straight.size() > 0)
            all.count(geometries[static_cast<std::size_t>(dimension == 3 ? 4 : dimension)].plural,
                      simplices.straight.size());
    };
    add(topology.elements, K);
    add(topology.boundary, K - 1);
    decoded.unheld = all.counts();
    return decoded;
}

template <int K>
Outcome<DecodedMesh> read_of_dimension(Source& source, Unheld unheld, const Execution& execution) {
    const std::string begin = source.place(source.words.at);
    auto topology = read_topology<K>(source);
    if (!topology) return fail(std::move(topology.error()));
    if (auto held = topology->refused.verdict(begin, unheld); !held) return fail(std::move(held.error()));
    if (topology->refused.any()) return counted(*topology);
    const auto vertices = read_vertices_head(source);
    if (!vertices) return fail(vertices.error());
    const int components = vertices->field.components;
    if (components < K)
        return source.fail_here("vertices have " + std::to_string(components) + " coordinates in a mesh of dimension " +
                                std::to_string(K));
    if constexpr (K == 2)
        if (components == 2) return read_mesh<2, 2>(source, *vertices, std::move(*topology), execution);
    return read_mesh<K, 3>(source, *vertices, std::move(*topology), execution);
}

Outcome<DecodedMesh> read(Source source, Unheld unheld, const Execution& execution) {
    if (source.text.empty()) return source.fail_here("the file is empty", "write it anew");
    const std::string_view line = first_line_of(source.text);
    const bool has_end = line == first_line_of_names || line == "MFEM mesh v1.2";
    if (line != first_line && !has_end) {
        if (!line.starts_with("MFEM "))
            return source.fail_here("does not begin with \"MFEM mesh v1.0\"", "give an MFEM mesh");
        return source.refuse_here("is of another version or kind than \"MFEM mesh v1.0\", 1.2 and 1.3",
                                  "write the conforming mesh by Mesh::Print");
    }
    source.has_end = has_end;
    source.words.at += line.size();
    if (auto begun = source.expect("dimension"); !begun) return fail(begun.error());
    const auto dimension = source.number("dimensions");
    if (!dimension) return fail(dimension.error());
    if (*dimension == 2) return read_of_dimension<2>(source, unheld, execution);
    if (*dimension == 3) return read_of_dimension<3>(source, unheld, execution);
    return source.refuse_here("is of dimension " + std::to_string(*dimension),
                              "Camber takes meshes of triangles and tetrahedra");
}

}  // namespace

}  // namespace mfem

Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                 const Execution& execution) {
    return guarded([&] {
        const std::string_view text = mfem::text_of(bytes);
        return mfem::read({std::string(name), text, {text.data(), text.data() + text.size()}}, options.unheld,
                          execution);
    });
}

bool is_mfem(std::span<const std::byte> bytes) {
    const std::string_view line = mfem::first_line_of(mfem::text_of(bytes).substr(0, 200));
    return line.starts_with("MFEM ") && line.find("mesh v") != std::string_view::npos;
}

}  // namespace camber

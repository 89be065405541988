// Reads MFEM meshes: topology, nodes, names.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::mfem {

namespace {

/// Returns a function that returns the position of row i for messages. It reads all earlier rows, because rows differ
/// in length.
auto place_of_rows(const Source& source) {
    return [source](std::size_t row) {
        Words words = source.words;
        for (; row > 0; --row) {
            std::int64_t attribute = 0, kind = 0;
            static_cast<void>(read_number(words, attribute) && read_number(words, kind));
            words.skip(geometries[static_cast<std::size_t>(kind) % geometries.size()].vertices);
        }
        static_cast<void>(words.find());
        return source.place(words.at);
    };
}

template <int K>
Outcome<Done> read_rows(Source& source, const std::string& title, const std::string& noun, listing::Rows<K + 1>& rows,
                        UnsupportedItems& refused) {
    if (auto started = source.expect(title); !started) return started;
    const auto count = source.count(title == "boundary" ? "boundary elements" : "elements", 3);
    if (!count) return fail(count.error());
    rows.nodes.reserve(*count);
    rows.references.reserve(*count);
    rows.origin = {noun, {}, place_of_rows(source)};
    for (std::size_t i = 0; i < *count; ++i) {
        const auto bad_row = [&](const std::string& what) {
            return fail(ErrorKind::input, what, source.place(source.words.at), Entity{noun, i + 1}, damaged);
        };
        std::int64_t attribute = 0, kind = 0;
        if (!read_number(source.words, attribute) || !read_number(source.words, kind))
            return bad_row("a number is missing or malformed");
        if (!std::in_range<Reference>(attribute)) return bad_row("the attribute does not fit 32 bits");
        if (kind < 0 || static_cast<std::size_t>(kind) >= geometries.size())
            return bad_row("its geometry " + std::to_string(kind) + " is not one of MFEM");
        const Geometry& shape = geometries[static_cast<std::size_t>(kind)];
        std::array<std::int64_t, 8> vertices{};
        for (std::size_t n = 0; n < shape.vertices; ++n)
            if (!read_number(source.words, vertices[n])) return bad_row("a number is missing or malformed");
        if (kind != geometry<K>) {
            refused.count(shape.plural);
            continue;
        }
        std::array<VertexId, K + 1> simplex;
        for (std::size_t n = 0; n <= K; ++n)
            if (vertices[n] >= 0 && static_cast<std::uint64_t>(vertices[n]) <= max_entities)
                simplex[n] = VertexId(static_cast<std::size_t>(vertices[n]));
        rows.nodes.push_back(simplex);
        rows.references.push_back(static_cast<Reference>(attribute));
    }
    return Done{};
}

Outcome<std::string> read_name(Source& source) {
    Words& words = source.words;
    if (!words.find()) return source.fail_at_line("the name of a set is missing");
    if (*words.at != '"') return std::string(words.next());
    const std::string_view rest(words.at + 1, static_cast<std::size_t>(words.end - words.at) - 1);
    const std::size_t end = rest.find_first_of("\"\n");
    if (end == std::string_view::npos || rest[end] != '"')
        return source.fail_at_line("the name of a set does not end on its line");
    words.at += end + 2;
    return std::string(rest.substr(0, end));
}

Outcome<Done> read_sets(Source& source, std::string_view title, int dimension, Buffer<Group>& groups) {
    Words ahead = source.words;
    if (ahead.next() != title) return Done{};
    source.words = ahead;
    const auto count = source.count("sets of attributes", 2);
    if (!count) return fail(count.error());
    for (std::size_t i = 0; i < *count; ++i) {
        const auto name = read_name(source);
        if (!name) return fail(name.error());
        const auto size = source.count("attributes of a set", 1);
        if (!size) return fail(size.error());
        for (std::size_t k = 0; k < *size; ++k) {
            const auto attribute = source.number("attributes");
            if (!attribute) return fail(attribute.error());
            if (!std::in_range<Reference>(*attribute)) return source.fail_at_line("an attribute does not fit 32 bits");
            groups.push_back({dimension, static_cast<Reference>(*attribute), *name});
        }
    }
    return Done{};
}

}  // namespace

template <int K>
Outcome<Topology<K>> read_topology(Source& source) {
    Topology<K> result;
    auto read = read_rows<K>(source, "elements", "element", result.elements.straight, result.refused)
                    .and_then([&](Done) { return read_sets(source, "attribute_sets", K, result.groups); })
                    .and_then([&](Done) {
                        return read_rows<K - 1>(source, "boundary", "boundary element", result.boundary.straight,
                                                result.refused);
                    })
                    .and_then([&](Done) { return read_sets(source, "bdr_attribute_sets", K - 1, result.groups); });
    if (!read) return fail(std::move(read.error()));
    return result;
}

template Outcome<Topology<2>> read_topology<2>(Source&);
template Outcome<Topology<3>> read_topology<3>(Source&);

namespace {

std::optional<int> order_of(std::string_view collection) {
    if (collection == "Linear" || collection == "H1_2D_P1" || collection == "H1_3D_P1") return 1;
    if (collection == "Quadratic" || collection == "H1_2D_P2" || collection == "H1_3D_P2") return 2;
    return std::nullopt;
}

Outcome<NodeField> read_field_head(Source& source) {
    NodeField field;
    if (auto started = source.expect("FiniteElementSpace"); !started) return fail(started.error());
    if (auto started = source.expect("FiniteElementCollection:"); !started) return fail(started.error());
    const auto order = order_of(source.words.next());
    if (!order)
        return source.reject_at_line("its nodes do not belong to the space H1 of order 1 or 2",
                                     "project them with Mesh::SetCurvature(2)");
    field.order = *order;
    if (auto started = source.expect("VDim:"); !started) return fail(started.error());
    const auto components = source.number("components");
    if (!components) return fail(components.error());
    if (auto started = source.expect("Ordering:"); !started) return fail(started.error());
    const auto ordering = source.number("the ordering");
    if (!ordering) return fail(ordering.error());
    if ((*components != 2 && *components != 3) || (*ordering != 0 && *ordering != 1))
        return source.fail_at_line("VDim is not 2 or 3, or Ordering not 0 or 1");
    field.components = static_cast<int>(*components);
    field.by_components = *ordering == 0;
    return field;
}

}  // namespace

Outcome<Vertices> read_vertices_head(Source& source) {
    Vertices vertices;
    if (auto started = source.expect("vertices"); !started) return fail(started.error());
    const auto count = source.count("vertices", 1);
    if (!count) return fail(count.error());
    vertices.count = *count;
    Words ahead = source.words;
    vertices.has_nodes = ahead.next() == "nodes";
    if (vertices.has_nodes) {
        source.words = ahead;
        auto field = read_field_head(source);
        if (!field) return fail(std::move(field.error()));
        vertices.field = *field;
        return vertices;
    }
    const auto components = source.number("coordinates of a vertex");
    if (!components) return fail(components.error());
    if (*components != 2 && *components != 3)
        return source.fail_at_line("vertices have " + std::to_string(*components) + " coordinates, not 2 or 3");
    vertices.field.components = static_cast<int>(*components);
    return vertices;
}

template <int D>
Outcome<Buffer<Vec<D>>> read_points(Source& source, std::size_t count, bool by_components) {
    if (count > source.left() / 2 + 1)
        return source.fail_at_line(std::to_string(count) + " nodes are required, but fewer follow");
    Buffer<Vec<D>> points(count);
    for (std::size_t i = 0; i < count * D; ++i) {
        const std::size_t node = by_components ? i % count : i / D, component = by_components ? i / count : i % D;
        if (!read_number(source.words, points[node][static_cast<int>(component)]))
            return source.fail_at_line("coordinate " + std::to_string(i + 1) + " of " + std::to_string(count * D) +
                                       " is missing or malformed");
    }
    return points;
}

template Outcome<Buffer<Vec<2>>> read_points<2>(Source&, std::size_t, bool);
template Outcome<Buffer<Vec<3>>> read_points<3>(Source&, std::size_t, bool);

}  // namespace camber::mfem

namespace camber {

namespace mfem {

namespace {

template <int K, int D>
listing::Simplices<K>& simplices_of(listing::Mesh<D>& mesh) {
    if constexpr (K == D)
        return mesh.elements;
    else if constexpr (K == D - 1)
        return mesh.facets;
    else
        return mesh.edges;
}

/// Checks the end line. A parallel mesh has another end line and more data, which is dropped with a notice.
Outcome<Done> read_end(Source& source, std::vector<Notice>& notices) {
    if (source.has_end && !source.words.next().ends_with("mesh_end"))
        return source.fail_at_line("\"mfem_mesh_end\" is missing here");
    // The last number may be truncated if the file ends with it.
    if (!source.has_end && source.words.at == source.words.end && !is_blank(source.text.back()))
        notices.push_back({"the last line has no end: the file may be cut off within its last number"});
    if (source.words.find()) notices.push_back({"all data after the vertices was left out"});
    return Done{};
}

template <int K, int D>
Outcome<DecodedMesh> read_mesh(Source& source, const Vertices& vertices, Topology<K> topology,
                               const Execution& execution) {
    auto& [elements, boundary, groups, refused] = topology;
    listing::Mesh<D> mesh;
    mesh.name = source.name;
    EdgeNumbers numbers;
    const bool quadratic = vertices.field.order == 2;
    // Edges are numbered only if all vertices exist, because numbers beyond the vertices would collide with those of
    // edge nodes.
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
        if (const std::size_t isolated = drop_isolated_boundary<K - 1>(simplices_of<K - 1>(mesh).straight, numbers);
            isolated > 0)
            notices.push_back({std::to_string(isolated) +
                               " boundary elements with an edge that belongs to no element were left out: MFEM has no "
                               "nodes for such edges"});
        auto curved = curve<K>(simplices_of<K>(mesh), numbers, vertices.count).and_then([&](Done) {
            return curve<K - 1>(simplices_of<K - 1>(mesh), numbers, vertices.count);
        });
        if (!curved) return fail(std::move(curved.error()));
    }
    if (auto ended = read_end(source, notices); !ended) return fail(std::move(ended.error()));
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
}

/// Counts all elements without building a mesh: nodes of curved elements cannot be assigned if some elements are
/// unsupported.
template <int K>
DecodedMesh counted(const Topology<K>& topology) {
    DecodedMesh decoded{Mesh<3>{}, {}};
    UnsupportedItems all = topology.refused;
    const auto add = [&](const auto& simplices, int dimension) {
        if (simplices.straight.size() > 0)
            all.count(geometries[static_cast<std::size_t>(dimension == 3 ? 4 : dimension)].plural,
                      simplices.straight.size());
    };
    add(topology.elements, K);
    add(topology.boundary, K - 1);
    decoded.unsupported_cells = all.counts();
    return decoded;
}

template <int K>
Outcome<DecodedMesh> read_of_dimension(Source& source, UnsupportedCells unsupported_cells, const Execution& execution) {
    const std::string begin = source.place(source.words.at);
    auto topology = read_topology<K>(source);
    if (!topology) return fail(std::move(topology.error()));
    if (auto supported = topology->refused.verdict(begin, unsupported_cells); !supported)
        return fail(std::move(supported.error()));
    if (topology->refused.any()) return counted(*topology);
    const auto vertices = read_vertices_head(source);
    if (!vertices) return fail(vertices.error());
    const int components = vertices->field.components;
    if (components < K)
        return source.fail_at_line("vertices have " + std::to_string(components) +
                                   " coordinates in a mesh of dimension " + std::to_string(K));
    if constexpr (K == 2)
        if (components == 2) return read_mesh<2, 2>(source, *vertices, std::move(*topology), execution);
    return read_mesh<K, 3>(source, *vertices, std::move(*topology), execution);
}

Outcome<DecodedMesh> read(Source source, UnsupportedCells unsupported_cells, const Execution& execution) {
    if (source.text.empty()) return source.fail_at_line("the file is empty", "write it again");
    const std::string_view line = first_line_of(source.text);
    const bool has_end = line == first_line_of_names || line == "MFEM mesh v1.2";
    if (line != first_line && !has_end) {
        if (!line.starts_with("MFEM "))
            return source.fail_at_line("does not begin with \"MFEM mesh v1.0\"", "give an MFEM mesh");
        return source.reject_at_line("has a version or kind other than \"MFEM mesh v1.0\", 1.2 and 1.3",
                                     "write the conforming mesh by Mesh::Print");
    }
    source.has_end = has_end;
    source.words.at += line.size();
    if (auto started = source.expect("dimension"); !started) return fail(started.error());
    const auto dimension = source.number("dimensions");
    if (!dimension) return fail(dimension.error());
    if (*dimension == 2) return read_of_dimension<2>(source, unsupported_cells, execution);
    if (*dimension == 3) return read_of_dimension<3>(source, unsupported_cells, execution);
    return source.reject_at_line("is of dimension " + std::to_string(*dimension),
                                 "Camber reads meshes of triangles and tetrahedra");
}

}  // namespace

}  // namespace mfem

Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                 const Execution& execution) {
    return guarded([&] {
        const std::string_view text = mfem::text_of(bytes);
        return mfem::read({std::string(name), text, {text.data(), text.data() + text.size()}},
                          options.unsupported_cells, execution);
    });
}

bool is_mfem(std::span<const std::byte> bytes) {
    const std::string_view line = mfem::first_line_of(mfem::text_of(bytes).substr(0, 200));
    return line.starts_with("MFEM ") && line.find("mesh v") != std::string_view::npos;
}

}  // namespace camber

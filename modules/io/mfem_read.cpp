module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace mfem {

namespace {

constexpr const char* damaged = "the file is cut off or damaged";

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The first line without what blanks end it.
std::string_view first_line_of(std::string_view text) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const std::size_t last = line.find_last_not_of(" \t\r");
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

/// The words of a file, and errors at their places.
struct Source {
    std::string name;
    std::string_view text;
    Words words;
    bool has_end = false;  ///< a line behind all that there is: since version 1.2

    [[nodiscard]] std::string place(const char* at) const { return line_place(name, text, at); }
    [[nodiscard]] auto fail_here(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] auto refuse_here(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(words.end - words.at); }

    [[nodiscard]] Outcome<Done> expect(std::string_view word) {
        if (words.next() == word) return Done{};
        return fail_here("\"" + std::string(word) + "\" is missing here",
                         "the sections of MFEM's files have one order; " + std::string(damaged));
    }
    [[nodiscard]] Outcome<std::int64_t> number(const std::string& what) {
        std::int64_t value = 0;
        if (!read_number(words, value)) return fail_here("the number of " + what + " is missing or malformed");
        return value;
    }
    /// A number of rows of so many words at least.
    [[nodiscard]] Outcome<std::size_t> count(const std::string& what, std::size_t min_words) {
        const auto value = number(what);
        if (!value) return fail(value.error());
        if (*value < 0 || static_cast<std::uint64_t>(*value) > left() / (2 * min_words) + 1)
            return fail_here("announces " + std::to_string(*value) + " " + what + ", more than follow");
        if (static_cast<std::uint64_t>(*value) > max_entities)
            return refuse_here("has more " + what + " than 32 bits can number", "divide the mesh");
        return static_cast<std::size_t>(*value);
    }
};

// ---------------------------------------------------------------- elements

struct Geometry {
    std::size_t vertices;
    const char* plural;
};
/// By MFEM's numbers.
constexpr std::array<Geometry, 8> geometries{{{1, "points"},
                                              {2, "segments"},
                                              {3, "triangles"},
                                              {4, "quadrilaterals"},
                                              {4, "tetrahedra"},
                                              {8, "hexahedra"},
                                              {6, "prisms"},
                                              {5, "pyramids"}}};

/// Where row i of rows that begin here stands: they are walked through, since their lengths differ.
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

/// Rows `attribute geometry vertices…`; those that are no K-simplices are counted in `refused`.
template <int K>
Outcome<Done> read_rows(Source& source, const std::string& title, const std::string& noun, listing::Rows<K + 1>& rows,
                        Refused& refused) {
    if (auto begun = source.expect(title); !begun) return begun;
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
            return bad_row("its geometry " + std::to_string(kind) + " is none of MFEM's");
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

// ---------------------------------------------------------------- names

/// A name, which may be in quotes.
Outcome<std::string> read_name(Source& source) {
    Words& words = source.words;
    if (!words.find()) return source.fail_here("the name of a set is missing");
    if (*words.at != '"') return std::string(words.next());
    const std::string_view rest(words.at + 1, static_cast<std::size_t>(words.end - words.at) - 1);
    const std::size_t end = rest.find_first_of("\"\n");
    if (end == std::string_view::npos || rest[end] != '"')
        return source.fail_here("the name of a set does not end in its line");
    words.at += end + 2;
    return std::string(rest.substr(0, end));
}

/// Named sets of attributes, where there is a section of that title: groups of so many dimensions.
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
            if (!std::in_range<Reference>(*attribute)) return source.fail_here("an attribute does not fit 32 bits");
            groups.push_back({dimension, static_cast<Reference>(*attribute), *name});
        }
    }
    return Done{};
}

// ---------------------------------------------------------------- nodes

/// The field that says where the nodes are.
struct NodeField {
    int order = 1, components = 0;
    bool by_components = false;  ///< Ordering 0: all x, then all y
};

std::optional<int> order_of(std::string_view collection) {
    if (collection == "Linear" || collection == "H1_2D_P1" || collection == "H1_3D_P1") return 1;
    if (collection == "Quadratic" || collection == "H1_2D_P2" || collection == "H1_3D_P2") return 2;
    return std::nullopt;
}

Outcome<NodeField> read_field_head(Source& source) {
    NodeField field;
    if (auto begun = source.expect("FiniteElementSpace"); !begun) return fail(begun.error());
    if (auto begun = source.expect("FiniteElementCollection:"); !begun) return fail(begun.error());
    const auto order = order_of(source.words.next());
    if (!order)
        return source.refuse_here("its nodes are of another space than H1 of order 1 or 2",
                                  "project them with Mesh::SetCurvature(2)");
    field.order = *order;
    if (auto begun = source.expect("VDim:"); !begun) return fail(begun.error());
    const auto components = source.number("components");
    if (!components) return fail(components.error());
    if (auto begun = source.expect("Ordering:"); !begun) return fail(begun.error());
    const auto ordering = source.number("the ordering");
    if (!ordering) return fail(ordering.error());
    if ((*components != 2 && *components != 3) || (*ordering != 0 && *ordering != 1))
        return source.fail_here("VDim is not 2 or 3, or Ordering not 0 or 1");
    field.components = static_cast<int>(*components);
    field.by_components = *ordering == 0;
    return field;
}

/// Where the nodes are, and how many there are.
struct Vertices {
    std::size_t count = 0;
    NodeField field;
    bool has_nodes = false;
};

Outcome<Vertices> read_vertices_head(Source& source) {
    Vertices vertices;
    if (auto begun = source.expect("vertices"); !begun) return fail(begun.error());
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
        return source.fail_here("vertices have " + std::to_string(*components) + " coordinates, not 2 or 3");
    vertices.field.components = static_cast<int>(*components);
    return vertices;
}

template <int D>
Outcome<Buffer<Vec<D>>> read_points(Source& source, std::size_t count, bool by_components) {
    if (count > source.left() / 2 + 1)
        return source.fail_here(std::to_string(count) + " nodes are wanted, more than follow");
    Buffer<Vec<D>> points(count);
    for (std::size_t i = 0; i < count * D; ++i) {
        const std::size_t node = by_components ? i % count : i / D, component = by_components ? i / count : i % D;
        if (!read_number(source.words, points[node][static_cast<int>(component)]))
            return source.fail_here("coordinate " + std::to_string(i + 1) + " of " + std::to_string(count * D) +
                                    " is missing or malformed");
    }
    // Without a sign after it the last number may be the beginning of another.
    if (source.words.at == source.words.end && count > 0)
        return source.fail_here("the file ends within its last number, or without the end of a line",
                                "it seems to be cut off; if it is whole, end its last line");
    return points;
}

// ---------------------------------------------------------------- degree 2

/// MFEM's numbers of edges, by their ends.
class EdgeNumbers {
  public:
    void add(VertexId a, VertexId b) { numbers_.try_emplace(key(a, b), static_cast<std::uint32_t>(numbers_.size())); }
    [[nodiscard]] std::optional<std::size_t> find(VertexId a, VertexId b) const {
        const auto found = numbers_.find(key(a, b));
        if (found == numbers_.end()) return std::nullopt;
        return found->second;
    }
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }

  private:
    static std::uint64_t key(VertexId a, VertexId b) {
        return std::uint64_t{std::min(a.value, b.value)} << 32U | std::max(a.value, b.value);
    }
    std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
};

template <int K>
EdgeNumbers number_edges(const listing::Rows<K + 1>& elements) {
    EdgeNumbers numbers;
    for (const auto& element : elements.nodes)
        for (const int k : edge_order<K>) numbers.add(element[local_edges<K>[k][0]], element[local_edges<K>[k][1]]);
    return numbers;
}

/// Leaves out simplices of the boundary with an edge of no element, for which there are no nodes. How many they are.
template <int K>
std::size_t drop_strays(listing::Rows<K + 1>& rows, const EdgeNumbers& numbers) {
    std::size_t kept = 0;
    const std::size_t before = rows.size();
    for (std::size_t i = 0; i < before; ++i) {
        const auto& simplex = rows.nodes[i];
        const bool known = std::all_of(local_edges<K>.begin(), local_edges<K>.end(), [&](const auto& ends) {
            return numbers.find(simplex[ends[0]], simplex[ends[1]]).has_value();
        });
        if (!known) continue;
        rows.nodes[kept] = simplex;
        rows.references[kept++] = rows.references[i];
    }
    rows.nodes.resize(kept);
    rows.references.resize(kept);
    return before - kept;
}

/// The simplices of degree 1 with the nodes of their edges.
template <int K>
Outcome<Done> curve(listing::Simplices<K>& simplices, const EdgeNumbers& numbers, std::size_t vertices) {
    simplices.curved.references = std::move(simplices.straight.references);
    simplices.curved.origin = simplices.straight.origin;
    simplices.curved.nodes.resize(simplices.straight.size());
    for (std::size_t i = 0; i < simplices.straight.size(); ++i) {
        const auto& corners = simplices.straight.nodes[i];
        auto& nodes = simplices.curved.nodes[i];
        std::copy(corners.begin(), corners.end(), nodes.begin());
        for (std::size_t k = 0; k < edges_per_simplex<K>; ++k) {
            const auto number = numbers.find(corners[local_edges<K>[k][0]], corners[local_edges<K>[k][1]]);
            const auto& origin = simplices.curved.origin;
            if (!number)
                return fail(ErrorKind::input, "one of its edges is none of an element's", origin.place(i),
                            Entity{origin.noun, origin.number_of(i)}, "MFEM has no node for it: remove it");
            nodes[K + 1 + k] = VertexId(vertices + *number);
        }
    }
    simplices.straight = {};
    return Done{};
}

// ---------------------------------------------------------------- the mesh

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

/// What the sections before the vertices have, of degree 1.
template <int K>
struct Topology {
    listing::Simplices<K> elements;
    listing::Simplices<K - 1> boundary;
    Buffer<Group> groups;
    Refused refused;
};

/// The line behind all, where the version has one. Parallel meshes have another there, and more behind it.
Outcome<Done> read_end(Source& source, std::vector<Notice>& notices) {
    if (source.has_end && !source.words.next().ends_with("mesh_end"))
        return source.fail_here("\"mfem_mesh_end\" is missing here");
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

template <int K>
Outcome<Topology<K>> read_topology(Source& source) {
    Topology<K> made;
    auto read =
        read_rows<K>(source, "elements", "element", made.elements.straight, made.refused)
            .and_then([&](Done) { return read_sets(source, "attribute_sets", K, made.groups); })
            .and_then([&](Done) {
                return read_rows<K - 1>(source, "boundary", "boundary element", made.boundary.straight, made.refused);
            })
            .and_then([&](Done) { return read_sets(source, "bdr_attribute_sets", K - 1, made.groups); });
    if (!read) return fail(std::move(read.error()));
    return made;
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

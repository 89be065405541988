// Decodes meshes of any format and mesh arrays; reads numbers in text; finds rows by tag.
module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

std::string line_place(std::string_view name, std::string_view text, const char* at) {
    return std::string(name) + ": line " + std::to_string(std::count(text.data(), at, '\n') + 1);
}

bool read_unusual_real(std::string_view word, double& value) {
    std::string text(word.starts_with('+') ? word.substr(1) : word);
    for (char& c : text)
        if (c == 'd' || c == 'D') c = 'e';
    // long double has a larger exponent range than double. So numbers too large for double become infinity, and numbers
    // too small become 0.
    long double wide = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), wide);
    value = static_cast<double>(wide);
    return !text.empty() && error == std::errc{} && stop == text.data() + text.size();
}

namespace {

bool is_dense(std::uint64_t first, std::uint64_t last, std::size_t n) {
    return last - first < 4 * std::uint64_t{n} + 64;
}

}  // namespace

Buffer<std::uint32_t> rows_by_tag(std::span<const std::uint64_t> tags) {
    if (std::is_sorted(tags.begin(), tags.end())) return {};
    const auto [first, last] = std::minmax_element(tags.begin(), tags.end());
    const std::uint64_t low = *first;
    Buffer<std::uint32_t> rows(tags.size());
    if (!is_dense(low, *last, tags.size())) {
        std::iota(rows.begin(), rows.end(), 0U);
        std::stable_sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) { return tags[a] < tags[b]; });
        return rows;
    }
    Buffer<std::uint32_t> starts(*last - low + 2, 0U);
    for (const std::uint64_t tag : tags) ++starts[tag - low + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    for (std::size_t i = 0; i < tags.size(); ++i) rows[starts[tags[i] - low]++] = static_cast<std::uint32_t>(i);
    return rows;
}

TagIndex::TagIndex(std::span<const std::uint64_t> ascending, Buffer<std::uint32_t> rows)
    : tags_(ascending), rows_(std::move(rows)) {
    if (tags_.empty()) return;
    const std::uint64_t width = tags_.back() - tags_.front();
    contiguous_ = width == tags_.size() - 1 && std::adjacent_find(tags_.begin(), tags_.end()) == tags_.end();
    if (contiguous_ || !is_dense(tags_.front(), tags_.back(), tags_.size())) return;
    table_ = Buffer<std::uint32_t>(width + 1, no_row);
    for (std::size_t i = tags_.size(); i-- > 0;) table_[tags_[i] - tags_.front()] = row(i);
}

std::uint32_t TagIndex::search(std::uint64_t tag) const {
    const auto found = std::lower_bound(tags_.begin(), tags_.end(), tag);
    return found != tags_.end() && *found == tag ? row(static_cast<std::size_t>(found - tags_.begin())) : no_row;
}

namespace {

constexpr std::size_t grain = 65536;

template <int D>
Outcome<Done> check_points(const Column<Vec<D>>& points, const Execution& execution) {
    FirstErrorRow row_error;
    auto looked = each(
        execution, points.size(),
        [&](std::size_t i) {
            for (int d = 0; d < D; ++d)
                if (!std::isfinite(points[i][d])) return row_error.note(i);
        },
        grain);
    if (!looked) return looked;
    if (!row_error.any()) return Done{};
    return fail(ErrorKind::input, "has a coordinate that is not finite", "points", Entity{"row", row_error.row()});
}

template <std::size_t N>
bool has_twice(const std::array<VertexId, N>& nodes) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (nodes[i] == nodes[j]) return true;
    return false;
}

template <int Nodes>
Outcome<Done> check_cells(const CellArray<Nodes>& cells, std::size_t points, const std::string& name,
                          const Execution& execution) {
    if (!cells.references.empty() && cells.references.size() != cells.nodes.size())
        return fail(
            ErrorKind::input,
            std::to_string(cells.references.size()) + " references of " + std::to_string(cells.nodes.size()) + " cells",
            name, {}, "give one per cell, or none");
    FirstErrorRow missing, twice;
    auto looked = each(
        execution, cells.nodes.size(),
        [&](std::size_t c) {
            for (const VertexId v : cells.nodes[c])
                if (v.index() >= points) return missing.note(c);
            if (has_twice(cells.nodes[c])) twice.note(c);
        },
        grain);
    if (!looked) return looked;
    if (missing.any())
        return fail(ErrorKind::input, "has a node that is none of the " + std::to_string(points) + " points", name,
                    Entity{"row", missing.row()}, "points are numbered from 0");
    if (twice.any()) return fail(ErrorKind::input, "has a node twice", name, Entity{"row", twice.row()});
    return Done{};
}

template <int K>
constexpr const char* name_of_cells(int degree) {
    constexpr std::array<std::array<const char*, 2>, 3> names{
        {{"line", "line3"}, {"triangle", "triangle6"}, {"tetra", "tetra10"}}};
    return names[K - 1][static_cast<std::size_t>(degree - 1)];
}
template <int K>
Outcome<Done> check_all(const CellArrays<K>& cells, std::size_t points, const Execution& execution) {
    auto done = check_cells(cells.straight, points, name_of_cells<K>(1), execution);
    return done ? check_cells(cells.curved, points, name_of_cells<K>(2), execution) : done;
}

Column<Reference> references_of(Column<Reference> input, std::size_t count) {
    if (!input.empty() || count == 0) return input;
    return Column<Reference>(Buffer<Reference>(count, 0));
}

template <int K>
Simplices<K> simplices_of(CellArray<K + 1> cells) {
    const std::size_t count = cells.nodes.size();
    return {std::move(cells.nodes), references_of(std::move(cells.references), count), {}};
}

template <int Nodes>
listing::Rows<Nodes> rows_of(CellArray<Nodes> cells, const char* name) {
    listing::Rows<Nodes> rows;
    const std::size_t count = cells.nodes.size();
    rows.nodes = take(std::move(cells.nodes));
    rows.references = take(references_of(std::move(cells.references), count));
    rows.origin.noun = name;
    return rows;
}
template <int K>
listing::Simplices<K> listed_of(CellArrays<K> cells) {
    listing::Simplices<K> listed;
    listed.straight = rows_of(std::move(cells.straight), name_of_cells<K>(1));
    listed.curved = rows_of(std::move(cells.curved), name_of_cells<K>(2));
    return listed;
}

template <int D>
Outcome<DecodedMesh> of_degree_2(MeshArrays<D> arrays, const Execution& execution) {
    listing::Mesh<D> mesh;
    mesh.name = "the arrays";
    const std::size_t points = arrays.points.size();
    mesh.points = take(std::move(arrays.points));
    mesh.point_references = take(references_of(std::move(arrays.point_references), points));
    mesh.elements = listed_of(std::move(arrays.elements));
    mesh.facets = listed_of(std::move(arrays.facets));
    if constexpr (D == 3) mesh.edges = listed_of(std::move(arrays.edges));
    mesh.groups.assign(arrays.groups.begin(), arrays.groups.end());
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, {}, execution);
}

template <int D>
DecodedMesh of_degree_1(MeshArrays<D> arrays) {
    LinearMesh<D> mesh;
    mesh.point_references = references_of(std::move(arrays.point_references), arrays.points.size());
    mesh.points = std::move(arrays.points);
    mesh.elements = simplices_of<D>(std::move(arrays.elements.straight));
    mesh.facets = simplices_of<D - 1>(std::move(arrays.facets.straight));
    if constexpr (D == 3) mesh.edges = simplices_of<1>(std::move(arrays.edges.straight));
    mesh.groups = Column<Group>(Buffer<Group>(arrays.groups.begin(), arrays.groups.end()));
    return DecodedMesh{as_mesh(std::move(mesh)), {}};
}

}  // namespace

template <int D>
Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution) {
    const std::size_t points = arrays.points.size();
    if (!arrays.point_references.empty() && arrays.point_references.size() != points)
        return fail(ErrorKind::input, "must be one per point", "references of points");
    return check_points(arrays.points, execution)
        .and_then([&](Done) { return check_all(arrays.elements, points, execution); })
        .and_then([&](Done) { return check_all(arrays.facets, points, execution); })
        .and_then([&](Done) { return D == 3 ? check_all(arrays.edges, points, execution) : Outcome<Done>(Done{}); })
        .and_then([&](Done) -> Outcome<DecodedMesh> {
            const bool is_curved = arrays.elements.curved.nodes.size() + arrays.facets.curved.nodes.size() +
                                       arrays.edges.curved.nodes.size() >
                                   0;
            return is_curved ? of_degree_2(std::move(arrays), execution) : of_degree_1(std::move(arrays));
        });
}

template <int D>
Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner) {
    static_assert(sizeof(Vec<D>) == D * sizeof(double));
    const std::span<const Vec<D>> points(reinterpret_cast<const Vec<D>*>(coordinates.data()), coordinates.size() / D);
    return owner ? Column<Vec<D>>(points, std::move(owner))
                 : Column<Vec<D>>(Buffer<Vec<D>>(points.begin(), points.end()));
}

template <int K>
Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n) {
    Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes(vertices.size());
    for (std::size_t c = 0; c < vertices.size(); ++c) {
        for (std::size_t i = 0; i <= K; ++i) nodes[c][i] = vertices[c][i];
        for (std::size_t e = 0; e < edges_per_simplex<K>; ++e) nodes[c][K + 1 + e] = VertexId(n + edges[c][e].index());
    }
    return nodes;
}

#define CAMBER_INSTANTIATE(K)                                                    \
    template Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells<K>( \
        const Column<SimplexVertices<K>>&, const Column<std::array<EdgeId, edges_per_simplex<K>>>&, std::size_t);
CAMBER_INSTANTIATE(1)
CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE
template Column<Vec<2>> points_of<2>(std::span<const double>, std::shared_ptr<const void>);
template Column<Vec<3>> points_of<3>(std::span<const double>, std::shared_ptr<const void>);
template Outcome<DecodedMesh> mesh_of_arrays<2>(MeshArrays<2>, const Execution&);
template Outcome<DecodedMesh> mesh_of_arrays<3>(MeshArrays<3>, const Execution&);

// Decoding of any format. Files of other programs are recognised for error messages.

namespace {

struct ForeignFormat {
    std::string_view what, remedy;
};

std::string_view first_line(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return {};
    text.remove_prefix(begin);
    return text.substr(0, text.find('\n'));
}

/// FreeFEM files have three counts (vertices, triangles, edges), then rows of coordinates and a label.
bool is_freefem(std::string_view text) {
    const std::string_view line = first_line(text);
    Words words{line.data(), line.data() + line.size()};
    for (int i = 0; i < 3; ++i)
        if (std::int64_t count = 0; !read_number(words, count) || count < 0) return false;
    if (words.find()) return false;
    const std::string_view rest = first_line({line.data() + line.size(), text.data() + text.size()});
    Words row{rest.data(), rest.data() + rest.size()};
    std::size_t numbers = 0;
    for (double value = 0; row.find(); ++numbers)
        if (!read_number(row, value)) return false;
    return numbers == 3 || numbers == 4;
}

/// Fluent files have sections in parentheses that begin with their number.
bool is_fluent(std::string_view text) {
    const std::string_view line = first_line(text);
    return line.size() > 1 && line[0] == '(' && line[1] >= '0' && line[1] <= '9';
}

bool is_ansys(std::string_view text) {
    const std::string_view line = first_line(text);
    return std::ranges::any_of(std::array{"/COM", "/PREP7", "/BATCH", "/NOPR", "*IF,_CDRDOFF", "NBLOCK"},
                               [&](std::string_view word) { return line.starts_with(word); });
}

std::optional<ForeignFormat> namesake_of(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 4096;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), soon));
    const std::string_view line = first_line(text);
    if (is_med(bytes)) return ForeignFormat{"Salome (.med)", "meshio convert --input-format med FILE NEW.vtu"};
    if (is_freefem(text)) return ForeignFormat{"FreeFEM", "in FreeFEM: savemesh(Th, \"FILE.mesh\")"};
    if (is_fluent(text))
        return ForeignFormat{"Fluent", "meshio convert --input-format ansys FILE NEW.vtu, or export CGNS"};
    if (is_ansys(text))
        return ForeignFormat{"ANSYS (a .cdb archive)", "export it from ANSYS as CGNS or Nastran (.bdf)"};
    if (line.starts_with("MESH dimension") || line.starts_with("MESH \""))
        return ForeignFormat{"GiD", "export it from GiD as Gmsh's .msh"};
    if (line.starts_with("mesh3d")) return ForeignFormat{"Netgen (.vol)", "export it from Netgen as Gmsh2 format"};
    if (line.starts_with("*Heading") || line.starts_with("*HEADING") || line.starts_with("*NODE"))
        return ForeignFormat{"Abaqus (.inp)", "meshio convert --input-format abaqus FILE NEW.vtu"};
    return std::nullopt;
}

}  // namespace

Outcome<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view path, const DecodeOptions& options,
                                 const Execution& execution) {
    const bool is_known = format_with_content(mesh_formats(), bytes) != nullptr;
    if (const auto namesake = is_known ? std::nullopt : namesake_of(bytes))
        return fail(ErrorKind::unsupported,
                    "is a mesh of " + std::string(namesake->what) + ", which Camber cannot read", std::string(path), {},
                    std::string(namesake->remedy));
    const auto format = format_to_read(mesh_formats(), bytes, path);
    if (!format) return fail(format.error());
    auto decoded = (*format)->decode(bytes, path, options, execution);
    if (decoded) {
        decoded->is_always_3d = (*format)->is_always_3d;
        decoded->format = (*format)->name;
    }
    return decoded;
}

}  // namespace camber

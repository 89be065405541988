module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:gmf;
import camber.core;
import :meshes;

export namespace camber {

/// Decodes a GMF mesh (.mesh, .meshb; ASCII or binary by content, versions 1 to 4, either byte order).
/// - Dimension 2 gives a 2D mesh, dimension 3 a 3D one (a surface mesh has no elements).
/// - Elements of degree 2 give a QuadraticMesh. Its vertices have the file's order; mid nodes are stored with the
///   edges.
///   Node orders (…P2Ordering) and BezierBasis are honoured. Simplices of degree 2 come first. If a simplex of degree 1
///   shares an edge with one of degree 2, the edge is curved in both. An edge without a node in the file gets the
///   chord's
///   midpoint.
/// - Plain element keywords with rows of degree 2 (Gmsh writes them) are read as degree 2. Gmsh versions differ in the
///   order of the last two nodes of a tetrahedron; the order whose nodes lie nearer the chord midpoints is used.
/// - References of mid nodes are dropped, with a notice if they differ from those of the edge's ends.
///
/// Further errors: input (contradictory mid nodes).
[[nodiscard]] Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                                   const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                                          const Execution& execution) {
    return decode_gmf_mesh(bytes, name, {}, execution);
}

[[nodiscard]] bool is_gmf_ascii(std::span<const std::byte> bytes);
[[nodiscard]] bool is_gmf_binary(std::span<const std::byte> bytes);

/// Text (.mesh, .sol) or binary, little-endian (.meshb, .solb).
enum class GmfEncoding { ascii, binary };

struct GmfOptions {
    GmfEncoding encoding = GmfEncoding::binary;
    /// File version, from 2 to 4. 0 selects the lowest version that can hold the data: 2 for files below 2 GiB, 3 for
    /// larger files, 4 if a count or an index needs 64 bits.
    int version = 0;
};

/// Encodes the mesh. Decoding the file gives exactly the same numbers. Blocks without rows are omitted, except
/// Vertices. Simplices of degree 2 have nodes in the order of `local_edges`, which is Vizir's default without Ordering
/// blocks. Mid nodes follow the vertices in the order of edges, with the reference `mid_node_reference`. Errors: usage
/// (a version that is invalid, or too low for the mesh), unsupported (not simplices of degree 1 or 2).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_gmf_mesh(const Mesh<D>& mesh, GmfOptions options, const Execution& execution);

/// Lists data that GMF cannot hold: names of references, entities of simplices, associations without parameters.
/// Unknown distances are written as 0.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_gmf(const Mesh<D>& mesh);

/// Decodes the fields of the block SolAtVertices in a GMF file (.sol, .solb).
[[nodiscard]] Outcome<DecodedSolution> decode_gmf_solution(std::span<const std::byte> bytes, std::string_view name,
                                                           const Execution& execution);

/// Encodes the fields as the block SolAtVertices. Errors: usage (invalid version, no fields, a number of values that is
/// not the number of rows times their width).
[[nodiscard]] Outcome<Chunks> encode_gmf_solution(const Solution& solution, GmfOptions options,
                                                  const Execution& execution);

}  // namespace camber

namespace camber::gmf {

/// Keywords that Camber reads, by their number in binary files.
enum class Keyword : std::int32_t {
    dimension = 3,
    vertices = 4,
    edges = 5,
    triangles = 6,
    tetrahedra = 8,
    required_tetrahedra = 12,  // a keyword that Mmg writes; libMeshb reserves its number
    corners = 13,
    ridges = 14,
    required_vertices = 15,
    required_edges = 16,
    required_triangles = 17,
    normal_at_vertices = 20,
    triangles_p2 = 24,
    edges_p2 = 25,
    tetrahedra_p2 = 30,
    vertices_on_geometric_vertices = 40,
    vertices_on_geometric_edges = 41,
    vertices_on_geometric_triangles = 42,
    end = 54,
    tangents = 59,
    normals = 60,
    tangent_at_vertices = 61,
    sol_at_vertices = 62,
    bezier_basis = 125,
    edges_p2_ordering = 127,
    triangles_p2_ordering = 129,
    tetrahedra_p2_ordering = 133,
};

enum class Content : std::uint8_t {
    value,             ///< the block is one integer
    rows,              ///< the block is a count, then rows
    solution,          ///< the block is a count, field types, then rows
    foreign_elements,  ///< rows of elements that Camber does not support
    end,
};

struct KeywordInfo {
    Keyword keyword;
    std::string_view name;
    Content content;
    std::string_view noun;
};

inline constexpr std::array keyword_table = {
    KeywordInfo{Keyword::dimension, "Dimension", Content::value, ""},
    KeywordInfo{Keyword::vertices, "Vertices", Content::rows, "vertex"},
    KeywordInfo{Keyword::edges, "Edges", Content::rows, "edge"},
    KeywordInfo{Keyword::triangles, "Triangles", Content::rows, "triangle"},
    KeywordInfo{Keyword::tetrahedra, "Tetrahedra", Content::rows, "tetrahedron"},
    KeywordInfo{Keyword::required_tetrahedra, "RequiredTetrahedra", Content::rows, "required tetrahedron"},
    KeywordInfo{Keyword::corners, "Corners", Content::rows, "corner"},
    KeywordInfo{Keyword::ridges, "Ridges", Content::rows, "ridge"},
    KeywordInfo{Keyword::required_vertices, "RequiredVertices", Content::rows, "required vertex"},
    KeywordInfo{Keyword::required_edges, "RequiredEdges", Content::rows, "required edge"},
    KeywordInfo{Keyword::required_triangles, "RequiredTriangles", Content::rows, "required triangle"},
    KeywordInfo{Keyword::normal_at_vertices, "NormalAtVertices", Content::rows, "normal at vertex"},
    KeywordInfo{Keyword::triangles_p2, "TrianglesP2", Content::rows, "triangle"},
    KeywordInfo{Keyword::edges_p2, "EdgesP2", Content::rows, "edge"},
    KeywordInfo{Keyword::tetrahedra_p2, "TetrahedraP2", Content::rows, "tetrahedron"},
    KeywordInfo{Keyword::vertices_on_geometric_vertices, "VerticesOnGeometricVertices", Content::rows,
                "vertex on geometric vertex"},
    KeywordInfo{Keyword::vertices_on_geometric_edges, "VerticesOnGeometricEdges", Content::rows,
                "vertex on geometric edge"},
    KeywordInfo{Keyword::vertices_on_geometric_triangles, "VerticesOnGeometricTriangles", Content::rows,
                "vertex on geometric triangle"},
    KeywordInfo{Keyword::end, "End", Content::end, ""},
    KeywordInfo{Keyword::tangents, "Tangents", Content::rows, "tangent"},
    KeywordInfo{Keyword::normals, "Normals", Content::rows, "normal"},
    KeywordInfo{Keyword::tangent_at_vertices, "TangentAtVertices", Content::rows, "tangent at vertex"},
    KeywordInfo{Keyword::sol_at_vertices, "SolAtVertices", Content::solution, "vertex"},
    KeywordInfo{Keyword::bezier_basis, "BezierBasis", Content::value, ""},
    KeywordInfo{Keyword::edges_p2_ordering, "EdgesP2Ordering", Content::rows, "node"},
    KeywordInfo{Keyword::triangles_p2_ordering, "TrianglesP2Ordering", Content::rows, "node"},
    KeywordInfo{Keyword::tetrahedra_p2_ordering, "TetrahedraP2Ordering", Content::rows, "node"},
    // The keyword numbers are those in the public header of libMeshb 8.
    KeywordInfo{Keyword{7}, "Quadrilaterals", Content::foreign_elements, ""},
    KeywordInfo{Keyword{9}, "Prisms", Content::foreign_elements, ""},
    KeywordInfo{Keyword{10}, "Hexahedra", Content::foreign_elements, ""},
    KeywordInfo{Keyword{27}, "QuadrilateralsQ2", Content::foreign_elements, ""},
    KeywordInfo{Keyword{33}, "HexahedraQ2", Content::foreign_elements, ""},
    KeywordInfo{Keyword{46}, "Polyhedra", Content::foreign_elements, ""},
    KeywordInfo{Keyword{47}, "Polygons", Content::foreign_elements, ""},
    KeywordInfo{Keyword{49}, "Pyramids", Content::foreign_elements, ""},
    KeywordInfo{Keyword{86}, "PrismsP2", Content::foreign_elements, ""},
    KeywordInfo{Keyword{87}, "PyramidsP2", Content::foreign_elements, ""},
    KeywordInfo{Keyword{88}, "QuadrilateralsQ3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{89}, "QuadrilateralsQ4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{90}, "TrianglesP3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{91}, "TrianglesP4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{92}, "EdgesP3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{93}, "EdgesP4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{96}, "TetrahedraP3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{97}, "TetrahedraP4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{98}, "HexahedraQ3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{99}, "HexahedraQ4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{100}, "PyramidsP3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{101}, "PyramidsP4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{102}, "PrismsP3", Content::foreign_elements, ""},
    KeywordInfo{Keyword{103}, "PrismsP4", Content::foreign_elements, ""},
    KeywordInfo{Keyword{200}, "Prisms9", Content::foreign_elements, ""},
    KeywordInfo{Keyword{201}, "Hexahedra12", Content::foreign_elements, ""},
    KeywordInfo{Keyword{202}, "Quadrilaterals6", Content::foreign_elements, ""},
    KeywordInfo{Keyword{203}, "BoundaryPolygonHeaders", Content::foreign_elements, ""},
    KeywordInfo{Keyword{205}, "InnerPolygonHeaders", Content::foreign_elements, ""},
    KeywordInfo{Keyword{207}, "PolyhedraHeaders", Content::foreign_elements, ""},
};

[[nodiscard]] constexpr const KeywordInfo* find_keyword(std::int32_t number) {
    for (const KeywordInfo& info : keyword_table)
        if (static_cast<std::int32_t>(info.keyword) == number) return &info;
    return nullptr;
}
[[nodiscard]] constexpr const KeywordInfo* find_keyword(std::string_view name) {
    for (const KeywordInfo& info : keyword_table)
        if (info.name == name) return &info;
    return nullptr;
}
[[nodiscard]] constexpr std::string_view name_of(Keyword keyword) {
    return find_keyword(static_cast<std::int32_t>(keyword))->name;
}

template <int K>
inline constexpr Keyword straight_keyword = K == 1   ? Keyword::edges
                                            : K == 2 ? Keyword::triangles
                                                     : Keyword::tetrahedra;
template <int K>
inline constexpr Keyword curved_keyword = K == 1   ? Keyword::edges_p2
                                          : K == 2 ? Keyword::triangles_p2
                                                   : Keyword::tetrahedra_p2;
template <int K, int Degree>
inline constexpr Keyword simplex_keyword = Degree == 1 ? straight_keyword<K> : curved_keyword<K>;
template <int K>
inline constexpr Keyword ordering_keyword = K == 1   ? Keyword::edges_p2_ordering
                                            : K == 2 ? Keyword::triangles_p2_ordering
                                                     : Keyword::tetrahedra_p2_ordering;
template <int K>
inline constexpr Keyword required_keyword = K == 1   ? Keyword::required_edges
                                            : K == 2 ? Keyword::required_triangles
                                                     : Keyword::required_tetrahedra;

template <int G>
inline constexpr Keyword association_keyword = G == 0   ? Keyword::vertices_on_geometric_vertices
                                               : G == 1 ? Keyword::vertices_on_geometric_edges
                                                        : Keyword::vertices_on_geometric_triangles;

enum class RowOrder { integers_first, reals_first };

/// The integers and reals of a row, independent of the file's encoding.
template <int Integers, int Reals, RowOrder Order = RowOrder::integers_first>
struct Row {
    static constexpr int integers = Integers, reals = Reals, words = Integers + Reals;
    static constexpr RowOrder order = Order;
    std::array<std::int64_t, Integers> integer{};
    std::array<double, Reals> real{};
};

template <int D>
using VertexRow = Row<1, D, RowOrder::reals_first>;
template <int Nodes>
using SimplexRow = Row<Nodes + 1, 0>;
using IndexRow = Row<1, 0>;
using PairRow = Row<2, 0>;
template <int D>
using VectorRow = Row<0, D>;
/// A row that associates a vertex with an entity of dimension G. Its integers are the numbers of the vertex and the
/// entity. If G > 0, its reals are the G parameters and the distance of the vertex from the entity.
template <int G>
using AssociationRow = Row<2, G == 0 ? 0 : G + 1>;
using ValueRow = Row<0, 1>;

enum class RowErrorKind : std::uint8_t { none, syntax, index, repeated, not_finite, too_large };
struct RowError {
    RowErrorKind kind = RowErrorKind::none;
    std::int64_t value = 0;
    std::uint64_t limit = 0;
};

/// Converts a file's index, from 1, to an index from 0. An index below 1 becomes larger than any number of rows.
[[nodiscard]] constexpr std::uint64_t from_file(std::int64_t index) { return static_cast<std::uint64_t>(index) - 1; }

[[nodiscard]] constexpr bool is_reference(std::int64_t value) {
    return value >= std::numeric_limits<Reference>::min() && value <= std::numeric_limits<Reference>::max();
}

template <int D>
[[nodiscard]] inline RowError store_point(const VertexRow<D>& row, Vec<D>& point, Reference& reference) {
    bool finite = true;
    for (int c = 0; c < D; ++c) {
        point[c] = row.real[c];
        finite = finite && std::isfinite(row.real[c]);
    }
    if (!finite) return {RowErrorKind::not_finite};
    if (!is_reference(row.integer[0])) return {RowErrorKind::too_large, row.integer[0]};
    reference = static_cast<Reference>(row.integer[0]);
    return {};
}

template <int N>
[[nodiscard]] inline RowError store_simplex(const SimplexRow<N>& row, std::size_t vertices,
                                            std::array<VertexId, N>& nodes, Reference& reference) {
    for (int n = 0; n < N; ++n) {
        if (from_file(row.integer[n]) >= vertices) return {RowErrorKind::index, row.integer[n], vertices};
        nodes[n] = VertexId(from_file(row.integer[n]));
        for (int m = 0; m < n && N > 2; ++m)
            if (row.integer[m] == row.integer[n]) return {RowErrorKind::repeated, row.integer[n]};
    }
    if (!is_reference(row.integer[N])) return {RowErrorKind::too_large, row.integer[N]};
    reference = static_cast<Reference>(row.integer[N]);
    return {};
}

}  // namespace camber::gmf

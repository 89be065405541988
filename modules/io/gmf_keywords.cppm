module;
#include <array>
#include <cstdint>
#include <string_view>
module camber.io:gmf_keywords;
import camber.core;

namespace camber::gmf {

/// The keywords that Camber reads, by their numbers in binary files.
enum class Keyword : std::int32_t {
    dimension = 3,
    vertices = 4,
    edges = 5,
    triangles = 6,
    tetrahedra = 8,
    required_tetrahedra = 12,  // Mmg's; libMeshb reserves the number
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

/// What follows a keyword.
enum class Content : std::uint8_t {
    value,             ///< one integer
    rows,              ///< a count and rows
    solution,          ///< a count, field types, and rows
    foreign_elements,  ///< a count and elements that Camber cannot hold
    end,
};

struct KeywordInfo {
    Keyword keyword;
    std::string_view name;
    Content content;
    std::string_view noun;  ///< what messages call one row
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
    // Numbers as in the public header of libMeshb 8.
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

/// The entry of a keyword, or null when Camber does not know it.
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

/// The keywords of K-simplices.
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

/// The keywords of vertices on entities of dimension G.
template <int G>
inline constexpr Keyword association_keyword = G == 0   ? Keyword::vertices_on_geometric_vertices
                                               : G == 1 ? Keyword::vertices_on_geometric_edges
                                                        : Keyword::vertices_on_geometric_triangles;

}  // namespace camber::gmf

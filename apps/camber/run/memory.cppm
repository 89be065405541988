module;
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
export module camber.run:memory;
import camber.core;

export namespace camber::run {

/// Largest resident memory of a run (elevate, curve, validate, relax, commit) on a mesh of that size, in bytes: what
/// the program itself takes, and so much a vertex and an element. Fitted to the peaks that report.json gave where walls
/// are curved and the field goes along with them: shells with layers of 2.7·10⁵, 10⁶ and 5·10⁶ tetrahedra, annuli of
/// 3·10⁵ and 3·10⁶ triangles. Off by −7 % to +7 % there; the objective `shape` takes a tenth to a fifth less, a run
/// where no wall moves a fifth. Saturates instead of overflowing. A mesh to be generated, or fields in a VTU
/// file, come on top.
[[nodiscard]] constexpr std::size_t estimated_peak_bytes(std::size_t vertices, std::size_t elements, int dimension) {
    const double program = 10.5e6;
    const double a_vertex = dimension == 2 ? 300 : 1000;
    const double an_element = dimension == 2 ? 200 : 210;
    const double bytes =
        program + a_vertex * static_cast<double>(vertices) + an_element * static_cast<double>(elements);
    constexpr double most = 9.2e18;
    return static_cast<std::size_t>(bytes < most ? bytes : most);
}

/// The memory that there is for a run, and who says so.
struct AvailableMemory {
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
    std::string source;
};

/// What passes that split make of a mesh, and the largest resident memory of that (bytes).
struct Growth {
    double elements = 0;  ///< that the metric asks for
    std::size_t peak_bytes = 0;
};

inline constexpr double bytes_of_program = 13e6;
/// Of a mesh that passes changed, where it is made one as any other.
[[nodiscard]] constexpr double bytes_of_element(int dimension, int degree) {
    return (dimension == 2 ? 347 : 263) * (degree == 2 ? 1.7 : 1);
}

/// `complexity`: ∫ sqrt(det M) over the mesh. A mesh whose edges end below √2 has some 11.5 tetrahedra, 2.5 triangles
/// for each unit of it, as meshes came out; shorter edges so many times more. Memory is at its peak where the changed
/// mesh is made one as any other: 256 and 263 bytes a tetrahedron (10^5 and 3·10^5 of them, one thread), 347 a triangle
/// (1.2·10^5), 450 a tetrahedron of degree 2 (7·10^4).
[[nodiscard]] inline Growth expected_growth(double complexity, double longest_edge, std::size_t elements_before,
                                            int dimension, int degree) {
    const double refined = pow(std::sqrt(2.0) / longest_edge, dimension);
    const double elements = (dimension == 2 ? 2.5 : 11.5) * complexity * refined;
    const double bytes =
        bytes_of_program + bytes_of_element(dimension, degree) * (elements + static_cast<double>(elements_before));
    constexpr double most = 9.2e18;
    return {elements, static_cast<std::size_t>(bytes < most ? bytes : most)};
}

/// How many elements passes may make with so many bytes.
[[nodiscard]] inline std::size_t max_elements_within(std::size_t bytes, int dimension, int degree) {
    const double room = static_cast<double>(bytes) - bytes_of_program;
    return room > 0 ? static_cast<std::size_t>(room / bytes_of_element(dimension, degree)) : 0;
}

}  // namespace camber::run

module;
#include <cstddef>
export module camber.run:memory;

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

}  // namespace camber::run

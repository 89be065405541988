module;
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>
export module camber.run:field_errors;
import camber.core;
import camber.interpolation;
import :report;

/// How well the mesh carries a function: `camber check --field`.
export namespace camber::run {

/// Elements of one kind, with their shares of the squared L2 error over the mesh.
struct ErrorBin {
    std::string range;  ///< "0.01 to 0.1"
    std::size_t elements = 0;
    double straight = 0, same_boundary = 0, curved = 0;
};
/// One way to tell elements apart.
struct ErrorPlace {
    std::string_view key;  ///< in JSON
    std::string_view title;
    std::vector<ErrorBin> bins;  ///< those without elements included
};

/// Errors of the interpolants of one field; lengths^(D/2) times the field's unit (L2), that by a length (H1).
struct FieldErrors {
    std::string expression;
    InterpolationError errors;
    std::vector<ErrorPlace> places;
};

/// One number an element, by which errors are told apart.
struct ElementKinds {
    Buffer<double> curvature;        ///< the largest of its edges: |node − middle|/|chord|
    Buffer<double> scaled_jacobian;  ///< the smallest
    Buffer<double> hops;             ///< edges from its nearest vertex to the boundary; 8 stands for all above, too
};
template <int D>
[[nodiscard]] Outcome<ElementKinds> element_kinds(const QuadraticMesh<D>& mesh,
                                                  const Column<float>& min_scaled_jacobian, const Execution& execution);

/// The errors of an expression, and where they sit. Errors: those of the expression and of `interpolation_error`.
template <int D>
[[nodiscard]] Outcome<FieldErrors> field_errors(const QuadraticMesh<D>& mesh, const std::string& expression,
                                                const ElementKinds& kinds, const Execution& execution);

/// Lines for a terminal; of degree 1 nothing is curved.
[[nodiscard]] std::string field_table(const FieldErrors& field, const MeshReport& mesh);
/// A JSON object.
[[nodiscard]] std::string field_json(const FieldErrors& field);

}  // namespace camber::run

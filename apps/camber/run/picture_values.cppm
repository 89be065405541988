module;
#include <array>
#include <cstddef>
#include <string>
module camber.run:picture_values;
import camber.core;
import camber.drawing;
import :picture;

/// The numbers that a picture's colours stand for.
namespace camber::run {

struct PictureValues {
    FaceValues of_face;
    Colouring colouring = OneColour{};
    std::string title = {};
};

/// Of each element, or triangle of a surface alone: scaled Jacobians of degree 2, qualities of degree 1. By these it is
/// told which are the worst.
template <int D>
[[nodiscard]] Outcome<Column<float>> element_goodness(const QuadraticMesh<D>& mesh, int degree,
                                                      const Execution& execution);

template <int D>
[[nodiscard]] Outcome<PictureValues> picture_values(const QuadraticMesh<D>& mesh, PictureColour colour,
                                                    const PictureInputs& inputs, const Execution& execution);

}  // namespace camber::run

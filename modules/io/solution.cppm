module;
#include <cstddef>
#include <vector>
export module camber.io:solution;
import camber.core;
import :notice;

export namespace camber {

/// What one field holds at each vertex; the numbers are those of GMF files.
enum class FieldKind { scalar = 1, vector = 2, symmetric_tensor = 3, full_tensor = 4 };

/// Values that a field has at each vertex, in 2 or 3 dimensions.
[[nodiscard]] constexpr int values_per_vertex(FieldKind kind, int dimension) {
    switch (kind) {
        case FieldKind::scalar: return 1;
        case FieldKind::vector: return dimension;
        case FieldKind::symmetric_tensor: return dimension * (dimension + 1) / 2;
        case FieldKind::full_tensor: return dimension * dimension;
    }
    return 0;
}

/// Fields at the vertices of a mesh.
struct Solution {
    int dimension = 3;
    std::vector<FieldKind> fields = {};
    std::size_t rows = 0;           ///< vertices
    Column<double> values = {};     ///< row after row, field after field; symmetric tensors in the order of `Sym`
    bool single_precision = false;  ///< the file held reals of 4 bytes (version 1); encoders write 8

    friend bool operator==(const Solution&, const Solution&) = default;
};

/// Values in one row of the solution.
[[nodiscard]] inline std::size_t row_width(const Solution& solution) {
    int width = 0;
    for (const FieldKind kind : solution.fields) width += values_per_vertex(kind, solution.dimension);
    return static_cast<std::size_t>(width);
}

/// What a solution file holds, and what is to be said about it.
struct DecodedSolution {
    Solution solution;
    std::vector<Notice> notices;
};

}  // namespace camber

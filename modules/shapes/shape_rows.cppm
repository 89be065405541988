module;
#include <cstddef>
#include <memory>
export module camber.shapes:shape_rows;
import camber.core;
import :box;
import :shell;

export namespace camber {

/// So many a shape's mesh has.
struct ShapeCounts {
    std::size_t vertices = 0, elements = 0, facets = 0, edges = 0;
};

/// What some rows of a shape have of its mesh: runs of vertices, elements and facets by their numbers in the whole.
template <int D>
struct ShapeRun {
    std::size_t first_vertex = 0, first_element = 0, first_facet = 0;
    Buffer<Vec<D>> points = {};
    Buffer<Reference> point_references = {};
    Buffer<SimplexVertices<D>> elements = {};
    Buffer<Reference> materials = {};
    Buffer<SimplexVertices<D - 1>> facets = {};
    Buffer<Reference> facet_references = {};
};

/// A shape that is rows of prisms over one base, cut to simplices: its mesh, that of `generate`, is made from any row
/// to any other by itself. What is asked for is made anew each time, from a few rows more on either side.
template <int D>
class ShapeRows {
  public:
    virtual ~ShapeRows() = default;
    [[nodiscard]] virtual ShapeCounts counts() const = 0;
    [[nodiscard]] virtual std::size_t rows() const = 0;
    /// Those of [first, last); runs follow each other as rows do. Errors: usage (an element without positive volume);
    /// memory, stopped.
    [[nodiscard]] virtual Outcome<ShapeRun<D>> run(std::size_t first, std::size_t last,
                                                   const Execution& execution) const = 0;
    /// What is said beside the rows: corners, and feature edges with their ridges.
    [[nodiscard]] virtual Outcome<LinearMesh<D>> lists() const = 0;

  protected:
    ShapeRows() = default;
    ShapeRows(const ShapeRows&) = default;
    ShapeRows(ShapeRows&&) = default;
    ShapeRows& operator=(const ShapeRows&) = default;
    ShapeRows& operator=(ShapeRows&&) = default;
};

/// Errors: as of `generate`; unsupported (an unstructured shell, which is made as a whole).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const BoxOptions<D>& options,
                                                                         const Execution& execution = {});
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const ShellOptions<D>& options,
                                                                         const Execution& execution = {});

}  // namespace camber

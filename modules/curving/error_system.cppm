module;
#include <array>
#include <cstddef>
#include <span>
export module camber.curving:error_system;
import camber.core;
import camber.validity;
import :solution_error;
import :solution_nodes;

namespace camber {

/// The expected error of a solution about the nodes as they are, and its least squares for changes of them.
template <int D>
class ErrorSystem {
  public:
    ErrorSystem(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Incidence<ElementId>& shells,
                const KnownSolution<D>& solution, double stiffness);

    /// About these offsets from the middles of chords; those of `home` are held to. The sum of squares.
    [[nodiscard]] Outcome<double> begin(std::span<const Vec<D>> offsets, std::span<const Vec<D>> home,
                                        const Execution& execution);
    /// The squared error of each element about the offsets of `begin`.
    [[nodiscard]] std::span<const double> errors() const { return errors_; }
    /// The changes of the offsets for which the sum is about least, by conjugate gradients.
    [[nodiscard]] Outcome<Buffer<Vec<D>>> solved(int iterations, const Execution& execution);

  private:
    using Errors = ErrorPacks<D>;

    [[nodiscard]] std::size_t packs() const { return (elements_ + pack_size - 1) / pack_size; }
    [[nodiscard]] std::size_t element_of(std::size_t pack, int lane) const;
    [[nodiscard]] ElementPacks<D> elements_of(std::size_t pack, std::span<const Vec<D>> offsets) const;
    void add_fields(std::size_t pack, const ElementPacks<D>& elements, Errors& sum) const;
    void begin_pack(std::size_t pack, std::span<const Vec<D>> offsets);
    void stiffen(std::size_t pack, std::span<const Vec<D>> offsets, std::span<const Vec<D>> home, double least);
    void multiply(std::size_t pack, std::span<const Vec<D>> x);
    /// Σ over the elements around the edge of their part of a vector.
    [[nodiscard]] Vec<D> gathered(std::size_t edge, std::span<const double> parts) const;
    [[nodiscard]] Sym<D> preconditioner(std::size_t edge) const;
    [[nodiscard]] bool is_free(std::size_t edge) const;

    const QuadraticMesh<D>& mesh_;
    const Column<EdgeKind>& kinds_;
    const Incidence<ElementId>& shells_;
    const KnownSolution<D>& solution_;
    double stiffness_;
    std::size_t elements_;
    Buffer<float> curvature_;         // [pack][entry][lane]
    Buffer<double> slope_, product_;  // [pack][unknown][lane]
    Buffer<double> errors_;           // [element]
};

}  // namespace camber

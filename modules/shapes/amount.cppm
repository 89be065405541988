export module camber.shapes:amount;
import camber.core;
import :box;
import :bump;
import :shell;

export namespace camber {

/// How many elements `generate` makes: exactly of boxes, channels and shells of prisms; of unstructured shells by the
/// density of their points, some per cent off. For options that `generate` takes.
template <int D>
[[nodiscard]] double expected_elements(const ShellOptions<D>& options);
template <int D>
[[nodiscard]] double expected_elements(const BoxOptions<D>& options);
[[nodiscard]] double expected_elements(const BumpOptions& options);

/// The same shape in about `count` elements (at least 1): all edge lengths times one factor, or all numbers of cells,
/// as near as whole numbers come. Layers keep their number and heights.
template <int D>
[[nodiscard]] ShellOptions<D> with_elements(ShellOptions<D> options, double count);
template <int D>
[[nodiscard]] BoxOptions<D> with_elements(BoxOptions<D> options, double count);
[[nodiscard]] BumpOptions with_elements(BumpOptions options, double count);

}  // namespace camber

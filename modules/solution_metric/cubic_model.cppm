module;
#include <memory>
export module camber.solution_metric:cubic_model;
import camber.core;
import :directions;
import :local_model;

export namespace camber {

/// k = 2: the Q of least determinant with |T[v,v,v]|^{2/3} ≤ vᵀQv for all v, whose unit ball is the largest ellipsoid
/// in {|T| ≤ 1}. By log-simplex (Coulaud and Loseille, "Very high order anisotropic metric-based mesh adaptation in
/// 3D", Procedia Engineering 163, 2016): in coordinates y = Q^{1/2} v of the present Q,
///
///     min tr L,   yᵀLy ≥ ⅔ log|T(y)|   for directions y, |y| = 1;      Q ← Q^{1/2} e^L Q^{1/2},
///
/// until L vanishes. Since e^{yᵀLy} ≤ yᵀe^Ly (Jensen), what holds for L holds for e^L. Directions are even in the frame
/// of the present Q, so that any anisotropy is as well resolved; the places where |T| is largest on the sphere join
/// them by Newton's method once they are near, and by these Q is scaled in the end, so that the bound holds for all v.
///
/// It begins with a diagonal bound: the frame of T:T, (T:T)_ij = Σ_ab T_iab T_jab, in coordinates y, and in it the
/// least Σ l_i with (l_i + l_j + l_k)/2 ≥ log|T_ijk|, four times. `CubicBound::diagonal` ends there.
///
/// Makes models of one kind; keeps what they have in common, so make it once, not once a model. Of any scale of T.
template <int D>
class CubicModels {
  public:
    explicit CubicModels(const ModelOptions& options);
    /// T finite.
    [[nodiscard]] LocalModel<D> operator()(const CubicForm<D>& t) const;

  private:
    ModelOptions options_;
    std::shared_ptr<const Directions<D>> directions_;
};

}  // namespace camber

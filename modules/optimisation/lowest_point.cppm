export module camber.optimisation:lowest_point;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// Where det J of an element is lowest.
template <int D>
struct LowestPoint {
    Barycentric<D> at{};
    double jacobian = 0;  ///< det J there
};

/// A point whose det J is within 1e-3 · max(|det of the straight element|, |the minimum|) of the smallest, by
/// bisection: for messages. What it says of det J is true to the error of the coefficients; that it is the lowest is
/// not certified.
template <int D>
[[nodiscard]] LowestPoint<D> lowest_point(const BoundedJacobian<D>& jacobian);

}  // namespace camber

module;
#include <array>
#include <cstddef>
#include <span>
export module camber.surface:jet;
import camber.core;

namespace camber {

/// A surface near a point as a height over a plane: z(x, y) = Σ c_ij (x/s_x)^i (y/s_y)^j, 1 ≤ i + j ≤ degree, in the frame
/// whose columns are the directions of x, y, z. The point itself is on it. Degree 0: nothing is known.
struct Jet {
    Vec<3> origin;
    Mat<3> frame;
    std::array<double, 2> scale{1, 1};
    std::array<double, 9> c{};  ///< x, y, xx, xy, yy, xxx, xxy, xyy, yyy
    int degree = 0;

    /// The unit normal at the origin.
    [[nodiscard]] Vec<3> normal() const;
};

/// How far q has to go along `direction` to meet the jet; false where it is not met.
struct JetMeeting {
    double distance = 0;
    bool met = false;
};
[[nodiscard]] JetMeeting meet(const Jet& jet, const Vec<3>& q, const Vec<3>& direction);

/// Least squares through `origin` of the points around it, weighted towards the near ones in the points' own principal
/// axes, so that thin stencils work as well as round ones. Cubic where there are points enough and well placed (rank
/// by column-pivoted QR), else quadratic, else degree 0. Fitted once over the plane of `normal` and once more over
/// the tangent plane found (error of the normal O(h³) when cubic, O(h²) when quadratic).
[[nodiscard]] Jet fit_jet(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points);

}  // namespace camber

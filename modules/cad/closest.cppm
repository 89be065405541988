module;
#include <array>
#include <cstddef>
#include <optional>
#include <span>
export module camber.cad:closest;
import camber.core;
import camber.surface;
import :model;

export namespace camber {

/// The point of a face or an edge nearest to a point; on an edge `normal` is zero, and t the first parameter.
struct CadFoot {
    Vec<3> point, normal;
    std::array<double, 2> parameters{};
    double distance = 0;
};

/// The nearest point of a face: where the nearest of its whole surface is beyond the face's edges, that of the edges.
/// Within rounding, for points that are nearer to the face than its curvature turns away; a point that lies there but
/// for rounding stays as it is, to the last bit.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p);

/// The same with the parameters of a point of the face that is not far: found sooner, and equal up to rounding.
[[nodiscard]] CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p,
                                      const std::array<double, 2>& near);

/// The nearest point of an edge, its ends included.
[[nodiscard]] CadFoot closest_on_edge(const CadModel& model, std::size_t edge, const Vec<3>& p);

/// The point of a face at (u, v), with the unit normal out of the model; at a pole of the surface that of its limit.
[[nodiscard]] EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv);
[[nodiscard]] EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t);

/// The nearest of some faces, the lowest of equally near ones; nothing of none.
[[nodiscard]] std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces,
                                                      const Vec<3>& p);

}  // namespace camber

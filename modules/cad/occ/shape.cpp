#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <ElSLib.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_Surface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <gp_Ax3.hxx>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>

#include "domain.hpp"
#include "read.hpp"
#include "spline.hpp"

namespace camber::occ {

namespace {

/// A surface with what is asked of it often.
struct Surface {
    Handle(Geom_Surface) geometry;
    GeomAdaptor_Surface kind;
    std::optional<SplineSurface> spline;
    std::optional<RevolvedSpline> revolved;
    std::unique_ptr<Domain> domain;  ///< none: the rectangle of the parameters
};
struct Curve {
    Handle(Geom_Curve) geometry;
    std::optional<SplineCurve> spline;
};

/// Whether all edges of a face run along the bounds of its parameters, as those of whole spheres, of cylinders and of
/// fillets do: such a domain is told without asking for it, which takes a hundred times as long.
bool is_rectangle(const TopoDS_Face& face, const FaceFacts& facts) {
    constexpr double same = 1e-9;
    constexpr int samples = 32;
    bool is_along = true;
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More() && is_along; at.Next()) {
        double first = 0, last = 0;
        const auto curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(at.Current()), face, first, last);
        if (curve.IsNull()) return false;
        std::array<bool, 4> along{true, true, true, true};
        for (int i = 0; i <= samples; ++i) {
            const gp_Pnt2d p = curve->Value(first + (last - first) * i / samples);
            for (std::size_t k = 0; k < 2; ++k) {
                const double x = k == 0 ? p.X() : p.Y(), range = facts.high[k] - facts.low[k];
                along[2 * k] = along[2 * k] && std::abs(x - facts.low[k]) <= same * range;
                along[2 * k + 1] = along[2 * k + 1] && std::abs(x - facts.high[k]) <= same * range;
            }
        }
        is_along = std::find(along.begin(), along.end(), true) != along.end();
    }
    return is_along;
}

Point scaled(const gp_XYZ& p, double s) { return {p.X() * s, p.Y() * s, p.Z() * s}; }

void add_once(std::vector<std::size_t>& list, std::size_t item) {
    if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

std::size_t clamped(int cells, int least, int most) { return static_cast<std::size_t>(std::clamp(cells, least, most)); }

bool has_closed_form(const GeomAdaptor_Surface& kind) {
    switch (kind.GetType()) {
        case GeomAbs_Plane:
        case GeomAbs_Cylinder:
        case GeomAbs_Sphere:
        case GeomAbs_Torus: return true;
        default: return false;
    }
}

ClosedForm closed_form(const GeomAdaptor_Surface& kind, double scale) {
    using Kind = ClosedForm::Kind;
    const auto of = [&](Kind what, const gp_Ax3& axes, double major, double minor) {
        const auto values = [](const gp_XYZ& p) { return Point{p.X(), p.Y(), p.Z()}; };
        return ClosedForm{what,
                          values(axes.Location().XYZ()),
                          values(axes.XDirection().XYZ()),
                          values(axes.YDirection().XYZ()),
                          values(axes.Direction().XYZ()),
                          major,
                          minor,
                          scale};
    };
    switch (kind.GetType()) {
        case GeomAbs_Plane: return of(Kind::plane, kind.Plane().Position(), 0, 0);
        case GeomAbs_Cylinder: return of(Kind::cylinder, kind.Cylinder().Position(), kind.Cylinder().Radius(), 0);
        case GeomAbs_Sphere: return of(Kind::sphere, kind.Sphere().Position(), kind.Sphere().Radius(), 0);
        case GeomAbs_Torus:
            return of(Kind::torus, kind.Torus().Position(), kind.Torus().MajorRadius(), kind.Torus().MinorRadius());
        default: return {};
    }
}

/// A spline turns at most about once in a span of each degree.
std::array<std::size_t, 2> cells_of(const GeomAdaptor_Surface& kind) {
    constexpr int least = 8, most = 64, swept = 32;
    if (kind.GetType() == GeomAbs_BSplineSurface) {
        const auto spline = kind.BSpline();
        return {clamped((spline->NbUKnots() - 1) * spline->UDegree(), least, most),
                clamped((spline->NbVKnots() - 1) * spline->VDegree(), least, most)};
    }
    if (kind.GetType() == GeomAbs_BezierSurface)
        return {clamped(2 * kind.UDegree(), least, most), clamped(2 * kind.VDegree(), least, most)};
    if (kind.GetType() == GeomAbs_Plane) return {1, 1};
    if (has_closed_form(kind)) return {least, least};
    return {swept, swept};
}

std::size_t cells_of(const GeomAdaptor_Curve& kind) {
    constexpr int least = 8, most = 256;
    switch (kind.GetType()) {
        case GeomAbs_Line: return 1;
        case GeomAbs_BSplineCurve:
            return clamped((kind.BSpline()->NbKnots() - 1) * kind.BSpline()->Degree(), least, most);
        default: return 2 * least;
    }
}

/// Of what OpenCASCADE refuses to tell, as derivatives at the apex of some surfaces: no numbers.
template <class T, class F>
T told_or(const T& none, F&& f) {
    try {
        return f();
    } catch (const Standard_Failure&) {
        return none;
    }
}
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Point nowhere{nan, nan, nan};

class Shape final : public Kernel {
  public:
    Shape(Read read, double unit) : read_(std::move(read)), scale_(1 / (unit > 0 ? unit : read_.millimetres)) {
        millimetres = unit > 0 ? unit : read_.millimetres;
        file_millimetres = read_.millimetres;
        file_unit = read_.unit;
        losses = read_.losses;
        const TopoDS_Shape& shape = read_.shape;
        // The order of TopExp: that in which a walk through the shape meets them first.
        TopTools_IndexedMapOfShape all_faces, all_edges, all_vertices;
        TopExp::MapShapes(shape, TopAbs_FACE, all_faces);
        TopExp::MapShapes(shape, TopAbs_EDGE, all_edges);
        TopExp::MapShapes(shape, TopAbs_VERTEX, all_vertices);
        for (int i = 1; i <= all_vertices.Extent(); ++i)
            vertices.push_back(scaled(BRep_Tool::Pnt(TopoDS::Vertex(all_vertices(i))).XYZ(), scale_));
        std::vector<std::ptrdiff_t> numbers;  // edges without a curve have none
        for (int i = 1; i <= all_edges.Extent(); ++i) {
            const bool is_curve = add_edge(TopoDS::Edge(all_edges(i)), all_vertices);
            numbers.push_back(is_curve ? static_cast<std::ptrdiff_t>(edges.size()) - 1 : -1);
        }
        for (int i = 1; i <= all_faces.Extent(); ++i) add_face(TopoDS::Face(all_faces(i)), all_edges, numbers);
        for (int i = 1; i <= all_edges.Extent(); ++i)
            if (const std::ptrdiff_t number = numbers[static_cast<std::size_t>(i - 1)]; number >= 0)
                add_turn(edges[static_cast<std::size_t>(number)], TopoDS::Edge(all_edges(i)), all_faces);
    }

    [[nodiscard]] std::string packed() const override { return occ::packed(read_); }

    [[nodiscard]] SurfaceJet on_surface(std::size_t face, double u, double v) const override {
        if (const auto& spline = surfaces_[face].spline) return spline->evaluate(u, v);
        if (const auto& revolved = surfaces_[face].revolved) return revolved->evaluate(u, v);
        return told_or<SurfaceJet>({nowhere, nowhere, nowhere, nowhere, nowhere, nowhere}, [&]() -> SurfaceJet {
            gp_Pnt p;
            gp_Vec du, dv, duu, dvv, duv;
            surfaces_[face].geometry->D2(u, v, p, du, dv, duu, dvv, duv);
            const auto s = [&](const gp_XYZ& x) { return scaled(x, scale_); };
            return {s(p.XYZ()), s(du.XYZ()), s(dv.XYZ()), s(duu.XYZ()), s(duv.XYZ()), s(dvv.XYZ())};
        });
    }

    [[nodiscard]] CurveJet on_curve(std::size_t edge, double t) const override {
        if (const auto& spline = curves_[edge].spline) return spline->evaluate(t);
        return told_or<CurveJet>({nowhere, nowhere, nowhere}, [&]() -> CurveJet {
            gp_Pnt p;
            gp_Vec first, second;
            curves_[edge].geometry->D2(t, p, first, second);
            return {scaled(p.XYZ(), scale_), scaled(first.XYZ(), scale_), scaled(second.XYZ(), scale_)};
        });
    }

    [[nodiscard]] std::array<double, 2> nearest_parameters(std::size_t face, const Point& p) const override {
        const GeomAdaptor_Surface& kind = surfaces_[face].kind;
        const gp_Pnt at(p[0] / scale_, p[1] / scale_, p[2] / scale_);
        double u = 0, v = 0;
        switch (kind.GetType()) {
            case GeomAbs_Plane: ElSLib::Parameters(kind.Plane(), at, u, v); break;
            case GeomAbs_Cylinder: ElSLib::Parameters(kind.Cylinder(), at, u, v); break;
            case GeomAbs_Sphere: ElSLib::Parameters(kind.Sphere(), at, u, v); break;
            case GeomAbs_Torus: ElSLib::Parameters(kind.Torus(), at, u, v); break;
            default: break;
        }
        return {u, v};
    }

    [[nodiscard]] std::optional<bool> has_at_once(std::size_t face, double u, double v) const override {
        const auto& domain = surfaces_[face].domain;
        if (!domain) return is_within(faces[face], {u, v});
        return told_or(std::optional<bool>(), [&] { return domain->has_at_once(u, v); });
    }

    [[nodiscard]] bool has(std::size_t face, double u, double v) const override {
        if (const auto known = has_at_once(face, u, v)) return *known;
        return told_or(false, [&] { return surfaces_[face].domain->has(u, v); });
    }

  private:
    /// By whole periods as near to the middle of the bounds as can be.
    [[nodiscard]] static bool is_within(const FaceFacts& facts, const std::array<double, 2>& uv) {
        constexpr double beyond = 1e-12;
        for (std::size_t k = 0; k < 2; ++k) {
            const double half = 0.5 * (facts.high[k] - facts.low[k]), period = facts.period[k];
            double off = uv[k] - 0.5 * (facts.low[k] + facts.high[k]);
            if (period > 0) off -= period * std::round(off / period);
            if (std::abs(off) > half * (1 + beyond)) return false;
        }
        return true;
    }

    bool add_edge(const TopoDS_Edge& edge, const TopTools_IndexedMapOfShape& all_vertices) {
        EdgeFacts facts;
        Handle(Geom_Curve) curve;
        if (!BRep_Tool::Degenerated(edge)) curve = BRep_Tool::Curve(edge, facts.first, facts.last);
        if (curve.IsNull()) return false;
        if (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve); !trimmed.IsNull())
            curve = trimmed->BasisCurve();
        const GeomAdaptor_Curve kind(curve);
        facts.is_line = kind.GetType() == GeomAbs_Line;
        facts.cells = cells_of(kind);
        if (curve->IsPeriodic()) facts.period = curve->Period();
        for (TopExp_Explorer at(edge, TopAbs_VERTEX); at.More(); at.Next())
            add_once(facts.vertices, static_cast<std::size_t>(all_vertices.FindIndex(at.Current()) - 1));
        edges.push_back(std::move(facts));
        auto spline = SplineCurve::of(curve, scale_);
        curves_.push_back({std::move(curve), std::move(spline)});
        return true;
    }

    void add_face(const TopoDS_Face& face, const TopTools_IndexedMapOfShape& all_edges,
                  const std::vector<std::ptrdiff_t>& numbers) {
        FaceFacts facts;
        Surface surface;
        surface.geometry = BRep_Tool::Surface(face);
        if (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface.geometry); !trimmed.IsNull())
            surface.geometry = trimmed->BasisSurface();
        surface.kind.Load(surface.geometry);
        facts.is_plane = surface.kind.GetType() == GeomAbs_Plane;
        facts.has_closed_form = has_closed_form(surface.kind);
        facts.form = closed_form(surface.kind, scale_);
        facts.is_reversed = face.Orientation() == TopAbs_REVERSED;
        BRepTools::UVBounds(face, facts.low[0], facts.high[0], facts.low[1], facts.high[1]);
        surface.spline = SplineSurface::of(surface.geometry, scale_);
        surface.revolved = RevolvedSpline::of(surface.geometry, scale_);
        if (!is_rectangle(face, facts)) surface.domain = std::make_unique<Domain>(face, facts);
        if (surface.geometry->IsUPeriodic()) facts.period[0] = surface.geometry->UPeriod();
        if (surface.geometry->IsVPeriodic()) facts.period[1] = surface.geometry->VPeriod();
        facts.cells = cells_of(surface.kind);
        for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) {
            const std::ptrdiff_t number = numbers[static_cast<std::size_t>(all_edges.FindIndex(at.Current()) - 1)];
            if (number < 0) continue;
            add_once(facts.edges, static_cast<std::size_t>(number));
            add_once(edges[static_cast<std::size_t>(number)].faces, faces.size());
        }
        faces.push_back(std::move(facts));
        surfaces_.push_back(std::move(surface));
    }

    /// The unit normal out of a face at a share of the way along one of its edges; none where the surface has none.
    [[nodiscard]] std::optional<gp_Dir> outward_normal(const TopoDS_Edge& edge, const TopoDS_Face& face,
                                                       std::size_t number, double share) const {
        double first = 0, last = 0;
        const auto curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
        if (curve.IsNull()) return std::nullopt;
        const gp_Pnt2d at = curve->Value(first + (last - first) * share);
        gp_Pnt p;
        gp_Vec u, v;
        surfaces_[number].geometry->D1(at.X(), at.Y(), p, u, v);
        const gp_Vec normal = u.Crossed(v);
        constexpr double parallel = 1e-9;
        if (!(normal.Magnitude() > parallel * u.Magnitude() * v.Magnitude())) return std::nullopt;
        return gp_Dir(faces[number].is_reversed ? normal.Reversed() : normal);
    }

    void add_turn(EdgeFacts& facts, const TopoDS_Edge& edge, const TopTools_IndexedMapOfShape& all_faces) const {
        constexpr std::array<double, 7> shares{0.02, 0.15, 0.35, 0.5, 0.65, 0.85, 0.98};
        if (facts.faces.size() != 2) return;
        facts.turn = told_or(EdgeFacts::half_turn, [&] {
            double largest = 0;
            for (const double share : shares) {
                std::array<std::optional<gp_Dir>, 2> normals;
                for (std::size_t k = 0; k < 2; ++k)
                    normals[k] = outward_normal(edge, TopoDS::Face(all_faces(static_cast<int>(facts.faces[k]) + 1)),
                                                facts.faces[k], share);
                if (!normals[0] || !normals[1]) return EdgeFacts::half_turn;
                largest = std::max(largest, normals[0]->Angle(*normals[1]));
            }
            return largest;
        });
    }

    Read read_;
    double scale_;
    std::vector<Surface> surfaces_;
    std::vector<Curve> curves_;
};

}  // namespace

std::unique_ptr<Kernel> kernel_of(Read read, double millimetres) {
    return std::make_unique<Shape>(std::move(read), millimetres);
}

}  // namespace camber::occ

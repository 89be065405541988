#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
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
#include <Precision.hxx>
#include <Standard_Failure.hxx>
#include <TopAbs_State.hxx>
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

#include "kernel.hpp"
#include "read.hpp"
#include "spline.hpp"

namespace camber::occ {

namespace {

/// Parameter grid of a trimmed face. Cells that no edge crosses are entirely inside or outside the face. OpenCASCADE
/// classifies each connected group of such cells once, and single points in the other cells.
class DomainGrid {
  public:
    DomainGrid(const TopoDS_Face& face, const FaceFacts& facts, BRepTopAdaptor_FClass2d& domain, std::size_t fineness);

    /// True if (u, v) is inside the face; empty in cells that an edge may cross.
    [[nodiscard]] std::optional<bool> has(double u, double v) const;

  private:
    [[nodiscard]] std::size_t cell_of(double x, std::size_t k) const;
    [[nodiscard]] double middle_of(std::size_t cell, std::size_t k) const;
    /// Marks each cell that an edge may cross: all cells in the box of two successive edge points, widened by its size.
    /// Empty if an edge has no parameter curve.
    [[nodiscard]] std::vector<bool> crossed_by_edges(const TopoDS_Face& face, std::size_t pieces) const;
    void mark(const gp_Pnt2d& from, const gp_Pnt2d& to, std::vector<bool>& crossed) const;
    [[nodiscard]] std::vector<std::size_t> group_of(std::size_t cell, std::vector<bool>& is_grouped) const;
    /// Tests some cells of a group by OpenCASCADE. If the results disagree (open loops), the group stays undecided.
    void decide(const std::vector<std::size_t>& group, BRepTopAdaptor_FClass2d& domain);

    std::array<double, 2> low_, high_;
    std::size_t side_;
    std::vector<bool> is_known_, is_inside_;
};

class Domain {
  public:
    Domain(const TopoDS_Face& face, const FaceFacts& facts);

    /// True if (u, v) is inside the face; empty if only OpenCASCADE can decide, which is 100 times slower.
    [[nodiscard]] std::optional<bool> has_if_known(double u, double v) const;
    /// Uses OpenCASCADE. Throws Standard_Failure.
    [[nodiscard]] bool has(double u, double v) const;

  private:
    TopoDS_Face face_;
    FaceFacts facts_;
    mutable std::mutex alone_;  ///< needed because OpenCASCADE gave wrong results with several threads
    mutable BRepTopAdaptor_FClass2d classifier_;
    DomainGrid coarse_;
    mutable std::once_flag refined_;
    mutable std::optional<DomainGrid> fine_;  ///< created for the first point in an undecided coarse cell
};

constexpr std::size_t most_cells = 1024;  // per direction

/// Cells per direction. Faces with many edges may have holes and get more cells.
std::size_t side_for(const TopoDS_Face& face) {
    constexpr double least = 64, most = 256, edges_of_few = 4;
    std::size_t edges = 0;
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) ++edges;
    return static_cast<std::size_t>(
        std::clamp(least * std::sqrt(static_cast<double>(edges) / edges_of_few), least, most));
}

DomainGrid::DomainGrid(const TopoDS_Face& face, const FaceFacts& facts, BRepTopAdaptor_FClass2d& domain,
                       std::size_t fineness)
    : low_(facts.low),
      high_(facts.high),
      side_(std::min(most_cells, fineness * side_for(face))),
      is_known_(side_ * side_, false),
      is_inside_(side_ * side_, false) {
    constexpr std::size_t pieces = 128;
    const auto crossed = crossed_by_edges(face, fineness * pieces);
    if (crossed.empty()) return;
    std::vector<bool> is_grouped = crossed;
    for (std::size_t cell = 0; cell < is_known_.size(); ++cell)
        if (!is_grouped[cell]) decide(group_of(cell, is_grouped), domain);
}

std::optional<bool> DomainGrid::has(double u, double v) const {
    const std::array<double, 2> uv{u, v};
    for (std::size_t k = 0; k < 2; ++k)
        if (!(uv[k] >= low_[k] && uv[k] <= high_[k])) return std::nullopt;
    const std::size_t cell = cell_of(u, 0) * side_ + cell_of(v, 1);
    return is_known_[cell] ? std::optional<bool>(is_inside_[cell]) : std::nullopt;
}

std::size_t DomainGrid::cell_of(double x, std::size_t k) const {
    const double at = (x - low_[k]) / (high_[k] - low_[k]) * static_cast<double>(side_);
    return at >= 0 ? std::min(static_cast<std::size_t>(std::min(at, static_cast<double>(side_))), side_ - 1) : 0;
}

double DomainGrid::middle_of(std::size_t cell, std::size_t k) const {
    return low_[k] + (high_[k] - low_[k]) * (static_cast<double>(cell) + 0.5) / static_cast<double>(side_);
}

std::vector<bool> DomainGrid::crossed_by_edges(const TopoDS_Face& face, std::size_t pieces) const {
    std::vector<bool> crossed(side_ * side_, false);
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) {
        double first = 0, last = 0;
        const auto curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(at.Current()), face, first, last);
        if (curve.IsNull()) return {};
        gp_Pnt2d from = curve->Value(first);
        for (std::size_t i = 1; i <= pieces; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(pieces);
            const gp_Pnt2d to = curve->Value(first + (last - first) * share);
            mark(from, to, crossed);
            from = to;
        }
    }
    return crossed;
}

void DomainGrid::mark(const gp_Pnt2d& from, const gp_Pnt2d& to, std::vector<bool>& crossed) const {
    constexpr double beside = 1e-6;  // margin relative to the face, for edges along cell borders
    std::array<std::size_t, 2> begin{}, end{};
    for (std::size_t k = 0; k < 2; ++k) {
        const auto [a, b] = std::minmax(k == 0 ? from.X() : from.Y(), k == 0 ? to.X() : to.Y());
        const double more = b - a + beside * (high_[k] - low_[k]);
        begin[k] = cell_of(a - more, k);
        end[k] = cell_of(b + more, k);
    }
    for (std::size_t i = begin[0]; i <= end[0]; ++i)
        for (std::size_t j = begin[1]; j <= end[1]; ++j) crossed[i * side_ + j] = true;
}

std::vector<std::size_t> DomainGrid::group_of(std::size_t cell, std::vector<bool>& is_grouped) const {
    std::vector<std::size_t> group{cell};
    is_grouped[cell] = true;
    const auto add = [&](std::size_t neighbour) {
        if (is_grouped[neighbour]) return;
        is_grouped[neighbour] = true;
        group.push_back(neighbour);
    };
    for (std::size_t next = 0; next < group.size(); ++next) {
        const std::size_t i = group[next] / side_, j = group[next] % side_;
        if (i > 0) add(group[next] - side_);
        if (i + 1 < side_) add(group[next] + side_);
        if (j > 0) add(group[next] - 1);
        if (j + 1 < side_) add(group[next] + 1);
    }
    return group;
}

void DomainGrid::decide(const std::vector<std::size_t>& group, BRepTopAdaptor_FClass2d& domain) {
    constexpr std::size_t tries = 5;
    std::optional<TopAbs_State> state;
    for (std::size_t n = 0; n < std::min(tries, group.size()); ++n) {
        const std::size_t cell = group[n * group.size() / std::min(tries, group.size())];
        const TopAbs_State found = domain.Perform(gp_Pnt2d(middle_of(cell / side_, 0), middle_of(cell % side_, 1)));
        if ((found != TopAbs_IN && found != TopAbs_OUT) || found != state.value_or(found)) return;
        state = found;
    }
    for (const std::size_t cell : group) {
        is_known_[cell] = true;
        is_inside_[cell] = state == TopAbs_IN;
    }
}

Domain::Domain(const TopoDS_Face& face, const FaceFacts& facts)
    : face_(face), facts_(facts), classifier_(face, Precision::PConfusion()), coarse_(face, facts, classifier_, 1) {}

std::optional<bool> Domain::has_if_known(double u, double v) const {
    constexpr std::size_t fineness = 4;
    if (const auto known = coarse_.has(u, v)) return known;
    std::call_once(refined_, [&] {
        const std::lock_guard lock(alone_);
        fine_.emplace(face_, facts_, classifier_, fineness);
    });
    return fine_->has(u, v);
}

bool Domain::has(double u, double v) const {
    const std::lock_guard lock(alone_);
    const TopAbs_State found = classifier_.Perform(gp_Pnt2d(u, v));
    return found == TopAbs_IN || found == TopAbs_ON;
}

struct Surface {
    Handle(Geom_Surface) geometry;
    GeomAdaptor_Surface kind;
    std::optional<SplineSurface> spline;
    std::optional<RevolvedSpline> revolved;
    std::unique_ptr<Domain> domain;
};
struct Curve {
    Handle(Geom_Curve) geometry;
    std::optional<SplineCurve> spline;
};

/// True if all edges run along the parameter bounds (spheres, cylinders, fillets): point queries are then 100 times
/// faster.
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

/// Number of search cells per direction. A spline can bend once per degree in each span.
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

/// Returns f(), or `none` if OpenCASCADE fails, for example for derivatives at an apex.
template <class T, class F>
T value_or_none(const T& none, F&& f) {
    try {
        return f();
    } catch (const Standard_Failure&) {
        return none;
    }
}
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Point undefined_point{nan, nan, nan};

class Shape final : public Kernel {
  public:
    Shape(Read read, double unit) : read_(std::move(read)), scale_(1 / (unit > 0 ? unit : read_.millimetres)) {
        millimetres = unit > 0 ? unit : read_.millimetres;
        file_millimetres = read_.millimetres;
        file_unit = read_.unit;
        losses = read_.losses;
        const TopoDS_Shape& shape = read_.shape;
        // Numbers faces, edges and vertices as TopExp does: in the order of their first visit in a walk through the
        // shape.
        TopTools_IndexedMapOfShape all_faces, all_edges, all_vertices;
        TopExp::MapShapes(shape, TopAbs_FACE, all_faces);
        TopExp::MapShapes(shape, TopAbs_EDGE, all_edges);
        TopExp::MapShapes(shape, TopAbs_VERTEX, all_vertices);
        for (int i = 1; i <= all_vertices.Extent(); ++i)
            vertices.push_back(scaled(BRep_Tool::Pnt(TopoDS::Vertex(all_vertices(i))).XYZ(), scale_));
        std::vector<std::ptrdiff_t> numbers;  // −1 for edges without a curve
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
        return value_or_none<SurfaceJet>(
            {undefined_point, undefined_point, undefined_point, undefined_point, undefined_point, undefined_point},
            [&]() -> SurfaceJet {
                gp_Pnt p;
                gp_Vec du, dv, duu, dvv, duv;
                surfaces_[face].geometry->D2(u, v, p, du, dv, duu, dvv, duv);
                const auto s = [&](const gp_XYZ& x) { return scaled(x, scale_); };
                return {s(p.XYZ()), s(du.XYZ()), s(dv.XYZ()), s(duu.XYZ()), s(duv.XYZ()), s(dvv.XYZ())};
            });
    }

    [[nodiscard]] CurveJet on_curve(std::size_t edge, double t) const override {
        if (const auto& spline = curves_[edge].spline) return spline->evaluate(t);
        return value_or_none<CurveJet>({undefined_point, undefined_point, undefined_point}, [&]() -> CurveJet {
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

    [[nodiscard]] std::optional<bool> has_if_known(std::size_t face, double u, double v) const override {
        const auto& domain = surfaces_[face].domain;
        if (!domain) return is_within(faces[face], {u, v});
        return value_or_none(std::optional<bool>(), [&] { return domain->has_if_known(u, v); });
    }

    [[nodiscard]] bool has(std::size_t face, double u, double v) const override {
        if (const auto known = has_if_known(face, u, v)) return *known;
        return value_or_none(false, [&] { return surfaces_[face].domain->has(u, v); });
    }

  private:
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

    /// Outward unit normal of a face at a point of its edge, if it exists. `share`: parameter of the point, from 0 to
    /// 1.
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
        facts.turn = value_or_none(EdgeFacts::half_turn, [&] {
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

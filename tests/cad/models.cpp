#include "models.hpp"

#include "occ/read.hpp"

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Ax1.hxx>
#include <gp_Ax2.hxx>
#include <gp_Circ.hxx>
#include <gp_Dir.hxx>
#include <gp_Elips.hxx>
#include <gp_Pnt.hxx>
#include <gp_Vec.hxx>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace cad_tests {

namespace {

TopoDS_Shape rounded(const TopoDS_Shape& box, double radius) {
    BRepFilletAPI_MakeFillet fillet(box);
    for (TopExp_Explorer at(box, TopAbs_EDGE); at.More(); at.Next()) fillet.Add(radius, TopoDS::Edge(at.Current()));
    return fillet.Shape();
}

TopoDS_Shape as_splines(const TopoDS_Shape& shape) { return BRepBuilderAPI_NurbsConvert(shape).Shape(); }

TopoDS_Edge circle(double radius, double z) {
    return BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), radius)).Edge();
}

TopoDS_Shape circles(const std::array<double, 3>& s) {
    TopoDS_Compound compound;
    BRep_Builder().MakeCompound(compound);
    for (const double radius : {s[0], s[1]}) BRep_Builder().Add(compound, circle(radius, s[2]));
    return compound;
}

TopoDS_Shape annulus(const std::array<double, 3>& s) {
    BRepBuilderAPI_MakeFace face(BRepBuilderAPI_MakeWire(circle(s[1], s[2])).Wire(), Standard_True);
    face.Add(TopoDS::Wire(BRepBuilderAPI_MakeWire(circle(s[0], s[2])).Wire().Reversed()));
    return face.Shape();
}

TopoDS_Shape within(const TopoDS_Wire& wire) { return BRepBuilderAPI_MakeFace(wire, Standard_True).Shape(); }

TopoDS_Shape ellipse(double a, double b) {
    const gp_Elips curve(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), a, b);
    return within(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge()).Wire());
}

TopoDS_Shape spline(double radius) {
    constexpr int points = 9;
    const Handle(TColgp_HArray1OfPnt) through = new TColgp_HArray1OfPnt(1, points);
    for (int i = 0; i < points; ++i) {
        const double angle = 2 * 3.141592653589793 * i / points, r = radius * (1 + 0.1 * std::cos(2 * angle));
        through->SetValue(i + 1, gp_Pnt(r * std::cos(angle), r * std::sin(angle), 0));
    }
    GeomAPI_Interpolate curve(through, Standard_True, 1e-9);
    curve.Perform();
    return within(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()).Wire());
}

TopoDS_Shape half_disc(double radius) {
    const gp_Circ curve(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), radius);
    const TopoDS_Edge arc = BRepBuilderAPI_MakeEdge(curve, 0, 3.141592653589793).Edge();
    const TopoDS_Edge line = BRepBuilderAPI_MakeEdge(TopExp::LastVertex(arc), TopExp::FirstVertex(arc)).Edge();
    return within(BRepBuilderAPI_MakeWire(arc, line).Wire());
}

TopoDS_Shape empty() {
    TopoDS_Compound compound;
    BRep_Builder().MakeCompound(compound);
    return compound;
}

TopoDS_Shape two_boxes(double a, double b, double c) {
    TopoDS_Compound compound;
    BRep_Builder builder;
    builder.MakeCompound(compound);
    builder.Add(compound, BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(a, b, c)).Shape());
    builder.Add(compound, BRepPrimAPI_MakeBox(gp_Pnt(a, 0, 0), gp_Pnt(2 * a, b, c)).Shape());
    return compound;
}

gp_Ax2 axes(const gp_Pnt& at, double angle) {
    return {at, gp_Dir(std::sin(angle), 0.3 * std::sin(angle), std::cos(angle))};
}

TopoDS_Shape plate() {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(gp_Pnt(-1, -1, 0), gp_Pnt(1, 1, 0.5)).Shape();
    return BRepAlgoAPI_Cut(box, BRepPrimAPI_MakeCylinder(0.5, 1).Shape()).Shape();
}

TopoDS_Shape tilted_hole(double radius, double angle) {
    const gp_Ax2 at = axes(gp_Pnt(0.5 - std::sin(angle), 0.5 - 0.3 * std::sin(angle), 0.5 - std::cos(angle)), angle);
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(1, 1, 1).Shape(), BRepPrimAPI_MakeCylinder(at, radius, 2).Shape())
        .Shape();
}

/// Returns the part of a shape on the far side of a plane through a point.
TopoDS_Shape beyond(const TopoDS_Shape& shape, const gp_Pnt& at, double angle, double size) {
    const gp_Ax2 plane = axes(at, angle);
    const gp_Pnt corner = at.Translated(-size * (gp_Vec(plane.XDirection()) + gp_Vec(plane.YDirection())));
    const TopoDS_Shape half =
        BRepPrimAPI_MakeBox(gp_Ax2(corner, plane.Direction(), plane.XDirection()), 2 * size, 2 * size, 2 * size)
            .Shape();
    return BRepAlgoAPI_Common(shape, half).Shape();
}

TopoDS_Shape groove(double major, double minor) {
    const gp_Ax2 top(gp_Pnt(2, 2, 1), gp_Dir(0.2, 0.1, 1));
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(4, 4, 1).Shape(), BRepPrimAPI_MakeTorus(top, major, minor).Shape())
        .Shape();
}

/// Angles at which the parts of a circle begin and end: a sliver of this angle, and two halves of the rest.
std::array<double, 4> split_angles(double sliver) {
    constexpr double begin = 0.2, turn = 2 * 3.141592653589793;
    return {begin, begin + sliver, begin + 0.5 * (turn + sliver), begin + turn};
}

TopoDS_Shape split_cylinder(double radius, double height, double sliver) {
    const std::array<double, 4> at = split_angles(sliver);
    const auto part = [&](std::size_t i) {
        const gp_Ax2 axes(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1), gp_Dir(std::cos(at[i]), std::sin(at[i]), 0));
        return BRepPrimAPI_MakeCylinder(axes, radius, height, at[i + 1] - at[i]).Shape();
    };
    return BRepAlgoAPI_Fuse(BRepAlgoAPI_Fuse(part(0), part(1)).Shape(), part(2)).Shape();
}

TopoDS_Shape split_disc(double radius, double sliver) {
    const std::array<double, 4> at = split_angles(sliver);
    const gp_Circ curve(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), radius);
    std::array<TopoDS_Vertex, 3> ends;
    for (std::size_t i = 0; i < 3; ++i)
        ends[i] = BRepBuilderAPI_MakeVertex(gp_Pnt(radius * std::cos(at[i]), radius * std::sin(at[i]), 0)).Vertex();
    BRepBuilderAPI_MakeWire wire;
    for (std::size_t i = 0; i < 3; ++i) wire.Add(BRepBuilderAPI_MakeEdge(curve, ends[i], ends[(i + 1) % 3]).Edge());
    return within(wire.Wire());
}

/// A rational half circle from pole to pole, turned about z.
TopoDS_Shape revolved_ball(double radius) {
    constexpr double quarter = 1.5707963267948966;
    const gp_Circ circle(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0), gp_Dir(1, 0, 0)), radius);
    const Handle(Geom_TrimmedCurve) half = new Geom_TrimmedCurve(new Geom_Circle(circle), -quarter, quarter);
    const TopoDS_Edge profile = BRepBuilderAPI_MakeEdge(GeomConvert::CurveToBSplineCurve(half)).Edge();
    return BRepPrimAPI_MakeRevol(profile, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape();
}

TopoDS_Shape shape_of(Kind kind, const std::array<double, 3>& s) {
    constexpr double half = 3.141592653589793;
    switch (kind) {
        case Kind::box: return BRepPrimAPI_MakeBox(s[0], s[1], s[2]).Shape();
        case Kind::ball: return BRepPrimAPI_MakeSphere(s[0]).Shape();
        case Kind::shell:
            return BRepAlgoAPI_Cut(BRepPrimAPI_MakeSphere(s[1]).Shape(), BRepPrimAPI_MakeSphere(s[0]).Shape()).Shape();
        case Kind::cylinder: return BRepPrimAPI_MakeCylinder(s[0], s[1]).Shape();
        case Kind::cone: return BRepPrimAPI_MakeCone(s[0], s[1], s[2]).Shape();
        case Kind::torus: return BRepPrimAPI_MakeTorus(s[0], s[1]).Shape();
        case Kind::half_torus: return BRepPrimAPI_MakeTorus(s[0], s[1], half).Shape();
        case Kind::filleted_box: return rounded(BRepPrimAPI_MakeBox(s[0], s[0], s[0]).Shape(), s[1]);
        case Kind::nurbs_torus: return as_splines(BRepPrimAPI_MakeTorus(s[0], s[1]).Shape());
        case Kind::nurbs_ball: return as_splines(BRepPrimAPI_MakeSphere(s[0]).Shape());
        case Kind::revolved_ball: return revolved_ball(s[0]);
        case Kind::two_boxes: return two_boxes(s[0], s[1], s[2]);
        case Kind::annulus: return annulus(s);
        case Kind::circles: return circles(s);
        case Kind::ellipse: return ellipse(s[0], s[1]);
        case Kind::spline: return spline(s[0]);
        case Kind::half_disc: return half_disc(s[0]);
        case Kind::plate: return plate();
        case Kind::tilted_hole: return tilted_hole(s[0], s[1]);
        case Kind::cap:
            return beyond(BRepPrimAPI_MakeSphere(s[0]).Shape(), gp_Pnt(0.5 * s[0], 0, 0.5 * s[0]), s[1], 2 * s[0]);
        case Kind::groove: return groove(s[0], s[1]);
        case Kind::skew_cone:
            return beyond(BRepPrimAPI_MakeCone(s[0], s[1], s[2]).Shape(), gp_Pnt(0, 0, 0.4 * s[2]), 0.7, 4 * s[2]);
        case Kind::split_cylinder: return split_cylinder(s[0], s[1], s[2]);
        case Kind::split_disc: return split_disc(s[0], s[1]);
        case Kind::nothing: return empty();
    }
    return {};
}

void write(const TopoDS_Shape& shape, const std::string& path, const char* unit) {
    const auto ends = [&](const char* ending) { return path.ends_with(ending); };
    bool written = false;
    if (ends(".brep")) {
        written = BRepTools::Write(shape, path.c_str());
    } else if (ends(".iges")) {
        IGESControl_Writer writer(unit, 1);  // faces of solids
        written = writer.AddShape(shape) && writer.Write(path.c_str());
    } else {
        STEPControl_Controller::Init();
        Interface_Static::SetCVal("write.step.unit", unit);
        STEPControl_Writer writer;
        written = writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone &&
                  writer.Write(path.c_str()) == IFSelect_RetDone;
    }
    if (!written) throw std::runtime_error("could not write " + path);
}

}  // namespace

File::File(const std::string& ending) {
    static std::atomic<int> count = 0;
    path_ = (std::filesystem::temp_directory_path() /
             ("camber-cad-" + std::to_string(getpid()) + "-" + std::to_string(count++) + ending))
                .string();
}
File::~File() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
}

void write_model(Kind kind, const std::array<double, 3>& sizes, const File& file, const char* unit) {
    CAMBER_OCC_KEEPS;
    Message::DefaultMessenger()->ChangePrinters().Clear();
    write(shape_of(kind, sizes), file.path(), unit);
}

Triangles triangles_of(Kind kind, const std::array<double, 3>& sizes, double deflection) {
    CAMBER_OCC_KEEPS;
    const TopoDS_Shape shape = shape_of(kind, sizes);
    const BRepMesh_IncrementalMesh mesher(shape, deflection, Standard_False, 0.5, Standard_False);
    Triangles out;
    int number = 0;
    for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next()) {
        ++number;
        TopLoc_Location place;
        const auto mesh = BRep_Tool::Triangulation(TopoDS::Face(at.Current()), place);
        if (mesh.IsNull()) continue;
        const std::size_t first = out.points.size();
        for (int i = 1; i <= mesh->NbNodes(); ++i) {
            const gp_Pnt p = mesh->Node(i).Transformed(place);
            out.points.push_back({p.X(), p.Y(), p.Z()});
        }
        for (int i = 1; i <= mesh->NbTriangles(); ++i) {
            std::array<int, 3> c{};
            mesh->Triangle(i).Get(c[0], c[1], c[2]);
            std::array<std::size_t, 3> triangle{};
            for (std::size_t k = 0; k < 3; ++k) triangle[k] = first + static_cast<std::size_t>(c[k] - 1);
            out.triangles.push_back(triangle);
            out.faces.push_back(number);
        }
    }
    return out;
}

}  // namespace cad_tests

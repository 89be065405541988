// Reads STEP, IGES and BREP files; packs shapes.
#include "read.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <exception>
#include <fstream>
#include <ios>
#include <iostream>
#include <mutex>
#include <new>
#include <sstream>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <BinTools_FormatVersion.hxx>
#include <Bnd_Box.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TransferBRep.hxx>
#include <Transfer_Binder.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

namespace camber::occ {

namespace {

/// Millimetres of the unit with this name in CAD files; 0 if unknown.
double millimetres_of(std::string name) {
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    constexpr std::array<std::pair<std::string_view, double>, 20> units{
        {{"mm", 1},          {"millimetre", 1}, {"millimeter", 1},    {"cm", 10},        {"centimetre", 10},
         {"centimeter", 10}, {"m", 1000},       {"metre", 1000},      {"meter", 1000},   {"km", 1e6},
         {"kilometre", 1e6}, {"um", 1e-3},      {"micrometre", 1e-3}, {"in", 25.4},      {"inch", 25.4},
         {"inches", 25.4},   {"ft", 304.8},     {"foot", 304.8},      {"mile", 1609344}, {"mil", 0.0254}}};
    for (const auto& [word, size] : units)
        if (name == word) return size;
    return 0;
}

class OutputSilencer {
  public:
    OutputSilencer() : out_(std::cout.rdbuf(null_stream_.rdbuf())), err_(std::cerr.rdbuf(null_stream_.rdbuf())) {
        Message::DefaultMessenger()->ChangePrinters().Clear();
    }
    OutputSilencer(const OutputSilencer&) = delete;
    OutputSilencer& operator=(const OutputSilencer&) = delete;
    OutputSilencer(OutputSilencer&&) = delete;
    OutputSilencer& operator=(OutputSilencer&&) = delete;
    ~OutputSilencer() {
        std::cout.rdbuf(out_);
        std::cerr.rdbuf(err_);
    }

  private:
    std::ostringstream null_stream_;
    std::streambuf *out_, *err_;
};

Read failed(std::string reason) {
    Read out;
    out.error_text = std::move(reason);
    return out;
}

Read in_unit(TopoDS_Shape shape, std::string unit) {
    Read out;
    out.millimetres = unit.empty() ? 1 : millimetres_of(unit);
    if (out.millimetres == 0) return failed("it has lengths in an unknown unit, '" + unit + "'");
    out.shape = std::move(shape);
    out.unit = std::move(unit);
    return out;
}

Losses losses_of(const Handle(XSControl_WorkSession) & session) {
    Losses losses;
    const auto model = session->Model();
    const auto process = session->TransferReader()->TransientProcess();
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const auto& entity = model->Value(i);
        const bool is_face = entity->IsKind("StepShape_FaceSurface") || entity->IsKind("IGESGeom_TrimmedSurface") ||
                             entity->IsKind("IGESSolid_Face");
        if (is_face && TransferBRep::ShapeResult(process, entity).IsNull()) ++losses.faces;
        const auto binder = process->Find(entity);
        if (!binder.IsNull() && !binder->Check().IsNull() && binder->Check()->HasFailed()) ++losses.entities;
    }
    return losses;
}

std::size_t open_shells_of(const TopoDS_Shape& shape) {
    std::size_t count = 0;
    for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next())
        for (TopExp_Explorer shell(solid.Current(), TopAbs_SHELL); shell.More(); shell.Next())
            count += BRep_Tool::IsClosed(shell.Current()) ? 0 : 1;
    return count;
}

Read read_step(const char* path) {
    STEPControl_Reader reader;
    if (reader.ReadFile(path) != IFSelect_RetDone) return failed("it is not a STEP file, or it is damaged");
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.FileUnits(lengths, angles, solid_angles);
    if (reader.TransferRoots() == 0) return failed("its entities cannot be converted to a shape");
    Read out = in_unit(reader.OneShape(), lengths.IsEmpty() ? "" : lengths.First().ToCString());
    out.losses = losses_of(reader.WS());
    return out;
}

/// Joins coincident edges of faces; IGES files contain unconnected faces.
TopoDS_Shape sewn(const TopoDS_Shape& shape) {
    constexpr double within = 1e-5;  // largest gap between edges, relative to the size of the shape
    if (!TopExp_Explorer(shape, TopAbs_FACE).More()) return shape;  // the file contains only curves
    Bnd_Box box;
    BRepBndLib::Add(shape, box);
    BRepBuilderAPI_Sewing sewing(within * std::sqrt(box.SquareExtent()));
    sewing.Add(shape);
    sewing.Perform();
    return sewing.SewedShape();
}

Read read_iges(const char* path) {
    IGESControl_Reader reader;
    if (reader.ReadFile(path) != IFSelect_RetDone) return failed("it is not an IGES file, or it is damaged");
    std::string unit;
    if (const auto model = reader.IGESModel(); !model.IsNull())
        if (const auto name = model->GlobalSection().UnitName(); !name.IsNull()) unit = name->ToCString();
    if (reader.TransferRoots() == 0) return failed("its entities cannot be converted to a shape");
    Read out = in_unit(sewn(reader.OneShape()), unit);
    out.losses = losses_of(reader.WS());
    return out;
}

Read read_brep(const char* path) {
    TopoDS_Shape shape;
    if (!BRepTools::Read(shape, path, BRep_Builder())) return failed("it is not a BREP file, or it is damaged");
    return in_unit(std::move(shape), "");
}

}  // namespace

Read read(const char* path, Format format) {
    Read out = format == Format::step ? read_step(path) : format == Format::iges ? read_iges(path) : read_brep(path);
    if (out.error_text.empty() && out.shape.IsNull()) return failed("it contains no shape");
    if (out.error_text.empty()) BRepLib::BuildCurves3d(out.shape);
    if (out.error_text.empty()) out.losses.open_shells = open_shells_of(out.shape);
    return out;
}

// Format of packed models: one line of data about the file, then OpenCASCADE's binary BREP (exact numbers).
namespace {

constexpr const char* magic = "camber-cad-1";

}  // namespace

std::string packed(const Read& read) {
    std::ostringstream out(std::ios::binary);
    out.precision(17);
    out << magic << ' ' << read.millimetres << ' ' << read.losses.faces << ' ' << read.losses.entities << ' '
        << read.losses.open_shells << ' ' << read.unit << '\n';
    BinTools::Write(read.shape, out, Standard_False, Standard_False, BinTools_FormatVersion_CURRENT);
    return std::move(out).str();
}

Read unpacked(const std::string& bytes) {
    Read read;
    std::istringstream in(bytes, std::ios::binary);
    std::string word;
    in >> word >> read.millimetres >> read.losses.faces >> read.losses.entities >> read.losses.open_shells;
    if (!in || word != magic || in.get() != ' ' || !std::getline(in, read.unit)) {
        read.error_text = "the serialised model is incomplete";
        return read;
    }
    BinTools::Read(read.shape, in);
    if (read.shape.IsNull()) read.error_text = "it contains no shape";
    return read;
}

}  // namespace camber::occ

namespace {

template <class Make>
void open_with(camber::occ::Opened& opened, double millimetres, Make&& make) {
    // All threads share the readers' settings and messages.
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    CAMBER_OCC_KEEPS;
    opened.remedy = "export the model again";
    try {
        const camber::occ::OutputSilencer quiet;
        camber::occ::Read read = make();
        opened.error_text = read.error_text;
        if (read.error_text.empty()) opened.kernel = camber::occ::kernel_of(std::move(read), millimetres);
    } catch (const Standard_OutOfMemory&) {
        opened.is_out_of_memory = true;
    } catch (const std::bad_alloc&) {
        opened.is_out_of_memory = true;
    } catch (const Standard_Failure& failure) {
        opened.error_text = std::string("OpenCASCADE failed: ") + failure.GetMessageString();
    } catch (const std::exception& failure) {
        opened.error_text = std::string("it cannot be read: ") + failure.what();
    }
}

}  // namespace

extern "C" void camber_occ_open(const char* path, camber::occ::Format format, double millimetres,
                                camber::occ::Opened& opened) {
    if (!std::ifstream(path)) {
        opened.error_text = "cannot be opened";
        opened.remedy = "check the path";
        return;
    }
    open_with(opened, millimetres, [&] { return camber::occ::read(path, format); });
}

extern "C" void camber_occ_restore(const std::string& bytes, double millimetres, camber::occ::Opened& opened) {
    open_with(opened, millimetres, [&] { return camber::occ::unpacked(bytes); });
}

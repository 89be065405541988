// A shape as bytes: a line of what its file said, then OpenCASCADE's binary BREP, whose numbers are exact.
#include <ios>
#include <sstream>
#include <string>
#include <utility>
#include <BinTools.hxx>
#include <BinTools_FormatVersion.hxx>

#include "read.hpp"

namespace camber::occ {

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
        read.fault = "it was not handed over whole";
        return read;
    }
    BinTools::Read(read.shape, in);
    if (read.shape.IsNull()) read.fault = "it holds no shape";
    return read;
}

}  // namespace camber::occ

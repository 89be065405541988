#pragma once

#include <TopoDS_Shape.hxx>
#include <memory>
#include <string>

#include "kernel.hpp"

namespace camber::occ {

/// A file's shape in millimetres, and its unit.
struct Read {
    TopoDS_Shape shape;
    std::string unit;        ///< as the file calls it; empty: it says none
    double millimetres = 1;  ///< of that unit
    std::string fault;       ///< why there is no shape
};
[[nodiscard]] Read read(const char* path, Format format);

/// The model of a shape, its coordinates multiplied by `scale`.
[[nodiscard]] std::unique_ptr<Kernel> kernel_of(const TopoDS_Shape& shape, double scale);

}  // namespace camber::occ

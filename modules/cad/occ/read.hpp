#pragma once

#include <memory>
#include <string>
#include <TopoDS_Shape.hxx>

#include "kernel.hpp"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#include <sanitizer/lsan_interface.h>
/// What OpenCASCADE's readers and writers keep to the end is not ours to free.
#define CAMBER_OCC_KEEPS __lsan::ScopedDisabler keeps
#endif
#endif
#ifndef CAMBER_OCC_KEEPS
#define CAMBER_OCC_KEEPS
#endif

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

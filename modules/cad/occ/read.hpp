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
    Losses losses;
    std::string fault;  ///< why there is no shape
};
[[nodiscard]] Read read(const char* path, Format format);

/// A shape as bytes, and the shape of such bytes: the same to the last bit.
[[nodiscard]] std::string packed(const Read& read);
[[nodiscard]] Read unpacked(const std::string& bytes);

/// The model of a shape in a unit of so many millimetres; 0: that of its file.
[[nodiscard]] std::unique_ptr<Kernel> kernel_of(Read read, double millimetres);

}  // namespace camber::occ

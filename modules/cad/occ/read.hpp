#pragma once

#include <memory>
#include <string>
#include <TopoDS_Shape.hxx>

#include "kernel.hpp"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#include <sanitizer/lsan_interface.h>
/// OpenCASCADE's readers and writers keep global data until exit, which the leak checker must ignore.
#define CAMBER_OCC_KEEPS __lsan::ScopedDisabler keeps
#endif
#endif
#ifndef CAMBER_OCC_KEEPS
#define CAMBER_OCC_KEEPS
#endif

namespace camber::occ {

/// Contents of a CAD file; the shape is in millimetres.
struct Read {
    TopoDS_Shape shape;
    std::string unit;  ///< unit's name in the file; empty: none
    double millimetres = 1;
    Losses losses;
    std::string error_text;
};
[[nodiscard]] Read read(const char* path, Format format);

[[nodiscard]] std::string packed(const Read& read);
[[nodiscard]] Read unpacked(const std::string& bytes);

[[nodiscard]] std::unique_ptr<Kernel> kernel_of(Read read, double millimetres);

}  // namespace camber::occ

// Reads models from temporary files.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <string>

#include "models.hpp"

import camber.core;
import camber.cad;

namespace cad_tests {

inline camber::CadModel model_of(Kind kind, const std::array<double, 3>& sizes, const std::string& ending = ".brep") {
    const File file(ending);
    write_model(kind, sizes, file);
    auto model = camber::read_cad(file.path(), {});
    if (!model) FAIL(camber::describe(model.error()));
    return *model;
}

}  // namespace cad_tests

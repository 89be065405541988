#pragma once
#include <pybind11/pybind11.h>

namespace camber::python {

void bind_verbs(pybind11::module_& module);

}  // namespace camber::python

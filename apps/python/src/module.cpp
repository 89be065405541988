// camber._camber: what the package camber is made on. Users import the package.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <string>
#include <vector>

#include "mesh.hpp"
#include "verbs.hpp"
import camber.app_shell;
import camber.commands;

namespace {

/// The process that reads CAD models apart from this one: Python once more.
int read_cad(const std::vector<std::string>& words) {
    std::vector<const char*> arguments;
    arguments.reserve(words.size());
    for (const std::string& word : words) arguments.push_back(word.c_str());
    return camber::app::cad_reader({arguments.data(), arguments.size()}).value_or(1);
}

}  // namespace

PYBIND11_MODULE(_camber, module) {
    module.attr("version") = CAMBER_VERSION;
    camber::python::bind_mesh(module);
    camber::python::bind_verbs(module);
    module.def("read_cad", &read_cad);
    module.def("start_itself_by", &camber::app::start_itself_by);
}

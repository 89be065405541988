module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import :parts;

namespace camber {

namespace {

Box<3> boundary_of(const LinearMesh<3>& mesh) {
    Box<3> box;
    for (const auto& facet : mesh.facets.vertices)
        for (const VertexId v : facet) box.include(mesh.points[v]);
    return box;
}

/// Whether the box of a straight mesh's boundary is that of a model multiplied by `factor`, but for its chords.
bool agree(const Box<3>& mesh, const Box<3>& model, double factor) {
    constexpr double within = 0.1;
    const double most = within * mesh.diagonal();
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(mesh.low[k] - factor * model.low[k]) > most ||
            std::abs(mesh.high[k] - factor * model.high[k]) > most)
            return false;
    return true;
}

std::string text(const Box<3>& box) {
    std::array<char, 256> out{};
    std::snprintf(out.data(), out.size(), "(%.5g, %.5g, %.5g) to (%.5g, %.5g, %.5g)", box.low[0], box.low[1],
                  box.low[2], box.high[0], box.high[1], box.high[2]);
    return out.data();
}

/// What would bring the model to the mesh, as far as it is a matter of units.
std::string remedy(const Box<3>& mesh, const Box<3>& model, const CadParts& parts) {
    const double here = parts.kernel->millimetres;  // of the unit in which the model is
    for (const auto& [unit, word] : words(CadUnit{})) {
        if (unit == CadUnit::file || millimetres_of(unit) == here) continue;
        if (agree(mesh, model, here / millimetres_of(unit)))
            return "the mesh is in " + std::string(word) + ": give that as the unit of the CAD model";
    }
    return "give the CAD model of this mesh, in the mesh's place; if the file's unit is not the mesh's, say the mesh's";
}

}  // namespace

Outcome<Done> check_agreement(const LinearMesh<3>& mesh, const CadModel& model) {
    const Box<3> of_mesh = boundary_of(mesh), of_model = model.bounds();
    if (mesh.facets.size() == 0) return fail(ErrorKind::input, "the mesh has no boundary to put onto the CAD model");
    if (agree(of_mesh, of_model, 1)) return Done{};
    return fail(ErrorKind::input,
                "the mesh's boundary reaches from " + text(of_mesh) + ", the CAD model from " + text(of_model), {}, {},
                remedy(of_mesh, of_model, model.parts()));
}

}  // namespace camber

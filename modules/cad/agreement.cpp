module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import :in_plane;
import :parts;

namespace camber {

namespace {

/// The box of those facets of which `is_part(f)`.
template <int D, class IsPart>
Box<D> box_of(const LinearMesh<D>& mesh, IsPart&& is_part) {
    Box<D> box;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (is_part(f))
            for (const VertexId v : mesh.facets.vertices[f]) box.include(mesh.points[v]);
    return box;
}

/// In 2D that of the curves, at whichever height they are.
template <int D>
Box<D> box_of_model(const CadParts& parts) {
    if constexpr (D == 2)
        return in_plane(parts.of_edges);
    else
        return parts.bounds;
}
template <int D>
Box<D> box_of_face(const CadParts& parts, std::size_t face) {
    if constexpr (D == 2)
        return in_plane(parts.edges[face].bounds);
    else
        return parts.faces[face].bounds;
}

/// Whether the box of a straight mesh's boundary is that of a model multiplied by `factor`, but for its chords.
template <int D>
bool agree(const Box<D>& mesh, const Box<D>& model, double factor) {
    constexpr double within = 0.1;
    const double most = within * mesh.diagonal();
    for (std::size_t k = 0; k < D; ++k)
        if (std::abs(mesh.low[k] - factor * model.low[k]) > most ||
            std::abs(mesh.high[k] - factor * model.high[k]) > most)
            return false;
    return true;
}

std::string text(const Vec<2>& p) {
    std::array<char, 128> out{};
    std::snprintf(out.data(), out.size(), "(%.5g, %.5g)", p[0], p[1]);
    return out.data();
}
std::string text(const Vec<3>& p) {
    std::array<char, 128> out{};
    std::snprintf(out.data(), out.size(), "(%.5g, %.5g, %.5g)", p[0], p[1], p[2]);
    return out.data();
}
template <int D>
std::string text(const Box<D>& box) {
    return text(box.low) + " to " + text(box.high);
}

/// The unit of the mesh in which it would agree with the model.
template <int D>
std::optional<std::string> fitting_unit(const Box<D>& mesh, const Box<D>& model, const CadParts& parts) {
    const double here = parts.kernel->millimetres;  // of the unit in which the model is
    for (const auto& [unit, word] : words(CadUnit{})) {
        if (unit == CadUnit::file || millimetres_of(unit) == here) continue;
        if (agree(mesh, model, here / millimetres_of(unit))) return std::string(word);
    }
    return std::nullopt;
}

/// What would bring the model to the mesh, as far as it is a matter of units.
template <int D>
std::string remedy(const Box<D>& mesh, const Box<D>& model, const CadParts& parts) {
    if (const auto unit = fitting_unit(mesh, model, parts))
        return "the mesh is in " + *unit + ": give that as the unit of the CAD model";
    return "give the CAD model of this mesh, in the mesh's place; if the file's unit is not the mesh's, say the mesh's";
}

constexpr const char* part = "the part of the mesh's boundary that is to lie on the CAD model";

}  // namespace

template <int D>
Outcome<Done> check_inclusion(const LinearMesh<D>& mesh, const CadModel& model, std::span<const Reference> elsewhere) {
    const Box<D> of_part = box_of(mesh, [&](std::size_t f) {
        return !std::binary_search(elsewhere.begin(), elsewhere.end(), mesh.facets.references[f]);
    });
    const Box<D> of_model = box_of_model<D>(model.parts());
    const double most = near_enough * of_part.diagonal();
    bool is_within = is_finite(of_part.low) && is_finite(of_part.high);
    for (std::size_t k = 0; k < D; ++k)
        is_within = is_within && of_part.low[k] >= of_model.low[k] - most && of_part.high[k] <= of_model.high[k] + most;
    if (is_within) return Done{};
    return fail(ErrorKind::input,
                std::string(part) + " reaches from " + text(of_part) + ", the model from " + text(of_model), {}, {},
                remedy(of_part, of_model, model.parts()));
}

template <int D>
Outcome<Done> check_part(const LinearMesh<D>& mesh, const CadModel& model, const CadAssociation& association) {
    const Box<D> of_part = box_of(mesh, [&](std::size_t f) { return association.faces[f] != no_face; });
    Box<D> met;
    for (const auto& [reference, faces] : association.of_references)
        for (const std::size_t face : faces) met.include(box_of_face<D>(model.parts(), face));
    const auto unit = agree(of_part, met, 1) ? std::nullopt : fitting_unit(of_part, met, model.parts());
    if (unit)
        return fail(
            ErrorKind::input,
            std::string(part) + " reaches from " + text(of_part) + ", what it met of the model from " + text(met), {},
            {}, remedy(of_part, met, model.parts()));
    constexpr double most = 0.1;
    const auto& [strays, all] = std::pair(association.stray_vertices, association.vertices);
    if (static_cast<double>(strays) <= most * static_cast<double>(all)) return Done{};
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.3g", association.largest_vertex_distance);
    return fail(ErrorKind::input,
                std::to_string(strays) + " of the " + std::to_string(all) + " vertices of " + part +
                    " are farther from it than a tenth of their edges, the farthest by " + digits.data(),
                {}, Entity{"vertex", association.farthest_vertex.index() + 1},
                "give the CAD model of these references, in the mesh's place and unit, or name others");
}

template <int D>
Outcome<Done> check_agreement(const LinearMesh<D>& mesh, const CadModel& model) {
    const Box<D> of_mesh = box_of(mesh, [](std::size_t) { return true; });
    const Box<D> of_model = box_of_model<D>(model.parts());
    if (mesh.facets.size() == 0) return fail(ErrorKind::input, "the mesh has no boundary to put onto the CAD model");
    if (agree(of_mesh, of_model, 1)) return Done{};
    return fail(ErrorKind::input,
                "the mesh's boundary reaches from " + text(of_mesh) + ", the CAD model from " + text(of_model), {}, {},
                remedy(of_mesh, of_model, model.parts()));
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<Done> check_agreement<D>(const LinearMesh<D>&, const CadModel&);                             \
    template Outcome<Done> check_inclusion<D>(const LinearMesh<D>&, const CadModel&, std::span<const Reference>); \
    template Outcome<Done> check_part<D>(const LinearMesh<D>&, const CadModel&, const CadAssociation&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.box_tree;
import :parts;
import :virtual_faces;

namespace camber {

namespace {

std::optional<occ::Format> format_of(std::string_view path) {
    constexpr std::array<std::pair<std::string_view, occ::Format>, 6> endings{{{".step", occ::Format::step},
                                                                               {".stp", occ::Format::step},
                                                                               {".iges", occ::Format::iges},
                                                                               {".igs", occ::Format::iges},
                                                                               {".brep", occ::Format::brep},
                                                                               {".brp", occ::Format::brep}}};
    std::string lower(path);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const auto& [ending, format] : endings)
        if (lower.ends_with(ending)) return format;
    return std::nullopt;
}

}  // namespace

CadModel::CadModel(std::shared_ptr<const CadParts> parts) : parts_(std::move(parts)) {}

std::size_t CadModel::faces() const { return parts_->kernel->faces.size(); }
std::size_t CadModel::edges() const { return parts_->kernel->edges.size(); }
std::size_t CadModel::vertices() const { return parts_->kernel->vertices.size(); }
Box<3> CadModel::bounds() const { return parts_->bounds; }
Vec<3> CadModel::vertex(std::size_t vertex) const { return vec(parts_->kernel->vertices[vertex]); }
std::string CadModel::file_unit() const { return parts_->kernel->file_unit; }

std::string CadModel::unit() const {
    for (const auto& [unit, word] : words(CadUnit{}))
        if (millimetres_of(unit) == parts_->kernel->millimetres) return std::string(word);
    return parts_->kernel->file_unit;
}

bool CadModel::is_in_file_unit() const { return parts_->kernel->millimetres == parts_->kernel->file_millimetres; }

CadLosses CadModel::losses() const {
    const occ::Losses& losses = parts_->kernel->losses;
    return {losses.faces, losses.entities, losses.open_shells};
}

namespace {

/// The model of a kernel; errors name `path`.
Outcome<CadModel> model_with(std::unique_ptr<const occ::Kernel> kernel, const std::string& path) {
    if (kernel->edges.empty() && kernel->faces.empty())
        return fail(ErrorKind::input, "the model has no faces and no edges", path, {},
                    "export its solids or its shells; of a flat model its curves");
    auto parts = std::make_shared<CadParts>();
    parts->kernel = std::move(kernel);
    const auto is_bounded = [](const Box<3>& box) {
        constexpr double most = 1e60;
        return is_finite(box.low) && is_finite(box.high) && norm(box.low) <= most && norm(box.high) <= most;
    };
    const auto unbounded = [&](const char* kind, std::size_t index) {
        return fail(ErrorKind::input, "has no bounds or no points", path, Entity{kind, index + 1},
                    "export the model again");
    };
    for (std::size_t e = 0; e < parts->kernel->edges.size(); ++e) {
        parts->edges.push_back(cells_of_edge(*parts->kernel, e));
        if (!is_bounded(parts->edges.back().bounds)) return unbounded("edge", e);
    }
    for (const Cells& edge : parts->edges) parts->of_edges.include(edge.bounds);
    for (std::size_t f = 0; f < parts->kernel->faces.size(); ++f) {
        Cells cells = cells_of_face(*parts->kernel, f);
        if (parts->kernel->faces[f].is_plane) {
            // The rectangle of its parameters may be larger than a plane face: its edges tell.
            cells.bounds = cells.reach = {};
            for (const std::size_t e : parts->kernel->faces[f].edges) {
                cells.bounds.include(parts->edges[e].bounds);
                cells.reach.include(parts->edges[e].reach);
            }
        }
        if (!is_bounded(cells.bounds)) return unbounded("face", f);
        parts->bounds.include(cells.bounds);
        parts->faces.push_back(std::move(cells));
    }
    std::vector<Box<3>> reaches;
    for (const Cells& face : parts->faces) reaches.push_back(face.reach);
    parts->tree_of_faces = BoxTree<3>(reaches);
    if (parts->faces.empty()) parts->bounds = parts->of_edges;
    parts->size = parts->bounds.diagonal();
    parts->virtual_faces = virtual_faces(*parts->kernel);
    parts->virtual_curves = virtual_curves(*parts->kernel);
    if (!(parts->size > 0)) return fail(ErrorKind::input, "the model has no size", path);
    return CadModel(std::move(parts));
}

}  // namespace

Outcome<CadModel> read_cad(const std::string& path, const CadOptions& options) {
    const auto format = format_of(path);
    if (!format)
        return fail(ErrorKind::usage, "no CAD format known for this ending", path, {},
                    "use " + std::string(cad_endings));
    return guarded([&]() -> Outcome<CadModel> {
        auto kernel = open_kernel(path, *format, millimetres_of(options.unit));
        if (!kernel) return fail(kernel.error());
        return model_with(std::move(*kernel), path);
    });
}

Outcome<std::string> packed_cad(const CadModel& model) {
    return guarded([&]() -> Outcome<std::string> { return model.parts().kernel->packed(); });
}

Outcome<CadModel> unpacked_cad(const std::string& bytes, const CadOptions& options) {
    return guarded([&]() -> Outcome<CadModel> {
        auto kernel = restored_kernel(bytes, millimetres_of(options.unit));
        if (!kernel) return fail(kernel.error());
        return model_with(std::move(*kernel), {});
    });
}

Outcome<CadModel> in_unit(const CadModel& model, CadUnit unit) {
    const auto bytes = packed_cad(model);
    if (!bytes) return fail(bytes.error());
    return unpacked_cad(*bytes, {unit});
}

}  // namespace camber

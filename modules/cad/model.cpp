// Loads the OpenCASCADE library; reads, packs and copies models.
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
#include <dlfcn.h>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.box_tree;
import :parts;

namespace camber {

#ifdef CAMBER_OCC_BUILT

namespace {

struct Library {
    occ::Open* open = nullptr;
    occ::Restore* restore = nullptr;
    std::string missing;  ///< error message if the library cannot be loaded
};

Library loaded() {
    Library library;
    // Search order: beside the program (also if it was moved), in the build tree, in the install prefix.
    for (const char* const name :
         {"$ORIGIN/../" CAMBER_OCC_BESIDE, "$ORIGIN/" CAMBER_OCC_FILE, CAMBER_OCC_BUILT, CAMBER_OCC_INSTALLED}) {
        void* const handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        if (handle == nullptr) {
            const char* const said = dlerror();
            const std::string reason = said != nullptr ? said : "no such library";
            // A missing file is not reported; a broken library is.
            if (reason.starts_with(name) && reason.ends_with("No such file or directory")) continue;
            library.missing += (library.missing.empty() ? "" : "; ") + reason;
            continue;
        }
        library.open = reinterpret_cast<occ::Open*>(dlsym(handle, "camber_occ_open"));
        library.restore = reinterpret_cast<occ::Restore*>(dlsym(handle, "camber_occ_restore"));
        if (library.open != nullptr && library.restore != nullptr) break;
        library.open = nullptr;
        library.missing = std::string(name) + " is not of this version of Camber";
    }
    if (library.open == nullptr && library.missing.empty()) library.missing = CAMBER_OCC_BESIDE " is not there";
    return library;
}

template <class Open>
Outcome<std::unique_ptr<const occ::Kernel>> kernel_by(const std::string& path, Open&& open) {
    static const Library library = loaded();
    if (library.open == nullptr)
        return fail(ErrorKind::unsupported, "OpenCASCADE cannot be loaded: " + library.missing, path, {},
                    "install Camber's package camber-cad, or Debian's libocct-data-exchange-7.6, or use another "
                    "geometry");
    occ::Opened opened;
    open(library, opened);
    if (opened.is_out_of_memory)
        return fail(ErrorKind::memory, "not enough memory to read the model", path, {}, "make more memory available");
    if (!opened.kernel) return fail(ErrorKind::input, opened.error_text, path, {}, opened.remedy);
    return std::unique_ptr<const occ::Kernel>(std::move(opened.kernel));
}

}  // namespace

bool has_cad_support() { return true; }

Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format format,
                                                        double millimetres) {
    return kernel_by(path, [&](const Library& library, occ::Opened& opened) {
        library.open(path.c_str(), format, millimetres, opened);
    });
}

Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string& bytes, double millimetres) {
    return kernel_by({},
                     [&](const Library& library, occ::Opened& opened) { library.restore(bytes, millimetres, opened); });
}

#else

bool has_cad_support() { return false; }

Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format, double) {
    return fail(ErrorKind::unsupported, "this build of Camber reads no CAD files", path, {},
                "install OpenCASCADE (Debian: libocct-data-exchange-dev) and build again, or use another geometry");
}

Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string&, double millimetres) {
    return open_kernel({}, {}, millimetres);
}

#endif

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

Outcome<CadModel> model_with(std::unique_ptr<const occ::Kernel> kernel, const std::string& path) {
    if (kernel->edges.empty() && kernel->faces.empty())
        return fail(ErrorKind::input, "the model has no faces and no edges", path, {},
                    "export its solids or its shells, or the curves of a plane model");
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
    for (const EntityCells& edge : parts->edges) parts->of_edges.include(edge.bounds);
    for (std::size_t f = 0; f < parts->kernel->faces.size(); ++f) {
        EntityCells cells = cells_of_face(*parts->kernel, f);
        if (parts->kernel->faces[f].is_plane) {
            // A planar face may be smaller than its parameter rectangle: its edges give the bounds.
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
    for (const EntityCells& face : parts->faces) reaches.push_back(face.reach);
    parts->tree_of_faces = BoxTree<3>(reaches);
    if (parts->faces.empty()) parts->bounds = parts->of_edges;
    parts->size = parts->bounds.diagonal();
    parts->virtual_faces = virtual_faces(*parts->kernel);
    parts->virtual_curves = virtual_curves(*parts->kernel);
    if (!(parts->size > 0)) return fail(ErrorKind::input, "the size of the model is zero", path);
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

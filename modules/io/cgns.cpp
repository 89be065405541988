module;
#include <algorithm>
#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

bool is_cgns(std::span<const std::byte> bytes) {
    constexpr std::string_view hdf5("\x89HDF\r\n\x1a\n", 8), adf("@(#)ADF");
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 64));
    return text.starts_with(hdf5) || text.starts_with(adf);
}

bool is_in_cgns(const MeshField& field) {
    return field.centring == Centring::node && (field.kind == FieldKind::scalar || field.kind == FieldKind::vector);
}

namespace {

/// Simplices of a reference that has come and gone before.
std::size_t out_of_run(const Column<Reference>& references) {
    std::size_t count = 0;
    std::set<Reference> seen;
    for (std::size_t i = 0; i < references.size(); ++i) {
        if (i > 0 && references[i] == references[i - 1]) continue;
        if (!seen.insert(references[i]).second) ++count;
    }
    return count;
}

}  // namespace

template <int D>
std::vector<Notice> not_in_cgns(const LinearMesh<D>& mesh) {
    std::vector<Notice> losses = not_held(mesh, {.groups = true, .point_references = false}, "CGNS");
    if (out_of_run(mesh.elements.references) + out_of_run(mesh.facets.references) + out_of_run(mesh.edges.references) >
        0)
        losses.push_back({"CGNS has a section for each reference: simplices are brought into their order"});
    const auto changed = std::count_if(mesh.groups.begin(), mesh.groups.end(), [](const Group& group) {
        return group.name.size() > 32 || group.name.find('/') != std::string::npos;
    });
    if (changed > 0)
        losses.push_back({"CGNS has names of 32 letters without /: " + std::to_string(changed) + " names are changed"});
    for (Notice& notice : not_in_further_groups(mesh, "CGNS")) losses.push_back(std::move(notice));
    return losses;
}

#define CAMBER_INSTANTIATE(D) template std::vector<Notice> not_in_cgns<D>(const LinearMesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

namespace cgns {

std::string plain_name(int dimension, Reference reference) {
    const char* const kind = dimension == 1 ? "edges_" : dimension == 2 ? "triangles_" : "tetrahedra_";
    return kind + std::to_string(reference);
}

Error no_folder(std::string_view root) {
    return {ErrorKind::write,
            "no folder for temporary files can be made",
            std::string(root),
            {},
            "set TMPDIR to a folder with room for the file"};
}

Error error_of(const char* said, ErrorKind kind, std::string_view doing, std::string_view name) {
    const std::string_view words = said != nullptr ? said : "";
    const bool says_something = !words.empty() && !words.starts_with("no CGNS error");
    const std::string reason = says_something ? ": " + std::string(words) : std::string();
    const char* const remedy =
        kind == ErrorKind::input ? "the file is damaged, or no CGNS file: try cgnscheck on it" : "";
    return {kind, std::string(doing) + reason, std::string(name), {}, remedy};
}

Error no_library(std::string_view why) {
    return {ErrorKind::unsupported,
            "CGNS needs its library, which is not to be had: " + std::string(why),
            {},
            {},
            "install it (Debian: libcgns3.4), or take another format"};
}

}  // namespace cgns

}  // namespace camber

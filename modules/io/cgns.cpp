// CGNS code that does not need the library: recognition, names, losses, errors.
module;
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

constexpr std::string_view hdf5("\x89HDF\r\n\x1a\n", 8), adf("@(#)ADF");

std::string_view beginning_of(std::span<const std::byte> bytes, std::size_t size) {
    return {reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), size)};
}

}  // namespace

bool is_med(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 65536;  // bytes that contain the names of the file's first nodes
    const std::string_view text = beginning_of(bytes, soon);
    return text.starts_with(hdf5) && text.find("INFOS_GENERALES") != std::string_view::npos;
}

bool is_cgns(std::span<const std::byte> bytes) {
    const std::string_view text = beginning_of(bytes, hdf5.size());
    return (text.starts_with(hdf5) && !is_med(bytes)) || text.starts_with(adf);
}

bool is_in_cgns(const MeshField& field) {
    return field.centring == Centring::node && (field.kind == FieldKind::scalar || field.kind == FieldKind::vector);
}

namespace {

std::size_t repeated_runs(const Column<Reference>& references) {
    std::size_t count = 0;
    std::set<Reference> visited;
    for (std::size_t i = 0; i < references.size(); ++i) {
        if (i > 0 && references[i] == references[i - 1]) continue;
        if (!visited.insert(references[i]).second) ++count;
    }
    return count;
}

}  // namespace

namespace cgns {

namespace {

std::string node_name(std::string_view name) {
    std::string text = readable_name(name);
    std::replace(text.begin(), text.end(), '/', '_');
    const std::size_t first = text.find_first_not_of(' ');
    if (first == std::string::npos) return {};
    text = text.substr(first, text.find_last_not_of(' ') - first + 1);
    return text == "." || text == ".." ? std::string() : text;
}
constexpr std::size_t longest_name = 32;

std::string main_name(const Column<Group>& groups, int dimension, Reference reference) {
    for (const Group& group : groups)
        if (group.dimension == dimension && group.reference == reference) return group.name;
    return {};
}

template <int D>
std::vector<std::pair<int, Reference>> references_of(const LinearMesh<D>& mesh) {
    std::vector<std::pair<int, Reference>> all;
    const auto add = [&]<int K>(const Simplices<K>& simplices) {
        const std::set<Reference> references(simplices.references.begin(), simplices.references.end());
        for (const Reference reference : references) all.emplace_back(K, reference);
    };
    add(mesh.elements);
    if constexpr (D == 3) add(mesh.edges);
    add(mesh.facets);
    return all;
}

/// Chooses a name for each reference: the name of its first group, made legal, or `plain_name` if the reference has no
/// group.
ReferenceNames names_of(const std::vector<std::pair<int, Reference>>& references, const Column<Group>& groups,
                        std::vector<std::string> reserved) {
    std::vector<ListedName> requested;
    for (const auto& [dimension, reference] : references) {
        reserved.push_back(plain_name(dimension, reference));
        if (std::string name = main_name(groups, dimension, reference); !name.empty())
            requested.push_back({std::move(name)});
    }
    const auto legal = legal_names(requested, {node_name, longest_name, std::move(reserved)});
    ReferenceNames names;
    std::size_t named = 0;
    for (const auto& [dimension, reference] : references) {
        const bool has_name = !main_name(groups, dimension, reference).empty();
        names[{dimension, reference}] = has_name ? legal[named++] : plain_name(dimension, reference);
    }
    return names;
}

template <int D>
std::vector<Notice> changed_names(const LinearMesh<D>& mesh) {
    const GroupNames names = group_names(mesh);
    std::vector<Renaming> renamed;
    std::set<std::pair<int, Reference>> visited;
    std::size_t lost = 0;
    for (const Group& group : mesh.groups) {
        const std::pair key(group.dimension, group.reference);
        if (!visited.insert(key).second) continue;  // only the first group of a reference names a section or condition
        const auto condition = names.conditions.find(key), section = names.sections.find(key);
        const bool is_condition = condition != names.conditions.end();
        if ((!is_condition && section == names.sections.end()) || group.name.empty())
            ++lost;
        else
            renamed.emplace_back(group.name, is_condition ? condition->second : section->second);
    }
    std::vector<Notice> notices = note_renamed("CGNS", "references", renamed);
    if (lost > 0)
        notices.push_back({"CGNS has no place for " + std::to_string(lost) +
                           " names of references: they are empty, or no simplex has them"});
    return notices;
}

}  // namespace

MeshFields fields_in_file(const MeshFields& fields) {
    MeshFields supported;
    for (const MeshField& field : fields)
        if (is_in_cgns(field)) supported = std::move(supported).with(field);
    return supported;
}

FieldNames field_names() {
    const NameRule rule{node_name, longest_name, {"GridLocation", "Rind"}};
    return {rule, rule, [](FieldKind kind) {
                return kind == FieldKind::vector ? std::vector<std::string>{"X", "Y", "Z"}
                                                 : std::vector<std::string>{{}};
            }};
}

template <int D>
GroupNames group_names(const LinearMesh<D>& mesh) {
    const auto references = references_of(mesh);
    GroupNames names{names_of(references, mesh.groups, {"GridCoordinates", "ZoneBC", "ZoneType", "FlowSolution"}), {}};
    if (is_standalone_surface(mesh)) return names;
    std::vector<std::pair<int, Reference>> of_facets;
    for (const auto& reference : references)
        if (reference.first == D - 1) of_facets.push_back(reference);
    names.conditions = names_of(of_facets, mesh.groups, {});
    return names;
}

template GroupNames group_names<2>(const LinearMesh<2>&);
template GroupNames group_names<3>(const LinearMesh<3>&);

}  // namespace cgns

template <int D>
std::vector<Notice> not_in_cgns(const Mesh<D>& all) {
    const LinearMesh<D> mesh = straight_simplices(all);
    std::vector<Notice> losses = unsupported_data(mesh, {.groups = true, .point_references = false}, "CGNS");
    if (repeated_runs(mesh.elements.references) + repeated_runs(mesh.facets.references) +
            repeated_runs(mesh.edges.references) >
        0)
        losses.push_back({"CGNS has one section for each reference: simplices were reordered"});
    for (Notice& notice : cgns::changed_names(mesh)) losses.push_back(std::move(notice));
    for (Notice& notice : not_in_further_groups(mesh, "CGNS")) losses.push_back(std::move(notice));
    return losses;
}

#define CAMBER_INSTANTIATE(D) template std::vector<Notice> not_in_cgns<D>(const Mesh<D>&);

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
            "no folder for temporary files can be created",
            std::string(root),
            {},
            "set TMPDIR to a folder with room for the file"};
}

Error error_of(const char* said, ErrorKind kind, std::string_view doing, std::string_view name) {
    const int failure = errno;
    const std::string_view words = said != nullptr ? said : "";
    const bool has_message = !words.empty() && !words.starts_with("no CGNS error");
    const std::string reason = has_message ? ": " + std::string(words) : std::string();
    if (kind == ErrorKind::input)
        return {kind,
                std::string(doing) + reason,
                std::string(name),
                {},
                "the file is damaged, or is not a CGNS file; check it with cgnscheck"};
    // The library's error text names only the failed call; errno has the reason from the system.
    const bool has_no_place = failure == EFBIG || failure == ENOSPC || failure == EDQUOT;
    const std::string of_system = has_no_place ? ": " + std::generic_category().message(failure) : std::string();
    const char* const remedy = failure == EFBIG ? "raise the limit (ulimit -f)"
                               : has_no_place   ? "set TMPDIR to a folder with room for the file"
                                                : "";
    return {kind, std::string(doing) + of_system + reason, std::string(name), {}, remedy};
}

Error no_library(std::string_view cause) {
    return {ErrorKind::unsupported,
            "the CGNS library cannot be loaded: " + std::string(cause),
            {},
            {},
            "install it (Debian: libcgns3.4), or use another format"};
}

}  // namespace cgns

#ifdef CAMBER_NO_CGNS
// Functions of the interface for builds without the CGNS library.

namespace {

auto absent() {
    return fail(ErrorKind::unsupported, "this build of Camber has no CGNS", {}, {},
                "install the library (Debian: libcgns-dev) and build again, or use another format");
}

}  // namespace

bool has_cgns_support() { return false; }

Outcome<DecodedMesh> decode_cgns(std::span<const std::byte>, std::string_view, const DecodeOptions&, const Execution&) {
    return absent();
}

template <int D>
Outcome<Chunks> encode_cgns(const Mesh<D>&, const MeshFields&, const Execution&) {
    return absent();
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Chunks> encode_cgns<D>(const Mesh<D>&, const MeshFields&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

#endif

}  // namespace camber

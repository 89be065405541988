module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
module camber.soundness;
import camber.core;
import camber.validity;

namespace camber {

namespace {

enum class EntityClass : std::uint8_t { element, facet, vertex, node, edge };

/// Texts for a defect, with placeholders. %e: element, %E: elements, %f: facet, %F: facets, #: number of the other
/// entity, %>: far end of a boundary edge (empty in 2D, where the edge is a vertex).
struct Wording {
    const char* key;
    Severity severity;
    EntityClass entity;
    const char *one, *many;
    const char* remedy;
};

// The texts below contain these numbers.
static_assert(min_length == 1e-60 && max_length == 1e60);

constexpr std::array<Wording, defect_count> wordings{{
    {"repeated_elements", Severity::mended, EntityClass::element, "lists the vertices of %e # again",
     "list the vertices of an earlier one again", "remove it"},
    {"contradicting_elements", Severity::fatal, EntityClass::element, "has the vertices of %e #, but another reference",
     "have the vertices of an earlier one, but another reference", "remove one of them"},
    {"non_manifold_faces", Severity::fatal, EntityClass::element, "shares a face with more than one other %e",
     "share a face with more than one other %e", "elements must not overlap"},
    {"stray_facets", Severity::harmless, EntityClass::facet, "is a face of no %e", "are a face of no %e", "remove it"},
    {"repeated_facets", Severity::mended, EntityClass::facet, "lists the vertices of %f # again",
     "list the vertices of an earlier one again", "remove it"},
    {"contradicting_facets", Severity::fatal, EntityClass::facet, "has the vertices of %f #, but another reference",
     "have the vertices of an earlier one, but another reference", "remove one of them"},
    {"distant_vertices", Severity::fatal, EntityClass::vertex, "is more than 1e60 away from the origin",
     "are more than 1e60 away from the origin", "use another unit of length"},
    {"distant_nodes", Severity::fatal, EntityClass::node, "is more than 1e60 away from the origin",
     "are more than 1e60 away from the origin", "use another unit of length"},
    {"tiny_elements", Severity::fatal, EntityClass::element, "is smaller than 1e-60", "are smaller than 1e-60",
     "use another unit of length"},
    {"tiny_facets", Severity::fatal, EntityClass::facet, "is smaller than 1e-60", "are smaller than 1e-60",
     "use another unit of length"},
    {"hanging_vertices", Severity::fatal, EntityClass::vertex,
     "lies inside a face of %e #, which does not have it as a vertex",
     "lie inside faces that do not have them as a vertex",
     "the elements must meet face to face; if a gap is intended there, list the boundary on both sides"},
    {"duplicate_vertices", Severity::fatal, EntityClass::vertex, "has the same position as vertex #",
     "have the same position as an earlier one",
     "merge them; if a slit is intended there, list the boundary on both sides"},
    {"reversed_elements", Severity::mended, EntityClass::element, "is numbered the wrong way round",
     "are numbered the wrong way round", "swap two of its vertices"},
    {"tangled_elements", Severity::blocking, EntityClass::element, "is inverted, or overlaps its neighbours",
     "are inverted, or overlap their neighbours", "repair the straight mesh"},
    {"flat_elements", Severity::blocking, EntityClass::element, "has no volume", "have no volume",
     "repair the straight mesh"},
    {"missing_facets", Severity::mended, EntityClass::element, "has a face on the boundary that is not listed",
     "have faces on the boundary that are not listed", "list it"},
    {"no_facets", Severity::harmless, EntityClass::element, "has a face on the boundary, but no boundary is listed",
     "have faces on the boundary, but no boundary is listed", "list the boundary"},
    {"missing_interfaces", Severity::harmless, EntityClass::element,
     "has an unlisted face to a %e of another reference", "have unlisted faces to %E of another reference", "list it"},
    {"unused_vertices", Severity::harmless, EntityClass::vertex, "belongs to no entity", "belong to no entity",
     "remove it"},
    {"slit_vertices", Severity::harmless, EntityClass::vertex, "has the same position as vertex #, across a slit",
     "have the same position as an earlier one, across a slit", ""},
    {"coincident_nodes", Severity::blocking, EntityClass::node, "has the same position as node #",
     "have the same position as another one", "all nodes of a mesh must have different positions"},
    {"inner_facets", Severity::harmless, EntityClass::facet, "lies between %E of one reference",
     "lie between %E of one reference", ""},
    {"open_edges", Severity::harmless, EntityClass::edge,
     "%>belongs to only one %f of the boundary: the boundary is not closed",
     "belong to only one %f of the boundary: the boundary is not closed", "list the other %F of the boundary"},
    {"non_manifold_edges", Severity::harmless, EntityClass::edge,
     "to vertex # is shared by more than two faces of the boundary",
     "are shared by more than two faces of the boundary", ""},
    {"pinched_vertices", Severity::harmless, EntityClass::vertex, "is a point at which the boundary touches itself",
     "are points at which the boundary touches itself", ""},
    {"isolated_edges", Severity::harmless, EntityClass::edge, "belongs to no %e and no %f", "belong to no %e and no %f",
     "remove it"},
    {"wall_elements", Severity::harmless, EntityClass::element,
     "has two %F on one smooth boundary, so no node positions make it good after curving; it needs a swap",
     "have two %F on one smooth boundary, so no node positions make them good after curving; they need a swap",
     "swap an edge"},
}};

const Wording& wording(Defect defect) { return wordings[static_cast<std::size_t>(defect)]; }

constexpr std::array element_name{"", "", "triangle", "tetrahedron"};
constexpr std::array elements_name{"", "", "triangles", "tetrahedra"};
constexpr std::array facet_name{"", "", "edge", "triangle"};
constexpr std::array facets_name{"", "", "edges", "triangles"};

std::string noun(const Soundness& s, Defect defect) {
    const auto d = static_cast<std::size_t>(s.dimension);
    switch (wording(defect).entity) {
        case EntityClass::element: return element_name[d];
        case EntityClass::facet: return facet_name[d];
        case EntityClass::vertex: return "vertex";
        case EntityClass::node: return "node";
        case EntityClass::edge:
            return defect == Defect::isolated_edge ? "edge" : d == 2 ? "vertex" : "edge from vertex";
    }
    return {};
}
std::string nouns(const Soundness& s, Defect defect) {
    const auto d = static_cast<std::size_t>(s.dimension);
    switch (wording(defect).entity) {
        case EntityClass::element: return elements_name[d];
        case EntityClass::facet: return facets_name[d];
        case EntityClass::vertex: return "vertices";
        case EntityClass::node: return "nodes";
        case EntityClass::edge: return defect != Defect::isolated_edge && d == 2 ? "vertices" : "edges";
    }
    return {};
}

std::string filled(const Soundness& s, std::string_view text, std::size_t other) {
    const auto d = static_cast<std::size_t>(s.dimension);
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '#') {
            out += std::to_string(other);
        } else if (text[i] == '%' && i + 1 < text.size()) {
            const char what = text[++i];
            if (what == '>')
                out += d == 2 ? "" : "to vertex " + std::to_string(other) + " ";
            else
                out += what == 'e'   ? element_name[d]
                       : what == 'E' ? elements_name[d]
                       : what == 'F' ? facets_name[d]
                                     : facet_name[d];
        } else {
            out += text[i];
        }
    }
    return out;
}

}  // namespace

bool Soundness::sound() const {
    if (empty) return false;
    for (std::size_t i = 0; i < defect_count; ++i)
        if (findings[i].count > 0 && wordings[i].severity != Severity::harmless) return false;
    return true;
}

Severity severity(Defect defect) { return wording(defect).severity; }
const char* key(Defect defect) { return wording(defect).key; }

std::string sentence(const Soundness& soundness, Defect defect) {
    const Finding& found = soundness[defect];
    const Wording& words = wording(defect);
    const std::string first = noun(soundness, defect) + " " + std::to_string(found.first);
    if (found.count == 1) return first + " " + filled(soundness, words.one, found.other);
    return std::to_string(found.count) + " " + nouns(soundness, defect) + " " +
           filled(soundness, words.many, found.other) + " (the first: " + first + ")";
}

std::optional<Error> refusal(const Soundness& soundness) {
    if (soundness.empty)
        return Error{ErrorKind::input,
                     "the mesh is empty: it has neither elements nor facets",
                     {},
                     {},
                     "give a mesh with elements"};
    for (std::size_t i = 0; i < defect_count; ++i) {
        const Finding& found = soundness.findings[i];
        if (found.count == 0 || wordings[i].severity != Severity::fatal) continue;
        std::string what = filled(soundness, wordings[i].one, found.other);
        if (found.count > 1) what += ", the first of " + std::to_string(found.count);
        return Error{ErrorKind::input,
                     what,
                     {},
                     Entity{noun(soundness, Defect{static_cast<std::uint8_t>(i)}), found.first},
                     wordings[i].remedy};
    }
    return {};
}

}  // namespace camber

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

enum class Who : std::uint8_t { element, facet, vertex, node, edge };

/// Texts. %e element, %E elements, %f facet, %F facets, # the other entity's number, %> the far end of a boundary edge
/// (empty in 2D, where it is a vertex).
struct Wording {
    const char* key;
    Gravity gravity;
    Who who;
    const char *one, *many;
    const char* remedy;
};

// The texts below contain these numbers.
static_assert(min_length == 1e-60 && max_length == 1e60);

/// In the order of Defect.
constexpr std::array<Wording, defect_count> wordings{{
    {"repeated_elements", Gravity::mended, Who::element, "lists the vertices of %e # again",
     "list the vertices of an earlier one again", "remove it"},
    {"contradicting_elements", Gravity::fatal, Who::element, "has the vertices of %e #, but another reference",
     "have the vertices of an earlier one, but another reference", "remove one of them"},
    {"non_manifold_faces", Gravity::fatal, Who::element, "shares a face with more than one other %e",
     "share a face with more than one other %e", "elements must not overlap"},
    {"stray_facets", Gravity::harmless, Who::facet, "is a face of no %e", "are a face of no %e", "remove it"},
    {"repeated_facets", Gravity::mended, Who::facet, "lists the vertices of %f # again",
     "list the vertices of an earlier one again", "remove it"},
    {"contradicting_facets", Gravity::fatal, Who::facet, "has the vertices of %f #, but another reference",
     "have the vertices of an earlier one, but another reference", "remove one of them"},
    {"distant_vertices", Gravity::fatal, Who::vertex, "is more than 1e60 away from the origin",
     "are more than 1e60 away from the origin", "use another unit of length"},
    {"distant_nodes", Gravity::fatal, Who::node, "is more than 1e60 away from the origin",
     "are more than 1e60 away from the origin", "use another unit of length"},
    {"tiny_elements", Gravity::fatal, Who::element, "is smaller than 1e-60", "are smaller than 1e-60",
     "use another unit of length"},
    {"tiny_facets", Gravity::fatal, Who::facet, "is smaller than 1e-60", "are smaller than 1e-60",
     "use another unit of length"},
    {"hanging_vertices", Gravity::fatal, Who::vertex, "lies inside a face of %e #, which does not have it as a vertex",
     "lie inside faces that do not have them as a vertex",
     "the elements must meet face to face; if a gap is intended there, list the boundary on both sides"},
    {"duplicate_vertices", Gravity::fatal, Who::vertex, "has the same position as vertex #",
     "have the same position as an earlier one",
     "merge them; if a slit is intended there, list the boundary on both sides"},
    {"reversed_elements", Gravity::mended, Who::element, "is numbered the wrong way round",
     "are numbered the wrong way round", "swap two of its vertices"},
    {"tangled_elements", Gravity::spoils, Who::element, "is inverted, or overlaps its neighbours",
     "are inverted, or overlap their neighbours", "repair the straight mesh"},
    {"flat_elements", Gravity::spoils, Who::element, "has no volume", "have no volume", "repair the straight mesh"},
    {"missing_facets", Gravity::mended, Who::element, "has a face on the boundary that is not listed",
     "have faces on the boundary that are not listed", "list it"},
    {"no_facets", Gravity::harmless, Who::element, "has a face on the boundary, but no boundary is listed",
     "have faces on the boundary, but no boundary is listed", "list the boundary"},
    {"missing_interfaces", Gravity::harmless, Who::element, "has an unlisted face to a %e of another reference",
     "have unlisted faces to %E of another reference", "list it"},
    {"unused_vertices", Gravity::harmless, Who::vertex, "belongs to no entity", "belong to no entity", "remove it"},
    {"slit_vertices", Gravity::harmless, Who::vertex, "has the same position as vertex #, across a slit",
     "have the same position as an earlier one, across a slit", ""},
    {"coincident_nodes", Gravity::spoils, Who::node, "has the same position as node #",
     "have the same position as another one", "all nodes of a mesh must have different positions"},
    {"inner_facets", Gravity::harmless, Who::facet, "lies between %E of one reference",
     "lie between %E of one reference", ""},
    {"open_edges", Gravity::harmless, Who::edge, "%>belongs to only one %f of the boundary: the boundary is not closed",
     "belong to only one %f of the boundary: the boundary is not closed", "list the other %F of the boundary"},
    {"non_manifold_edges", Gravity::harmless, Who::edge, "to vertex # is shared by more than two faces of the boundary",
     "are shared by more than two faces of the boundary", ""},
    {"pinched_vertices", Gravity::harmless, Who::vertex, "is a point at which the boundary touches itself",
     "are points at which the boundary touches itself", ""},
    {"isolated_edges", Gravity::harmless, Who::edge, "belongs to no %e and no %f", "belong to no %e and no %f",
     "remove it"},
    {"wall_elements", Gravity::harmless, Who::element,
     "has two %F on one smooth boundary, so no node positions make it good after curving; it needs a swap",
     "have two %F on one smooth boundary, so no node positions make them good after curving; they need a swap",
     "swap an edge"},
}};

const Wording& wording(Defect defect) { return wordings[static_cast<std::size_t>(defect)]; }

constexpr std::array element_name{"", "", "triangle", "tetrahedron"};
constexpr std::array elements_name{"", "", "triangles", "tetrahedra"};
constexpr std::array facet_name{"", "", "edge", "triangle"};
constexpr std::array facets_name{"", "", "edges", "triangles"};

/// Boundary edges have no number; their lower vertex identifies them.
std::string noun(const Soundness& s, Defect defect) {
    const auto d = static_cast<std::size_t>(s.dimension);
    switch (wording(defect).who) {
        case Who::element: return element_name[d];
        case Who::facet: return facet_name[d];
        case Who::vertex: return "vertex";
        case Who::node: return "node";
        case Who::edge: return defect == Defect::lone_edge ? "edge" : d == 2 ? "vertex" : "edge from vertex";
    }
    return {};
}
std::string nouns(const Soundness& s, Defect defect) {
    const auto d = static_cast<std::size_t>(s.dimension);
    switch (wording(defect).who) {
        case Who::element: return elements_name[d];
        case Who::facet: return facets_name[d];
        case Who::vertex: return "vertices";
        case Who::node: return "nodes";
        case Who::edge: return defect != Defect::lone_edge && d == 2 ? "vertices" : "edges";
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
        if (findings[i].count > 0 && wordings[i].gravity != Gravity::harmless) return false;
    return true;
}

Gravity gravity(Defect defect) { return wording(defect).gravity; }
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
        if (found.count == 0 || wordings[i].gravity != Gravity::fatal) continue;
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

// Writes MFEM meshes: boundary, attributes and nodes.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace mfem {

namespace {

template <int K>
Outcome<Simplices<K - 1>> faces_of(const Simplices<K>& elements, const Simplices<K - 1>& boundary,
                                   const Execution& execution) {
    const RowsByVertices<K - 1> rows(boundary.vertices);
    Buffer<std::uint8_t> is_face(boundary.size(), std::uint8_t{0});
    auto marked = each(execution, elements.size(), [&](std::size_t e) {
        for (int i = 0; i <= K; ++i) {
            SimplexVertices<K - 1> face;
            for (int k = 0; k < K; ++k) face[k] = elements.vertices[e][face_opposite<K>(i)[k]];
            rows.find(face,
                      [&](std::size_t row) { std::atomic_ref(is_face[row]).store(1, std::memory_order_relaxed); });
        }
    });
    if (!marked) return fail(std::move(marked.error()));
    if (std::find(is_face.begin(), is_face.end(), 0) == is_face.end()) return boundary;
    Buffer<SimplexVertices<K - 1>> vertices;
    Buffer<Reference> references;
    for (std::size_t i = 0; i < boundary.size(); ++i)
        if (is_face[i] != 0) {
            vertices.push_back(boundary.vertices[i]);
            references.push_back(boundary.references[i]);
        }
    return Simplices<K - 1>{std::move(vertices), std::move(references), {}};
}

struct Renamed {
    Reference from, to;
    std::size_t count;
};

struct Referenced {
    const Column<Reference>& references;
    const Column<Group>& groups;
    int dimension;
};
template <int K>
Referenced referenced(const Simplices<K>& simplices, const Column<Group>& groups) {
    return {simplices.references, groups, K};
}

/// Finds references that are not positive (0, −1 …, in this order) and their replacements, which no simplex and no
/// group has.
std::vector<Renamed> renamed(const Referenced& input) {
    std::map<Reference, std::size_t, std::greater<>> counts;
    for (const Reference r : input.references)
        if (r <= 0) ++counts[r];
    if (counts.empty()) return {};
    std::vector<Reference> used;
    for (const Reference r : input.references)
        if (r > 0) used.push_back(r);
    for (const Group& group : input.groups)
        if (group.dimension == input.dimension) used.push_back(group.reference);
    std::sort(used.begin(), used.end());
    std::vector<Renamed> result;
    Reference next = 1;
    auto at = used.begin();
    for (const auto& [from, count] : counts) {
        for (; at != used.end() && *at <= next; ++at)
            if (*at == next) ++next;
        result.push_back({from, next++, count});
    }
    return result;
}

class Attributes {
  public:
    explicit Attributes(const Referenced& input) : renamed_(renamed(input)) {}
    [[nodiscard]] Reference of(Reference reference) const { return *find(reference); }
    [[nodiscard]] std::optional<Reference> find(Reference reference) const {
        if (reference > 0) return reference;
        const auto found = std::lower_bound(renamed_.begin(), renamed_.end(), reference,
                                            [](const Renamed& r, Reference value) { return r.from > value; });
        if (found == renamed_.end() || found->from != reference) return std::nullopt;
        return found->to;
    }

  private:
    std::vector<Renamed> renamed_;
};

struct AttributeSet {
    std::string name;
    std::vector<Reference> attributes;
};

Column<Group> named(const Column<Group>& groups) { return with_legal_names(groups, {.legal = quotable_name}); }

std::vector<AttributeSet> sets_of(const Referenced& input) {
    const Attributes attributes(input);
    std::vector<AttributeSet> sets;
    for (const Group& group : named(input.groups)) {
        const auto attribute = group.dimension == input.dimension ? attributes.find(group.reference) : std::nullopt;
        if (!attribute) continue;
        auto set = std::find_if(sets.begin(), sets.end(), [&](const AttributeSet& s) { return s.name == group.name; });
        if (set == sets.end()) set = sets.insert(sets.end(), {group.name, {}});
        set->attributes.push_back(*attribute);
    }
    return sets;
}

void note_renamed(const Referenced& input, const std::string& what, std::vector<Notice>& notices) {
    const std::vector<Renamed> changes = renamed(input);
    if (changes.empty()) return;
    std::string text = "MFEM's attributes are positive: of the " + what + " reference ";
    constexpr std::size_t most = 5;
    for (std::size_t i = 0; i < changes.size() && i < most; ++i)
        text += (i == 0 ? "" : ", ") + std::to_string(changes[i].from) + " becomes " + std::to_string(changes[i].to) +
                " (" + std::to_string(changes[i].count) + ")";
    if (changes.size() > most) text += ", and " + std::to_string(changes.size() - most) + " others";
    notices.push_back({text});
}

template <int K, class Mesh>
Buffer<std::uint32_t> edges_in_order(const Grid<Mesh>& grid, const Simplices<K>& elements) {
    const std::size_t vertices = grid.vertices();
    Buffer<std::uint32_t> order;
    Buffer<std::uint8_t> visited(grid.nodes() - vertices, 0);
    for (std::size_t i = 0; i < elements.size(); ++i)
        for (const int k : edge_order<K>) {
            const std::size_t edge = grid.template node<K>(elements, i, K + 1 + static_cast<std::size_t>(k)) - vertices;
            if (visited[edge] != 0) continue;
            visited[edge] = 1;
            order.push_back(static_cast<std::uint32_t>(edge));
        }
    return order;
}

template <int K>
void note_names(const Column<Group>& groups, const Simplices<K>& elements, const Simplices<K - 1>& boundary,
                std::vector<Notice>& notices) {
    std::size_t preserved = 0;
    for (const AttributeSet& set : sets_of(referenced(elements, groups))) preserved += set.attributes.size();
    for (const AttributeSet& set : sets_of(referenced(boundary, groups))) preserved += set.attributes.size();
    if (const std::size_t lost = groups.size() - preserved; lost > 0)
        notices.push_back({"MFEM has no place for " + std::to_string(lost) + " names of references"});
    Buffer<Group> group_copies(groups.begin(), groups.end());
    std::erase_if(group_copies, [](const Group& group) { return group.dimension != K && group.dimension != K - 1; });
    const Column<Group> written(std::move(group_copies));
    for (Notice& notice : renamed_groups(written, named(written), "MFEM")) notices.push_back(std::move(notice));
}

template <int K>
void note_boundary(const Simplices<K>& elements, const Simplices<K - 1>& listed, const Column<Group>& groups,
                   std::vector<Notice>& notices) {
    if (listed.references.size() != listed.size()) return;  // inconsistent columns: the encoder reports this error
    const auto boundary = faces_of(elements, listed, {.threads = 1});
    if (!boundary) return;
    if (const std::size_t lost = listed.size() - boundary->size(); lost > 0)
        notices.push_back({"MFEM has no place for " + std::to_string(lost) + " facets that are not faces of elements"});
    note_renamed(referenced(*boundary, groups), "boundary", notices);
    note_names(groups, elements, *boundary, notices);
}

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;

    Writer(const Mesh& mesh, const Execution& execution)
        : grid_{mesh}, linear_(grid_.linear()), execution_(execution), text_(execution) {}

    Outcome<Chunks> write() && {
        if (!columns_fit(linear_) || !grid_.is_sound())
            return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths");
        if constexpr (D == 3)
            if (is_standalone_surface(linear_)) return std::move(*this).write(linear_.facets, linear_.edges);
        if (linear_.elements.size() == 0 && cells_of(linear_) > 0)
            return fail(ErrorKind::unsupported,
                        "has no elements, and MFEM does not support a boundary without "
                        "elements",
                        {}, {}, "write another format");
        return std::move(*this).write(linear_.elements, linear_.facets);
    }

  private:
    template <int K>
    Outcome<Chunks> write(const Simplices<K>& elements, const Simplices<K - 1>& listed) && {
        const auto boundary = faces_of(elements, listed, execution_);
        if (!boundary) return fail(boundary.error());
        const auto of_elements = sets_of(referenced(elements, linear_.groups)),
                   of_boundary = sets_of(referenced(*boundary, linear_.groups));
        const bool named = !of_elements.empty() || !of_boundary.empty();
        text_.put(std::string(named ? first_line_of_names : first_line) + "\n\ndimension\n" + std::to_string(K) + "\n");
        auto written = simplices("elements", elements);
        if (named) put_sets("attribute_sets", of_elements);
        if (written) written = simplices("boundary", *boundary);
        if (named) put_sets("bdr_attribute_sets", of_boundary);
        if (written) written = points(elements);
        if (!written) return fail(std::move(written.error()));
        if (named) text_.put("\nmfem_mesh_end\n");
        return std::move(text_).finish();
    }

    void put_sets(const std::string& title, const std::vector<AttributeSet>& sets) {
        std::string text = "\n" + title + "\n" + std::to_string(sets.size()) + "\n";
        for (const AttributeSet& set : sets) {
            text += "\"" + set.name + "\" " + std::to_string(set.attributes.size());
            for (const Reference attribute : set.attributes) text += " " + std::to_string(attribute);
            text += "\n";
        }
        text_.put(text);
    }

    template <int K>
    Outcome<Done> simplices(const std::string& title, const Simplices<K>& rows) {
        const Attributes attributes(referenced(rows, linear_.groups));
        text_.put("\n" + title + "\n" + std::to_string(rows.size()) + "\n");
        return text_.lines(rows.size(), K + 3, [&](std::size_t i, char* to) {
            to = write_word(to, attributes.of(rows.references[i]), ' ');
            to = write_word(to, geometry<K>, ' ');
            for (const VertexId v : rows.vertices[i]) to = write_word(to, v.index(), ' ');
            to[-1] = '\n';
            return to;
        });
    }

    template <int K>
    Outcome<Done> points(const Simplices<K>& elements) {
        text_.put("\nvertices\n" + std::to_string(linear_.points.size()) + "\n");
        if constexpr (Grid<Mesh>::degree == 1) {
            text_.put(std::to_string(D) + "\n");
            return text_.lines(linear_.points.size(), D, [&](std::size_t v, char* to) { return coordinates(v, to); });
        } else {
            const Buffer<std::uint32_t> edges = edges_in_order(grid_, elements);
            text_.put("\nnodes\nFiniteElementSpace\nFiniteElementCollection: H1_" + std::to_string(K) +
                      "D_P2\nVDim: " + std::to_string(D) + "\nOrdering: 1\n\n");
            const std::size_t vertices = grid_.vertices();
            return text_.lines(vertices + edges.size(), D, [&](std::size_t n, char* to) {
                return coordinates(n < vertices ? n : vertices + edges[n - vertices], to);
            });
        }
    }

    char* coordinates(std::size_t node, char* to) const {
        for (int c = 0; c < D; ++c) to = write_word(to, grid_.point(node)[c], c + 1 == D ? '\n' : ' ');
        return to;
    }

    Grid<Mesh> grid_;
    const LinearMesh<D>& linear_;
    const Execution& execution_;
    TextWriter text_;
};

}  // namespace

}  // namespace mfem

template <int D>
Outcome<Chunks> encode_mfem(const Mesh<D>& mesh, const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return guarded([&] { return mfem::Writer(simplices, execution).write(); });
    });
}

template <int D>
std::vector<Notice> not_in_mfem(const Mesh<D>& all) {
    const LinearMesh<D> mesh = straight_simplices(all);
    const bool surface = is_standalone_surface(mesh);  // in MFEM a surface is a mesh of dimension 2
    auto notices =
        unsupported_data(mesh, {.groups = true, .feature_edges = surface, .point_references = false}, "MFEM");
    if constexpr (D == 3)
        if (surface) {
            mfem::note_renamed(mfem::referenced(mesh.facets, mesh.groups), "elements", notices);
            mfem::note_boundary(mesh.facets, mesh.edges, mesh.groups, notices);
            return notices;
        }
    mfem::note_renamed(mfem::referenced(mesh.elements, mesh.groups), "elements", notices);
    mfem::note_boundary(mesh.elements, mesh.facets, mesh.groups, notices);
    return notices;
}

#define CAMBER_INSTANTIATE(D)                                                  \
    template Outcome<Chunks> encode_mfem<D>(const Mesh<D>&, const Execution&); \
    template std::vector<Notice> not_in_mfem<D>(const Mesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>
export module camber.io:mfem;
import camber.core;
import :listing;
import :meshes;
import :text;

export namespace camber {

/// Decodes "MFEM mesh v1.0", v1.2 or v1.3; in v1.3, named sets of attributes become names of references.
/// - Elements are triangles (in 2D, or a surface in space) or tetrahedra, with their boundary.
/// - The degree is 1, or 2 if `nodes` are an H1 field of order 2.
/// - Attributes become references; vertices have reference 0.
///
/// Further errors: unsupported (nodes in another finite element space).
[[nodiscard]] Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name,
                                               const DecodeOptions& options, const Execution& execution);
[[nodiscard]] inline Outcome<DecodedMesh> decode_mfem(std::span<const std::byte> bytes, std::string_view name,
                                                      const Execution& execution) {
    return decode_mfem(bytes, name, {}, execution);
}

[[nodiscard]] bool is_mfem(std::span<const std::byte> bytes);

/// Encodes "MFEM mesh v1.0", or v1.3 if references of elements or boundary have names.
/// - Elements are the tetrahedra of the mesh; in 2D and for a surface its triangles.
/// - The boundary consists of the facets (for a surface: edges) that are faces of elements. MFEM allows no others.
/// - For degree 2, `nodes` are an H1 field of order 2: vertices first, then edges in the order in which elements list
///   them. Elements list their edges in MFEM's order of local edges.
/// - References that are not positive are replaced by the smallest positive numbers that are not in use.
///
/// Errors: unsupported (facets or edges without any element).
template <int D>
[[nodiscard]] Outcome<Chunks> encode_mfem(const Mesh<D>& mesh, const Execution& execution);

template <int D>
[[nodiscard]] std::vector<Notice> not_in_mfem(const Mesh<D>& mesh);

}  // namespace camber

namespace camber::mfem {

inline constexpr std::string_view first_line = "MFEM mesh v1.0", first_line_of_names = "MFEM mesh v1.3";

template <int K>
inline constexpr int geometry = K == 3 ? 4 : K;

/// MFEM's order of local edges, as indices in `local_edges`. The vertices of these edges are 01 02 03 12 13 23 in a
/// tetrahedron, and 01 12 20 in a triangle.
template <int K>
inline constexpr auto edge_order = [] {
    if constexpr (K == 3)
        return std::array{0, 2, 3, 1, 4, 5};
    else if constexpr (K == 2)
        return std::array{0, 1, 2};
    else
        return std::array{0};
}();

// Edge nodes of degree 2. MFEM numbers them in the order in which elements list them.

class EdgeNumbers {
  public:
    void add(VertexId a, VertexId b) { numbers_.try_emplace(key(a, b), static_cast<std::uint32_t>(numbers_.size())); }
    [[nodiscard]] std::optional<std::size_t> find(VertexId a, VertexId b) const {
        const auto found = numbers_.find(key(a, b));
        if (found == numbers_.end()) return std::nullopt;
        return found->second;
    }
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }

  private:
    static std::uint64_t key(VertexId a, VertexId b) {
        return std::uint64_t{std::min(a.value, b.value)} << 32U | std::max(a.value, b.value);
    }
    std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
};

template <int K>
[[nodiscard]] EdgeNumbers number_edges(const listing::Rows<K + 1>& elements) {
    EdgeNumbers numbers;
    for (const auto& element : elements.nodes)
        for (const int k : edge_order<K>) numbers.add(element[local_edges<K>[k][0]], element[local_edges<K>[k][1]]);
    return numbers;
}

/// Drops boundary simplices with an edge that belongs to no element, because such an edge has no node in the file.
/// Returns the number of dropped simplices.
template <int K>
std::size_t drop_isolated_boundary(listing::Rows<K + 1>& rows, const EdgeNumbers& numbers) {
    std::size_t preserved = 0;
    const std::size_t before = rows.size();
    for (std::size_t i = 0; i < before; ++i) {
        const auto& simplex = rows.nodes[i];
        const bool known = std::all_of(local_edges<K>.begin(), local_edges<K>.end(), [&](const auto& ends) {
            return numbers.find(simplex[ends[0]], simplex[ends[1]]).has_value();
        });
        if (!known) continue;
        rows.nodes[preserved] = simplex;
        rows.references[preserved++] = rows.references[i];
    }
    rows.nodes.resize(preserved);
    rows.references.resize(preserved);
    return before - preserved;
}

template <int K>
Outcome<Done> curve(listing::Simplices<K>& simplices, const EdgeNumbers& numbers, std::size_t vertices) {
    simplices.curved.references = std::move(simplices.straight.references);
    simplices.curved.origin = simplices.straight.origin;
    simplices.curved.nodes.resize(simplices.straight.size());
    for (std::size_t i = 0; i < simplices.straight.size(); ++i) {
        const auto& corners = simplices.straight.nodes[i];
        auto& nodes = simplices.curved.nodes[i];
        std::copy(corners.begin(), corners.end(), nodes.begin());
        for (std::size_t k = 0; k < edges_per_simplex<K>; ++k) {
            const auto number = numbers.find(corners[local_edges<K>[k][0]], corners[local_edges<K>[k][1]]);
            const auto& origin = simplices.curved.origin;
            if (!number)
                return fail(ErrorKind::input, "one of its edges belongs to no element", origin.place(i),
                            Entity{origin.noun, origin.number_of(i)}, "MFEM has no node for this edge. Remove it");
            nodes[K + 1 + k] = VertexId(vertices + *number);
        }
    }
    simplices.straight = {};
    return Done{};
}

// Reading of an MFEM file, word by word.

inline constexpr const char* damaged = "the file is cut off or damaged";

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

[[nodiscard]] inline std::string_view first_line_of(std::string_view text) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const std::size_t last = line.find_last_not_of(" \t\r");
    return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

struct Source {
    std::string name;
    std::string_view text;
    Words words;
    bool has_end = false;  ///< since version 1.2 the file must end with the line mfem_mesh_end

    [[nodiscard]] std::string place(const char* at) const { return line_place(name, text, at); }
    [[nodiscard]] auto fail_at_line(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] auto reject_at_line(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), place(words.at), {}, std::move(remedy));
    }
    [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(words.end - words.at); }

    [[nodiscard]] Outcome<Done> expect(std::string_view word) {
        if (words.next() == word) return Done{};
        return fail_at_line(in_quotes(word) + " is missing here",
                            "the sections of an MFEM file have a fixed order; " + std::string(damaged));
    }
    [[nodiscard]] Outcome<std::int64_t> number(const std::string& what) {
        std::int64_t value = 0;
        if (!read_number(words, value)) return fail_at_line("the number of " + what + " is missing or malformed");
        return value;
    }
    /// Reads a number of rows with at least `min_words` words, and checks that the file is large enough for them.
    [[nodiscard]] Outcome<std::size_t> count(const std::string& what, std::size_t min_words) {
        const auto value = number(what);
        if (!value) return fail(value.error());
        if (*value < 0 || static_cast<std::uint64_t>(*value) > left() / (2 * min_words) + 1)
            return fail_at_line("announces " + std::to_string(*value) + " " + what + ", but fewer follow");
        if (static_cast<std::uint64_t>(*value) > max_entities)
            return reject_at_line("has more " + what + " than 32 bits can number", "divide the mesh");
        return static_cast<std::size_t>(*value);
    }
};

struct Geometry {
    std::size_t vertices;
    const char* plural;
};
inline constexpr std::array<Geometry, 8> geometries{{{1, "points"},
                                                     {2, "segments"},
                                                     {3, "triangles"},
                                                     {4, "quadrilaterals"},
                                                     {4, "tetrahedra"},
                                                     {8, "hexahedra"},
                                                     {6, "prisms"},
                                                     {5, "pyramids"}}};

// Sections of an MFEM file, in their order.

/// Content of the sections before the vertices. All simplices have degree 1.
template <int K>
struct Topology {
    listing::Simplices<K> elements;
    listing::Simplices<K - 1> boundary;
    Buffer<Group> groups;
    UnsupportedItems refused;
};

template <int K>
[[nodiscard]] Outcome<Topology<K>> read_topology(Source& source);

struct NodeField {
    int order = 1, components = 0;
    bool by_components = false;  ///< MFEM's Ordering 0: the x of all nodes, then the y of all nodes
};

struct Vertices {
    std::size_t count = 0;
    NodeField field;
    bool has_nodes = false;
};

[[nodiscard]] Outcome<Vertices> read_vertices_head(Source& source);

template <int D>
[[nodiscard]] Outcome<Buffer<Vec<D>>> read_points(Source& source, std::size_t count, bool by_components);

}  // namespace camber::mfem

namespace camber::su2 {

inline constexpr const char* damaged = "the file is cut off or damaged";

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Iterates over lines that are not empty. Comments (from % on) and blanks at either end are removed.
class Lines {
  public:
    explicit Lines(std::string_view text) : rest_(text) {}

    std::optional<std::string_view> next() {
        while (!rest_.empty()) {
            const std::size_t end = rest_.find('\n');
            std::string_view line = rest_.substr(0, end);
            ended_ = end != std::string_view::npos;
            rest_.remove_prefix(ended_ ? end + 1 : rest_.size());
            line = line.substr(0, line.find('%'));
            while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
            while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
            if (!line.empty()) return line;
        }
        return std::nullopt;
    }
    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    [[nodiscard]] bool ended() const { return ended_; }

  private:
    std::string_view rest_;
    bool ended_ = true;
};

/// A line `KEY= value`. The key is empty for a row of numbers.
struct Entry {
    std::string_view key = {}, value = {};
};
[[nodiscard]] inline Entry entry_of(std::string_view line) {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return {};
    Words key{line.data(), line.data() + equals}, value{line.data() + equals + 1, line.data() + line.size()};
    const std::string_view name = key.next();
    if (name != "MARKER_TAG") return {name, value.next()};
    // The name of a marker may have any characters; it extends to the end of the line.
    std::string_view rest = line.substr(equals + 1);
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    return {name, rest};
}

struct Block {
    std::size_t count = 0;
    Lines rows{{}};
    std::string tag = {};
};

struct Zone {
    std::string name;
    std::string_view text;
    std::optional<std::int64_t> dimension = {}, markers_announced = {};
    std::optional<Block> elements = {}, points = {};
    std::vector<Block> markers = {};
    std::int64_t number = 1;
    std::size_t parallel_markers = 0, foreign_blocks = 0;
    std::string first_foreign = {};

    [[nodiscard]] bool empty() const { return !dimension && !elements && !points && markers.empty(); }
    [[nodiscard]] std::string place(std::string_view at) const { return line_place(name, text, at.data()); }
    [[nodiscard]] std::string end() const { return line_place(name, text, text.data() + text.size()); }
};

struct File {
    std::vector<Zone> zones;
    bool ended = true;
};

[[nodiscard]] Outcome<File> find_blocks(std::string_view text, std::string_view name);

}  // namespace camber::su2

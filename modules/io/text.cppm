module;
#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
/// Helpers that all formats share: words of text, memory limits, refused cells, tags, names, losses.
module camber.io:text;
import camber.core;
import :meshes;

/// Words and numbers of text files.
namespace camber {

[[nodiscard]] constexpr bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
[[nodiscard]] constexpr bool ends_word(char c) { return is_blank(c) || c == '#'; }

/// Walks the words of ASCII text between blanks and comments (`#` to the end of the line).
struct Words {
    const char* at;
    const char* end;

    /// Moves to the next word; false at the end.
    [[nodiscard]] inline bool find() {
        for (; at != end; ++at) {
            if (*at == '#') {
                while (at != end && *at != '\n' && *at != '\r') ++at;
                if (at == end) return false;
            } else if (!is_blank(*at)) {
                return true;
            }
        }
        return false;
    }
    inline void pass() {
        while (at != end && !ends_word(*at)) ++at;
    }
    /// The next word, or an empty one at the end.
    [[nodiscard]] inline std::string_view next() {
        if (!find()) return {};
        const char* const begin = at;
        pass();
        return {begin, static_cast<std::size_t>(at - begin)};
    }
    inline void skip(std::size_t words) {
        for (; words > 0 && find(); --words) pass();
    }
    [[nodiscard]] inline bool at_word_end() const { return at == end || ends_word(*at); }
};

/// `name: line N` of a place in a text.
[[nodiscard]] std::string line_place(std::string_view name, std::string_view text, const char* at);

/// Reads a number that the plain way cannot: a leading +, Fortran's exponent D, magnitudes beyond those of double.
[[nodiscard]] bool read_unusual_real(std::string_view word, double& value);

[[nodiscard]] inline bool read_number(Words& words, std::int64_t& value) {
    if (!words.find()) return false;
    if (*words.at == '+') ++words.at;
    const auto [stop, error] = std::from_chars(words.at, words.end, value);
    words.at = stop;
    return error == std::errc{} && words.at_word_end();
}

[[nodiscard]] inline bool read_number(Words& words, double& value) {
    if (!words.find()) return false;
    const char* const begin = words.at;
    const auto [stop, error] = std::from_chars(begin, words.end, value);
    words.at = stop;
    if (error == std::errc{} && words.at_word_end()) return true;
    words.at = begin;
    return read_unusual_real(words.next(), value);
}

/// What a file with compressed data may still be unpacked to, in bytes of memory. Deflate makes a thousand bytes out of
/// one where all are alike; meshes come to about seven (a grid of a box, as regular as they get, with types and
/// references that are all the same), so a hundred times the file is no mesh. Small files have 64 MiB: they cost nobody
/// anything.
class UnpackedBudget {
  public:
    explicit constexpr UnpackedBudget(std::size_t file_bytes) : left_(most(file_bytes)) {}

    /// So many numbers of so many bytes each; false: more than is left.
    [[nodiscard]] constexpr bool take(std::uint64_t count, std::uint64_t bytes_each = sizeof(double)) {
        if (bytes_each > 0 && count > left_ / bytes_each) return false;
        left_ -= count * bytes_each;
        return true;
    }

    [[nodiscard]] static constexpr std::uint64_t most(std::size_t file_bytes) {
        constexpr std::uint64_t ratio = 100, of_small_files = std::uint64_t{64} << 20U;
        return std::max(of_small_files, ratio * file_bytes);
    }

  private:
    std::uint64_t left_;
};

/// What is to be done about cells that are not held.
inline constexpr const char* simplices_remedy =
    "give a mesh of edges, triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and tells "
    "what splits them";

/// Counts what a file holds and Camber cannot, kind by kind in the order of their first mention.
class Refused {
  public:
    /// `kind`: in the plural.
    void count(const std::string& kind, std::size_t number = 1) {
        for (auto& [name, counted] : kinds_)
            if (name == kind) {
                counted += number;
                return;
            }
        if (kinds_.size() < max_kinds)
            kinds_.push_back({kind, number});
        else
            others_ += number;
    }

    [[nodiscard]] bool any() const { return !kinds_.empty(); }
    /// All of them, by kind.
    [[nodiscard]] std::vector<CellCount> counts() const {
        std::vector<CellCount> counts(kinds_);
        if (others_ > 0) counts.push_back({"of other kinds", others_});
        return counts;
    }

    /// Nothing where they are only counted; else an error of kind unsupported that names them all, if there are any.
    [[nodiscard]] Outcome<Done> verdict(std::string where, Unheld unheld) const {
        return unheld == Unheld::count ? Outcome<Done>(Done{}) : verdict(std::move(where));
    }
    /// An error of kind unsupported that names them all, if there are any.
    [[nodiscard]] Outcome<Done> verdict(std::string where) const {
        if (kinds_.empty()) return Done{};
        std::string text;
        constexpr std::size_t most = 12;
        for (std::size_t i = 0; i < kinds_.size() && i < most; ++i)
            text += (text.empty() ? "" : ", ") + std::to_string(kinds_[i].count) + " " + kinds_[i].kind;
        if (kinds_.size() > most || others_ > 0) text += " and more";
        return fail(ErrorKind::unsupported, "holds " + text + ", which Camber cannot hold", std::move(where), {},
                    simplices_remedy);
    }

  private:
    /// A damaged file may have any number of kinds.
    static constexpr std::size_t max_kinds = 64;
    std::size_t others_ = 0;
    std::vector<CellCount> kinds_;
};

/// The first of the rows at fault, whatever thread finds it.
class FirstFault {
  public:
    void note(std::size_t row) {
        std::size_t seen = row_.load(std::memory_order_relaxed);
        while (row < seen && !row_.compare_exchange_weak(seen, row, std::memory_order_relaxed)) {
        }
    }
    [[nodiscard]] bool any() const { return row() != std::numeric_limits<std::size_t>::max(); }
    [[nodiscard]] std::size_t row() const { return row_.load(std::memory_order_relaxed); }

  private:
    std::atomic<std::size_t> row_{std::numeric_limits<std::size_t>::max()};
};

inline constexpr std::uint32_t no_row = std::numeric_limits<std::uint32_t>::max();

/// The rows in the order of their tags, those of one tag in the order they have; none at all where they are in it. At
/// most `max_entities` of them. Takes no memory for tags that do not occur.
[[nodiscard]] Buffer<std::uint32_t> rows_by_tag(std::span<const std::uint64_t> tags);

/// Finds rows by tags, whatever these are: next to each other, with gaps, or scattered.
class TagIndex {
  public:
    TagIndex() = default;
    /// Of ascending tags, which must outlive it; row i is `rows[i]`, or i where there are no rows.
    TagIndex(std::span<const std::uint64_t> ascending, Buffer<std::uint32_t> rows);

    /// The row, or `no_row`.
    [[nodiscard]] std::uint32_t find(std::uint64_t tag) const {
        if (tags_.empty() || tag < tags_.front() || tag > tags_.back()) return no_row;
        const std::size_t offset = tag - tags_.front();
        if (contiguous_) return row(offset);
        return table_.empty() ? search(tag) : table_[offset];
    }

  private:
    [[nodiscard]] std::uint32_t row(std::size_t i) const {
        return rows_.empty() ? static_cast<std::uint32_t>(i) : rows_[i];
    }
    [[nodiscard]] std::uint32_t search(std::uint64_t tag) const;

    std::span<const std::uint64_t> tags_;
    Buffer<std::uint32_t> rows_;
    bool contiguous_ = false;
    Buffer<std::uint32_t> table_;  ///< by tags from the first; where most of them occur
};

/// What a format has a place for, of what meshes have beside nodes, simplices and references.
struct Holds {
    bool groups = false;        ///< names of references
    bool entities = false;      ///< the entities that simplices lie on
    bool associations = false;  ///< the entities that vertices lie on, and where
    bool corners = false, ridges = false, required = false;
    bool directions = false;    ///< normals and tangents
    bool feature_edges = true;  ///< simplices of dimension 1 in a 3D mesh
    bool point_references = true;
};

/// A sentence for each kind of things that the mesh has and the format of that name does not hold, with their number.
template <int D>
[[nodiscard]] std::vector<Notice> not_held(const LinearMesh<D>& mesh, Holds holds, std::string_view format);

/// For formats with one name a reference: the simplices that are in further groups, by these.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_further_groups(const LinearMesh<D>& mesh, std::string_view format);

/// Whether fields have a row for each node, or cell, of the mesh that they are written with. Errors: usage.
template <int D>
[[nodiscard]] Outcome<Done> check_rows(const MeshFields& fields, std::size_t nodes, std::size_t cells) {
    for (const MeshField& field : fields) {
        const bool is_of_nodes = field.centring == Centring::node;
        const std::size_t rows = is_of_nodes ? nodes : cells;
        if (field.size() != rows * static_cast<std::size_t>(values_per_vertex(field.kind, D)))
            return fail(ErrorKind::usage, "the field " + in_quotes(field.name) +
                                              " does not have one row for each of the " + std::to_string(rows) +
                                              (is_of_nodes ? " nodes" : " cells") + " of the mesh");
    }
    return Done{};
}

// Names of fields and groups as formats have them: legal, and each one's own.

/// What a format requires of names.
struct NameRule {
    std::string (*legal)(std::string_view name);  ///< the nearest name of letters that the format has
    std::size_t longest = std::string::npos;      ///< in bytes
    std::vector<std::string> reserved = {};       ///< names of what is no field or group
    std::string_view unnamed = "unnamed";         ///< the name of what has none
};

/// A name, and the endings with which the file lists it: of a vector by its components several.
struct ListedName {
    std::string name;
    std::vector<std::string> endings{{}};
};

/// A name for each, as the rule has it, so that nothing is listed twice. Names that the rule has stay, the first of
/// equal ones; the others lose what is not legal, and end in _2, _3 and so on where another has their name.
[[nodiscard]] std::vector<std::string> legal_names(std::span<const ListedName> names, const NameRule& rule);

/// The name with `_` for control characters and for bytes that are no UTF-8.
[[nodiscard]] std::string readable_name(std::string_view name);
/// The name on one line, with ' for ".
[[nodiscard]] std::string quotable_name(std::string_view name);

/// The rules of a format for its fields.
struct FieldNames {
    NameRule at_nodes, at_cells;
    std::vector<std::string> (*endings)(FieldKind kind) = nullptr;  ///< none: each field is listed once
};
/// The fields with their names in the format.
[[nodiscard]] MeshFields with_legal_names(const MeshFields& fields, const FieldNames& rules);
/// A notice of the names that become others.
[[nodiscard]] std::vector<Notice> renamed_fields(const MeshFields& fields, const FieldNames& rules,
                                                 std::string_view format);

/// The groups with their names in the format: names that differ within a dimension stay different.
[[nodiscard]] Column<Group> with_legal_names(const Column<Group>& groups, const NameRule& rule);

/// An old name and the new one; the same where it stays.
using Renaming = std::pair<std::string, std::string>;
/// A notice of those that change: "VTU has other names for 2 fields: …".
[[nodiscard]] std::vector<Notice> note_renamed(std::string_view format, std::string_view kind,
                                               const std::vector<Renaming>& names);
[[nodiscard]] std::vector<Notice> renamed_groups(const Column<Group>& groups, const Column<Group>& in_file,
                                                 std::string_view format);

}  // namespace camber

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
module camber.io:text;
import camber.core;
import :meshes;

namespace camber {

[[nodiscard]] constexpr bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
[[nodiscard]] constexpr bool ends_word(char c) { return is_blank(c) || c == '#'; }

/// Iterates over words of ASCII text. Words are separated by blanks and by comments (from # to the end of the line).
struct Words {
    const char* at;
    const char* end;

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

[[nodiscard]] std::string line_place(std::string_view name, std::string_view text, const char* at);

/// Reads numbers with a leading +, with Fortran's exponent D, or outside the range of double.
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

/// Limits uncompressed data to 100 times the file size, at least 64 MiB. Deflate reaches a ratio of 1000 on constant
/// data; meshes reach about 7 (regular grid, constant types and references).
class UnpackedBudget {
  public:
    explicit constexpr UnpackedBudget(std::size_t file_bytes) : left_(most(file_bytes)) {}

    /// Subtracts `count` items from the budget. Returns false if the rest is too small.
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

inline constexpr const char* simplices_remedy =
    "give a mesh of edges, triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names "
    "a program that splits them";

/// Numbers of unsupported items by kind, in the order in which the kinds first occur.
class UnsupportedItems {
  public:
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
    [[nodiscard]] std::vector<CellCount> counts() const {
        std::vector<CellCount> counts(kinds_);
        if (others_ > 0) counts.push_back({"of other kinds", others_});
        return counts;
    }

    /// Returns success if unsupported cells are only counted, else the result of verdict(where).
    [[nodiscard]] Outcome<Done> verdict(std::string where, UnsupportedCells unsupported_cells) const {
        return unsupported_cells == UnsupportedCells::count ? Outcome<Done>(Done{}) : verdict(std::move(where));
    }
    /// Returns an error of kind unsupported that lists all kinds, or success if there are none.
    [[nodiscard]] Outcome<Done> verdict(std::string where) const {
        if (kinds_.empty()) return Done{};
        std::string text;
        constexpr std::size_t most = 12;
        for (std::size_t i = 0; i < kinds_.size() && i < most; ++i)
            text += (text.empty() ? "" : ", ") + std::to_string(kinds_[i].count) + " " + kinds_[i].kind;
        if (kinds_.size() > most || others_ > 0) text += " and more";
        return fail(ErrorKind::unsupported, "holds " + text + ", which Camber does not support", std::move(where), {},
                    simplices_remedy);
    }

  private:
    static constexpr std::size_t max_kinds = 64;
    std::size_t others_ = 0;
    std::vector<CellCount> kinds_;
};

class FirstErrorRow {
  public:
    void note(std::size_t row) {
        std::size_t observed = row_.load(std::memory_order_relaxed);
        while (row < observed && !row_.compare_exchange_weak(observed, row, std::memory_order_relaxed)) {
        }
    }
    [[nodiscard]] bool any() const { return row() != std::numeric_limits<std::size_t>::max(); }
    [[nodiscard]] std::size_t row() const { return row_.load(std::memory_order_relaxed); }

  private:
    std::atomic<std::size_t> row_{std::numeric_limits<std::size_t>::max()};
};

inline constexpr std::uint32_t no_row = std::numeric_limits<std::uint32_t>::max();

/// Rows sorted by tag; rows with equal tags stay in order. Empty if the rows are already sorted. Precondition: at most
/// `max_entities` rows. The memory does not depend on the size of tags.
[[nodiscard]] Buffer<std::uint32_t> rows_by_tag(std::span<const std::uint64_t> tags);

class TagIndex {
  public:
    TagIndex() = default;
    /// `ascending`: tags, which must outlive the index. Tag `ascending[i]` has row `rows[i]`, or row i if `rows` is
    /// empty.
    TagIndex(std::span<const std::uint64_t> ascending, Buffer<std::uint32_t> rows);

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
    Buffer<std::uint32_t> table_;  ///< for tags with few gaps: `table_[tag − lowest tag]` is the row
};

/// Data besides nodes and simplices that a format can hold.
struct FormatCapabilities {
    bool groups = false;        ///< names of references
    bool entities = false;      ///< CAD entities of simplices
    bool associations = false;  ///< entities and parameters of vertices
    bool corners = false, ridges = false, required = false;
    bool directions = false;    ///< normals and tangents
    bool feature_edges = true;  ///< simplices of dimension 1 in a 3D mesh
    bool point_references = true;
};

template <int D>
[[nodiscard]] std::vector<Notice> unsupported_data(const LinearMesh<D>& mesh, FormatCapabilities capabilities,
                                                   std::string_view format);

/// Lists names that are lost in formats where a reference has only one name.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_further_groups(const LinearMesh<D>& mesh, std::string_view format);

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

// Legal and unique names of fields and groups in a format.

struct NameRule {
    std::string (*legal)(std::string_view name);  ///< returns the nearest legal name
    std::size_t longest = std::string::npos;
    std::vector<std::string> reserved = {};  ///< names that must not occur
    std::string_view unnamed = "unnamed";
};

/// A name and its endings. The file contains the name once with each ending, for example for each component.
struct ListedName {
    std::string name;
    std::vector<std::string> endings{{}};
};

/// Makes names legal and unique. A legal name stays, except if an earlier name is equal to it. Illegal characters are
/// replaced, and _2, _3 … is appended to a name that is already in use.
[[nodiscard]] std::vector<std::string> legal_names(std::span<const ListedName> names, const NameRule& rule);

/// Replaces control characters and invalid UTF-8 bytes by `_`.
[[nodiscard]] std::string readable_name(std::string_view name);
/// Returns the name on one line, with ' in place of ".
[[nodiscard]] std::string quotable_name(std::string_view name);

struct FieldNames {
    NameRule at_nodes, at_cells;
    std::vector<std::string> (*endings)(FieldKind kind) = nullptr;  ///< endings of the components' names; null: no
                                                                    ///< components
};
[[nodiscard]] MeshFields with_legal_names(const MeshFields& fields, const FieldNames& rules);
[[nodiscard]] std::vector<Notice> renamed_fields(const MeshFields& fields, const FieldNames& rules,
                                                 std::string_view format);

/// Makes names of groups legal. Different names of one dimension stay different.
[[nodiscard]] Column<Group> with_legal_names(const Column<Group>& groups, const NameRule& rule);

using Renaming = std::pair<std::string, std::string>;
/// Returns for example "VTU has other names for 2 fields: …".
[[nodiscard]] std::vector<Notice> note_renamed(std::string_view format, std::string_view kind,
                                               const std::vector<Renaming>& names);
[[nodiscard]] std::vector<Notice> renamed_groups(const Column<Group>& groups, const Column<Group>& in_file,
                                                 std::string_view format);

}  // namespace camber

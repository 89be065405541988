// Reads STL files; names of their solids.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace stl {

namespace {

constexpr const char* cut = "it seems to be cut off";

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::uint32_t number_at(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t number = 0;
    for (unsigned i = 0; i < 4; ++i) number |= static_cast<std::uint32_t>(bytes[at + i]) << (8U * i);
    return number;
}
std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

Entity triangle_of(std::size_t number) { return {"triangle", number}; }

auto not_finite(std::string place, Entity triangle) {
    return fail(ErrorKind::input, "a coordinate is infinite or not a number", std::move(place), triangle,
                "the program that wrote the file failed there. Write it again");
}

struct File {
    Triangles triangles = {};
    std::size_t left_out = 0;
    Buffer<Group> groups = {};
};

class Parser {
  public:
    Parser(std::string_view text, std::string_view name)
        : text_(text), name_(name), words_{text.data(), text.data() + text.size()} {}

    Outcome<File> read() && {
        Solids solids;
        while (words_.find()) {
            if (auto done = expect("solid"); !done) return fail(std::move(done.error()));
            const std::string name = rest_of_line();
            const std::size_t first = file_.triangles.size();
            for (word_ = next(); word_ == "facet"; word_ = next())
                if (auto done = facet(); !done) return fail(std::move(done.error()));
            if (word_ != "endsolid") return fail(unexpected("facet or endsolid"));
            rest_of_line();
            if (file_.triangles.size() == first) continue;
            const Reference reference = solids.of(name);
            for (std::size_t t = first; t < file_.triangles.size(); ++t) file_.triangles[t].reference = reference;
        }
        file_.groups = std::move(solids).groups();
        return std::move(file_);
    }

  private:
    std::string next() {
        static_cast<void>(words_.find());
        at_ = words_.at;
        return lower(words_.next());
    }
    std::string rest_of_line() {
        const char* const begin = words_.at;
        words_.at = std::find(words_.at, words_.end, '\n');
        std::string_view rest(begin, static_cast<std::size_t>(words_.at - begin));
        while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
        while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
        return std::string(rest);
    }
    [[nodiscard]] Entity entity() const { return triangle_of(file_.triangles.size() + file_.left_out + 1); }
    [[nodiscard]] std::string place() const { return line_place(name_, text_, at_); }

    [[nodiscard]] Error unexpected(const std::string& expected) const {
        if (word_.empty())
            return {ErrorKind::input, "the file ends where " + expected + " is expected", place(), {}, cut};
        return {ErrorKind::input,
                "has no " + expected + " where it is expected",
                place(),
                {},
                "the file is cut off or damaged"};
    }
    Outcome<Done> expect(std::string_view expected) {
        word_ = next();
        if (word_ != expected) return fail(unexpected(std::string(expected)));
        return Done{};
    }
    Outcome<Done> expect_all(std::initializer_list<std::string_view> expected) {
        for (const std::string_view word : expected)
            if (auto done = expect(word); !done) return done;
        return Done{};
    }

    /// Reads a facet. The words of the normal are skipped, because some programs write `nan`.
    Outcome<Done> facet() {
        if (auto done = expect("normal"); !done) return done;
        for (int c = 0; c < 3; ++c)
            if (word_ = next(); word_.empty()) return fail(unexpected("a number"));
        if (auto done = expect_all({"outer", "loop"}); !done) return done;
        Triangle triangle;
        for (Vec<3>& corner : triangle.corners)
            if (auto done = vertex(corner); !done) return done;
        if (word_ = next(); word_ == "vertex")
            return fail(ErrorKind::unsupported, "has more corners than three", place(), entity(),
                        "write it again with triangles only");
        if (word_ != "endloop") return fail(unexpected("endloop"));
        if (has_equal_corners(triangle))
            ++file_.left_out;
        else
            file_.triangles.push_back(triangle);
        return expect("endfacet");
    }
    Outcome<Done> vertex(Vec<3>& corner) {
        if (auto done = expect("vertex"); !done) return done;
        for (int c = 0; c < 3; ++c) {
            const bool more = words_.find();
            at_ = words_.at;
            double x = 0;
            if (!more || !read_number(words_, x))
                return fail(ErrorKind::input, more ? "a number is malformed" : "the file ends within a corner", place(),
                            entity(), more ? "the file is cut off or damaged" : cut);
            if (!std::isfinite(x)) return not_finite(place(), entity());
            corner[c] = x + 0.0;  // turns −0 into 0
        }
        return Done{};
    }

    std::string_view text_, name_;
    Words words_;
    File file_;
    const char* at_ = nullptr;
    std::string word_;
};

Outcome<File> read_binary(std::span<const std::byte> bytes, std::string_view name, const Execution& execution) {
    const auto at = [&](std::size_t byte) { return std::string(name) + ": byte " + std::to_string(byte); };
    const auto damage = [&](std::size_t byte, std::string what, const char* remedy) {
        return fail(ErrorKind::input, std::move(what), at(byte), {}, remedy);
    };
    constexpr std::size_t head = header_bytes + count_bytes;
    if (bytes.empty()) return damage(0, "the file is empty", "write it again");
    if (bytes.size() < head)
        return damage(bytes.size(), "the file ends within the 84 bytes of a binary STL header, and is not text", cut);
    const std::uint64_t count = number_at(bytes, header_bytes);
    if (bytes.size() != head + row_bytes * count)
        return damage(header_bytes,
                      "announces " + std::to_string(count) + " triangles of 50 bytes, but " +
                          std::to_string(bytes.size() - head) + " bytes follow",
                      "the file is cut off, or its count is wrong");
    if (count > max_entities)
        return fail(ErrorKind::unsupported, "has more triangles than 32 bits can number", at(header_bytes));
    File file{Triangles(static_cast<std::size_t>(count))};
    FirstErrorRow first;
    auto done = each(
        execution, file.triangles.size(),
        [&](std::size_t t) {
            const std::size_t row = head + row_bytes * t + 12;  // begin of the corners; the normal before them has 12
                                                                // bytes
            bool finite = true;
            file.triangles[t].reference = 1;
            for (std::size_t i = 0; i < 9; ++i) {
                const auto x = static_cast<double>(std::bit_cast<float>(number_at(bytes, row + 4 * i)));
                file.triangles[t].corners[i / 3][static_cast<int>(i % 3)] = x + 0.0;  // turns −0 into 0
                finite = finite && std::isfinite(x);
            }
            if (!finite) first.note(t);
        },
        4096);
    if (!done) return fail(std::move(done.error()));
    if (first.any()) return not_finite(at(head + row_bytes * first.row()), triangle_of(first.row() + 1));
    file.left_out = std::erase_if(file.triangles, has_equal_corners);
    return file;
}

/// True if there is a zero byte near the begin. Binary files whose header begins with `solid` have such bytes; text
/// files have none.
bool looks_binary(std::span<const std::byte> bytes) {
    const auto begin = bytes.first(std::min<std::size_t>(bytes.size(), 1024));
    return std::find(begin.begin(), begin.end(), std::byte{0}) != begin.end();
}

Outcome<DecodedMesh> read(std::span<const std::byte> bytes, std::string_view name, const Execution& execution) {
    const bool is_text = is_stl(bytes, StlEncoding::ascii) && !looks_binary(bytes);
    auto file = is_text ? Parser(text_of(bytes), name).read() : read_binary(bytes, name, execution);
    if (!file) return fail(std::move(file.error()));
    std::vector<Notice> notices;
    if (file->left_out > 0)
        notices.push_back({std::to_string(file->left_out) + " triangles with two corners at the same position were "
                                                            "left out"});
    listing::Mesh<3> mesh = welded(file->triangles);
    mesh.name = std::string(name);
    mesh.groups = std::move(file->groups);
    if (auto checked = listing::check(mesh, execution); !checked) return fail(std::move(checked.error()));
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
}

/// False if the first bytes are those of another binary format, or of a text format that may contain binary data.
bool may_be_header(std::span<const std::byte> bytes) {
    const std::string_view text = text_of(bytes.first(4));
    return std::string_view("$#<@\x89").find(text[0]) == std::string_view::npos &&
           text != std::string_view("\1\0\0\0", 4) && text != std::string_view("\0\0\0\1", 4);
}

}  // namespace

listing::Mesh<3> welded(const Triangles& triangles) {
    listing::Mesh<3> mesh;
    auto& rows = mesh.facets.straight;
    rows.origin.noun = "triangle";
    Buffer<std::size_t> ends;
    for (const Triangle& triangle : triangles) {
        std::array<VertexId, 3> nodes;
        for (std::size_t i = 0; i < 3; ++i) {
            nodes[i] = VertexId(mesh.points.size());
            mesh.points.push_back(triangle.corners[i]);
        }
        rows.nodes.push_back(nodes);
        rows.references.push_back(triangle.reference);
        ends.push_back(mesh.points.size());
    }
    mesh.point_references = Buffer<Reference>(mesh.points.size(), 0);
    listing::join_coincident(mesh, ends);
    return mesh;
}

namespace {

std::string solid_name(std::string_view text) {
    std::string name(text);
    for (char& c : name)
        if (is_blank(c) || c == 0) c = ' ';
    const std::size_t first = name.find_first_not_of(' ');
    if (first == std::string::npos) return {};
    return name.substr(first, name.find_last_not_of(' ') - first + 1);
}

std::string group_name(const Column<Group>& groups, Reference reference) {
    for (const Group& group : groups)
        if (group.dimension == 2 && group.reference == reference) return group.name;
    return {};
}

}  // namespace

std::map<Reference, std::string> solid_names(const Triangles& triangles, const Column<Group>& groups,
                                             std::vector<Renaming>& renamed) {
    std::map<Reference, std::string> names;
    for (const Triangle& triangle : triangles)
        if (!names.contains(triangle.reference))
            names[triangle.reference] = solid_name(group_name(groups, triangle.reference));
    NameRule rule{.legal = solid_name};
    std::vector<ListedName> expected;
    for (auto& [reference, name] : names) {
        const std::string group = group_name(groups, reference);
        if (!name.empty()) {
            expected.push_back({group});
            continue;
        }
        rule.reserved.push_back(name = "reference_" + std::to_string(reference));
        if (!group.empty()) renamed.emplace_back(group, name);
    }
    const auto legal = legal_names(expected, rule);
    std::size_t named = 0;
    for (auto& [reference, name] : names) {
        if (solid_name(group_name(groups, reference)).empty()) continue;
        name = legal[named];
        renamed.emplace_back(expected[named++].name, name);
    }
    return names;
}

}  // namespace stl

Outcome<DecodedMesh> decode_stl(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions&,
                                const Execution& execution) {
    return guarded([&] { return stl::read(bytes, name, execution); });
}

bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding) {
    constexpr std::size_t head = stl::header_bytes + stl::count_bytes;
    const bool is_binary =
        bytes.size() >= head && stl::may_be_header(bytes) &&
        bytes.size() == head + stl::row_bytes * std::uint64_t{stl::number_at(bytes, stl::header_bytes)};
    if (encoding == StlEncoding::binary || is_binary) return is_binary == (encoding == StlEncoding::binary);
    constexpr std::size_t soon = 256;  // number of bytes, because blanks may precede the first word
    std::string_view text = stl::text_of(bytes.first(std::min(bytes.size(), soon)));
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    return stl::lower(text.substr(0, 5)) == "solid" && (text.size() < 6 || is_blank(text[5]));
}

}  // namespace camber

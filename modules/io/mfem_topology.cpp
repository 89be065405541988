module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import :mfem_order;
import :mfem_sections;
import :mfem_source;

namespace camber::mfem {

namespace {

/// Where row i of rows that begin here stands: they are walked through, since their lengths differ.
auto place_of_rows(const Source& source) {
    return [source](std::size_t row) {
        Words words = source.words;
        for (; row > 0; --row) {
            std::int64_t attribute = 0, kind = 0;
            static_cast<void>(read_number(words, attribute) && read_number(words, kind));
            words.skip(geometries[static_cast<std::size_t>(kind) % geometries.size()].vertices);
        }
        static_cast<void>(words.find());
        return source.place(words.at);
    };
}

/// Rows `attribute geometry vertices…`; those that are no K-simplices are counted in `refused`.
template <int K>
Outcome<Done> read_rows(Source& source, const std::string& title, const std::string& noun, listing::Rows<K + 1>& rows,
                        Refused& refused) {
    if (auto begun = source.expect(title); !begun) return begun;
    const auto count = source.count(title == "boundary" ? "boundary elements" : "elements", 3);
    if (!count) return fail(count.error());
    rows.nodes.reserve(*count);
    rows.references.reserve(*count);
    rows.origin = {noun, {}, place_of_rows(source)};
    for (std::size_t i = 0; i < *count; ++i) {
        const auto bad_row = [&](const std::string& what) {
            return fail(ErrorKind::input, what, source.place(source.words.at), Entity{noun, i + 1}, damaged);
        };
        std::int64_t attribute = 0, kind = 0;
        if (!read_number(source.words, attribute) || !read_number(source.words, kind))
            return bad_row("a number is missing or malformed");
        if (!std::in_range<Reference>(attribute)) return bad_row("the attribute does not fit 32 bits");
        if (kind < 0 || static_cast<std::size_t>(kind) >= geometries.size())
            return bad_row("its geometry " + std::to_string(kind) + " is none of MFEM's");
        const Geometry& shape = geometries[static_cast<std::size_t>(kind)];
        std::array<std::int64_t, 8> vertices{};
        for (std::size_t n = 0; n < shape.vertices; ++n)
            if (!read_number(source.words, vertices[n])) return bad_row("a number is missing or malformed");
        if (kind != geometry<K>) {
            refused.count(shape.plural);
            continue;
        }
        std::array<VertexId, K + 1> simplex;
        for (std::size_t n = 0; n <= K; ++n)
            if (vertices[n] >= 0 && static_cast<std::uint64_t>(vertices[n]) <= max_entities)
                simplex[n] = VertexId(static_cast<std::size_t>(vertices[n]));
        rows.nodes.push_back(simplex);
        rows.references.push_back(static_cast<Reference>(attribute));
    }
    return Done{};
}

/// A name, which may be in quotes.
Outcome<std::string> read_name(Source& source) {
    Words& words = source.words;
    if (!words.find()) return source.fail_here("the name of a set is missing");
    if (*words.at != '"') return std::string(words.next());
    const std::string_view rest(words.at + 1, static_cast<std::size_t>(words.end - words.at) - 1);
    const std::size_t end = rest.find_first_of("\"\n");
    if (end == std::string_view::npos || rest[end] != '"')
        return source.fail_here("the name of a set does not end in its line");
    words.at += end + 2;
    return std::string(rest.substr(0, end));
}

/// Named sets of attributes, where there is a section of that title: groups of so many dimensions.
Outcome<Done> read_sets(Source& source, std::string_view title, int dimension, Buffer<Group>& groups) {
    Words ahead = source.words;
    if (ahead.next() != title) return Done{};
    source.words = ahead;
    const auto count = source.count("sets of attributes", 2);
    if (!count) return fail(count.error());
    for (std::size_t i = 0; i < *count; ++i) {
        const auto name = read_name(source);
        if (!name) return fail(name.error());
        const auto size = source.count("attributes of a set", 1);
        if (!size) return fail(size.error());
        for (std::size_t k = 0; k < *size; ++k) {
            const auto attribute = source.number("attributes");
            if (!attribute) return fail(attribute.error());
            if (!std::in_range<Reference>(*attribute)) return source.fail_here("an attribute does not fit 32 bits");
            groups.push_back({dimension, static_cast<Reference>(*attribute), *name});
        }
    }
    return Done{};
}

}  // namespace

template <int K>
Outcome<Topology<K>> read_topology(Source& source) {
    Topology<K> made;
    auto read =
        read_rows<K>(source, "elements", "element", made.elements.straight, made.refused)
            .and_then([&](Done) { return read_sets(source, "attribute_sets", K, made.groups); })
            .and_then([&](Done) {
                return read_rows<K - 1>(source, "boundary", "boundary element", made.boundary.straight, made.refused);
            })
            .and_then([&](Done) { return read_sets(source, "bdr_attribute_sets", K - 1, made.groups); });
    if (!read) return fail(std::move(read.error()));
    return made;
}

template Outcome<Topology<2>> read_topology<2>(Source&);
template Outcome<Topology<3>> read_topology<3>(Source&);

}  // namespace camber::mfem

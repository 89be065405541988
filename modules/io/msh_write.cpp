module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace msh {

namespace {

using Tag = std::uint64_t;

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;

    Writer(const Mesh& mesh, const MeshFields& fields, MshOptions options, const Execution& execution)
        : grid_{mesh},
          linear_(grid_.linear()),
          fields_(fields),
          options_(options),
          execution_(execution),
          sink_(options.encoding, execution) {}

    Outcome<Chunks> write() && {
        for (auto check : {&Writer::check_mesh, &Writer::check_fields})
            if (auto sound = (this->*check)(); !sound) return fail(std::move(sound.error()));
        numbers_ = numbers_of(linear_);
        count_elements();
        begin();
        const GroupTags groups(with_legal_names(linear_.groups, name_rule()), numbers_);
        put_names(groups, sink_);
        auto written = options_.version == MshVersion::v4 ? write_4(groups) : write_2(groups);
        for (const MeshField& field : fields_)
            if (written) written = write_field(field);
        if (!written) return fail(std::move(written.error()));
        return std::move(sink_).finish();
    }

  private:
    [[nodiscard]] Outcome<Done> check_mesh() const {
        bool sound = columns_fit(linear_) && grid_.is_sound();
        for (const Group& group : linear_.groups) sound = sound && group.dimension >= 0 && group.dimension <= 3;
        with_each_dimension(linear_, [&](auto, const auto& simplices) {
            sound = sound && (simplices.entities.empty() || simplices.entities.size() == simplices.size());
        });
        if (!sound) return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths");
        const std::size_t most = std::numeric_limits<std::int32_t>::max();
        if (options_.version == MshVersion::v2 && (grid_.nodes() > most || cells_of(linear_) + grid_.nodes() > most))
            return fail(ErrorKind::unsupported, "the mesh has more nodes or elements than MSH 2.2 can number", {}, {},
                        "write MSH 4.1 (--format msh)");
        return Done{};
    }
    [[nodiscard]] Outcome<Done> check_fields() const {
        const std::size_t most = std::numeric_limits<std::int32_t>::max();
        if (!fields_.empty() && (grid_.nodes() > most || cells_of(linear_) + grid_.nodes() > most))
            return fail(ErrorKind::unsupported, "the fields have more nodes or elements than MSH can number", {}, {},
                        "write a .vtu");
        return check_rows<D>(fields_, grid_.nodes(), cells_of(linear_));
    }

    void count_elements() {
        before_[1] = numbers_.points.size();
        before_[2] = before_[1] + numbers_.of_dimension[1].of.size();
        before_[3] = before_[2] + numbers_.of_dimension[2].of.size();
        before_[4] = before_[3] + numbers_.of_dimension[3].of.size();
    }

    void begin() {
        sink_.section("MeshFormat");
        sink_.text(std::string(options_.version == MshVersion::v4 ? "4.1 " : "2.2 ") + (sink_.binary() ? "1" : "0") +
                   " 8\n");
        if (sink_.binary()) sink_.line(std::int32_t{1});
        sink_.end_section("MeshFormat");
    }
    [[nodiscard]] std::array<double, 3> point(std::size_t n) const {
        std::array<double, 3> p{};
        for (int c = 0; c < D; ++c) p[static_cast<std::size_t>(c)] = grid_.point(n)[c];
        return p;
    }
    template <int K, class Integer>
    void put_nodes(const Simplices<K>& simplices, std::size_t s, Integer* to) const {
        constexpr std::size_t width = Grid<Mesh>::template width<K>;
        for (std::size_t i = 0; i < width; ++i)
            to[place_in_row<static_cast<int>(width)>(static_cast<int>(i))] =
                static_cast<Integer>(grid_.template node<K>(simplices, s, i) + 1);
    }

    // ---------------------------------------------------------------- version 2.2

    Outcome<Done> write_2(const GroupTags& groups) {
        sink_.text("$Nodes\n" + std::to_string(grid_.nodes()) + "\n");
        auto written = sink_.template rows<Row<std::int32_t, 1, 3>>(grid_.nodes(), [&](std::size_t n) {
            return Row<std::int32_t, 1, 3>{{static_cast<std::int32_t>(n + 1)}, point(n)};
        });
        if (!written) return written;
        sink_.end_section("Nodes");
        sink_.text("$Elements\n" + std::to_string(before_[4]) + "\n");
        written = elements_2<1>(
            15, main_tags(groups, numbers_, 0), 0, before_[0],
            [&](std::size_t i, std::int32_t* to) { *to = static_cast<std::int32_t>(numbers_.points[i] + 1); });
        with_each_dimension(linear_, [&](auto dimension, const auto& simplices) {
            constexpr int k = dimension();
            constexpr int width = static_cast<int>(Grid<Mesh>::template width<k>);
            if (written)
                written = elements_2<width>(simplex_type<k, width>, main_tags(groups, numbers_, k), k, before_[k],
                                            [&](std::size_t i, std::int32_t* to) { put_nodes<k>(simplices, i, to); });
        });
        sink_.end_section("Elements");
        return written;
    }
    /// Writes elements of one type. Text files have the type and number of tags in each line; binary files have them
    /// once, in a header.
    template <std::size_t Width>
    Outcome<Done> elements_2(std::int32_t type, const std::vector<Reference>& physicals, std::size_t dimension,
                             std::size_t before, const auto& put) {
        const Classes& classes = numbers_.of_dimension[dimension];
        const std::size_t n = classes.of.size();
        constexpr std::int32_t tags = 2;
        const auto fill = [&](auto row, std::size_t first, std::size_t i) {
            const Class& one = classes.list[classes.of[i]];
            row.integers[0] = static_cast<std::int32_t>(before + i + 1);
            row.integers[first] = physicals[classes.of[i]];
            row.integers[first + 1] = one.tag;
            put(i, row.integers.data() + first + 2);
            return row;
        };
        if (n == 0) return Done{};
        if (sink_.binary()) {
            sink_.line(type, static_cast<std::int32_t>(n), tags);
            using Packed = Row<std::int32_t, 3 + Width, 0>;
            return sink_.template rows<Packed>(n, [&](std::size_t i) { return fill(Packed{}, 1, i); });
        }
        using Line = Row<std::int32_t, 5 + Width, 0>;
        return sink_.template rows<Line>(n, [&](std::size_t i) {
            Line line;
            line.integers[1] = type;
            line.integers[2] = tags;
            return fill(line, 3, i);
        });
    }

    // ---------------------------------------------------------------- version 4.1

    Outcome<Done> write_4(const GroupTags& groups) {
        auto layout = layout_of(grid_, numbers_, groups, execution_);
        if (!layout) return fail(std::move(layout.error()));
        put_entities(*layout, sink_);
        return nodes_4(*layout).and_then([&](Done) { return elements_4(*layout); });
    }
    Outcome<Done> nodes_4(const Layout& layout) {
        const std::vector<std::size_t>& starts = layout.nodes.starts;
        Tag blocks = 0;
        for (std::size_t g = 0; g + 1 < starts.size(); ++g)
            if (starts[g] < starts[g + 1]) ++blocks;
        sink_.section("Nodes");
        sink_.line(blocks, Tag{grid_.nodes()}, Tag{grid_.nodes() > 0 ? 1U : 0U}, Tag{grid_.nodes()});
        for (std::size_t g = 0; g + 1 < starts.size(); ++g) {
            const std::size_t n = starts[g + 1] - starts[g];
            if (n == 0) continue;
            const FileEntity& entity = layout.entities[g / 2];
            const std::uint32_t* const nodes = layout.nodes.items.data() + starts[g];
            sink_.line(std::int32_t{entity.dimension}, entity.tag, static_cast<std::int32_t>(g % 2), Tag{n});
            auto written = sink_.template rows<Row<Tag, 1, 0>>(
                n, [&](std::size_t i) { return Row<Tag, 1, 0>{{Tag{nodes[i]} + 1}, {}}; });
            if (written) written = places_4(g % 2 == 0 ? 0 : entity.dimension, nodes, n);
            if (!written) return written;
        }
        sink_.end_section("Nodes");
        return Done{};
    }
    Outcome<Done> places_4(int parameters, const std::uint32_t* nodes, std::size_t n) {
        const auto& geometry = linear_.geometry;
        if (parameters == 0)
            return sink_.template rows<Row<Tag, 0, 3>>(
                n, [&](std::size_t i) { return Row<Tag, 0, 3>{{}, point(nodes[i])}; });
        const auto with = [&]<std::size_t width>(std::integral_constant<std::size_t, width>, const auto& associations) {
            return sink_.template rows<Row<Tag, 0, 3 + width>>(n, [&](std::size_t i) {
                Row<Tag, 0, 3 + width> row;
                const auto place = point(nodes[i]);
                for (std::size_t c = 0; c < 3; ++c) row.reals[c] = place[c];
                const auto& input = *associations[numbers_.places[nodes[i]].row].parameters;
                for (std::size_t c = 0; c < width; ++c) row.reals[3 + c] = input[c];
                return row;
            });
        };
        if (parameters == 1) return with(std::integral_constant<std::size_t, 1>{}, geometry.on_curves);
        return with(std::integral_constant<std::size_t, 2>{}, geometry.on_surfaces);
    }

    Outcome<Done> elements_4(const Layout& layout) {
        std::array<Grouped, 4> groups;
        Tag blocks = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const auto& of = numbers_.of_dimension[k].of;
            const auto& entity_of = layout.entity_of_class[k];
            groups[k] = grouped(of.size(), layout.entities.size(), [&](std::size_t i) { return entity_of[of[i]]; });
            for (std::size_t e = 0; e < layout.entities.size(); ++e)
                if (groups[k].starts[e] < groups[k].starts[e + 1]) ++blocks;
        }
        sink_.section("Elements");
        sink_.line(blocks, Tag{before_[4]}, Tag{before_[4] > 0 ? 1U : 0U}, Tag{before_[4]});
        auto written = blocks_4<1>(layout, groups[0], 15, before_[0],
                                   [&](std::size_t i, Tag* to) { *to = Tag{numbers_.points[i]} + 1; });
        with_each_dimension(linear_, [&](auto dimension, const auto& simplices) {
            constexpr int k = dimension();
            constexpr int width = static_cast<int>(Grid<Mesh>::template width<k>);
            if (written)
                written = blocks_4<width>(layout, groups[k], simplex_type<k, width>, before_[k],
                                          [&](std::size_t i, Tag* to) { put_nodes<k>(simplices, i, to); });
        });
        sink_.end_section("Elements");
        return written;
    }
    template <std::size_t Width>
    Outcome<Done> blocks_4(const Layout& layout, const Grouped& group, std::int32_t type, std::size_t before,
                           const auto& put) {
        using Line = Row<Tag, 1 + Width, 0>;
        for (std::size_t e = 0; e < layout.entities.size(); ++e) {
            const std::size_t n = group.starts[e + 1] - group.starts[e];
            if (n == 0) continue;
            const std::uint32_t* const items = group.items.data() + group.starts[e];
            sink_.line(std::int32_t{layout.entities[e].dimension}, layout.entities[e].tag, type, Tag{n});
            auto written = sink_.template rows<Line>(n, [&](std::size_t i) {
                Line line;
                line.integers[0] = Tag{before + items[i] + 1};
                put(items[i], line.integers.data() + 1);
                return line;
            });
            if (!written) return written;
        }
        return Done{};
    }

    // ---------------------------------------------------------------- fields

    /// Returns the number in the mesh of the cell that is row i of a field in the file. The file has cells in the order
    /// edges, facets, elements; the mesh has the opposite order.
    [[nodiscard]] std::size_t cell_in_file(std::size_t i) const {
        const std::size_t elements = linear_.elements.size(), facets = linear_.facets.size();
        const std::size_t edges = linear_.edges.size();
        if (i < edges) return elements + facets + i;
        if (i < edges + facets) return elements + i - edges;
        return i - edges - facets;
    }

    Outcome<Done> write_field(const MeshField& field) {
        switch (field.kind) {
            case FieldKind::scalar: return write_field<1>(field, {0});
            case FieldKind::vector: return write_field<3>(field, D == 2 ? std::array{0, 1, -1} : std::array{0, 1, 2});
            case FieldKind::symmetric_tensor:
                return write_field<9>(
                    field, D == 2 ? std::array{0, 1, -1, 1, 2, -1, -1, -1, -1} : std::array{0, 1, 3, 1, 2, 4, 3, 4, 5});
            case FieldKind::full_tensor:
                return write_field<9>(
                    field, D == 2 ? std::array{0, 1, -1, 2, 3, -1, -1, -1, -1} : std::array{0, 1, 2, 3, 4, 5, 6, 7, 8});
        }
        return Done{};
    }
    template <std::size_t Components>
    Outcome<Done> write_field(const MeshField& field, std::array<int, Components> sources) {
        const bool of_nodes = field.centring == Centring::node;
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        const std::size_t n = of_nodes ? grid_.nodes() : cells_of(linear_);
        const std::string section = of_nodes ? "NodeData" : "ElementData";
        sink_.section(section);
        sink_.text("1\n" + quoted(field.name) + "\n1\n0\n3\n0\n" + std::to_string(Components) + "\n" +
                   std::to_string(n) + "\n");
        const std::size_t before = of_nodes ? 0 : before_[1];  // number of elements in the file before the first one
                                                               // with a value: point elements have no values
        using Line = Row<std::int32_t, 1, Components>;
        auto written = std::visit(
            [&](const auto& values) {
                return sink_.template rows<Line>(n, [&](std::size_t i) {
                    const std::size_t row = of_nodes ? i : cell_in_file(i);
                    Line line{{static_cast<std::int32_t>(before + i + 1)}, {}};
                    for (std::size_t c = 0; c < Components; ++c)
                        if (sources[c] >= 0)
                            line.reals[c] =
                                static_cast<double>(values[row * width + static_cast<std::size_t>(sources[c])]);
                    return line;
                });
            },
            field.values);
        sink_.end_section(section);
        return written;
    }

    Grid<Mesh> grid_;
    const LinearMesh<D>& linear_;
    const MeshFields& fields_;
    MshOptions options_;
    const Execution& execution_;
    Sink sink_;
    Numbers numbers_;
    std::array<std::size_t, 5> before_{};  ///< for each dimension, the number of file elements of lower dimension; last
                                           ///< entry: number of all file elements
};

}  // namespace

}  // namespace msh

template <int D>
Outcome<Chunks> encode_msh(const Mesh<D>& mesh, const MeshFields& fields, MshOptions options,
                           const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return guarded([&] {
            return msh::Writer(simplices, with_legal_names(fields, msh::field_names()), options, execution).write();
        });
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Chunks> encode_msh<D>(const Mesh<D>&, const MeshFields&, MshOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace xdmf {

namespace {

template <int K>
constexpr std::size_t mixed_type = K == 1   ? 2
                                   : K == 2 ? 4
                                            : 6;
template <int K>
constexpr std::size_t head_words = K == 1 ? 2 : 1;

template <int K>
constexpr std::string_view curved_type = K == 1   ? "Edge_3"
                                         : K == 2 ? "Triangle_6"
                                                  : "Tetrahedron_10";

std::vector<int> sources_of(FieldKind kind, int dimension) {
    if (kind != FieldKind::symmetric_tensor) return vtu::components_of(kind, dimension).sources;
    if (dimension == 2) return {0, 1, -1, 1, 2, -1, -1, -1, -1};
    return {0, 1, 3, 1, 2, 4, 3, 4, 5};
}

std::string_view attribute_type(std::size_t components) {
    return components == 1 ? "Scalar" : components == 3 ? "Vector" : "Tensor";
}

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;
    using G = Grid<Mesh>;

    Writer(const Mesh& mesh, const MeshFields& fields, const Execution& execution)
        : grid_{mesh}, linear_(grid_.linear()), fields_(fields), text_(execution) {}

    Outcome<Chunks> write() && {
        if (!columns_fit(linear_) || !grid_.is_sound())
            return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths");
        if (auto fits = check_rows<D>(fields_, grid_.nodes(), rows(Centring::cell)); !fits)
            return fail(std::move(fits.error()));
        text_.put("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"mesh\">\n");
        auto done = points().and_then([&](Done) { return topology(); });
        if (done)
            done = attribute<std::int32_t>("reference", Centring::node, grid_.nodes(), 1,
                                           [&](std::size_t n, std::size_t) { return grid_.reference(n); });
        if (done)
            done = attribute<std::int32_t>("reference", Centring::cell, cells(), 1, [&](std::size_t c, std::size_t) {
                return at_cell(linear_, c,
                               [](const auto& simplices, std::size_t s) { return simplices.references[s]; });
            });
        for (const MeshField& field : fields_)
            if (done) done = std::visit([&](const auto& values) { return put(field, values); }, field.values);
        if (!done) return fail(std::move(done.error()));
        text_.put("</Grid>\n</Domain>\n</Xdmf>\n");
        return std::move(text_).finish();
    }

  private:
    [[nodiscard]] std::size_t rows(Centring centring) const {
        return centring == Centring::node ? grid_.nodes() : cells_of(linear_);
    }
    [[nodiscard]] bool has_elements() const { return linear_.elements.size() > 0; }
    [[nodiscard]] std::size_t cells() const {
        if constexpr (G::degree == 1)
            return cells_of(linear_);
        else
            return has_elements() ? linear_.elements.size() : linear_.facets.size();
    }

    template <class T>
    static std::string item(std::size_t n, std::size_t width) {
        const bool real = std::is_floating_point_v<T>;
        return std::string("<DataItem DataType=\"") + (real ? "Float" : "Int") + "\" Dimensions=\"" +
               std::to_string(n) + (width > 1 ? " " + std::to_string(width) : std::string()) +
               "\" Format=\"XML\" Precision=\"" + std::to_string(sizeof(T)) + "\">\n";
    }
    template <class T, class Value>
    Outcome<Done> table(std::size_t n, std::size_t width, const Value& value) {
        return text_.lines(n, width, [&](std::size_t i, char* to) {
            for (std::size_t k = 0; k < width; ++k)
                to = write_word(to, static_cast<T>(value(i, k)), k + 1 == width ? '\n' : ' ');
            return to;
        });
    }
    template <class T, class Value>
    Outcome<Done> data_item(std::size_t n, std::size_t width, const Value& value) {
        text_.put(item<T>(n, width));
        return table<T>(n, width, value).map([&](Done done) {
            text_.put("</DataItem>\n");
            return done;
        });
    }

    Outcome<Done> points() {
        text_.put("<Geometry GeometryType=\"XYZ\">\n");
        return data_item<double>(
                   grid_.nodes(), 3,
                   [&](std::size_t n, std::size_t c) { return c < D ? grid_.point(n)[static_cast<int>(c)] : 0.0; })
            .map([&](Done done) {
                text_.put("</Geometry>\n");
                return done;
            });
    }

    template <int K>
    Outcome<Done> mixed(const Simplices<K>& simplices) {
        constexpr std::size_t head = head_words<K>;
        return table<std::int64_t>(simplices.size(), head + K + 1, [&](std::size_t s, std::size_t k) {
            if (k == 0) return mixed_type<K>;
            return k < head ? std::size_t{K + 1} : grid_.template node<K>(simplices, s, k - head);
        });
    }
    template <int K>
    Outcome<Done> alone(const Simplices<K>& simplices) {
        text_.put("<Topology TopologyType=\"" + std::string(curved_type<K>) + "\" NumberOfElements=\"" +
                  std::to_string(simplices.size()) + "\">\n");
        return data_item<std::int64_t>(simplices.size(), G::template width<K>, [&](std::size_t s, std::size_t k) {
            return grid_.template node<K>(simplices, s, k);
        });
    }
    Outcome<Done> topology() {
        const auto end = [&](Done done) {
            text_.put("</Topology>\n");
            return done;
        };
        if constexpr (G::degree == 2) {
            return (has_elements() ? alone(linear_.elements) : alone(linear_.facets)).map(end);
        } else {
            const std::size_t lines = D == 3 ? linear_.edges.size() : 0;
            const std::size_t words = linear_.elements.size() * (head_words<D> + D + 1) +
                                      linear_.facets.size() * (head_words<D - 1> + D) + lines * 4;
            text_.put("<Topology TopologyType=\"Mixed\" NumberOfElements=\"" + std::to_string(cells()) + "\">\n" +
                      item<std::int64_t>(words, 1));
            auto done = mixed(linear_.elements).and_then([&](Done) { return mixed(linear_.facets); });
            if constexpr (D == 3)
                if (done) done = mixed(linear_.edges);
            if (done) text_.put("</DataItem>\n");
            return done.map(end);
        }
    }

    template <class T, class Value>
    Outcome<Done> attribute(const std::string& name, Centring centring, std::size_t n, std::size_t width,
                            const Value& value) {
        text_.put("<Attribute Name=\"" + vtu::escaped(name) + "\" AttributeType=\"" +
                  std::string(attribute_type(width)) + "\" Center=\"" + (centring == Centring::node ? "Node" : "Cell") +
                  "\">\n");
        return data_item<T>(n, width, value).map([&](Done done) {
            text_.put("</Attribute>\n");
            return done;
        });
    }

    template <class T>
    Outcome<Done> put(const MeshField& field, const Column<T>& values) {
        const std::vector<int> sources = sources_of(field.kind, D);
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        const std::size_t n = field.centring == Centring::node ? grid_.nodes() : cells();
        return attribute<T>(field.name, field.centring, n, sources.size(), [&](std::size_t i, std::size_t k) {
            return sources[k] < 0 ? T{} : values[i * width + static_cast<std::size_t>(sources[k])];
        });
    }

    G grid_;
    const LinearMesh<D>& linear_;
    const MeshFields& fields_;
    TextWriter text_;
};

}  // namespace

}  // namespace xdmf

template <int D>
Outcome<Chunks> encode_xdmf(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return guarded(
            [&] { return xdmf::Writer(simplices, with_legal_names(fields, vtu::field_names()), execution).write(); });
    });
}

bool is_xdmf(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 1024;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), soon));
    const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
    return first != std::string_view::npos && text[first] == '<' && text.find("<Xdmf") != std::string_view::npos &&
           text.find("<VTKFile") == std::string_view::npos;
}

template <int D>
std::vector<Notice> not_in_xdmf(const Mesh<D>& all) {
    const LinearMesh<D> mesh = straight_simplices(all);
    std::vector<Notice> notices = unsupported_data(mesh, {.feature_edges = all.degree == 1}, "XDMF");
    if (all.degree == 2 && mesh.elements.size() > 0 && mesh.facets.size() > 0)
        notices.push_back({"XDMF allows only one kind of cells of degree 2 in a grid: " +
                           std::to_string(mesh.facets.size()) + " facets are left out"});
    return notices;
}

#define CAMBER_INSTANTIATE(D)                                                                     \
    template Outcome<Chunks> encode_xdmf<D>(const Mesh<D>&, const MeshFields&, const Execution&); \
    template std::vector<Notice> not_in_xdmf<D>(const Mesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

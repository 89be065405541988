module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
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

namespace vtk {

namespace {

template <class T>
constexpr std::string_view type_name = std::is_same_v<T, double> ? "double" : "int";

std::string encoded(std::string_view name) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string text;
    for (const char c : name) {
        const auto code = static_cast<unsigned char>(c);
        if (code > ' ' && code < 0x7f && c != '%' && c != '"') {
            text += c;
            continue;
        }
        text += '%';
        text += digits[code / 16];
        text += digits[code % 16];
    }
    return text;
}

template <int K>
constexpr std::int32_t cell_type(int degree) {
    constexpr std::array<std::int32_t, 3> linear{3, 5, 10}, quadratic{21, 22, 24};
    return degree == 1 ? linear[K - 1] : quadratic[K - 1];
}

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;
    using G = Grid<Mesh>;

    Writer(const Mesh& mesh, const MeshFields& fields, VtkEncoding encoding, const Execution& execution)
        : grid_{mesh}, linear_(grid_.linear()), fields_(fields), encoding_(encoding), execution_(execution) {}

    Outcome<Chunks> write() && {
        if (auto sound = check(); !sound) return fail(std::move(sound.error()));
        text(std::string("# vtk DataFile Version 4.2\na mesh of Camber\n") +
             (encoding_ == VtkEncoding::ascii ? "ASCII" : "BINARY") + "\nDATASET UNSTRUCTURED_GRID\n");
        auto done = points().and_then([&](Done) { return cells(); }).and_then([&](Done) { return point_data(); });
        if (done) done = cell_data();
        if (!done) return fail(std::move(done.error()));
        return std::move(chunks_);
    }

  private:
    [[nodiscard]] std::size_t rows(Centring centring) const {
        return centring == Centring::node ? grid_.nodes() : cells_of(linear_);
    }
    [[nodiscard]] Outcome<Done> check() const {
        if (!columns_fit(linear_) || !grid_.is_sound())
            return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths");
        constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
        if (grid_.nodes() > most || entries() > most)
            return fail(ErrorKind::unsupported, "has more cells than legacy VTK files can number", {}, {},
                        "write a .vtu");
        return check_rows<D>(fields_, grid_.nodes(), rows(Centring::cell));
    }

    [[nodiscard]] std::size_t entries() const {
        const std::size_t of_edges = linear_.edges.size() * (1 + G::template width<1>);
        return linear_.elements.size() * (1 + G::template width<D>)+linear_.facets.size() *
               (1 + G::template width<D - 1>)+(D == 3 ? of_edges : 0);
    }

    void text(std::string_view words) {
        Buffer<std::byte> bytes(words.size());
        std::memcpy(bytes.data(), words.data(), words.size());
        chunks_.push_back(std::move(bytes));
    }

    template <class T, class Value>
    Outcome<Done> numbers(std::size_t n, std::size_t width, const Value& value) {
        constexpr std::size_t grain = 4096;
        const std::size_t before = chunks_.size();
        chunks_.resize(before + (n + grain - 1) / grain);
        return each_chunk(
            execution_, n,
            [&](std::size_t first, std::size_t last) {
                chunks_[before + first / grain] = encoding_ == VtkEncoding::ascii
                                                      ? lines<T>(first, last, width, value)
                                                      : packed<T>(first, last, width, value);
            },
            grain);
    }
    template <class T, class Value>
    Outcome<Done> array(std::size_t n, std::size_t width, const Value& value) {
        return numbers<T>(n, width, value).map([&](Done done) {
            end_array();
            return done;
        });
    }
    void end_array() {
        if (encoding_ == VtkEncoding::binary) text("\n");
    }
    template <class T, class Value>
    static Buffer<std::byte> lines(std::size_t first, std::size_t last, std::size_t width, const Value& value) {
        Buffer<char> room((last - first) * width * word_room);
        char* to = room.data();
        for (std::size_t i = first; i < last; ++i)
            for (std::size_t k = 0; k < width; ++k)
                to = write_word(to, static_cast<T>(value(i, k)), k + 1 == width ? '\n' : ' ');
        Buffer<std::byte> bytes(static_cast<std::size_t>(to - room.data()));
        std::memcpy(bytes.data(), room.data(), bytes.size());
        return bytes;
    }
    template <class T, class Value>
    static Buffer<std::byte> packed(std::size_t first, std::size_t last, std::size_t width, const Value& value) {
        Buffer<std::byte> bytes((last - first) * width * sizeof(T));
        std::byte* to = bytes.data();
        for (std::size_t i = first; i < last; ++i)
            for (std::size_t k = 0; k < width; ++k, to += sizeof(T)) {
                const auto number = static_cast<T>(value(i, k));
                std::memcpy(to, &number, sizeof number);
                if constexpr (std::endian::native == std::endian::little) std::reverse(to, to + sizeof number);
            }
        return bytes;
    }

    Outcome<Done> points() {
        text("POINTS " + std::to_string(grid_.nodes()) + " double\n");
        return array<double>(grid_.nodes(), 3, [&](std::size_t n, std::size_t c) {
            return c < D ? grid_.point(n)[static_cast<int>(c)] : 0.0;
        });
    }

    template <int K>
    Outcome<Done> cells_of_kind(const Simplices<K>& simplices) {
        constexpr std::size_t width = G::template width<K>;
        return numbers<std::int32_t>(simplices.size(), 1 + width, [&](std::size_t s, std::size_t k) {
            return k == 0 ? width : grid_.template node<K>(simplices, s, k - 1);
        });
    }
    Outcome<Done> cells() {
        const std::size_t n = cells_of(linear_);
        text("CELLS " + std::to_string(n) + " " + std::to_string(entries()) + "\n");
        auto done = cells_of_kind(linear_.elements).and_then([&](Done) { return cells_of_kind(linear_.facets); });
        if constexpr (D == 3)
            if (done) done = cells_of_kind(linear_.edges);
        if (!done) return done;
        end_array();
        text("CELL_TYPES " + std::to_string(n) + "\n");
        return of_cells([]<int K>(const Simplices<K>&, std::size_t) { return cell_type<K>(G::degree); });
    }
    Outcome<Done> of_cells(const auto& value) {
        return array<std::int32_t>(cells_of(linear_), 1,
                                   [&](std::size_t c, std::size_t) { return at_cell(linear_, c, value); });
    }

    Outcome<Done> point_data() {
        const std::size_t own = 1, n = grid_.nodes();
        text("POINT_DATA " + std::to_string(n) + "\nFIELD FieldData " + std::to_string(own + count(Centring::node)) +
             "\nreference 1 " + std::to_string(n) + " int\n");
        return array<std::int32_t>(n, 1, [&](std::size_t v, std::size_t) { return grid_.reference(v); })
            .and_then([&](Done) { return put_fields(Centring::node); });
    }

    Outcome<Done> cell_data() {
        const std::string n = std::to_string(cells_of(linear_));
        const bool known = has_entities();
        const std::size_t own = known ? 3 : 2;
        text("CELL_DATA " + n + "\nFIELD FieldData " + std::to_string(own + count(Centring::cell)) + "\nreference 1 " +
             n + " int\n");
        auto done = of_cells([](const auto& simplices, std::size_t s) { return simplices.references[s]; });
        if (!done) return done;
        text("dimension 1 " + n + " int\n");
        done = of_cells([]<int K>(const Simplices<K>&, std::size_t) { return K; });
        if (done && known) {
            text("entity 1 " + n + " int\n");
            done = of_cells([](const auto& simplices, std::size_t s) {
                return simplices.entities.empty() ? 0 : simplices.entities[s];
            });
        }
        return done ? put_fields(Centring::cell) : done;
    }
    [[nodiscard]] bool has_entities() const {
        const auto known = [](const auto& simplices) {
            return std::any_of(simplices.entities.begin(), simplices.entities.end(),
                               [](Reference e) { return e != 0; });
        };
        return known(linear_.elements) || known(linear_.facets) || known(linear_.edges);
    }

    [[nodiscard]] std::size_t count(Centring centring) const {
        return static_cast<std::size_t>(std::count_if(
            fields_.begin(), fields_.end(), [&](const MeshField& field) { return field.centring == centring; }));
    }
    Outcome<Done> put_fields(Centring centring) {
        for (const MeshField& field : fields_) {
            if (field.centring != centring) continue;
            auto done = std::visit([&](const auto& values) { return put(field, values); }, field.values);
            if (!done) return done;
        }
        return Done{};
    }
    template <class T>
    Outcome<Done> put(const MeshField& field, const Column<T>& values) {
        const vtu::Components components = vtu::components_of(field.kind, D);
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        const std::size_t wide = components.sources.size(), n = rows(field.centring);
        text(encoded(field.name) + " " + std::to_string(wide) + " " + std::to_string(n) + " " +
             std::string(type_name<T>) + "\n");
        return array<T>(n, wide, [&](std::size_t i, std::size_t k) {
            const int source = components.sources[k];
            return source < 0 ? T{} : values[i * width + static_cast<std::size_t>(source)];
        });
    }

    G grid_;
    const LinearMesh<D>& linear_;
    const MeshFields& fields_;
    VtkEncoding encoding_;
    const Execution& execution_;
    Chunks chunks_;
};

}  // namespace

FieldNames field_names() {
    FieldNames names = vtu::field_names();
    for (NameRule* const rule : {&names.at_nodes, &names.at_cells}) rule->reserved.emplace_back("METADATA");
    return names;
}

}  // namespace vtk

template <int D>
Outcome<Chunks> encode_vtk(const Mesh<D>& mesh, const MeshFields& fields, VtkEncoding encoding,
                           const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return guarded([&] {
            return vtk::Writer(simplices, with_legal_names(fields, vtk::field_names()), encoding, execution).write();
        });
    });
}

template <int D>
std::vector<Notice> not_in_vtk(const Mesh<D>& mesh) {
    return unsupported_data(straight_simplices(mesh), {.entities = true}, "VTK");
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<Chunks> encode_vtk<D>(const Mesh<D>&, const MeshFields&, VtkEncoding, const Execution&); \
    template std::vector<Notice> not_in_vtk<D>(const Mesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

module;
#include "cgns_library.hpp"
#include "cgns_temporary.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ios>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace cgns {

namespace {

/// CGNS has names of at most 32 letters.
using Name = std::array<char, 33>;

/// Where a simplex of the file went.
struct Place {
    std::int8_t dimension = -1, degree = 0;
    bool listed = false;  ///< by a boundary condition
    std::uint32_t row = 0;
};

/// Elements with numbers that follow each other.
struct Section {
    std::string name;
    std::optional<Reference> reference = {};  ///< as the file gives it
    cgsize_t first = 0;
    std::vector<Place> places = {};
};

/// Closes the file whatever happens.
class OpenFile {
  public:
    OpenFile(const Library& lib, int number) : lib_(lib), number_(number) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    OpenFile(OpenFile&&) = delete;
    OpenFile& operator=(OpenFile&&) = delete;
    ~OpenFile() { lib_.close_(number_); }

  private:
    const Library& lib_;
    int number_;
};

/// Reads one file of D physical dimensions, part by part.
template <int D>
struct Reader {
    const Library& lib;
    int file = 0;
    int cell_dimension = 0;
    listing::Mesh<D> mesh = {};
    std::vector<Notice> notices = {};
    std::vector<Section> sections = {};
    std::map<std::string, std::size_t> foreign = {};
    std::size_t points_listed = 0, listed_again = 0;

    [[nodiscard]] auto broken(std::string_view doing) const {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, mesh.name));
    }

    [[nodiscard]] Outcome<Done> read_points(std::size_t n) {
        int coordinates = 0;
        if (lib.ncoords_(file, 1, 1, &coordinates) != CG_OK) return broken("the coordinates cannot be read");
        if (coordinates < D)
            return fail(ErrorKind::input,
                        "the zone has " + std::to_string(coordinates) + " coordinates, not " + std::to_string(D),
                        mesh.name);
        mesh.points.resize(n);
        mesh.point_references.assign(n, 0);
        Buffer<double> column(n);
        constexpr std::array names{"CoordinateX", "CoordinateY", "CoordinateZ"};
        const cgsize_t first = 1, last = static_cast<cgsize_t>(n);
        for (int c = 0; c < D && n > 0; ++c) {
            if (lib.coord_read_(file, 1, 1, names[c], CGNS_ENUMV(RealDouble), &first, &last, column.data()) != CG_OK)
                return broken(std::string(names[c]) + " cannot be read");
            for (std::size_t v = 0; v < n; ++v) mesh.points[v][c] = column[v];
        }
        return Done{};
    }

    template <int K>
    [[nodiscard]] listing::Simplices<K>* simplices() {
        if constexpr (K == D) return &mesh.elements;
        if constexpr (K == D - 1) return &mesh.facets;
        if constexpr (K == 1 && D == 3) return &mesh.edges;
        return nullptr;
    }

    template <int N>
    static std::array<VertexId, N> nodes_of(const cgsize_t* nodes) {
        std::array<VertexId, N> simplex;
        for (int n = 0; n < N; ++n)
            simplex[n] = nodes[n] > 0 && std::cmp_less_equal(nodes[n], max_entities)
                             ? VertexId(static_cast<std::size_t>(nodes[n] - 1))
                             : VertexId();
        return simplex;
    }

    template <int K>
    void add(listing::Simplices<K>& kind, int degree, const cgsize_t* nodes, Section& section) {
        std::size_t row = 0;
        const auto put = [&](auto& rows, auto simplex) {
            row = rows.size();
            rows.nodes.push_back(simplex);
            rows.references.push_back(0);
        };
        if (degree == 1)
            put(kind.straight, nodes_of<K + 1>(nodes));
        else
            put(kind.curved, nodes_of<quadratic_nodes<K>>(nodes));
        section.places.push_back({K, static_cast<std::int8_t>(degree), false, static_cast<std::uint32_t>(row)});
    }

    /// One element; false: none that we can hold.
    bool add_element(CGNS_ENUMT(ElementType_t) type, const cgsize_t* nodes, Section& section) {
        switch (type) {
            case CGNS_ENUMV(BAR_2): return add_simplex<1>(1, nodes, section);
            case CGNS_ENUMV(BAR_3): return add_simplex<1>(2, nodes, section);
            case CGNS_ENUMV(TRI_3): return add_simplex<2>(1, nodes, section);
            case CGNS_ENUMV(TRI_6): return add_simplex<2>(2, nodes, section);
            case CGNS_ENUMV(TETRA_4): return add_simplex<3>(1, nodes, section);
            case CGNS_ENUMV(TETRA_10): return add_simplex<3>(2, nodes, section);
            default: return false;
        }
    }
    template <int K>
    bool add_simplex(int degree, const cgsize_t* nodes, Section& section) {
        if constexpr (K > D) {
            return false;
        } else {
            add(*simplices<K>(), degree, nodes, section);
            return true;
        }
    }
    void skip(CGNS_ENUMT(ElementType_t) type, Section& section) {
        section.places.emplace_back();
        if (type == CGNS_ENUMV(NODE))
            ++points_listed;
        else
            ++foreign[lib.ElementTypeName_(type)];
    }

    /// The number that a descriptor below the current node gives.
    [[nodiscard]] std::optional<Reference> described_reference() const {
        int n = 0;
        if (lib.ndescriptors_(&n) != CG_OK) return std::nullopt;
        for (int d = 1; d <= n; ++d) {
            Name name{};
            char* text = nullptr;
            if (lib.descriptor_read_(d, name.data(), &text) != CG_OK) continue;
            const std::string value(text != nullptr ? text : "");
            if (text != nullptr) lib.free_(text);
            if (std::string_view(name.data()) != "reference") continue;
            Words words{value.data(), value.data() + value.size()};
            std::int64_t number = 0;
            if (read_number(words, number) && gmf::is_reference(number)) return static_cast<Reference>(number);
        }
        return std::nullopt;
    }

    [[nodiscard]] Outcome<Done> read_section(int s) {
        Name name{};
        CGNS_ENUMT(ElementType_t) type{};
        cgsize_t first = 0, last = 0, size = 0;
        int boundary = 0, parents = 0;
        if (lib.section_read_(file, 1, 1, s, name.data(), &type, &first, &last, &boundary, &parents) != CG_OK ||
            lib.ElementDataSize_(file, 1, 1, s, &size) != CG_OK || first < 1 || last < first ||
            last == std::numeric_limits<cgsize_t>::max() || size < 0)
            return broken("section " + std::to_string(s) + " cannot be read");
        const auto n = static_cast<std::size_t>(last - first) + 1;
        Section section{name.data(), {}, first};
        if (lib.goto_(file, 1, "Zone_t", 1, "Elements_t", s, "end") == CG_OK) section.reference = described_reference();
        const bool fixed = type != CGNS_ENUMV(MIXED) && type < CGNS_ENUMV(NGON_n);
        if (!fixed && type != CGNS_ENUMV(MIXED)) {
            foreign[lib.ElementTypeName_(type)] += n;
            return Done{};
        }
        int width = 0;
        if (fixed &&
            (lib.npe_(type, &width) != CG_OK || static_cast<std::size_t>(size) != n * static_cast<std::size_t>(width)))
            return broken("section " + std::to_string(s) + " has " + std::to_string(size) + " numbers for " +
                          std::to_string(n) + " elements");
        if (!fixed && n > static_cast<std::size_t>(size) / 2)
            return broken("section " + std::to_string(s) + " has " + std::to_string(size) + " numbers for " +
                          std::to_string(n) + " elements");
        // Offsets are not asked for: their number in a damaged file is anything.
        std::vector<cgsize_t> numbers(static_cast<std::size_t>(size));
        const int read = fixed ? lib.elements_read_(file, 1, 1, s, numbers.data(), nullptr)
                               : lib.poly_elements_read_(file, 1, 1, s, numbers.data(), nullptr, nullptr);
        if (read != CG_OK) return broken("the elements of section " + std::to_string(s) + " cannot be read");
        section.places.reserve(n);
        if (auto done = fixed ? add_fixed(type, static_cast<std::size_t>(width), numbers, section)
                              : add_mixed(numbers, n, section);
            !done)
            return done;
        sections.push_back(std::move(section));
        return Done{};
    }
    Outcome<Done> add_fixed(CGNS_ENUMT(ElementType_t) type, std::size_t width, std::span<const cgsize_t> numbers,
                            Section& section) {
        for (std::size_t at = 0; at + width <= numbers.size(); at += width)
            if (!add_element(type, numbers.data() + at, section)) skip(type, section);
        return Done{};
    }
    Outcome<Done> add_mixed(std::span<const cgsize_t> numbers, std::size_t n, Section& section) {
        std::size_t at = 0;
        for (std::size_t i = 0; i < n; ++i) {
            int width = 0;
            const auto type =
                at < numbers.size() ? static_cast<CGNS_ENUMT(ElementType_t)>(numbers[at]) : CGNS_ENUMV(ElementTypeNull);
            const bool is_cell = type > CGNS_ENUMV(ElementTypeUserDefined) && type != CGNS_ENUMV(MIXED) &&
                                 type != CGNS_ENUMV(NGON_n) && type != CGNS_ENUMV(NFACE_n);
            if (!is_cell || lib.npe_(type, &width) != CG_OK || width < 1 ||
                at + 1 + static_cast<std::size_t>(width) > numbers.size())
                return damaged(section, i + 1);
            if (!add_element(type, numbers.data() + at + 1, section)) skip(type, section);
            at += 1 + static_cast<std::size_t>(width);
        }
        return at == numbers.size() ? Outcome<Done>(Done{}) : damaged(section, n);
    }
    [[nodiscard]] Outcome<Done> damaged(const Section& section, std::size_t element) const {
        return fail(ErrorKind::input, "the mixed section \"" + section.name + "\" is damaged", mesh.name,
                    Entity{"element", element}, "try cgnscheck on it");
    }

    /// Gives simplices of this dimension that no condition lists the reference of their section: its own, or the next
    /// of those that are not taken.
    void number_sections(int dimension, std::set<Reference> taken) {
        for (const Section& section : sections)
            if (section.reference) taken.insert(*section.reference);
        for (Section& section : sections) {
            const auto mine = [&](const Place& p) { return p.dimension == dimension && !p.listed; };
            if (std::none_of(section.places.begin(), section.places.end(), mine)) continue;
            const Reference reference = section.reference ? *section.reference : next_free(taken);
            for (const Place& place : section.places)
                if (mine(place)) reference_at(place) = reference;
            name_group(dimension, reference, section.name);
        }
    }
    static Reference next_free(std::set<Reference>& taken) {
        Reference next = 1;
        while (!taken.insert(next).second) ++next;
        return next;
    }
    /// f(the rows that the place is in).
    auto at_place(const Place& place, auto&& f) {
        const auto of_kind = [&](auto& kind) { return place.degree == 1 ? f(kind.straight) : f(kind.curved); };
        if constexpr (D == 3)
            if (place.dimension == 1) return of_kind(mesh.edges);
        return place.dimension == D ? of_kind(mesh.elements) : of_kind(mesh.facets);
    }
    Reference& reference_at(const Place& place) {
        return *at_place(place, [&](auto& rows) { return &rows.references[place.row]; });
    }
    /// The first name of a reference stands; names that `encode_cgns` made up are none.
    void name_group(int dimension, Reference reference, const std::string& name) {
        if (name == plain_name(dimension, reference)) return;
        for (const Group& group : mesh.groups)
            if (group.dimension == dimension && group.reference == reference) return;
        mesh.groups.push_back({dimension, reference, name});
    }

    /// A boundary condition as the file has it.
    struct Condition {
        std::string name;
        std::optional<Reference> reference;
        std::vector<cgsize_t> items;
        bool is_range = false, of_elements = false;
    };

    [[nodiscard]] Outcome<Condition> read_condition(int bc) {
        Name name{};
        CGNS_ENUMT(BCType_t) type{};
        CGNS_ENUMT(PointSetType_t) set{};
        CGNS_ENUMT(DataType_t) normal_type{};
        CGNS_ENUMT(GridLocation_t) location = CGNS_ENUMV(Vertex);
        cgsize_t n = 0, normals = 0;
        int normal_index[3]{}, datasets = 0;
        if (lib.boco_info_(file, 1, 1, bc, name.data(), &type, &set, &n, normal_index, &normals, &normal_type,
                           &datasets) != CG_OK ||
            n < 0 || !has_one_index_a_point(bc, n))
            return broken("boundary condition " + std::to_string(bc) + " cannot be read");
        static_cast<void>(lib.boco_gridlocation_read_(file, 1, 1, bc, &location));
        Condition condition{name.data(), {}, std::vector<cgsize_t>(static_cast<std::size_t>(n))};
        if (n > 0 && lib.boco_read_(file, 1, 1, bc, condition.items.data(), nullptr) != CG_OK)
            return broken("the points of boundary condition \"" + condition.name + "\" cannot be read");
        if (lib.goto_(file, 1, "Zone_t", 1, "ZoneBC_t", 1, "BC_t", bc, "end") == CG_OK)
            condition.reference = described_reference();
        condition.is_range = set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(ElementRange);
        condition.of_elements =
            set == CGNS_ENUMV(ElementRange) || set == CGNS_ENUMV(ElementList) || location != CGNS_ENUMV(Vertex);
        if (condition.is_range && (n != 2 || condition.items[1] < condition.items[0])) condition.items.clear();
        return condition;
    }
    /// The library writes as many numbers as the node has, whatever it says of the points.
    [[nodiscard]] bool has_one_index_a_point(int bc, cgsize_t n) const {
        double node = 0, points = 0;
        int cgio = 0;
        if (lib.boco_id_(file, 1, 1, bc, &node) != CG_OK || lib.get_cgio_(file, &cgio) != CG_OK) return false;
        for (const char* const child : {"PointList", "PointRange", "ElementList", "ElementRange"}) {
            if (lib.node_id(cgio, node, child, &points) != 0) continue;
            int dimensions = 0;
            std::array<cgsize_t, 12> sizes{};
            if (lib.node_dimensions(cgio, points, &dimensions, sizes.data()) != 0) return false;
            cgsize_t product = 1;
            for (int d = 0; d < dimensions; ++d) product *= sizes[static_cast<std::size_t>(d)];
            if (product != n || (dimensions > 1 && sizes[0] != 1)) return false;
        }
        return true;
    }

    /// What the condition lists gets its reference. False: it lists no simplex of the boundary's dimension.
    bool mark(const Condition& condition, Reference reference) {
        std::size_t listed = 0;
        const auto enter = [&](Place& place) {
            if (place.dimension != cell_dimension - 1) return;
            listed_again += place.listed ? 1 : 0;
            reference_at(place) = reference;
            place.listed = true;
            ++listed;
        };
        if (condition.of_elements)
            each_element(condition, enter);
        else
            each_between_vertices(condition, enter);
        return listed > 0;
    }
    void each_element(const Condition& condition, const auto& enter) {
        for (Section& section : sections) {
            const cgsize_t last = section.first + static_cast<cgsize_t>(section.places.size()) - 1;
            const auto at = [&](cgsize_t e) -> Place& {
                return section.places[static_cast<std::size_t>(e - section.first)];
            };
            if (condition.is_range && condition.items.size() == 2) {
                const cgsize_t end = std::min(condition.items[1], last);
                for (cgsize_t e = std::max(condition.items[0], section.first); e <= end; ++e) enter(at(e));
                continue;
            }
            for (const cgsize_t e : condition.items)
                if (e >= section.first && e <= last) enter(at(e));
        }
    }
    /// Simplices of the boundary all of whose vertices are listed.
    void each_between_vertices(const Condition& condition, const auto& enter) {
        std::vector<std::uint8_t> listed(mesh.points.size(), 0);
        const auto list = [&](cgsize_t v) {
            if (v >= 1 && std::cmp_less_equal(v, listed.size())) listed[static_cast<std::size_t>(v - 1)] = 1;
        };
        if (condition.is_range && condition.items.size() == 2)
            for (cgsize_t v = std::max<cgsize_t>(1, condition.items[0]);
                 v <= condition.items[1] && std::cmp_less_equal(v, listed.size()); ++v)
                list(v);
        else
            std::for_each(condition.items.begin(), condition.items.end(), list);
        for (Section& section : sections)
            for (Place& place : section.places) {
                if (place.dimension != cell_dimension - 1) continue;
                const bool all = at_place(place, [&](auto& rows) {
                    const auto& nodes = rows.nodes[place.row];
                    return std::all_of(nodes.begin(), nodes.begin() + cell_dimension, [&](VertexId v) {
                        return v.valid() && v.index() < listed.size() && listed[v.index()] != 0;
                    });
                });
                if (all) enter(place);
            }
    }

    [[nodiscard]] Outcome<Done> read_conditions() {
        int n = 0;
        if (lib.nbocos_(file, 1, 1, &n) != CG_OK) return broken("the boundary conditions cannot be read");
        std::vector<Condition> conditions;
        std::set<Reference> taken;
        for (int bc = 1; bc <= n; ++bc) {
            auto condition = read_condition(bc);
            if (!condition) return fail(condition.error());
            if (condition->reference) taken.insert(*condition->reference);
            conditions.push_back(std::move(*condition));
        }
        for (const Section& section : sections)
            if (section.reference) taken.insert(*section.reference);
        for (const Condition& condition : conditions) {
            const Reference reference = condition.reference ? *condition.reference : next_free(taken);
            if (mark(condition, reference))
                name_group(cell_dimension - 1, reference, condition.name);
            else
                notices.push_back({"the boundary condition \"" + condition.name + "\" has no face of the mesh"});
        }
        if (listed_again > 0)
            notices.push_back({std::to_string(listed_again) +
                               " faces are in several boundary conditions: the last of each was taken"});
        for (int k = D; k >= 1; --k) number_sections(k, k == cell_dimension - 1 ? taken : std::set<Reference>{});
        return Done{};
    }

    [[nodiscard]] Outcome<Done> refuse_foreign() const {
        if (foreign.empty()) return Done{};
        std::string text = "holds ";
        for (const auto& [name, count] : foreign)
            text += (text.size() > 6 ? ", " : "") + std::to_string(count) + " " + name;
        return fail(ErrorKind::unsupported, text + ", which Camber cannot hold", mesh.name, {},
                    "give a mesh of edges, triangles and tetrahedra of degree 1 or 2");
    }

    /// Scalars at vertices; those named …X …Y (…Z) become a vector.
    [[nodiscard]] Outcome<Done> read_fields() {
        int solutions = 0;
        if (lib.nsols_(file, 1, 1, &solutions) != CG_OK) return broken("the solutions cannot be read");
        std::map<std::string, Column<double>> scalars;
        std::vector<std::string> order;
        for (int s = 1; s <= solutions; ++s) {
            Name name{};
            CGNS_ENUMT(GridLocation_t) location{};
            int fields = 0;
            if (lib.sol_info_(file, 1, 1, s, name.data(), &location) != CG_OK ||
                lib.nfields_(file, 1, 1, s, &fields) != CG_OK)
                return broken("solution " + std::to_string(s) + " cannot be read");
            int dimensions = 0;
            cgsize_t sizes[3]{};
            const bool at_vertices = location == CGNS_ENUMV(Vertex) &&
                                     lib.sol_size_(file, 1, 1, s, &dimensions, sizes) == CG_OK && dimensions == 1 &&
                                     static_cast<std::size_t>(sizes[0]) == mesh.points.size();
            if (!at_vertices && fields > 0) {
                notices.push_back({"the " + std::to_string(fields) + " fields of the solution \"" +
                                   std::string(name.data()) + "\" are not at all vertices and were skipped"});
                continue;
            }
            for (int f = 1; f <= fields; ++f) {
                CGNS_ENUMT(DataType_t) type{};
                Name field{};
                Buffer<double> values(mesh.points.size());
                const cgsize_t first = 1, last = static_cast<cgsize_t>(mesh.points.size());
                if (lib.field_info_(file, 1, 1, s, f, &type, field.data()) != CG_OK ||
                    lib.field_read_(file, 1, 1, s, field.data(), CGNS_ENUMV(RealDouble), &first, &last,
                                    values.data()) != CG_OK)
                    return broken("field " + std::to_string(f) + " cannot be read");
                if (type != CGNS_ENUMV(RealDouble) && type != CGNS_ENUMV(RealSingle) && type != CGNS_ENUMV(Integer) &&
                    type != CGNS_ENUMV(LongInteger)) {
                    notices.push_back(
                        {"the field \"" + std::string(field.data()) + "\" is not of real numbers: left out"});
                    continue;
                }
                if (scalars.contains(field.data()))
                    notices.push_back({"the field \"" + std::string(field.data()) +
                                       "\" is in several solutions: the last was taken"});
                else
                    order.emplace_back(field.data());
                scalars.insert_or_assign(field.data(), Column<double>(std::move(values)));
            }
        }
        for (const std::string& name : order) add_field(name, scalars);
        return Done{};
    }
    void add_field(const std::string& name, const std::map<std::string, Column<double>>& scalars) {
        constexpr std::string_view axes = "XYZ";
        const std::string stem = name.substr(0, name.size() - 1);
        const auto whole_vector = [&] {
            for (int c = 0; c < D; ++c)
                if (!scalars.contains(stem + axes[static_cast<std::size_t>(c)])) return false;
            return !stem.empty();
        }();
        const std::size_t axis = axes.substr(0, D).find(name.back());
        if (!whole_vector || axis == std::string_view::npos) {
            mesh.fields = std::move(mesh.fields).with({name, Centring::node, FieldKind::scalar, scalars.at(name)});
            return;
        }
        if (axis != 0) return;
        Buffer<double> values(mesh.points.size() * D);
        for (int c = 0; c < D; ++c) {
            const Column<double>& column = scalars.at(stem + axes[static_cast<std::size_t>(c)]);
            for (std::size_t v = 0; v < column.size(); ++v) values[v * D + static_cast<std::size_t>(c)] = column[v];
        }
        mesh.fields =
            std::move(mesh.fields).with({stem, Centring::node, FieldKind::vector, Column<double>(std::move(values))});
    }

    void name_origins() {
        const auto name_rows = [](auto& rows, const char* noun) { rows.origin.noun = noun; };
        name_rows(mesh.elements.straight, simplex_name<D>);
        name_rows(mesh.elements.curved, simplex_name<D>);
        name_rows(mesh.facets.straight, simplex_name<D - 1>);
        name_rows(mesh.facets.curved, simplex_name<D - 1>);
        name_rows(mesh.edges.straight, simplex_name<1>);
        name_rows(mesh.edges.curved, simplex_name<1>);
    }

    [[nodiscard]] Outcome<DecodedMesh> read(std::size_t vertices, const Execution& execution) {
        int n = 0;
        if (auto done = read_points(vertices); !done) return fail(std::move(done.error()));
        if (lib.nsections_(file, 1, 1, &n) != CG_OK) return broken("the sections cannot be read");
        for (int s = 1; s <= n; ++s)
            if (auto done = read_section(s); !done) return fail(std::move(done.error()));
        auto done = refuse_foreign().and_then([&](Done) { return read_conditions(); }).and_then([&](Done) {
            return read_fields();
        });
        if (!done) return fail(std::move(done.error()));
        if (points_listed > 0)
            notices.push_back({std::to_string(points_listed) + " elements of kind NODE were skipped"});
        name_origins();
        if (auto sound = listing::check(mesh, execution); !sound) return fail(std::move(sound.error()));
        return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
    }
};

/// A file of these bytes: the one of that name, or a new one in a folder that is made for it.
Outcome<std::string> path_of(std::span<const std::byte> bytes, const std::string& name,
                             std::optional<TemporaryFolder>& folder) {
    std::error_code error;
    if (std::filesystem::is_regular_file(name, error) && std::filesystem::file_size(name, error) == bytes.size())
        return name;
    folder.emplace();
    if (folder->file().empty()) return fail(no_folder(folder->root()));
    std::ofstream stream(folder->file(), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) return fail(ErrorKind::write, "the temporary file cannot be written", folder->file());
    return folder->file();
}

struct Zone {
    int cell_dimension = 0, physical_dimension = 0;
    std::size_t vertices = 0;
};

/// The one zone of the one base.
Outcome<Zone> zone_of(const Library& lib, int file, const std::string& name) {
    int bases = 0, zones = 0;
    Zone zone;
    Name text{};
    CGNS_ENUMT(ZoneType_t) type{};
    cgsize_t size[9]{};
    const auto broken = [&](std::string_view doing) {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, name));
    };
    if (lib.nbases_(file, &bases) != CG_OK) return broken("the bases cannot be read");
    if (bases != 1)
        return fail(ErrorKind::unsupported, "has " + std::to_string(bases) + " bases, not one", name, {},
                    "give a file of one base");
    if (lib.base_read_(file, 1, text.data(), &zone.cell_dimension, &zone.physical_dimension) != CG_OK ||
        lib.nzones_(file, 1, &zones) != CG_OK)
        return broken("the base cannot be read");
    if (zones != 1)
        return fail(ErrorKind::unsupported, "has " + std::to_string(zones) + " zones, not one", name, {},
                    "join the zones to one");
    if (lib.zone_type_(file, 1, 1, &type) != CG_OK) return broken("the zone cannot be read");
    if (type != CGNS_ENUMV(Unstructured))
        return fail(ErrorKind::unsupported, "the zone is structured", name, {},
                    "give a mesh of triangles or tetrahedra");
    if (lib.zone_read_(file, 1, 1, text.data(), size) != CG_OK) return broken("the zone cannot be read");
    if (size[0] < 0 || static_cast<std::uint64_t>(size[0]) > 0xfffffff0U)
        return fail(ErrorKind::unsupported, "has more vertices than 32 bits can number", name);
    if (zone.physical_dimension != 2 && zone.physical_dimension != 3)
        return fail(ErrorKind::unsupported,
                    "is in " + std::to_string(zone.physical_dimension) + " dimensions, not 2 or 3", name);
    zone.vertices = static_cast<std::size_t>(size[0]);
    return zone;
}

}  // namespace

}  // namespace cgns

bool knows_cgns() { return true; }

Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name, const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const cgns::Library& lib = cgns::library();
        if (!lib.missing.empty()) return fail(cgns::no_library(lib.missing));
        const std::scoped_lock alone(cgns::library_lock());
        std::optional<cgns::TemporaryFolder> folder;
        const std::string title(name);
        const auto path = cgns::path_of(bytes, title, folder);
        if (!path) return fail(path.error());
        int file = 0;
        if (lib.open_(path->c_str(), CG_MODE_READ, &file) != CG_OK)
            return fail(cgns::error_of(lib.get_error_(), ErrorKind::input, "the file cannot be opened as CGNS", title));
        const cgns::OpenFile open(lib, file);
        const auto zone = cgns::zone_of(lib, file, title);
        if (!zone) return fail(zone.error());
        const auto read = [&]<int D>() {
            cgns::Reader<D> reader{lib, file, zone->cell_dimension};
            reader.mesh.name = title;
            return reader.read(zone->vertices, execution);
        };
        return zone->physical_dimension == 2 ? read.template operator()<2>() : read.template operator()<3>();
    });
}

}  // namespace camber

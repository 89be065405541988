// Reads CGNS files: checks the sizes of their tree nodes, then reads zones and points.
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
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

/// A CGNS file is a tree of data nodes. Their sizes are checked before the library opens the file, because the library
/// reads many of them completely when it opens the file.
namespace camber::cgns {

namespace {

class Tree {
  public:
    Tree(const Library& lib, std::size_t file_bytes) : lib_(lib), file_bytes_(file_bytes), budget_(file_bytes) {}
    Tree(const Tree&) = delete;
    Tree& operator=(const Tree&) = delete;
    Tree(Tree&&) = delete;
    Tree& operator=(Tree&&) = delete;
    ~Tree() {
        if (is_open_) lib_.close_tree(file_);
    }

    /// Checks the sizes of all tree nodes. Returns success if the file has no tree, because the library rejects such a
    /// file later.
    [[nodiscard]] Outcome<Done> walk(const std::string& path, const std::string& name) {
        double root = 0;
        if (lib_.open_tree(path.c_str(), CGIO_MODE_READ, CGIO_FILE_NONE, &file_) != 0) return Done{};
        is_open_ = true;
        if (lib_.root_id(file_, &root) != 0) return Done{};
        return below(root, 0, name);
    }

  private:
    /// Maximum depth of the tree of nodes. Trees of standard files have at most twelve levels.
    static constexpr int max_depth = 32;
    static constexpr std::size_t bytes_of_a_node = 1024;

    [[nodiscard]] Outcome<Done> below(double node, int depth, const std::string& name) {
        int children = 0;
        if (depth > max_depth) return refused("has nodes nested deeper than " + std::to_string(max_depth), name);
        if (lib_.number_of_children(file_, node, &children) != 0) return Done{};
        for (int c = 1; c <= children; ++c) {
            double child = 0;
            int found = 0;
            cglong_t bytes = 0;
            if (lib_.children_ids(file_, node, c, 1, &found, &child) != 0 || found != 1) continue;
            // a tree node may have no data
            const bool has_data = lib_.data_size(file_, child, &bytes) == 0 && bytes > 0;
            const bool fits =
                budget_.take(1, bytes_of_a_node) && (!has_data || budget_.take(static_cast<std::uint64_t>(bytes), 1));
            if (!fits)
                return refused("its nodes declare more than " +
                                   std::to_string(UnpackedBudget::most(file_bytes_) >> 20U) +
                                   " MiB, which is implausible for a file of " + std::to_string(file_bytes_) + " bytes",
                               name);
            auto done = below(child, depth + 1, name);
            lib_.release_id(file_, child);
            if (!done) return done;
        }
        return Done{};
    }
    [[nodiscard]] static Outcome<Done> refused(std::string what, const std::string& name) {
        return fail(ErrorKind::input, std::move(what), name, {},
                    "the file is damaged; if it is whole, write it uncompressed");
    }

    const Library& lib_;
    std::size_t file_bytes_;
    UnpackedBudget budget_;
    int file_ = 0;
    bool is_open_ = false;
};

}  // namespace

Outcome<Done> check_nodes(const Library& lib, const std::string& path, std::size_t file_bytes,
                          const std::string& name) {
    return Tree(lib, file_bytes).walk(path, name);
}

namespace {

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

template <int D>
Outcome<Done> read_points(Reader<D>& of, std::size_t n) {
    int coordinates = 0;
    if (of.lib.ncoords_(of.file, 1, of.zone, &coordinates) != CG_OK) return of.broken("the coordinates cannot be read");
    if (coordinates < D)
        return fail(ErrorKind::input,
                    "the zone has " + std::to_string(coordinates) + " coordinates, not " + std::to_string(D),
                    of.mesh.name);
    if (auto within_budget = of.take_budget(n * (D + 1), "the zone's vertices"); !within_budget) return within_budget;
    of.first_point = of.mesh.points.size();
    of.mesh.points.resize(of.first_point + n);
    of.mesh.point_references.resize(of.first_point + n, 0);
    Buffer<double> column(n);
    constexpr std::array names{"CoordinateX", "CoordinateY", "CoordinateZ"};
    const cgsize_t first = 1, last = static_cast<cgsize_t>(n);
    for (int c = 0; c < D && n > 0; ++c) {
        if (of.lib.coord_read_(of.file, 1, of.zone, names[c], CGNS_ENUMV(RealDouble), &first, &last, column.data()) !=
            CG_OK)
            return of.broken(std::string(names[c]) + " cannot be read");
        for (std::size_t v = 0; v < n; ++v) of.mesh.points[of.first_point + v][c] = column[v];
    }
    return Done{};
}

template <int D>
void name_origins(listing::Mesh<D>& mesh) {
    const auto name_rows = [](auto& rows, const char* noun) { rows.origin.noun = noun; };
    name_rows(mesh.elements.straight, simplex_name<D>);
    name_rows(mesh.elements.curved, simplex_name<D>);
    name_rows(mesh.facets.straight, simplex_name<D - 1>);
    name_rows(mesh.facets.curved, simplex_name<D - 1>);
    name_rows(mesh.edges.straight, simplex_name<1>);
    name_rows(mesh.edges.curved, simplex_name<1>);
}

struct Zone {
    int number = 1;
    std::string name;
    std::size_t vertices = 0;
    bool is_joined = false;
};

struct Zones {
    int cell_dimension = 0, physical_dimension = 0;
    std::vector<Zone> chosen = {};
};

template <int D>
Outcome<Done> read_zone(Reader<D>& of, const Zone& zone) {
    of.zone = zone.number;
    of.sections.clear();
    of.groups_before = of.mesh.groups.size();
    return read_points(of, zone.vertices)
        .and_then([&](Done) { return read_sections(of); })
        .and_then([&](Done) { return read_conditions(of); })
        .and_then([&](Done) { return read_fields(of); });
}

template <int D>
void join(listing::Mesh<D>& mesh, const Zones& zones, std::vector<Notice>& notices) {
    std::vector<std::size_t> ends;
    ends.reserve(zones.chosen.size());
    for (const Zone& zone : zones.chosen) ends.push_back((ends.empty() ? 0 : ends.back()) + zone.vertices);
    std::size_t joined = 0;
    if (std::any_of(zones.chosen.begin(), zones.chosen.end(), [](const Zone& zone) { return zone.is_joined; }))
        joined = listing::join_coincident(mesh, ends);
    notices.push_back({std::to_string(zones.chosen.size()) + " zones were joined into one mesh" +
                       (joined > 0 ? ", at " + std::to_string(joined) + " vertices" : std::string())});
}

template <int D>
Outcome<DecodedMesh> read_mesh(Reader<D> of, const Zones& zones, UnsupportedCells unsupported_cells,
                               const Execution& execution) {
    for (const Zone& zone : zones.chosen) {
        if (zones.chosen.size() > 1) of.prefix = zone.name + " ";
        if (auto done = read_zone(of, zone); !done) return fail(std::move(done.error()));
    }
    if (auto supported = of.refused.verdict(of.mesh.name, unsupported_cells); !supported)
        return fail(std::move(supported.error()));
    if (of.points_listed > 0)
        of.notices.push_back({std::to_string(of.points_listed) + " elements of kind NODE were skipped"});
    name_origins(of.mesh);
    if (auto sound = listing::check(of.mesh, execution); !sound) return fail(std::move(sound.error()));
    if (zones.chosen.size() > 1) {
        if (!of.mesh.fields.empty()) of.notices.push_back({"the fields of the zones were left out"});
        of.mesh.fields = {};
        join(of.mesh, zones, of.notices);
        if (auto sound = listing::check(of.mesh, execution); !sound) return fail(std::move(sound.error()));
    }
    auto decoded =
        listing::assembled(std::move(of.mesh), listing::MidNodeKind::on_curve, std::move(of.notices), execution);
    if (decoded) decoded->unsupported_cells = of.refused.counts();
    return decoded;
}

/// Returns `name` if that file is as large as `bytes`, else the path of a new temporary file with `bytes`.
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

int open_to_read(const Library& lib, const std::string& path, int& file) {
    CAMBER_CGNS_KEEPS;
    return lib.open_(path.c_str(), CG_MODE_READ, &file);
}

Outcome<Zone> zone_of(const Library& lib, int file, int number, const std::string& file_name) {
    Zone zone{number, {}, 0};
    Name text{};
    CGNS_ENUMT(ZoneType_t) type{};
    cgsize_t size[9]{};
    int connections = 0;
    const auto broken = [&] {
        return fail(error_of(lib.get_error_(), ErrorKind::input, "the zone cannot be read", file_name));
    };
    if (lib.zone_type_(file, 1, number, &type) != CG_OK || lib.zone_read_(file, 1, number, text.data(), size) != CG_OK)
        return broken();
    if (type != CGNS_ENUMV(Unstructured))
        return fail(ErrorKind::unsupported, "the zone " + in_quotes(text.data()) + " is structured", file_name, {},
                    "give a mesh of triangles or tetrahedra");
    if (size[0] < 0 || static_cast<std::uint64_t>(size[0]) > max_entities)
        return fail(ErrorKind::unsupported, "has more vertices than 32 bits can number", file_name);
    zone.name = text.data();
    zone.vertices = static_cast<std::size_t>(size[0]);
    zone.is_joined = lib.nconns_(file, 1, number, &connections) == CG_OK && connections > 0;
    return zone;
}

Outcome<Zones> zones_of(const Library& lib, int file, const std::string& requested, const std::string& name) {
    int bases = 0, count = 0;
    Zones zones;
    Name text{};
    const auto broken = [&](std::string_view doing) {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, name));
    };
    if (lib.nbases_(file, &bases) != CG_OK) return broken("the bases cannot be read");
    if (bases != 1)
        return fail(ErrorKind::unsupported, "has " + std::to_string(bases) + " bases, not one", name, {},
                    "give a file of one base");
    if (lib.base_read_(file, 1, text.data(), &zones.cell_dimension, &zones.physical_dimension) != CG_OK ||
        lib.nzones_(file, 1, &count) != CG_OK)
        return broken("the base cannot be read");
    if (zones.physical_dimension != 2 && zones.physical_dimension != 3)
        return fail(ErrorKind::unsupported,
                    "is in " + std::to_string(zones.physical_dimension) + " dimensions, not 2 or 3", name);
    std::string names;
    std::size_t vertices = 0;
    for (int z = 1; z <= count; ++z) {
        cgsize_t size[9]{};
        if (lib.zone_read_(file, 1, z, text.data(), size) != CG_OK) return broken("the zone cannot be read");
        names += (names.empty() ? "" : ", ") + std::string(text.data());
        if (!requested.empty() && requested != text.data() && requested != std::to_string(z)) continue;
        auto zone = zone_of(lib, file, z, name);
        if (!zone) return fail(std::move(zone.error()));
        vertices += zone->vertices;
        zones.chosen.push_back(std::move(*zone));
    }
    if (zones.chosen.empty())
        return fail(ErrorKind::input, requested.empty() ? "has no zone" : "has no zone " + in_quotes(requested), name,
                    {}, names.empty() ? "the file is damaged" : "its zones are " + names);
    if (vertices > max_entities) return fail(ErrorKind::unsupported, "has more vertices than 32 bits can number", name);
    return zones;
}

}  // namespace

}  // namespace camber::cgns

namespace camber {

bool has_cgns_support() { return true; }

Outcome<DecodedMesh> decode_cgns(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                 const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const cgns::Library& lib = cgns::library();
        if (!lib.missing.empty()) return fail(cgns::no_library(lib.missing));
        const std::scoped_lock alone(cgns::library_lock());
        std::optional<cgns::TemporaryFolder> folder;
        const std::string title(name);
        const auto path = cgns::path_of(bytes, title, folder);
        if (!path) return fail(path.error());
        if (auto within_budget = cgns::check_nodes(lib, *path, bytes.size(), title); !within_budget)
            return fail(std::move(within_budget.error()));
        int file = 0;
        if (cgns::open_to_read(lib, *path, file) != CG_OK)
            return fail(cgns::error_of(lib.get_error_(), ErrorKind::input, "the file cannot be opened as CGNS", title));
        const cgns::OpenFile open(lib, file);
        const auto zones = cgns::zones_of(lib, file, options.zone, title);
        if (!zones) return fail(zones.error());
        const auto read = [&]<int D>() {
            cgns::Reader<D> reader{lib, file, zones->cell_dimension, UnpackedBudget(bytes.size())};
            reader.mesh.name = title;
            return cgns::read_mesh(std::move(reader), *zones, options.unsupported_cells, execution);
        };
        return zones->physical_dimension == 2 ? read.template operator()<2>() : read.template operator()<3>();
    });
}

}  // namespace camber

module;
#include "cgns_library.hpp"
#include "cgns_temporary.hpp"

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
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

namespace camber {

namespace cgns {

namespace {

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

template <int D>
Outcome<Done> read_points(Reader<D>& of, std::size_t n) {
    int coordinates = 0;
    if (of.lib.ncoords_(of.file, 1, 1, &coordinates) != CG_OK) return of.broken("the coordinates cannot be read");
    if (coordinates < D)
        return fail(ErrorKind::input,
                    "the zone has " + std::to_string(coordinates) + " coordinates, not " + std::to_string(D),
                    of.mesh.name);
    if (auto bearable = of.announced(n * (D + 1), "the zone's vertices"); !bearable) return bearable;
    of.mesh.points.resize(n);
    of.mesh.point_references.assign(n, 0);
    Buffer<double> column(n);
    constexpr std::array names{"CoordinateX", "CoordinateY", "CoordinateZ"};
    const cgsize_t first = 1, last = static_cast<cgsize_t>(n);
    for (int c = 0; c < D && n > 0; ++c) {
        if (of.lib.coord_read_(of.file, 1, 1, names[c], CGNS_ENUMV(RealDouble), &first, &last, column.data()) != CG_OK)
            return of.broken(std::string(names[c]) + " cannot be read");
        for (std::size_t v = 0; v < n; ++v) of.mesh.points[v][c] = column[v];
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

template <int D>
Outcome<DecodedMesh> read_mesh(Reader<D> of, std::size_t vertices, const Execution& execution) {
    auto done = read_points(of, vertices)
                    .and_then([&](Done) { return read_sections(of); })
                    .and_then([&](Done) { return read_conditions(of); })
                    .and_then([&](Done) { return read_fields(of); });
    if (!done) return fail(std::move(done.error()));
    if (of.points_listed > 0)
        of.notices.push_back({std::to_string(of.points_listed) + " elements of kind NODE were skipped"});
    name_origins(of.mesh);
    if (auto sound = listing::check(of.mesh, execution); !sound) return fail(std::move(sound.error()));
    return listing::assembled(std::move(of.mesh), listing::MidNodeKind::on_curve, std::move(of.notices), execution);
}

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

int open_to_read(const Library& lib, const std::string& path, int& file) {
    CAMBER_CGNS_KEEPS;
    return lib.open_(path.c_str(), CG_MODE_READ, &file);
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
        if (auto bearable = cgns::check_nodes(lib, *path, bytes.size(), title); !bearable)
            return fail(std::move(bearable.error()));
        int file = 0;
        if (cgns::open_to_read(lib, *path, file) != CG_OK)
            return fail(cgns::error_of(lib.get_error_(), ErrorKind::input, "the file cannot be opened as CGNS", title));
        const cgns::OpenFile open(lib, file);
        const auto zone = cgns::zone_of(lib, file, title);
        if (!zone) return fail(zone.error());
        const auto read = [&]<int D>() {
            cgns::Reader<D> reader{lib, file, zone->cell_dimension, UnpackedBudget(bytes.size())};
            reader.mesh.name = title;
            return cgns::read_mesh(std::move(reader), zone->vertices, execution);
        };
        return zone->physical_dimension == 2 ? read.template operator()<2>() : read.template operator()<3>();
    });
}

}  // namespace camber

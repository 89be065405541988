module;
#include "cgns_library.hpp"
#include "cgns_temporary.hpp"

#include <dlfcn.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <ios>
#include <limits>
#include <map>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

namespace camber::cgns {

namespace {

/// Throws std::bad_alloc if 48 MiB of address space are not available: the CGNS and HDF5 libraries crash if an
/// allocation fails.
void require_memory() {
    constexpr std::size_t room = std::size_t{48} << 20U;
    void* const probe = mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (probe == MAP_FAILED) throw std::bad_alloc();
    munmap(probe, room);
}

void* open_library() {
    // Tries the path known at build time, then any library of the same version that the loader finds.
    for (const char* const name : {CAMBER_CGNS_LIBRARY, CAMBER_CGNS_SONAME})
        if (void* const handle = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return handle;
    return nullptr;
}

Library loaded() {
    Library lib;
    void* const handle = open_library();
    if (handle == nullptr) {
        const char* const reason = dlerror();
        lib.missing = reason != nullptr ? reason : "no such library";
        return lib;
    }
#define CAMBER_CGNS_LOAD(name)                                                         \
    lib.name##_ = reinterpret_cast<decltype(lib.name##_)>(dlsym(handle, "cg_" #name)); \
    if (lib.name##_ == nullptr) lib.missing = "the library has no cg_" #name;
    CAMBER_CGNS_FUNCTIONS(CAMBER_CGNS_LOAD)
#undef CAMBER_CGNS_LOAD
    const auto load = [&](auto& function, const char* name) {
        function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
        if (function == nullptr) lib.missing = std::string("the library has no ") + name;
    };
    load(lib.node_id, "cgio_get_node_id");
    load(lib.node_dimensions, "cgio_get_dimensions");
    load(lib.open_tree, "cgio_open_file");
    load(lib.close_tree, "cgio_close_file");
    load(lib.root_id, "cgio_get_root_id");
    load(lib.number_of_children, "cgio_number_children");
    load(lib.children_ids, "cgio_children_ids");
    load(lib.data_size, "cgio_get_data_size");
    load(lib.release_id, "cgio_release_id");
    // HDF5's exit handler is disabled, because it crashes if a file could not be written completely.
    if (const auto stay = reinterpret_cast<int (*)()>(dlsym(handle, "H5dont_atexit"))) stay();
    return lib;
}

}  // namespace

const Library& library() {
    require_memory();
    static const Library lib = loaded();
    return lib;
}

std::mutex& library_lock() {
    static std::mutex lock;
    return lock;
}

// ---------------------------------------------------------------- writing

namespace {

Outcome<Chunks> bytes_of_file(const std::string& path) {
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    const auto size = static_cast<std::streamoff>(stream.tellg());
    Buffer<std::byte> bytes(size > 0 ? static_cast<std::size_t>(size) : 0);
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(bytes.data()), size);
    if (!stream || size <= 0) return fail(ErrorKind::write, "the temporary file cannot be read back", path);
    Chunks chunks;
    chunks.push_back(std::move(bytes));
    return chunks;
}

template <int K, int Degree>
constexpr CGNS_ENUMT(ElementType_t) element_type = [] {
    constexpr std::array types{CGNS_ENUMV(BAR_2), CGNS_ENUMV(TRI_3), CGNS_ENUMV(TETRA_4),
                               CGNS_ENUMV(BAR_3), CGNS_ENUMV(TRI_6), CGNS_ENUMV(TETRA_10)};
    return types[K - 1 + 3 * (Degree - 1)];
}();

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;

    Writer(const Library& lib, int file, const Mesh& mesh, const MeshFields& fields, const Execution& execution)
        : lib_(lib),
          file_(file),
          grid_{mesh},
          linear_(grid_.linear()),
          fields_(with_legal_names(fields_in_file(fields), field_names())),
          execution_(execution),
          names_(group_names(linear_)) {}

    Outcome<Done> write() {
        if (grid_.nodes() == 0)
            return fail(ErrorKind::unsupported, "a CGNS zone must have vertices", {}, {}, "use another format");
        const bool surface = linear_.elements.size() == 0 && D == 3;
        const auto cells = static_cast<cgsize_t>(surface ? linear_.facets.size() : linear_.elements.size());
        const std::array<cgsize_t, 3> size{static_cast<cgsize_t>(grid_.nodes()), cells, 0};
        int base = 0, zone = 0;
        if (lib_.base_write_(file_, "Base", surface ? 2 : D, D, &base) != CG_OK ||
            lib_.zone_write_(file_, 1, "Zone", size.data(), CGNS_ENUMV(Unstructured), &zone) != CG_OK)
            return broken("the zone cannot be written");
        auto done = coordinates();
        if (done) done = sections(linear_.elements, false);
        if (done) done = sections(linear_.facets, !surface);
        if constexpr (D == 3)
            if (done) done = sections(linear_.edges, false);
        if (done) done = solution();
        return done;
    }

  private:
    [[nodiscard]] auto broken(std::string_view doing) const {
        return fail(error_of(lib_.get_error_(), ErrorKind::write, doing, {}));
    }

    Outcome<Done> coordinates() {
        constexpr std::array names{"CoordinateX", "CoordinateY", "CoordinateZ"};
        Buffer<double> column(grid_.nodes());
        for (int c = 0; c < D; ++c) {
            auto filled = each(execution_, column.size(), [&](std::size_t n) { column[n] = grid_.point(n)[c]; });
            if (!filled) return filled;
            int ignored = 0;
            if (lib_.coord_write_(file_, 1, 1, CGNS_ENUMV(RealDouble), names[c], column.data(), &ignored) != CG_OK)
                return broken("the coordinates cannot be written");
        }
        return Done{};
    }

    template <int K>
    Outcome<Done> sections(const Simplices<K>& simplices, bool with_conditions) {
        std::map<Reference, std::vector<std::uint32_t>> rows;
        std::vector<Reference> order;
        for (std::size_t s = 0; s < simplices.size(); ++s) {
            auto& of_reference = rows[simplices.references[s]];
            if (of_reference.empty()) order.push_back(simplices.references[s]);
            of_reference.push_back(static_cast<std::uint32_t>(s));
        }
        for (const Reference reference : order)
            if (auto done = section<K>(simplices, rows[reference], reference, with_conditions); !done) return done;
        return Done{};
    }

    template <int K>
    Outcome<Done> section(const Simplices<K>& simplices, const std::vector<std::uint32_t>& rows, Reference reference,
                          bool with_condition) {
        constexpr std::size_t width = Grid<Mesh>::template width<K>;
        if (rows.size() * width > static_cast<std::size_t>(std::numeric_limits<cgsize_t>::max()))
            return fail(ErrorKind::unsupported,
                        "the integers of the installed CGNS library are too small for this "
                        "mesh",
                        {}, {}, "use another format, or a 64-bit CGNS library");
        Buffer<cgsize_t> numbers(rows.size() * width);
        auto filled = each(execution_, rows.size(), [&](std::size_t r) {
            for (std::size_t n = 0; n < width; ++n)
                numbers[r * width + n] = static_cast<cgsize_t>(grid_.template node<K>(simplices, rows[r], n)) + 1;
        });
        if (!filled) return filled;
        const std::array<cgsize_t, 2> range{next_, next_ + static_cast<cgsize_t>(rows.size()) - 1};
        next_ = range[1] + 1;
        const std::string& name = names_.sections.at({K, reference});
        int s = 0;
        if (lib_.section_write_(file_, 1, 1, name.c_str(), element_type<K, Grid<Mesh>::degree>, range[0], range[1], 0,
                                numbers.data(), &s) != CG_OK ||
            lib_.goto_(file_, 1, "Zone_t", 1, "Elements_t", s, "end") != CG_OK || !described(reference))
            return broken("the section " + in_quotes(name) + " cannot be written");
        return with_condition ? condition(names_.conditions.at({K, reference}), range, reference) : Done{};
    }
    [[nodiscard]] bool described(Reference reference) const {
        return lib_.descriptor_write_("reference", std::to_string(reference).c_str()) == CG_OK;
    }

    Outcome<Done> condition(const std::string& name, const std::array<cgsize_t, 2>& range, Reference reference) {
        const auto location = D == 3 ? CGNS_ENUMV(FaceCenter) : CGNS_ENUMV(EdgeCenter);
        int bc = 0;
        if (lib_.boco_write_(file_, 1, 1, name.c_str(), CGNS_ENUMV(BCTypeUserDefined), CGNS_ENUMV(PointRange), 2,
                             range.data(), &bc) != CG_OK ||
            lib_.boco_gridlocation_write_(file_, 1, 1, bc, location) != CG_OK ||
            lib_.goto_(file_, 1, "Zone_t", 1, "ZoneBC_t", 1, "BC_t", bc, "end") != CG_OK || !described(reference))
            return broken("the boundary condition " + in_quotes(name) + " cannot be written");
        return Done{};
    }

    Outcome<Done> solution() {
        if (fields_.empty()) return Done{};
        int s = 0;
        if (lib_.sol_write_(file_, 1, 1, "FlowSolution", CGNS_ENUMV(Vertex), &s) != CG_OK)
            return broken("the solution cannot be written");
        for (const MeshField& field : fields_) {
            const int width = values_per_vertex(field.kind, D);
            if (field.size() != grid_.nodes() * static_cast<std::size_t>(width))
                return fail(ErrorKind::usage,
                            "the field " + in_quotes(field.name) + " does not have one row for each node");
            for (int c = 0; c < width; ++c)
                if (auto done = component(field, c); !done) return done;
        }
        return Done{};
    }
    Outcome<Done> component(const MeshField& field, int c) {
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        Buffer<double> column(grid_.nodes());
        auto filled = std::visit(
            [&](const auto& values) {
                return each(execution_, column.size(), [&](std::size_t n) {
                    column[n] = static_cast<double>(values[n * width + static_cast<std::size_t>(c)]);
                });
            },
            field.values);
        if (!filled) return filled;
        const std::string name = field.kind == FieldKind::vector ? field.name + "XYZ"[c] : field.name;
        int f = 0;
        if (lib_.field_write_(file_, 1, 1, 1, CGNS_ENUMV(RealDouble), name.c_str(), column.data(), &f) != CG_OK)
            return broken("the field " + in_quotes(name) + " cannot be written");
        return Done{};
    }

    const Library& lib_;
    int file_;
    Grid<Mesh> grid_;
    const LinearMesh<D>& linear_;
    MeshFields fields_;
    const Execution& execution_;
    cgsize_t next_ = 1;
    GroupNames names_;
};

template <class Mesh>
Outcome<Chunks> encode(const Mesh& mesh, const MeshFields& fields, const Execution& execution) {
    const Library& lib = library();
    if (!lib.missing.empty()) return fail(no_library(lib.missing));
    const std::scoped_lock alone(library_lock());
    const TemporaryFolder folder;
    if (folder.file().empty()) return fail(no_folder(folder.root()));
    const std::string& path = folder.file();
    int file = 0;
    errno = 0;
    if (lib.open_(path.c_str(), CG_MODE_WRITE, &file) != CG_OK)
        return fail(error_of(lib.get_error_(), ErrorKind::write, "the temporary file cannot be created", path));
    auto written = guarded([&] { return Writer<Mesh>(lib, file, mesh, fields, execution).write(); });
    const bool closed = lib.close_(file) == CG_OK;
    if (!written) return fail(std::move(written.error()));
    if (!closed)
        return fail(error_of(lib.get_error_(), ErrorKind::write, "the temporary file cannot be finished", path));
    return bytes_of_file(path);
}

}  // namespace

}  // namespace camber::cgns

namespace camber {

template <int D>
Outcome<Chunks> encode_cgns(const Mesh<D>& mesh, const MeshFields& fields, const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return guarded([&] { return cgns::encode(simplices, fields, execution); });
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Chunks> encode_cgns<D>(const Mesh<D>&, const MeshFields&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber

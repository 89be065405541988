#include "cgns_library.hpp"

#include <dlfcn.h>
#include <sys/mman.h>

#include <cstddef>
#include <mutex>
#include <new>
#include <string>
#include <type_traits>

namespace camber::cgns {

namespace {

/// The libraries of CGNS and HDF5 crash where memory that they need is not to be had. Throws std::bad_alloc where the
/// process has not place for them and their work.
void require_room() {
    constexpr std::size_t room = std::size_t{48} << 20U;
    void* const probe = mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (probe == MAP_FAILED) throw std::bad_alloc();
    munmap(probe, room);
}

void* open_library() {
    // Where it was when Camber was built; else wherever the loader finds one of the same version.
    for (const char* const name : {CAMBER_CGNS_LIBRARY, CAMBER_CGNS_SONAME})
        if (void* const handle = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return handle;
    return nullptr;
}

Library loaded() {
    Library lib;
    void* const handle = open_library();
    if (handle == nullptr) {
        const char* const why = dlerror();
        lib.missing = why != nullptr ? why : "no such library";
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
    // What HDF5 does at the end of a program crashes where a file could not be written to its end.
    if (const auto stay = reinterpret_cast<int (*)()>(dlsym(handle, "H5dont_atexit"))) stay();
    return lib;
}

}  // namespace

const Library& library() {
    require_room();
    static const Library lib = loaded();
    return lib;
}

std::mutex& library_lock() {
    static std::mutex lock;
    return lock;
}

}  // namespace camber::cgns

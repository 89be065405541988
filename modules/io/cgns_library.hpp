// The CGNS Mid-Level Library. It is loaded at first use, because it needs about forty libraries that would slow down
// every program start. This header is private to the io module and independent of all modules, since importers must not
// see cgnslib.h.
#pragma once

#include <cgns_io.h>
#include <cgnslib.h>

#include <string>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#include <sanitizer/lsan_interface.h>
/// Disables leak checks in this scope, because the library leaks memory when it reads damaged files.
#define CAMBER_CGNS_KEEPS __lsan::ScopedDisabler keeps
#endif
#endif
#ifndef CAMBER_CGNS_KEEPS
#define CAMBER_CGNS_KEEPS
#endif

namespace camber::cgns {

/// Names of the library's functions without their prefix `cg_`.
// clang-format off
#define CAMBER_CGNS_FUNCTIONS(X) \
    X(open) X(close) X(get_error) X(free) X(nbases) X(base_read) X(base_write) X(nzones) X(zone_type) X(zone_read) \
    X(zone_write) X(ncoords) X(coord_read) X(coord_write) X(nsections) X(section_read) X(section_write) \
    X(elements_read) X(poly_elements_read) X(ElementDataSize) X(npe) X(ElementTypeName) X(nbocos) X(boco_info) \
    X(boco_read) X(boco_write) X(boco_gridlocation_read) X(boco_gridlocation_write) X(nsols) X(sol_info) \
    X(sol_write) X(sol_size) X(nfields) X(field_info) X(field_read) X(field_write) X(goto) X(ndescriptors) \
    X(descriptor_read) X(descriptor_write) X(boco_id) X(get_cgio) X(nconns)
// clang-format on

struct Library {
#define CAMBER_CGNS_MEMBER(name) decltype(&::cg_##name) name##_ = nullptr;
    CAMBER_CGNS_FUNCTIONS(CAMBER_CGNS_MEMBER)
#undef CAMBER_CGNS_MEMBER
    decltype(&::cgio_get_node_id) node_id = nullptr;
    decltype(&::cgio_get_dimensions) node_dimensions = nullptr;
    decltype(&::cgio_open_file) open_tree = nullptr;
    decltype(&::cgio_close_file) close_tree = nullptr;
    decltype(&::cgio_get_root_id) root_id = nullptr;
    decltype(&::cgio_number_children) number_of_children = nullptr;
    decltype(&::cgio_children_ids) children_ids = nullptr;
    decltype(&::cgio_get_data_size) data_size = nullptr;
    decltype(&::cgio_release_id) release_id = nullptr;
    std::string missing;
};

}  // namespace camber::cgns

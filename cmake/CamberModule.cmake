# One module of Camber, like a crate's manifest:
#
#   camber_module(NAME
#       INTERFACE a.cppm b.cppm …     its interface units, installed with it
#       PARTS c.cppm …                interface units that only its implementation units import: not installed
#       IMPL a.cpp …                  its implementation units
#       USES core bezier …            modules of lower floors that its interface imports
#       LINK_PUBLIC tl::expected …    libraries that its interface units include
#       LINK_PRIVATE Eigen3::Eigen …  libraries that only its implementation units include
#       PACKAGES OpenCASCADE …)       packages to find for whoever links it, where the target's name (Package::target) does not tell
#
# makes the static library camber_NAME, alias camber::NAME, and installs it as a component.
include_guard(GLOBAL)

# Warnings are ours alone: they reach neither an embedding project nor whoever imports the installed modules.
add_library(camber_warnings INTERFACE)
target_compile_options(camber_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wconversion -Wno-sign-conversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-align
    -Woverloaded-virtual -Wextra-semi -Wimplicit-fallthrough -Wnewline-eof -Wundef
    -Wno-psabi) # functions of packs (core:tensors) are always inlined: no call passes one

# What must agree between everything that sees a module: C++20 without extensions, threads, and sums that are not fused behind our back
# (validity is decided by rounding errors that are accounted for).
function(camber_common TARGET)
    target_compile_features(${TARGET} PUBLIC cxx_std_20)
    set_target_properties(${TARGET} PROPERTIES CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF CXX_SCAN_FOR_MODULES ON)
    target_compile_options(${TARGET} PUBLIC -pthread -ffp-contract=off)
    target_link_options(${TARGET} PUBLIC -pthread)
    target_link_libraries(${TARGET} PRIVATE $<BUILD_INTERFACE:camber_warnings> PUBLIC $<BUILD_INTERFACE:camber_header_module>)
endfunction()

# What find_package wants to hear for a library; a package that is not here needs no more than its name.
set(CAMBER_FIND_Boost Boost 1.74 CONFIG) # Multiprecision
set(CAMBER_FIND_Eigen3 Eigen3 3.4 NO_MODULE)
set(CAMBER_FIND_tl tl-expected)

# camber_find(Package::target …): the packages of libraries that are not there yet. Each module asks for its own, so that whoever embeds
# one needs what that one needs, and nothing else.
function(camber_find)
    foreach(library IN LISTS ARGN)
        if(TARGET ${library} OR NOT library MATCHES "^(.+)::")
            continue()
        endif()
        set(package ${CMAKE_MATCH_1})
        if(DEFINED CAMBER_FIND_${package})
            set(package ${CAMBER_FIND_${package}})
        endif()
        find_package(${package} REQUIRED)
    endforeach()
endfunction()

# camber_with_used(LIST): the modules in LIST and all that they use, by their manifests, in the order of the floors.
function(camber_with_used LIST)
    set(wanted "${${LIST}}")
    set(floors ${camber_floors})
    foreach(name IN LISTS wanted)
        if(NOT name IN_LIST floors)
            list(JOIN floors ", " names)
            message(FATAL_ERROR "CAMBER_MODULES: there is no module '${name}'; there are ${names}")
        endif()
    endforeach()
    list(REVERSE floors)
    foreach(name IN LISTS floors)
        if(name IN_LIST wanted)
            file(READ "${PROJECT_SOURCE_DIR}/modules/${name}/CMakeLists.txt" manifest)
            if(manifest MATCHES "USES ([a-z_ ]+)")
                string(REPLACE " " ";" used "${CMAKE_MATCH_1}")
                list(APPEND wanted ${used})
            endif()
        endif()
    endforeach()
    set(found "")
    foreach(name IN LISTS camber_floors)
        if(name IN_LIST wanted)
            list(APPEND found ${name})
        endif()
    endforeach()
    set(${LIST} "${found}" PARENT_SCOPE)
endfunction()

# Headers and nothing else: who links an installed module does not need them.
set(CAMBER_HEADER_ONLY Boost::headers Eigen3::Eigen range-v3::range-v3 nlohmann_json::nlohmann_json fmt::fmt-header-only CLI11::CLI11)

function(camber_module NAME)
    cmake_parse_arguments(PARSE_ARGV 1 MODULE "" "" "INTERFACE;PARTS;IMPL;USES;LINK_PUBLIC;LINK_PRIVATE;PACKAGES")
    if(MODULE_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "camber_module(${NAME}): unknown: ${MODULE_UNPARSED_ARGUMENTS}")
    endif()
    set(target camber_${NAME})
    add_library(${target} STATIC)
    add_library(camber::${NAME} ALIAS ${target})
    camber_common(${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${NAME})
    target_sources(${target} PUBLIC FILE_SET CXX_MODULES FILES ${MODULE_INTERFACE} PRIVATE ${MODULE_IMPL})
    if(MODULE_PARTS)
        target_sources(${target} PRIVATE FILE_SET parts TYPE CXX_MODULES FILES ${MODULE_PARTS})
    endif()

    foreach(used IN LISTS MODULE_USES)
        if(NOT TARGET camber::${used})
            message(FATAL_ERROR "camber_module(${NAME}): uses '${used}', which is not on a lower floor")
        endif()
        target_link_libraries(${target} PUBLIC camber::${used})
    endforeach()

    camber_find(${MODULE_LINK_PUBLIC} ${MODULE_LINK_PRIVATE})
    set(packages ${MODULE_PACKAGES})
    foreach(library IN LISTS MODULE_LINK_PUBLIC MODULE_LINK_PRIVATE)
        if(library IN_LIST MODULE_LINK_PUBLIC)
            target_link_libraries(${target} PUBLIC ${library})
        elseif(library IN_LIST CAMBER_HEADER_ONLY)
            target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:${library}>)
            continue()
        else()
            target_link_libraries(${target} PRIVATE ${library})
        endif()
        if(library MATCHES "^(.+)::")
            set(package ${CMAKE_MATCH_1})
            if(package STREQUAL "tl")
                set(package tl-expected)
            endif()
            list(APPEND packages ${package})
        endif()
    endforeach()
    list(REMOVE_DUPLICATES packages)

    set_property(GLOBAL APPEND PROPERTY CAMBER_MODULES ${NAME})
    set_property(GLOBAL PROPERTY CAMBER_USES_${NAME} "${MODULE_USES}")
    set_property(GLOBAL PROPERTY CAMBER_PACKAGES_${NAME} "${packages}")
    set_property(GLOBAL PROPERTY CAMBER_LIBRARIES_${NAME} ${MODULE_LINK_PUBLIC} ${MODULE_LINK_PRIVATE})

    if(CAMBER_INSTALL)
        install(TARGETS ${target} EXPORT camberTargets
            ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
            FILE_SET CXX_MODULES DESTINATION "${CAMBER_INSTALL_MODULES}/${NAME}")
    endif()
endfunction()

# camber_install(): once, after the last module: the package file, with one component a module.
function(camber_install)
    include(CMakePackageConfigHelpers)
    get_property(CAMBER_MODULES GLOBAL PROPERTY CAMBER_MODULES)
    set(CAMBER_MANIFEST "")
    foreach(name IN LISTS CAMBER_MODULES)
        get_property(uses GLOBAL PROPERTY CAMBER_USES_${name})
        get_property(packages GLOBAL PROPERTY CAMBER_PACKAGES_${name})
        list(JOIN uses " " uses)
        list(JOIN packages " " packages)
        string(APPEND CAMBER_MANIFEST "set(_camber_uses_${name} ${uses})\nset(_camber_packages_${name} ${packages})\n")
    endforeach()
    set(destination "${CMAKE_INSTALL_LIBDIR}/cmake/camber")
    configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/camberConfig.cmake.in" "${PROJECT_BINARY_DIR}/camberConfig.cmake"
        INSTALL_DESTINATION "${destination}" NO_SET_AND_CHECK_MACRO)
    write_basic_package_version_file("${PROJECT_BINARY_DIR}/camberConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
    install(FILES "${PROJECT_BINARY_DIR}/camberConfig.cmake" "${PROJECT_BINARY_DIR}/camberConfigVersion.cmake"
        "${PROJECT_SOURCE_DIR}/cmake/HeaderModule.cmake" "${PROJECT_SOURCE_DIR}/cmake/Toolchain.cmake" DESTINATION "${destination}")
    install(EXPORT camberTargets NAMESPACE camber:: DESTINATION "${destination}" CXX_MODULES_DIRECTORY modules)
endfunction()

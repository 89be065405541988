# Parts that a build can lack, because their libraries are optional. CMake writes the list of parts to parts.inc in the build directory, which
# `camber --version --verbose` contains and `./x build` reads.
include_guard(GLOBAL)

# camber_version(OUT HEADER MACRO…): sets OUT to the numbers that these macros of HEADER define, joined by dots.
function(camber_version OUT HEADER)
    set(${OUT} "(unknown version)" PARENT_SCOPE)
    if(NOT EXISTS "${HEADER}")
        return()
    endif()
    file(READ "${HEADER}" text)
    set(numbers "")
    foreach(macro IN LISTS ARGN)
        string(REGEX MATCH "#define +${macro} +\"?([0-9.]+)" found "${text}")
        list(APPEND numbers "${CMAKE_MATCH_1}")
    endforeach()
    list(JOIN numbers "." numbers)
    set(${OUT} "${numbers}" PARENT_SCOPE)
endfunction()

# camber_part(NAME LIBRARIES): adds a part to the list. LIBRARIES: its libraries with their versions; empty if the part is missing.
function(camber_part NAME LIBRARIES)
    set(command "")
    if(NOT LIBRARIES)
        string(TOLOWER "${CMAKE_BUILD_TYPE}" preset)
        string(REGEX REPLACE "(.+)" " \\1" preset "${preset}")
        string(REPLACE " release" "" preset "${preset}") # the default
        set(command "./x setup && ./x build${preset}")
    endif()
    set_property(GLOBAL APPEND_STRING PROPERTY CAMBER_PARTS "{\"${NAME}\", \"${LIBRARIES}\", \"${command}\"},\n")
endfunction()

# camber_write_parts(): writes the list, after the last part.
function(camber_write_parts)
    get_property(parts GLOBAL PROPERTY CAMBER_PARTS)
    file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/parts.inc" CONTENT "${parts}" @ONLY)
endfunction()

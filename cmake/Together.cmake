# camber_units(TARGET IMPL a.cpp … [INTERFACE a.cppm …]): the implementation units of TARGET, several compiled as one text where they go
# together (together.py tells when, and why): most of what a unit costs is to read what it imports. INTERFACE: the module's own interface
# units. A unit with definitions of its own, set before, stays alone.
#
# On where Camber is the project itself. CAMBER_TOGETHER=OFF compiles each unit by itself: for whoever changes one again and again.
include_guard(GLOBAL)

option(CAMBER_TOGETHER "Compile several implementation units as one text" ${PROJECT_IS_TOP_LEVEL})
set(CAMBER_TOGETHER_LINES 1200 CACHE STRING "Lines of such a text, about: longer ones leave a processor waiting at the end")
mark_as_advanced(CAMBER_TOGETHER_LINES)
if(CAMBER_TOGETHER)
    find_program(CAMBER_TOGETHER_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH) # the system's begins quicker than a wrapper
    find_program(CAMBER_TOGETHER_PYTHON python3)
    mark_as_advanced(CAMBER_TOGETHER_PYTHON)
endif()

set(camber_together_script "${CMAKE_CURRENT_LIST_DIR}/together.py")
set(camber_together_folder "${PROJECT_BINARY_DIR}/together")

# camber_sources(TARGET INTERFACE a.cppm … IMPL a.cpp …): all units of a module.
function(camber_sources TARGET)
    cmake_parse_arguments(PARSE_ARGV 1 SOURCES "" "" "IMPL;INTERFACE")
    target_sources(${TARGET} PUBLIC FILE_SET CXX_MODULES BASE_DIRS "${CMAKE_CURRENT_SOURCE_DIR}" FILES ${SOURCES_INTERFACE})
    camber_units(${TARGET} IMPL ${SOURCES_IMPL} INTERFACE ${SOURCES_INTERFACE})
endfunction()

function(camber_units TARGET)
    cmake_parse_arguments(PARSE_ARGV 1 UNITS "" "" "IMPL;INTERFACE")
    list(LENGTH UNITS_IMPL count)
    if(NOT CAMBER_TOGETHER OR NOT CAMBER_TOGETHER_PYTHON OR count LESS 2)
        target_sources(${TARGET} PRIVATE ${UNITS_IMPL})
        return()
    endif()
    foreach(unit IN LISTS UNITS_IMPL)
        get_source_file_property(own "${unit}" COMPILE_DEFINITIONS)
        if(own)
            list(REMOVE_ITEM UNITS_IMPL "${unit}")
            target_sources(${TARGET} PRIVATE "${unit}")
        endif()
    endforeach()
    foreach(list IN ITEMS UNITS_IMPL UNITS_INTERFACE)
        set(paths "")
        foreach(path IN LISTS ${list})
            cmake_path(ABSOLUTE_PATH path)
            list(APPEND paths "${path}")
        endforeach()
        set(${list} ${paths})
    endforeach()
    execute_process(
        COMMAND ${CAMBER_TOGETHER_PYTHON} ${camber_together_script} group ${CAMBER_TOGETHER_LINES} ${UNITS_IMPL} --beside ${UNITS_INTERFACE}
        OUTPUT_VARIABLE texts OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" ";" texts "${texts}")

    # Touched where units no longer go together: CMake runs again, and groups them anew.
    set(stamp "${camber_together_folder}/stamp")
    if(NOT EXISTS "${stamp}")
        file(MAKE_DIRECTORY "${camber_together_folder}")
        file(TOUCH "${stamp}")
    endif()
    set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${stamp}" "${camber_together_script}")
    set(number 0)
    foreach(text IN LISTS texts)
        string(REPLACE "|" ";" units "${text}")
        list(LENGTH units count)
        if(count EQUAL 1)
            target_sources(${TARGET} PRIVATE ${units})
            continue()
        endif()
        math(EXPR number "${number} + 1")
        set(out "${camber_together_folder}/${TARGET}-${number}.cpp")
        add_custom_command(OUTPUT "${out}"
            COMMAND ${CAMBER_TOGETHER_PYTHON} ${camber_together_script} write "${out}" ${units} --beside ${UNITS_INTERFACE}
            DEPENDS ${units} ${UNITS_INTERFACE} "${camber_together_script}" COMMENT "Writing together/${TARGET}-${number}.cpp" VERBATIM)
        target_sources(${TARGET} PRIVATE "${out}")
    endforeach()
endfunction()

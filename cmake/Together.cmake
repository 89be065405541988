# camber_sources(TARGET INTERFACE a.cppm … [PARTS b.cppm …] IMPL a.cpp …): all units of a module, several compiled as one text where they go
# together (together.py tells when, and why): most of what a unit costs is to read what it imports. PARTS: interface units that only its
# implementation units import, and which are not installed.
#
# camber_units(TARGET IMPL a.cpp … [INTERFACE a.cppm …]): the same of implementation units alone. INTERFACE: the module's own interface units.
# A unit with definitions of its own, set before, stays alone.
#
# On where Camber is the project itself. CAMBER_TOGETHER=OFF compiles each unit by itself: for whoever changes one again and again.
include_guard(GLOBAL)

option(CAMBER_TOGETHER "Compile several units as one text" ${PROJECT_IS_TOP_LEVEL})
set(CAMBER_TOGETHER_LINES 1200 CACHE STRING "Lines of a text of implementation units, about: longer ones leave a processor waiting at the end")
mark_as_advanced(CAMBER_TOGETHER_LINES)
set(camber_together FALSE)
if(CAMBER_TOGETHER)
    find_program(CAMBER_TOGETHER_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH) # the system's begins quicker than a wrapper
    find_program(CAMBER_TOGETHER_PYTHON python3)
    mark_as_advanced(CAMBER_TOGETHER_PYTHON)
    if(CAMBER_TOGETHER_PYTHON)
        set(camber_together TRUE)
    endif()
endif()

set(camber_together_script "${CMAKE_CURRENT_LIST_DIR}/together.py")
set(camber_together_folder "${PROJECT_BINARY_DIR}/together")
set(camber_together_install "${camber_together_folder}/install") # interfaces as they are installed, in files of the same names
if(camber_together)
    # Touched where units no longer go together: CMake runs again, and groups them anew.
    file(MAKE_DIRECTORY "${camber_together_install}")
    if(NOT EXISTS "${camber_together_folder}/stamp")
        file(TOUCH "${camber_together_folder}/stamp")
    endif()
    set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
        "${camber_together_folder}/stamp" "${camber_together_script}")
endif()

# camber_ask_together(RESULT word …): what together.py answers, as a list.
function(camber_ask_together RESULT)
    execute_process(COMMAND ${CAMBER_TOGETHER_PYTHON} ${camber_together_script} ${ARGN}
        OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" ";" answer "${answer}")
    set(${RESULT} "${answer}" PARENT_SCOPE)
endfunction()

# camber_text(TEXT UNITS a … [BESIDE b …] [INSTALL]): TEXT in the folder of texts is made of these units. DEPENDS_EXPLICIT_ONLY: else it
# waits until all that the target links is built.
function(camber_text TEXT)
    cmake_parse_arguments(PARSE_ARGV 1 TEXT "INSTALL" "" "UNITS;BESIDE")
    set(outputs "${camber_together_folder}/${TEXT}")
    set(install "")
    if(TEXT_INSTALL)
        list(APPEND outputs "${camber_together_install}/${TEXT}")
        set(install --install "${camber_together_install}/${TEXT}")
    endif()
    add_custom_command(OUTPUT ${outputs}
        COMMAND ${CAMBER_TOGETHER_PYTHON} ${camber_together_script} write "${camber_together_folder}/${TEXT}" ${TEXT_UNITS} --beside ${TEXT_BESIDE} ${install}
        DEPENDS ${TEXT_UNITS} ${TEXT_BESIDE} "${camber_together_script}" DEPENDS_EXPLICIT_ONLY COMMENT "Writing together/${TEXT}" VERBATIM)
endfunction()

# camber_absolute(LIST …): the paths in these lists are absolute from now on.
function(camber_absolute)
    foreach(list IN LISTS ARGN)
        set(paths "")
        foreach(path IN LISTS ${list})
            cmake_path(ABSOLUTE_PATH path)
            list(APPEND paths "${path}")
        endforeach()
        set(${list} "${paths}" PARENT_SCOPE)
    endforeach()
endfunction()

function(camber_sources TARGET)
    cmake_parse_arguments(PARSE_ARGV 1 SOURCES "" "" "IMPL;INTERFACE;PARTS")
    set(interface ${SOURCES_INTERFACE})
    set(parts ${SOURCES_PARTS})
    set(folder "${CMAKE_CURRENT_SOURCE_DIR}")
    if(camber_together)
        camber_interface(${TARGET} interface parts ${SOURCES_INTERFACE} ${SOURCES_PARTS})
        set(folder "${camber_together_folder}")
    endif()
    target_sources(${TARGET} PUBLIC FILE_SET CXX_MODULES BASE_DIRS "${folder}" FILES ${interface})
    if(parts)
        target_sources(${TARGET} PRIVATE FILE_SET parts TYPE CXX_MODULES BASE_DIRS "${folder}" FILES ${parts})
    endif()
    camber_units(${TARGET} IMPL ${SOURCES_IMPL} INTERFACE ${SOURCES_INTERFACE} ${SOURCES_PARTS})
endfunction()

# camber_interface(TARGET INTERFACE PARTS a.cppm …): the text of the module's interface, and those of what only its implementation imports.
function(camber_interface TARGET INTERFACE PARTS)
    set(all ${ARGN})
    camber_absolute(all)
    camber_ask_together(alone interfaces ${all})
    list(POP_FRONT alone units)
    string(REPLACE "|" ";" units "${units}")
    camber_text(${TARGET}.cppm UNITS ${units} BESIDE ${all} INSTALL)
    set(parts "")
    foreach(unit IN LISTS alone)
        cmake_path(GET unit STEM name)
        camber_text(${TARGET}-${name}.cppm UNITS ${unit} BESIDE ${all})
        list(APPEND parts "${camber_together_folder}/${TARGET}-${name}.cppm")
    endforeach()
    set(${INTERFACE} "${camber_together_folder}/${TARGET}.cppm" PARENT_SCOPE)
    set(${PARTS} "${parts}" PARENT_SCOPE)
endfunction()

function(camber_units TARGET)
    cmake_parse_arguments(PARSE_ARGV 1 UNITS "" "" "IMPL;INTERFACE")
    if(NOT camber_together)
        target_sources(${TARGET} PRIVATE ${UNITS_IMPL})
        return()
    endif()
    camber_absolute(UNITS_INTERFACE)
    set(together "")
    set(number 0)
    foreach(unit IN LISTS UNITS_IMPL)
        get_source_file_property(own "${unit}" COMPILE_DEFINITIONS)
        camber_absolute(unit)
        if(own)
            cmake_path(GET unit STEM name)
            camber_one_text(${TARGET} ${TARGET}-${name}.cpp "${unit}" "${UNITS_INTERFACE}")
            set_property(SOURCE "${camber_together_folder}/${TARGET}-${name}.cpp" PROPERTY COMPILE_DEFINITIONS "${own}")
        else()
            list(APPEND together "${unit}")
        endif()
    endforeach()
    if(together)
        camber_ask_together(together group ${CAMBER_TOGETHER_LINES} ${together} --beside ${UNITS_INTERFACE})
    endif()
    foreach(text IN LISTS together)
        string(REPLACE "|" ";" units "${text}")
        math(EXPR number "${number} + 1")
        camber_one_text(${TARGET} ${TARGET}-${number}.cpp "${units}" "${UNITS_INTERFACE}")
    endforeach()
endfunction()

# A unit of no module, alone, is what it is; of a module, it imports partitions that are no longer there.
function(camber_one_text TARGET TEXT UNITS INTERFACE)
    list(LENGTH UNITS count)
    if(count EQUAL 1 AND NOT INTERFACE)
        target_sources(${TARGET} PRIVATE ${UNITS})
        return()
    endif()
    camber_text(${TEXT} UNITS ${UNITS} BESIDE ${INTERFACE})
    target_sources(${TARGET} PRIVATE "${camber_together_folder}/${TEXT}")
endfunction()

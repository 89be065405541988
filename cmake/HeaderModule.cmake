# camber_header_module: an interface library that gives a unit the standard library's headers compiled once, as one clang header
# module, instead of a copy of their text in each unit: merging those copies was most of what a unit cost. The sources know nothing
# of it; `#include <vector>` is written as ever, and means an import where this is on.
#
# camber_compile_once does the same with headers of other libraries that many units include.
#
# On for Camber itself and for who embeds it, unless CAMBER_HEADER_MODULE is off (docs/embedding.md). The price is that a missing `#include`
# of a standard header goes unnoticed: tests/includes looks for those of Camber.
include_guard(GLOBAL)

add_library(camber_header_module INTERFACE)

set(camber_standard_headers
    algorithm array atomic bit cctype cerrno charconv chrono climits cmath compare concepts csignal cstddef cstdint cstdio cstdlib cstring
    deque exception filesystem fstream functional initializer_list iomanip ios iosfwd istream iterator limits list locale map memory
    memory_resource mutex new numbers numeric optional ostream queue random ranges ratio set shared_mutex span sstream stack stdexcept
    stop_token string string_view system_error thread tuple type_traits typeinfo unordered_map unordered_set utility valarray variant vector version)

# The folder of libstdc++'s headers, from the preprocessor's own line for <vector>; empty for another library.
function(camber_standard_folder RESULT)
    set(probe "${PROJECT_BINARY_DIR}/CMakeFiles/vector.cpp")
    file(WRITE "${probe}" "#include <vector>\n")
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} ${ARGN} -E "${probe}" OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE failed)
    set(${RESULT} "" PARENT_SCOPE)
    if(NOT failed AND text MATCHES "# 1 \"([^\"]*/c\\+\\+/[0-9.]+)/vector\"")
        set(${RESULT} "${CMAKE_MATCH_1}" PARENT_SCOPE)
    endif()
endfunction()

function(camber_make_header_module)
    get_property(several GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
    if(several)
        return() # its flags would be those of one configuration
    endif()
    string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
    separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}}")
    set(dialect gnu++)
    if(DEFINED CMAKE_CXX_EXTENSIONS AND NOT CMAKE_CXX_EXTENSIONS)
        set(dialect c++)
    endif()
    set(standard 20)
    if(CMAKE_CXX_STANDARD GREATER 20)
        set(standard ${CMAKE_CXX_STANDARD})
    endif()
    list(APPEND flags -std=${dialect}${standard} -pthread -ffp-contract=off)
    camber_standard_folder(folder ${flags})
    if(NOT folder)
        message(STATUS "CAMBER_HEADER_MODULE: not libstdc++, so each unit reads the standard headers itself")
        return()
    endif()

    set(headers "")
    foreach(name IN LISTS camber_standard_headers)
        if(EXISTS "${folder}/${name}")
            list(APPEND headers "${folder}/${name}")
        endif()
    endforeach()
    set(CAMBER_HEADER_FLAGS "${flags}" PARENT_SCOPE)
    camber_compile_header_module(camber_header_module camber_headers "${flags}"
        "-fmodules;-fno-implicit-modules;-fno-implicit-module-maps" "${headers}")
endfunction()

# camber_compile_header_module(TARGET NAME FLAGS MODULES HEADERS): the module NAME of HEADERS, whose users TARGET gives MODULES and itself.
function(camber_compile_header_module TARGET NAME FLAGS MODULES HEADERS)
    list(JOIN HEADERS "\"\n    header \"" lines)
    set(map "module ${NAME} [system] {\n    header \"${lines}\"\n    export *\n}\n")

    # Another compiler, other flags or other headers are another file, and so other flags for every unit: all is compiled again.
    file(REAL_PATH "${CMAKE_CXX_COMPILER}" compiler)
    set(watched "${compiler}" ${HEADERS})
    set(key "${CMAKE_CXX_COMPILER_VERSION} ${FLAGS} ${MODULES} ${map}")
    foreach(file IN LISTS watched)
        file(TIMESTAMP "${file}" time)
        string(APPEND key " ${time}")
    endforeach()
    set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${watched})
    string(SHA256 key "${key}")
    string(SUBSTRING "${key}" 0 16 key)
    set(folder "${PROJECT_BINARY_DIR}/headers/${NAME}")
    set(stem "${folder}/${key}")
    if(NOT EXISTS "${stem}.pcm")
        file(REMOVE_RECURSE "${folder}")
        file(WRITE "${stem}.modulemap" "${map}")
        execute_process(
            COMMAND ${CMAKE_CXX_COMPILER} ${FLAGS} ${MODULES} -Xclang -emit-module -fmodule-name=${NAME} -x c++ -c "${stem}.modulemap"
                -o "${stem}.part"
            RESULT_VARIABLE failed ERROR_VARIABLE said)
        if(failed)
            message(WARNING "CAMBER_HEADER_MODULE: headers do not compile as the module ${NAME}, so each unit reads them itself:\n${said}")
            return()
        endif()
        file(RENAME "${stem}.part" "${stem}.pcm")
    endif()
    target_compile_options(${TARGET} INTERFACE ${MODULES} "-fmodule-map-file=${stem}.modulemap" "-fmodule-file=${NAME}=${stem}.pcm")
endfunction()

# camber_compile_once(LIBRARY HEADER …): the headers of a library of others compiled once, for all who link it here. Not where Camber is
# embedded: the library is not ours then.
function(camber_compile_once LIBRARY)
    get_target_property(modules camber_header_module INTERFACE_COMPILE_OPTIONS)
    string(MAKE_C_IDENTIFIER "camber_headers_of_${LIBRARY}" name)
    if(NOT PROJECT_IS_TOP_LEVEL OR NOT modules OR TARGET ${name})
        return()
    endif()
    set(headers "")
    foreach(header IN LISTS ARGN)
        unset(found)
        find_path(found "${header}" NO_CACHE)
        string(REGEX REPLACE "(.)/$" "\\1" found "${found}")
        if(NOT found IN_LIST CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
            return() # somewhere else than where the compiler looks by itself
        endif()
        list(APPEND headers "${found}/${header}")
    endforeach()
    add_library(${name} INTERFACE)
    camber_compile_header_module(${name} ${name} "${CAMBER_HEADER_FLAGS}" "${modules}" "${headers}")
    target_link_libraries(${LIBRARY} INTERFACE $<BUILD_INTERFACE:${name}>)
endfunction()

if(CAMBER_HEADER_MODULE)
    camber_make_header_module()
endif()

# camber_toolchain_fault(RESULT): in one sentence, with its remedy, why C++20 modules cannot be compiled with what this project was
# configured by; empty if they can. Also of a project that finds Camber installed. It begins with a blank, so that CMake leaves it one line.
include_guard(GLOBAL)

function(camber_toolchain_fault RESULT)
    set(fault "")
    set(again "configure in a new folder with: cmake -G Ninja -DCMAKE_CXX_COMPILER=clang++-19")
    if(NOT CMAKE_CXX_COMPILER_LOADED)
        set(fault " Camber wants C++: write project(… LANGUAGES CXX) before it is looked for")
    elseif(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR CMAKE_CXX_COMPILER_VERSION VERSION_LESS 18)
        set(fault " Camber wants clang 18 or later, not ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}: ${again}")
    elseif(NOT CMAKE_GENERATOR MATCHES "^Ninja")
        set(fault " Camber wants the generator Ninja, not ${CMAKE_GENERATOR}, which knows no C++20 modules: ${again}")
    elseif(NOT CMAKE_CXX_COMPILER_CLANG_SCAN_DEPS)
        set(fault " Camber wants clang-scan-deps beside ${CMAKE_CXX_COMPILER} (Debian: clang-tools-19): install it and ${again}")
    endif()
    set(${RESULT} "${fault}" PARENT_SCOPE)
endfunction()

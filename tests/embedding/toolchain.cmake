# cmake -DOUTSIDE=… -DBUILD=… -DPREFIX=… -DCOMPILER=… -P toolchain.cmake: the error for toolchains that cannot compile Camber's
# modules is one line with the remedy, also in projects that find Camber installed or use it as a subdirectory.
cmake_minimum_required(VERSION 3.28)
cmake_path(SET root NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../..")
include("${root}/cmake/Toolchain.cmake")

# camber_expect(START ID VERSION GENERATOR SCAN_DEPS): expects an error that begins with START for such a toolchain; empty: none.
function(camber_expect START CMAKE_CXX_COMPILER_ID CMAKE_CXX_COMPILER_VERSION CMAKE_GENERATOR CMAKE_CXX_COMPILER_CLANG_SCAN_DEPS)
    set(CMAKE_CXX_COMPILER_LOADED 1)
    camber_toolchain_fault(fault)
    string(FIND "${fault}" " ${START}" place)
    if(START STREQUAL "" AND fault STREQUAL "")
        return()
    elseif(START STREQUAL "" OR NOT place EQUAL 0 OR fault MATCHES "\n" OR NOT fault MATCHES "cmake -G Ninja -DCMAKE_CXX_COMPILER=clang")
        message(FATAL_ERROR "'${fault}', not '${START}'")
    endif()
endfunction()
camber_expect("" Clang 18.1.0 Ninja /usr/bin/clang-scan-deps)
camber_expect("" Clang 21.0.0 "Ninja Multi-Config" /usr/bin/clang-scan-deps)
camber_expect("Camber wants clang 18 or later, not GNU 14.2.0: " GNU 14.2.0 Ninja "")
camber_expect("Camber wants clang 18 or later, not Clang 17.0.6: " Clang 17.0.6 Ninja "")
camber_expect("Camber wants clang 18 or later, not AppleClang 17.0.0: " AppleClang 17.0.0 Ninja "")
camber_expect("Camber wants the generator Ninja, not Unix Makefiles" Clang 19.1.0 "Unix Makefiles" /usr/bin/clang-scan-deps)
camber_expect("Camber wants clang-scan-deps beside " Clang 19.1.0 Ninja CMAKE_CXX_COMPILER_CLANG_SCAN_DEPS-NOTFOUND)

# A missing scanner can be simulated on every machine.
foreach(option IN ITEMS -DCMAKE_PREFIX_PATH=${PREFIX} -DCAMBER_SOURCE=${root})
    file(REMOVE_RECURSE "${BUILD}")
    execute_process(COMMAND "${CMAKE_COMMAND}" -S "${OUTSIDE}" -B "${BUILD}" -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER}
            -DCMAKE_CXX_COMPILER_CLANG_SCAN_DEPS= -DCAMBER_WANTED=core ${option}
        RESULT_VARIABLE failed ERROR_VARIABLE said OUTPUT_QUIET)
    if(NOT failed OR NOT said MATCHES "\n +Camber wants clang-scan-deps beside [^\n]+: install it and [^\n]+clang\\+\\+-19\n")
        message(FATAL_ERROR "${option}: ${failed}\n${said}")
    endif()
endforeach()

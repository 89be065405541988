# camber_test(NAME SOURCES a.cpp … USES core … [LINK library …] [LABELS …])
#   the executable test_NAME (doctest and RapidCheck), known to CTest as NAME. The sources may include "property.hpp" (tests/support/),
#   and find CAMBER_TEST_DIR (the folder of the CMakeLists.txt that calls this) and CAMBER_SOURCE_DIR defined.
# camber_example(NAME)
#   the executable example_NAME from modules/NAME/example.cpp, which sees only the module and those that its interface imports; known to
#   CTest as example_NAME, and failed by an exit code other than 0: each example judges its own result.
# camber_bench(NAME SOURCES a.cpp … USES core … [LINK library …])
#   the executable bench_NAME (Google Benchmark).
# camber_program(NAME SOURCES a.cpp … USES core … [LINK library …])
#   the executable NAME that measures something and takes arguments; neither a test nor a benchmark. It may include what is in
#   tests/support/.
include_guard(GLOBAL)

# Not -O0: the linker can take a test's copy of an inline function for the whole program.
set(CAMBER_TEST_OPTIMISATION "-O1" CACHE STRING "Optimisation of test units; the modules that they test keep that of the build")

# Benchmarks that are only to compile and link, as for `.ci/run`, need none: -O0.
set(CAMBER_BENCH_OPTIMISATION "" CACHE STRING "Optimisation of benchmarks; empty: that of the build")

function(camber_test NAME)
    cmake_parse_arguments(PARSE_ARGV 1 TEST "" "" "SOURCES;USES;LINK;LABELS")
    if(TEST_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "camber_test(${NAME}): unknown: ${TEST_UNPARSED_ARGUMENTS}")
    endif()
    set(target test_${NAME})
    add_executable(${target} ${TEST_SOURCES})
    camber_common(${target})
    target_compile_options(${target} PRIVATE ${CAMBER_TEST_OPTIMISATION})
    list(TRANSFORM TEST_USES PREPEND camber::)
    target_link_libraries(${target} PRIVATE camber_test_support ${TEST_USES} ${TEST_LINK})
    target_compile_definitions(${target} PRIVATE
        CAMBER_TEST_DIR="${CMAKE_CURRENT_SOURCE_DIR}" CAMBER_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    add_test(NAME ${NAME} COMMAND ${target})
    set_tests_properties(${NAME} PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT 600
        ENVIRONMENT "UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1;ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1")
endfunction()

function(camber_example NAME)
    set(target example_${NAME})
    add_executable(${target} "${PROJECT_SOURCE_DIR}/modules/${NAME}/example.cpp")
    camber_common(${target})
    target_compile_options(${target} PRIVATE ${CAMBER_TEST_OPTIMISATION})
    target_link_libraries(${target} PRIVATE camber::${NAME})
    add_test(NAME ${target} COMMAND ${target})
    set_tests_properties(${target} PROPERTIES LABELS example TIMEOUT 60)
endfunction()

function(camber_bench NAME)
    cmake_parse_arguments(PARSE_ARGV 1 BENCH "" "" "SOURCES;USES;LINK")
    if(BENCH_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "camber_bench(${NAME}): unknown: ${BENCH_UNPARSED_ARGUMENTS}")
    endif()
    set(target bench_${NAME})
    add_executable(${target} ${BENCH_SOURCES})
    camber_common(${target})
    target_compile_options(${target} PRIVATE ${CAMBER_BENCH_OPTIMISATION})
    list(TRANSFORM BENCH_USES PREPEND camber::)
    target_link_libraries(${target} PRIVATE benchmark::benchmark_main ${BENCH_USES} ${BENCH_LINK})
endfunction()

function(camber_program NAME)
    cmake_parse_arguments(PARSE_ARGV 1 PROGRAM "" "" "SOURCES;USES;LINK")
    if(PROGRAM_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "camber_program(${NAME}): unknown: ${PROGRAM_UNPARSED_ARGUMENTS}")
    endif()
    add_executable(${NAME} ${PROGRAM_SOURCES})
    camber_common(${NAME})
    target_compile_options(${NAME} PRIVATE ${CAMBER_BENCH_OPTIMISATION})
    target_include_directories(${NAME} PRIVATE "${PROJECT_SOURCE_DIR}/tests/support")
    list(TRANSFORM PROGRAM_USES PREPEND camber::)
    target_link_libraries(${NAME} PRIVATE ${PROGRAM_USES} ${PROGRAM_LINK})
endfunction()

# What is built in BUILD, installed to PREFIX and nothing else there: a file of an earlier run would hide that it is installed no more.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${PREFIX}" --config "${CONFIG}" COMMAND_ERROR_IS_FATAL ANY)
# What others compile names no folder of this machine.
cmake_path(SET root NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../..")
file(GLOB_RECURSE interfaces "${PREFIX}/*.cppm")
foreach(file IN LISTS interfaces)
    file(READ "${file}" text)
    string(FIND "${text}" "${root}" found)
    if(NOT found EQUAL -1)
        message(FATAL_ERROR "${file} names ${root}")
    endif()
endforeach()

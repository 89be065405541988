# Installs the build in BUILD to an empty PREFIX; files of an earlier run would hide missing ones.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${PREFIX}" --config "${CONFIG}" COMMAND_ERROR_IS_FATAL ANY)
# Installed interfaces must not contain paths of this machine.
cmake_path(SET root NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../..")
file(GLOB_RECURSE interfaces "${PREFIX}/*.cppm")
foreach(file IN LISTS interfaces)
    file(READ "${file}" text)
    string(FIND "${text}" "${root}" found)
    if(NOT found EQUAL -1)
        message(FATAL_ERROR "${file} names ${root}")
    endif()
endforeach()

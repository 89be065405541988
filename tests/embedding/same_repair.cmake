# cmake -DCAMBER=… -DOUTSIDE=… -DCONFIG=… -DFOLDER=… -P same_repair.cmake: a mesh that is curved by energy, which breaks elements, and not repaired comes out of the outside
# program as out of `camber repair`, byte by byte.
file(MAKE_DIRECTORY "${FOLDER}")
execute_process(COMMAND "${CAMBER}" run "${CONFIG}" --set "stages=[\"elevate\",{\"curve\":{\"objective\":\"energy\",\"back_mesh\":\"straight\"}},\"commit\"]" --set output/mesh=curved.meshb
    --set output/report= --set output/vtu= WORKING_DIRECTORY "${FOLDER}" RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
if(NOT code EQUAL 1)
    message(FATAL_ERROR "curving without repair was to leave invalid elements (exit code 1), not ${code}")
endif()
execute_process(COMMAND "${CAMBER}" repair curved.meshb -o program.meshb WORKING_DIRECTORY "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${OUTSIDE}" curved.meshb outside.meshb WORKING_DIRECTORY "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${CMAKE_COMMAND}" -E compare_files program.meshb outside.meshb WORKING_DIRECTORY "${FOLDER}"
    COMMAND_ERROR_IS_FATAL ANY)

# cmake -DCAMBER=… -DOUTSIDE=… -DCONFIG=… -DFOLDER=… -P same_bytes.cmake: checks that the outside program, which
# calls the recipes, writes the bytes of the program: curved, remeshed in both degrees, repaired after curving by energy, and adapted.
file(MAKE_DIRECTORY "${FOLDER}")
function(same VERB INPUT)
    execute_process(COMMAND "${CAMBER}" ${VERB} ${INPUT} -o program.meshb ${ARGN} WORKING_DIRECTORY "${FOLDER}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
    execute_process(COMMAND "${OUTSIDE}" ${VERB} ${INPUT} outside.meshb WORKING_DIRECTORY "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
    execute_process(COMMAND "${CMAKE_COMMAND}" -E compare_files program.meshb outside.meshb WORKING_DIRECTORY "${FOLDER}"
        COMMAND_ERROR_IS_FATAL ANY)
endfunction()
# run(RESULT STAGES MESH): runs the config with other stages and returns its exit code.
function(run RESULT STAGES MESH)
    execute_process(COMMAND "${CAMBER}" run "${CONFIG}" --set "stages=${STAGES}" --set output/mesh=${MESH} --set output/report= --set output/vtu=
        WORKING_DIRECTORY "${FOLDER}" RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
    set(${RESULT} ${code} PARENT_SCOPE)
endfunction()
run(code "[]" straight.meshb)
if(NOT code EQUAL 0)
    message(FATAL_ERROR "no stages were to leave the straight mesh, and the run ended with ${code}")
endif()
run(code "[\"elevate\",{\"curve\":{\"objective\":\"energy\",\"background_mesh\":\"straight\"}},\"commit\"]" broken.meshb)
if(NOT code EQUAL 1)
    message(FATAL_ERROR "curving without repair was to leave invalid elements (exit code 1), not ${code}")
endif()
same(curve straight.meshb)
file(RENAME "${FOLDER}/program.meshb" "${FOLDER}/curved.meshb")
same(remesh straight.meshb)
same(remesh curved.meshb)
same(repair broken.meshb)
same(adapt straight.meshb "--solution=tanh((z-1)/0.3)" --complexity=300 --cycles=2)

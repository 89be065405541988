# What is built in BUILD, installed to PREFIX and nothing else there: a file of an earlier run would hide that it is installed no more.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${PREFIX}" --config "${CONFIG}" COMMAND_ERROR_IS_FATAL ANY)

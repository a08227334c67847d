# cmake -DBUILD=DIR -DULF=PROGRAM -DCHECKOUT=DIR -DSCRATCH=DIR -P example.cmake: the example, built against
# what was installed, runs; and each library links whole.
file(REMOVE_RECURSE ${SCRATCH})
set(prefix ${SCRATCH}/prefix)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
foreach(project tests/install/whole examples)
  get_filename_component(name ${project} NAME)
  execute_process(COMMAND ${CMAKE_COMMAND} -G Ninja -S ${CHECKOUT}/${project} -B ${SCRATCH}/${name}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=Release OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${SCRATCH}/${name} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
set(EXAMPLE ${SCRATCH}/examples/capture_and_render)
set(SCRATCH ${SCRATCH}/run)
include(${CMAKE_CURRENT_LIST_DIR}/run_example.cmake)

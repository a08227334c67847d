# cmake -DBUILD=DIR -DULF=PROGRAM -DCHECKOUT=DIR -DSCRATCH=DIR -P example.cmake: a program of somebody else's, built against
# what was installed, renders a light field; and each library links whole.
file(REMOVE_RECURSE ${SCRATCH})
set(prefix ${SCRATCH}/prefix)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
foreach(project whole example)
  execute_process(COMMAND ${CMAKE_COMMAND} -G Ninja -S ${CHECKOUT}/tests/install/${project} -B ${SCRATCH}/${project}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=Release OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${SCRATCH}/${project} COMMAND_ERROR_IS_FATAL ANY)
endforeach()

set(field ${SCRATCH}/field)
execute_process(COMMAND ${ULF} capture sim:studio?width=320&height=240 -o ${field} --headless --poses known
  --subject 0,0,0.07,0.162 --quality fast --frames 80 --no-geometry OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${SCRATCH}/example/between_views ${field} ${SCRATCH}/picture.png
  OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
if(NOT said MATCHES "^320 x 240, [0-9]+ pixels empty" OR NOT EXISTS ${SCRATCH}/picture.png)
  message(FATAL_ERROR "between_views said: ${said}")
endif()
file(REMOVE_RECURSE ${SCRATCH})

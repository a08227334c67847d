# cmake -DEXAMPLE=PROGRAM -DSCRATCH=DIR -P run_example.cmake: the example captures and renders, and what it cannot do it
# says in the words of the libraries, without options of ulf's command line.
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH})
execute_process(COMMAND ${EXAMPLE} sim:studio?width=320&height=240&row_deg=5&speed_deg_s=30 ${SCRATCH}/field
  ${SCRATCH}/picture.png OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
if(NOT said MATCHES "^[0-9]+ views cover (9[89]|100) % of the cap" OR NOT EXISTS ${SCRATCH}/picture.png)
  message(FATAL_ERROR "the example said: ${said}")
endif()
foreach(device sim:nowhere sim:studio?width=no replay:${SCRATCH}/nothing sim:board
    sim:studio?width=320&height=240&duration_s=0.1)
  execute_process(COMMAND ${EXAMPLE} ${device} ${SCRATCH}/other ${SCRATCH}/other.png RESULT_VARIABLE status
    ERROR_VARIABLE said)
  if(NOT status EQUAL 1 OR said MATCHES " --[a-z]" OR NOT said MATCHES "^capture_and_render: [^\n]+\n$")
    message(FATAL_ERROR "${device}: ended with ${status}: ${said}")
  endif()
  message(STATUS "${said}")
endforeach()
file(REMOVE_RECURSE ${SCRATCH})

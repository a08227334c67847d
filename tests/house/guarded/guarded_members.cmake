# Whether the thread-safety analysis sees through core/base/mutex.h: -DCLANG= compiles a file that locks, and refuses
# the same file where it does not.
if(NOT CLANG)
  message("skipped: clang++ is not installed; ULF_PRESET=clang ./run deps installs it")
  return()
endif()
set(compile ${CLANG} -std=c++20 -fsyntax-only -Wthread-safety -Werror -I${CHECKOUT}
  ${CMAKE_CURRENT_LIST_DIR}/guarded_member.cpp)
execute_process(COMMAND ${compile} RESULT_VARIABLE result ERROR_VARIABLE words)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "with the lock it does not compile:\n${words}")
endif()
execute_process(COMMAND ${compile} -DWITHOUT_LOCK RESULT_VARIABLE result ERROR_VARIABLE words)
foreach(refusal "reading variable 'count_' requires holding mutex 'mutex_'"
                "calling function 'Increase' requires holding mutex 'mutex_'")
  string(FIND "${words}" "${refusal}" found)
  if(result EQUAL 0 OR found EQUAL -1)
    message(FATAL_ERROR "without the lock Clang does not say \"${refusal}\":\n${words}")
  endif()
endforeach()

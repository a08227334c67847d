# cmake -DBUILD=DIR -DSCRATCH=DIR -P installed_files.cmake: installs, and looks at what is there.
file(REMOVE_RECURSE ${SCRATCH})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

foreach(file bin/ulf share/man/man1/ulf.1.gz share/man/man1/ulf-capture.1.gz share/man/man1/ulf-export-colmap.1.gz
    share/bash-completion/completions/ulf share/fish/vendor_completions.d/ulf.fish lib/udev/rules.d/70-ulf-cameras.rules
    share/applications/ulf.desktop share/icons/hicolor/scalable/apps/ulf.svg share/doc/ulf/docs/tracking.md
    include/ulf/core/base/error.h include/ulf/coverage/bound/criterion.h)
  if(NOT EXISTS ${SCRATCH}/${file})
    message(SEND_ERROR "${file} was not installed")
  endif()
endforeach()

# Under /usr and elsewhere zsh's folders have different names.
file(GLOB zsh ${SCRATCH}/share/zsh/*/_ulf)
if(NOT zsh)
  message(SEND_ERROR "zsh's _ulf was not installed")
endif()

# Links of pages lead to what is installed, but for pictures (charts/ is a folder of them).
file(GLOB_RECURSE pages RELATIVE ${SCRATCH}/share/doc/ulf ${SCRATCH}/share/doc/ulf/*.md)
foreach(page IN LISTS pages)
  file(READ ${SCRATCH}/share/doc/ulf/${page} text)
  get_filename_component(folder ${SCRATCH}/share/doc/ulf/${page} DIRECTORY)
  string(REPLACE "](" "LINK:" text "${text}")  # brackets would hold a list of CMake's together
  string(REGEX MATCHALL "LINK:[A-Za-z0-9_./-]+[)#]" links "${text}")
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^LINK:(.*)[)#]$" "\\1" link "${link}")
    if(NOT link MATCHES "\\.(png|jpg|svg)$|charts/$" AND NOT EXISTS ${folder}/${link})
      message(SEND_ERROR "${page} leads to ${link}, which was not installed")
    endif()
  endforeach()
endforeach()

# Headers include nothing that is not installed: what a header names in quotation marks is there.
file(GLOB_RECURSE headers RELATIVE ${SCRATCH}/include/ulf ${SCRATCH}/include/ulf/*.h)
foreach(header IN LISTS headers)
  file(STRINGS ${SCRATCH}/include/ulf/${header} lines REGEX "^#include \"")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
    if(NOT EXISTS ${SCRATCH}/include/ulf/${included})
      message(SEND_ERROR "${header} includes ${included}, which was not installed")
    endif()
  endforeach()
endforeach()

# Neither the folder that it was built in nor the sources' are named in what other programs read.
file(GLOB_RECURSE package_files ${SCRATCH}/lib*/*.cmake)
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  foreach(folder ${BUILD} ${CHECKOUT})
    string(FIND "${text}" "${folder}" at)
    if(NOT at EQUAL -1)
      message(SEND_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()
if(NOT package_files)
  message(SEND_ERROR "no files of find_package(ulf) were installed")
endif()

find_program(VALIDATE desktop-file-validate)
if(VALIDATE)
  execute_process(COMMAND ${VALIDATE} ${SCRATCH}/share/applications/ulf.desktop COMMAND_ERROR_IS_FATAL ANY)
endif()
file(REMOVE_RECURSE ${SCRATCH})

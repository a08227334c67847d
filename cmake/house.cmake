# Flags that every target of ours is compiled with, and how a folder becomes a library.
include(CheckCXXSourceRuns)

# Debian's Eigen-based libraries are built with 16-byte alignment; with AVX our side would otherwise
# allocate with 32 and free() what the other side laid out differently.
add_library(ulf_flags INTERFACE)
target_compile_definitions(ulf_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1 EIGEN_MAX_ALIGN_BYTES=16)
target_include_directories(ulf_flags INTERFACE ${CMAKE_SOURCE_DIR})

check_cxx_source_runs(
  "int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") && __builtin_cpu_supports(\"bmi2\") ? 0 : 1; }"
  ULF_HOST_HAS_AVX2)
if(ULF_HOST_HAS_AVX2)
  set(ulf_default_march x86-64-v3)
endif()
set(ULF_MARCH "${ulf_default_march}" CACHE STRING "Instruction set (-march=); empty for the compiler's own default")
if(ULF_MARCH)
  target_compile_options(ulf_flags INTERFACE -march=${ULF_MARCH})
endif()

option(ULF_WARNINGS_AS_ERRORS "Fail on any warning" ON)
target_compile_options(ulf_flags INTERFACE -Wall -Wextra -Wno-psabi $<$<BOOL:${ULF_WARNINGS_AS_ERRORS}>:-Werror>)

set(ULF_SANITIZE "" CACHE STRING "address,undefined or thread")
if(ULF_SANITIZE)
  # Instrumented code makes GCC 12 see overlaps and overruns inside std::string that are not there.
  target_compile_options(ulf_flags INTERFACE -fsanitize=${ULF_SANITIZE} -fno-omit-frame-pointer -Wno-error)
  target_link_options(ulf_flags INTERFACE -fsanitize=${ULF_SANITIZE})
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

# Files are compiled eight at a time, since most of the time goes into what they all include. (CMake's own unity builds
# name files absolutely: no compiler cache finds them again in another checkout.)
function(ulf_batch sources name)
  set(apart ${${sources}})
  list(FILTER apart INCLUDE REGEX "^/")  # generated headers
  list(FILTER ${sources} EXCLUDE REGEX "^/")
  set(batches)
  while(${sources})
    list(SUBLIST ${sources} 0 8 batch)
    list(REMOVE_ITEM ${sources} ${batch})
    file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    list(TRANSFORM batch REPLACE "(.+)" "#include \"${folder}/\\1\"\n")
    string(JOIN "" batch ${batch})
    list(LENGTH batches index)
    file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/batches/${name}_${index}.cpp CONTENT "${batch}" @ONLY)
    list(APPEND batches ${CMAKE_CURRENT_BINARY_DIR}/batches/${name}_${index}.cpp)
  endwhile()
  set(${sources} ${apart} ${batches} PARENT_SCOPE)
endfunction()

# ulf_library(NAME SOURCES ... [APART ...] LINK ... PRECOMPILE ...)
# APART: files with options of their own, or with private names that others have, too.
function(ulf_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;APART;LINK;LINK_PRIVATE;PRECOMPILE" ${ARGN})
  ulf_batch(ARG_SOURCES ${name})
  add_library(${name} STATIC ${ARG_SOURCES} ${ARG_APART})
  target_link_libraries(${name} PUBLIC ulf_flags ${ARG_LINK} PRIVATE ${ARG_LINK_PRIVATE})
  target_compile_options(${name} PRIVATE -Wno-subobject-linkage)  # which takes a file in a batch for a header
  if(ARG_PRECOMPILE)
    target_precompile_headers(${name} PRIVATE ${ARG_PRECOMPILE})
  endif()
endfunction()

# Command files parse arguments and print: nothing in them is worth much of the optimiser's time, and what they include
# costs more to compile than what they do, so it is compiled once for them and for main.cpp.
set(ulf_command_options -pthread $<$<CONFIG:Release>:-O1>)
function(ulf_precompile_command_headers)
  file(WRITE ${CMAKE_BINARY_DIR}/generated/command_headers.cpp "")
  add_library(ulf_command_headers OBJECT ${CMAKE_BINARY_DIR}/generated/command_headers.cpp)
  target_link_libraries(ulf_command_headers PRIVATE ulf_flags Eigen3::Eigen opencv_core fmt::fmt spdlog::spdlog
    nlohmann_json::nlohmann_json CLI11::CLI11 Threads::Threads)
  target_compile_options(ulf_command_headers PRIVATE ${ulf_command_options})
  target_precompile_headers(ulf_command_headers PRIVATE
    <CLI/CLI.hpp> <Eigen/Core> <Eigen/Geometry> <fmt/core.h> <nlohmann/json.hpp> <opencv2/core.hpp>
    <memory> <optional> <string> <vector>)
endfunction()

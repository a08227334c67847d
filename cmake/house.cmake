# Flags that every target of ours is compiled with, and how a folder becomes a library.
include(CheckCXXSourceRuns)

# Debian's Eigen-based libraries are built with 16-byte alignment; with AVX our side would otherwise
# allocate with 32 and free() what the other side laid out differently.
add_library(ulf_flags INTERFACE)
target_compile_definitions(ulf_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1 EIGEN_MAX_ALIGN_BYTES=16)
target_include_directories(ulf_flags INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/ulf>)

check_cxx_source_runs(
  "int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") && __builtin_cpu_supports(\"bmi2\") ? 0 : 1; }"
  ULF_HOST_HAS_AVX2)
if(ULF_HOST_HAS_AVX2)
  set(ulf_default_march x86-64-v3)
endif()
set(ULF_MARCH "${ulf_default_march}" CACHE STRING "Instruction set (-march=); empty for the compiler's own default")
if(ULF_MARCH)
  target_compile_options(ulf_flags INTERFACE $<BUILD_INTERFACE:-march=${ULF_MARCH}>)
endif()

option(ULF_WARNINGS_AS_ERRORS "Fail on any warning" ON)
target_compile_options(ulf_flags INTERFACE $<BUILD_INTERFACE:-pthread> $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wno-psabi>
  $<$<BOOL:${ULF_WARNINGS_AS_ERRORS}>:$<BUILD_INTERFACE:-Werror>>)

# The Python module is a shared library of the same objects. What nobody interposes is inlined as before, and in programs
# the linker takes the detours out. Tests have the module in a program (tests/python), and need none of this.
if(ULF_PYTHON)
  target_compile_options(ulf_flags INTERFACE $<BUILD_INTERFACE:-fPIC> $<BUILD_INTERFACE:-fno-semantic-interposition>)
endif()

# Below a gigabyte GCC frees no memory: a batch takes a fifth more of it and up to a tenth less time.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(ulf_flags INTERFACE $<BUILD_INTERFACE:--param=ggc-min-heapsize=1000000>)
endif()

# Clang alone checks what core/base/mutex.h says of locks. The cache knows a precompiled header by its content, so no
# time goes into it.
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  target_compile_options(ulf_flags INTERFACE $<BUILD_INTERFACE:-Wthread-safety>
    "$<BUILD_INTERFACE:SHELL:-Xclang -fno-pch-timestamp>")
endif()

set(ULF_SANITIZE "" CACHE STRING "address,undefined or thread")
if(ULF_SANITIZE)
  # Instrumented code makes GCC 12 see overlaps and overruns inside std::string that are not there.
  target_compile_options(ulf_flags INTERFACE -fsanitize=${ULF_SANITIZE} -fno-omit-frame-pointer -Wno-error)
  # GCC writes where each check of undefined behaviour stands into the program: nine tenths of a gigabyte each. Instead a
  # check that fails traps, and the address sanitizer shows where (ASAN_OPTIONS=handle_sigill=2).
  if(ULF_SANITIZE STREQUAL "address,undefined")
    target_compile_options(ulf_flags INTERFACE -fsanitize-undefined-trap-on-error)
  endif()
  set(kept_modules ${CMAKE_BINARY_DIR}/kept_modules.o)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS tests/support/sanitizers/kept_modules.cpp)
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -c -fPIC ${CMAKE_SOURCE_DIR}/tests/support/sanitizers/kept_modules.cpp -o ${kept_modules}
    COMMAND_ERROR_IS_FATAL ANY)
  target_link_options(ulf_flags INTERFACE -fsanitize=${ULF_SANITIZE} $<BUILD_INTERFACE:${kept_modules}>)
endif()

# The cache finds a file again in any checkout: paths count from its root (BASEDIR), a precompiled header is known by its
# content and not by the time it was written (SLOPPINESS), and where nothing is known yet no time goes into a first run
# of the preprocessor (DEPEND).
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_DEPEND=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${CCACHE})
endif()

# Some 120 programs are linked, most of them tests: with mold a tenth of a second each, with the usual linker two.
find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# Most of the time goes into what all files include and the templates that they instantiate: 32 at a time they take 0.43 of
# the processor time of one at a time. For a build from nothing (./run makes such ones); afterwards one changed file costs 32,
# and tools that read compile_commands.json see only one file in 32.
option(ULF_UNITY "Compile the libraries' files 32 at a time" OFF)

# What the floors' files include, compiled once for each set of options. (GCC takes the optimiser's level from the precompiled
# header, whatever the command says.)
function(ulf_precompile name level)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/${name}.cpp CONTENT "")  # as it is where it is there
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/generated/${name}.cpp)
  target_link_libraries(${name} PRIVATE ulf_flags Eigen3::Eigen opencv_core opencv_imgproc fmt::fmt spdlog::spdlog
    nlohmann_json::nlohmann_json Threads::Threads ${ARGN})
  target_compile_options(${name} PRIVATE ${level})
  target_precompile_headers(${name} PRIVATE
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <fmt/core.h> <nlohmann/json.hpp> <opencv2/core.hpp>
    <opencv2/imgproc.hpp> <spdlog/spdlog.h> <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <deque>
    <filesystem> <fstream> <functional> <map> <memory> <mutex> <numeric> <optional> <ranges> <set> <span> <sstream> <string>
    <string_view> <thread> <tuple> <unordered_map> <utility> <variant> <vector>)
endfunction()
set(ulf_cold_options $<$<CONFIG:Release>:-O1>)

# With ULF_UNITY, compiles a target's files `size` at a time.
function(ulf_unite name size)
  if(ULF_UNITY)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size})
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      target_compile_options(${name} PRIVATE -Wno-subobject-linkage)  # takes a file in a batch for a header
    endif()
  endif()
endfunction()

# ulf_library(NAME [COLD ...] [HEADERS ...] LINK ...): every source under this folder is one library. Private names must
# differ in a folder's files (CMake keeps files with options of their own apart).
# COLD: rooms, as regular expressions, that read files, wait for devices and write: the optimiser's first level does for them,
# in two thirds of the time. HEADERS: whose precompiled headers the library uses.
function(ulf_library name)
  cmake_parse_arguments(ARG "" "HEADERS" "COLD;LINK;LINK_PRIVATE" ${ARGN})
  if(NOT ARG_HEADERS)
    set(ARG_HEADERS ulf_headers)
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.cpp)
  set(cold)
  if(ARG_COLD)
    set(cold ${sources})
    list(JOIN ARG_COLD "|" rooms)
    list(FILTER cold INCLUDE REGEX "^(${rooms})/?[^/]*$")
    list(REMOVE_ITEM sources ${cold})
  endif()
  add_library(${name} STATIC ${sources})
  set(parts ${name})
  if(cold)
    add_library(${name}_cold OBJECT ${cold})
    target_sources(${name} PRIVATE $<TARGET_OBJECTS:${name}_cold>)
    target_compile_options(${name}_cold PRIVATE ${ulf_cold_options})
    target_precompile_headers(${name}_cold REUSE_FROM ulf_cold_headers)
    list(APPEND parts ${name}_cold)
  endif()
  target_precompile_headers(${name} REUSE_FROM ${ARG_HEADERS})
  foreach(part IN LISTS parts)
    target_link_libraries(${part} PUBLIC ulf_flags ${ARG_LINK} PRIVATE ${ARG_LINK_PRIVATE})
    ulf_unite(${part} 32)
  endforeach()
endfunction()

# The target headers_alone compiles every header by itself: what it needs, it includes.
option(ULF_HEADERS_ALONE "Make the target headers_alone" OFF)
if(ULF_HEADERS_ALONE)
  add_custom_target(headers_alone)
endif()

# ulf_headers_alone(FOLDER LIBRARY LINK ...): FOLDER's headers, compiled as LIBRARY's files are.
function(ulf_headers_alone folder library)
  if(NOT ULF_HEADERS_ALONE)
    return()
  endif()
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/${folder}/*.h)
  set(sources "")
  foreach(header IN LISTS headers)
    set(source ${CMAKE_BINARY_DIR}/generated/headers_alone/${header}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include \"${header}\"\n")
    list(APPEND sources ${source})
  endforeach()
  add_library(${folder}_headers_alone OBJECT EXCLUDE_FROM_ALL ${sources})
  target_link_libraries(${folder}_headers_alone PRIVATE ${library} ${ARGN})
  foreach(property INCLUDE_DIRECTORIES COMPILE_DEFINITIONS)
    set_property(TARGET ${folder}_headers_alone APPEND PROPERTY ${property} $<TARGET_PROPERTY:${library},${property}>)
  endforeach()
  add_dependencies(headers_alone ${folder}_headers_alone)
endfunction()

# Every outside package.
include(library_packages)
find_package(CLI11 2.1 REQUIRED)

# What the Python module needs: pybind11, and NumPy for its tests. A Python of one's own may stand first in the path;
# the module is for the distribution's, as its package is.
if(NOT DEFINED Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development NumPy)
if(Python_FOUND)
  find_package(pybind11 2.10 QUIET)
endif()
option(ULF_PYTHON "Build the Python module, and all else as position-independent code" OFF)
if(ULF_PYTHON AND NOT pybind11_FOUND)
  message(FATAL_ERROR "ULF_PYTHON needs pybind11, and Python with its headers and NumPy: ./run deps installs them")
endif()
if(ULF_TESTS)
  pkg_check_modules(umockdev REQUIRED IMPORTED_TARGET umockdev-1.0)
endif()

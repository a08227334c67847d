# Every outside package.
include(library_packages)
find_package(CLI11 2.1 REQUIRED)
if(ULF_TESTS)
  pkg_check_modules(umockdev REQUIRED IMPORTED_TARGET umockdev-1.0)
endif()

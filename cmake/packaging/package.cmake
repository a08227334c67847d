# `cpack` (./run package) makes Debian packages of what is installed: ulf, the program, ulf-dev, the libraries, and
# python3-ulf, the Python module.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ulf)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "ulf developers <ulf@localhost>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# The libraries that the program links are read from it, with the versions that it needs.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ulf)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# Copies of two modules of OpenCV come with it (install.cmake): no package has to bring them.
if(ULF_PRIVATE_MODULES)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/private_libraries)
  set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/project.cmake)
endif()
# It opens these two by name (libepoxy does): no linker knows of them.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libegl1, libgl1")
# OpenGL where no GPU's driver is, letters on the display, man, completion in bash.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libgl1-mesa-dri, fonts-dejavu-core, man-db, bash-completion")
# What reads and writes videos, opened by name when it is needed (core/ffmpeg/ffmpeg_calls): of the versions whose headers were there.
foreach(library avformat avcodec avutil swscale)
  string(REGEX MATCH "^[0-9]+" major "${ffmpeg_lib${library}_VERSION}")
  string(APPEND CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS ", lib${library}${major}")
endforeach()
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ulf-dev, colmap")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
"captures and renders unstructured light fields
ulf captures light fields with one camera held in the hand: it tells which
viewpoints are still missing, ends when all are there, and renders the result
at once, without training. GigE Vision, USB3 Vision, webcams and tethered
cameras; a simulated camera; exports for COLMAP and nerfstudio.")

# Without the instructions that it is compiled for (x86-64-v3, where the computer that builds has them) the program would
# end at once, so the package refuses.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/postinst ${CMAKE_CURRENT_LIST_DIR}/postrm)
if(ULF_MARCH STREQUAL x86-64-v3)
  set(processor_flags "avx2 bmi2 fma movbe")
  configure_file(${CMAKE_CURRENT_LIST_DIR}/preinst.in ${CMAKE_BINARY_DIR}/generated/preinst @ONLY
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  list(APPEND CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/generated/preinst)
endif()

file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/libraries.txt libraries)
list(JOIN libraries ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_DEV_PACKAGE_NAME ulf-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEV_DESCRIPTION
"libraries of ulf, for other programs
Static libraries, headers and CMake's find_package(ulf): light fields on disk,
cameras, tracking, coverage and rendering as five targets.")

if(ULF_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ulf)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # It is compiled for one Python, and opens OpenGL and has libraries (install.cmake) as the program does.
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, ulf (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION
"light fields of ulf in Python
Module ulf: poses, intrinsics, photographs, masks, depth and coverage of a
light field as NumPy arrays, and renderings from new places.")
endif()

include(CPack)

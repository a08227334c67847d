# What `cmake --install` writes, in components: `program`, for programs that link the libraries `dev`, and `python`.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(packaging ${CMAKE_CURRENT_LIST_DIR})
set(documents ${CMAKE_INSTALL_DATADIR}/doc/ulf)

# --- dev: a target a floor, ulf::core and so on. Headers include each other as "core/base/error.h".
set(floors core acquisition tracking render coverage)
foreach(floor IN LISTS floors)
  set_target_properties(ulf_${floor} PROPERTIES EXPORT_NAME ${floor})
  install(TARGETS ulf_${floor} EXPORT ulfTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${floor} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ulf COMPONENT dev
    FILES_MATCHING PATTERN *.h PATTERN shaders EXCLUDE)
endforeach()
set_target_properties(ulf_flags PROPERTIES EXPORT_NAME flags)
install(TARGETS ulf_flags EXPORT ulfTargets)
set(package_files ${CMAKE_INSTALL_LIBDIR}/cmake/ulf)
install(EXPORT ulfTargets NAMESPACE ulf:: DESTINATION ${package_files} COMPONENT dev)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/ulfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${packaging}/ulfConfig.cmake ${PROJECT_SOURCE_DIR}/cmake/library_packages.cmake
  ${CMAKE_BINARY_DIR}/generated/ulfConfigVersion.cmake DESTINATION ${package_files} COMPONENT dev)

# --- program
# Debian's package of OpenCV's contributed modules brings Qt, Tesseract, HDF5 and some 170 packages more; ulf links two small
# modules of it. A package has its own copies of those, as Debian built them, and needs what they need.
option(ULF_PRIVATE_MODULES "Install copies of those two" OFF)
if(ULF_PRIVATE_MODULES)
  set(private_folder ${CMAKE_BINARY_DIR}/private_libraries)
  foreach(module aruco mcc)
    get_target_property(module_file opencv_${module} IMPORTED_LOCATION_RELEASE)
    get_target_property(module_name opencv_${module} IMPORTED_SONAME_RELEASE)
    file(REAL_PATH ${module_file} module_file)
    configure_file(${module_file} ${private_folder}/${module_name} COPYONLY)
    install(PROGRAMS ${private_folder}/${module_name} DESTINATION ${CMAKE_INSTALL_LIBDIR}/ulf COMPONENT program)
  endforeach()
  set_target_properties(ulf PROPERTIES INSTALL_RPATH "\$ORIGIN/../${CMAKE_INSTALL_LIBDIR}/ulf")
endif()
install(TARGETS ulf RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)

# The manual and the completions come from the options that the program itself declares. What they are depends on the
# program alone, so they are made when everything is built.
set(manual ${CMAKE_BINARY_DIR}/manual)
set(generated ${manual}/ulf.bash ${manual}/ulf.zsh ${manual}/ulf.fish)
add_custom_command(OUTPUT ${generated}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manual}/man1
  COMMAND ulf manual ${manual}/man1
  COMMAND gzip -9 -n -r ${manual}/man1
  COMMAND ulf completion bash > ${manual}/ulf.bash
  COMMAND ulf completion zsh > ${manual}/ulf.zsh
  COMMAND ulf completion fish > ${manual}/ulf.fish
  DEPENDS ulf VERBATIM)
add_custom_target(manual ALL DEPENDS ${generated})
install(DIRECTORY ${manual}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
install(FILES ${manual}/ulf.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ulf
  COMPONENT program)
# Debian's zsh looks for what packages bring in a folder of its own.
set(zsh_functions site-functions)
if(CMAKE_INSTALL_PREFIX STREQUAL /usr)
  set(zsh_functions vendor-completions)
endif()
install(FILES ${manual}/ulf.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/${zsh_functions} RENAME _ulf COMPONENT program)
install(FILES ${manual}/ulf.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT program)

install(FILES ${PROJECT_SOURCE_DIR}/udev/70-ulf-cameras.rules DESTINATION lib/udev/rules.d COMPONENT program)
install(FILES ${packaging}/ulf.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT program)
install(FILES ${packaging}/ulf.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT program)

# Pages that help and messages name as docs/NAME.md, without their pictures, and scripts for schedulers (docs/farm.md).
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md DESTINATION ${documents}
  COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${documents} COMPONENT program
  FILES_MATCHING PATTERN *.md PATTERN *.sbatch PATTERN *.sh PATTERN charts EXCLUDE PATTERN stability EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/udev/README.md DESTINATION ${documents}/udev COMPONENT program)

# --- python: the module, where Debian's Python looks for modules of packages (/usr) or of one's own (/usr/local).
set(components program dev)
if(ULF_PYTHON)
  list(APPEND components python)
  set(python_folder lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/dist-packages)
  if(CMAKE_INSTALL_PREFIX STREQUAL /usr)
    set(python_folder lib/python${Python_VERSION_MAJOR}/dist-packages)
  endif()
  if(ULF_PRIVATE_MODULES)
    set_target_properties(ulf_python PROPERTIES INSTALL_RPATH "\$ORIGIN/../../../${CMAKE_INSTALL_LIBDIR}/ulf")
  endif()
  install(TARGETS ulf_python LIBRARY DESTINATION ${python_folder} COMPONENT python)
  install(FILES ${PROJECT_SOURCE_DIR}/examples/load_views.py ${PROJECT_SOURCE_DIR}/examples/compare_captures.py
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-ulf/examples COMPONENT python)
endif()

# Every package says whose it is.
foreach(component IN LISTS components)
  set(name ulf)
  if(component STREQUAL dev)
    set(name ulf-dev)
  elseif(component STREQUAL python)
    set(name python3-ulf)
  endif()
  install(FILES ${packaging}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endforeach()

# find_package(ulf): the targets ulf::core, ulf::acquisition, ulf::tracking, ulf::render and ulf::coverage. The libraries
# are static, so what they link from outside is looked for here as well.
include(${CMAKE_CURRENT_LIST_DIR}/library_packages.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/ulfTargets.cmake)

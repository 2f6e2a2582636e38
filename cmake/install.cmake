# `cmake --install`: the program, the libraries with their headers, the scenes, and what
# find_package(ferrule) needs.
include(CMakePackageConfigHelpers)

set(FERRULE_LIBRARIES sim haptic insertion capture learn controller)
foreach(library IN LISTS FERRULE_LIBRARIES)
  install(TARGETS ferrule_${library} EXPORT ferrule_targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${library}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ferrule/${library}
    FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(TARGETS ferrule_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY data/scenes data/devices DESTINATION ${CMAKE_INSTALL_DATADIR}/ferrule)
install(FILES data/controller.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/ferrule)

set(FERRULE_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/ferrule)
install(EXPORT ferrule_targets NAMESPACE ferrule:: FILE ferrule-targets.cmake
  DESTINATION ${FERRULE_CMAKE_DIR})
configure_package_config_file(cmake/ferrule-config.cmake.in ferrule-config.cmake
  INSTALL_DESTINATION ${FERRULE_CMAKE_DIR})
write_basic_package_version_file(ferrule-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ferrule-config.cmake
  ${PROJECT_BINARY_DIR}/ferrule-config-version.cmake DESTINATION ${FERRULE_CMAKE_DIR})

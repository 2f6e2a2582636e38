# `cmake --install`: the program, the libraries with their headers, the scenes, and what
# find_package(ferrule) needs. `cpack -G DEB` in the build folder: the same as Debian packages.
include(CMakePackageConfigHelpers)

set(FERRULE_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/ferrule)
foreach(library IN LISTS FERRULE_LIBRARIES)
  install(TARGETS ferrule_${library} EXPORT ferrule_${library}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries)
  if(NOT library STREQUAL base) # its headers are those of sim/base
    install(DIRECTORY ${library}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ferrule/${library}
      COMPONENT libraries FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
  endif()
  install(EXPORT ferrule_${library} NAMESPACE ferrule:: FILE ferrule-${library}.cmake
    DESTINATION ${FERRULE_CMAKE_DIR} COMPONENT libraries)
endforeach()
configure_package_config_file(cmake/ferrule-config.cmake.in ferrule-config.cmake
  INSTALL_DESTINATION ${FERRULE_CMAKE_DIR})
write_basic_package_version_file(ferrule-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ferrule-config.cmake
  ${PROJECT_BINARY_DIR}/ferrule-config-version.cmake DESTINATION ${FERRULE_CMAKE_DIR}
  COMPONENT libraries)

install(TARGETS ferrule_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(DIRECTORY data/scenes data/devices data/controllers DESTINATION ${CMAKE_INSTALL_DATADIR}/ferrule
  COMPONENT program)
install(FILES data/controller.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/ferrule
  COMPONENT program)
install(FILES cmake/completion.bash RENAME ferrule COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ferrule
  COMPONENT program)

# A man page of the program and one of each verb, from what --help says.
find_program(FERRULE_HELP2MAN help2man)
if(FERRULE_HELP2MAN)
  set(man ${PROJECT_BINARY_DIR}/man)
  add_custom_command(OUTPUT ${man}/made
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:ferrule_app> -DHELP2MAN=${FERRULE_HELP2MAN}
      -DOUT=${man} -P ${PROJECT_SOURCE_DIR}/cmake/man_pages.cmake
    DEPENDS ferrule_app ferrule_bench_verb ferrule_view_verb cmake/man_pages.cmake VERBATIM)
  add_custom_target(man_pages ALL DEPENDS ${man}/made)
  install(DIRECTORY ${man}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program
    OPTIONAL FILES_MATCHING PATTERN "*.1.gz")
endif()

# ferrule; libferrule-dev; and what loads libtorch and CVODE, which are large, each on its own.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The ferrule authors <ferrule@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ferrule)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ferrule-torch, ferrule-cvode")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_NAME libferrule-dev)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_DEPENDS
  "libeigen3-dev, nlohmann-json3-dev, ferrule (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_RECOMMENDS
  "libfmt-dev, libhidapi-dev, pkg-config, libhdf5-dev, libtbb-dev, libceres-dev")
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION "Libraries and headers of ferrule")
foreach(loaded torch cvode)
  string(TOUPPER ${loaded} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ferrule-${loaded})
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "ferrule (= ${PROJECT_VERSION})")
endforeach()
set(CPACK_COMPONENT_TORCH_DESCRIPTION "Networks for ferrule, by libtorch")
set(CPACK_COMPONENT_CVODE_DESCRIPTION "The reference trajectories of ferrule bench, by CVODE")
include(CPack)

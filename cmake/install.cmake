# Installation: every module library with its headers, the program, and the package files that make
# find_package(sarblock) work (tests/package is a consumer that proves it).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(sarblock_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sarblock)
get_property(sarblock_modules GLOBAL PROPERTY SARBLOCK_MODULES)
install(TARGETS ${sarblock_modules} EXPORT sarblock-targets FILE_SET HEADERS)
install(EXPORT sarblock-targets NAMESPACE sarblock:: DESTINATION ${sarblock_package_dir})

if(TARGET sarblock)
  install(TARGETS sarblock)
endif()
install(FILES LICENSE CHANGELOG.md README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(cmake/sarblock-config.cmake.in sarblock-config.cmake
  INSTALL_DESTINATION ${sarblock_package_dir})
write_basic_package_version_file(sarblock-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/sarblock-config.cmake
  ${PROJECT_BINARY_DIR}/sarblock-config-version.cmake
  DESTINATION ${sarblock_package_dir})

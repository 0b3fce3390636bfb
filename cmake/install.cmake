# Installation: every module library with its headers, the program with its manual, completions,
# documents and scenes, and the package files that make find_package(sarblock) work (tests/package is
# a consumer that proves it). Components: sarblock (the program), mpi (sarblock-mpi), dev (the library)
# and python (the Python package).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(sarblock_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sarblock)
get_property(sarblock_modules GLOBAL PROPERTY SARBLOCK_MODULES)
install(TARGETS ${sarblock_modules} EXPORT sarblock-targets
  ARCHIVE COMPONENT dev FILE_SET HEADERS COMPONENT dev)
install(EXPORT sarblock-targets NAMESPACE sarblock:: DESTINATION ${sarblock_package_dir}
  COMPONENT dev)

if(TARGET sarblock)
  install(TARGETS sarblock RUNTIME COMPONENT sarblock)
  install(DIRECTORY datasets/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/sarblock
    COMPONENT sarblock FILES_MATCHING PATTERN "*.toml")
  install(DIRECTORY datasets/real DESTINATION ${CMAKE_INSTALL_DATADIR}/sarblock COMPONENT sarblock)
endif()
if(TARGET sarblock_mpi)
  install(TARGETS sarblock_mpi RUNTIME COMPONENT mpi)
endif()
if(TARGET sarblock_python)
  # Below the prefix, where the distribution's Python looks for what is installed there.
  set(SARBLOCK_PYTHON_DIR lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/dist-packages CACHE STRING
    "Folder of the Python package below the prefix")
  install(TARGETS sarblock_python LIBRARY DESTINATION ${SARBLOCK_PYTHON_DIR}/sarblock COMPONENT python)
  install(DIRECTORY src/python/sarblock DESTINATION ${SARBLOCK_PYTHON_DIR} COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed")
endif()
if(TARGET sarblock_manual)
  set(manual ${PROJECT_BINARY_DIR}/manual)
  install(FILES ${manual}/sarblock.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT sarblock)
  install(FILES ${manual}/completion/sarblock
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT sarblock)
endif()
# A package has both under the names of its own rules.
install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT project)
install(FILES README.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT sarblock)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT sarblock
  FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png" PATTERN "*.cc" PATTERN "*.ipynb")
# Headers name pages: whoever has the library alone has them too.
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libsarblock-dev COMPONENT dev
  FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png" PATTERN "*.cc")

# What must be found before a library is linked, itself and all below it, as its targets name it.
function(sarblock_append_needs target out)
  get_target_property(aliased ${target} ALIASED_TARGET)
  if(aliased)
    set(target ${aliased})
  endif()
  get_target_property(links ${target} INTERFACE_LINK_LIBRARIES)
  set(needs ${${out}})
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" link "${link}")
    if(link STREQUAL sarblock::ceres)
      list(APPEND needs Ceres)
    elseif(link MATCHES "^sarblock::")
      sarblock_append_needs(${link} needs)
    elseif(link MATCHES "^([A-Za-z0-9_]+)::")
      list(APPEND needs ${CMAKE_MATCH_1})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES needs)
  set(${out} ${needs} PARENT_SCOPE)
endfunction()
set(sarblock_libraries)
set(sarblock_needs)
foreach(module IN LISTS sarblock_modules)
  get_target_property(library ${module} EXPORT_NAME)
  set(needs)
  sarblock_append_needs(${module} needs)
  string(APPEND sarblock_needs "set(sarblock_needs_${library} ${needs})\n")
  list(APPEND sarblock_libraries ${library})
endforeach()
configure_package_config_file(cmake/sarblock-config.cmake.in sarblock-config.cmake
  INSTALL_DESTINATION ${sarblock_package_dir})
write_basic_package_version_file(sarblock-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  cmake/one_blas.cmake
  ${PROJECT_BINARY_DIR}/sarblock-config.cmake
  ${PROJECT_BINARY_DIR}/sarblock-config-version.cmake
  DESTINATION ${sarblock_package_dir} COMPONENT dev)

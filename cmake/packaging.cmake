# Debian packages: `cpack -G DEB` in a build folder makes sarblock (the program; our libraries are
# inside it, others are depended on as dpkg-shlibdeps finds them), libsarblock-dev and, where they are
# built, python3-sarblock and sarblock-mpi, which alone depends on MPI.
# tests/package/check_deb.py holds them to their contents, scripts/deb_test.sh installs them.
find_program(GZIP gzip)
if(NOT GZIP OR NOT EXISTS /etc/debian_version)
  return()
endif()

# What only a package has: copyright and Debian changelog of each.
set(debian ${PROJECT_BINARY_DIR}/debian)
execute_process(COMMAND date --utc -R -d "${SARBLOCK_RELEASE_DATE} 12:00"
  OUTPUT_VARIABLE SARBLOCK_CHANGELOG_DATE OUTPUT_STRIP_TRAILING_WHITESPACE)
set(SARBLOCK_MAINTAINER
  "sarblock maintainers <maintainers@users.noreply.h-seed-4c7fffa1.example>")
set(component_of_sarblock sarblock)
set(component_of_libsarblock-dev dev)
set(component_of_python3-sarblock python3)
set(component_of_sarblock-mpi mpi)
set(packages sarblock libsarblock-dev)
if(TARGET sarblock_python)
  list(APPEND packages python3-sarblock)
endif()
if(TARGET sarblock_mpi)
  list(APPEND packages sarblock-mpi)
endif()
foreach(package IN LISTS packages)
  set(component ${component_of_${package}})
  configure_file(cmake/debian/changelog.in ${debian}/${package}/changelog.Debian @ONLY)
  execute_process(COMMAND ${GZIP} -9nkf ${debian}/${package}/changelog.Debian)
  install(FILES ${debian}/${package}/changelog.Debian.gz cmake/debian/copyright
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

# Where a package of Debian puts a Python package, whatever the version of Python.
if(TARGET sarblock_python)
  set(folder lib/python3/dist-packages)
  install(TARGETS sarblock_python LIBRARY DESTINATION ${folder}/sarblock COMPONENT python3 EXCLUDE_FROM_ALL)
  install(DIRECTORY src/python/sarblock DESTINATION ${folder} COMPONENT python3 EXCLUDE_FROM_ALL
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed")
endif()

# The libraries that the developer's package needs are those that the build needs.
file(STRINGS scripts/packages.txt lines)
set(needed)
set(section)
foreach(line IN LISTS lines)
  if(line MATCHES "^# (.*)")
    set(section ${CMAKE_MATCH_1})
  elseif(section STREQUAL "libraries" AND line)
    list(APPEND needed ${line})
  endif()
endforeach()
list(JOIN needed ", " needed)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sarblock)
set(CPACK_PACKAGE_VENDOR sarblock)
set(CPACK_PACKAGE_CONTACT "${SARBLOCK_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "stereo block adjustment for side-looking radar")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL sarblock dev)
if(TARGET sarblock_python)
  list(APPEND CPACK_COMPONENTS_ALL python3)
endif()
if(TARGET sarblock_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_SARBLOCK_PACKAGE_NAME sarblock)
set(CPACK_DEBIAN_SARBLOCK_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SARBLOCK_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_SARBLOCK_DESCRIPTION
"Takes what was measured in overlapping radar images, the flight paths as
 recorded and the points that are known, and gives the most probable positions
 of all points and corrections of all flight paths with their exact covariance.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsarblock-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${needed}")
set(CPACK_COMPONENT_DEV_DESCRIPTION
"Headers, static libraries and the CMake package of sarblock, for programs of
 one's own: find_package(sarblock).")
if(TARGET sarblock_python)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_NAME python3-sarblock)
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next_minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_SUGGESTS "python3-matplotlib, python3-pandas, python3-tqdm, python3-xarray")
  set(CPACK_COMPONENT_PYTHON3_DESCRIPTION
"The Python package of sarblock: blocks and results as numpy arrays, the
 adjustment, prediction and simulation of blocks, and pictures of results.")
endif()
if(TARGET sarblock_mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_NAME sarblock-mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "openmpi-bin")
  set(CPACK_DEBIAN_MPI_PACKAGE_SUGGESTS "sarblock")
  set(CPACK_COMPONENT_MPI_DESCRIPTION
"The adjustment of sarblock by several processes, on one machine or on many,
 which mpirun or a batch system starts; results have the bytes of one process.")
endif()
include(CPack)

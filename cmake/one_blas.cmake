# sarblock::ceres: Ceres with one BLAS in a program. The package files of Ceres name the BLAS that its
# builder had (ATLAS on Debian) by full paths beside ours, and the order of a link line, not we, would
# decide which of the two answers: programs of one build would round differently. So our libraries link
# Ceres with the BLAS that was found for `linear`. Ceres::ceres, which is not ours, stays as it is.
# Included after find_package of Ceres, BLAS and LAPACK, here and by users of the package.
if(NOT TARGET sarblock::ceres)
  add_library(sarblock::ceres INTERFACE IMPORTED GLOBAL)
  get_target_property(sarblock_ceres_imported Ceres::ceres IMPORTED)
  if(sarblock_ceres_imported)
    set(sarblock_ceres_libraries)
    get_target_property(sarblock_ceres_libraries Ceres::ceres INTERFACE_LINK_LIBRARIES)
    list(FILTER sarblock_ceres_libraries EXCLUDE REGEX "/lib(lapack|blas|f77blas|cblas|atlas|openblas)\\.(so|a)$")
    get_target_property(sarblock_ceres_file Ceres::ceres LOCATION)
    set_property(TARGET sarblock::ceres PROPERTY INTERFACE_LINK_LIBRARIES
      ${sarblock_ceres_file} ${sarblock_ceres_libraries} LAPACK::LAPACK BLAS::BLAS)
    foreach(sarblock_property IN ITEMS INCLUDE_DIRECTORIES COMPILE_DEFINITIONS COMPILE_OPTIONS COMPILE_FEATURES)
      get_target_property(sarblock_ceres_has Ceres::ceres INTERFACE_${sarblock_property})
      if(sarblock_ceres_has)
        set_property(TARGET sarblock::ceres PROPERTY INTERFACE_${sarblock_property} ${sarblock_ceres_has})
      endif()
    endforeach()
  else()  # built in the same tree, with a BLAS of its builder's choice
    set_property(TARGET sarblock::ceres PROPERTY INTERFACE_LINK_LIBRARIES Ceres::ceres)
  endif()
endif()

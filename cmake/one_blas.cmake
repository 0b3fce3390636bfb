# One BLAS in a program. The package files of Ceres name the BLAS that its builder had (ATLAS on
# Debian) by full paths beside ours, and the order of a link line, not we, would decide which of the
# two answers: programs of one build would round differently. So Ceres takes the BLAS that was found
# for `linear`. Included after find_package of Ceres, BLAS and LAPACK, here and by users of the package.
get_target_property(sarblock_ceres_libraries Ceres::ceres INTERFACE_LINK_LIBRARIES)
list(FILTER sarblock_ceres_libraries EXCLUDE REGEX "/lib(lapack|blas|f77blas|cblas|atlas|openblas)\\.(so|a)$")
list(APPEND sarblock_ceres_libraries LAPACK::LAPACK BLAS::BLAS)
set_target_properties(Ceres::ceres PROPERTIES INTERFACE_LINK_LIBRARIES "${sarblock_ceres_libraries}")

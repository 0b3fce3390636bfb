// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/image_grid.h"

#include <vector>

namespace sarblock {

/// Polynomials at close times, linear between which is what USGSCSM computes of these between
/// `start_s` and `end_s`: it takes N polynomials as if they stood `span / N` apart from the time of
/// the first one and interpolates their coefficients with Lagrange's polynomial of up to eight
/// (usgscsm/src/UsgsAstroSarSensorModel.cpp, getRangeCoefficients; Utilities.cpp, lagrangeInterp).
/// 32 polynomials an interval: within 1 mm of it for coefficients as uneven as those of LRO.
[[nodiscard]] std::vector<GroundRangePolynomial> AsUsgscsmReads(
    const std::vector<GroundRangePolynomial>& given, double start_s, double end_s);

/// The row at `place`, counted in rows from the first one, as USGSCSM interpolates in a table of
/// evenly spaced rows: Lagrange's polynomial of up to eight. Two rows or more, equally long.
[[nodiscard]] std::vector<double> AsUsgscsmInterpolates(
    const std::vector<std::vector<double>>& rows, double place);

/// The reverse of AsUsgscsmReads(): polynomials that USGSCSM reads, from `start_s` to `end_s`, as
/// the given ones are at their own times, linear between these; so does who takes them at their
/// times. They stand close together, four beyond both ends.
[[nodiscard]] std::vector<GroundRangePolynomial> ForUsgscsm(
    const std::vector<GroundRangePolynomial>& given, double start_s, double end_s);

}  // namespace sarblock

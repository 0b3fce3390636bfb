// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "products/synthetic_annotation.h"

namespace sarblock::test {

/// Metadata of an ICEYE image made from the orbit of SyntheticAnnotation: 2001 lines of 0.01 s from
/// 23:59:50.25 on, 1001 samples of 10 m of ground range, corners 100 m high, no RPC.
struct SyntheticIceye {
  SyntheticAnnotation orbit;
  double first_line_s = 50.25;

  static constexpr int kLines = 2001, kSamples = 1001;
  static constexpr double kLineInterval_s = 0.01;
  static constexpr double kPixel_m = 10.0;
  static constexpr double kHeight_m = 100.0;

  [[nodiscard]] std::string Xml() const;
  [[nodiscard]] static double SlantRange_m(double sample) {
    const double g_m = sample * kPixel_m;
    return 850123.5 + g_m * (0.6 + g_m * 3e-7);
  }
  /// Where a line and a sample lie on the ground, in earth-fixed axes.
  [[nodiscard]] Eigen::Vector3d Ground_m(double line, double sample) const;
};

}  // namespace sarblock::test

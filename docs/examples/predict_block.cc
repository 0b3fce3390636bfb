// SPDX-License-Identifier: Apache-2.0
// Reads a block's folder and says what accuracy its points would have with the control it has and
// with one control point after the other taken away. docs/api.md explains it.
//
// Usage: predict_block BLOCK
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

#include <sarblock/adjust/adjust.h>
#include <sarblock/core/error.h>
#include <sarblock/files/block_file.h>

namespace {

// [predict]
/// The largest standard deviation of a height, from geometry and weights alone.
double LargestHeightSigma_m(const sarblock::files::BlockFile& file, const sarblock::Truth& truth) {
  const sarblock::AdjustResult result = sarblock::Predict(file.block, file.adjust, truth.points_m);
  double largest_m2 = 0.0;
  for (std::size_t i = 0; i < result.points.status.size(); ++i) {
    if (!sarblock::IsSolved(result.points.status[i])) continue;
    largest_m2 = std::max(largest_m2, result.points.covariance_m2[i][2]);
  }
  return std::sqrt(largest_m2);
}
// [predict]

int Run(const char* folder) {
  // [read]
  sarblock::files::ReadOptions read;
  read.measurements = sarblock::files::Measurements::kOptional;  // a plan has none
  sarblock::files::BlockFile file = sarblock::files::ReadBlock(folder, read);
  const sarblock::Truth truth = sarblock::files::ReadTruth(folder, file.block);
  // [read]
  double before_m = 0.0;
  for (;;) {
    const double sigma_m = LargestHeightSigma_m(file, truth);
    std::printf("%2zu control points: sigma_u at most %.2f m\n",
                static_cast<std::size_t>(std::count(file.block.points.role.begin(),
                                                    file.block.points.role.end(),
                                                    sarblock::PointRole::kControl)),
                sigma_m);
    if (sigma_m < before_m) return 1;  // less control cannot be better
    before_m = sigma_m;
    // [release]
    const auto last = std::find_if(
        file.block.points.known.rbegin(), file.block.points.known.rend(), [&](const auto& known) {
          return file.block.points.role[known.point] == sarblock::PointRole::kControl;
        });
    if (last == file.block.points.known.rend()) return 0;
    file.block.points.role[last->point] = sarblock::PointRole::kTie;
    file.block.points.known.erase(std::next(last).base());
    // [release]
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: predict_block BLOCK\n");
    return 2;
  }
  // [errors]
  try {
    return Run(argv[1]);
  } catch (const sarblock::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());  // FILE:LINE: field: what is wrong
    return 3;
  } catch (const sarblock::UndeterminedError& error) {
    std::fprintf(stderr, "%s\n", error.what());  // names the parameters or points
    return 4;
  }
  // [errors]
}

// SPDX-License-Identifier: Apache-2.0
// A program that is compiled for the processor at hand, as many are, with a library that is not: a
// matrix goes from one to the other and back. Eigen aligns its memory by the instructions that the
// compiler may use, so that matrices of Eigen would end in a crash. The standard deviations by
// hand: of sigma 20, 50, 10 m without looks that say more.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <sarblock/adjust/adjust.h>
#include <sarblock/files/block_file.h>

int main() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "sarblock_native";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "block.toml") << R"(format = "sarblock-block 1"
[frame]
kind = "local"
[sigma]
range_m = 0.5
azimuth_m = 0.5
[adjust]
corrections = "given"
[adjust.correction.position]
degree = 0
[adjust.prior.orbit]
parameters = ["position.along.0", "position.across.0", "position.up.0"]
covariance = [[400, 0, 0], [0, 2500, 100], [0, 100, 100]]
[[pass]]
id = "A"
look = "left"
[[pass]]
id = "B"
look = "left"
)";
  std::ofstream(folder / "trajectories.csv")
      << "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
         "A,0,0,0,6000,150,0,0\nA,40,6000,0,6000,150,0,0\n"
         "B,0,0,4000,6000,150,0,0\nB,40,6000,4000,6000,150,0,0\n";
  std::ofstream(folder / "observations.csv")
      << "pass,point,time_s,range_m\nA,P,10,10000\nB,P,10,7211.102550927978\n";
  const sarblock::files::BlockFile file = sarblock::files::ReadBlock(folder.string(), {});
  sarblock::AdjustOptions options = file.adjust;
  options.priors.push_back(options.priors[0]);  // copied by this program, and given up again
  options.priors.pop_back();
  const sarblock::DenseMatrix covariance = options.priors[0].Covariance();
  const sarblock::AdjustResult result = sarblock::Adjust(file.block, options);
  bool right = covariance(1, 2) == 100.0 && result.joint_priors.size() == 2 &&
               result.joint_priors[1].covariance == covariance;
  for (std::size_t i = 0; i < 3; ++i) {
    const double given = std::sqrt(covariance(i, i)), sigma = result.parameters[i].sigma;
    right = right && sigma > 0.1 * given && sigma < 1.0001 * given;
  }
  std::printf("%s\n", right ? "right" : "wrong");
  return right ? 0 : 1;
}

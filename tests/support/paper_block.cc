// SPDX-License-Identifier: Apache-2.0
#include "support/paper_block.h"

#include <cmath>
#include <optional>
#include <string>

namespace sarblock::test {

Block MakePaperBlock(const std::vector<PaperPass>& passes,
                     const std::vector<Eigen::Vector3d>& points_m) {
  constexpr double kSpeed_mps = 211.0;
  Block block;
  block.name = "paper";
  for (const PaperPass& plan : passes) {
    Pass pass;
    pass.id = "A" + std::to_string(block.passes.size() + 1);
    pass.side = points_m.front().y() > plan.across_m ? LookSide::kLeft : LookSide::kRight;
    std::vector<StateVector> states;
    for (int k = 0; k <= 4; ++k) {
      const double time_s = 250.0 * k;
      states.push_back({time_s,
                        {kSpeed_mps * (time_s - 500.0), plan.across_m, plan.height_m},
                        {kSpeed_mps, 0.0, 0.0}});
    }
    pass.path = FlightPath(std::move(states));
    pass.sigma = {plan.range_sigma_m, 1.3, AzimuthUnit::kMetres};
    block.passes.push_back(std::move(pass));
  }
  for (const Eigen::Vector3d& p_m : points_m) {
    block.points.ids.Append("P" + std::to_string(block.points.size() + 1));
    block.points.role.push_back(PointRole::kTie);
    block.points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
    for (std::size_t i = 0; i < passes.size(); ++i) {
      // tan(tau) is the distance ahead over the distance in the plane across the track
      const double plane_m = std::hypot(p_m.y() - passes[i].across_m, p_m.z() - passes[i].height_m);
      const double ahead_m = plane_m * std::tan(passes[i].squint_rad);
      block.looks.pass.push_back(static_cast<std::uint32_t>(i));
      block.looks.flags.push_back(0);
      block.looks.time_s.push_back(500.0 + (p_m.x() - ahead_m) / kSpeed_mps);
      block.looks.range_m.push_back(std::hypot(plane_m, ahead_m));
      block.looks.cone.push_back(passes[i].squint_rad);
    }
    block.looks.offsets.push_back(block.looks.size());
  }
  SetStripSpans(std::vector<std::optional<std::array<double, 2>>>(passes.size()), &block);
  return block;
}

}  // namespace sarblock::test

// SPDX-License-Identifier: Apache-2.0
// A program with threads and loops of its own, compiled under ThreadSanitizer where there is one:
// two adjustments of one const block at once, its own loops of TBB and threads that read HDF5 files
// beside them, and a third one that another thread stops. Adjustments at once are those alone to
// the bit, what is read is what was written, the loops have all threads of the process, the stop is
// seen.
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <sarblock/adjust/adjust.h>
#include <sarblock/core/error.h>
#include <sarblock/core/statistics.h>
#include <sarblock/files/block_file.h>

namespace {

using Eigen::Vector3d;

/// Two passes beside each other and points on a grid, with noise of half a metre.
sarblock::Block GridBlock(int points) {
  sarblock::Block block;
  block.name = "grid";
  for (int p = 0; p < 2; ++p) {
    sarblock::Pass pass;
    pass.id = p == 0 ? "A" : "B";
    std::vector<sarblock::StateVector> states;
    for (double t_s = -20.0; t_s <= 220.0; t_s += 10.0) {
      states.push_back({t_s, {150.0 * t_s, 4000.0 * p, 6000.0}, {150.0, 0.0, 0.0}});
    }
    pass.path = sarblock::FlightPath(states);
    pass.side = sarblock::LookSide::kLeft;
    pass.sigma = {0.5, 0.5, sarblock::AzimuthUnit::kMetres};
    block.passes.push_back(pass);
  }
  sarblock::RandomStream random(7, 1);
  std::vector<std::uint32_t> point_of_look;
  for (int i = 0; i < points; ++i) {
    const Vector3d p_m(30000.0 * i / points, 9000.0 + 100.0 * (i % 40), 0.0);
    const std::uint32_t point = block.points.ids.Append("T" + std::to_string(i));
    block.points.role.push_back(sarblock::PointRole::kTie);
    block.points.given_m.push_back(Vector3d::Constant(sarblock::kNotGiven));
    for (std::uint32_t pass = 0; pass < 2; ++pass) {
      point_of_look.push_back(point);
      block.looks.pass.push_back(pass);
      block.looks.flags.push_back(0);
      block.looks.time_s.push_back((p_m.x() + 0.5 * random.Normal()) / 150.0);
      block.looks.range_m.push_back(std::hypot(p_m.y() - 4000.0 * pass, 6000.0) +
                                    0.5 * random.Normal());
    }
  }
  sarblock::SortLooksByPoint(point_of_look, block.points.size(), &block.looks);
  sarblock::SetStripSpans({}, &block);
  return block;
}

sarblock::AdjustOptions Options(int threads) {
  sarblock::PositionCorrection shift;
  for (auto& sigma_m : shift.prior_sigma_m) sigma_m = {2.0};
  sarblock::AdjustOptions options;
  options.groups = {{"position", shift, {}, false}};
  options.threads = threads;
  return options;
}

/// Asks to stop once another thread says so.
class Stopping final : public sarblock::ProgressSink {
 public:
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {
    started_ = true;
  }
  bool Cancelled() const override { return stop_; }
  void Stop() { stop_ = true; }
  bool started() const { return started_; }

 private:
  std::atomic<bool> stop_{false}, started_{false};
};

bool Same(const sarblock::AdjustResult& a, const sarblock::AdjustResult& b) {
  return a.points.position_m == b.points.position_m &&
         a.points.covariance_m2 == b.points.covariance_m2 && a.sigma0_squared == b.sigma0_squared;
}

}  // namespace

int main() {
  const sarblock::Block block = GridBlock(4000);
  const sarblock::AdjustResult alone = sarblock::Adjust(block, Options(0));
  const auto of_the_process = [] {
    return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  };
  const std::size_t threads = of_the_process();
  std::atomic<bool> limited{false}, wrong{false}, misread{false};
  std::vector<std::thread> working;
  for (int t = 1; t <= 2; ++t) {
    working.emplace_back([&, t] {
      for (int k = 0; k < 3; ++k) {
        if (!Same(alone, sarblock::Adjust(block, Options(t)))) wrong = true;
      }
    });
  }
  const std::filesystem::path file = "host_block.h5";
  sarblock::files::WriteBlock(file, block, {});
  for (int t = 0; t < 2; ++t) {
    working.emplace_back([&] {
      for (int k = 0; k < 5; ++k) {
        const sarblock::Block read = sarblock::files::ReadBlock(file).block;
        if (read.looks.range_m != block.looks.range_m) misread = true;
      }
    });
  }
  std::vector<double> values(100000);
  for (int k = 0; k < 50; ++k) {
    tbb::parallel_for(
        0, 100000, [&](int i) { values[static_cast<std::size_t>(i)] += std::sqrt(i); });
    if (of_the_process() != threads) limited = true;
  }
  for (std::thread& thread : working) thread.join();

  Stopping sink;
  bool stopped = false;
  std::thread one([&] {
    try {
      const sarblock::Block large = GridBlock(40000);
      static_cast<void>(sarblock::Adjust(large, Options(2), {}, &sink));
    } catch (const sarblock::Interrupted&) {
      stopped = true;
    }
  });
  while (!sink.started()) std::this_thread::yield();
  sink.Stop();
  one.join();

  const bool right = alone.accepted() && !limited && !wrong && !misread && stopped &&
                     std::abs(values[10000] - 50.0 * 100.0) < 1e-9;
  std::printf("accepted %d, at once as alone %d, read %d, loops not limited %d, stopped %d\n",
              alone.accepted() ? 1 : 0,
              wrong ? 0 : 1,
              misread ? 0 : 1,
              limited ? 0 : 1,
              stopped ? 1 : 0);
  return right ? 0 : 1;
}

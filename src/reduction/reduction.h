// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/utc.h"
#include <Eigen/Core>

namespace sarblock {

/// Positions of the bodies that raise tides at an instant, the same for all points. They take some
/// tens of microseconds to compute, a displacement takes one. The tide moves by up to 2e-5 m a
/// second.
struct TidalBodies {
  std::array<Eigen::Vector3d, 2> positions_m;  ///< of Moon and Sun, Earth-fixed
  double sidereal_rad = 0.0;                   ///< Greenwich mean sidereal time
  std::array<double, 5> delaunay_rad{};        ///< l, l', F, D, Omega
};

/// Throws InputError ("utc") before 1972 and after 2034, and for a text that is no time in UTC.
[[nodiscard]] TidalBodies TidalBodiesAt(const UtcTime& time);
[[nodiscard]] TidalBodies TidalBodiesAt(std::string_view utc);

/// Displacement of a point with that position, both in Earth-fixed axes [m].
[[nodiscard]] Eigen::Vector3d SolidEarthTide_m(const TidalBodies& bodies,
                                               const Eigen::Vector3d& position_m);

/// Slant over zenith delay of the troposphere by the cosine of the zenith angle at the ground,
/// after Black and Eisner (1984): the secant but for the curvature of the atmosphere (docs/theory/
/// reductions.md, eq. (0)).
[[nodiscard]] double SlantFactor(double cos_zenith);

/// Sources of the reductions that are subtracted from measured ranges and times.
enum class ReductionSource : std::uint8_t {
  kGiven,  ///< Looks::range_delay_m and time_shift_s
  kTroposphere,
  kIonosphere,
  kTide,
  kMotion,    ///< of known points since the epoch of their positions
  kConstant,  ///< of the pass
};
inline constexpr std::size_t kReductionSources = 6;

/// Reductions of one look, by ReductionSource: measured less geometric.
struct LookReduction {
  std::array<double, kReductionSources> range_m{}, time_s{};
  [[nodiscard]] double Range_m() const;
  [[nodiscard]] double Time_s() const;
};

/// A reduction model or value that a pass cannot have.
struct ReductionProblem {
  std::size_t pass = 0;
  std::string key;  ///< of the pass: "reduction.troposphere", "epoch_utc"
  std::string problem;
};
/// The first problem of models by pass: values beyond their domain (ReductionModels), a body
/// without the Earth's atmosphere or tide, an ionosphere without a wavelength or above the antenna,
/// an invalid date.
[[nodiscard]] std::optional<ReductionProblem> FindProblem(
    const Block& block, const std::vector<ReductionModels>& models);

/// The models of the passes of a block.
[[nodiscard]] std::vector<ReductionModels> ModelsOf(const Block& block);

/// Evaluates models by pass for looks of a block (docs/theory/reductions.md).
class ReductionOfLooks {
 public:
  /// Throws InputError for what FindProblem() finds. The block must live as long.
  ReductionOfLooks(const Block& block, std::vector<ReductionModels> models);
  ~ReductionOfLooks();
  ReductionOfLooks(ReductionOfLooks&&) noexcept;
  ReductionOfLooks& operator=(ReductionOfLooks&&) = delete;
  ReductionOfLooks(const ReductionOfLooks&) = delete;
  ReductionOfLooks& operator=(const ReductionOfLooks&) = delete;

  /// Whether anything is to be evaluated.
  [[nodiscard]] bool any() const;
  /// Reductions of a look of `pass` at `time_s` at a point at p_m (frame axes), which moves by
  /// `velocity_mpy`. Without a finite position only the constants. kGiven is 0.
  [[nodiscard]] LookReduction Of(std::uint32_t pass,
                                 double time_s,
                                 const Cone& cone,
                                 const Eigen::Vector3d& p_m,
                                 const Eigen::Vector3d& velocity_mpy) const;

 private:
  struct PassModel;
  const Block& block_;
  std::vector<PassModel> passes_;
  bool any_ = false;
};

/// A block whose looks are reduced to geometry: the values of its passes' models at the positions
/// of its points are subtracted. Copies the block where there are models; the passes of the copy
/// have none.
class ReducedBlock {
 public:
  /// Throws InputError for what FindProblem() finds. The block must live as long.
  explicit ReducedBlock(const Block& block);

  [[nodiscard]] const Block& block() const { return reduced_ ? *reduced_ : given_; }
  [[nodiscard]] bool HasModels() const { return reduced_.has_value(); }
  /// Subtracts the models' values at these positions (by point, frame axes). Where a position is
  /// NaN, looks stay as they are: at first with the constants alone subtracted. Returns the largest
  /// change [m]; a time counts by the way of the antenna in it. Changes nothing where that is at
  /// most `settled_m`.
  double ReduceAt(const std::vector<Eigen::Vector3d>& position_m, double settled_m = 0.0);
  /// What was subtracted.
  [[nodiscard]] Reductions Report() const;

 private:
  [[nodiscard]] LookReduction Of(std::size_t look,
                                 std::size_t point,
                                 const Eigen::Vector3d& p_m) const;
  void TakeOff();

  const Block& given_;
  ReductionOfLooks models_;
  std::optional<Block> reduced_;
  std::vector<Eigen::Vector3d> position_m_;  // where the models were evaluated
};

}  // namespace sarblock

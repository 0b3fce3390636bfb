// SPDX-License-Identifier: Apache-2.0
#include "read_recorded.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "geometry/recorded_states.h"
#include "swath.h"

namespace sarblock {
namespace {

/// The ways of kAuto, the nearest to the data first.
constexpr std::array<PathThrough, 4> kWays{
    PathThrough::kStates, PathThrough::kOrbit, PathThrough::kPositions, PathThrough::kSmooth};

/// What the looks of a pass say of its target.
struct TargetOfPass {
  double range_m = 0.0;  ///< largest
  double azimuth_sigma_m = kNotGiven;
};

/// Mean height of the given points of a local frame, 0 without any.
double GroundHeight_m(const Block& block) {
  double sum_m = 0.0, count = 0.0;
  for (const Eigen::Vector3d& given_m : block.points.given_m) {
    if (!given_m.allFinite()) continue;
    sum_m += given_m.z();
    count += 1.0;
  }
  return count > 0.0 ? sum_m / count : 0.0;
}

/// What the swath of a pass says of its target, in a plan whose looks have no ranges.
TargetOfPass TargetInSwath(const Block& block, const Pass& pass, double ground_m) {
  TargetOfPass target;
  if (!pass.swath || pass.path.states().empty()) return target;
  const StateVector& state = pass.path.states().front();
  const bool geocentric = block.frame.kind() == FrameKind::kGeocentric;
  const double infinite = std::numeric_limits<double>::infinity();
  const double antenna_radius_m = geocentric ? state.position_m.norm() : infinite;
  const double depth_m = geocentric ? block.frame.GeodeticFromFrame(state.position_m).h_m
                                    : state.position_m.z() - ground_m;
  const double range_m =
      FarRange(*pass.swath, depth_m, antenna_radius_m, antenna_radius_m - depth_m);
  if (!(range_m > 0.0) || pass.sigma.azimuth_unit == AzimuthUnit::kHertz) return target;
  target.range_m = range_m;
  target.azimuth_sigma_m =
      pass.sigma.azimuth *
      (pass.sigma.azimuth_unit == AzimuthUnit::kSeconds ? state.velocity_mps.norm() : 1.0);
  return target;
}

std::vector<TargetOfPass> TargetsOf(const Block& block) {
  // By pass: the standard deviation of azimuth in metres where it is that of all looks, else NaN.
  const bool own = !block.looks.azimuth_sigma.empty();
  std::vector<double> same_m, speed_mps;
  for (const Pass& pass : block.passes) {
    const bool same = !own && pass.sigma.azimuth_unit == AzimuthUnit::kMetres;
    same_m.push_back(same ? pass.sigma.azimuth : kNotGiven);
    const auto& states = pass.path.states();
    speed_mps.push_back(states.empty() ? kNotGiven : states.front().velocity_mps.norm());
  }
  struct Sum {
    double range_m = 0.0, sigma_m = 0.0, count = 0.0;  // the largest range
  };
  const std::vector<Sum> none(block.passes.size());
  const std::size_t looks = block.looks.size();
  std::vector<std::vector<Sum>> pieces(PiecesOfLooks(looks), none);
  ForPiecesOfLooks(looks, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t pass = block.looks.pass[i];
      if (block.looks.rejected(i) || std::isnan(block.looks.range_m[i])) continue;
      double sigma_m = same_m[pass];
      if (!(sigma_m > 0.0)) {
        if (!(block.SigmaOf(i).azimuth > 0.0)) continue;
        sigma_m = block.ApproximateAzimuthSigma_m(i, speed_mps[pass]);
      }
      Sum& sum = pieces[piece][pass];
      sum.range_m = std::max(sum.range_m, block.looks.range_m[i]);
      sum.sigma_m += sigma_m;
      sum.count += 1.0;
    }
  });
  std::vector<Sum> all = none;
  for (const std::vector<Sum>& piece : pieces) {
    for (std::size_t pass = 0; pass < all.size(); ++pass) {
      all[pass].range_m = std::max(all[pass].range_m, piece[pass].range_m);
      all[pass].sigma_m += piece[pass].sigma_m;
      all[pass].count += piece[pass].count;
    }
  }
  std::vector<TargetOfPass> out(all.size());
  const bool plan =
      std::none_of(all.begin(), all.end(), [](const Sum& sum) { return sum.count > 0.0; });
  const double ground_m = plan ? GroundHeight_m(block) : 0.0;
  for (std::size_t pass = 0; pass < out.size(); ++pass) {
    if (plan) out[pass] = TargetInSwath(block, block.passes[pass], ground_m);
    if (!(all[pass].count > 0.0)) continue;
    out[pass].range_m = std::max(out[pass].range_m, all[pass].range_m);
    out[pass].azimuth_sigma_m = all[pass].sigma_m / all[pass].count;
  }
  return out;
}

/// Errors of a path at the target.
RecordingEffect EffectOf(const RecordedPath& read, const TargetOfPass& target, double speed_mps) {
  const double turning_s = target.range_m / speed_mps;
  const PathErrors& errors = read.errors;
  RecordingEffect out;
  out.through = read.through;
  out.noise_m = std::hypot(errors.noise.position_m, turning_s * errors.noise.velocity_mps);
  out.contradiction_m = turning_s * errors.contradiction_mps;
  out.interpolation_m = std::hypot(errors.interpolation_m, turning_s * errors.interpolation_mps);
  out.azimuth_sigma_m = target.azimuth_sigma_m;
  out.noise = read.noise;
  out.fit = read.fit;
  return out;
}

/// A recording and the ways to read it.
class Ways {
 public:
  Ways(const Pass& pass, const TargetOfPass& target)
      : recording_(pass.RecordedStates(), pass.recorded.asked.sigma, {pass.start_s, pass.end_s}),
        target_(target),
        speed_mps_(pass.path.states().front().velocity_mps.norm()) {}

  struct Way {
    RecordingEffect effect;
    std::optional<FlightPath> path;  ///< of kSmooth, which cannot be measured without
  };
  [[nodiscard]] Way Measure(PathThrough through) const {
    if (through == PathThrough::kSmooth) return Read(through);
    RecordedPath read;
    read.through = through;
    read.errors = recording_.ErrorsOf(through);
    read.noise = recording_.noise();
    return {EffectOf(read, target_, speed_mps_), std::nullopt};
  }

  /// The first way whose effect does not matter, or that of least effect.
  [[nodiscard]] Way Choose() const {
    Way best = Measure(kWays.front());
    for (std::size_t i = 1; i < kWays.size() && best.effect.Matters(); ++i) {
      try {
        Way way = Measure(kWays[i]);
        if (way.effect.Total_m() < best.effect.Total_m()) best = std::move(way);
      } catch (const InputError&) {  // states of which no such path can be made
      }
    }
    return best;
  }

  [[nodiscard]] FlightPath PathOf(Way way) const {
    return way.path ? std::move(*way.path) : *Read(way.effect.through).path;
  }

 private:
  [[nodiscard]] Way Read(PathThrough through) const {
    // The states made for a polynomial add a thousandth of sigma, a nanoradian where none is known.
    const double known_rad = 1e-3 * target_.azimuth_sigma_m / target_.range_m;
    RecordedPath read = recording_.Read(through, known_rad > 0.0 ? known_rad : 1e-9);
    const RecordingEffect effect = EffectOf(read, target_, speed_mps_);
    return {effect, std::move(read.path)};
  }

  Recording recording_;
  const TargetOfPass& target_;
  double speed_mps_;
};

std::string Parts(const RecordingEffect& effect) {
  return "noise of states " + Digits(effect.noise_m, 3) +
         " m, velocities that contradict positions " + Digits(effect.contradiction_m, 3) +
         " m, between states " + Digits(effect.interpolation_m, 3) + " m";
}

std::string Named(PathThrough through) {
  return std::string("through = \"") + NameOf(through) + "\"";
}

/// Why kAuto took what it took.
std::string WhyChosen(const RecordingEffect& chosen, const RecordingEffect& states) {
  if (std::isnan(chosen.azimuth_sigma_m)) return "no look says how far a target is: states";
  const std::string sigma = " m (sigma of azimuth " + Digits(chosen.azimuth_sigma_m, 3) + " m)";
  if (chosen.through == PathThrough::kStates) {
    return chosen.Matters()
               ? "the states move points along track by " + Digits(chosen.Total_m(), 3) + sigma +
                     ", no other way by less"
               : "the states move points along track by " + Digits(chosen.Total_m(), 3) + sigma;
  }
  return std::string(NameOf(chosen.through)) + " moves points along track by " +
         Digits(chosen.Total_m(), 3) + sigma + ", the states by " + Digits(states.Total_m(), 3) +
         " m: " + Parts(states);
}

/// Calls `make` for a pass, whose name an InputError gets: sizes of states that cannot be computed
/// with are seen only here.
template <typename Make>
auto NamingPass(const Pass& pass, const FilePlace& place, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    throw InputError(place,
                     "no path can be made of its states " + Named(pass.recorded.asked.through) +
                         ": " + error.what());
  }
}

/// A recording that matters, and the way that would make it matter less: its own where none would.
struct Remark {
  std::size_t pass = 0;
  PathThrough through = PathThrough::kStates, remedy = PathThrough::kStates;
  double effect_ratio = 0.0;  ///< of the sigma of azimuth
  double remedied_m = 0.0;
};

std::optional<Remark> RemarkOn(const Block& block, std::size_t index, const Ways& ways) {
  const RecordedFlight& recorded = block.passes[index].recorded;
  const RecordingEffect& effect = recorded.effect;
  if (!effect.Matters()) return std::nullopt;
  const double effect_ratio = effect.Total_m() / effect.azimuth_sigma_m;
  Remark remark{index, effect.through, effect.through, effect_ratio, effect.Total_m()};
  if (recorded.asked.through == PathThrough::kAuto) return remark;
  const RecordingEffect best = ways.Choose().effect;
  constexpr double kWorthIt = 0.7;
  if (best.Total_m() < kWorthIt * effect.Total_m()) {
    remark.remedy = best.through;
    remark.remedied_m = best.Total_m();
  }
  return remark;
}

/// One warning for all passes that were read in one way and have one remedy, in the words of the
/// worst.
std::string RecordingWarning(const Block& block, const std::vector<Remark>& alike) {
  const Remark& worst =
      *std::max_element(alike.begin(), alike.end(), [](const Remark& a, const Remark& b) {
        return a.effect_ratio < b.effect_ratio;
      });
  const RecordingEffect& effect = block.passes[worst.pass].recorded.effect;
  std::string text = "pass " + block.passes[worst.pass].id + ": its recorded flight, read " +
                     Named(effect.through) + ", moves points along track by " +
                     Digits(effect.Total_m(), 3) +
                     " m (root mean square at the largest range: " + Parts(effect) +
                     "), sigma of azimuth is " + Digits(effect.azimuth_sigma_m, 3) + " m";
  if (worst.remedy != worst.through) {
    text += ": " + Named(worst.remedy) + " in its trajectory makes that " +
            Digits(worst.remedied_m, 3) + " m";
  } else {
    text += ", and no other way to read it is better: better or denser states are needed, or " +
            Digits(std::hypot(effect.azimuth_sigma_m, effect.Total_m()), 3) +
            " m as sigma of azimuth";
  }
  constexpr std::size_t kNamed = 5;
  std::size_t others = 0;
  for (const Remark& remark : alike) {
    if (remark.pass == worst.pass || ++others > kNamed) continue;
    text += (others == 1 ? "; less, but in the same way: " : ", ") + block.passes[remark.pass].id;
  }
  return others > kNamed ? text + " and " + std::to_string(others - kNamed) + " more" : text;
}

/// Warnings of remarks, those alike in one.
std::vector<std::string> RecordingWarnings(const Block& block, const std::vector<Remark>& remarks) {
  std::map<std::pair<PathThrough, PathThrough>, std::vector<Remark>> groups;
  for (const Remark& remark : remarks) groups[{remark.through, remark.remedy}].push_back(remark);
  std::vector<std::string> warnings;
  for (const auto& [ways, alike] : groups) warnings.push_back(RecordingWarning(block, alike));
  return warnings;
}

/// Whether states fit their standard deviations: a test at 99.9 %, and a factor that matters.
std::string FitWarning(const Pass& pass) {
  const std::optional<FitOfStates>& fit = pass.recorded.effect.fit;
  if (!fit) return "";
  constexpr double kLevel = 0.999, kFactor = 1.1;
  const StateNoise& sigma = pass.recorded.asked.sigma;
  std::string text;
  const auto test =
      [&](const char* what, const char* key, double given, double ratio, double freedom) {
        if (std::isnan(given) || !(freedom >= 1.0)) return;
        const double factor = std::sqrt(ratio);
        if (factor <= kFactor && factor >= 1.0 / kFactor) return;
        if (ChiSquareInterval(kLevel, freedom).Contains(ratio * freedom)) return;
        text += (text.empty() ? "" : "; ") + std::string(what) + " are off by " +
                Digits(factor, 3) + " times what " + key + " = " + Digits(given, 3) + " says";
      };
  test("positions", "sigma_m", sigma.position_m, fit->position_ratio, fit->position_freedom);
  test("velocities", "sigma_mps", sigma.velocity_mps, fit->velocity_ratio, fit->velocity_freedom);
  if (text.empty()) return "";
  return "pass " + pass.id + ": its states do not fit the smoothed path as stated: " + text +
         " (chi-square test at 99.9 %)";
}

/// Makes the path of a pass in the way that it asks for. Nothing where it stays as it is.
std::optional<Ways> ReadPass(const TargetOfPass& target, const FilePlace& place, Pass* read) {
  Pass& pass = *read;
  const PathThrough asked = pass.recorded.asked.through;
  pass.recorded.effect = {};
  pass.recorded.effect.azimuth_sigma_m = target.azimuth_sigma_m;
  if (asked == PathThrough::kStates && pass.recorded.states.empty() && pass.path.IsStraight()) {
    return std::nullopt;  // without noise, and a cubic follows it
  }
  std::optional<Ways> ways(std::in_place, pass, target);
  Ways::Way way = NamingPass(pass, place, [&] {
    return asked == PathThrough::kAuto ? ways->Choose() : ways->Measure(asked);
  });
  if (asked == PathThrough::kAuto) {
    way.effect.why = WhyChosen(way.effect, ways->Measure(PathThrough::kStates).effect);
  }
  pass.recorded.effect = way.effect;
  const bool through_states = way.effect.through == PathThrough::kStates;
  const bool was_through_states = pass.recorded.states.empty();
  if (!through_states && was_through_states) pass.recorded.states = pass.path.states();
  if (!through_states || !was_through_states) {
    pass.path = NamingPass(pass, place, [&] { return ways->PathOf(std::move(way)); });
  }
  if (through_states) pass.recorded.states.clear();
  return ways;
}

FilePlace PlaceOfPass(const Block& block, std::span<const FilePlace> places, std::size_t i) {
  if (places.empty()) return {"", 0, "pass " + block.passes[i].id};
  return {places[i].file, places[i].line, "pass[" + std::to_string(i) + "]"};
}

}  // namespace

std::vector<std::string> ReadRecordedFlights(Block* block, std::span<const FilePlace> places) {
  constexpr std::size_t kNamedMisfits = 5;
  std::vector<std::string> warnings;
  std::vector<Remark> remarks;
  std::size_t misfits = 0;
  const std::vector<TargetOfPass> targets = TargetsOf(*block);
  for (std::size_t i = 0; i < block->passes.size(); ++i) {
    Pass& pass = block->passes[i];
    const std::optional<Ways> ways = ReadPass(targets[i], PlaceOfPass(*block, places, i), &pass);
    if (!ways) continue;
    if (const auto remark = RemarkOn(*block, i, *ways)) remarks.push_back(*remark);
    const std::string misfit = FitWarning(pass);
    if (!misfit.empty() && ++misfits <= kNamedMisfits) warnings.push_back(misfit);
  }
  if (misfits > kNamedMisfits) {
    warnings.push_back("states of " + std::to_string(misfits - kNamedMisfits) +
                       " passes more do not fit their smoothed paths as stated");
  }
  for (std::string& warning : RecordingWarnings(*block, remarks)) {
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

void ReadRecordedFlights(const std::vector<std::uint32_t>& passes, Block* block) {
  const std::vector<TargetOfPass> targets = TargetsOf(*block);
  for (const std::uint32_t i : passes) {
    static_cast<void>(ReadPass(targets[i], PlaceOfPass(*block, {}, i), &block->passes[i]));
  }
}

std::vector<double> PathTimes_s(const Pass& pass) {
  std::vector<double> times_s;
  for (const StateVector& state : pass.path.states()) times_s.push_back(state.time_s);
  for (const StateVector& state : pass.recorded.states) times_s.push_back(state.time_s);
  std::sort(times_s.begin(), times_s.end());
  times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
  return times_s;
}

}  // namespace sarblock

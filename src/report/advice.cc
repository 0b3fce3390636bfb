// SPDX-License-Identifier: Apache-2.0
#include "advice.h"

#include <cmath>

#include "html.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kPathsDecide_1 = 0.6, kLooksDecide_1 = 0.4;
constexpr double kAlong_1 = 0.7, kAcross_1 = 0.3;
constexpr double kGoodAngle_deg = 60.0;

enum class Direction { kAlong, kRanges, kBoth, kUnknown };

Direction DirectionOf(const AccuracyFigures& accuracy) {
  if (std::isnan(accuracy.along_track_1)) return Direction::kUnknown;
  if (accuracy.along_track_1 > kAlong_1) return Direction::kAlong;
  return accuracy.along_track_1 < kAcross_1 ? Direction::kRanges : Direction::kBoth;
}

std::string Percent(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

/// What would lower the part of the looks, briefly.
std::string LooksBriefly(const AccuracyFigures& accuracy) {
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return "azimuth accuracy, more looks";
    case Direction::kBoth:
      return "azimuth and range accuracy, more looks";
    case Direction::kUnknown:
      return "more and better looks";
    case Direction::kRanges:
      break;
  }
  return accuracy.median_intersection_deg < kGoodAngle_deg ? "larger angles, more and better ranges"
                                                           : "more and better ranges";
}

std::string LooksInWords(const AccuracyFigures& accuracy) {
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return "more accurate azimuths (image times) or more looks a point";
    case Direction::kBoth:
      return "more accurate azimuths and ranges or more looks a point";
    case Direction::kUnknown:
      return "more accurate looks or more of them a point";
    case Direction::kRanges:
      break;
  }
  return accuracy.median_intersection_deg < kGoodAngle_deg
             ? fmt::format(
                   "larger intersection angles (the median is {} degrees), more looks a "
                   "point or more accurate ranges",
                   ReadableNumber(accuracy.median_intersection_deg, 3))
             : "more looks a point or more accurate ranges";
}

/// "north (along track)"
std::string WeakestName(const AccuracyFigures& accuracy, const Frame& frame) {
  const std::string axis = AxisNames(frame)[static_cast<std::size_t>(accuracy.weakest)];
  if (accuracy.weakest == 2) return axis;
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return axis + " (along track)";
    case Direction::kRanges:
      return axis + " (across track)";
    case Direction::kBoth:
      return axis + " (along some tracks, across others)";
    case Direction::kUnknown:
      break;
  }
  return axis;
}

}  // namespace

Advice AdviceOf(const AccuracyFigures& accuracy, const Frame& frame) {
  if (accuracy.free_points == 0) return {"", ""};
  const std::string weakest = WeakestName(accuracy, frame);
  const double part = accuracy.path_part_1;
  if (std::isnan(part)) {
    return {LooksBriefly(accuracy),
            fmt::format(
                "The weakest component is {}: {} would help.", weakest, LooksInWords(accuracy))};
  }
  const std::string paths = "control points or better flight paths";
  const std::string shares = fmt::format(
      "The weakest component is {}: {} of its variance comes from the flight paths and "
      "{} from the noise of the looks, so ",
      weakest,
      Percent(part),
      Percent(1.0 - part));
  if (part > kPathsDecide_1) return {"control, better paths", shares + paths + " would help most."};
  if (part < kLooksDecide_1) {
    return {LooksBriefly(accuracy), shares + LooksInWords(accuracy) + " would help most."};
  }
  return {
      "control, and " + LooksBriefly(accuracy),
      shares + "both would have to improve: " + paths + ", and " + LooksInWords(accuracy) + "."};
}

}  // namespace sarblock

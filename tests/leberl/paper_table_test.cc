// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "leberl/table1.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

const Table1Cell& FindCell(const std::vector<Table1Cell>& cells,
                           const std::string& configuration,
                           const std::string& position,
                           const std::string& quantity,
                           const std::string& source,
                           double dy_km = 0.0) {
  const auto found = std::find_if(cells.begin(), cells.end(), [&](const Table1Cell& cell) {
    return cell.configuration == configuration && cell.position == position &&
           cell.quantity == quantity && cell.source == source && cell.dy_km.value_or(0.0) == dy_km;
  });
  if (found == cells.end()) throw std::logic_error("no such cell");
  return *found;
}

TEST(PaperTable1Test, HasAVerdictWithANoteForEveryCell) {
  const auto cells = PaperTable1();
  ASSERT_EQ(cells.size(), 72u);  // 6 rows, 4 columns, 3 sources
  std::set<std::string> keys;
  for (const Table1Cell& cell : cells) {
    EXPECT_FALSE(cell.note.empty()) << cell.quantity << cell.source;
    EXPECT_EQ(cell.printed_m.has_value(), cell.verdict != PaperVerdict::kIllegible);
    EXPECT_TRUE(std::isfinite(cell.exact_m));
    keys.insert(cell.configuration + cell.position + cell.quantity + cell.source +
                std::to_string(cell.dy_km.value_or(-1.0)));
  }
  EXPECT_EQ(keys.size(), 72u);
}

TEST(PaperTable1Test, JoinsFormulaAndDerivativeWhereTheVerdictSaysSo) {
  for (const Table1Cell& cell : PaperTable1()) {
    if (cell.verdict != PaperVerdict::kAgrees && cell.verdict != PaperVerdict::kTruncation) {
      continue;
    }
    EXPECT_NEAR(cell.formula_m, cell.derivative_m, 1e-9 * std::abs(cell.formula_m))
        << cell.configuration << cell.position << cell.quantity << cell.source;
    EXPECT_NEAR(*cell.printed_m, cell.formula_m, std::max(0.5, 0.001 * std::abs(cell.formula_m)));
  }
}

// Hand values: Eq. 14, 15, 19 and 24 evaluated with pencil for B = 8, H = 10, y = 13 km.
TEST(PaperTable1Test, EvaluatesTheFormulasOfTheAircraftNearEdge) {
  const auto cells = PaperTable1();
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dy", "dy0''").formula_m, -62.5, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dy", "dz0''").formula_m, 12.5, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dy", "dr''").formula_m,
              -10.0 * std::sqrt(125.0) / 8.0,
              1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dz", "dy0''").formula_m, -81.25, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "ddz", "dB").formula_m, 8.125, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "ddz", "dB").derivative_m, -8.125, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "ddz", "dB", 1.0).formula_m, -14.375, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "ddz", "dB", 1.0).derivative_m, -30.625, 1e-10);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "ddy", "dr''").formula_m,
              -100.0 / (8.0 * std::sqrt(125.0)),
              1e-10);
}

// Closed form, exact for any size of error: with z = 0 the two circles of the erroneous station
// give B' y1 = (y^2 - (y - B)^2 + B'^2) / 2 with B' = B + dB.
TEST(PaperTable1Test, TakesExactValuesFromTheFiniteIntersection) {
  const auto cells = PaperTable1();
  const double base_m = 8100.0, first_m2 = 13e3 * 13e3 + 1e8, second_m2 = 5e3 * 5e3 + 1e8;
  const double y_m = (first_m2 - second_m2 + base_m * base_m) / (2.0 * base_m);
  const double z_m = 10e3 - std::sqrt(first_m2 - y_m * y_m);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dy", "dy0''").exact_m, y_m - 13e3, 1e-8);
  EXPECT_NEAR(FindCell(cells, "aircraft", "near", "dz", "dy0''").exact_m, z_m, 1e-8);
}

TEST(PaperTable1Test, ExplainsTheSlips) {
  const auto cells = PaperTable1();
  const auto note = [&](const char* c, const char* p, const char* q, const char* s, double dy) {
    const Table1Cell& cell = FindCell(cells, c, p, q, s, dy);
    EXPECT_EQ(cell.verdict, PaperVerdict::kSlip) << c << p << q << s;
    return cell.note;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  // hand: 10 sqrt(269)/8 = 20.50 and 20.50 * 13/10 = 26.65 with r' for r''
  EXPECT_TRUE(has(note("aircraft", "near", "dy", "dr''", 0), "r' in place of r''"));
  EXPECT_TRUE(has(note("aircraft", "near", "dz", "dr''", 0), "r' in place of r''"));
  EXPECT_TRUE(has(note("aircraft", "near", "dz", "dy0''", 0), "opposite sign"));
  // hand: 100 * 325/40 = 812.5 where y/B would be 912.5
  EXPECT_TRUE(has(note("voir", "near", "dz", "dz0''", 0), "y - B in place of y"));
  EXPECT_TRUE(has(note("voir", "near", "dz", "dr''", 0), "y - B in place of y"));
  // hand: 10 (10/8) (1/sqrt(269) - 1/sqrt(125)) km/km = -0.356
  EXPECT_TRUE(has(note("aircraft", "near", "ddy", "dr''", 0), "same range error in both"));
  EXPECT_TRUE(has(note("aircraft", "far", "ddz", "dr''", 1), "same range error in both"));
  EXPECT_TRUE(has(note("voir", "far", "ddz", "dB", 1), "wrong sign"));
  EXPECT_TRUE(has(note("voir", "far", "ddy", "dH", 0), "wrong sign"));
}

/// Half a unit of the last printed digit that is not a trailing zero of an integer.
double HalfUnit(const Table1Cell& cell) {
  const std::string& text = cell.printed_text;
  const std::size_t point = text.find('.');
  if (point != std::string::npos) {
    return 0.5 * std::pow(10.0, -static_cast<double>(text.size() - point - 1));
  }
  const std::size_t last = text.find_last_not_of('0');
  const bool zero = cell.printed_m == 0.0;
  return 0.5 * std::pow(10.0, zero ? 0.0 : static_cast<double>(text.size() - last - 1));
}

// The definition of the verdicts, of every cell.
TEST(PaperTable1Test, JudgesPrintedDigitsByTheFormulaTheDerivativeAndTheExactValue) {
  for (const Table1Cell& cell : PaperTable1()) {
    PaperVerdict expected = PaperVerdict::kIllegible;
    if (cell.printed_text.find('?') == std::string::npos) {
      const auto is_printed = [&](double value_m) {
        return std::abs(value_m - *cell.printed_m) <= HalfUnit(cell) * (1.0 + 1e-8);
      };
      const bool same =
          std::abs(cell.formula_m - cell.derivative_m) <= 1e-9 * std::abs(cell.formula_m);
      expected = !same || !is_printed(cell.formula_m) ? PaperVerdict::kSlip
                 : is_printed(cell.exact_m)           ? PaperVerdict::kAgrees
                                                      : PaperVerdict::kTruncation;
    }
    EXPECT_EQ(cell.verdict, expected)
        << cell.configuration << cell.position << cell.quantity << cell.source;
  }
}

// What docs/theory/leberl.md finds cell by cell: 16 relative cells by dr'', 8 d(Dy) by dH, 7
// legible d(Dz) by dB, and three pairs.
TEST(PaperTable1Test, ExplainsEverySlipByOneCause) {
  std::vector<std::string> causes;
  for (const Table1Cell& cell : PaperTable1()) {
    EXPECT_EQ(cell.cause.empty(), cell.verdict != PaperVerdict::kSlip) << cell.note;
    causes.push_back(cell.cause);
    if (cell.verdict == PaperVerdict::kSlip && cell.dy_km && cell.source == "dr''") {
      EXPECT_EQ(cell.cause, "the same range error in both images (dr' = dr'')");
    }
    if (cell.verdict == PaperVerdict::kSlip && cell.dy_km && cell.source == "dH") {
      EXPECT_EQ(cell.cause, "wrong sign of the Dz term in Eq. 22");
    }
  }
  std::vector<int> counts;
  for (const SlipCause& cause : CountCauses(causes)) counts.push_back(cause.count);
  EXPECT_EQ(counts, (std::vector<int>{16, 8, 7, 2, 2, 2}));
  for (const QuotedExample& e : PaperExamples()) {
    EXPECT_EQ(e.cause.empty(), e.verdict != PaperVerdict::kSlip) << e.name;
  }
}

TEST(PaperTable1Test, CountsEachCauseOnceTheMostFrequentFirst) {
  const auto counts = CountCauses({"a", "", "b", "b", "c", "b", "c"});
  ASSERT_EQ(counts.size(), 3u);
  EXPECT_EQ(counts[0].cause, "b");
  EXPECT_EQ(counts[0].count, 3);
  EXPECT_EQ(counts[1].cause, "c");
  EXPECT_EQ(counts[2].count, 1);
}

TEST(PaperConfigurationTest, KnowsItsNamesOnly) {
  EXPECT_EQ(PaperConfiguration("voir", "centre").ground_range_m, 395e3);
  EXPECT_THROW((void)PaperConfiguration("seasat", "near"), InputError);
  EXPECT_THROW((void)PaperConfiguration("voir", "middle"), InputError);
}

TEST(PaperExamplesTest, JudgeEveryQuotedNumber) {
  const auto examples = PaperExamples();
  ASSERT_EQ(examples.size(), 22u);
  for (const QuotedExample& e : examples) EXPECT_FALSE(e.note.empty()) << e.name;
  const auto find = [&](const std::string& part) {
    for (const QuotedExample& e : examples) {
      if (e.name.find(part) != std::string::npos) return e;
    }
    throw std::logic_error("no such example");
  };
  // hand: -100 * 19 * 11/80; -100 * 395 * 355/15000; 5 * 15000/(365 * 325); 5 * 0.6053
  EXPECT_NEAR(find("aircraft centre, dB = 100 m: dz").formula, -261.25, 1e-9);
  EXPECT_NEAR(find("voir centre, dB = 100 m: dz").formula, -934.8333, 1e-4);
  EXPECT_NEAR(find("aircraft centre, dB = 100 m: d(Dz)").derivative.value(), -63.625, 1e-9);
  EXPECT_NEAR(find("voir near, exaggeration").formula, 0.632244, 1e-6);
  EXPECT_EQ(find("voir near, exaggeration").verdict, PaperVerdict::kAgrees);
  EXPECT_EQ(find("voir far, exaggeration").verdict, PaperVerdict::kSlip);
  EXPECT_EQ(find("sigma_y").verdict, PaperVerdict::kAgrees);
  EXPECT_NEAR(find("sigma_y").derivative.value(), find("sigma_y").formula, 1e-6);
  EXPECT_EQ(find("viewing guidance, dtheta").verdict, PaperVerdict::kAgrees);
  // hand: dz/dy = y/H = 13/10 and 365/375; 365 325/(40 375) km against 13 5/(8 10) km, and so on
  EXPECT_NEAR(find("aircraft near, dz/dy").formula, 1.3, 1e-12);
  EXPECT_NEAR(find("aircraft near, dz/dy").derivative.value(), 1.3, 1e-9);
  EXPECT_NEAR(find("voir near, dz/dy").formula, 365.0 / 375.0, 1e-12);
  EXPECT_NEAR(
      find("voir over aircraft, near").formula, (365.0 * 325.0 / 15e3) / (65.0 / 80.0), 1e-12);
  EXPECT_NEAR(
      find("voir over aircraft, far").formula, (425.0 * 385.0 / 15e3) / (425.0 / 80.0), 1e-12);
  EXPECT_EQ(find("voir over aircraft, near").verdict, PaperVerdict::kAgrees);
  EXPECT_EQ(find("voir over aircraft, centre").verdict, PaperVerdict::kSlip);
}

}  // namespace
}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sarblock {

enum class HeadlineState {
  kAccepted,
  kTestsFailed,
  kNotAccepted,
  kNeutral,  ///< nothing to accept: a prediction, a study, a comparison
};

/// The top of a report: whether the result is accepted and why, how accurate it is, what limits it.
struct Headline {
  HeadlineState state = HeadlineState::kNeutral;
  std::string word;                    ///< "Accepted"
  std::vector<std::string> sentences;  ///< three at most: verdict, accuracy, what would help
  std::string would_help;              ///< in a few words; may be empty
  std::vector<std::string> attention;  ///< what a careful reader should look at; may be empty
};

/// A report before it is written: plain text everywhere, escaped only by RenderPage.

/// A paragraph. `kind` is a class of style.css: "", "note", "answer"; or it is a "heading".
struct PageText {
  std::string text;
  std::string kind;
};

struct PageColumn {
  std::string title;
  bool number = false;  ///< aligned to the right
};
/// The script shows the first ten rows, more on demand, sorts by a column and filters.
struct PageTable {
  std::string title;
  std::vector<PageColumn> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> marked;  ///< rows to be noticed
  std::string note;
  bool folded = false;  ///< behind its title until asked for; open on paper
  bool plain = false;   ///< all rows, in their order: figures by name, not a list
};

/// A chart: `json` is what ChartJson() makes. `size` is a class of style.css: "map", "wide",
/// "half", "small".
struct PageFigure {
  std::string id;
  std::string title;
  std::string caption;
  std::string size = "wide";
  std::string json;
};
/// Figures side by side where there is room.
struct PageFigures {
  std::vector<PageFigure> figures;
};
/// The text of an SVG file, shown as an image (scripts in it do not run).
struct PagePicture {
  std::string title;
  std::string svg;
};
/// Label, value and a remark, as tiles.
struct PageFact {
  std::string label, value, remark;
};
struct PageFacts {
  std::vector<PageFact> facts;
};
struct PageList {
  std::vector<std::string> items;
};
/// Text with its line breaks, such as TOML.
struct PagePre {
  std::string title, text;
};

using PageItem = std::variant<PageText,
                              PageTable,
                              PageFigure,
                              PageFigures,
                              PagePicture,
                              PageFacts,
                              PageList,
                              PagePre>;

struct PageSection {
  std::string id;
  std::string title;
  std::vector<PageItem> items;
};

struct Page {
  std::string title;     ///< of the document
  std::string kind;      ///< "Adjustment", above the title
  std::string subtitle;  ///< below it
  Headline headline;
  std::vector<PageFact> facts;  ///< beside the headline
  std::vector<PageSection> sections;
};

/// The page as one HTML file that needs no other.
[[nodiscard]] std::string RenderPage(const Page& page);

/// Text escaped for use between tags and in quoted attributes: & < > " ' become references, control
/// characters other than tab and newline the replacement character, and so does what is not UTF-8.
[[nodiscard]] std::string EscapeHtml(std::string_view text);

/// JSON escaped for use inside a script element: < > & and the two line separators that a script
/// would take for line ends become \u escapes. They occur in strings only, so the value is the
/// same.
[[nodiscard]] std::string EscapeScriptJson(std::string_view json);

/// A number for people with `digits` significant digits and without an exponent between 1e-5 and
/// 1e9; "-" for NaN. A thin space parts thousands from five digits before the point on.
[[nodiscard]] std::string ReadableNumber(double value, int digits = 4);

/// A count with thin spaces between groups of three from five digits on.
[[nodiscard]] std::string ReadableCount(double count);
[[nodiscard]] inline std::string ReadableCount(std::size_t count) {
  return ReadableCount(static_cast<double>(count));
}

/// A number with four significant digits; a probability or a part of one as percent.
[[nodiscard]] std::string Shown(double value, int digits = 4);
[[nodiscard]] std::string ShownPercent(double part);
/// "1.2 +- 0.3"
[[nodiscard]] std::string ShownWithSigma(double value, double sigma);
/// The first letter in capitals.
[[nodiscard]] std::string Capital(std::string text);

/// A file of src/report/assets, or the chart library, as it was when the program was built
/// (cmake/embed_files.cmake writes the definition). std::out_of_range for another name.
[[nodiscard]] std::string_view AssetText(std::string_view name);

/// Charts as data for report.js: values with five significant digits, what is not a number as null.

struct ChartAxis {
  std::string label;
  bool logarithmic = false;
  double least = std::numeric_limits<double>::quiet_NaN();  ///< NaN: as the data are
  double most = std::numeric_limits<double>::quiet_NaN();
};

/// One series. `style`: "points", "line", "dash", "steps" (filled), "band" (between low and high),
/// "bars" (points with a bar from low to high). `color`: a name of report.js.
struct ChartSeries {
  std::string label, style, color;
  std::vector<double> x, y, low, high;
  std::vector<std::string> names;  ///< of points, shown when pointed at; empty: none
  bool written = false;            ///< names are also written next to their points
};

struct XyChart {
  ChartAxis x, y;
  std::vector<ChartSeries> series;
};
[[nodiscard]] std::string ChartJson(const std::string& id, const XyChart& chart);
/// Gives the y axis the ends of the data with a margin; logarithmic where they span a factor of 5.
void FitY(XyChart* chart);

using ChartPlaces = std::vector<std::array<double, 2>>;  ///< in the unit of the map

/// A map with equal scales. Points are coloured by one of several values, each with its own scale.
struct MapChart {
  std::string unit;  ///< "km"
  struct Line {
    std::string name;
    ChartPlaces places;
  };
  std::vector<Line> tracks, swaths;
  ChartPlaces points;
  std::vector<std::string> point_names;
  struct Value {
    std::string label;
    std::vector<double> of_point;
    double low = 0.0, high = 0.0;    ///< ends of the colour scale
    double least = 0.0, most = 0.0;  ///< of the values that the scale covers
    bool weak_where_low = false;     ///< dark colours are for what is weak
  };
  std::vector<Value> values;
  std::size_t shown = 0;    ///< of `values`, at first
  bool logarithmic = true;  ///< colour scale
  double unit_m = 1.0;
  ChartPlaces control, checks;
  std::vector<std::string> control_names, check_names;
  /// Place, half axes and azimuth [rad] of the long one; true size, report.js enlarges.
  std::vector<std::array<double, 5>> ellipses;
  std::vector<std::array<double, 4>> errors;  ///< place and error, true size
  std::vector<Line> graticule;
};
[[nodiscard]] std::string ChartJson(const std::string& id, const MapChart& chart);

/// Figures of a report: small statistics of any values. NaN are left out everywhere.

/// Quantile by linear interpolation between order statistics: position p (n - 1), p in [0, 1].
/// NaN without values.
[[nodiscard]] double SampleQuantile(std::vector<double> values, double probability);

/// Several quantiles of the same values with one sort.
[[nodiscard]] std::vector<double> SampleQuantiles(std::vector<double> values,
                                                  std::span<const double> probabilities);

/// Counts of values in equal bins over [lower, upper]. The first and last bin also take what lies
/// outside, so that nothing vanishes from a picture.
struct Histogram {
  double lower = 0.0, upper = 0.0;
  std::vector<std::size_t> counts;
  std::size_t below = 0, above = 0;  ///< of those, how many lay outside
  [[nodiscard]] std::size_t total() const;
};
[[nodiscard]] Histogram CountInBins(std::span<const float> values,
                                    double lower,
                                    double upper,
                                    std::size_t bins);

/// One point of a quantile plot: the normal quantile expected of an ordered value, and the value.
struct QuantilePoint {
  double expected = 0.0;
  double value = 0.0;
};
/// Normal quantile plot, expected quantiles at (i - 0.5) / n (Hazen). Above `most` points the tails
/// are kept one by one and the middle is thinned evenly.
[[nodiscard]] std::vector<QuantilePoint> NormalQuantilePlot(std::span<const float> values,
                                                            std::size_t most);

/// A sample of `most` of `count` indices, ascending: the same for the same numbers, without regard
/// to the order of the data (the smallest hashes of the indices). All of them where count <= most.
[[nodiscard]] std::vector<std::uint32_t> SampleIndices(std::size_t count, std::size_t most);

/// Medians of y in equal bins of x. A bin with fewer than `least` values is left out.
struct BinnedMedian {
  double x = 0.0;  ///< middle of the bin
  double value = 0.0;
  std::size_t count = 0;
};
[[nodiscard]] std::vector<BinnedMedian> MedianInBins(std::span<const double> x,
                                                     std::span<const double> values,
                                                     std::size_t bins,
                                                     std::size_t least);

/// The largest number 1, 2 or 5 times a power of ten that is not above a positive value.
[[nodiscard]] double RoundDown125(double value);

/// True for (x, y) inside or on the convex hull of other places.
class ConvexHull {
 public:
  explicit ConvexHull(std::vector<std::array<double, 2>> places_m);
  [[nodiscard]] bool Contains(double x_m, double y_m) const;
  /// False with fewer than three places that are not on one line.
  [[nodiscard]] bool HasArea() const { return corners_m_.size() > 2; }

 private:
  std::vector<std::array<double, 2>> corners_m_;  // counter-clockwise
};

}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#include "isis.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "core/text.h"
#include "core/utc.h"
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace sarblock {
namespace {

constexpr std::uint64_t kLongestLabel = 8U << 20U;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\0'; }

std::string_view TrimmedLine(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

// Place of the line `End`, at or after the line with `from`.
std::size_t FindEnd(std::string_view text, std::size_t from) {
  std::size_t begin = from == 0 ? 0 : text.rfind('\n', from - 1) + 1;  // npos + 1 is 0
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end < text.size() && SameName(TrimmedLine(text.substr(begin, end - begin)), "End")) {
      return begin;
    }
    begin = end + 1;
  }
  return std::string_view::npos;
}

}  // namespace

bool SameName(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

/// Recursive descent over the text before `End`; depth is bounded.
class PvlParser {
 public:
  PvlParser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  PvlObject Parse() {
    PvlObject root;
    root.file_ = file_;
    root.line_ = 1;
    ParseBody(&root, 0);
    return root;
  }

 private:
  static constexpr std::size_t kDeepest = 16;

  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(FilePlace{file_, line_, "label"}, problem);
  }
  [[nodiscard]] bool AtEnd() const { return at_ >= text_.size(); }
  char Take() {
    if (text_[at_] == '\n') ++line_;
    return text_[at_++];
  }
  void SkipTo(std::string_view mark) {
    while (!AtEnd() && !text_.substr(at_).starts_with(mark)) Take();
  }
  void SkipBlanks() {
    while (!AtEnd()) {
      if (IsBlank(text_[at_])) {
        Take();
      } else if (text_[at_] == '#') {
        SkipTo("\n");
      } else if (text_.substr(at_).starts_with("/*")) {
        SkipTo("*/");
        at_ = std::min(at_ + 2, text_.size());
      } else {
        return;
      }
    }
  }
  void SkipSpaces() {
    while (!AtEnd() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) Take();
  }

  std::string ParseName() {
    const std::size_t begin = at_;
    while (!AtEnd() && !IsBlank(text_[at_]) && text_[at_] != '=') Take();
    return std::string(text_.substr(begin, at_ - begin));
  }

  std::string ParseQuoted() {
    const char quote = Take();
    std::string value;
    while (!AtEnd() && text_[at_] != quote) value += Take();
    if (AtEnd()) Fail("a text in quotation marks does not end");
    Take();
    return value;
  }

  // A word; `-` at the end of a line joins it with the next one.
  std::string ParseWord() {
    std::string value;
    while (!AtEnd()) {
      const char c = text_[at_];
      if (c == ',' || c == '(' || c == ')' || c == '{' || c == '}' || c == '<') break;
      if (IsBlank(c)) {
        if (!value.ends_with('-') || value.size() < 2) break;
        const std::size_t rest = text_.find_first_not_of(" \t\r", at_);
        if (rest == std::string_view::npos || text_[rest] != '\n') break;
        value.pop_back();
        SkipBlanks();
        continue;
      }
      value += Take();
    }
    if (value.empty()) Fail("a value is missing");
    return value;
  }

  void ParseUnit(PvlKey* key) {
    SkipSpaces();
    if (AtEnd() || text_[at_] != '<') return;
    const std::size_t begin = at_ + 1;
    SkipTo(">");
    if (AtEnd()) Fail("a unit does not end, '>' is needed");
    key->unit = std::string(text_.substr(begin, at_ - begin));
    Take();
  }

  void ParseValue(PvlKey* key, std::size_t depth) {
    if (depth > kDeepest) Fail("lists are nested too deep");
    SkipBlanks();
    if (AtEnd()) Fail("a value is missing");
    const char c = text_[at_];
    if (c == '"' || c == '\'') {
      key->values.push_back(ParseQuoted());
    } else if (c == '(' || c == '{') {
      if (depth > 0) ++key->inner_lists;
      ParseList(key, depth);
    } else {
      key->values.push_back(ParseWord());
    }
    ParseUnit(key);
  }

  void ParseList(PvlKey* key, std::size_t depth) {
    Take();
    for (;;) {
      SkipBlanks();
      if (AtEnd()) Fail("a list does not end, ')' is needed");
      if (text_[at_] == ')' || text_[at_] == '}') break;
      if (text_[at_] == ',') {
        Take();
        continue;
      }
      ParseValue(key, depth + 1);
    }
    Take();
  }

  void ParseChild(PvlObject* parent, std::size_t depth, std::size_t line, const std::string& name) {
    if (depth >= kDeepest) Fail("objects are nested too deep");
    PvlObject child;
    child.file_ = file_;
    child.name_ = name;
    child.path_ = parent->path_.empty() ? name : parent->path_ + "." + name;
    child.line_ = line;
    ParseBody(&child, depth + 1);
    parent->children_.push_back(std::move(child));
  }

  void ParseBody(PvlObject* object, std::size_t depth) {
    for (SkipBlanks(); !AtEnd(); SkipBlanks()) {
      PvlKey key;
      key.line = line_;
      key.name = ParseName();
      SkipSpaces();
      const bool valued = !AtEnd() && text_[at_] == '=';
      if (SameName(key.name, "End_Object") || SameName(key.name, "End_Group") ||
          SameName(key.name, "EndObject") || SameName(key.name, "EndGroup")) {
        if (valued) {
          Take();
          ParseValue(&key, 0);
        }
        if (depth == 0) Fail(Quoted(key.name) + " ends nothing");
        return;
      }
      if (!valued) Fail(Quoted(key.name) + " is not followed by '='");
      Take();
      ParseValue(&key, 0);
      if (SameName(key.name, "Object") || SameName(key.name, "Group")) {
        ParseChild(object, depth, key.line, key.values.empty() ? "" : key.values.front());
      } else {
        object->keys_.push_back(std::move(key));
      }
    }
    if (depth > 0) Fail("object " + Quoted(object->name_) + " does not end");
  }

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0, line_ = 1;
};

const PvlObject* PvlObject::Find(std::string_view name) const {
  for (const PvlObject& child : children_) {
    if (SameName(child.name_, name)) return &child;
  }
  return nullptr;
}

const PvlObject& PvlObject::Child(std::string_view name) const {
  const PvlObject* const child = Find(name);
  if (child == nullptr) Fail(name, "is missing in the label");
  return *child;
}

const PvlKey* PvlObject::FindKey(std::string_view name) const {
  for (const PvlKey& key : keys_) {
    if (SameName(key.name, name)) return &key;
  }
  return nullptr;
}

const PvlKey& PvlObject::Key(std::string_view name) const {
  const PvlKey* const key = FindKey(name);
  if (key == nullptr) Fail(name, "is missing in the label");
  return *key;
}

std::string PvlObject::Text(std::string_view key) const {
  const PvlKey& found = Key(key);
  if (found.values.size() != 1 || found.values.front().empty()) Fail(key, "one value is needed");
  return found.values.front();
}

double PvlObject::NumberOf(const PvlKey& key, std::size_t index) const {
  const std::string& text = key.values[index];
  const char* begin = text.data();
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') ++begin;
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    Fail(key.name, Quoted(text) + " is not a finite number");
  }
  return value;
}

double PvlObject::Number(std::string_view key) const { return Numbers(key, 1).front(); }

double PvlObject::Positive(std::string_view key) const {
  const double value = Number(key);
  if (!(value > 0.0)) Fail(key, "must be a number above 0, got " + NumberText(value));
  return value;
}

std::uint64_t PvlObject::Count(std::string_view key, std::uint64_t least) const {
  constexpr double kMax = 9007199254740992.0;  // 2^53: every integer up to it is a double
  const double value = Number(key);
  if (value != std::floor(value) || value < static_cast<double>(least) || value > kMax) {
    Fail(key, fmt::format("must be an integer of {1} or more, got {0}", NumberText(value), least));
  }
  return static_cast<std::uint64_t>(value);
}

std::vector<double> PvlObject::Numbers(std::string_view key, std::size_t count) const {
  const PvlKey& found = Key(key);
  if (found.values.size() != count) {
    Fail(key, fmt::format("has {} values, {} is needed", found.values.size(), count));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(NumberOf(found, i));
  return numbers;
}

void PvlObject::Fail(std::string_view key, const std::string& problem) const {
  const PvlKey* const found = FindKey(key);
  throw InputError(FilePlace{file_,
                             found != nullptr ? found->line : line_,
                             (path_.empty() ? "" : path_ + ".") + std::string(key)},
                   problem);
}

PvlObject ReadPvlLabel(ByteSource* source) {
  constexpr std::uint64_t kPiece = 64U << 10U;
  const std::uint64_t most = std::min(source->size(), kLongestLabel);
  std::string text;
  while (text.size() < most) {
    const std::size_t seen = text.size();
    text +=
        source->Read(seen, std::min(most - seen, std::max<std::uint64_t>(kPiece, seen)), "label");
    if (seen == 0 && text.find('=') == std::string::npos) break;
    if (text.size() == source->size()) text += '\n';  // of a last line without one
    const std::size_t end = FindEnd(text, seen);
    if (end == std::string_view::npos) continue;
    return PvlParser(std::string_view(text).substr(0, end), source->file()).Parse();
  }
  throw InputError(
      FilePlace{source->file(), 0, "label"},
      text.find('=') == std::string::npos ? "is no label: the file does not begin with NAME = VALUE"
      : source->size() < kLongestLabel ? "the file ends before its label does: a line End is needed"
                                       : "is longer than 8 MiB, which no label of ISIS is");
}

namespace {

constexpr double kMetres = 1e3;  // of a kilometre
constexpr const char* kSpiceinit = "run spiceinit on the cube again";

UtcTime LabelTime(const PvlObject& group, std::string_view key, const std::string& text) {
  const auto time = ParseUtc(text);
  if (!time) group.Fail(key, Quoted(text) + " is no UTC time from 1972 on");
  return *time;
}

// Labels of Mini-RF say GHz and mean MHz; the range of radar frequencies decides.
double Wavelength_m(const PvlObject& instrument) {
  const double frequency = instrument.Positive("Frequency");
  const std::string& unit = instrument.Key("Frequency").unit;
  constexpr double kLowest_hz = 1e8, kHighest_hz = 3e11;
  for (const double scale : {1e9, 1e6, 1.0}) {
    const double frequency_hz = frequency * scale;
    if (frequency_hz >= kLowest_hz && frequency_hz <= kHighest_hz) {
      return kSpeedOfLight_mps / frequency_hz;
    }
  }
  instrument.Fail(
      "Frequency",
      fmt::format(
          "{} {} is no frequency of a radar in GHz, MHz or Hz", NumberText(frequency), unit));
}

std::vector<GroundRangePolynomial> CubeGroundRange(const PvlObject& instrument) {
  const PvlKey& key = instrument.Key("RangeCoefficientSet");
  constexpr std::size_t kOfOne = 5;  // a time and four coefficients
  const std::size_t sets = key.inner_lists > 0 ? key.inner_lists : 1;
  if (key.values.size() != kOfOne * sets) {
    instrument.Fail(key.name, "sets of a time and four coefficients are needed");
  }
  std::vector<GroundRangePolynomial> polynomials;
  for (std::size_t i = 0; i < key.values.size(); i += kOfOne) {
    GroundRangePolynomial polynomial;
    polynomial.time_s = EphemerisTime_s(LabelTime(instrument, key.name, key.values[i]));
    for (std::size_t k = 1; k < kOfOne; ++k) {
      polynomial.coefficients.push_back(instrument.NumberOf(key, i + k));
    }
    if (!polynomials.empty() && !(polynomial.time_s > polynomials.back().time_s)) {
      instrument.Fail(key.name, "the times must increase");
    }
    polynomials.push_back(std::move(polynomial));
  }
  return polynomials;
}

Ellipsoid CubeEllipsoid(const PvlObject& root, const std::string& target) {
  const PvlObject* const naif = root.Find("NaifKeywords");
  if (naif != nullptr) {
    for (const PvlKey& key : naif->keys()) {
      if (!key.name.starts_with("BODY") || !key.name.ends_with("_RADII")) continue;
      const std::vector<double> radii_km = naif->Numbers(key.name, 3);
      if (radii_km[0] != radii_km[1] || !(radii_km[2] > 0.0) || radii_km[2] > radii_km[0]) {
        naif->Fail(key.name, "a sphere or an ellipsoid of revolution is needed");
      }
      return {target, radii_km[0] * kMetres, 1.0 - radii_km[2] / radii_km[0]};
    }
  }
  return NamedEllipsoid(target);
}

/// How the lines or samples of a cube lie in those of the image that it was cut out of, counted
/// from 0 at the centre of the first one: first + step index.
struct AxisInFull {
  double first = 0.0, step = 1.0;
  std::uint64_t full_count = 0;
};
AxisInFull AxisOf(const PvlObject& cube, const std::string& axis) {
  const PvlObject& dimensions = cube.Child("Core").Child("Dimensions");
  AxisInFull result{0.0, 1.0, dimensions.Count(axis, 1)};
  const PvlObject* const alpha = cube.Find("AlphaCube");
  if (alpha == nullptr) return result;
  const std::string singular = axis.substr(0, axis.size() - 1);
  const double start = alpha->Number("AlphaStarting" + singular);
  const double end = alpha->Number("AlphaEnding" + singular);
  const auto count = static_cast<double>(alpha->Count("Beta" + axis, 1));
  if (!(end > start)) alpha->Fail("AlphaEnding" + singular, "must be after the start");
  result.step = (end - start) / count;
  result.first = start + 0.5 * result.step - 1.0;  // edges are at 0.5, centres at 1
  result.full_count = alpha->Count("Alpha" + axis, 1);
  return result;
}

InertialOrbit CubeOrbit(ByteSource* source, const PvlObject& root) {
  InertialOrbit orbit;
  orbit.file = source->file();
  const PvlObject* const position = FindCubeTable(root, "InstrumentPosition");
  const PvlObject* const rotation = FindCubeTable(root, "BodyRotation");
  if (position == nullptr || rotation == nullptr) {
    root.Fail("Table",
              fmt::format("{} is missing: run spiceinit on the cube (attach = yes)",
                          position == nullptr ? "InstrumentPosition" : "BodyRotation"));
  }
  if (const PvlKey* const cache = position->FindKey("CacheType")) {
    const std::string type = cache->values.empty() ? "" : cache->values.front();
    if (type != "Linear" && type != "HermiteSpline") {
      position->Fail(
          "CacheType",
          Quoted(type) + " is a path that jigsaw has fitted, states are needed: " + kSpiceinit);
    }
  }
  const CubeTable states =
      ReadCubeTable(source,
                    *position,
                    {"J2000X", "J2000Y", "J2000Z", "J2000XV", "J2000YV", "J2000ZV", "ET"},
                    kSpiceinit);
  for (const std::vector<double>& row : states.rows) {
    orbit.states.push_back({row[6],
                            kMetres * Eigen::Vector3d(row[0], row[1], row[2]),
                            kMetres * Eigen::Vector3d(row[3], row[4], row[5])});
  }
  const CubeTable attitudes =
      ReadCubeTable(source,
                    *rotation,
                    {"J2000Q0", "J2000Q1", "J2000Q2", "J2000Q3", "AV1", "AV2", "AV3", "ET"},
                    kSpiceinit);
  for (const std::vector<double>& row : attitudes.rows) {
    orbit.body.push_back(
        {row[7], {row[0], row[1], row[2], row[3]}, Eigen::Vector3d(row[4], row[5], row[6])});
  }
  if (rotation->FindKey("ConstantRotation") != nullptr) {
    const std::vector<double> rows = rotation->Numbers("ConstantRotation", 9);
    orbit.constant = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  }
  return orbit;
}

// ISIS measures slant range and Doppler shift in units of 100 resolutions of its label, each with
// 1.4 pixels of the size of a sample (MiniRF.cpp).
std::optional<JigsawSigma> JigsawSigmaOf(const PvlObject& instrument,
                                         const RadarImage& image,
                                         double pixel_m,
                                         const FlightPath& path,
                                         double mid_s) {
  for (const char* key : {"IncidenceAngle", "RangeResolution", "AzimuthResolution"}) {
    if (instrument.FindKey(key) == nullptr) return std::nullopt;
  }
  const auto motion = path.At(mid_s);
  if (!motion) return std::nullopt;
  const double incidence_rad = instrument.Positive("IncidenceAngle") * kRadPerDeg;
  const double height_m = motion->position_m.norm() - image.ellipsoid.a_m;
  const double pixels = 100.0 * 1.4 * pixel_m;
  JigsawSigma sigma;
  sigma.range_m = pixels * instrument.Positive("RangeResolution") * std::sin(incidence_rad);
  sigma.doppler_hz = pixels * 2.0 * motion->velocity_mps.norm() / image.wavelength_m *
                     instrument.Positive("AzimuthResolution") * std::cos(incidence_rad) / height_m;
  if (!(sigma.range_m > 0.0) || !(sigma.doppler_hz > 0.0)) return std::nullopt;
  return sigma;
}

RadarImage ReadCube(ByteSource source) {
  const PvlObject root = ReadPvlLabel(&source);
  const PvlObject& cube = root.Child("IsisCube");
  const PvlObject& instrument = cube.Child("Instrument");
  if (cube.Find("Mapping") != nullptr) {
    cube.Fail("Mapping", "is a map: a level 1 cube in the geometry of its sensor is needed");
  }
  RadarImage image;
  image.file = source.file();
  image.target = instrument.Text("TargetName");
  image.ellipsoid = CubeEllipsoid(root, image.target);
  const std::string start = instrument.Text("StartTime");
  const PvlKey* const host = instrument.FindKey("InstrumentHostId");
  image.serial =
      (host != nullptr ? instrument.Text("InstrumentHostId") : instrument.Text("SpacecraftName")) +
      "/" + instrument.Text("InstrumentId") + "/" + start;
  const std::string look = instrument.Text("LookDirection");
  if (look != "LEFT" && look != "RIGHT") {
    instrument.Fail("LookDirection", "must be LEFT or RIGHT, got " + Quoted(look));
  }
  image.side = look == "LEFT" ? LookSide::kLeft : LookSide::kRight;
  image.wavelength_m = Wavelength_m(instrument);
  const double start_s = EphemerisTime_s(LabelTime(instrument, "StartTime", start));
  const double interval_s = instrument.Positive("LineExposureDuration");
  const double pixel_m = instrument.Positive("ScaledPixelHeight");
  const AxisInFull lines = AxisOf(cube, "Lines"), samples = AxisOf(cube, "Samples");
  // A crop whose end is not in the label does not give the number of lines.
  image.lines = lines.full_count;
  image.samples = samples.full_count;
  image.first_line_s = start_s + lines.first * interval_s;
  image.line_interval_s = lines.step * interval_s;
  image.first_sample_m = samples.first * pixel_m;
  image.sample_spacing_m = samples.step * pixel_m;
  image.ground_range = CubeGroundRange(instrument);
  image.states = BodyFixedStates(CubeOrbit(&source, root), kImageStateStep_s);
  const double mid_s = start_s + 0.5 * static_cast<double>(lines.full_count + 1) * interval_s;
  image.jigsaw = JigsawSigmaOf(instrument, image, pixel_m, FlightPath(image.states), mid_s);
  return image;
}

}  // namespace

RadarImage ReadIsisCube(const std::string& file) { return ReadCube(ByteSource::FromFile(file)); }

RadarImage ParseIsisCube(std::string_view bytes, const std::string& file) {
  return ReadCube(ByteSource::FromBytes(bytes, file));
}

const PvlObject* FindCubeTable(const PvlObject& root, std::string_view name) {
  for (const PvlObject& child : root.children()) {
    if (child.name() == "Table" && child.Text("Name") == name) return &child;
  }
  return nullptr;
}

CubeTable ReadCubeTable(ByteSource* source,
                        const PvlObject& label,
                        const std::vector<std::string_view>& fields,
                        const char* remedy) {
  constexpr std::uint64_t kLargest = 64U << 20U;
  std::vector<std::string> names;
  for (const PvlObject& field : label.children()) {
    if (field.name() != "Field") continue;
    if (field.Text("Type") != "Double" || field.Count("Size", 1) != 1) {
      field.Fail("Type", "must be a single Double here");
    }
    names.push_back(field.Text("Name"));
  }
  if (!std::equal(names.begin(), names.end(), fields.begin(), fields.end())) {
    label.Fail("Field",
               fmt::format("{} has the fields {}; {} are needed: {}",
                           label.Text("Name"),
                           fmt::join(names, ", "),
                           fmt::join(fields, ", "),
                           remedy));
  }
  const std::string order = label.FindKey("ByteOrder") != nullptr ? label.Text("ByteOrder") : "Lsb";
  if (order != "Lsb" && order != "Msb") label.Fail("ByteOrder", "Lsb or Msb is allowed");
  const std::uint64_t records = label.Count("Records", 1);
  const std::uint64_t row_bytes = sizeof(double) * fields.size();
  const std::uint64_t bytes = label.Count("Bytes", 0);
  if (bytes > kLargest || records > kLargest || bytes != records * row_bytes) {
    label.Fail(
        "Bytes",
        fmt::format(
            "{} do not hold {} records of {} bytes, 64 MiB at most", bytes, records, row_bytes));
  }
  // StartByte counts from 1.
  std::string data = source->Read(label.Count("StartByte", 1) - 1, bytes, "table");
  CubeTable table{&label, {}};
  for (std::uint64_t at = 0; at < bytes; at += sizeof(double)) {
    if (at % row_bytes == 0) table.rows.emplace_back();
    char* const number = data.data() + at;
    if (order == "Msb") std::reverse(number, number + sizeof(double));
    const auto value = LittleEndianDouble(number);
    if (!std::isfinite(value)) {
      label.Fail("Records",
                 fmt::format("record {} holds a number that is not finite", table.rows.size()));
    }
    table.rows.back().push_back(value);
  }
  return table;
}

namespace {

void CheckAttitudes(InertialOrbit* orbit) {
  const auto fail = [orbit](std::size_t index, const char* problem) {
    throw InputError(FilePlace{orbit->file, 0, fmt::format("body rotation {}", index + 1)},
                     problem);
  };
  if (orbit->body.empty()) fail(0, "is missing, one or more are needed");
  for (std::size_t i = 0; i < orbit->body.size(); ++i) {
    BodyAttitude& attitude = orbit->body[i];
    if (!std::isfinite(attitude.time_s) || !attitude.rate_radps.allFinite()) {
      fail(i, "is not finite");
    }
    if (i > 0 && !(attitude.time_s > orbit->body[i - 1].time_s)) fail(i, "times must increase");
    if (!(std::abs(attitude.rotation.norm() - 1.0) < 1e-6)) {
      fail(i, "the quaternion is not one of a rotation: its length is not 1");
    }
    attitude.rotation.normalize();
  }
  const Eigen::Matrix3d product = orbit->constant * orbit->constant.transpose();
  if (!((product - Eigen::Matrix3d::Identity()).norm() < 1e-6)) {
    throw InputError(FilePlace{orbit->file, 0, "constant rotation"}, "is no rotation");
  }
}

BodyAttitude AttitudeAt(const InertialOrbit& orbit, double time_s) {
  const std::vector<BodyAttitude>& body = orbit.body;
  if (body.size() == 1) {
    BodyAttitude attitude = body.front();
    const Eigen::Vector3d turn_rad = attitude.rate_radps * (time_s - attitude.time_s);
    // Axes that turn with the body: coordinates of inertial vectors turn back.
    const Eigen::Vector3d axis = turn_rad.norm() > 0.0 ? Eigen::Vector3d(turn_rad.normalized())
                                                       : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
    attitude.rotation = attitude.rotation * Eigen::AngleAxisd(-turn_rad.norm(), axis);
    return attitude;
  }
  const auto above = std::upper_bound(
      body.begin() + 1, body.end() - 1, time_s, [](double t, const BodyAttitude& attitude) {
        return t < attitude.time_s;
      });
  const BodyAttitude& a = *(above - 1);
  const BodyAttitude& b = *above;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  return {time_s,
          a.rotation.slerp(part, b.rotation),
          (1.0 - part) * a.rate_radps + part * b.rate_radps};
}

}  // namespace

std::vector<StateVector> BodyFixedStates(const InertialOrbit& orbit, double step_s) {
  InertialOrbit checked = orbit;
  CheckAttitudes(&checked);
  const FlightPath path = [&orbit] {
    try {
      return FlightPath(orbit.states);
    } catch (const InputError& error) {
      throw InputError(FilePlace{orbit.file, 0, "instrument position"}, error.what());
    }
  }();
  constexpr double kMaxSteps = 1e6;
  if (path.end_s() - path.start_s() > kMaxSteps * step_s) {
    throw InputError(FilePlace{orbit.file, 0, "instrument position"},
                     fmt::format("states go over {:.3g} s, which no image takes",
                                 path.end_s() - path.start_s()));
  }
  std::vector<StateVector> states;
  const auto append = [&](const StateVector& inertial) {
    const BodyAttitude attitude = AttitudeAt(checked, inertial.time_s);
    const Eigen::Matrix3d fixed = checked.constant * attitude.rotation.toRotationMatrix();
    states.push_back(
        {inertial.time_s,
         fixed * inertial.position_m,
         fixed * (inertial.velocity_mps - attitude.rate_radps.cross(inertial.position_m))});
  };
  for (std::size_t k = 0; k < orbit.states.size(); ++k) {
    append(orbit.states[k]);
    if (k + 1 == orbit.states.size()) break;
    const double span_s = orbit.states[k + 1].time_s - orbit.states[k].time_s;
    const double parts = std::max(1.0, std::ceil(span_s / step_s - 1e-9));
    for (double part = 1.0; part < parts; part += 1.0) {
      const double time_s = orbit.states[k].time_s + span_s * (part / parts);
      const auto motion = path.At(time_s);
      if (motion) append({time_s, motion->position_m, motion->velocity_mps});
    }
  }
  return states;
}

}  // namespace sarblock

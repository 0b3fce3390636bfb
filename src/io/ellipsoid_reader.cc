// SPDX-License-Identifier: Apache-2.0
#include "ellipsoid_reader.h"

#include "sarblock/core/id_table.h"

#include <algorithm>

#include "core/text.h"

namespace sarblock {
namespace {

bool SameIgnoringCase(const std::string& a, const std::string& b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

Ellipsoid ReadEllipsoid(const TomlValue& value) {
  if (value.IsText()) {
    const std::string text = value.Text();
    for (const std::string& name : EllipsoidNames()) {
      if (SameIgnoringCase(name, text)) return NamedEllipsoid(name);
    }
    value.Fail(Quoted(text) + " is not known, " + Listed(EllipsoidNames()) +
               " or { a_m = ..., f = ... } is allowed" +
               DidYouMean(NearestName(text, EllipsoidNames())));
  }
  const TomlTable table(value);
  table.RefuseOthers({"a_m", "f"});
  Ellipsoid ellipsoid;
  ellipsoid.name = "custom";
  ellipsoid.a_m = table.Require("a_m", "the equatorial radius in metres").Positive();
  const TomlValue flattening = table.Require("f", "the flattening (a - b)/a");
  ellipsoid.flattening = flattening.Number();
  if (!(ellipsoid.flattening >= 0.0 && ellipsoid.flattening < 1.0)) {
    flattening.Fail(NumberText(ellipsoid.flattening) + " is not allowed, 0 <= f < 1 is");
  }
  return ellipsoid;
}

}  // namespace sarblock

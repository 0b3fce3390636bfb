// SPDX-License-Identifier: Apache-2.0
#include "sicd_writer.h"

#include "sarblock/core/error.h"

#include <array>
#include <charconv>
#include <sstream>
#include <utility>

#include "core/text.h"
#include "products/bytes.h"
#include "products/xml.h"

namespace sarblock {
namespace {

constexpr std::string_view kNamespace = "urn:SICD:";
constexpr const char* kAdjusted = "AdjustableParameterOffsets";
constexpr std::string_view kMark = " written by sarblock ";

struct SicdVersion {
  int major = 0, minor = 0;
};

SicdVersion VersionOf(const XmlElement& root) {
  const std::string given = root.AttributeText("xmlns");
  SicdVersion version;
  const auto fail = [&] {
    root.Fail("its namespace xmlns is " + Quoted(given) +
              ", urn:SICD:1.0.0 or later is needed, which tells the version");
  };
  if (!given.starts_with(kNamespace)) fail();
  const char* const end = given.data() + given.size();
  const auto major = std::from_chars(given.data() + kNamespace.size(), end, version.major);
  if (major.ec != std::errc() || major.ptr == end || *major.ptr != '.') fail();
  const auto minor = std::from_chars(major.ptr + 1, end, version.minor);
  if (minor.ec != std::errc() || version.major < 1) fail();
  return version;
}

void AddNumber(pugi::xml_node parent, const char* name, double value) {
  parent.append_child(name).text().set(NumberText(value).c_str());
}

void AddVector(pugi::xml_node parent, const char* name, const Eigen::Vector3d& vector) {
  pugi::xml_node node = parent.append_child(name);
  AddNumber(node, "X", vector.x());
  AddNumber(node, "Y", vector.y());
  AddNumber(node, "Z", vector.z());
}

// Only elements that are not zero, as the type of the matrix allows.
void AddMatrix(pugi::xml_node parent, const char* name, const Eigen::Matrix<double, 8, 8>& matrix) {
  pugi::xml_node node = parent.append_child(name);
  node.append_attribute("size1").set_value(8);
  node.append_attribute("size2").set_value(8);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      if (matrix(i, j) == 0.0) continue;
      pugi::xml_node entry = node.append_child("Entry");
      entry.append_attribute("index1").set_value(i + 1);
      entry.append_attribute("index2").set_value(j + 1);
      entry.text().set(NumberText(matrix(i, j)).c_str());
    }
  }
}

// ErrorStatistics stands before MatchInfo and what belongs to the kind of image.
pugi::xml_node StatisticsOf(pugi::xml_node root) {
  if (pugi::xml_node statistics = root.child("ErrorStatistics")) return statistics;
  for (const char* after : {"MatchInfo", "RgAzComp", "PFA", "RMA"}) {
    if (const pugi::xml_node next = root.child(after)) {
      return root.insert_child_before("ErrorStatistics", next);
    }
  }
  return root.append_child("ErrorStatistics");
}

void SetMark(pugi::xml_document* document) {
  for (pugi::xml_node node : document->children()) {
    if (node.type() == pugi::node_comment && std::string_view(node.value()).starts_with(kMark)) {
      document->remove_child(node);
      break;
    }
  }
  pugi::xml_node mark =
      document->insert_child_before(pugi::node_comment, document->document_element());
  mark.set_value((std::string(kMark) + Version() + " ").c_str());
}

}  // namespace

AdjustedSicd AdjustSicd(std::string_view bytes,
                        const std::string& file,
                        const SicdAdjustment& adjustment) {
  ByteSource source = ByteSource::OfBytes(bytes, file);
  const std::string text = SicdText(&source);
  AdjustedSicd adjusted;
  {
    const XmlFile checked(text, file, "SICD");  // refuses with lines
    const SicdVersion version = VersionOf(checked.Root());
    constexpr int kWithOffsets = 4;
    adjusted.raised = version.major == 1 && version.minor < kWithOffsets;
  }
  // Blanks and comments stay where they stand.
  pugi::xml_document document;
  constexpr unsigned int kKeepAll = pugi::parse_full | pugi::parse_ws_pcdata;
  if (!document.load_buffer(text.data(), text.size(), kKeepAll, pugi::encoding_utf8)) {
    throw InputError(FilePlace{file, 0, ""}, "is not valid XML");
  }
  pugi::xml_node root = document.document_element();
  if (adjusted.raised) root.attribute("xmlns").set_value("urn:SICD:1.4.0");
  pugi::xml_node statistics = StatisticsOf(root);
  while (statistics.remove_child(kAdjusted)) {
  }
  pugi::xml_node offsets = statistics.append_child(kAdjusted);
  AddVector(offsets, "ARPPosSCPCOA", adjustment.offsets.position_m);
  AddVector(offsets, "ARPVel", adjustment.offsets.velocity_mps);
  AddNumber(offsets, "TxTimeSCPCOA", 0.0);
  AddNumber(offsets, "RcvTimeSCPCOA", 2.0 / kSpeedOfLight_mps * adjustment.offsets.range_m);
  if (adjustment.covariance) AddMatrix(offsets, "APOError", *adjustment.covariance);
  if (adjustment.composite) {
    pugi::xml_node composite = offsets.append_child("CompositeSCP");
    AddNumber(composite, "Rg", adjustment.composite->range_m);
    AddNumber(composite, "Az", adjustment.composite->azimuth_m);
    AddNumber(composite, "RgAz", adjustment.composite->correlation_1);
  }
  SetMark(&document);
  std::ostringstream out;
  document.save(out, "", pugi::format_raw, pugi::encoding_utf8);
  adjusted.text = out.str();
  return adjusted;
}

AdjustedSicd AdjustSicdFile(const std::string& file, const SicdAdjustment& adjustment) {
  ByteSource source = ByteSource::OfFile(file);
  const std::string text = SicdText(&source);
  return AdjustSicd(text, file, adjustment);
}

}  // namespace sarblock

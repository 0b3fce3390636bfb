// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "adjusted_image.h"
#include "formats.h"
#include "products/image_table.h"
#include <fmt/core.h>
#include <pugixml.hpp>

namespace sarblock {
namespace {

void Add(pugi::xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(text.c_str());
}

void AddVector(pugi::xml_node parent,
               const std::array<const char*, 3>& names,
               const char* unit,
               const Eigen::Vector3d& vector) {
  for (std::size_t i = 0; i < 3; ++i) {
    pugi::xml_node node = parent.append_child(names[i]);
    node.append_attribute("unit") = unit;
    node.text().set(fmt::format("{}", vector[static_cast<Eigen::Index>(i)]).c_str());
  }
}

void AddHeader(pugi::xml_node root,
               const OrbitFile& orbit,
               const UtcTime& created,
               const std::string& creator_version) {
  pugi::xml_node header = root.append_child("Earth_Explorer_Header");
  pugi::xml_node fixed = header.append_child("Fixed_Header");
  Add(fixed, "File_Name", orbit.file);
  Add(fixed, "File_Description", "Flight path after a block adjustment");
  Add(fixed, "Notes", "");
  Add(fixed, "Mission", orbit.mission);
  Add(fixed, "File_Class", "USER");
  Add(fixed, "File_Type", "AUX_RESORB");
  pugi::xml_node validity = fixed.append_child("Validity_Period");
  Add(validity, "Validity_Start", "UTC=" + UtcMicroseconds(orbit.states.front().time));
  Add(validity, "Validity_Stop", "UTC=" + UtcMicroseconds(orbit.states.back().time));
  Add(fixed, "File_Version", "0001");
  pugi::xml_node source = fixed.append_child("Source");
  Add(source, "System", "sarblock");
  Add(source, "Creator", "sarblock");
  Add(source, "Creator_Version", creator_version);
  Add(source, "Creation_Date", "UTC=" + UtcMicroseconds(created));
  pugi::xml_node variable = header.append_child("Variable_Header");
  Add(variable, "Ref_Frame", "EARTH_FIXED");
  Add(variable, "Time_Reference", "UTC");
}

}  // namespace

std::string OrbitFileText(const OrbitFile& orbit,
                          const UtcTime& created,
                          const std::string& creator_version) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("Earth_Explorer_File");
  AddHeader(root, orbit, created, creator_version);
  pugi::xml_node data = root.append_child("Data_Block");
  data.append_attribute("type") = "xml";
  pugi::xml_node list = data.append_child("List_of_OSVs");
  list.append_attribute("count") = static_cast<unsigned long long>(orbit.states.size());
  for (const OrbitState& state : orbit.states) {
    pugi::xml_node osv = list.append_child("OSV");
    Add(osv, "TAI", "TAI=" + TaiMicroseconds(state.time));
    Add(osv, "UTC", "UTC=" + UtcMicroseconds(state.time));
    AddVector(osv, {"X", "Y", "Z"}, "m", state.position_m);
    AddVector(osv, {"VX", "VY", "VZ"}, "m/s", state.velocity_mps);
    Add(osv, "Quality", "NOMINAL");
  }
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

namespace {

void RequireWgs84(const Frame& frame) {
  if (frame.kind() == FrameKind::kLocal) {
    throw InputError("format",
                     "an orbit file holds earth-fixed positions; the frame of this result is "
                     "local, a geocentric one on WGS84 is allowed");
  }
  const Ellipsoid wgs84 = NamedEllipsoid("WGS84");
  const Ellipsoid& given = frame.ellipsoid();
  if (given.a_m != wgs84.a_m || given.flattening != wgs84.flattening) {
    throw InputError(
        "format",
        "an orbit file holds positions on the Earth; the ellipsoid of this result is " +
            given.name + ", WGS84 is allowed");
  }
}

// Sentinel-1A of S1A_IW2_VV_...
std::string MissionOf(const files::ResultPass& pass, const ExportOptions& options) {
  if (!options.mission.empty()) return options.mission;
  const std::string& id = pass.id;
  const bool sentinel =
      id.size() >= 4 && id.compare(0, 2, "S1") == 0 && id[2] >= 'A' && id[2] <= 'D' && id[3] == '_';
  if (sentinel) return std::string("Sentinel-1") + id[2];
  throw InputError("mission",
                   "an orbit file names its satellite, and '" + id +
                       "' does not begin as Sentinel-1 products do (S1A_); --mission names it");
}

// The path at whole microseconds: 1 us is 7 mm of an orbit, so a state between two of them is not
// rounded but computed anew. Below a nanosecond (7 um) it is the state itself.
std::vector<OrbitState> StatesOf(const files::ResultPass& pass, const UtcTime& epoch) {
  constexpr double kSame_s = 1e-9;
  std::vector<OrbitState> states;
  for (const StateVector& state : pass.path.states()) {
    const UtcTime exact = AddSeconds(epoch, state.time_s);
    UtcTime whole = WholeMicrosecond(exact);
    double shift_s = SecondsBetween(exact, whole);
    if (std::abs(shift_s) <= kSame_s) {
      states.push_back({whole, state.position_m, state.velocity_mps});
      continue;
    }
    auto motion = pass.path.At(state.time_s + shift_s);
    if (!motion) {  // of the first or last state: the next one inside
      whole = WholeMicrosecond(AddSeconds(whole, shift_s < 0.0 ? 1e-6 : -1e-6));
      shift_s = SecondsBetween(exact, whole);
      motion = pass.path.At(state.time_s + shift_s);
    }
    if (!motion) continue;
    states.push_back({whole, motion->position_m, motion->velocity_mps});
  }
  const auto not_later = [](const OrbitState& a, const OrbitState& b) {
    return !(SecondsBetween(a.time, b.time) > 0.0);
  };
  states.erase(std::unique(states.begin(), states.end(), not_later), states.end());
  if (states.size() < 2) {
    throw InputError("format",
                     "pass '" + pass.id +
                         "' spans less than two microseconds, an orbit file needs "
                         "two states");
  }
  return states;
}

}  // namespace

void WriteOrbitFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report) {
  RequireWgs84(view.result.frame);
  std::vector<OrbitFile> orbits;
  std::set<std::string> names;
  for (const files::ResultPass& pass : view.result.passes) {
    OrbitFile orbit{FileNameOf(pass.id), MissionOf(pass, view.options), {}};
    orbit.states = StatesOf(pass, EpochOf(pass, "an orbit file"));
    if (!names.insert(orbit.file).second) {
      throw InputError("format", "two passes would have the file " + orbit.file + ".EOF");
    }
    orbits.push_back(std::move(orbit));
  }
  const auto given = ParseUtc(view.options.created_utc);
  MakeFolder(folder);
  for (const OrbitFile& orbit : orbits) {
    const UtcTime created = given ? *given : orbit.states.back().time;
    const std::filesystem::path file = folder / (orbit.file + ".EOF");
    AtomicFile out(file);
    out.Write(OrbitFileText(orbit, WholeSecond(created), Version()));
    out.Commit();
    report->files.push_back(file);
  }
  report->paths = orbits.size();
  report->not_carried.emplace_back("points, residuals, standard deviations of the paths");
  for (const ParameterResult& parameter : view.result.parameters) {
    // Positions and times are in the states.
    if (parameter.name.starts_with("position.") || parameter.name == "time.bias") continue;
    report->not_carried.push_back(fmt::format(
        "{}: {} {:.6g} {}", parameter.owner, parameter.name, parameter.value, parameter.unit));
  }
}

}  // namespace sarblock

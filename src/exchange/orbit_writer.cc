// SPDX-License-Identifier: Apache-2.0
#include <sstream>

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

}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#include "run_origin.h"

#include "sarblock/io/adjust_table.h"

#include <sstream>

#include <toml++/toml.h>

namespace sarblock {

nlohmann::ordered_json ConfigurationJson(const AdjustOptions& options) {
  const toml::table table = toml::parse(DumpAdjustTable(options));
  std::ostringstream text;
  text << toml::json_formatter{*table.get("adjust")};
  auto configuration = nlohmann::ordered_json::parse(text.str());
  configuration["threads"] = options.threads;
  return configuration;
}

nlohmann::ordered_json InputsJson(const std::vector<InputFile>& files) {
  auto inputs = nlohmann::ordered_json::array();
  for (const InputFile& file : files) {
    inputs.push_back({{"file", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  }
  return inputs;
}

}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#include "product/csm_isd.h"

#include "csm_isd_parts.h"
#include "csm_model.h"

namespace sarblock {

RadarImage ParseCsmIsd(std::string_view text, const std::string& file) {
  if (IsCsmState(text)) return ParseCsmState(text, file).image;
  const JsonFile json(text, file);
  return IsdImage(json.Root(), file);
}

RadarImage ReadCsmIsd(const std::string& file) { return ParseCsmIsd(ReadCsmText(file), file); }

}  // namespace sarblock

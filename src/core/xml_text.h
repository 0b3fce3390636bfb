// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sarblock {

/// Text for XML: & < > " escaped, control characters as spaces.
[[nodiscard]] std::string XmlText(std::string_view text);

}  // namespace sarblock

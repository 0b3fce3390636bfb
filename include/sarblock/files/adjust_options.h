// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// Every key of `[adjust]`, in the order of the manual. The same table drives reading,
/// `--dump-config` and the documentation.
[[nodiscard]] std::span<const AdjustOption> AdjustOptionTable();

/// Reads the `[adjust]` table of a TOML text (no table: the defaults). `file` is for messages,
/// `pass_ids` are what `passes = [...]` may name. Everything not allowed throws InputError with
/// place and key; an unknown key gets the nearest known one.
/// `overrides` are `KEY=VALUE` with dotted keys below `adjust` ("correction.position.degree=2");
/// a value that is no TOML is taken as a text.
[[nodiscard]] AdjustOptions ReadAdjustTable(std::string_view toml_text,
                                            const std::string& file,
                                            const std::vector<std::string>& pass_ids,
                                            const std::vector<std::string>& overrides = {});

/// The options as a TOML `[adjust]` table, defaults written out; reads back to the same options.
[[nodiscard]] std::string DumpAdjustTable(const AdjustOptions& options);

}  // namespace sarblock

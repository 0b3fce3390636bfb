// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sarblock {

enum class HeadlineState {
  kAccepted,
  kTestsFailed,
  kNotAccepted,
  kNeutral,  ///< nothing to accept: a prediction, a study, a comparison
};

/// The first thing a reader sees: is it accepted and why, how accurate, what limits it.
struct Headline {
  HeadlineState state = HeadlineState::kNeutral;
  std::string word;                    ///< "Accepted"
  std::vector<std::string> sentences;  ///< three at most: verdict, accuracy, what would help
  std::string would_help;              ///< in a few words; may be empty
  std::vector<std::string> attention;  ///< what a careful reader should look at; may be empty
};

}  // namespace sarblock

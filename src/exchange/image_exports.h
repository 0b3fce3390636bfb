// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "export_view.h"
#include "products/utc.h"

namespace sarblock {

/// What time_s = 0 of a pass is. Throws InputError where it is not told; `what` ("an orbit file")
/// needs it.
[[nodiscard]] UtcTime EpochOf(const ResultPass& pass, const std::string& what);

/// The id of a pass as the name of a file: letters, digits, dots and dashes; anything else becomes
/// an underscore.
[[nodiscard]] std::string FileNameOf(const std::string& id);

/// An image that was given for a pass.
struct PassImage {
  std::size_t pass = 0;  ///< index in the result
  std::string file;
};

/// What is said of one image's file.
struct ImageNotes {
  std::vector<std::string> not_carried;  ///< with its size where it has one
  std::vector<std::string> warnings;
};
/// One image's file as it was made.
struct MadeImage {
  std::string text;
  ImageNotes notes;
};
using ImageMaker = std::function<MadeImage(const PassImage&)>;

/// Writes one file for each image given, its name that of the pass and an ending, after all of them
/// are made. Passes without an image are told among what is not carried. Throws InputError where no
/// image is given, two are of one pass, or a pass is not in the result.
void WriteImageFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     const char* ending,
                     const ImageMaker& make,
                     ExportReport* report);

}  // namespace sarblock

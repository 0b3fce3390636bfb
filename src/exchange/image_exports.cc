// SPDX-License-Identifier: Apache-2.0
#include "image_exports.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

namespace sarblock {
namespace {

std::vector<PassImage> ImagesOf(const ExportView& view) {
  if (view.options.images.empty()) {
    throw InputError("image", "none given: --image PASS=FILE names the file of a pass");
  }
  std::vector<std::string> ids;
  for (const ResultPass& pass : view.result.passes) ids.push_back(pass.id);
  std::vector<PassImage> images;
  std::set<std::size_t> passes;
  for (const ExportImage& image : view.options.images) {
    const auto found = std::find(ids.begin(), ids.end(), image.pass);
    if (found == ids.end()) {
      throw InputError(
          "image",
          "the result has no pass '" + image.pass + "'" + DidYouMean(NearestName(image.pass, ids)));
    }
    const auto pass = static_cast<std::size_t>(found - ids.begin());
    if (!passes.insert(pass).second) {
      throw InputError("image", "pass '" + image.pass + "' is given two files, one is allowed");
    }
    images.push_back({pass, image.file});
  }
  return images;
}

}  // namespace

UtcTime EpochOf(const ResultPass& pass, const std::string& what) {
  if (pass.epoch_utc.empty()) {
    throw InputError("format",
                     what + " needs UTC, and pass '" + pass.id +
                         "' does not tell what its time_s = 0 is: epoch_utc of the pass in "
                         "block.toml tells it");
  }
  const auto epoch = ParseUtc(pass.epoch_utc);
  if (!epoch) {
    throw InputError("format",
                     what + " needs UTC, and epoch_utc of pass '" + pass.id + "', '" +
                         pass.epoch_utc + "', is no such time; 2022-10-16T01:50:44Z is one");
  }
  return *epoch;
}

std::string FileNameOf(const std::string& id) {
  std::string name = id;
  std::replace_if(
      name.begin(),
      name.end(),
      [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-';
      },
      '_');
  return name;
}

void WriteImageFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     const char* ending,
                     const ImageMaker& make,
                     ExportReport* report) {
  const std::vector<PassImage> images = ImagesOf(view);
  std::vector<std::pair<std::string, std::string>> files;
  std::set<std::string> names;
  for (const PassImage& image : images) {
    const std::string& id = view.result.passes[image.pass].id;
    MadeImage made = make(image);
    files.emplace_back(FileNameOf(id) + ending, std::move(made.text));
    if (!names.insert(files.back().first).second) {
      throw InputError("format", "two passes would have the file " + files.back().first);
    }
    for (const std::string& what : made.notes.not_carried) {
      report->not_carried.push_back(id + ": " + what);
    }
    for (const std::string& what : made.notes.warnings)
      report->warnings.push_back(id + ": " + what);
  }
  for (std::size_t pass = 0; pass < view.result.passes.size(); ++pass) {
    const auto of_pass = [pass](const PassImage& image) { return image.pass == pass; };
    if (std::none_of(images.begin(), images.end(), of_pass)) {
      report->not_carried.push_back(view.result.passes[pass].id + ": no --image was given for it");
    }
  }
  report->not_carried.emplace_back(
      "points, residuals, covariances between passes; standard deviations of points");
  MakeFolder(folder);
  for (const auto& [name, text] : files) {
    AtomicFile out(folder / name);
    out.Write(text);
    out.Commit();
    report->files.push_back(folder / name);
  }
  report->paths = files.size();
}

}  // namespace sarblock

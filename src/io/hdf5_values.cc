// SPDX-License-Identifier: Apache-2.0
#include "hdf5_values.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "hdf5_input.h"

namespace sarblock {
namespace {

constexpr std::size_t kLongestText = std::size_t{1} << 16;

void Require(const Hdf5Values& values, const std::string& path) {
  if (!values.Has(path)) values.Fail(path, "is missing");
}

std::string TrimmedText(std::string text) {
  text.resize(std::min(text.size(), text.find('\0')));
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

void RequireWhole(const OpenedHdf5& opened, const std::string& path, const StoredDataset& stored) {
  if (stored.whole) return;
  opened.Fail(path,
              "has " + std::to_string(stored.count) + " values, not all of which are in the file");
}

}  // namespace

Hdf5Values::Hdf5Values(const std::string& file)
    : opened_(std::make_unique<OpenedHdf5>(OpenHdf5(file))) {}
Hdf5Values::~Hdf5Values() = default;

const std::string& Hdf5Values::file() const { return opened_->path; }

void Hdf5Values::Fail(const std::string& path, const std::string& problem) const {
  opened_->Fail(path, problem);
}

bool Hdf5Values::Has(const std::string& path) const {
  // Name by name, for libhdf5 asks of the last one alone whether it is a link.
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    const std::string part = path.substr(0, end);
    if (!HasMember(*opened_, opened_->file.get(), part, part)) return false;
    if (end == std::string::npos) return true;
  }
}

std::string Hdf5Values::Text(const std::string& path) const {
  Require(*this, path);
  const StoredDataset stored = OpenStored(*opened_, opened_->file.get(), path, path, 0);
  if (stored.type != H5T_STRING || stored.count != 1 || stored.value_bytes > kLongestText) {
    Fail(path, "is no text, one string is needed");
  }
  RequireWhole(*opened_, path, stored);
  const Hdf5Id type(H5Dget_type(stored.dataset.get()), H5Tclose);
  bool read = false;
  std::string text;
  if (stored.variable_text) {
    char* value = nullptr;
    read = H5Dread(stored.dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) >= 0 &&
           value != nullptr;
    if (read) text = value;
    H5free_memory(value);
  } else {
    text.resize(stored.value_bytes);
    read =
        H5Dread(stored.dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) >= 0;
  }
  if (!read) Fail(path, "cannot be read, the file is damaged");
  return TrimmedText(std::move(text));
}

double Hdf5Values::Number(const std::string& path) const {
  return Numbers(path, 0, 1).values.front();
}

Hdf5Array Hdf5Values::Numbers(const std::string& path, int rank, std::size_t most) const {
  Require(*this, path);
  const StoredDataset stored = OpenStored(*opened_, opened_->file.get(), path, path, rank);
  if (stored.type != H5T_FLOAT && stored.type != H5T_INTEGER) {
    Fail(path, "holds no numbers, which are needed");
  }
  if (stored.count == 0) Fail(path, "is empty, numbers are needed");
  if (stored.count > most) {
    Fail(path,
         "has " + std::to_string(stored.count) + " values, at most " + std::to_string(most) +
             (most == 1 ? " is" : " are") + " allowed");
  }
  RequireWhole(*opened_, path, stored);
  Hdf5Array array;
  array.size.assign(stored.size.begin(), stored.size.end());
  array.values.resize(stored.count);
  if (H5Dread(stored.dataset.get(),
              H5T_NATIVE_DOUBLE,
              H5S_ALL,
              H5S_ALL,
              H5P_DEFAULT,
              array.values.data()) < 0) {
    Fail(path, "cannot be read, the file is damaged");
  }
  for (const double value : array.values) {
    if (!std::isfinite(value)) Fail(path, "holds " + NumberText(value) + ", numbers are needed");
  }
  return array;
}

std::string Hdf5Values::TextAttribute(const std::string& path, const std::string& name) const {
  Require(*this, path);
  const Hdf5Id object(H5Oopen(opened_->file.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  if (!object.valid()) Fail(path, "is no dataset that can be read");
  const std::string place = path + " (" + name + ")";
  auto text = ReadTextAttribute(*opened_, object.get(), name, place);
  if (!text) Fail(place, "the attribute is missing");
  return TrimmedText(std::move(*text));
}

}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#include "stored_texts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sarblock {
namespace {

/// That are kept of the texts of some rows; our chunks of texts have as many.
constexpr std::uint64_t kBytesAtOnce = std::uint64_t{1} << 20;
constexpr std::uint64_t kBytesOfPiece = std::uint64_t{1} << 17;  // where no chunk is inflated

/// Whether chunks that are not stored read as numbers that are not given: NaN, or -1 of integers.
bool FillsWithNothing(hid_t creation, H5T_class_t type) {
  H5D_fill_value_t defined = H5D_FILL_VALUE_UNDEFINED;
  double fill = 0.0;
  if (type == H5T_STRING || H5Pfill_value_defined(creation, &defined) < 0 ||
      defined != H5D_FILL_VALUE_USER_DEFINED ||
      H5Pget_fill_value(creation, H5T_NATIVE_DOUBLE, &fill) < 0) {
    return false;
  }
  return type == H5T_FLOAT ? std::isnan(fill) : fill == -1.0;
}

}  // namespace

StoredDataset OpenColumn(const OpenedHdf5& opened,
                         hid_t group,
                         const std::string& name,
                         const std::string& path) {
  StoredDataset column = OpenStored(opened, group, name, path, 1);
  if (!column.whole) {
    const Hdf5Id made(H5Dget_create_plist(column.dataset.get()), H5Pclose);
    if (!FillsWithNothing(made.get(), column.type)) {
      opened.Fail(
          path, "has " + std::to_string(column.count) + " rows, not all of which are in the file");
    }
  }
  return column;
}

StoredTexts::StoredTexts(const OpenedHdf5& opened,
                         hid_t group,
                         const std::string& name,
                         std::string path)
    : opened_(opened), path_(std::move(path)) {
  if (!HasMember(opened, group, name, path_))
    opened.Fail(path_, "the dataset is missing, it holds texts");
  stored_ = OpenColumn(opened, group, name, path_);
  if (stored_.type != H5T_STRING || stored_.variable_text) {
    opened.Fail(path_, "is no dataset of strings of a fixed length, which is needed");
  }
  type_ = Hdf5Id(H5Dget_type(stored_.dataset.get()), H5Tclose);
  blanks_ = H5Tget_strpad(type_.get()) == H5T_STR_SPACEPAD;
  const Hdf5Id made(H5Dget_create_plist(stored_.dataset.get()), H5Pclose);
  deflated_ = H5Pget_nfilters(made.get()) > 0;
}

void StoredTexts::ReadPadded(std::uint64_t first,
                             std::uint64_t count,
                             std::vector<char>* characters) const {
  characters->resize(count * stored_.value_bytes);
  const hsize_t size = count;
  const Hdf5Id from = SelectRows(stored_.dataset.get(), first, count);
  const Hdf5Id to(H5Screate_simple(1, &size, nullptr), H5Sclose);
  if (!from.valid() || H5Dread(stored_.dataset.get(),
                               type_.get(),
                               to.get(),
                               from.get(),
                               H5P_DEFAULT,
                               characters->data()) < 0) {
    opened_.Fail(path_, "cannot be read, the file is damaged");
  }
}

std::string_view StoredTexts::Text(const std::vector<char>& characters, std::size_t which) const {
  const char* const begin = characters.data() + which * stored_.value_bytes;
  std::string_view text(begin, strnlen(begin, stored_.value_bytes));
  while (blanks_ && text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

void StoredTexts::ForEach(const std::function<void(std::string_view)>& take) const {
  const std::uint64_t at_once =
      std::max<std::uint64_t>(1, (deflated_ ? kBytesAtOnce : kBytesOfPiece) / stored_.value_bytes);
  std::vector<char> characters;
  for (std::uint64_t first = 0; first < stored_.count; first += at_once) {
    const std::uint64_t count = std::min(at_once, stored_.count - first);
    ReadPadded(first, count, &characters);
    for (std::size_t i = 0; i < count; ++i) take(Text(characters, i));
  }
}

const IdTable& StoredTexts::All() const {
  const std::lock_guard<std::mutex> lock(Hdf5Mutex());
  if (!all_) {
    IdTable all;
    ForEach([&all](std::string_view text) { all.Append(text); });
    all_ = std::make_unique<const IdTable>(std::move(all));
  }
  return *all_;
}

std::string_view TextsOfRows::Of(const StoredTexts& texts,
                                 std::span<const std::uint32_t> rows,
                                 std::uint32_t index) {
  if (kept_ == Kept::kNothing) Read(texts, rows);
  if (kept_ == Kept::kAll) return (*all_)[index];
  return texts.Text(characters_, index - first_);
}

void TextsOfRows::Read(const StoredTexts& texts, std::span<const std::uint32_t> rows) {
  const auto [least, greatest] = std::minmax_element(rows.begin(), rows.end());
  const std::uint64_t count = std::uint64_t{*greatest} - *least + 1;
  // Far apart or long: a table of all of them takes less. Deflated: every read inflates a chunk.
  if (texts.deflated_ || *greatest >= texts.size() || count > 2 * kSlabRows ||
      count > kBytesAtOnce / texts.stored_.value_bytes) {
    all_ = &texts.All();
    kept_ = Kept::kAll;
    return;
  }
  const std::lock_guard<std::mutex> lock(Hdf5Mutex());
  first_ = *least;
  texts.ReadPadded(first_, count, &characters_);
  kept_ = Kept::kThese;
}

StoredIds::Ids StoredIds::Of(CellKind kind) {
  const std::size_t which = kind == CellKind::kPass ? 0 : 1;
  const char* const name = which == 0 ? kPassIds : kPointIds;
  std::shared_ptr<const StoredTexts> texts = texts_[which].lock();
  if (!texts) {
    texts = std::make_shared<const StoredTexts>(
        opened_, opened_.file.get(), name, std::string("/") + name);
    texts_[which] = texts;
  }
  return {std::move(texts), &memo_[which]};
}

}  // namespace sarblock

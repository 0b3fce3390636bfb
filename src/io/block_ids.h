// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"

#include <functional>
#include <string_view>

namespace sarblock {

/// Texts in their order, wherever they stand.
class TextList {
 public:
  virtual ~TextList() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  virtual void ForEach(const std::function<void(std::string_view)>& take) const = 0;
};

/// Those of a table, which must outlive this.
class TextsOfTable final : public TextList {
 public:
  explicit TextsOfTable(const IdTable& table) : table_(table) {}
  [[nodiscard]] std::size_t size() const override { return table_.size(); }
  void ForEach(const std::function<void(std::string_view)>& take) const override {
    for (std::size_t i = 0; i < table_.size(); ++i) take(table_[i]);
  }

 private:
  const IdTable& table_;
};

/// Ids that tables hold the index of, where they stand once; null where they do not.
struct BlockIds {
  const TextList* passes = nullptr;
  const TextList* points = nullptr;
};

}  // namespace sarblock

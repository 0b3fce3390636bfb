// SPDX-License-Identifier: Apache-2.0
// Replays the fuzzer's corpus: nothing but InputError may come of a file.
#include <filesystem>
#include <string>

#include "fuzz/product_fuzz_targets.h"
#include "support/folder_test.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class ProductCorpusTest : public test::FolderTest {};

TEST_F(ProductCorpusTest, AnnotationsAndOrbitFilesAreReadOrRefused) {
  std::size_t files = 0, read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "product")) {
    const std::string text = Content(entry.path());
    EXPECT_NO_THROW(fuzz::Product(text)) << entry.path();
    ++files;
    try {
      static_cast<void>(ImportProducts({ParseSentinel1(text, "a.xml")}, {}, ImportOptions{}));
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GE(files, 20u);
  EXPECT_GE(read, 4u);
}

}  // namespace
}  // namespace sarblock

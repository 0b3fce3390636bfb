// SPDX-License-Identifier: Apache-2.0
// Replays the fuzzers' corpus: nothing but InputError may come of a file (fuzz_targets.h aborts).
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/container_fuzz_targets.h"
#include "fuzz/fuzz_targets.h"
#include "support/folder_test.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class FuzzCorpusTest : public test::FolderTest {
 protected:
  static std::vector<std::string> Corpus(const std::string& name) {
    std::vector<std::string> texts;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / name)) {
      texts.push_back(Content(entry.path()));
    }
    return texts;
  }
};

TEST_F(FuzzCorpusTest, TablesAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("csv");
  EXPECT_GE(texts.size(), 20u);
  for (const std::string& text : texts) EXPECT_NO_THROW(fuzz::Csv(text));
}

TEST_F(FuzzCorpusTest, BlockTablesAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("block_toml");
  EXPECT_GE(texts.size(), 20u);
  for (const std::string& text : texts) EXPECT_NO_THROW(fuzz::BlockToml(text));
}

TEST_F(FuzzCorpusTest, ContainersAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("container");
  EXPECT_GE(texts.size(), 30u);
  for (const std::string& text : texts) EXPECT_NO_THROW(fuzz::Container(text, folder_)) << text;
  fuzz::WriteSmallContainer(folder_ / "whole.h5");
  EXPECT_EQ(files::ReadBlock(folder_ / "whole.h5").block.looks.size(), 2u);
}

TEST_F(FuzzCorpusTest, ScenesAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("scene");
  EXPECT_GE(texts.size(), 20u);
  std::size_t read = 0;
  for (const std::string& text : texts) {
    EXPECT_NO_THROW(fuzz::SceneToml(text));
    try {
      static_cast<void>(files::ParseScene(text, "scene.toml"));
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GE(read, 12u);  // the shipped scenes stand in the corpus
}

TEST_F(FuzzCorpusTest, ResultsAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("result");
  EXPECT_GE(texts.size(), 20u);
  for (const std::string& text : texts) EXPECT_NO_THROW(fuzz::Result(text));
  EXPECT_NO_THROW(static_cast<void>(files::ReadResultTexts(
      {fuzz::kSummary, fuzz::kResultPoints, fuzz::kResultPasses, fuzz::kResiduals, fuzz::kPaths})));
}

TEST_F(FuzzCorpusTest, StudiesAreReadOrRefused) {
  const std::vector<std::string> texts = Corpus("study");
  EXPECT_GE(texts.size(), 20u);
  std::size_t read = 0;
  for (const std::string& text : texts) {
    EXPECT_NO_THROW(fuzz::StudyToml(text));
    try {
      static_cast<void>(ParseDensification(
          text, "study.toml", {}, [](const std::string&) { return std::string(fuzz::kScene); }));
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GE(read, 6u);
  const auto text_of = [](const std::string& name) {
    return Content(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "study" / name);
  };
  EXPECT_FALSE(
      ParseTradeoffStudy(text_of("tradeoff.toml"), "study.toml", {}, [](const std::string&) {
        return std::string(fuzz::kScene);
      }).choices.empty());
  EXPECT_EQ(ParseStability(text_of("stability.toml"), "study.toml").families.size(), 3u);
}

}  // namespace
}  // namespace sarblock

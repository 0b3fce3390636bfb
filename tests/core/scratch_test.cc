// SPDX-License-Identifier: Apache-2.0
// Arrays in mapped files: what is mapped, that nothing stays behind, what is refused.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "core/memory.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/statfs.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::size_t kBytes = kScratchMinBytes + 4099;  // no whole pages

class ScratchTest : public testing::Test {
 protected:
  ScratchTest() {
    std::string name = (fs::temp_directory_path() / "sarblock-scratch-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~ScratchTest() override { fs::remove_all(folder_); }
  [[nodiscard]] bool Empty() const { return fs::is_empty(folder_); }

  fs::path folder_;
};

std::string WordsOf(const fs::path& folder, std::size_t bytes) {
  try {
    const ScratchScope scope(folder);
    static_cast<void>(AllocateScratch(bytes));
  } catch (const ScratchError& error) {
    return error.what();
  }
  return {};
}

TEST_F(ScratchTest, AnArrayKeepsItsBytesAndItsFileHasNoName) {
  std::optional<ScratchScope> scope(folder_);
  std::span<unsigned char> array(static_cast<unsigned char*>(AllocateScratch(kBytes)), kBytes);
  ASSERT_NE(array.data(), nullptr);
  EXPECT_TRUE(Empty());
  unsigned char value = 17;
  for (unsigned char& byte : array) byte = value = static_cast<unsigned char>(5 * value + 3);
  scope.reset();  // arrays outlive it
  value = 17;
  std::size_t wrong = 0;
  for (const unsigned char byte : array) {
    value = static_cast<unsigned char>(5 * value + 3);
    wrong += byte == value ? 0U : 1U;
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_TRUE(FreeScratch(array.data()));
  EXPECT_TRUE(Empty());
}

TEST_F(ScratchTest, SmallArraysAndThoseOutsideAScopeAreMemory) {
  EXPECT_EQ(AllocateScratch(kBytes), nullptr);
  const ScratchScope scope(folder_);
  EXPECT_EQ(AllocateScratch(kScratchMinBytes - 1), nullptr);
  {
    const ResidentScope resident;
    EXPECT_EQ(ScratchScope::Current(), nullptr);
    EXPECT_EQ(AllocateScratch(kBytes), nullptr);
  }
  EXPECT_EQ(ScratchScope::Current(), &scope);
  std::thread([] { EXPECT_EQ(AllocateScratch(kBytes), nullptr); }).join();
}

TEST_F(ScratchTest, GivesBackItsOwnAloneInAnyOrder) {
  const ScratchScope scope(folder_);
  void* first = AllocateScratch(kBytes);
  void* second = AllocateScratch(2 * kBytes);
  void* third = AllocateScratch(kBytes);
  void* aligned = std::aligned_alloc(4096, 8192);  // an address as a mapping has
  EXPECT_FALSE(FreeScratch(nullptr));
  EXPECT_FALSE(FreeScratch(aligned));
  for (void* array : {second, first, third}) {
    EXPECT_TRUE(FreeScratch(array));
    EXPECT_FALSE(FreeScratch(aligned));
  }
  std::free(aligned);
}

TEST_F(ScratchTest, RefusesAFolderWithoutFilesByItsName) {
  std::ofstream(folder_ / "file") << "text";
  for (const fs::path& folder : {folder_ / "missing", folder_ / "file", fs::path("/proc")}) {
    EXPECT_THAT(WordsOf(folder, kBytes), HasSubstr(folder.string() + ": has no place for a "));
    EXPECT_EQ(ScratchScope::Current(), nullptr);
  }
}

TEST_F(ScratchTest, RefusesWhatAFullDiskCannotHold) {
  const fs::path shared = "/dev/shm";  // of limited size, told without filling it
  struct statfs of_shared {};
  constexpr long kTmpfs = 0x01021994;
  if (statfs(shared.c_str(), &of_shared) != 0 || of_shared.f_type != kTmpfs ||
      of_shared.f_blocks == 0) {
    GTEST_SKIP() << "no /dev/shm of limited size";
  }
  const std::string words = WordsOf(shared, std::size_t{1} << 46);
  EXPECT_THAT(words, HasSubstr("/dev/shm: has no place for a scratch file of 67108864 MiB: "));
  EXPECT_THAT(words, HasSubstr("No space left on device; --scratch takes a folder"));
}

TEST_F(ScratchTest, RefusesFilesAboveTheLimitOfTheProcessWithoutASignal) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit lowered{kScratchMinBytes, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &lowered), 0);
  const std::string words = WordsOf(folder_, kBytes);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_THAT(words, HasSubstr("File too large"));
  EXPECT_TRUE(Empty());
}

}  // namespace
}  // namespace sarblock

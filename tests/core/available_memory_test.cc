// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/memory.h"
#include <gtest/gtest.h>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr double kMiB = 1024.0 * 1024.0;

/// A folder that stands for the files of a system; by hand as the kernel writes them.
class AvailableMemoryTest : public testing::Test {
 protected:
  AvailableMemoryTest()
      : root_(fs::temp_directory_path() /
              ("sarblock_available_memory_" + std::to_string(::getpid()))) {
    fs::remove_all(root_);
    Put("proc/meminfo",
        "MemTotal:       24684380 kB\nMemFree:         1024000 kB\nMemAvailable:    3072000 kB\n");
  }
  ~AvailableMemoryTest() override { fs::remove_all(root_); }
  void Put(const std::string& file, const std::string& text) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  fs::path root_;
};

TEST_F(AvailableMemoryTest, IsWhatTheKernelCallsAvailable) {
  EXPECT_EQ(AvailableMemory_bytes(root_), 3000.0 * kMiB);
  Put("proc/meminfo", "MemTotal:       24684380 kB\n");
  EXPECT_TRUE(std::isinf(AvailableMemory_bytes(root_)));
}

TEST_F(AvailableMemoryTest, IsNoMoreThanAGroupOfVersion2LeavesWithItsCacheFreed) {
  Put("proc/self/cgroup", "0::/slice/job\n");
  Put("sys/fs/cgroup/slice/job/memory.max", "max\n");
  Put("sys/fs/cgroup/slice/job/memory.current", "104857600\n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 3000.0 * kMiB);
  Put("sys/fs/cgroup/slice/memory.max", "629145600\n");      // 600 MiB
  Put("sys/fs/cgroup/slice/memory.current", "314572800\n");  // 300
  Put("sys/fs/cgroup/slice/memory.stat", "anon 209715200\nfile 104857600\n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 400.0 * kMiB);
  Put("sys/fs/cgroup/slice/job/memory.max", "157286400\n");  // 150, of which 100 are used
  EXPECT_EQ(AvailableMemory_bytes(root_), 50.0 * kMiB);
}

TEST_F(AvailableMemoryTest, IsNoMoreThanAGroupOfVersion1Leaves) {
  Put("proc/self/cgroup", "9:name=systemd:/\n5:cpu,cpuacct:/a\n4:memory:/a/b\n");
  Put("sys/fs/cgroup/memory/a/b/memory.limit_in_bytes", "9223372036854771712\n");
  Put("sys/fs/cgroup/memory/a/b/memory.usage_in_bytes", "52428800\n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 3000.0 * kMiB);
  Put("sys/fs/cgroup/memory/a/memory.limit_in_bytes", "419430400\n");  // 400
  Put("sys/fs/cgroup/memory/a/memory.usage_in_bytes", "367001600\n");  // 350
  Put("sys/fs/cgroup/memory/a/memory.stat", "cache 1\ntotal_cache 157286400\n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 200.0 * kMiB);
  Put("sys/fs/cgroup/memory/a/memory.usage_in_bytes", "576716800\n");  // beyond the limit
  EXPECT_EQ(AvailableMemory_bytes(root_), 0.0);
}

TEST_F(AvailableMemoryTest, IsNoMoreThanTheLimitOnAddressesLeaves) {
  Put("proc/self/statm", "25600 1000 900 10 0 800 0\n");  // 100 MiB asked for, of pages of 4 KiB
  Put("proc/self/limits",
      "Limit                     Soft Limit           Hard Limit           Units     \n"
      "Max cpu time              unlimited            unlimited            seconds   \n"
      "Max address space         unlimited            unlimited            bytes     \n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 3000.0 * kMiB);
  Put("proc/self/limits",
      "Max address space         419430400            unlimited            bytes     \n");  // 400
  EXPECT_EQ(AvailableMemory_bytes(root_), 300.0 * kMiB);
  Put("proc/self/statm", "256000 1000 900 10 0 800 0\n");
  EXPECT_EQ(AvailableMemory_bytes(root_), 0.0);
}

TEST_F(AvailableMemoryTest, OfThisSystemIsThereOrUnknown) {
  EXPECT_GT(AvailableMemory_bytes(), 0.0);
}

}  // namespace
}  // namespace sarblock

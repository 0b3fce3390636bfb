// SPDX-License-Identifier: Apache-2.0
#include "available_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr double kUnlimited_bytes = std::numeric_limits<double>::infinity();

/// The number in a file of one number; nothing where there is none ("max").
std::optional<double> NumberIn(const fs::path& file) {
  std::ifstream in(file);
  double value = 0.0;
  if (in >> value) return value;
  return std::nullopt;
}

/// The number behind a name in a file of lines "name number" or "name: number".
std::optional<double> NumberAfter(const fs::path& file, const std::string& name) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string first;
    double value = 0.0;
    if (words >> first && (first == name || first == name + ":") && words >> value) return value;
  }
  return std::nullopt;
}

/// Names of a control group's files.
struct GroupFiles {
  const char* limit;
  const char* usage;
  const char* cache;  ///< in memory.stat
};
constexpr GroupFiles kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_cache"};
constexpr GroupFiles kVersion2{"memory.max", "memory.current", "file"};

/// What a group and those it stands in leave.
double LeftByGroups(const fs::path& mount, const fs::path& group, const GroupFiles& files) {
  double left_bytes = kUnlimited_bytes;
  for (fs::path at = group.relative_path();; at = at.parent_path()) {
    const fs::path folder = at.empty() ? mount : mount / at;
    const std::optional<double> limit = NumberIn(folder / files.limit);
    const std::optional<double> usage = NumberIn(folder / files.usage);
    if (limit && usage) {
      const double cache = NumberAfter(folder / "memory.stat", files.cache).value_or(0.0);
      left_bytes = std::min(left_bytes, std::max(0.0, *limit - std::max(0.0, *usage - cache)));
    }
    if (at.empty()) return left_bytes;
  }
}

}  // namespace

double AvailableMemory_bytes(const fs::path& root) {
  double left_bytes = kUnlimited_bytes;
  if (const auto kib = NumberAfter(root / "proc/meminfo", "MemAvailable")) {
    left_bytes = 1024.0 * *kib;
  }
  std::ifstream groups(root / "proc/self/cgroup");
  std::string line;  // "0::/path" of version 2, "4:memory:/path" of version 1
  while (std::getline(groups, line)) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    const fs::path mounted = root / "sys/fs/cgroup";
    if (controllers == ",,") {
      left_bytes = std::min(left_bytes, LeftByGroups(mounted, group, kVersion2));
    } else if (controllers.find(",memory,") != std::string::npos) {
      left_bytes = std::min(left_bytes, LeftByGroups(mounted / "memory", group, kVersion1));
    }
  }
  return left_bytes;
}

}  // namespace sarblock

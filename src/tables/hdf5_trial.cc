// SPDX-License-Identifier: Apache-2.0
#include "hdf5_trial.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/threads.h"
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

// The program of the walk as it was built (hdf5_walk.cc). It stands in the library, so that whoever
// links it, a program, a Python package or a program of others, needs no second file and no path.
asm(R"(
  .pushsection .rodata
  .balign 16
sarblock_hdf5_walk_begin:
  .incbin ")" SARBLOCK_HDF5_WALK R"("
sarblock_hdf5_walk_end:
  .popsection
)");
extern "C" {
[[gnu::visibility("hidden")]] extern const char sarblock_hdf5_walk_begin[];
[[gnu::visibility("hidden")]] extern const char sarblock_hdf5_walk_end[];
}

namespace sarblock {
namespace {

std::atomic<bool> g_apart{true};

using Clock = std::chrono::steady_clock;

/// Of the clock on the wall: a disk may be slow, and so may a machine with other work. The walk
/// itself bounds what it computes.
constexpr std::chrono::seconds kMinDeadline{120};
constexpr std::uint64_t kBytesPerSecond = std::uint64_t{10} << 20;
constexpr std::chrono::milliseconds kAskEvery{20};
/// Every block of memory comes from where M_PERTURB of the walk fills it; those that a thread keeps
/// for itself hold what was in them before.
constexpr std::string_view kTunables = "GLIBC_TUNABLES=glibc.malloc.tcache_count=0";

[[noreturn]] void Fail(const std::string& path, const std::string& problem) {
  throw InputError(FilePlace{path, 0, ""}, problem);
}

[[noreturn]] void FailStart(const std::string& path, int code) {
  Fail(path,
       std::string("cannot be tried in a process of its own before it is read: ") +
           std::strerror(code));
}

class Descriptor {
 public:
  Descriptor() = default;
  /// Takes its number and gives one above those that the new process has for its own streams.
  explicit Descriptor(int number) {
    constexpr int kFirst = 10;
    if (number < 0) return;
    number_ = ::fcntl(number, F_DUPFD_CLOEXEC, kFirst);
    ::close(number);
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  [[nodiscard]] int get() const { return number_; }
  [[nodiscard]] bool valid() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
  return true;
}

/// The process of a walk; ended and waited for when this ends.
class WalkProcess {
 public:
  WalkProcess(const std::string& path, std::uint64_t bytes) {
    const Descriptor program(::memfd_create("sarblock-hdf5-walk", MFD_CLOEXEC));
    const std::string_view image(
        sarblock_hdf5_walk_begin,
        static_cast<std::size_t>(sarblock_hdf5_walk_end - sarblock_hdf5_walk_begin));
    if (!program.valid() || !WriteAll(program.get(), image)) FailStart(path, errno);
    std::array<int, 2> ends{-1, -1};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) FailStart(path, errno);
    hears_ = Descriptor(ends[0]);
    const Descriptor says(ends[1]);
    if (!hears_.valid() || !says.valid() || ::fcntl(hears_.get(), F_SETFL, O_NONBLOCK) != 0) {
      FailStart(path, errno);
    }
    const int code = Start(program.get(), says.get(), path, std::to_string(bytes));
    if (code != 0) FailStart(path, code);
  }
  ~WalkProcess() {
    if (waited_) return;
    ::kill(process_, SIGKILL);
    Wait(0);
  }
  WalkProcess(const WalkProcess&) = delete;
  WalkProcess& operator=(const WalkProcess&) = delete;

  /// Waits a little for words; false once there will be none any more.
  [[nodiscard]] bool Listen() {
    pollfd words{hears_.get(), POLLIN, 0};
    if (::poll(&words, 1, static_cast<int>(kAskEvery.count())) <= 0) {
      // Somebody else may hold the other end: a process forked while it was open.
      const bool ended = Wait(WNOHANG);
      if (ended) Read();
      return !ended;
    }
    if (Read()) return true;
    Wait(0);
    return false;
  }
  [[nodiscard]] const std::string& said() const { return said_; }
  [[nodiscard]] bool EndedBy(int signal) const {
    return waited_ && WIFSIGNALED(status_) && WTERMSIG(status_) == signal;
  }

 private:
  /// False at the end of what is said.
  bool Read() {
    for (;;) {
      std::array<char, 64> words{};
      const ssize_t got = ::read(hears_.get(), words.data(), words.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return got < 0;
      said_.append(words.data(), static_cast<std::size_t>(got));
    }
  }
  /// Whether the process has ended. A process that ignores SIGCHLD hears nothing of how.
  bool Wait(int how) {
    pid_t ended = 0;
    do {
      ended = ::waitpid(process_, &status_, how);
    } while (ended < 0 && errno == EINTR);
    waited_ = ended != 0;
    if (ended < 0) status_ = 0;
    return waited_;
  }
  int Start(int program, int says, const std::string& path, const std::string& bytes) {
    constexpr int kProgram = STDERR_FILENO + 1;
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, says, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, program, kProgram);
    posix_spawn_file_actions_addclosefrom_np(&files, kProgram + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    for (const int signal :
         {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGXCPU, SIGTERM, SIGPIPE}) {
      sigaddset(&usual, signal);
    }
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::string name = "sarblock-hdf5-walk", file = path, length = bytes;
    const std::array<char*, 4> arguments{name.data(), file.data(), length.data(), nullptr};
    const std::string image = "/proc/self/fd/" + std::to_string(kProgram);
    std::string tunables(kTunables);
    std::vector<char*> environment;
    for (char** variable = ::environ; variable != nullptr && *variable != nullptr; ++variable) {
      if (!std::string_view(*variable).starts_with("GLIBC_TUNABLES=")) {
        environment.push_back(*variable);
      }
    }
    environment.push_back(tunables.data());
    environment.push_back(nullptr);
    const int code = ::posix_spawn(
        &process_, image.c_str(), &files, &attributes, arguments.data(), environment.data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return code;
  }

  pid_t process_ = -1;
  Descriptor hears_;
  int status_ = 0;
  bool waited_ = false;
  std::string said_;
};

}  // namespace

void SetHdf5Trial(bool on) { g_apart = on; }

void TryHdf5(const std::string& path, std::uint64_t bytes) {
  if (!g_apart) return;
  const Clock::time_point deadline =
      Clock::now() + kMinDeadline + std::chrono::seconds(bytes / kBytesPerSecond);
  const ProgressSink* const sink = CancellationScope::Current();
  WalkProcess walk(path, bytes);
  bool late = false;
  while (!late && walk.Listen()) {
    if (sink != nullptr && sink->Cancelled()) throw Interrupted("read");
    late = Clock::now() > deadline;
  }
  const std::string begins(kWalkBegins);
  if (walk.said() == begins + kWalkEnds) return;
  if (!walk.said().starts_with(begins)) {
    Fail(path, "cannot be tried before it is read: the program for it did not start (libhdf5)");
  }
  const bool endless = late || walk.EndedBy(SIGXCPU);
  Fail(path,
       std::string("is damaged: libhdf5 ") + (endless ? "does not come to an end" : "fails") +
           " as it walks through it");
}

}  // namespace sarblock

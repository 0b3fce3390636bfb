// SPDX-License-Identifier: Apache-2.0
#include "session.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"
#include "sarblock/tables/output.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "core/memory.h"
#include "terminal.h"
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

namespace sarblock::cli {
namespace {

std::string WordsFor(const std::filesystem::filesystem_error& error) {
  return error.path1().string() + ": cannot be used: " + error.code().message();
}

}  // namespace

void OpenStandardStreams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (::fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is taken, which is this one. Reading alone makes writing fail.
    static_cast<void>(::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY));
  }
}

void PrintError(std::string_view line) noexcept {
  static_cast<void>(std::fwrite(line.data(), 1, line.size(), stderr));
  static_cast<void>(std::fputc('\n', stderr));
}

Ending EndingOf(const std::exception& error) {
  if (const auto* other = dynamic_cast<const OtherRankFailed*>(&error)) return other->ending();
  if (dynamic_cast<const InputError*>(&error) != nullptr) return {kBadInput, error.what()};
  if (dynamic_cast<const UndeterminedError*>(&error) != nullptr) {
    return {kUndetermined, error.what()};
  }
  if (dynamic_cast<const Interrupted*>(&error) != nullptr) return {kNotAccepted, error.what()};
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    return {kBadInput, WordsFor(*file)};
  }
  if (dynamic_cast<const std::system_error*>(&error) != nullptr) {
    return {kBadInput, std::string("the system refused: ") + error.what()};
  }
  if (dynamic_cast<const ScratchError*>(&error) != nullptr) return {kBadInput, error.what()};
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    return {kBadInput, "there is not enough memory for this block"};
  }
  return {kInternalError, std::string("internal error: ") + error.what()};
}

void RunTogether(Ranks* ranks, const std::function<void()>& work) {
  if (ranks == nullptr) {
    work();
    return;
  }
  std::exception_ptr own;
  Ending ending;
  try {
    const RanksScope scope(ranks);
    work();
  } catch (const std::exception& error) {
    own = std::current_exception();
    ending = EndingOf(error);
  }
  const std::optional<Ending> known = ranks->Agree(own ? &ending : nullptr);
  if (own) std::rethrow_exception(own);
  if (known) throw OtherRankFailed(*known);
}

int FinishOutput(int exit_code) {
  if (exit_code > kNotAccepted) return exit_code;  // the error is printed already
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0 && std::cout.good()) return exit_code;
  const std::string reason = errno != 0 ? std::strerror(errno) : "a write failed";
  PrintError("sarblock: standard output: cannot be written: " + reason);
  return kBadInput;
}

namespace {

std::atomic<bool> g_interrupted{false};

void OnInterrupt(int) {
  if (!g_interrupted.exchange(true)) return;
  RemoveOpenTemporaryFiles();
  _exit(kNotAccepted);
}

/// A bar on standard error, shown only on a terminal and only for work of over two seconds.
class TerminalProgress final : public ProgressSink {
 public:
  TerminalProgress(bool visible, std::string* stage)
      : visible_(visible), stage_of_session_(stage) {}
  ~TerminalProgress() override { Clear(); }

  void Update(std::string_view stage,
              std::size_t done,
              std::size_t total,
              std::string_view detail) override {
    if (*stage_of_session_ != stage) *stage_of_session_ = stage;
    if (!visible_) return;
    using Seconds = std::chrono::duration<double>;
    const auto now = std::chrono::steady_clock::now();
    const auto left_s = remaining_.Update(stage, done, total, Seconds(now - begin_).count());
    constexpr double kQuiet_s = 2.0, kEvery_s = 0.1;
    if (Seconds(now - begin_).count() < kQuiet_s) return;
    if (Seconds(now - last_).count() < kEvery_s && done != total) return;
    last_ = now;
    std::string line = fmt::format("{:<14}", stage);
    if (total > 0) {
      const double part = static_cast<double>(done) / static_cast<double>(total);
      constexpr int kWidth = 30;
      const int filled = static_cast<int>(part * kWidth);
      line +=
          fmt::format("[{:=<{}}{:{}}] {:3.0f} %", "", filled, "", kWidth - filled, 100.0 * part);
      if (left_s) line += fmt::format("  {:.0f} s left", *left_s);
    }
    if (!detail.empty()) line += fmt::format("  {}", detail);
    if (line.size() >= kColumns) line.resize(kColumns - 1);  // one line, or it would scroll
    line.insert(0, "\r\033[K");
    static_cast<void>(std::fputs(line.c_str(), stderr));
    std::fflush(stderr);
    shown_ = true;
  }

  [[nodiscard]] bool Cancelled() const override { return g_interrupted.load(); }

  void Clear() {
    if (!shown_) return;
    static_cast<void>(std::fputs("\r\033[K", stderr));
    std::fflush(stderr);
    shown_ = false;
  }

 private:
  bool visible_;
  std::string* stage_of_session_;  ///< for words at an interruption
  bool shown_ = false;
  RemainingTime remaining_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = begin_;
};

}  // namespace

int Session::Threads() const { return threads > 0 ? threads : cores; }

void Session::Warn(const std::string& line) const {
  if (quiet || !first()) return;
  if (clear_bar) clear_bar();
  PrintError(line);
}

void Session::Print(const std::string& text) const {
  if (quiet || !first()) return;
  if (clear_bar) clear_bar();
  fmt::print("{}", FitColumns(text));
}

void AddGlobalOptions(CLI::App* app, Session* session) {
  app->add_option("--threads", session->threads, "Threads to use (0: all cores)")
      ->check(CLI::Range(0, 1024));
  app->add_flag("--quiet,-q", session->quiet, "No messages, no summary, no progress bar");
  app->add_flag("--json", session->json, "Summary as JSON on standard output, nothing else there");
  app->add_option("--set", session->set, "Override one key, KEY=VALUE; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
  app->add_flag("--dump-config", session->dump_config, "Print the effective configuration and end");
}

void AddForce(CLI::App* command, ForeignFiles* foreign, const std::string& help) {
  command->add_flag_callback(
      "--force", [foreign] { *foreign = ForeignFiles::kReplace; }, help);
}

void AddMemory(CLI::App* command, double* memory_mib) {
  command
      ->add_option("--memory",
                   *memory_mib,
                   "Memory that may be needed [MiB]; what is predicted to need more is refused "
                   "(default: the free memory of this computer)")
      ->type_name("MIB")
      ->check(CLI::PositiveNumber);
}

CLI::Option* AddPart(CLI::App* command, std::string* part, const std::string& help) {
  return command->add_option("--part", *part, help)
      ->check(CLI::Validator(
          [](const std::string& text) {
            return TaskPartOf(text)
                       ? std::string()
                       : fmt::format("I/N with 0 <= I <= N and N up to {} is allowed", kMaxParts);
          },
          ""))
      ->type_name("I/N");
}

void AddScratch(CLI::App* command, std::string* folder) {
  command->add_option("--scratch",
                      *folder,
                      "Folder for files that hold large arrays by look and by point instead of "
                      "memory; removed at the end (default: memory)");
}

void MakeProgress(Session* session) {
  auto bar = std::make_unique<TerminalProgress>(
      !session->quiet && session->first() && isatty(STDERR_FILENO) == 1, &session->stage);
  session->clear_bar = [bar = bar.get()] { bar->Clear(); };
  session->progress = std::move(bar);
}

void InstallInterruptHandler() {
  struct sigaction action {};
  action.sa_handler = OnInterrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A file beyond `ulimit -f` is a write that fails (EFBIG), and told as such.
  action.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &action, nullptr);
}

}  // namespace sarblock::cli

// operator new and delete of the program: large arrays made within a ScratchScope are mapped
// files (core/memory.h), everything else is malloc's as in the standard library. The library and
// the Python package, which live in processes of others, leave these to the process.

void* operator new(std::size_t bytes) {
  if (bytes >= sarblock::kScratchMinBytes) {
    if (void* array = sarblock::AllocateScratch(bytes)) return array;
  }
  for (;;) {
    if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* memory) noexcept {
  if (!sarblock::FreeScratch(memory)) std::free(memory);
}

void operator delete(void* memory, std::size_t bytes) noexcept {
  if (bytes >= sarblock::kScratchMinBytes && sarblock::FreeScratch(memory)) return;
  std::free(memory);
}

// The other forms, which the standard library makes of these and AddressSanitizer does not.
void* operator new(std::size_t bytes, const std::nothrow_t& /*unused*/) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void* operator new[](std::size_t bytes) { return operator new(bytes); }

void* operator new[](std::size_t bytes, const std::nothrow_t& tag) noexcept {
  return operator new(bytes, tag);
}

void operator delete(void* memory, const std::nothrow_t& /*unused*/) noexcept {
  operator delete(memory);
}

void operator delete[](void* memory) noexcept { operator delete(memory); }

void operator delete[](void* memory, std::size_t bytes) noexcept { operator delete(memory, bytes); }

void operator delete[](void* memory, const std::nothrow_t& /*unused*/) noexcept {
  operator delete(memory);
}

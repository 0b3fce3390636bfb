// SPDX-License-Identifier: Apache-2.0
#include "environment.h"

#include "sarblock/core/error.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "core/memory.h"
#include "exit_code.h"
#include <fcntl.h>
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

void Tell(std::string_view line) noexcept {
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
  if (exit_code > kNotAccepted) return exit_code;  // told already what is wrong
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0 && std::cout.good()) return exit_code;
  const std::string reason = errno != 0 ? std::strerror(errno) : "a write failed";
  Tell("sarblock: standard output: cannot be written: " + reason);
  return kBadInput;
}

}  // namespace sarblock::cli

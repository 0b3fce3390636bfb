// SPDX-License-Identifier: Apache-2.0
#include "environment.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <system_error>

#include "core/scratch.h"
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

int ExplainError(const std::exception& error) {
  std::string words;
  int code = kBadInput;
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    words = WordsFor(*file);
  } else if (dynamic_cast<const std::system_error*>(&error) != nullptr) {
    words = std::string("the system refused: ") + error.what();
  } else if (dynamic_cast<const ScratchError*>(&error) != nullptr) {
    words = error.what();
  } else if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    words = "there is not enough memory for this block";
  } else {
    words = std::string("internal error: ") + error.what();
    code = kInternalError;
  }
  Tell("sarblock: " + words);
  return code;
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

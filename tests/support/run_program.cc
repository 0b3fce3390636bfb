// SPDX-License-Identifier: Apache-2.0
#include "support/run_program.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sarblock::test {
namespace {

std::string ContentOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

Program::Program(std::filesystem::path folder, const std::vector<std::string>& arguments)
    : folder_(std::move(folder)) {
  std::vector<std::string> words{SARBLOCK_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string out = folder_ / "stdout";
  const std::string err = folder_ / "stderr";
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int kNew = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kNew, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), kNew, 0600);
  const int error = posix_spawn(&pid_, SARBLOCK_PROGRAM, &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::system_error(error, std::generic_category(), SARBLOCK_PROGRAM);
}

Program::~Program() {
  if (!ended_) waitpid(pid_, &status_, 0);
}

void Program::Signal(int signal) const {
  if (!ended_) kill(pid_, signal);
}

bool Program::Running() {
  if (!ended_ && waitpid(pid_, &status_, WNOHANG) == pid_) ended_ = true;
  return !ended_;
}

ProgramRun Program::Wait() {
  while (!ended_) {
    if (waitpid(pid_, &status_, 0) == pid_) {
      ended_ = true;
    } else if (errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "waitpid");
    }
  }
  return {WIFEXITED(status_) ? WEXITSTATUS(status_) : -1,
          ContentOf(folder_ / "stdout"),
          ContentOf(folder_ / "stderr")};
}

ProgramRun RunProgram(const std::vector<std::string>& arguments) {
  std::string folder = std::filesystem::temp_directory_path() / "sarblock-run-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), folder);
  }
  const ProgramRun run = Program(folder, arguments).Wait();
  std::filesystem::remove_all(folder);
  return run;
}

}  // namespace sarblock::test

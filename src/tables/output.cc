// SPDX-License-Identifier: Apache-2.0
#include "sarblock/tables/output.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "checksum.h"
#include "hdf5_file.h"
#include "json.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace sarblock {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

// Names of open temporary files at fixed addresses, so that a signal handler can walk them.
struct Slot {
  std::atomic<int> state{0};  // 0 free, 1 being filled or emptied, 2 holds a name
  char name[PATH_MAX];
};
std::array<Slot, 32> g_slots;

// A file beyond the last slot is still removed by its destructor, only not by a signal.
int Register(const std::string& name) {
  if (name.size() >= PATH_MAX) return -1;
  for (std::size_t i = 0; i < g_slots.size(); ++i) {
    int free = 0;
    if (!g_slots[i].state.compare_exchange_strong(free, 1)) continue;
    std::memcpy(g_slots[i].name, name.c_str(), name.size() + 1);
    g_slots[i].state.store(2);
    return static_cast<int>(i);
  }
  return -1;
}

void Unregister(int slot) {
  if (slot >= 0) g_slots[static_cast<std::size_t>(slot)].state.store(0);
}

constexpr std::string_view kTemporary = ".tmp-";  // and random digits

/// `.NAME.tmp-RANDOM`, which no other run and no other call makes.
std::string TemporaryNameOf(const std::string& name) {
  std::random_device device;
  return fmt::format(".{}{}{:08x}{:08x}", name, kTemporary, device(), device());
}

/// What a link points to, which is written in its place.
std::filesystem::path BehindLink(std::filesystem::path target) {
  constexpr int kMaxLinks = 40;
  std::error_code error;
  for (int i = 0; i < kMaxLinks && std::filesystem::is_symlink(target, error); ++i) {
    const std::filesystem::path behind = std::filesystem::read_symlink(target, error);
    if (error) break;
    target = behind.is_absolute() ? behind : target.parent_path() / behind;
  }
  return target;
}

/// Gives a file the permissions of the one that it will replace, if there is one.
void KeepPermissions(const std::filesystem::path& file, const std::filesystem::path& replaced) {
  std::error_code ignored;
  const auto status = std::filesystem::status(replaced, ignored);
  if (std::filesystem::is_regular_file(status)) {
    std::filesystem::permissions(file, status.permissions(), ignored);
  }
}

bool IsSpecial(const std::filesystem::path& target) {
  std::error_code error;
  const auto status = std::filesystem::status(target, error);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

TemporaryName::TemporaryName(const std::filesystem::path& target)
    : target_(BehindLink(target)),
      name_((target_.parent_path() / TemporaryNameOf(target_.filename().string())).string()) {
  slot_ = Register(name_);
}

TemporaryName::~TemporaryName() {
  if (name_.empty()) return;
  ::unlink(name_.c_str());
  Unregister(slot_);
}

void TemporaryName::Commit() {
  KeepPermissions(name_, target_);
  if (std::rename(name_.c_str(), target_.c_str()) != 0) {
    throw InputError(FilePlace{target_.string(), 0, ""},
                     std::string("cannot be replaced: ") + std::strerror(errno));
  }
  Unregister(slot_);
  name_.clear();
}

struct AtomicFile::State {
  std::filesystem::path target;
  std::optional<TemporaryName> temporary;  // nothing: written directly
  int descriptor = -1;
  int lock = -1;  // as long as it is held, nobody takes the temporary file for one left behind
  gzFile gzip = nullptr;
  std::string buffer;

  void Close() {
    if (gzip != nullptr) gzclose_w(gzip);
    if (gzip == nullptr && descriptor >= 0) ::close(descriptor);
    gzip = nullptr;
    descriptor = -1;
  }
  ~State() {
    Close();
    if (lock >= 0) ::close(lock);
  }
};

AtomicFile::AtomicFile(const std::filesystem::path& target, Compression compression)
    : state_(std::make_unique<State>()) {
  state_->target = target;
  state_->buffer.reserve(kBufferBytes);
  std::string name = target.string();
  int flags = O_WRONLY | O_CLOEXEC;
  if (!IsSpecial(target)) {
    name = state_->temporary.emplace(target).name();
    flags |= O_CREAT | O_EXCL;
  }
  state_->descriptor = ::open(name.c_str(), flags, 0666);
  if (state_->descriptor < 0) Fail("cannot be written");
  if (state_->temporary && ::flock(state_->descriptor, LOCK_EX | LOCK_NB) == 0) {
    state_->lock = ::fcntl(state_->descriptor, F_DUPFD_CLOEXEC, 0);
  }
  if (compression == Compression::kGzip) {
    state_->gzip = gzdopen(state_->descriptor, "wb");
    if (state_->gzip == nullptr) Fail("cannot be written");
    gzbuffer(state_->gzip, 1u << 17);
  }
}

AtomicFile::~AtomicFile() = default;
AtomicFile::AtomicFile(AtomicFile&&) noexcept = default;

void AtomicFile::Write(std::string_view text) {
  if (state_->buffer.size() + text.size() > kBufferBytes) Flush();
  if (text.size() > kBufferBytes) {
    WriteThrough(text);
  } else {
    state_->buffer += text;
  }
}

void AtomicFile::Flush() {
  WriteThrough(state_->buffer);
  state_->buffer.clear();
}

void AtomicFile::WriteThrough(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = std::min<std::size_t>(text.size(), std::size_t{1} << 30);
    errno = 0;
    const auto done = state_->gzip != nullptr
                          ? gzwrite(state_->gzip, text.data(), static_cast<unsigned>(size))
                          : ::write(state_->descriptor, text.data(), size);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) Fail("writing failed");
    text.remove_prefix(static_cast<std::size_t>(done));
  }
}

void AtomicFile::Commit() {
  Flush();
  errno = 0;
  const bool gzip = state_->gzip != nullptr;
  const int code = gzip ? gzclose_w(state_->gzip) : ::close(state_->descriptor);
  state_->gzip = nullptr;
  state_->descriptor = -1;
  if (code != 0) Fail("writing failed");
  if (state_->temporary) state_->temporary->Commit();
}

void AtomicFile::Fail(const std::string& doing) {
  const std::string reason = errno != 0 ? std::strerror(errno) : "compression failed";
  throw InputError(FilePlace{state_->target.string(), 0, ""}, doing + ": " + reason);
}

void RemoveOpenTemporaryFiles() noexcept {
  for (Slot& slot : g_slots) {
    if (slot.state.load() == 2) ::unlink(slot.name);
  }
}

std::filesystem::path FileOf(const std::filesystem::path& owner, const std::string& name) {
  if (!std::filesystem::is_regular_file(owner)) return owner / name;
  return owner.parent_path() / (owner.stem().string() + "." + name);
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     "cannot be made a folder: " +
                         (error ? error.message() : std::string("a file has this name")));
  }
}

bool NamesContainer(const std::filesystem::path& path) { return path.extension() == ".h5"; }

std::string NameAt(const std::filesystem::path& path) {
  const auto whole = std::filesystem::absolute(path).lexically_normal();
  const auto last = (whole.has_filename() ? whole : whole.parent_path()).filename();
  return (NamesContainer(last) ? last.stem() : last).string();
}

bool IsContainer(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return false;
  constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
  std::array<char, kSignature.size()> begin{};
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == kSignature;
}

void TryHdf5Apart(bool apart) { SetHdf5Trial(apart); }

std::optional<FolderContent> ContentOf(const std::filesystem::path& container) {
  const QuietHdf5 quiet;
  const Hdf5Id file(H5Fopen(container.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) return std::nullopt;
  const bool block = H5Aexists(file.get(), AttributeOf("block.toml").c_str()) > 0;
  const bool result = H5Aexists(file.get(), AttributeOf("summary.json").c_str()) > 0;
  if (block == result) return std::nullopt;
  return block ? FolderContent::kBlock : FolderContent::kResult;
}

namespace {

namespace fs = std::filesystem;

const char* MarkerOf(FolderContent content) {
  return content == FolderContent::kResult ? "summary.json" : "block.toml";
}

[[noreturn]] void Fail(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Whether a file is JSON whose `format` begins like this.
bool HasFormat(const fs::path& file, std::string_view begin) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return false;
  const std::string text = TextOf(file);
  try {
    const JsonFile json(text, file.string());
    const auto format = json.Root().Find("format");
    return format && format->Text().starts_with(begin);
  } catch (const InputError&) {
    return false;
  }
}

bool IsBlockOfOurs(const fs::path& folder) {
  return TextOf(folder / "block.toml").starts_with(kWrittenBySarblock);
}

bool HasMark(const fs::path& file, FileMarks marks) {
  constexpr std::streamsize kRead = 65536;
  std::string head(kRead, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), kRead);
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return std::any_of(marks.begin(), marks.end(), [&head](std::string_view mark) {
    return head.find(mark) != std::string::npos;
  });
}

/// Names in a folder that do not begin with a dot, in order.
std::vector<std::string> VisibleNames(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with('.')) names.push_back(name);
  }
  if (error) Fail(folder, "cannot be read: " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

bool IsStudyOfOurs(const fs::path& folder) {
  if (!fs::is_directory(folder)) return false;
  const std::vector<std::string> names = VisibleNames(folder);
  return std::any_of(names.begin(), names.end(), [&folder](const std::string& name) {
    return name.ends_with(".study.toml") && HasMark(folder / name, {"# written by sarblock"});
  });
}

/// Whether there is a folder; throws InputError where its name is taken by a file.
bool IsThere(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return false;
  if (status.type() == fs::file_type::none) Fail(folder, "cannot be read: " + error.message());
  if (!fs::is_directory(status)) Fail(folder, "is a file, the name of a folder is needed");
  return true;
}

bool CanReplace(const fs::path& file, FileMarks marks) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || fs::file_size(file, ignored) == 0) return true;
  return HasMark(file, marks);
}

std::string FirstOf(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

/// Whether a name is one of TemporaryNameOf().
bool IsTemporary(std::string_view name) {
  const std::size_t at = name.rfind(kTemporary);
  if (!name.starts_with('.') || at == std::string_view::npos || at == 0) return false;
  const std::string_view digits = name.substr(at + kTemporary.size());
  return !digits.empty() && digits.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Whether nobody writes a temporary file any more (AtomicFile).
bool IsAbandoned(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool abandoned = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  ::close(descriptor);
  return abandoned;
}

/// What killed processes left half written in a folder whose lock is held.
std::vector<fs::path> AbandonedIn(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    if (!IsTemporary(entry->path().filename().string())) continue;
    if (entry->is_directory(ignored) || IsAbandoned(entry->path())) {
      abandoned.push_back(entry->path());
    }
  }
  return abandoned;
}

/// Whether a run was killed while it moved files into this folder, or still does.
bool IsUnfinished(FolderContent content, const fs::path& folder) {
  const std::string begin = std::string(".") + MarkerOf(content) + std::string(kTemporary);
  std::error_code ignored;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    if (entry->path().filename().string().starts_with(begin)) return true;
  }
  return false;
}

void RequireContainerFor(FolderContent content,
                         const fs::path& file,
                         const fs::file_status& status,
                         ForeignFiles foreign) {
  if (fs::is_directory(status)) Fail(file, "is a folder, the name of a file is needed");
  if (!fs::is_regular_file(status)) Fail(file, "is neither a folder nor a file");
  if (foreign == ForeignFiles::kReplace || ContentOf(file) == content) return;
  Fail(file,
       std::string("is no ") + NameOf(content) +
           " that sarblock wrote; the name of a new file is allowed, or --force to replace it");
}

}  // namespace

bool HoldsOurs(FolderContent content, const fs::path& folder) {
  switch (content) {
    case FolderContent::kResult:
      return HasFormat(folder / "summary.json", "sarblock-result ");
    case FolderContent::kBlock:
      return IsBlockOfOurs(folder);
    case FolderContent::kStudy:
      return IsStudyOfOurs(folder);
  }
  return false;
}

void RequireFolderFor(FolderContent content, const fs::path& folder, ForeignFiles foreign) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (NamesContainer(folder) && fs::exists(status)) {
    RequireContainerFor(content, folder, status, foreign);
    return;
  }
  if (!IsThere(folder)) return;
  const std::vector<std::string> names = VisibleNames(folder);
  if (foreign == ForeignFiles::kReplace || names.empty()) return;
  if (content == FolderContent::kResult &&
      std::find(names.begin(), names.end(), "block.toml") != names.end()) {
    Fail(folder,
         "is a block, whose tables a result would overwrite; a new or empty folder is allowed, or "
         "--force");
  }
  if (content == FolderContent::kBlock && HoldsOurs(content, folder)) {
    if (const std::string changed = ChangedSinceWritten(folder); !changed.empty()) {
      Fail(folder,
           "is a block that was changed since sarblock wrote it (" + changed +
               "); a new or empty folder is allowed, or --force to write over it");
    }
  }
  if (HoldsOurs(content, folder) || IsUnfinished(content, folder)) return;
  Fail(folder,
       std::string("is not empty and no ") + NameOf(content) + " that sarblock wrote (" +
           FirstOf(names) +
           "); a new or empty folder is allowed, or --force to write among these files");
}

void RequireFileFor(const fs::path& file, FileMarks marks, ForeignFiles foreign) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) Fail(file, "is a folder, the name of a file is needed");
  if (foreign == ForeignFiles::kReplace || CanReplace(file, marks)) return;
  Fail(file,
       "is there and sarblock did not write it; another name is allowed, or --force to replace it");
}

void RequireFilesFor(const fs::path& folder, FileMarks marks, ForeignFiles foreign) {
  if (!IsThere(folder) || foreign == ForeignFiles::kReplace) return;
  std::vector<std::string> others;
  for (const std::string& name : VisibleNames(folder)) {
    if (!CanReplace(folder / name, marks)) others.push_back(name);
  }
  if (others.empty()) return;
  Fail(folder,
       "holds files that sarblock did not write (" + FirstOf(others) +
           "); a new or empty folder is allowed, or --force to write among these files");
}

namespace {

/// The same text for the same output, however it is called.
fs::path KeyOf(const fs::path& output) {
  std::error_code error;
  const fs::path named = output.has_filename() ? output : output.parent_path();
  const fs::path key = fs::weakly_canonical(fs::absolute(named, error), error);
  return error ? named : key;
}

/// Who writes, for those that want to.
std::string Writer() {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  return fmt::format("process {} on {} since {:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z\n",
                     ::getpid(),
                     host.data(),
                     utc.tm_year + 1900,
                     utc.tm_mon + 1,
                     utc.tm_mday,
                     utc.tm_hour,
                     utc.tm_min,
                     utc.tm_sec);
}

}  // namespace

struct OutputLock::Held {
  fs::path output, key, file;
  std::vector<fs::path> made;  // folders, inner ones last
  int descriptor = -1;         // -1: there are no locks

  explicit Held(fs::path of) : output(std::move(of)), key(KeyOf(output)) {
    const bool one_file = NamesContainer(key);
    const fs::path folder = one_file ? key.parent_path() : key;
    file = folder / ("." + (one_file ? key.filename().string() + "." : "") + "sarblock-lock");
    while (!TryOnce(folder)) {
    }
    if (!one_file || descriptor < 0) return;
    const std::string begin = "." + key.filename().string() + std::string(kTemporary);
    for (const fs::path& left : AbandonedIn(folder)) {
      if (left.filename().string().starts_with(begin)) ::unlink(left.c_str());
    }
  }
  ~Held() {
    if (descriptor >= 0) {
      ::unlink(file.c_str());
      ::flock(descriptor, LOCK_UN);  // a process forked meanwhile has it too
      ::close(descriptor);
    }
    for (auto folder = made.rbegin(); folder != made.rend(); ++folder) ::rmdir(folder->c_str());
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  /// False where whoever held the lock took its file away meanwhile.
  bool TryOnce(const fs::path& folder) {
    std::vector<fs::path> missing;
    std::error_code ignored;
    for (fs::path at = folder; at.has_relative_path() && !fs::exists(at, ignored);
         at = at.parent_path()) {
      missing.insert(missing.begin(), at);
    }
    MakeFolder(NamesContainer(key) ? output.parent_path().empty() ? folder : output.parent_path()
                                   : output);
    made.insert(made.end(), missing.begin(), missing.end());
    const int opened = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (opened < 0 && errno == ENOENT) return false;
    if (opened < 0) Fail(output, std::string("cannot be written: ") + std::strerror(errno));
    if (::flock(opened, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) FailHeld(opened);
      ::unlink(file.c_str());
      ::close(opened);
      return true;
    }
    struct stat ours {
    }, there{};
    if (::fstat(opened, &ours) != 0 || ::stat(file.c_str(), &there) != 0 ||
        ours.st_ino != there.st_ino || ours.st_dev != there.st_dev) {
      ::close(opened);
      return false;
    }
    descriptor = opened;
    const std::string writer = Writer();
    static_cast<void>(::ftruncate(descriptor, 0) == 0 &&
                      ::write(descriptor, writer.data(), writer.size()) > 0);
    return true;
  }
  [[noreturn]] void FailHeld(int opened) {
    std::array<char, 512> text{};
    const ssize_t got = ::read(opened, text.data(), text.size() - 1);
    ::close(opened);
    std::string who(text.data(), static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    while (who.ends_with('\n')) who.pop_back();
    made.clear();
    Fail(output,
         "is being written by another run" + (who.empty() ? who : " (" + who + ")") +
             "; another name is allowed, or this one once that run has ended");
  }
};

OutputLock::OutputLock(fs::path output) {
  static thread_local std::vector<std::weak_ptr<Held>> locks;
  std::erase_if(locks, [](const std::weak_ptr<Held>& lock) { return lock.expired(); });
  const fs::path key = KeyOf(output);
  for (const std::weak_ptr<Held>& lock : locks) {
    held_ = lock.lock();
    if (held_ != nullptr && held_->key == key) return;
  }
  held_ = std::make_shared<Held>(std::move(output));
  locks.push_back(held_);
}

bool OutputLock::exclusive() const { return held_->descriptor >= 0; }

StagedFolder::StagedFolder(FolderContent content, fs::path folder)
    : content_(content),
      folder_(std::move(folder)),
      lock_(folder_),
      stage_(folder_ / TemporaryNameOf(MarkerOf(content_))) {
  std::error_code ignored;
  const std::vector<fs::path> abandoned =
      lock_.exclusive() ? AbandonedIn(folder_) : std::vector<fs::path>();
  MakeFolder(stage_);
  for (const fs::path& file : abandoned) fs::remove_all(file, ignored);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  fs::remove_all(stage_, ignored);
}

void StagedFolder::Write(const std::function<void(const fs::path&)>& write) {
  try {
    write(stage_);
  } catch (const InputError& error) {
    std::string text = error.what();
    const std::string from = stage_.string(), to = folder_.string();
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw;
    throw InputError(FilePlace{}, text.replace(at, from.size(), to));
  }
}

void StagedFolder::Publish(const std::vector<std::string>& known) {
  const std::string marker = MarkerOf(content_);
  std::vector<std::string> written;
  for (const fs::directory_entry& entry : fs::directory_iterator(stage_)) {
    const std::string name = entry.path().filename().string();
    if (name != marker) written.push_back(name);
  }
  std::sort(written.begin(), written.end());
  written.push_back(marker);  // last
  for (const std::string& name : written) KeepPermissions(stage_ / name, folder_ / name);
  fs::remove(folder_ / marker);
  for (const std::string& name : known) {
    if (std::find(written.begin(), written.end(), name) != written.end()) continue;
    if (name.ends_with(".html") && !HasMark(folder_ / name, {kReportMark})) continue;
    fs::remove(folder_ / name);
  }
  for (const std::string& name : written) fs::rename(stage_ / name, folder_ / name);
}

namespace {

namespace fs = std::filesystem;

[[noreturn]] void RefuseFolder(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

}  // namespace

void PartFolders::Add(const fs::path& folder, const TaskPart& part) {
  if (folders_.empty()) held_by_.resize(part.count);
  if (part.count != held_by_.size()) {
    RefuseFolder(folder,
                 fmt::format("holds {}, but {} one of {} parts",
                             NameOf(part),
                             folders_.front().string(),
                             held_by_.size()));
  }
  if (!held_by_[part.index].empty()) {
    RefuseFolder(folder, "holds " + NameOf(part) + ", as does " + held_by_[part.index]);
  }
  folders_.push_back(folder);
  held_by_[part.index] = folder.string();
}

void PartFolders::RequireAll() const {
  std::vector<std::string> missing;
  for (std::size_t number = 1; number <= held_by_.size(); ++number) {
    const TaskPart part{number % held_by_.size(), held_by_.size()};
    if (held_by_[part.index].empty()) missing.push_back(NameOf(part));
  }
  if (missing.empty()) return;
  const std::size_t count = missing.size(), named = std::min<std::size_t>(5, count);
  missing.resize(named);
  std::string names = fmt::format("{}", fmt::join(missing, ", "));
  if (count > named) names += fmt::format(" and {} more", count - named);
  RefuseFolder(folders_.front(), "is one of several parts; missing to join: " + names);
}

void RequireNoneOf(const std::vector<std::string>& folders, const fs::path& output) {
  for (const std::string& folder : folders) {
    std::error_code ignored;
    if (fs::equivalent(folder, output, ignored)) {
      RefuseFolder(output, "is one of the parts to join; another folder is needed");
    }
  }
}

}  // namespace sarblock

// SPDX-License-Identifier: Apache-2.0
#include "hdf5_file.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
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

// ---- the walk through a file before it is read

namespace {

std::atomic<bool> g_apart{true};

using Clock = std::chrono::steady_clock;

/// Limits of wall-clock time, which are wide because a disk may be slow, and so may a machine with
/// other work. The walk itself bounds what it computes.
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

/// Throws InputError where the walk does not come to its end or cannot be started. `bytes` is the
/// file's length, which bounds the time and the memory of the walk.
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

}  // namespace

void SetHdf5Trial(bool on) { g_apart = on; }

// ---- what is read

std::mutex& Hdf5Mutex() {
  static std::mutex mutex;
  return mutex;
}

std::string AttributeOf(std::string_view file) {
  std::string name(file);
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

Hdf5Id StringType(std::size_t bytes) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), bytes);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  if (bytes != H5T_VARIABLE) H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  return type;
}

Hdf5Id SelectRows(hid_t dataset, std::uint64_t first, std::uint64_t count) {
  Hdf5Id space(H5Dget_space(dataset), H5Sclose);
  const hsize_t start = first, size = count;
  if (!space.valid() ||
      H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &start, nullptr, &size, nullptr) < 0) {
    return {};
  }
  return space;
}

namespace {

constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 26;
constexpr std::uint64_t kMaxInflation = 1032;  // of deflate, bytes out of one byte
constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();

std::uint64_t BoundedProduct(std::uint64_t a, std::uint64_t b) {
  return b != 0 && a > kMax / b ? kMax : a * b;
}

/// Values of a chunk, and the chunks that all values fill.
struct Chunks {
  std::uint64_t values = 1, needed = 1;
};
Chunks ChunksOf(const OpenedHdf5& opened,
                const std::string& path,
                hid_t made,
                const StoredDataset& stored) {
  std::vector<hsize_t> chunk(stored.size.size());
  const int rank = static_cast<int>(chunk.size());
  const bool known = H5Pget_chunk(made, rank, chunk.data()) == rank;
  Chunks chunks;
  for (std::size_t i = 0; known && i < chunk.size(); ++i) {
    chunks.values = BoundedProduct(chunks.values, chunk[i]);
    if (chunk[i] > 0) {
      chunks.needed = BoundedProduct(chunks.needed, (stored.size[i] - 1) / chunk[i] + 1);
    }
  }
  if (!known || chunks.values == 0 || chunks.values > kMaxChunkBytes / stored.value_bytes) {
    opened.Fail(path,
                "has chunks of " + std::to_string(chunks.values) + " values, at most " +
                    std::to_string(kMaxChunkBytes) + " bytes are allowed");
  }
  return chunks;
}

/// Sets whole and none.
void LookForValues(const OpenedHdf5& opened, const std::string& path, StoredDataset* of) {
  StoredDataset& stored = *of;
  if (stored.count == 0) return;
  const Hdf5Id made(H5Dget_create_plist(stored.dataset.get()), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(made.get());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(made.get()) > 0) {
    opened.Fail(path, "has its values in another file, they are needed in this one");
  }
  const bool filtered = H5Pget_nfilters(made.get()) > 0;
  bool whole = true;
  if (layout == H5D_CHUNKED) {
    const Chunks chunks = ChunksOf(opened, path, made.get(), stored);
    hsize_t there = 0;
    const Hdf5Id all(H5Dget_space(stored.dataset.get()), H5Sclose);  // H5S_ALL is refused
    const bool known = H5Dget_num_chunks(stored.dataset.get(), all.get(), &there) >= 0;
    whole = known && there >= chunks.needed;
    stored.none = known && there == 0;
    if (!filtered && stored.size.size() == 1) stored.chunk_values = chunks.values;
  } else if (layout == H5D_CONTIGUOUS) {
    const hsize_t bytes = H5Dget_storage_size(stored.dataset.get());
    whole = bytes / stored.value_bytes >= stored.count;
    stored.none = bytes == 0;
  }
  const std::uint64_t most =
      BoundedProduct(opened.bytes, filtered ? kMaxInflation : 1) / stored.value_bytes;
  stored.whole = whole && stored.count <= most;
}

}  // namespace

void OpenedHdf5::Fail(const std::string& object, const std::string& problem) const {
  throw InputError(FilePlace{path, 0, object}, problem);
}

OpenedHdf5 OpenHdf5(const std::filesystem::path& path) {
  OpenedHdf5 opened{path.string(), std::filesystem::file_size(path), {}, {}};
  TryHdf5(opened.path, opened.bytes);
  opened.file = Hdf5Id(H5Fopen(opened.path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!opened.file.valid()) {
    opened.Fail("", "cannot be opened as an HDF5 file: damaged, cut off, or being written");
  }
  return opened;
}

bool HasMember(const OpenedHdf5& opened,
               hid_t group,
               const std::string& name,
               const std::string& path) {
  if (H5Lexists(group, name.c_str(), H5P_DEFAULT) <= 0) return false;
  H5L_info_t info;
  if (H5Lget_info(group, name.c_str(), &info, H5P_DEFAULT) < 0 || info.type != H5L_TYPE_HARD) {
    opened.Fail(path, "is a link, the data themselves are needed");
  }
  return true;
}

StoredDataset OpenStored(const OpenedHdf5& opened,
                         hid_t group,
                         const std::string& name,
                         const std::string& path,
                         int rank) {
  StoredDataset stored;
  const auto open = [&](std::size_t cached_bytes) {
    const Hdf5Id access = ColumnAccess(cached_bytes);
    stored.dataset = Hdf5Id(H5Dopen2(group, name.c_str(), access.get()), H5Dclose);
    if (!stored.dataset.valid()) opened.Fail(path, "is no dataset that can be read");
  };
  open(0);
  const Hdf5Id creation(H5Dget_create_plist(stored.dataset.get()), H5Pclose);
  // A part of a chunk that is deflated needs all of it; others are read from the file.
  if (H5Pget_nfilters(creation.get()) > 0) open(kSlabRows * sizeof(double));
  const Hdf5Id type(H5Dget_type(stored.dataset.get()), H5Tclose);
  const Hdf5Id space(H5Dget_space(stored.dataset.get()), H5Sclose);
  if (!type.valid() || !space.valid()) opened.Fail(path, "is no dataset that can be read");
  stored.type = H5Tget_class(type.get());
  stored.value_bytes = H5Tget_size(type.get());
  stored.variable_text = H5Tis_variable_str(type.get()) > 0;
  const int dimensions = std::max(0, H5Sget_simple_extent_ndims(space.get()));
  if (dimensions != rank) {
    opened.Fail(path,
                "has " + std::to_string(dimensions) + " dimensions, " +
                    (rank == 1 ? "one" : std::to_string(rank)) + " is needed");
  }
  std::vector<hsize_t> size(static_cast<std::size_t>(rank));
  if (H5Sget_simple_extent_type(space.get()) != H5S_NULL) {
    if (rank > 0) H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
    stored.count = 1;
  }
  for (const hsize_t length : size) {
    stored.size.push_back(length);
    stored.count = BoundedProduct(stored.count, length);
  }
  if (stored.value_bytes == 0) opened.Fail(path, "has values without a size");
  for (const hid_t own : {H5T_NATIVE_DOUBLE, H5T_NATIVE_UINT32}) {
    if (H5Tequal(type.get(), own) > 0) stored.own_type = own;
  }
  LookForValues(opened, path, &stored);
  return stored;
}

StoredRows ReadRows(const StoredDataset& stored,
                    std::uint64_t first,
                    std::uint64_t count,
                    hid_t memory,
                    hid_t type,
                    void* values) {
  const hid_t dataset = stored.dataset.get();
  const std::uint64_t chunk = stored.chunk_values;
  if (stored.none && type == H5T_NATIVE_DOUBLE) return StoredRows::kNone;
  if (count == chunk && first % chunk == 0 && stored.whole && type == stored.own_type) {
    const hsize_t begin = first;
    hsize_t bytes = 0;
    std::uint32_t filters = 0;
    if (H5Dget_chunk_storage_size(dataset, &begin, &bytes) >= 0 &&
        bytes == chunk * stored.value_bytes &&  // another size would not fit
        H5Dread_chunk(dataset, H5P_DEFAULT, &begin, &filters, values) >= 0) {
      return StoredRows::kRead;
    }
  }
  const Hdf5Id from = SelectRows(dataset, first, count);
  const bool read =
      from.valid() && H5Dread(dataset, type, memory, from.get(), H5P_DEFAULT, values) >= 0;
  return read ? StoredRows::kRead : StoredRows::kDamaged;
}

std::optional<std::string> ReadTextAttribute(const OpenedHdf5& opened,
                                             hid_t object,
                                             const std::string& name,
                                             const std::string& place) {
  if (H5Aexists(object, name.c_str()) <= 0) return std::nullopt;
  const Hdf5Id attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Hdf5Id type(H5Aget_type(attribute.get()), H5Tclose);
  const Hdf5Id space(H5Aget_space(attribute.get()), H5Sclose);
  if (!type.valid() || !space.valid() || H5Tget_class(type.get()) != H5T_STRING ||
      H5Sget_simple_extent_npoints(space.get()) != 1) {
    opened.Fail(place, "is no text, an attribute with one string is needed");
  }
  bool read = false;
  std::string text;
  if (H5Tis_variable_str(type.get()) > 0) {
    char* value = nullptr;
    read = H5Aread(attribute.get(), type.get(), &value) >= 0 && value != nullptr;
    if (read) text = value;
    H5free_memory(value);
  } else if (H5Tget_size(type.get()) <= opened.bytes) {
    text.resize(H5Tget_size(type.get()));
    read = H5Aread(attribute.get(), type.get(), text.data()) >= 0;
    text.resize(std::min(text.size(), text.find('\0')));
  }
  if (!read) opened.Fail(place, "cannot be read, the file is damaged");
  return text;
}

namespace {

constexpr std::size_t kLongestText = std::size_t{1} << 16;

void Require(const Hdf5Values& values, const std::string& path) {
  if (!values.Has(path)) values.Fail(path, "is missing");
}

std::string TrimmedText(std::string text) {
  text.resize(std::min(text.size(), text.find('\0')));
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

void RequireWhole(const OpenedHdf5& opened, const std::string& path, const StoredDataset& stored) {
  if (stored.whole) return;
  opened.Fail(path,
              "has " + std::to_string(stored.count) + " values, not all of which are in the file");
}

}  // namespace

Hdf5Values::Hdf5Values(const std::string& file)
    : opened_(std::make_unique<OpenedHdf5>(OpenHdf5(file))) {}
Hdf5Values::~Hdf5Values() = default;

const std::string& Hdf5Values::file() const { return opened_->path; }

void Hdf5Values::Fail(const std::string& path, const std::string& problem) const {
  opened_->Fail(path, problem);
}

bool Hdf5Values::Has(const std::string& path) const {
  // Name by name, for libhdf5 asks of the last one alone whether it is a link.
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    const std::string part = path.substr(0, end);
    if (!HasMember(*opened_, opened_->file.get(), part, part)) return false;
    if (end == std::string::npos) return true;
  }
}

std::string Hdf5Values::Text(const std::string& path) const {
  Require(*this, path);
  const StoredDataset stored = OpenStored(*opened_, opened_->file.get(), path, path, 0);
  if (stored.type != H5T_STRING || stored.count != 1 || stored.value_bytes > kLongestText) {
    Fail(path, "is no text, one string is needed");
  }
  RequireWhole(*opened_, path, stored);
  const Hdf5Id type(H5Dget_type(stored.dataset.get()), H5Tclose);
  bool read = false;
  std::string text;
  if (stored.variable_text) {
    char* value = nullptr;
    read = H5Dread(stored.dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) >= 0 &&
           value != nullptr;
    if (read) text = value;
    H5free_memory(value);
  } else {
    text.resize(stored.value_bytes);
    read =
        H5Dread(stored.dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) >= 0;
  }
  if (!read) Fail(path, "cannot be read, the file is damaged");
  return TrimmedText(std::move(text));
}

double Hdf5Values::Number(const std::string& path) const {
  return Numbers(path, 0, 1).values.front();
}

Hdf5Array Hdf5Values::Numbers(const std::string& path, int rank, std::size_t most) const {
  Require(*this, path);
  const StoredDataset stored = OpenStored(*opened_, opened_->file.get(), path, path, rank);
  if (stored.type != H5T_FLOAT && stored.type != H5T_INTEGER) {
    Fail(path, "holds no numbers, which are needed");
  }
  if (stored.count == 0) Fail(path, "is empty, numbers are needed");
  if (stored.count > most) {
    Fail(path,
         "has " + std::to_string(stored.count) + " values, at most " + std::to_string(most) +
             (most == 1 ? " is" : " are") + " allowed");
  }
  RequireWhole(*opened_, path, stored);
  Hdf5Array array;
  array.size.assign(stored.size.begin(), stored.size.end());
  array.values.resize(stored.count);
  if (H5Dread(stored.dataset.get(),
              H5T_NATIVE_DOUBLE,
              H5S_ALL,
              H5S_ALL,
              H5P_DEFAULT,
              array.values.data()) < 0) {
    Fail(path, "cannot be read, the file is damaged");
  }
  for (const double value : array.values) {
    if (!std::isfinite(value)) Fail(path, "holds " + NumberText(value) + ", numbers are needed");
  }
  return array;
}

std::string Hdf5Values::TextAttribute(const std::string& path, const std::string& name) const {
  Require(*this, path);
  const Hdf5Id object(H5Oopen(opened_->file.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  if (!object.valid()) Fail(path, "is no dataset that can be read");
  const std::string place = path + " (" + name + ")";
  auto text = ReadTextAttribute(*opened_, object.get(), name, place);
  if (!text) Fail(place, "the attribute is missing");
  return TrimmedText(std::move(*text));
}

namespace {

constexpr std::uint64_t kPageBytes = 4096;
constexpr haddr_t kMaxAddress = (haddr_t{1} << 62) - 1;

/// What H5Pset_driver() is given, and what stands in the list of properties.
struct Options {
  FailingSafely* owner;
};

struct OpenFile {
  H5FD_t base{};  // first: libhdf5 knows no more of it
  FailingSafely* owner = nullptr;
  int descriptor = -1;
  haddr_t end_allocated = 0, end_of_file = 0;
};

OpenFile* Of(H5FD_t* file) { return reinterpret_cast<OpenFile*>(file); }
const OpenFile* Of(const H5FD_t* file) { return reinterpret_cast<const OpenFile*>(file); }

H5FD_t* Open(const char* name, unsigned flags, hid_t access, haddr_t /*most*/) {
  const auto* options = static_cast<const Options*>(H5Pget_driver_info(access));
  if (options == nullptr || (flags & H5F_ACC_CREAT) == 0) return nullptr;
  auto file = std::make_unique<OpenFile>();
  file->owner = options->owner;
  file->descriptor = ::open(name, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file->descriptor < 0) {
    file->owner->Note(errno);
    return nullptr;
  }
  return &file.release()->base;
}

herr_t Close(H5FD_t* file) {
  const std::unique_ptr<OpenFile> closed(Of(file));
  if (::close(closed->descriptor) != 0) closed->owner->Note(errno);
  return 0;
}

herr_t Query(const H5FD_t* /*file*/, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t EndAllocated(const H5FD_t* file, H5FD_mem_t /*kind*/) { return Of(file)->end_allocated; }
herr_t SetEndAllocated(H5FD_t* file, H5FD_mem_t /*kind*/, haddr_t end) {
  Of(file)->end_allocated = end;
  return 0;
}
haddr_t EndOfFile(const H5FD_t* file, H5FD_mem_t /*kind*/) { return Of(file)->end_of_file; }

herr_t Read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, void* bytes) {
  OpenFile& from = *Of(file);
  return from.owner->Read(from.descriptor, at, static_cast<char*>(bytes), count) ? 0 : -1;
}

herr_t Write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, const void* bytes) {
  OpenFile& to = *Of(file);
  to.owner->Write(to.descriptor, at, static_cast<const char*>(bytes), count);
  to.end_of_file = std::max<haddr_t>(to.end_of_file, at + count);
  return 0;
}

herr_t Truncate(H5FD_t* file, hid_t, hbool_t /*closing*/) {
  OpenFile& to = *Of(file);
  if (to.end_of_file == to.end_allocated) return 0;
  if (::ftruncate(to.descriptor, static_cast<off_t>(to.end_allocated)) != 0) to.owner->Note(errno);
  to.end_of_file = to.end_allocated;
  return 0;
}

H5FD_class_t Driver() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 2)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(512);  // the first that is free for all
#endif
  driver.name = "sarblock";
  driver.maxaddr = kMaxAddress;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.fapl_size = sizeof(Options);
  driver.open = Open;
  driver.close = Close;
  driver.query = Query;
  driver.get_eoa = EndAllocated;
  driver.set_eoa = SetEndAllocated;
  driver.get_eof = EndOfFile;
  driver.read = Read;
  driver.write = Write;
  driver.truncate = Truncate;
  constexpr H5FD_mem_t kLists[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kLists), std::end(kLists), std::begin(driver.fl_map));
  return driver;
}

/// False where the descriptor does not take or give all bytes; errno says why.
template <typename Move>
bool MoveAll(std::uint64_t at, std::uint64_t count, const Move& move) {
  for (std::uint64_t done = 0; done < count;) {
    errno = 0;
    const ssize_t moved = move(done, static_cast<off_t>(at + done), count - done);
    if (moved < 0 && errno == EINTR) continue;
    if (moved <= 0) return false;
    done += static_cast<std::uint64_t>(moved);
  }
  return true;
}

}  // namespace

FailingSafely::FailingSafely() {
  static const H5FD_class_t kDriver = Driver();
  driver_ = Hdf5Id(H5FDregister(&kDriver), H5FDunregister);
}

Hdf5Id FailingSafely::Access() {
  Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Options options{this};
  H5Pset_driver(access.get(), driver_.get(), &options);
  return access;
}

void FailingSafely::Write(int descriptor,
                          std::uint64_t at,
                          const char* bytes,
                          std::uint64_t count) {
  if (error_ == 0 && MoveAll(at, count, [&](std::uint64_t done, off_t place, std::uint64_t left) {
        return ::pwrite(descriptor, bytes + done, left, place);
      })) {
    return;
  }
  Note(errno != 0 ? errno : ENOSPC);
  for (std::uint64_t done = 0; done < count;) {
    const std::uint64_t page = (at + done) / kPageBytes, offset = (at + done) % kPageBytes;
    const std::uint64_t size = std::min(kPageBytes - offset, count - done);
    std::vector<char>& kept = not_written_[page];
    if (kept.empty()) {
      std::vector<char> whole(kPageBytes);
      const ssize_t got =
          ::pread(descriptor, whole.data(), kPageBytes, static_cast<off_t>(page * kPageBytes));
      static_cast<void>(got);  // what the file has not is zero
      kept = std::move(whole);
    }
    std::memcpy(kept.data() + offset, bytes + done, size);
    done += size;
  }
}

bool FailingSafely::Read(int descriptor, std::uint64_t at, char* bytes, std::uint64_t count) {
  std::uint64_t read = 0;
  while (read < count) {
    const ssize_t got =
        ::pread(descriptor, bytes + read, count - read, static_cast<off_t>(at + read));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    read += static_cast<std::uint64_t>(got);
  }
  std::memset(bytes + read, 0, count - read);  // behind the end, as libhdf5's own driver gives it
  const std::uint64_t end = at + count;
  for (auto page = not_written_.lower_bound(at / kPageBytes);
       page != not_written_.end() && page->first * kPageBytes < end;
       ++page) {
    const std::uint64_t first = std::max(at, page->first * kPageBytes);
    const std::uint64_t last = std::min(end, (page->first + 1) * kPageBytes);
    std::memcpy(bytes + (first - at),
                page->second.data() + (first - page->first * kPageBytes),
                last - first);
  }
  return true;
}

}  // namespace sarblock

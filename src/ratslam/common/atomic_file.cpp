#include "ratslam/common/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <utility>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// Whether the file's bytes have reached the disk.
bool synchronised(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = ::fsync(descriptor) == 0 || errno == EINVAL;  // not every file system supports it
  ::close(descriptor);
  return done;
}

bool beginsWith(const std::string& path, const std::string& magic) {
  std::string beginning(magic.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  return file.read(beginning.data(), static_cast<std::streamsize>(beginning.size())) && beginning == magic;
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), part_(path_ + ".part") {
  std::error_code error;
  const fs::file_status there = fs::status(path_, error);
  if (fs::exists(there) && !fs::is_regular_file(there)) fail("something that is no file has this name");
  for (const auto& [magic, what] :
       {std::pair{"#ROSBAG V", "a recording"}, std::pair{"SQLite format 3", "a map or another database"}}) {
    if (beginsWith(path_, magic)) fail(std::string("it is ") + what + " and is not overwritten");
  }
  errno = 0;
  file_.open(part_, std::ios::binary | std::ios::trunc);
  if (!file_) fail(errno != 0 ? std::strerror(errno) : "the system reports no reason");
  file_.precision(std::numeric_limits<double>::max_digits10);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  file_.close();
  std::error_code ignored;
  fs::remove(part_, ignored);
}

void AtomicFile::close() {
  if (closed_) return;
  errno = 0;
  file_.flush();
  const bool written = file_.good();
  file_.close();
  if (!written || file_.fail() || !synchronised(part_)) {
    fail(errno != 0 ? std::strerror(errno) : "the system reports no reason");
  }
  closed_ = true;
}

void AtomicFile::commit() {
  close();
  std::error_code error;
  fs::rename(part_, path_, error);
  if (error) fail(error.message());
  committed_ = true;
}

void AtomicFile::fail(const std::string& what) const {
  throw std::runtime_error(path_ + ": cannot write this file: " + what);
}

void requireWritable(const std::string& path) { AtomicFile file(path); }

}  // namespace ratslam

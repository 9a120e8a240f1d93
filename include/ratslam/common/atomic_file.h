/// A file that is there whole or not at all: written beside its place and renamed once it is complete.
///
/// Whatever ends the program before commit(), and whatever the disk refuses, leaves what was there before.
#pragma once

#include <fstream>
#include <string>

namespace ratslam {

class AtomicFile {
 public:
  /// Opens PATH.part. Numbers are written such that reading them gives the same doubles.
  /// @throws std::runtime_error naming the path where it cannot be written, or is taken by something that is
  /// no file
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return file_; }
  const std::string& path() const { return path_; }

  /// Makes sure that all is on the disk. Nothing can be written after it.
  /// @throws std::runtime_error naming the path where it is not
  void close();
  /// Closes, and puts the file in its place. @throws std::runtime_error as close does
  void commit();

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::string part_;
  std::ofstream file_;
  bool closed_ = false;
  bool committed_ = false;
};

/// Fails now where an AtomicFile of that path would fail at the end of a long run; leaves nothing behind.
/// @throws std::runtime_error naming the path
void requireWritable(const std::string& path);

}  // namespace ratslam

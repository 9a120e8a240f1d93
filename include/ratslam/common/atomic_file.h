/// A file that is written under a temporary name and renamed once it is complete.
///
/// If the program ends before commit(), or writing fails, the old file remains.
#pragma once

#include <fstream>
#include <string>

namespace ratslam {

class AtomicFile {
 public:
  /// Opens PATH.part. Numbers have enough digits to give the same doubles when read.
  /// @throws std::runtime_error naming the path if it cannot be written, or exists and is not a regular file, or is a bag
  /// or a database
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return file_; }
  const std::string& path() const { return path_; }

  /// Writes everything to the disk. Nothing can be written to the stream afterwards.
  /// @throws std::runtime_error naming the path if that fails
  void close();
  /// Closes and renames the file. @throws std::runtime_error as close does
  void commit();

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::string part_;
  std::ofstream file_;
  bool closed_ = false;
  bool committed_ = false;
};

/// Fails at once if an AtomicFile of that path would fail at the end of a long run. Leaves no file behind.
/// @throws std::runtime_error naming the path
void requireWritable(const std::string& path);

}  // namespace ratslam

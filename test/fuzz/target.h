/// What a fuzzer feeds with bytes: every reader of files and every message that a stage takes.
///
/// A target takes any bytes. What is wrong with them it may refuse, in one line that says so (Refusal); anything
/// else - another exception, a crash, a number that is none - is a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

namespace ratslam {
class ExperienceMap;
struct PoseCellParams;
}  // namespace ratslam

namespace ratslam::fuzz {

using Bytes = std::vector<std::uint8_t>;

struct Target {
  const char* name;  ///< also of its folder in the corpus
  void (*run)(const Bytes& input);
};

/// Files of the core's readers.
std::vector<Target> fileTargets();
/// Odometry, views, decisions and images into the stages.
std::vector<Target> stageTargets();
/// ROS messages as they come from a wire, and bags; empty in a build without ROS.
std::vector<Target> messageTargets();
/// A fault inside the core that only a sanitised core reports: shows that a run would see one.
Target plantedFault();

/// The target of a name. @throws std::runtime_error listing the names where there is none
Target findTarget(const std::string& name);

/// Runs something that may refuse its input by std::runtime_error or std::invalid_argument.
/// Aborts, with the reason, where the refusal is not one short line of text that can be printed.
void mayRefuse(const std::function<void()>& action);

/// Aborts where a condition does not hold.
void require(bool condition, const char* what);

/// A network of few cells: what an input can do wrong does not hang on their number, the time it takes does.
PoseCellParams fewPoseCells();

/// Aborts where a pose of the map is not finite.
void requireFinite(const ExperienceMap& map);

/// A folder in memory that is emptied again.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// @return path of the file, which now has this content
  std::string write(const std::string& name, const std::uint8_t* data, std::size_t size) const;
  std::string write(const std::string& name, const Bytes& content) const;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Takes numbers off the front of an input; zeros once it is used up.
class Reader {
 public:
  explicit Reader(const Bytes& input) : input_(input) {}

  bool atEnd() const { return next_ >= input_.size(); }
  template <class Number>
  Number take() {
    Number number{};
    const std::size_t count = std::min(sizeof number, input_.size() - next_);
    if (count > 0) std::memcpy(&number, input_.data() + next_, count);
    next_ += count;
    return number;
  }
  /// At most `count` bytes.
  Bytes takeBytes(std::size_t count);
  Bytes rest() { return takeBytes(input_.size()); }

 private:
  const Bytes& input_;
  std::size_t next_ = 0;
};

}  // namespace ratslam::fuzz

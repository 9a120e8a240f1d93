#include "ratslam/common/yaml_check.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

namespace ratslam {
namespace {

constexpr int kDeepest = 32;

/// Throws if YAML is nested too deeply, before the parser recurses further.
class DepthGuard : public YAML::EventHandler {
 public:
  YAML::Mark begin() const { return begin_; }

  void OnDocumentStart(const YAML::Mark& mark) override { begin_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void enter(const YAML::Mark& mark) {
    if (++depth_ > kDeepest) throw YAML::ParserException(mark, "nested too deep");
  }

  YAML::Mark begin_;
  int depth_ = 0;
};

}  // namespace

void requireOneYamlDocument(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DepthGuard guard;
  if (!parser.HandleNextDocument(guard)) return;
  const YAML::Mark first = guard.begin();
  if (!parser.HandleNextDocument(guard)) return;
  // The parser takes invalid text for an empty document, again and again at the same position.
  const bool stands_still = guard.begin().pos == first.pos;
  throw YAML::ParserException(guard.begin(), stands_still
                                                 ? "neither a key nor a value begins like this"
                                                 : "a second document, parted by '---'; a file is one");
}

}  // namespace ratslam

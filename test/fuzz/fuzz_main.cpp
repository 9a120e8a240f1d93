// The entry points that libFuzzer calls. RATSLAM_FUZZ_TARGET names the target.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "target.h"

namespace {

const ratslam::fuzz::Target& chosen() {
  static const ratslam::fuzz::Target target = [] {
    try {
      const char* name = std::getenv("RATSLAM_FUZZ_TARGET");
      return ratslam::fuzz::findTarget(name == nullptr ? "" : name);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "RATSLAM_FUZZ_TARGET: %s\n", error.what());
      std::exit(2);
    }
  }();
  return target;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen().run(ratslam::fuzz::Bytes(data, data + size));
  return 0;
}

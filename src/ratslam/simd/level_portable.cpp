#include "levels.h"

#define RATSLAM_REGISTER_BYTES 16
#define RATSLAM_LAMBDA

namespace ratslam {
namespace {
#include "level_body.h"
}  // namespace

Kernels kernelsOfArchitecture() {
  return kernelsOfLevel(features::kFeatureKernels, smallestSadsOfArchitecture, nullptr);
}

Kernels kernelsScalar() { return kernelsOfLevel(features::kFeatureKernels, smallestSadsScalar, nullptr); }

}  // namespace ratslam

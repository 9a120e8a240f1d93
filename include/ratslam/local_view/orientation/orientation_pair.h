/// Descriptor and matcher `orientation`: orientation energies with adaptation (orientation_energy.h, adaptation.h),
/// stored as bytes and compared by the cosine of their angle (byte_matcher.h). They are robust to light, weather and
/// season.
#pragma once

#include "ratslam/local_view/descriptor_registry.h"

namespace ratslam {

/// @throws std::invalid_argument as LocalViewParams::validate does.
ViewPair makeOrientationPair(const LocalViewParams& params);

}  // namespace ratslam

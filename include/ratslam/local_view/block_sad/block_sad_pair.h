/// Mean greys of blocks, compared by sums of absolute differences: OpenRatSLAM's view (MODEL section 1),
/// behind the seam of descriptor.h and matcher.h.
///
/// A view's values are its block sums, which are whole numbers, and after them what a white block sums to.
#pragma once

#include "ratslam/local_view/descriptor_registry.h"

namespace ratslam {

/// @throws std::invalid_argument as LocalViewParams::validate does.
ViewPair makeBlockSadPair(const LocalViewParams& params);

}  // namespace ratslam

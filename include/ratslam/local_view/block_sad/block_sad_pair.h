/// Descriptor and matcher `blocks`: mean grey values of blocks, compared by sums of absolute differences, as in
/// OpenRatSLAM (docs/model.md section 1).
///
/// The values of a view are its block sums, which are whole numbers, followed by the sum of a white block.
#pragma once

#include "ratslam/local_view/descriptor_registry.h"

namespace ratslam {

/// @throws std::invalid_argument as LocalViewParams::validate does.
ViewPair makeBlockSadPair(const LocalViewParams& params);

}  // namespace ratslam

#include "ratslam/local_view/orientation/orientation_pair.h"

#include <cmath>
#include <cstdlib>
#include <memory>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"
#include "ratslam/local_view/orientation/adaptation.h"
#include "ratslam/local_view/orientation/byte_matcher.h"
#include "ratslam/local_view/orientation/orientation_energy.h"
#include "ratslam/local_view/orientation/orientation_picture.h"

namespace ratslam {
namespace {

constexpr int kShiftStep =
    kOrientationCell / 2;                     // between variants [pixels of 64]; finer ones are too similar
constexpr int kLaneShift = kOrientationCell;  // shift of another lane [pixels of 64]
constexpr double kSameLane = 0.5;             // prior probability of the same lane
constexpr double kLeastContrast = 1.0;        // with less contrast an image shows nothing [grey values^2]

/// Shift of the image for each variant of a view [pixels of 64].
std::vector<int> shiftsOf(bool panoramic) {
  std::vector<int> shifts{0};
  const int most = panoramic ? kOrientationColumns / 2 : kLaneShift;
  for (int shift = kShiftStep; shift <= most; shift += kShiftStep) {
    shifts.push_back(shift);
    if (!panoramic || shift < most) shifts.push_back(-shift);  // half a turn is the same in both directions
  }
  return shifts;
}

/// Turn of a camera [rad] whose image matches another one when it is moved to the right by `shift` pixels of 64. Positive
/// turns are to the left; they move the scene to the right.
double turnOf(int shift, const LocalViewParams& params) {
  if (params.panoramic) return wrapAngle(2.0 * kPi * shift / kOrientationColumns);
  const double half_angle = 0.5 * params.view_angle_deg * kPi / 180.0;
  return -std::atan(2.0 * std::tan(half_angle) * shift / kOrientationColumns);
}

/// Prior probability of a variant. A forward camera returns more often in the same lane than in another one. A panoramic
/// camera returns with any heading.
double priorOf(std::size_t variant, std::size_t variants, bool panoramic) {
  if (panoramic) return 1.0 / static_cast<double>(variants);
  return variant == 0 ? kSameLane : (1.0 - kSameLane) / static_cast<double>(variants - 1);
}

Adaptation::Sharing sharingOf(bool panoramic) {
  if (!panoramic) return {};
  return {static_cast<std::size_t>(kOrientationCellColumns), static_cast<std::size_t>(kOrientationBins)};
}

class OrientationDescriptor : public ViewDescriptor {
 public:
  explicit OrientationDescriptor(const LocalViewParams& params)
      : params_(params),
        shifts_(shiftsOf(params.panoramic)),
        adaptation_(static_cast<std::size_t>(kOrientationValues), static_cast<std::size_t>(kOrientationBins),
                    sharingOf(params.panoramic)) {}

  View describe(const cv::Mat& image) override {
    const OrientationEnergy energy(image, params_.view_template, params_.panoramic);
    View view;
    view.textured = energy.contrast() >= kLeastContrast;
    const std::vector<double> as_seen = energy.values(0);
    if (view.textured && !adaptation_.started()) adaptation_.start(as_seen);
    for (const int shift : shifts_) {
      view.variants.push_back({adaptation_.apply(shift == 0 ? as_seen : energy.values(shift)),
                               turnOf(shift, params_),
                               priorOf(view.variants.size(), shifts_.size(), params_.panoramic)});
    }
    if (view.textured) adaptation_.learn(as_seen);
    return view;
  }

  void save(State& state) const override { state.write(adaptation_); }
  void load(const State& state) override { state.read(adaptation_); }

 private:
  LocalViewParams params_;
  std::vector<int> shifts_;
  Adaptation adaptation_;
};

}  // namespace

ViewPair makeOrientationPair(const LocalViewParams& params) {
  params.validate();
  return {std::make_unique<OrientationDescriptor>(params),
          std::make_unique<ByteMatcher>(static_cast<std::size_t>(kOrientationValues),
                                        params.orientation_threshold, orientationPicture)};
}

}  // namespace ratslam

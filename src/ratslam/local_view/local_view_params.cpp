#include "ratslam/local_view/local_view_params.h"

namespace ratslam {
namespace {

void checkCropRange(const char* max_key, int max, const char* min_key, int min) {
  if (max == -1 || max > min) return;
  std::ostringstream requirement;
  requirement << "it must be -1 (the image's edge) or greater than " << min_key << " (" << min << ")";
  throwBadValue(max_key, max, requirement.str());
}

}  // namespace

void TemplateParams::validate() const {
  checkBounds(*this);
  checkCropRange("image_crop_x_max", crop_x_max, "image_crop_x_min", crop_x_min);
  checkCropRange("image_crop_y_max", crop_y_max, "image_crop_y_min", crop_y_min);
}

void ViewRecallParams::validate() const {
  if (kind != "nearest" && kind != "belief") throwBadValue("vt_recall", kind, "it must be nearest or belief");
}

void LocalViewParams::validate() const {
  checkBounds(*this);
  view_template.validate();
  recall.validate();
  if (descriptor == "blocks" && comparedColumns() < 1) {
    std::ostringstream requirement;
    requirement << "twice the shift must be less than template_x_size (" << view_template.x_size
                << ") unless vt_panoramic is set";
    throwBadValue("vt_shift_match", shift_match, requirement.str());
  }
}

}  // namespace ratslam

/// Parameters of the local view cells: how an image becomes a template, and how templates are compared.
#pragma once

#include <string>

#include "ratslam/common/params.h"

namespace ratslam {

/// How an image becomes a template (docs/model.md section 1, steps 1-4).
struct TemplateParams {
  int crop_x_min = 0;
  int crop_x_max = -1;
  int crop_y_min = 0;
  int crop_y_max = -1;
  int x_size = 1;
  int y_size = 1;
  double normalisation = 0.0;
  int patch_radius = 0;
  double min_patch_std = 0.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("image_crop_x_min", crop_x_min, Bounds{0, 65535}, "left edge of the part of the image used [px]");
    visit("image_crop_x_max", crop_x_max, Bounds{-1, 65535}, "right edge, exclusive; -1: the image's [px]");
    visit("image_crop_y_min", crop_y_min, Bounds{0, 65535}, "upper edge of the part of the image used [px]");
    visit("image_crop_y_max", crop_y_max, Bounds{-1, 65535}, "lower edge, exclusive; -1: the image's [px]");
    visit("template_x_size", x_size, Bounds{1, 1024}, "columns of a template");
    visit("template_y_size", y_size, Bounds{1, 1024}, "rows of a template");
    visit("vt_normalisation", normalisation, Bounds{0, 1},
          "mean that every template is scaled to; 0: not scaled");
    visit("vt_patch_normalise", patch_radius, Bounds{0, 64},
          "radius of the patch whose mean and deviation normalise each value; 0: none");
    visit("vt_min_patch_normalisation_std", min_patch_std, Bounds{0, 1e6},
          "a patch of smaller standard deviation is featureless");
  }

  /// @throws std::invalid_argument naming key, value and requirement.
  void validate() const;
};

/// Which method recalls a view.
struct ViewRecallParams {
  std::string kind = "nearest";

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit(
        "vt_recall", kind, Bounds{},
        "nearest: recall the most similar template; belief: recall the place that odometry and the views so "
        "far make most likely");
  }
  bool believes() const { return kind == "belief"; }

  /// @throws std::invalid_argument naming key, value and requirement.
  void validate() const;
};

/// How templates are compared, recalled and learned (docs/model.md section 1, steps 5-6).
struct LocalViewParams {
  TemplateParams view_template;
  double match_threshold = 0.03;
  int shift_match = 25;
  int step_match = 5;
  bool panoramic = false;
  std::string descriptor = "blocks";
  ViewRecallParams recall;
  double orientation_threshold = 0.15;
  double view_angle_deg = 0.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    view_template.visitFields(visit);
    visit("vt_match_threshold", match_threshold, Bounds{0, 1},
          "blocks: largest mean difference between a view and the template it recalls");
    visit("vt_shift_match", shift_match, Bounds{0, 1024},
          "largest shift to either side of a forward camera's view [template columns]");
    visit("vt_step_match", step_match, Bounds{1, 1024},
          "step between compared shifts [template columns]; it must divide vt_shift_match for unshifted "
          "views to be compared");
    visit("vt_panoramic", panoramic, Bounds{0, 1},
          "the image goes all round: its last column adjoins its first");
    visit("vt_descriptor", descriptor, Bounds{},
          "what is compared: blocks (grey values) or orientation (of edges)");
    recall.visitFields(visit);
    visit("vt_orientation_threshold", orientation_threshold, Bounds{0, 2},
          "orientation: largest error (1 - cosine) between two views of one place");
    visit("vt_view_angle_deg", view_angle_deg, Bounds{0, 175},
          "orientation: horizontal angle that the crop of a forward camera sees; it turns a shift into a "
          "heading [deg]; 0: unknown, a recall has the heading of its template");
  }

  /// Columns of the view that take part in the comparison at every shift.
  int comparedColumns() const {
    return panoramic ? view_template.x_size : view_template.x_size - 2 * shift_match;
  }

  /// Number of shifts compared; shift number i is i * step_match columns.
  int shiftCount() const { return (panoramic ? view_template.x_size - 1 : 2 * shift_match) / step_match + 1; }

  /// Two templates are compared only if their means differ by at most this.
  double meanGate() const { return match_threshold + 0.005; }

  /// @throws std::invalid_argument naming key, value and requirement.
  void validate() const;
};

}  // namespace ratslam

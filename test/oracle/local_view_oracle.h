/// The local view cells straight from docs/model.md section 1: every template kept as doubles, every shift of every
/// template compared in full. Slow and plain on purpose: the tests compare the library with it, the
/// benchmarks measure against it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/local_view/local_view_params.h"

namespace ratslam::oracle {

using Values = std::vector<double>;  // X x Y, row by row

inline double mean(const Values& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Sum of the colour channels of a pixel.
inline double colourSum(const cv::Mat& image, int x, int y) {
  switch (image.type()) {
    case CV_16UC1:
      return image.at<std::uint16_t>(y, x);
    case CV_8UC3: {
      const auto& pixel = image.at<cv::Vec3b>(y, x);
      return pixel[0] + pixel[1] + pixel[2];
    }
    case CV_8UC4: {
      const auto& pixel = image.at<cv::Vec4b>(y, x);
      return pixel[0] + pixel[1] + pixel[2];
    }
    default:
      return image.at<std::uint8_t>(y, x);
  }
}

/// Steps 1 and 2: means of the blocks of the crop.
inline Values blockMeans(const cv::Mat& image, const TemplateParams& p) {
  const int x_max = p.crop_x_max == -1 ? image.cols : p.crop_x_max;
  const int y_max = p.crop_y_max == -1 ? image.rows : p.crop_y_max;
  const int width = (x_max - p.crop_x_min) / p.x_size;
  const int height = (y_max - p.crop_y_min) / p.y_size;
  const double colours = image.channels() == 1 ? 1.0 : 3.0;
  const double white = image.depth() == CV_16U ? 65535.0 : 255.0;
  Values values;
  for (int j = 0; j < p.y_size; ++j) {
    for (int i = 0; i < p.x_size; ++i) {
      double sum = 0.0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          sum += colourSum(image, p.crop_x_min + i * width + x, p.crop_y_min + j * height + y);
        }
      }
      values.push_back(sum / (width * height * colours * white));
    }
  }
  return values;
}

/// Step 3.
inline void normalise(Values& values, double target) {
  const double now = mean(values);
  if (now == 0.0) return;
  const double scale = target / now;
  for (double& value : values) value = std::clamp(value * scale, 0.0, 1.0);
}

/// Step 4.
inline Values patchNormalise(const Values& values, const TemplateParams& p) {
  Values result;
  for (int y = 0; y < p.y_size; ++y) {
    for (int x = 0; x < p.x_size; ++x) {
      Values patch;
      for (int j = y - p.patch_radius; j <= y + p.patch_radius; ++j) {
        for (int i = x - p.patch_radius; i <= x + p.patch_radius; ++i) {
          const int row = std::clamp(j, 0, p.y_size - 1);
          const int column = std::clamp(i, 0, p.x_size - 1);
          patch.push_back(values[static_cast<std::size_t>(row * p.x_size + column)]);
        }
      }
      const double m = mean(patch);
      double variance = 0.0;
      for (const double value : patch) variance += (value - m) * (value - m);
      const bool flat = std::all_of(patch.begin(), patch.end(), [&](double v) { return v == patch[0]; });
      const double s = flat ? 0.0 : std::sqrt(variance / static_cast<double>(patch.size()));
      const double value = values[static_cast<std::size_t>(y * p.x_size + x)];
      if (s < p.min_patch_std) {
        result.push_back(0.5);
      } else {
        result.push_back(s == 0.0 ? 1.0 : std::clamp(((value - m) / s + 3.0) / 6.0, 0.0, 1.0));
      }
    }
  }
  return result;
}

/// Steps 1 to 4.
inline Values makeTemplate(const cv::Mat& image, const TemplateParams& p) {
  Values values = blockMeans(image, p);
  if (p.normalisation > 0.0) normalise(values, p.normalisation);
  if (p.patch_radius > 0) values = patchNormalise(values, p);
  return values;
}

struct Match {
  std::uint32_t id = 0;
  int shift = 0;
  double error = 0.0;
};

/// Step 5: the templates learned, and the search.
class Matcher {
 public:
  explicit Matcher(const LocalViewParams& params) : params_(params) {}

  void add(const Values& values) {
    templates_.push_back(values);
    means_.push_back(mean(values));
  }
  std::size_t size() const { return templates_.size(); }

  std::optional<Match> best(const Values& view) const {
    std::optional<Match> best;
    const double view_mean = mean(view);
    const int columns = params_.view_template.x_size;
    const int last_shift = params_.panoramic ? columns - 1 : 2 * params_.shift_match;
    for (std::uint32_t id = 0; id < templates_.size(); ++id) {
      if (std::abs(view_mean - means_[id]) > params_.match_threshold + 0.005) continue;
      for (int shift = 0; shift <= last_shift; shift += params_.step_match) {
        const double error = params_.panoramic ? panoramicError(view, templates_[id], shift)
                                               : forwardError(view, templates_[id], shift);
        if (!best || error < best->error) best = Match{id, shift, error};
      }
    }
    return best;
  }

 private:
  double forwardError(const Values& view, const Values& learned, int shift) const {
    const int columns = params_.view_template.x_size;
    const int compared = columns - 2 * params_.shift_match;
    double sum = 0.0;
    for (int y = 0; y < params_.view_template.y_size; ++y) {
      const double* view_row = view.data() + y * columns + params_.shift_match;
      const double* learned_row = learned.data() + y * columns + shift;
      for (int x = 0; x < compared; ++x) sum += std::abs(view_row[x] - learned_row[x]);
    }
    return sum / (compared * params_.view_template.y_size);
  }

  double panoramicError(const Values& view, const Values& learned, int shift) const {
    const int columns = params_.view_template.x_size;
    double sum = 0.0;
    for (int y = 0; y < params_.view_template.y_size; ++y) {
      const double* view_row = view.data() + y * columns;
      const double* learned_row = learned.data() + y * columns;
      for (int x = 0; x < columns; ++x) {
        const int wrapped = x + shift < columns ? x + shift : x + shift - columns;
        sum += std::abs(view_row[x] - learned_row[wrapped]);
      }
    }
    return sum / (columns * params_.view_template.y_size);
  }

  LocalViewParams params_;
  std::vector<Values> templates_;
  Values means_;
};

}  // namespace ratslam::oracle

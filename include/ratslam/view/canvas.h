/// Common functions for the pictures of the running system: conversion to colours, scaling, lettering.
///
/// Pictures are 8-bit BGR. They are shown by topics and videos, not in windows.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace ratslam {

const cv::Scalar kInk(235, 235, 235);        ///< lettering
const cv::Scalar kPaper(28, 24, 22);         ///< background
const cv::Scalar kDrivenLink(255, 160, 60);  ///< link to a new experience
const cv::Scalar kRecallLink(40, 90, 255);   ///< link by recall
const cv::Scalar kRobot(80, 230, 120);

/// Converts an image (8 or 16 bits, 1, 3 or 4 channels) to 8-bit BGR. Always a copy.
/// @throws std::invalid_argument for an empty image or another kind
cv::Mat toBgr8(const cv::Mat& image);

/// A picture of exactly `size` with `image` (8-bit BGR) in the middle, as large as possible.
/// @param interpolation one of OpenCV's; nearest shows single values
cv::Mat fitInto(const cv::Mat& image, const cv::Size& size, int interpolation);

/// Writes a line of text with its upper left corner at `place`, on a dark ground.
void label(cv::Mat& picture, const cv::Point& place, const std::string& text);

}  // namespace ratslam

/// What the pictures of the running system have in common: conversion to colours, fitting, lettering.
///
/// Pictures are 8-bit BGR. Nothing here opens a window; topics and videos show what is drawn.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace ratslam {

const cv::Scalar kInk(235, 235, 235);        ///< lettering
const cv::Scalar kPaper(28, 24, 22);         ///< background
const cv::Scalar kDrivenLink(255, 160, 60);  ///< the robot drove on to a new place
const cv::Scalar kRecallLink(40, 90, 255);   ///< the robot recognised a place
const cv::Scalar kRobot(80, 230, 120);

/// An image of any kind the system takes (8 or 16 bits, 1, 3 or 4 channels) as 8-bit BGR; a copy.
/// @throws std::invalid_argument for an empty image or another kind
cv::Mat toBgr8(const cv::Mat& image);

/// A picture of exactly `size` with `image` (8-bit BGR) as large as it fits in the middle; @param
/// interpolation OpenCV's, nearest where single values are to be seen.
cv::Mat fitInto(const cv::Mat& image, const cv::Size& size, int interpolation);

/// Writes a line of text with its upper left corner at `place`, on a dark ground.
void label(cv::Mat& picture, const cv::Point& place, const std::string& text);

}  // namespace ratslam

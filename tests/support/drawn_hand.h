// Draws a hand before the lens: a blob over a part of the picture that reaches in from one of its rims.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace ulf::test {

enum class HandLook { kPlain, kSkin, kTextured };

// Covers about `share` of the picture (CV_8UC3 or CV_8UC1), and returns where (CV_8U, 255). The blob is an
// ellipse with a wavy outline; kSkin is shaded, kTextured has strong structures of several sizes.
inline cv::Mat DrawHand(cv::Mat& picture, double share, HandLook look, unsigned seed) {
  cv::RNG random(seed * 7919 + 1);
  const cv::Size size = picture.size();
  const double angle = random.uniform(0.0, 2 * M_PI), waves = random.uniform(2, 6),
               phase = random.uniform(0.0, 2 * M_PI), stretch = random.uniform(0.7, 1.4);
  const cv::Point2d rim(size.width * (0.5 + 0.5 * std::cos(angle)),
                        size.height * (0.5 + 0.5 * std::sin(angle)));
  cv::Mat distance(size, CV_32F);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double dx = (x - rim.x) * stretch, dy = (y - rim.y) / stretch;
      distance.at<float>(y, x) =
          static_cast<float>(std::hypot(dx, dy) * (1 + 0.12 * std::sin(waves * std::atan2(dy, dx) + phase)));
    }
  double nearest = 0, farthest = 2.0 * (size.width + size.height);
  cv::Mat hand;
  for (int i = 0; i < 40; ++i) {
    const double middle = (nearest + farthest) / 2;
    hand = distance < middle;
    (cv::countNonZero(hand) < share * static_cast<double>(size.area()) ? nearest : farthest) = middle;
  }
  cv::Mat blob(size, CV_8UC3, cv::Scalar(110, 140, 205));
  if (look == HandLook::kPlain)
    blob.setTo(cv::Scalar(random.uniform(10, 240), random.uniform(10, 240), random.uniform(10, 240)));
  cv::Mat shade = cv::Mat::zeros(size, CV_32F);
  for (const double coarse : {0.25, 0.06, 0.015}) {
    if (look == HandLook::kPlain || (look == HandLook::kSkin && coarse < 0.05)) continue;
    cv::Mat noise(std::max(2, static_cast<int>(1 / coarse)), std::max(2, static_cast<int>(1.3 / coarse)),
                  CV_32F);
    random.fill(noise, cv::RNG::NORMAL, 0, look == HandLook::kTextured ? 40 : 12);
    cv::resize(noise, noise, size, 0, 0, cv::INTER_CUBIC);
    shade += noise;
  }
  cv::Mat shades[] = {shade, shade, shade}, shaded;
  cv::merge(shades, 3, shaded);
  cv::Mat sensor(size, CV_32FC3);
  random.fill(sensor, cv::RNG::NORMAL, 0, 2);
  shaded += sensor;
  cv::add(blob, shaded, blob, cv::noArray(), CV_8UC3);
  if (picture.channels() == 1) cv::cvtColor(blob, blob, cv::COLOR_BGR2GRAY);
  blob.copyTo(picture, hand);
  return hand;
}

}  // namespace ulf::test

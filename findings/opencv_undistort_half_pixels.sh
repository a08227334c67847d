#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), getOptimalNewCameraMatrix and initUndistortRectifyMap.
# Expected: a principal point that counts pixel centres at halves (COLMAP's, nerfstudio's) may be given to OpenCV, which counts
#           them at whole numbers, where it goes in and comes out again: half a pixel to the right, half a pixel back.
# Seen:     that holds for a new camera of the same focal length alone. The new matrix for alpha = 0 is zoomed by f'/f, and the
#           undistorted picture lies 0.5 (f'/f - 1) pixels beside what its matrix says, in each axis. With the half taken off
#           the old matrix and put on the new one it is where it should be.
# Matters:  gsplat's examples and OpenSplat undistort COLMAP's sets in this way: poses are exact, pictures beside them.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12 packages=()
for part in core imgproc flann features2d calib3d; do packages+=("libopencv-$part-dev=$cv" "libopencv-${part}406=$cv"); done
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends "${packages[@]}" \
  >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
// How far the undistorted picture lies beside what its matrix says, in pixels of it, near its middle. Centres of
// the given lens are at halves; `taken_off` is subtracted before OpenCV sees the lens, and added afterwards.
double Beside(double taken_off, double* zoom) {
  const cv::Size size(960, 720);
  const cv::Mat terms = (cv::Mat_<double>(1, 4) << -0.21, 0.06, 0, 0);
  const cv::Matx33d lens(880, 0, 480, 0, 880, 360, 0, 0, 1);
  cv::Matx33d given = lens;
  given(0, 2) -= taken_off;
  given(1, 2) -= taken_off;
  const cv::Mat made = cv::getOptimalNewCameraMatrix(given, terms, size, 0);
  cv::Mat x, y;
  cv::initUndistortRectifyMap(given, terms, cv::noArray(), made, size, CV_32F, x, y);
  const int column = 480, row = 360;
  // The ray of the photograph's pixel that is shown there, by the lens.
  const std::vector<cv::Point2d> shown{{x.at<float>(row, column) + 0.5, y.at<float>(row, column) + 0.5}};
  std::vector<cv::Point2d> ray;
  cv::undistortPoints(shown, ray, lens, terms);
  const double f = made.at<double>(0, 0), c = made.at<double>(0, 2) + taken_off;
  *zoom = f / lens(0, 0);
  return f * ray[0].x + c - (column + 0.5);
}
int main() {
  double zoom = 1;
  const double as_given = Beside(0, &zoom), with_half = Beside(0.5, &zoom), expected = 0.5 * (zoom - 1);
  std::printf("   new focal length / old: %.4f\n   beside itself: %.4f px as given (0.5 (f'/f - 1) is %.4f), %.4f px with the "
              "half taken off and put on\n", zoom, as_given, expected, with_half);
  return std::abs(expected) > 0.02 && std::abs(as_given - expected) < 0.005 && std::abs(with_half) < 0.005 ? 0 : 1;
}
CPP
g++ -I root/usr/include/opencv4 try.cpp -o try -L "$libraries" -lopencv_calib3d -lopencv_core \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

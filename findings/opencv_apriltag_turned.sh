#!/usr/bin/env bash
# Version:  OpenCV 4.6.0 (Debian 12), its ArUco module; against AprilTag's own library, 3.3.0 (Debian 12).
# Expected: marker 0 of DICT_APRILTAG_36h11 is the picture that AprilTag prints for tag36h11, id 0: its published code
#           0xd5d628584 row by row, the highest bit first. The first corner detected on a printed tag is its upper left one.
# Seen:     the dictionary holds every picture of the four families turned by half a turn; id 0 of 36h11 is the code read
#           backwards. Ids are right, and the first corner of an upright printed tag is its lower right one.
# Matters:  a board whose corners are counted from AprilTag's pictures (Kalibr's grid) pairs each tag's corners two places
#           off, and nothing but the size of the errors says so.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
named=()
for part in core imgproc flann features2d calib3d contrib; do
  named+=("libopencv-$part-dev=$cv" "libopencv-${part}406=$cv")
done
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends "${named[@]}" \
  'libapriltag-dev=3.3.0*' 'libapriltag3=3.3.0*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>
// What AprilTag's library draws for an id, its white and black borders left off if `inside`; white is 1.
cv::Mat Printed(apriltag_family_t* family, int id, bool inside) {
  image_u8_t* drawn = apriltag_to_image(family, id);
  cv::Mat picture = cv::Mat(drawn->height, drawn->width, CV_8UC1, drawn->buf, drawn->stride).clone() / 255;
  std::free(drawn->buf);
  std::free(drawn);
  return inside ? picture(cv::Rect(2, 2, picture.cols - 4, picture.rows - 4)).clone() : picture;
}
bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::countNonZero(a != b) == 0;
}
std::uint64_t Code(const cv::Mat& bits) {
  std::uint64_t code = 0;
  for (int y = 0; y < bits.rows; ++y)
    for (int x = 0; x < bits.cols; ++x) code = 2 * code + bits.at<std::uint8_t>(y, x);
  return code;
}
int main() {
  struct Family {
    const char* name;
    apriltag_family_t* family;
    int dictionary;
  } families[] = {{"16h5", tag16h5_create(), cv::aruco::DICT_APRILTAG_16h5},
                  {"25h9", tag25h9_create(), cv::aruco::DICT_APRILTAG_25h9},
                  {"36h10", tag36h10_create(), cv::aruco::DICT_APRILTAG_36h10},
                  {"36h11", tag36h11_create(), cv::aruco::DICT_APRILTAG_36h11}};
  bool holds = true;
  for (const Family& f : families) {
    const auto dictionary = cv::aruco::getPredefinedDictionary(f.dictionary);
    int count = 0, upright = 0, turned = 0;
    for (; count < int(f.family->ncodes) && count < dictionary->bytesList.rows; ++count) {
      const cv::Mat printed = Printed(f.family, count, true);
      const cv::Mat held = cv::aruco::Dictionary::getBitsFromByteList(dictionary->bytesList.row(count),
                                                                      dictionary->markerSize);
      cv::Mat half;
      cv::rotate(held, half, cv::ROTATE_180);
      upright += Same(held, printed);
      turned += Same(half, printed);
    }
    std::printf(
        "   %s: of %d ids OpenCV holds as AprilTag prints them, expected all; seen %d, and %d turned by half "
        "a turn\n",
        f.name, count, upright, turned);
    holds &= count > 0 && upright == 0 && turned == count;
  }

  apriltag_family_t* family = families[3].family;
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  const std::uint64_t printed = Code(Printed(family, 0, true));
  const std::uint64_t held =
      Code(cv::aruco::Dictionary::getBitsFromByteList(dictionary->bytesList.row(0), 6));
  std::printf("   36h11, id 0, row by row: expected 0x%09llx, as AprilTag prints it; OpenCV holds 0x%09llx\n",
              (unsigned long long)printed, (unsigned long long)held);
  std::uint64_t backwards = 0;
  for (int i = 0; i < 36; ++i) backwards |= (0xd5d628584ull >> i & 1) << (35 - i);
  holds &= printed == 0xd5d628584ull && held == backwards;

  cv::Mat page;
  cv::resize(255 * Printed(family, 0, false), page, cv::Size(), 40, 40, cv::INTER_NEAREST);
  cv::copyMakeBorder(page, page, 100, 100, 100, 100, cv::BORDER_CONSTANT, 255);
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
  cv::aruco::detectMarkers(page, dictionary, corners, ids);
  if (ids.size() != 1)
    return std::printf("   OpenCV finds %zu markers on AprilTag's picture\n", ids.size()), 1;
  const cv::Point2f first = corners[0][0];
  const bool lower = first.y > page.rows / 2, right = first.x > page.cols / 2;
  std::printf(
      "   AprilTag's picture of id 0, upright: expected id 0, first corner upper left; seen id %d, first "
      "corner %s %s\n",
      ids[0], lower ? "lower" : "upper", right ? "right" : "left");
  holds &= ids[0] == 0 && lower && right;
  return holds ? 0 : 1;
}
CPP
g++ -I root/usr/include/opencv4 -I root/usr/include try.cpp -o try -L "$libraries" \
  -lopencv_aruco -lopencv_imgproc -lopencv_core -lapriltag -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

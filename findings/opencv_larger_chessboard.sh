#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), findChessboardCornersSB.
# Expected: a board of more inner corners than asked for is found only with CALIB_CB_LARGER, as its page says; without the
#           flag the answer is no.
# Seen:     without the flag a part of the larger board is found in many pictures, with success and the number of corners that
#           was asked for. Which part it is differs from picture to picture of the same board.
# Matters:  who says 9x6 of a board of 12x9 squares gets no error: corners of one picture stand for other places of the board
#           than the same corners of the next, and a calibration goes on with them.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
named=()
for part in core imgproc flann features2d calib3d; do
  named+=("libopencv-$part-dev=$cv" "libopencv-${part}406=$cv")
done
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends "${named[@]}" >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>
#include <vector>
constexpr int kColumns = 12, kRows = 9, kSquare = 40;  // 11x8 inner corners

// The board on white paper, seen from eight sides.
cv::Mat Seen(int side, cv::Matx33d& picture_from_board) {
  cv::Mat board((kRows + 2) * kSquare, (kColumns + 2) * kSquare, CV_8UC1, cv::Scalar(255));
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      if ((x + y) % 2 == 0) board(cv::Rect((x + 1) * kSquare, (y + 1) * kSquare, kSquare, kSquare)) = 0;
  const float w = board.cols, h = board.rows, in = 90, out = 20;
  const auto inset = [&](int corner) { return ((side >> corner % 3) & 1) ? in : out; };
  const std::vector<cv::Point2f> from{{0, 0}, {w, 0}, {w, h}, {0, h}},
      to{{inset(0), inset(1)}, {w - inset(1), inset(2)}, {w - inset(2), h - inset(0)}, {inset(1), h - inset(2)}};
  picture_from_board = cv::Matx33d(cv::getPerspectiveTransform(from, to));
  cv::Mat seen;
  cv::warpPerspective(board, seen, picture_from_board, board.size(), cv::INTER_AREA, cv::BORDER_CONSTANT, cv::Scalar(200));
  cv::GaussianBlur(seen, seen, {}, 1);
  return seen;
}

int main() {
  int exact = 0, part = 0;
  std::set<std::pair<int, int>> places;
  for (int side = 0; side < 8; ++side) {
    cv::Matx33d picture_from_board;
    const cv::Mat seen = Seen(side, picture_from_board);
    std::vector<cv::Point2f> corners;
    exact += cv::findChessboardCornersSB(seen, {kColumns - 1, kRows - 1}, corners);
    for (const cv::Size size : {cv::Size(8, 5), cv::Size(9, 6), cv::Size(10, 7)}) {
      if (!cv::findChessboardCornersSB(seen, size, corners)) continue;
      ++part;
      std::vector<cv::Point2f> first;
      cv::perspectiveTransform(std::vector<cv::Point2f>{corners[0]}, first, picture_from_board.inv());
      places.emplace(cvRound(first[0].x / kSquare), cvRound(first[0].y / kSquare));
    }
  }
  std::printf("   of 8 pictures of 11x8 inner corners 11x8 is found in %d; of 24 searches for fewer %d succeed, which begin at", exact, part);
  for (const auto& [x, y] : places) std::printf(" %d,%d", x - 1, y - 1);
  std::printf("\n");
  return exact == 8 && part >= 3 && places.size() >= 2 ? 0 : 1;
}
CPP
g++ -I root/usr/include/opencv4 try.cpp -o try -L "$libraries" -lopencv_calib3d -lopencv_imgproc -lopencv_core \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

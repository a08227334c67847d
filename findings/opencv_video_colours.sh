#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), VideoCapture with FFmpeg 5.1, against FFmpeg's own program.
# Expected: the colours of a video are those that its stream names, as with FFmpeg's program, whose libraries OpenCV uses.
# Seen:     OpenCV tells FFmpeg's scaler no matrix, so that all is taken for BT.601: patches are 26 levels off where the
#           stream says BT.709, as nearly all HD videos do, in limited and in full range. BT.601 is right.
# Matters:  red turns to orange, green to another green, and greys stay grey: white balance and a grey card show nothing.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends 'ffmpeg=7:5.1*' \
  libopencv-core-dev=$cv libopencv-core406=$cv libopencv-videoio-dev=$cv libopencv-videoio406=$cv libopencv-imgcodecs-dev=$cv \
  libopencv-imgcodecs406=$cv libopencv-imgproc-dev=$cv libopencv-imgproc406=$cv >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu
ffmpeg() { LD_LIBRARY_PATH=$libraries "$work/root/usr/bin/ffmpeg" -v error -y "$@"; }

cat >first.cpp <<'CPP'
#include <cstdio>
#include <opencv2/videoio.hpp>
// The middle of each patch of the first picture: red, green, blue.
int main(int, char** argv) {
  cv::VideoCapture video(argv[1], cv::CAP_FFMPEG);
  cv::Mat frame;
  if (!video.read(frame)) return 77;
  for (int x = 32; x < frame.cols; x += 64) {
    const cv::Vec3b color = frame.at<cv::Vec3b>(frame.rows / 2, x);
    std::printf("%d %d %d\n", color[2], color[1], color[0]);
  }
}
CPP
g++ -I root/usr/include/opencv4 first.cpp -o first -L "$libraries" -lopencv_videoio -lopencv_core \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || { head -n 3 errors.txt >&2; exit 77; }

patches="200 50 50
50 200 50
50 50 200
200 200 50
128 128 128"
# One row of patches as a binary picture, enlarged to 64 pixels each without mixing.
{ printf 'P6 5 1 255\n'; for number in $patches; do printf "\\$(printf %o "$number")"; done; } >patches.ppm
worst() { paste -d ' ' - <(echo "$patches") | awk '{ for (i = 1; i <= 3; i++) { d = $i - $(i + 3); if (d < 0) d = -d; if (d > most) most = d } } END { print most + 0 }'; }
holds=0
for video in "smpte170m tv" "bt709 tv" "bt709 pc"; do
  read -r matrix range <<< "$video"
  ffmpeg -i patches.ppm -vf "scale=320:64:flags=neighbor:out_color_matrix=$matrix:out_range=$range,format=yuv444p,loop=5:1" \
    -colorspace "$matrix" -color_primaries "$matrix" -color_trc "$matrix" -color_range "$range" -c:v libx264 -qp 1 clip.mp4 || exit 77
  ffmpeg -i clip.mp4 -frames:v 1 -vf "crop=iw-32:1:32:32,scale=5:1:flags=neighbor" -f rawvideo -pix_fmt rgb24 shown.raw || exit 77
  shown=$(od -An -v -t u1 -w3 shown.raw | worst)
  read=$(LD_LIBRARY_PATH=$libraries ./first clip.mp4 | worst) || exit 77
  echo "   $matrix, range $range: the worst patch is $shown levels off in FFmpeg's picture, $read in OpenCV's"
  [ "$shown" -le 3 ] || holds=1
  if [ "$matrix" = smpte170m ]; then [ "$read" -le 3 ] || holds=1; else [ "$read" -ge 15 ] || holds=1; fi
done
exit $holds

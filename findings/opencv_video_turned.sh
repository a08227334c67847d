#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), VideoCapture with FFmpeg 5.1, against FFmpeg's own program.
# Expected: OpenCV turns a video by the matrix of its stream by default (CAP_PROP_ORIENTATION_AUTO, since 4.5), so that a
#           telephone's portrait video stands upright, as FFmpeg and players show it.
# Seen:     of a quarter turn it has the right size and stands on its head: OpenCV turns the other way, 90 degrees for 270
#           and 270 for 90. A half turn is right. CAP_PROP_ORIENTATION_META says the angle that it took.
# Matters:  width and height are those that one expects, and faces alone tell up from down. A set of photographs upside down
#           is consistent in itself: poses are found, and the lens's centre is that of the turned picture.
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
ffmpeg() { LD_LIBRARY_PATH=$libraries "$work/root/usr/bin/ffmpeg" "$@"; }
ffmpeg -version 2>/dev/null | head -n 1 || exit 77

cat >first.cpp <<'CPP'
#include <cstdio>
#include <opencv2/videoio.hpp>
// The first picture as bytes of blue, green, red; its size and the angle to stderr.
int main(int, char** argv) {
  cv::VideoCapture video(argv[1], cv::CAP_FFMPEG);
  cv::Mat frame;
  if (!video.read(frame)) return 77;
  std::fwrite(frame.data, 1, frame.total() * frame.elemSize(), stdout);
  std::fprintf(stderr, "%dx%d, angle %g", frame.cols, frame.rows, video.get(cv::CAP_PROP_ORIENTATION_META));
}
CPP
g++ -I root/usr/include/opencv4 first.cpp -o first -L "$libraries" -lopencv_videoio -lopencv_core \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || { head -n 3 errors.txt >&2; exit 77; }

ffmpeg -v error -f lavfi -i testsrc2=size=320x240:rate=30:duration=0.2 -pix_fmt yuv420p -c:v libx264 -qp 4 plain.mp4 || exit 77
# The mean difference of two pictures of bytes, in levels.
difference() { cmp -l "$1" "$2" | awk -v all="$(stat -c %s "$1")" '
  function number(octal) { return substr(octal, 1, length(octal) - 2) * 64 + substr(octal, length(octal) - 1, 1) * 8 + substr(octal, length(octal)) }
  { d = number(sprintf("%03d", $2)) - number(sprintf("%03d", $3)); sum += d < 0 ? -d : d } END { printf "%.0f", sum / all }'; }
holds=0
for angle in 90 180 270; do
  ffmpeg -v error -i plain.mp4 -c copy -metadata:s:v:0 rotate=$angle turned.mp4 -y || exit 77
  ffmpeg -v error -i turned.mp4 -frames:v 1 -f rawvideo -pix_fmt bgr24 shown.raw -y || exit 77
  ffmpeg -v error -i turned.mp4 -vf hflip,vflip -frames:v 1 -f rawvideo -pix_fmt bgr24 head.raw -y || exit 77
  LD_LIBRARY_PATH=$libraries ./first turned.mp4 >read.raw 2>said.txt || exit 77
  upright=$(difference read.raw shown.raw) on_its_head=$(difference read.raw head.raw)
  echo "   rotate=$angle: OpenCV gives $(cat said.txt); $upright levels from what FFmpeg shows, $on_its_head from that on its head"
  case $angle in
    180) [ "$upright" -le 3 ] || holds=1 ;;
    *) [ "$upright" -gt 20 ] && [ "$on_its_head" -le 3 ] || holds=1 ;;
  esac
done
exit $holds

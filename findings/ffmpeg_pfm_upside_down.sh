#!/usr/bin/env bash
# Version:  FFmpeg 5.1 (Debian 12), its decoder and encoder of PFM; against a build of July 2023 (npm:
#           @ffprobe-installer/linux-x64 5.2.0), Netpbm 11.01 and OpenCV 4.6 (Debian 12).
# Expected: the rows of a PFM stand in the file from the bottom up, as Debevec and Netpbm describe the format, and a decoder
#           gives them from the top down, as of every other format.
# Seen:     FFmpeg 5.1 gives and writes them in the order of the file: pictures of others are upside down, and so are its own
#           for others. Netpbm and OpenCV turn the rows, and FFmpeg of 2023 does when it reads. (Netpbm's page knows of a
#           second PFM, that of Photoshop, whose rows stand from the top down; no header tells the two apart.)
# Matters:  maps of depth and of disparity are kept as PFM. The picture has the right size and values, in the wrong rows.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
npm install --silent --no-audit --no-fund --prefix . @ffprobe-installer/linux-x64@5.2.0 >/dev/null 2>&1 || exit 77
newer=$work/node_modules/@ffprobe-installer/linux-x64/ffprobe
mkdir -p debs/partial
cv=4.6.0+dfsg-12
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends 'ffmpeg=7:5.1*' \
  'libavcodec59=7:5.1*' 'netpbm=2:11.01*' 'libnetpbm11=2:11.01*' libopencv-core-dev=$cv libopencv-core406=$cv \
  libopencv-imgcodecs-dev=$cv libopencv-imgcodecs406=$cv libopencv-imgproc406=$cv >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
export LD_LIBRARY_PATH=$work/root/usr/lib/x86_64-linux-gnu
ffmpeg=$work/root/usr/bin/ffmpeg
"$ffmpeg" -version 2>/dev/null | head -n 1 || exit 77
"$newer" -version 2>/dev/null | head -n 1 || exit 77

cat >rows.cpp <<'CPP'
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
int main(int, char** argv) {
  const cv::Mat read = cv::imread(argv[1], cv::IMREAD_UNCHANGED);
  for (int y = 0; y < read.rows; ++y)
    std::printf("%.1f ", read.type() == CV_32FC1 ? read.at<float>(y, 0) : -1.f);
}
CPP
g++ -I root/usr/include/opencv4 rows.cpp -o rows -L "$LD_LIBRARY_PATH" -lopencv_imgcodecs -lopencv_core \
  -Wl,-rpath-link,"$LD_LIBRARY_PATH" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }

# Three rows of two samples, little-endian. In the order of the file: 0.2, 0.4, 0.6.
sample() { printf "$1$1"; }
{ printf 'Pf\n2 3\n-1.0\n'; sample '\xcd\xcc\x4c\x3e'; sample '\xcd\xcc\xcc\x3e'; sample '\x9a\x99\x19\x3f'; } >stored.pfm
# The rows of a picture from the top down, of bytes too as parts of 1.
in_parts() { awk '{ for (i = 1; i <= NF; i += 2) printf "%.1f ", $i / '"$1"' }'; }
ffmpeg_rows=$("$ffmpeg" -v error -i stored.pfm -f rawvideo -pix_fmt grayf32le - | od -A n -v -w24 -t f4 | in_parts 1)
netpbm_rows=$("$work/root/usr/bin/pfmtopam" stored.pfm | tail -c 6 | od -A n -v -t u1 | in_parts 255)
opencv_rows=$(./rows stored.pfm)
newer_rows=$(for y in 0 1 2; do
  "$newer" -v error -f lavfi -i "movie=stored.pfm,format=gray,crop=2:1:0:$y:exact=1,signalstats" \
    -show_entries frame_tags=lavfi.signalstats.YAVG -of csv=p=0
done | awk '{ printf "%.1f ", $1 / 255 }')
echo "   rows in the file 0.2 0.4 0.6; from the top down, expected 0.6 0.4 0.2; seen: FFmpeg 5.1 ${ffmpeg_rows% };" \
  "FFmpeg of 2023 ${newer_rows% }; Netpbm ${netpbm_rows% }; OpenCV ${opencv_rows% }"

# The same picture from the top down, 0.2, 0.4, 0.6, written as PFM by FFmpeg 5.1.
{ printf 'P5\n2 3\n255\n'; printf '\x33\x33\x66\x66\x99\x99'; } >top_down.pgm
"$ffmpeg" -v error -i top_down.pgm -pix_fmt grayf32le written.pfm || exit 77
written_rows=$(./rows written.pfm)
echo "   written as PFM by FFmpeg 5.1 and read by OpenCV, expected 0.2 0.4 0.6; seen: ${written_rows% }"
[ "$ffmpeg_rows" = "0.2 0.4 0.6 " ] && [ "$newer_rows" = "0.6 0.4 0.2 " ] && [ "$netpbm_rows" = "0.6 0.4 0.2 " ] &&
  [ "$opencv_rows" = "0.6 0.4 0.2 " ] && [ "$written_rows" = "0.6 0.4 0.2 " ]

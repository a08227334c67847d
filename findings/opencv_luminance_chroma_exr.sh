#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), its reader of OpenEXR; OpenEXR 3.1 writes the file and reads it too.
# Expected: a luminance-chroma EXR (channels Y, RY, BY), which OpenCV reads without a word, has the colours that
#           OpenEXR's own RgbaInputFile gives.
# Seen:     red and blue are right, green is not: 0.68 for 0.58 in a green, below zero in a red. The numbers are those
#           of a formula that takes the y coordinates of the primaries (0.64 0.33 ...) for their shares of the luminance.
# Matters:  a grey picture looks right, so a test with a grey card passes; colours are wrong, and no error says so.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12 exr=3.1.5*
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libopencv-core-dev=$cv libopencv-core406=$cv libopencv-imgcodecs-dev=$cv libopencv-imgcodecs406=$cv \
  libopenexr-dev="$exr" libopenexr-3-1-30="$exr" libimath-dev="3.1.6*" libimath-3-1-29="3.1.6*" >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <OpenEXR/ImfRgbaFile.h>

#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <vector>
int main() {
  const float colours[3][3] = {{0.58f, 0.03f, 0.03f}, {0.03f, 0.58f, 0.03f}, {0.2f, 0.2f, 0.2f}};
  int wrong = 0, grey_wrong = 0;
  for (const auto& c : colours) {
    std::vector<Imf::Rgba> pixels(64 * 64, Imf::Rgba(c[0], c[1], c[2])), back(64 * 64);
    {
      Imf::RgbaOutputFile out("yc.exr", Imf::Header(64, 64), Imf::WRITE_YC);
      out.setFrameBuffer(pixels.data(), 1, 64);
      out.writePixels(64);
    }
    {
      Imf::RgbaInputFile in("yc.exr");
      in.setFrameBuffer(back.data(), 1, 64);
      in.readPixels(0, 63);
    }
    const cv::Mat read = cv::imread("yc.exr", cv::IMREAD_UNCHANGED);
    if (read.type() != CV_32FC3) {
      std::puts("   OpenCV does not read it");
      return 1;
    }
    const cv::Vec3f got = read.at<cv::Vec3f>(32, 32);
    const Imf::Rgba own = back[32 * 64 + 32];
    std::printf("   written %.2f %.2f %.2f  OpenEXR %.2f %.2f %.2f  OpenCV %.2f %.2f %.2f\n", c[0], c[1], c[2],
                float(own.r), float(own.g), float(own.b), got[2], got[1], got[0]);
    if (std::abs(own.g - c[1]) > 0.01f) return 1;
    const bool off = std::abs(got[1] - c[1]) > 0.05f;
    c[0] == c[1] ? grey_wrong += off : wrong += off;
  }
  return wrong == 2 && grey_wrong == 0 ? 0 : 1;
}
CPP
g++ -I root/usr/include/opencv4 -I root/usr/include -I root/usr/include/OpenEXR -I root/usr/include/Imath \
  try.cpp -o try -L "$libraries" \
  -lopencv_imgcodecs -lopencv_core -lOpenEXR -lImath -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries OPENCV_IO_ENABLE_OPENEXR=1 ./try

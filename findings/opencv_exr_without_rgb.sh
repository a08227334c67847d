#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), its reader of OpenEXR.
# Expected: an EXR in whose first part there is no R, G, B or Y, such as a map of depth (Z) or a file whose picture is in its
#           second part, is refused, as one is whose channels bear a layer's name ("beauty.R").
# Seen:     imread succeeds and gives a grey picture of the right size, all of it 0. The layered one is refused.
# Matters:  success and the right size are what a program checks; it goes on with black.
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
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>

#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>
using Names = std::vector<std::string>;
void Write(const char* path, const std::vector<Names>& parts) {
  static std::vector<float> samples(64 * 48, 0.5f);
  std::vector<Imf::Header> headers;
  for (const Names& names : parts) {
    Imf::Header header(64, 48);
    header.setName("part" + std::to_string(headers.size()));
    header.setType(Imf::SCANLINEIMAGE);
    for (const auto& name : names) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    headers.push_back(header);
  }
  Imf::MultiPartOutputFile file(path, headers.data(), int(headers.size()));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Imf::FrameBuffer frame;
    for (const auto& name : parts[i])
      frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(samples.data()), 4, 4 * 64));
    Imf::OutputPart part(file, int(i));
    part.setFrameBuffer(frame);
    part.writePixels(48);
  }
}
std::string Seen(const char* path) {
  const cv::Mat read = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (read.empty()) return "refused";
  double least = 0, most = 0;
  cv::minMaxIdx(read.reshape(1), &least, &most);
  return std::to_string(read.cols) + "x" + std::to_string(read.rows) + "x" + std::to_string(read.channels()) + " of " +
         std::to_string(most).substr(0, 3);
}
int main() {
  Write("depth.exr", {{"Z"}});
  Write("second.exr", {{"Z"}, {"R", "G", "B"}});
  Write("layer.exr", {{"beauty.R", "beauty.G", "beauty.B"}});
  Write("first.exr", {{"R", "G", "B"}});
  const std::string depth = Seen("depth.exr"), second = Seen("second.exr"), layer = Seen("layer.exr"),
                    first = Seen("first.exr");
  std::printf(
      "   all samples are 0.5. R, G, B: %s; Z alone: %s; Z, and R, G, B in the second part: %s; beauty.R, G, B: %s\n",
      first.c_str(), depth.c_str(), second.c_str(), layer.c_str());
  return first == "64x48x3 of 0.5" && depth == "64x48x1 of 0.0" && second == "64x48x1 of 0.0" && layer == "refused" ? 0
                                                                                                                    : 1;
}
CPP
g++ -I root/usr/include/opencv4 -I root/usr/include -I root/usr/include/OpenEXR -I root/usr/include/Imath \
  try.cpp -o try -L "$libraries" \
  -lopencv_imgcodecs -lopencv_core -lOpenEXR -lImath -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries OPENCV_IO_ENABLE_OPENEXR=1 ./try 2>/dev/null

#!/usr/bin/env bash
# Version:  OpenEXR 3.1 (Debian 12), DWAA compression.
# Expected: the compression is lossy or not by the type of a channel, and a float channel keeps the range of floats.
# Seen:     by its name. The same numbers lose bits as "Y", "R" or "depth.Y", and none as "Z", "depth.Z" or "disparity".
#           A float channel named "R" or "Y" is cut to half floats on its way: 1e6 comes back below 65505, 5e-9 as 0.
# Matters:  one channel of depth is often named "Y", as OpenCV does; metres or counts in it are changed, and large ones cut.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
exr=3.1.5*
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libopenexr-dev="$exr" libopenexr-3-1-30="$exr" libimath-dev='3.1.6*' libimath-3-1-29='3.1.6*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>

#include <cmath>
#include <cstdio>
#include <vector>
struct Back {
  int changed = 0;
  float first = 0;
};
Back WrittenAndRead(const char* name, float scale) {
  std::vector<float> a(64 * 64), b(64 * 64);
  for (int i = 0; i < 64 * 64; ++i) a[i] = scale * (1 + 0.4f * std::sin(i % 64 * 0.1f) * std::cos(i / 64 * 0.13f));
  const auto frame = [&](std::vector<float>& v) {
    Imf::FrameBuffer f;
    f.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(v.data()), 4, 4 * 64));
    return f;
  };
  {
    Imf::Header header(64, 64);
    header.compression() = Imf::DWAA_COMPRESSION;
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    Imf::OutputFile out("d.exr", header);
    out.setFrameBuffer(frame(a));
    out.writePixels(64);
  }
  {
    Imf::InputFile in("d.exr");
    in.setFrameBuffer(frame(b));
    in.readPixels(0, 63);
  }
  Back back{0, b[0]};
  for (int i = 0; i < 64 * 64; ++i) back.changed += a[i] != b[i];
  return back;
}
int main() {
  bool holds = true;
  for (const char* name : {"R", "Y", "depth.Y", "Z", "depth.Z", "disparity"}) {
    const Back back = WrittenAndRead(name, 1);
    std::printf("   float channel %-10s %4d of 4096 numbers changed\n", name, back.changed);
    const char last = name[std::char_traits<char>::length(name) - 1];
    holds &= last == 'R' || last == 'Y' ? back.changed > 2000 : back.changed == 0;
  }
  const float large = WrittenAndRead("R", 1e6f).first, small = WrittenAndRead("R", 5e-9f).first;
  std::printf("   float channel R: 1e6 comes back as %g, 5e-9 as %g\n", large, small);
  return holds && large < 65505 && small == 0 ? 0 : 1;
}
CPP
g++ -I root/usr/include -I root/usr/include/OpenEXR -I root/usr/include/Imath try.cpp -o try -L "$libraries" -lOpenEXR -lImath \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

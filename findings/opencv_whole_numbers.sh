#!/usr/bin/env bash
# Version:  OpenCV 4.6 (Debian 12), FileStorage (YAML and JSON).
# Expected: a whole number that an int does not hold is read as a real number or refused. JSON knows no octal numbers.
# Seen:     a whole number is an int modulo 2^32: 3000000000 is -1294967296, a stamp in nanoseconds is any number. The same
#           with ".0" at its end is right. 010 is eight, as in old YAML, but in JSON too; 080 is refused in both.
# Matters:  stamps in nanoseconds, serial numbers and counts of bytes in a calibration are other numbers without an error.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libopencv-core-dev=$cv libopencv-core406=$cv >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <cstdio>
#include <opencv2/core.hpp>
#include <string>
double Read(const std::string& number, bool json) {
  const std::string text = json ? "{\"a\": " + number + ", \"z\": 1}" : "%YAML:1.0\n---\na: " + number + "\nz: 1\n";
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY |
                                         (json ? cv::FileStorage::FORMAT_JSON : cv::FileStorage::FORMAT_YAML));
    return static_cast<double>(file["a"]);
  } catch (const cv::Exception&) {
    return -77;
  }
}
int main() {
  bool holds = true;
  for (const bool json : {false, true}) {
    const double big = Read("3000000000", json), real = Read("3000000000.0", json),
                 stamp = Read("1403636579763555584", json), zero = Read("010", json), eighty = Read("080", json);
    std::printf("   %s: 3000000000 is %.0f, 3000000000.0 is %.0f, 1403636579763555584 is %.0f, 010 is %.0f, 080 %s\n",
                json ? "JSON" : "YAML", big, real, stamp, zero, eighty == -77 ? "is refused" : "is read");
    holds &= big == 3000000000. - 4294967296. && real == 3000000000. && stamp != 1403636579763555584. && zero == 8 &&
             eighty == -77;
  }
  return holds ? 0 : 1;
}
CPP
g++ -I root/usr/include/opencv4 try.cpp -o try -L "$libraries" -lopencv_core -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try 2>/dev/null

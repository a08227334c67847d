#!/usr/bin/env bash
# Version:  ExifTool 12.57, Exiv2 0.27.6, OpenCV 4.6, ImageMagick 6.9.11 (Debian 12).
# Expected: both tools write the orientation of a PNG into the same place, and a reader that turns PNGs turns the files of
#           both.
# Seen:     ExifTool writes the chunk eXIf, Exiv2 a zTXt "Raw profile type exif"; each tool reads both. OpenCV's imread turns
#           by the first and not by the second; ImageMagick's -auto-orient by the second and not by the first.
# Matters:  two programs that both say "PNG turned by Exif" show the same file differently, whichever tool has written it.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libopencv-core-dev=$cv libopencv-core406=$cv libopencv-imgcodecs-dev=$cv libopencv-imgcodecs406=$cv \
  libopencv-imgproc406=$cv \
  'libimage-exiftool-perl=12.57*' 'exiv2=0.27.6*' 'libexiv2-27=0.27.6*' 'imagemagick-6.q16=8:6.9.11*' \
  'libmagickcore-6.q16-6=8:6.9.11*' 'libmagickwand-6.q16-6=8:6.9.11*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
export LD_LIBRARY_PATH=$work/root/usr/lib/x86_64-linux-gnu
export PERL5LIB=$work/root/usr/share/perl5
tools=$work/root/usr/bin
convert=$tools/convert-im6.q16

cat >size.cpp <<'CPP'
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
int main(int, char** argv) {
  const cv::Mat read = cv::imread(argv[1]);
  std::printf("%dx%d", read.cols, read.rows);
}
CPP
g++ -I root/usr/include/opencv4 size.cpp -o size -L "$LD_LIBRARY_PATH" -lopencv_imgcodecs -lopencv_core \
  -Wl,-rpath-link,"$LD_LIBRARY_PATH" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }

"$convert" -size 96x64 gradient:red-blue -strip plain.png || exit 77
cp plain.png exiftool.png; cp plain.png exiv2.png
"$tools/exiftool" -q -overwrite_original -n -Orientation=6 exiftool.png 2>/dev/null || exit 77
"$tools/exiv2" -M'set Exif.Image.Orientation 6' exiv2.png || exit 77
seen=""
for file in exiftool exiv2; do
  chunks=$(grep -a -o -E 'eXIf|Raw profile type exif' $file.png | tr '\n' ' ')
  by_exiftool=$("$tools/exiftool" -n -s3 -Orientation $file.png)
  by_exiv2=$("$tools/exiv2" -Pv -K Exif.Image.Orientation $file.png)
  opencv=$(./size $file.png)
  magick=$("$convert" $file.png -auto-orient -format '%wx%h' info:)
  echo "   $file.png has $chunks: orientation by ExifTool $by_exiftool, by Exiv2 $by_exiv2; OpenCV shows $opencv, ImageMagick $magick"
  seen+="$by_exiftool $by_exiv2 $opencv $magick;"
done
[ "$seen" = "6 6 64x96 96x64;6 6 96x64 64x96;" ]

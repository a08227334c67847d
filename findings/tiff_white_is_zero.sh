#!/usr/bin/env bash
# Version:  OpenImageIO 2.4.7, OpenCV 4.6, Pillow 9.4, ImageMagick 6.9.11 (Debian 12).
# Expected: a reader that turns a white-is-zero TIFF of 8 bits into black-is-zero does the same with 16 bits, or refuses it.
# Seen:     OpenImageIO, OpenCV and Pillow do so with 8 bits and give 16 bits as a negative, without a word. OpenImageIO says
#           "PhotometricInterpretation 0" of both, so that mark cannot tell which of them is still to be turned.
#           ImageMagick has both right.
# Matters:  scanners and scientific cameras write such files; who tests the reader with 8 bits takes negatives for pictures.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null && [ -x /usr/bin/python3 ] || exit 77
mkdir -p debs/partial
cv=4.6.0+dfsg-12
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libopencv-core-dev=$cv libopencv-core406=$cv libopencv-imgcodecs-dev=$cv libopencv-imgcodecs406=$cv \
  libopencv-imgproc406=$cv \
  'openimageio-tools=2.4.7.1*' 'libopenimageio2.4=2.4.7.1*' 'python3-pil=9.4.0*' 'imagemagick-6.q16=8:6.9.11*' \
  'libmagickcore-6.q16-6=8:6.9.11*' 'libmagickwand-6.q16-6=8:6.9.11*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
export LD_LIBRARY_PATH=$work/root/usr/lib/x86_64-linux-gnu
export PYTHONPATH=$work/root/usr/lib/python3/dist-packages

# 32x32 samples of one grey: the file says 60 (of 255) below its white, that is 195 by its own words.
/usr/bin/python3 - <<'PY' || exit 77
import struct
for bits in 8, 16:
    sample = struct.pack('<B' if bits == 8 else '<H', 60 if bits == 8 else 60 * 257)
    data = sample * 1024
    tags = [(256, 3, 32), (257, 3, 32), (258, 3, bits), (259, 3, 1), (262, 3, 0), (273, 4, 8), (277, 3, 1),
            (278, 3, 32), (279, 4, len(data))]
    directory = struct.pack('<H', len(tags)) + b''.join(struct.pack('<HHII', t, k, 1, v) for t, k, v in tags) + bytes(4)
    open('w%d.tif' % bits, 'wb').write(struct.pack('<2sHI', b'II', 42, 8 + len(data)) + data + directory)
PY
cat >value.cpp <<'CPP'
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
int main(int, char** argv) {
  const cv::Mat read = cv::imread(argv[1], cv::IMREAD_UNCHANGED);
  std::printf("%d", read.empty() ? -1 : read.depth() == CV_8U ? read.at<uchar>(9, 9) : read.at<ushort>(9, 9) / 257);
}
CPP
g++ -I root/usr/include/opencv4 value.cpp -o value -L "$LD_LIBRARY_PATH" -lopencv_imgcodecs -lopencv_core \
  -Wl,-rpath-link,"$LD_LIBRARY_PATH" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }

seen=""
for bits in 8 16; do
  whole=$((bits == 8 ? 1 : 257))
  oiio=$(root/usr/bin/oiiotool w$bits.tif --cut 1x1+9+9 -d uint8 -o oiio.ppm >/dev/null && tail -c 1 oiio.ppm | od -An -tu1 | tr -d ' ')
  said=$(root/usr/bin/oiiotool --info -v w$bits.tif | grep -o 'PhotometricInterpretation: .*')
  pillow=$(/usr/bin/python3 -c "from PIL import Image; print(Image.open('w$bits.tif').getpixel((9, 9)) // $whole)")
  magick=$(root/usr/bin/convert-im6.q16 w$bits.tif -crop 1x1+9+9 -depth 8 gray:- | od -An -tu1 | tr -d ' ')
  echo "   $bits bits, right is 195: OpenImageIO $oiio ($said), OpenCV $(./value w$bits.tif), Pillow $pillow, ImageMagick $magick"
  seen+="$oiio $(./value w$bits.tif) $pillow $magick;"
done
[ "$seen" = "195 195 195 195;60 60 60 195;" ]

#!/usr/bin/env bash
# Version:  FFmpeg 5.1 (Debian 12), its scaler.
# Expected: a grey picture that is converted to float planes of red, green and blue (gbrpf32le) is grey, as it is with the
#           planes of 8 and 16 bits, and as the one float plane (grayf32le) has its values.
# Seen:     it is green: red and blue are 0, and green is no longer the value either (0.61 for 20 of 255). A grey picture
#           converted to 8-bit RGB first, and then to float, is right.
# Matters:  float is what one asks for to lose nothing; who tests the path with colours sees no fault.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  'ffmpeg=7:5.1*' 'libswscale6=7:5.1*' 'libavfilter8=7:5.1*' 'libavcodec59=7:5.1*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
ffmpeg() { LD_LIBRARY_PATH=$work/root/usr/lib/x86_64-linux-gnu "$work/root/usr/bin/ffmpeg" "$@"; }
ffmpeg -version 2>/dev/null | head -n 1 || exit 77

# 64x64 samples of one grey, 20 of 255.
head -c 4096 /dev/zero | tr '\0' '\024' >grey.raw
first() { # the first sample of each plane, after a chain of filters
  ffmpeg -v error -f rawvideo -pix_fmt gray -s 64x64 -i grey.raw -vf "$1" -f rawvideo - >planes.raw || exit 1
  local planes=$(($(stat -c %s planes.raw) / 4096 / $3)) plane
  for ((plane = 0; plane < planes; plane++)); do
    od -An -t "$2" -j $((plane * 4096 * $3)) -N "$3" planes.raw
  done | awk -v most="$4" '{ printf "%s%.3f", (NR > 1 ? " " : ""), $1 / most }'
}
one=$(first format=grayf32le f4 4 1)
bytes=$(first format=gbrp u1 1 255)
straight=$(first format=gbrpf32le f4 4 1)
around=$(first format=rgb24,format=gbrpf32le f4 4 1)
echo "   0.078 as grey float: $one; green, blue, red as bytes: $bytes; as float: $straight; by way of rgb24: $around"
[ "$one" = 0.078 ] && [ "$bytes" = "0.078 0.078 0.078" ] && \
  [ "$around" = "0.078 0.078 0.078" ] && [ "$straight" != "$around" ]

#!/usr/bin/env bash
# Version:  COLMAP 3.8 (Debian 12); the same code stands in 4.x (Camera::IsUndistorted()).
# Expected: image_undistorter makes pinhole pictures of an OPENCV_FISHEYE camera, whatever its coefficients: with all of them
#           zero the lens is still equidistant, r = f theta, and bends lines.
# Seen:     coefficients below 1e-8 count as "undistorted", a fisheye's too: the picture is copied byte for byte and the model
#           stays OPENCV_FISHEYE in the folder of undistorted pictures. With k1 = 2e-8 it becomes a PINHOLE.
# Matters:  trainers that take that folder for pinholes are off by hundreds of pixels at the rim, and drawn sets and equidistant
#           lenses have such coefficients.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends 'colmap=3.8*' \
  >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu
colmap() { QT_QPA_PLATFORM=offscreen LD_LIBRARY_PATH=$libraries "$work/root/usr/bin/colmap" "$@"; }
colmap help 2>/dev/null | grep -m 1 '^COLMAP 3.8' || exit 77

mkdir -p images
awk 'BEGIN { print "P3 200 150 255"; for (y = 0; y < 150; ++y) for (x = 0; x < 200; ++x)
  print int(x * 255 / 199), int(y * 255 / 149), (int(x / 10) + int(y / 10)) % 2 * 255 }' \
  >images/a.ppm
holds=0
for k1 in 0 2e-8; do
  mkdir -p model_$k1 text_$k1
  echo "1 OPENCV_FISHEYE 200 150 100 100 100 75 $k1 0 0 0" >model_$k1/cameras.txt
  printf '1 1 0 0 0 0 0 0 1 a.ppm\n\n' >model_$k1/images.txt
  : >model_$k1/points3D.txt
  colmap image_undistorter --image_path images --input_path model_$k1 --output_path out_$k1 >said.txt 2>&1 ||
    { tail -n 3 said.txt >&2; exit 77; }
  colmap model_converter --input_path out_$k1/sparse --output_path text_$k1 --output_type TXT >/dev/null 2>&1 || exit 77
  model=$(awk '!/^#/ { print $2; exit }' text_$k1/cameras.txt)
  same=no; cmp -s images/a.ppm out_$k1/images/a.ppm && same=yes
  echo "   k1 = $k1: the undistorted model is $model, the picture is the given one byte for byte: $same"
  case $k1 in
    0) [ "$model" = OPENCV_FISHEYE ] && [ $same = yes ] || holds=1 ;;
    *) [ "$model" = PINHOLE ] && [ $same = no ] || holds=1 ;;
  esac
done
exit $holds

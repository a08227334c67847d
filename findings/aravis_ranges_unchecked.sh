#!/usr/bin/env bash
# Version:  Aravis 0.8.26 (Debian 12), its fake camera (in the library, no network).
# Expected: a value outside the bounds that the library itself tells for a feature is an error when it is set.
# Seen:     it is written, and the call succeeds: Width 1000000000 where 2048 is the most, and an exposure of 1e12 µs where
#           1e7 is the most goes through the camera's 32-bit register and reads back as 3.57e9. The check exists
#           (arv_device_set_range_check_policy) and is off by default.
# Matters:  what protects a user from a wrong value is the camera alone; a camera that takes the number modulo its register
#           exposes with another one, without an error.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  libaravis-dev=0.8.26-1 libaravis-0.8-0=0.8.26-1 'libglib2.0-dev=2.74.6*' 'libglib2.0-0=2.74.6*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu
glib="-I root/usr/include/glib-2.0 -I root/usr/lib/x86_64-linux-gnu/glib-2.0/include"

cat >try.cpp <<'CPP'
#include <arv.h>

#include <cstdio>
#include <initializer_list>
int main() {
  arv_enable_interface("Fake");
  ArvCamera* camera = arv_camera_new("Fake_1", nullptr);
  if (camera == nullptr) return 77;
  bool holds = true;
  for (const bool checked : {false, true}) {
    if (checked) arv_device_set_range_check_policy(arv_camera_get_device(camera), ARV_RANGE_CHECK_POLICY_ENABLE);
    GError *width_error = nullptr, *exposure_error = nullptr;
    gint64 least = 0, most = 0;
    double shortest = 0, longest = 0;
    arv_camera_get_integer_bounds(camera, "Width", &least, &most, nullptr);
    arv_camera_get_exposure_time_bounds(camera, &shortest, &longest, nullptr);
    arv_camera_set_integer(camera, "Width", 1000000000, &width_error);
    arv_camera_set_exposure_time(camera, 1e12, &exposure_error);
    std::printf("   %s: Width of at most %ld set to 1000000000: %s", checked ? "checked" : "default", long(most),
                width_error ? width_error->message : "no error");
    std::printf("; exposure of at most %g set to 1e12: %s", longest,
                exposure_error ? exposure_error->message : "no error");
    const double exposure = arv_camera_get_exposure_time(camera, nullptr);
    const gint64 width = arv_camera_get_integer(camera, "Width", nullptr);
    std::printf("; read back %ld and %g\n", long(width), exposure);
    if (checked)
      holds &= width_error != nullptr && exposure_error != nullptr;
    else
      holds &= width_error == nullptr && exposure_error == nullptr && width == 1000000000 && exposure > 3.5e9 &&
               exposure < 3.6e9;
    arv_camera_set_integer(camera, "Width", 512, nullptr);
    arv_camera_set_exposure_time(camera, 1e4, nullptr);
  }
  return holds ? 0 : 1;
}
CPP
g++ -I root/usr/include/aravis-0.8 $glib try.cpp -o try -L "$libraries" -laravis-0.8 -lgio-2.0 -lgobject-2.0 -lglib-2.0 \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

#!/usr/bin/env bash
# Version:  Aravis 0.8.26 (Debian 12), GigE Vision, its fake camera on the loopback device of a network namespace.
# Expected: where a camera's PayloadSize is 0 or less than what it sends, its frames fail (ARV_BUFFER_STATUS_SIZE_MISMATCH),
#           or none come.
# Seen:     they come with ARV_BUFFER_STATUS_SUCCESS, with the picture's width and height, and with 0 bytes of it or as many
#           as the buffer holds. n_failures stays 0; n_size_mismatch_errors counts the frames cut short, but not the empty
#           ones. (Buffers are made of arv_camera_get_payload bytes, as the library's own programs do. The fake camera's file
#           is its own but for the formula of PayloadSize; what it sends is whole.)
# Matters:  a status of success does not say that there are bytes: a program that goes by it and by width and height reads
#           past the end of the buffer. The size that arv_buffer_get_image_data gives is what says it.
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

# A network of its own: the camera is seen by nobody else, and no other camera by the program.
namespace=''
for way in "unshare -n" "unshare -r -n"; do
  [ -z "$namespace" ] && $way ip link set lo up 2>/dev/null && namespace=$way
done
[ -n "$namespace" ] || exit 77

cat >try.cpp <<'CPP'
#include <arv.h>

#include <cstdio>
#include <cstring>
#include <string>
struct Seen {
  int good = 0, bad = 0, width = 0, height = 0;
  std::size_t least = ~std::size_t{0}, most = 0;
  guint64 failures = 0, mismatches = 0;
  std::string description;
};
// The frames of a fake camera of this description, its own if "", or -1 good ones if there is no camera.
Seen Frames(const std::string& description, const char* serial) {
  Seen seen;
  const std::string path = std::string(serial) + ".xml";
  g_file_set_contents(path.c_str(), description.data(), gssize(description.size()), nullptr);
  ArvGvFakeCamera* device =
      arv_gv_fake_camera_new_full("127.0.0.1", serial, description.empty() ? nullptr : path.c_str());
  ArvCamera* camera = arv_gv_fake_camera_is_running(device) ? arv_camera_new("127.0.0.1", nullptr) : nullptr;
  ArvStream* stream = camera ? arv_camera_create_stream(camera, nullptr, nullptr, nullptr) : nullptr;
  if (stream == nullptr) {
    seen.good = -1;
    return seen;
  }
  std::size_t length = 0;
  const char* text = arv_device_get_genicam_xml(arv_camera_get_device(camera), &length);
  seen.description.assign(text, length);
  const guint payload = arv_camera_get_payload(camera, nullptr);
  for (int i = 0; i < 10; ++i) arv_stream_push_buffer(stream, arv_buffer_new(payload, nullptr));
  arv_camera_start_acquisition(camera, nullptr);
  for (int i = 0; i < 20; ++i) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 1000000);
    if (buffer == nullptr) continue;
    if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS) {
      std::size_t size = 0;
      arv_buffer_get_image_data(buffer, &size);
      ++seen.good;
      if (size < seen.least) seen.least = size;
      if (size > seen.most) seen.most = size;
      seen.width = arv_buffer_get_image_width(buffer);
      seen.height = arv_buffer_get_image_height(buffer);
    } else {
      ++seen.bad;
    }
    arv_stream_push_buffer(stream, buffer);
  }
  arv_camera_stop_acquisition(camera, nullptr);
  seen.failures = arv_stream_get_info_uint64_by_name(stream, "n_failures");
  seen.mismatches = arv_stream_get_info_uint64_by_name(stream, "n_size_mismatch_errors");
  std::printf(
      "   PayloadSize %u: %d frames of success, %d others; those of success are %dx%d, of %zu to %zu bytes; ",
      payload, seen.good, seen.bad, seen.width, seen.height, seen.least, seen.most);
  std::printf("n_failures %llu, n_size_mismatch_errors %llu\n", (unsigned long long)seen.failures,
              (unsigned long long)seen.mismatches);
  g_object_unref(stream);
  g_object_unref(camera);
  g_object_unref(device);
  return seen;
}
int main() {
  const Seen own = Frames("", "OWN");
  std::string zero = own.description;
  const std::size_t node = zero.find("Name=\"PayloadSize\""), from = zero.find("<Formula>", node),
                    to = zero.find("</Formula>", from);
  if (own.good < 0 || node == std::string::npos || from == std::string::npos || to == std::string::npos)
    return 77;
  zero.replace(from, to - from, "<Formula>0");
  std::string half = own.description;
  half.replace(from, to - from, "<Formula>131072");
  const std::size_t whole = std::size_t(own.width) * own.height;
  std::printf("   expected: with a PayloadSize of less than that there is no frame of success. Seen:\n");
  const Seen none = Frames(zero, "ZERO"), cut = Frames(half, "HALF");
  if (none.good < 0 || cut.good < 0) return 77;
  bool holds = own.good > 0 && own.bad == 0 && own.least == whole;
  holds &= none.good > 0 && none.bad == 0 && none.most == 0 && none.failures == 0 && none.mismatches == 0;
  holds &= cut.good > 0 && cut.bad == 0 && cut.most == 131072 && cut.failures == 0 && cut.mismatches > 0;
  for (const Seen& seen : {none, cut}) holds &= seen.width == own.width && seen.height == own.height;
  return holds ? 0 : 1;
}
CPP
g++ -I root/usr/include/aravis-0.8 $glib try.cpp -o try -L "$libraries" -laravis-0.8 -lgio-2.0 -lgobject-2.0 -lglib-2.0 \
  -Wl,-rpath-link,"$libraries" 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries $namespace sh -c 'ip link set lo up && timeout 60 ./try'

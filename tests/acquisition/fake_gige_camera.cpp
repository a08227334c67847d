// A GigE Vision camera for the tests of the client: Aravis's fake camera with pictures that tell which pixel
// is where. Arguments: SERIAL, LOSS (the share of stream packets that it swallows) and, where it is not
// 127.0.0.1, ADDRESS. Says "ready" when it listens and serves until it is killed.
//
//   Mono8     value (3 x + 5 y) mod 256
//   RGB8      red x mod 256, green y mod 256, blue 77
//   BayerRG8  red sites 200, green 120, blue 40
#include <arv.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace {

void Fill(ArvBuffer* buffer, void* /*user_data*/, guint32 /*exposure_us*/, guint32 /*gain*/,
          ArvPixelFormat format) {
  std::size_t size = 0;
  auto* out = static_cast<guint8*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
  const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
  const int left = arv_buffer_get_image_x(buffer), top = arv_buffer_get_image_y(buffer);
  for (int y = top; y < top + height; ++y)
    for (int x = left; x < left + width; ++x) switch (format) {
        case ARV_PIXEL_FORMAT_RGB_8_PACKED:
          *out++ = static_cast<guint8>(x);
          *out++ = static_cast<guint8>(y);
          *out++ = 77;
          break;
        case ARV_PIXEL_FORMAT_BAYER_RG_8:
          *out++ = y % 2 == 0 ? (x % 2 == 0 ? 200 : 120) : (x % 2 == 0 ? 120 : 40);
          break;
        case ARV_PIXEL_FORMAT_MONO_8:
          *out++ = static_cast<guint8>(3 * x + 5 * y);
          break;
        default:
          break;
      }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) return 2;
  ArvGvFakeCamera* camera = arv_gv_fake_camera_new(argc == 4 ? argv[3] : "127.0.0.1", argv[1]);
  if (!camera || !arv_gv_fake_camera_is_running(camera)) return 1;
  g_object_set(camera, "gvsp-lost-ratio", std::atof(argv[2]), nullptr);
  arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(camera), Fill, nullptr);
  std::puts("ready");
  std::fflush(stdout);
  for (;;) pause();
}

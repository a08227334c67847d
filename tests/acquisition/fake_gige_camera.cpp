// A GigE Vision camera for the tests of the client: Aravis's fake camera with pictures that tell which pixel
// is where. Arguments: SERIAL, LOSS (the share of stream packets that it swallows) and, where they are not
// 127.0.0.1 and Aravis's own, ADDRESS and DESCRIPTION (a GenICam file; full_camera.xml's registers are
// served). Says "ready" when it listens and serves until it is killed. SIGUSR1: it answers but sends no
// frames any more; SIGUSR2: it sends again.
//
//   Mono8     value (3 x + 5 y) mod 256
//   RGB8      red x mod 256, green y mod 256, blue 77
//   BayerRG8  red sites 200, green 120, blue 40
#include <arv.h>
#include <signal.h>
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

volatile sig_atomic_t asked_to_stream = -1;

// What a camera does by itself and Aravis's fake does not: says who controls it, loads user sets.
void ServeRegisters(ArvFakeCamera* camera) {
  constexpr guint32 kControl = 0xa00, kControllerPort = 0xa04, kControllerAddress = 0xa14;
  constexpr guint32 kUserSetLoad = 0x1040, kUserSetSelector = 0x1044, kUserSetLoaded = 0x1048;
  guint32 control = 0, load = 0, set = 0;
  arv_fake_camera_read_register(camera, kControl, &control);
  arv_fake_camera_write_register(camera, kControllerAddress, control ? 0x7f000001 : 0);
  arv_fake_camera_write_register(camera, kControllerPort, control ? 45678 : 0);
  arv_fake_camera_read_register(camera, kUserSetLoad, &load);
  if (load == 0) return;
  arv_fake_camera_read_register(camera, kUserSetSelector, &set);
  arv_fake_camera_write_register(camera, kUserSetLoaded, set);
  arv_fake_camera_write_register(camera, kUserSetLoad, 0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) return 2;
  const char* address = argc > 3 ? argv[3] : "127.0.0.1";
  const char* description = argc > 4 ? argv[4] : nullptr;
  ArvGvFakeCamera* camera = arv_gv_fake_camera_new_full(address, argv[1], description);
  if (!camera || !arv_gv_fake_camera_is_running(camera)) return 1;
  g_object_set(camera, "gvsp-lost-ratio", std::atof(argv[2]), nullptr);
  ArvFakeCamera* registers = arv_gv_fake_camera_get_fake_camera(camera);
  arv_fake_camera_set_fill_pattern(registers, Fill, nullptr);
  signal(SIGUSR1, [](int) { asked_to_stream = 0; });
  signal(SIGUSR2, [](int) { asked_to_stream = 1; });
  std::puts("ready");
  std::fflush(stdout);
  for (;;) {
    if (asked_to_stream >= 0) {
      arv_fake_camera_write_register(registers, ARV_FAKE_CAMERA_REGISTER_ACQUISITION,
                                     static_cast<guint32>(asked_to_stream));
      asked_to_stream = -1;
    }
    if (description) ServeRegisters(registers);
    usleep(5000);
  }
}

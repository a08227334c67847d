// A GigE Vision camera for the tests of the client: Aravis's fake camera with pictures that tell which pixel
// is where. Arguments: SERIAL, LOSS (the share of stream packets that it swallows) and, where they are not
// 127.0.0.1 and Aravis's own, ADDRESS and DESCRIPTION (a GenICam file; full_camera.xml's registers are
// served; its automatics go from what was set by hand to values of their own within a tenth of a second).
// Says "ready" when it listens and serves until it is killed. SIGUSR1: it answers but sends no frames any
// more; SIGUSR2: it sends again.
//
//   Mono8     value (3 x + 5 y) mod 256
//   RGB8      red x mod 256, green y mod 256, blue 77
//   BayerRG8  red sites 200, green 120, blue 40
#include <arpa/inet.h>
#include <arv.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

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

// Test packets, which the fake camera leaves out: of the size asked for, to the stream's receiver. The
// "network" swallows those of more than 4000 bytes.
void FireTestPacket(ArvFakeCamera* camera, const char* address) {
  constexpr guint32 kPacketSize = 0xd04, kReceiver = 0xd18, kPort = 0xd00;
  constexpr guint32 kFire = 0x80000000, kHeaders = 28;
  guint32 packet = 0, receiver = 0, port = 0;
  arv_fake_camera_read_register(camera, kPacketSize, &packet);
  if (!(packet & kFire)) return;
  arv_fake_camera_write_register(camera, kPacketSize, packet & ~kFire);
  arv_fake_camera_read_register(camera, kReceiver, &receiver);
  arv_fake_camera_read_register(camera, kPort, &port);
  const guint32 size = packet & 0xffff;
  if (size <= kHeaders || size > 4000) return;
  sockaddr_in from{}, to{};
  from.sin_family = to.sin_family = AF_INET;
  inet_pton(AF_INET, address, &from.sin_addr);
  to.sin_addr.s_addr = htonl(receiver);
  to.sin_port = htons(static_cast<guint16>(port));
  const int out = socket(AF_INET, SOCK_DGRAM, 0);
  const std::vector<char> bytes(size - kHeaders);
  bind(out, reinterpret_cast<sockaddr*>(&from), sizeof from);
  sendto(out, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  close(out);
}

// Automatics: 0 is off, 2 runs. What they move lies 0x2000 above what was set by hand.
void RunAutomatics(ArvFakeCamera* camera) {
  constexpr guint32 kRegistersAbove = 0x2000;
  struct Moved {
    guint32 automatic, by_hand, goal;
  };
  constexpr Moved kMoved[] = {
      {0x1030, 0x120, 5000},   // exposure, us
      {0x1034, 0x110, 120},    // gain, tenths of a decibel
      {0x1038, 0x1010, 32},    // black level, quarters
      {0x1018, 0x1020, 2000},  // red, thousandths
      {0x1018, 0x1028, 1250},  // blue
  };
  for (const Moved& moved : kMoved) {
    guint32 mode = 0, value = 0;
    arv_fake_camera_read_register(camera, moved.automatic, &mode);
    arv_fake_camera_read_register(camera, moved.by_hand + (mode ? kRegistersAbove : 0), &value);
    const auto left = static_cast<gint64>(moved.goal) - value;
    if (mode) value = static_cast<guint32>(value + (left / 2 ? left / 2 : left));
    arv_fake_camera_write_register(camera, moved.by_hand + kRegistersAbove, value);
  }
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
    if (description) RunAutomatics(registers);
    if (description) FireTestPacket(registers, address);
    usleep(5000);
  }
}

// Tests: acquisition/simulator/gige/simulated_gige_camera, acquisition/simulator/gige/gige_registers.
//
// The simulated GigE Vision camera's triggers and its account of the last frame, by the library's own client:
// as many frames as pulses, whatever else the client does.
#include <arv.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"

namespace ulf::simulator_trigger_test {
namespace {

using namespace std::chrono_literals;

class TriggeredCamera : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = test::EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
    GigeServerOptions options;
    options.simulation.width = 160;
    options.simulation.height = 120;
    options.simulation.fps = 200;
    options.simulation.noise = false;
    options.simulation.format = SensorFormat::kMono8;
    options.loop = 8;
    options.line_hz = 25;
    server_ = std::make_unique<SimulatedGigeCamera>(options);
    camera_ = arv_camera_new("127.0.0.1", nullptr);
    ASSERT_TRUE(camera_);
    arv_camera_gv_set_stream_options(camera_, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    arv_camera_set_pixel_format_from_string(camera_, "Mono8", nullptr);
  }
  void TearDown() override {
    if (stream_) {
      arv_camera_stop_acquisition(camera_, nullptr);
      g_object_unref(stream_);
    }
    if (camera_) g_object_unref(camera_);
  }

  void Arm(const char* source) {
    GError* error = nullptr;
    arv_camera_set_trigger(camera_, source, &error);
    ASSERT_FALSE(error) << error->message;
    stream_ = arv_camera_create_stream(camera_, nullptr, nullptr, nullptr);
    ASSERT_TRUE(stream_);
    for (int i = 0; i < 16; ++i) arv_stream_push_buffer(stream_, arv_buffer_new_allocate(160 * 120));
    arv_camera_start_acquisition(camera_, nullptr);
  }

  // Frames that come until none has come for `patience`.
  int Frames(std::chrono::microseconds patience, int most = 1000) {
    int frames = 0;
    while (frames < most) {
      ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream_, static_cast<guint64>(patience.count()));
      if (!buffer) break;
      if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS) {
        ++frames;
        last_id_ = arv_buffer_get_frame_id(buffer);
      }
      arv_stream_push_buffer(stream_, buffer);
    }
    return frames;
  }

  std::unique_ptr<SimulatedGigeCamera> server_;
  ArvCamera* camera_ = nullptr;
  ArvStream* stream_ = nullptr;
  guint64 last_id_ = 0;
};

TEST_F(TriggeredCamera, ExposesAtEachSoftwareTrigger) {
  Arm("Software");
  EXPECT_EQ(Frames(300ms), 0) << "before any trigger";
  int frames = 0;
  for (int i = 0; i < 12; ++i) {
    arv_camera_software_trigger(camera_, nullptr);
    frames += Frames(2s, 1);
  }
  frames += Frames(300ms);
  EXPECT_EQ(frames, 12);
  EXPECT_EQ(server_->Statistics().served, 12u);
}

TEST_F(TriggeredCamera, ExposesAtEachPulseOnTheLine) {
  Arm("Line0");
  const auto begin = std::chrono::steady_clock::now();
  const int frames = Frames(1s, 30);
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(frames, 30);
  EXPECT_GT(took_s, 29 / 25.0 - 0.05) << "no faster than 25 pulses a second";
  arv_camera_set_float(camera_, "LinePulseRate", 2, nullptr);
  Frames(20ms);  // pulses from before
  Frames(100ms);
  const int slow = Frames(800ms, 3);
  EXPECT_EQ(slow, 3);
}

TEST_F(TriggeredCamera, TheLastFrameIsToldInRegisters) {
  arv_camera_set_exposure_time(camera_, 2000, nullptr);
  arv_camera_set_gain(camera_, 6, nullptr);
  Arm("Software");
  for (int i = 1; i <= 3; ++i) {
    arv_camera_software_trigger(camera_, nullptr);
    ASSERT_EQ(Frames(2s, 1), 1);
    const auto read = [&](const char* name) { return arv_camera_get_integer(camera_, name, nullptr); };
    EXPECT_EQ(static_cast<guint64>(read("LastFrameId")), last_id_);
    EXPECT_EQ(read("LastFrameNumber"), i);
    EXPECT_EQ(read("LastExposureTime"), 2000);
    EXPECT_EQ(read("LastGain"), 60);
  }
  std::array<std::uint8_t, 20> block{};
  GError* error = nullptr;
  arv_device_read_memory(arv_camera_get_device(camera_), 0x1000, block.size(), block.data(), &error);
  ASSERT_FALSE(error);
  EXPECT_EQ(block[7], 3) << "the same in one piece";
  EXPECT_EQ(block[10] << 8 | block[11], 2000);
}

// Pulses far apart, at a hardware line and by software, each camera through our device: as many frames as
// triggers, no fault in between.
void RunSparseTriggers(double seconds, double every_s) {
  static const std::optional<std::string> why_not = test::EnterLoopbackNamespace();
  if (why_not) GTEST_SKIP() << *why_not;
  const auto serve = [&](const char* address) {
    GigeServerOptions options;
    options.simulation.width = 160;
    options.simulation.height = 120;
    options.simulation.noise = false;
    options.loop = 4;
    options.line_hz = 1 / every_s;
    options.interface = address;
    options.serial = std::string("ULF-") + address;
    return std::make_unique<SimulatedGigeCamera>(options);
  };
  const auto by_line = serve("127.0.0.1"), by_software = serve("127.0.0.2");
  const auto line = OpenDevice("aravis:127.0.0.1?trigger=Line0&packet_timeout_ms=40");
  const auto software = OpenDevice("aravis:127.0.0.2?trigger=software");
  line->Start();
  software->Start();
  using PulseClock = std::chrono::steady_clock;
  const auto begin = PulseClock::now();
  auto due = begin;
  std::uint64_t at_line = 0, asked = 0, answered = 0;
  while (PulseClock::now() - begin < std::chrono::duration<double>(seconds)) {
    if (const auto frame = line->Next(50ms); frame && frame->status == FrameStatus::kComplete) ++at_line;
    if (PulseClock::now() < due) continue;
    due += std::chrono::duration_cast<PulseClock::duration>(std::chrono::duration<double>(every_s));
    ++asked;
    if (const auto frame = software->Next(2s); frame && frame->status == FrameStatus::kComplete) ++answered;
  }
  // One that is on its way when the time is over.
  while (const auto frame = line->Next(200ms)) ++at_line;
  for (Device* device : {line.get(), software.get()}) {
    const DeviceStatistics counted = device->Statistics();
    EXPECT_EQ(device->State(), DeviceState::kStreaming) << device->Info().problem;
    EXPECT_EQ(counted.incomplete + counted.missing + counted.reconnects, 0u) << device->Info().uri;
    for (const DeviceEvent& event : device->TakeEvents())
      EXPECT_EQ(event.kind, DeviceEventKind::kNotice) << event.text;
  }
  EXPECT_EQ(at_line, by_line->Statistics().served);
  EXPECT_GE(at_line, std::floor(seconds / every_s) - 1);
  EXPECT_EQ(answered, asked);
  EXPECT_EQ(by_software->Statistics().served, asked);
  std::printf("triggers every %g s for %g s: %llu of %llu frames at the line, %llu of %llu by software\n",
              every_s, seconds, static_cast<unsigned long long>(at_line),
              static_cast<unsigned long long>(by_line->Statistics().served),
              static_cast<unsigned long long>(answered), static_cast<unsigned long long>(asked));
}

TEST(SparseTriggers, LoseNothing) { RunSparseTriggers(4, 1); }
TEST(SparseTriggers, LoseNothingInTenMinutes) { RunSparseTriggers(600, 10); }

}  // namespace
}  // namespace ulf::simulator_trigger_test

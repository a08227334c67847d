#include "tests/benchmarks/aravis_turns.h"

#include <arv.h>

#include <algorithm>

#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/measure/figures.h"
#include "tests/measure/paired.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

constexpr std::size_t kTurns = 15;
constexpr double kTurnS = 0.8;

// Counts the frames that `next` brings: +1 whole, 0 none, -1 broken; its argument takes the timestamp.
template <typename Next>
Turn Measure(Next&& next, std::size_t frames_wanted) {
  Turn turn;
  double device_time_s = 0;
  for (int settled = 0; settled < 10;) settled += next(device_time_s) > 0;  // the first meet small buffers
  const double cpu_before = CpuSeconds();
  const auto begin = Clock::now();
  std::size_t frames = 0;
  while (frames_wanted > 0 ? frames < frames_wanted : SecondsSince(begin) < kTurnS) {
    const int came = next(device_time_s);
    if (came > 0) {
      ++frames;
      if (frames_wanted > 0) turn.latencies_ms.push_back(1e3 * (EpochSeconds() - device_time_s));
    }
    turn.broken += came < 0;
  }
  turn.fps = static_cast<double>(frames) / SecondsSince(begin);
  turn.cpu_ms = 1e3 * (CpuSeconds() - cpu_before) / static_cast<double>(std::max<std::size_t>(1, frames));
  return turn;
}

}  // namespace

Size SizeOf(const benchmark::State& state) {
  return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

Turn OurTurn(const std::string& uri, std::size_t frames_wanted) {
  const auto device = OpenDevice(uri);
  device->Start();
  Turn turn = Measure(
      [&](double& device_time_s) {
        const auto frame = device->Next(std::chrono::milliseconds(1000));
        if (!frame) return 0;
        device_time_s = frame->device_time_s;
        benchmark::DoNotOptimize(frame->image.pixels.data);
        return frame->status == FrameStatus::kComplete ? 1 : -1;
      },
      frames_wanted);
  device->Stop();
  turn.broken += static_cast<int>(device->Statistics().dropped);
  return turn;
}

Turn BareTurn(const BareStream& wanted, std::size_t frames_wanted) {
  GError* error = nullptr;
  if (!wanted.camera) arv_update_device_list();
  ArvCamera* camera = arv_camera_new(wanted.camera ? wanted.camera : arv_get_device_id(0), &error);
  if (!camera) throw Error("the benchmark's camera cannot be opened: {}", error->message);
  arv_camera_set_pixel_format(camera, ARV_PIXEL_FORMAT_MONO_8, nullptr);
  arv_camera_set_region(camera, 0, 0, wanted.size.width, wanted.size.height, nullptr);
  arv_camera_set_frame_rate(camera, wanted.fps, nullptr);
  if (wanted.gige_packet_bytes > 0) {
    arv_camera_gv_set_packet_size(camera, wanted.gige_packet_bytes, nullptr);
    arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  ArvStream* stream = arv_camera_create_stream(camera, nullptr, nullptr, &error);
  if (!stream) throw Error("the benchmark's camera does not stream: {}", error->message);
  const std::size_t bytes =
      static_cast<std::size_t>(wanted.size.width) * static_cast<std::size_t>(wanted.size.height);
  if (wanted.gige_packet_bytes > 0)
    g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                 static_cast<gint>(std::max<std::size_t>(2 * bytes, 2 << 20)), nullptr);
  for (int i = 0; i < kSlack; ++i) arv_stream_push_buffer(stream, arv_buffer_new_allocate(bytes));
  arv_camera_start_acquisition(camera, nullptr);
  Turn turn = Measure(
      [&](double& device_time_s) {
        ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 1'000'000);
        if (!buffer) return 0;
        const bool whole = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS;
        device_time_s = 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
        benchmark::DoNotOptimize(arv_buffer_get_image_data(buffer, nullptr));
        arv_stream_push_buffer(stream, buffer);
        return whole ? 1 : -1;
      },
      frames_wanted);
  arv_camera_stop_acquisition(camera, nullptr);
  g_object_unref(stream);
  g_object_unref(camera);
  return turn;
}

void TellThroughput(benchmark::State& state, const std::function<Turn()>& ours,
                    const std::function<Turn()>& bare) {
  using Turns = test::Paired<Turn>;
  for ([[maybe_unused]] auto _ : state) {
    const Turns turns(ours, bare, kTurns);
    const test::Spread ratio = turns.Ratios(&Turn::fps);
    state.counters["ratio"] = ratio.median;
    state.counters["ratio_least"] = ratio.low;
    state.counters["ratio_most"] = ratio.high;
    for (const auto& [who, of] : {std::pair{"ours", &turns.ours()}, {"bare", &turns.bare()}}) {
      const std::string name = who;
      state.counters[name + "_fps"] = Turns::MedianOf(*of, &Turn::fps);
      state.counters[name + "_cpu_ms"] = Turns::MedianOf(*of, &Turn::cpu_ms);
      for (const Turn& turn : *of) state.counters[name + "_broken"] += turn.broken;
    }
    state.SetIterationTime(1 / Turns::MedianOf(turns.ours(), &Turn::fps));
  }
}

}  // namespace ulf

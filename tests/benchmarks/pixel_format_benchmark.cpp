// From a camera's bytes to an image on one core: bytes per second are of output. `Copy` is the ceiling.
// Targets: 1 GB/s for what packs 10 and 12 bits.
#include <benchmark/benchmark.h>

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "core/frames/pixel_format.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

constexpr int kWidth = 2048, kHeight = 1536;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidth) * kHeight;

std::vector<std::uint8_t> RandomBytes(std::size_t size) {
  std::mt19937 random(1);
  std::vector<std::uint8_t> bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

void Copy(benchmark::State& state) {
  const auto bytes = RandomBytes(2 * kPixels);
  std::vector<std::uint16_t> out(kPixels);
  for ([[maybe_unused]] auto _ : state) {
    std::memcpy(out.data(), bytes.data(), 2 * kPixels);
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * 2 * kPixels));
}
BENCHMARK(Copy);

template <void (*kUnpack)(const std::uint8_t*, std::size_t, int, std::uint16_t*)>
void Unpack(benchmark::State& state) {
  const auto bytes = RandomBytes(2 * kPixels);
  std::vector<std::uint16_t> out(kPixels);
  for ([[maybe_unused]] auto _ : state) {
    kUnpack(bytes.data(), kPixels, static_cast<int>(state.range(0)), out.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * 2 * kPixels));
}
BENCHMARK(Unpack<UnpackLsb>)->Name("UnpackLsb_p")->Arg(10)->Arg(12)->Arg(14);
BENCHMARK(Unpack<UnpackGvsp>)->Name("UnpackGvsp_Packed")->Arg(10)->Arg(12);
BENCHMARK(Unpack<UnpackWords>)->Name("UnpackWords")->Arg(10)->Arg(12)->Arg(16);

// The whole way, with the image's memory.
void FromBytes(benchmark::State& state, const char* name, std::optional<YuvEncoding> yuv = {}) {
  const PixelFormat format = *PixelFormatByName(name);
  auto bytes = RandomBytes(ImageBytes(format, kWidth, kHeight));
  if (format.packing == PixelPacking::kJpeg) {
    cv::Mat picture(kHeight, kWidth, CV_8UC3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        picture.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                       static_cast<std::uint8_t>(x * y / 64)};
    cv::imencode(".jpg", picture, bytes);
  }
  std::size_t out = 0;
  for ([[maybe_unused]] auto _ : state) {
    const Image image = ImageFromBytes(format, kWidth, kHeight, bytes.data(), bytes.size(), {.yuv = yuv});
    out = image.pixels.total() * image.pixels.elemSize();
    benchmark::DoNotOptimize(image.pixels.data);
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * out));
}
BENCHMARK_CAPTURE(FromBytes, Mono8, "Mono8");
BENCHMARK_CAPTURE(FromBytes, Mono10p, "Mono10p");
BENCHMARK_CAPTURE(FromBytes, Mono12p, "Mono12p");
BENCHMARK_CAPTURE(FromBytes, Mono12Packed, "Mono12Packed");
BENCHMARK_CAPTURE(FromBytes, BayerRG12p, "BayerRG12p");
BENCHMARK_CAPTURE(FromBytes, Mono16, "Mono16");
BENCHMARK_CAPTURE(FromBytes, RGB8, "RGB8");
BENCHMARK_CAPTURE(FromBytes, YUYV_limited601, "YUYV");
BENCHMARK_CAPTURE(FromBytes, YUYV_full709, "YUYV", YuvEncoding{YuvMatrix::kBt709, true});
BENCHMARK_CAPTURE(FromBytes, NV12_limited601, "NV12");
BENCHMARK_CAPTURE(FromBytes, MJPEG, "MJPEG");

// A mosaic on its way to the tracker, and what the same would cost by way of all colours.
void MosaicGray(benchmark::State& state) {
  const PixelFormat format = *PixelFormatByName(state.range(0) == 8 ? "BayerRG8" : "BayerRG16");
  const auto bytes = RandomBytes(ImageBytes(format, kWidth, kHeight));
  const Image mosaic = ImageFromBytes(format, kWidth, kHeight, bytes.data(), bytes.size());
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(GrayForTracking(mosaic).data);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kPixels));
}
BENCHMARK(MosaicGray)->Arg(8)->Arg(16)->Unit(benchmark::kMillisecond);

void MosaicGrayByColors(benchmark::State& state) {
  const PixelFormat format = *PixelFormatByName(state.range(0) == 8 ? "BayerRG8" : "BayerRG16");
  const auto bytes = RandomBytes(ImageBytes(format, kWidth, kHeight));
  const Image mosaic = ImageFromBytes(format, kWidth, kHeight, bytes.data(), bytes.size());
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(GrayForTracking(Demosaiced(mosaic)).data);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kPixels));
}
BENCHMARK(MosaicGrayByColors)->Arg(8)->Arg(16)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::vector<ulf::Target> targets;
  for (const char* run : {"UnpackLsb_p/10", "UnpackLsb_p/12", "UnpackGvsp_Packed/10", "UnpackGvsp_Packed/12",
                          "FromBytes/Mono10p", "FromBytes/Mono12p"})
    targets.push_back({run, "bytes_per_second", 1e9, "bytes of output a second on one core"});
  return ulf::RunBenchmarks(argc, argv, targets);
}

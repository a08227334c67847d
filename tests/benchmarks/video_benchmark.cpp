// What reading a video costs, beside OpenCV's reader in the same run, and how right either is. Target: 1.05
// of OpenCV's processor time for 1080p in H.264.
//
//   ratio            processor time of our reader / of OpenCV's, in turns, median of the turns' ratios
//   ms               of the processor, a picture, by our reader
//   levels_ours, levels_opencv   the largest difference from the grays and colours that the video was made of
//                    (BT.709, limited range, as nearly all cameras record), of 255
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/videoio.hpp>

#include "core/base/quantile.h"
#include "core/video/video_reader.h"
#include "tests/measure/figures.h"
#include "tests/support/test_paths.h"
#include "tests/support/video/sample_video.h"

namespace ulf {
namespace {

constexpr int kWidth = 1920, kHeight = 1080, kPatch = 240;
constexpr std::array<std::array<double, 3>, 4> kPatches{
    {{200, 50, 50}, {50, 200, 50}, {50, 50, 200}, {128, 128, 128}}};

// Patches that stand, and below them noise that moves, so that there is something to decode.
test::VideoSample Sample() {
  test::VideoSample sample;
  sample.encoder = "libx264";
  sample.width = kWidth;
  sample.height = kHeight;
  sample.pictures = 40;
  sample.matrix = AVCOL_SPC_BT709;
  sample.range = AVCOL_RANGE_MPEG;
  sample.value = [](int number, int plane, int x, int y) {
    const int scale = plane == 0 ? 1 : 2;
    if (y * scale >= kHeight / 2) return 40 + ((x + 3 * number) * 37 + y * 11) % 160;
    const auto& [red, green, blue] = kPatches[static_cast<std::size_t>(x * scale / kPatch) % kPatches.size()];
    const double luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    if (plane == 0) return static_cast<int>(std::lround(16 + luma * 219 / 255));
    return static_cast<int>(
        std::lround(128 + (plane == 1 ? (blue - luma) / 1.8556 : (red - luma) / 1.5748) * 224 / 255));
  };
  return sample;
}

double LevelsOff(const cv::Mat& bgr) {
  double most = 0;
  for (std::size_t patch = 0; patch < kPatches.size(); ++patch) {
    const auto at = bgr.at<cv::Vec3b>(kHeight / 4, static_cast<int>(patch) * kPatch + kPatch / 2);
    for (int channel = 0; channel < 3; ++channel)
      most = std::max(most, std::abs(at[channel] - kPatches[patch][static_cast<std::size_t>(2 - channel)]));
  }
  return most;
}

void FullHdH264(benchmark::State& state) {
  const test::ScratchFolder scratch;
  const std::string file = (scratch / "video.mp4").string();
  test::WriteVideo(file, Sample());
  std::vector<double> ratios, ms;
  double ours_off = 0, opencv_off = 0;
  for ([[maybe_unused]] auto _ : state) {
    const double begin_s = CpuSeconds();
    int opencv = 0;
    cv::VideoCapture capture(file, cv::CAP_FFMPEG);
    for (cv::Mat picture; capture.read(picture); ++opencv)
      opencv_off = std::max(opencv_off, LevelsOff(picture));
    const double middle_s = CpuSeconds();
    int ours = 0;
    VideoReader reader(file);
    for (auto picture = reader.Next(); picture; picture = reader.Next(), ++ours)
      ours_off = std::max(ours_off, LevelsOff(picture->image.pixels));
    const double end_s = CpuSeconds();
    if (ours != opencv || ours == 0) return state.SkipWithError("not all pictures were read");
    ratios.push_back((end_s - middle_s) / (middle_s - begin_s));
    ms.push_back(1000 * (end_s - middle_s) / ours);
  }
  state.counters["ratio"] = Median(ratios);
  state.counters["ms"] = Median(ms);
  state.counters["levels_ours"] = ours_off;
  state.counters["levels_opencv"] = opencv_off;
}
BENCHMARK(FullHdH264)->Iterations(7)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  return ulf::RunBenchmarks(
      argc, argv,
      {{"FullHdH264", "ratio", 0, "of OpenCV's processor time, for 1080p in H.264", 1.05},
       {"FullHdH264", "levels_ours", 0, "levels that colours are off", 2}});
}

// Tests: core/light_field/folder/light_field_io, commands/light_field/info_command,
// commands/rendering/render_command.
//
// A light field of ten thousand views: it is written, closed, opened, described and rendered, and memory
// grows with the number of views by what a view weighs. Rows of docs/measured/cameras.md.
#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

extern char** environ;

namespace ulf::test::many_views_long_test {
namespace {

namespace fs = std::filesystem;

struct Ended {
  int exit_code = -1;
  double seconds = 0, peak_mb = 0;
};

Ended Measure(const std::string& arguments) {
  const std::string command = fmt::format("exec '{}' {} >/dev/null", std::getenv("ULF_BINARY"), arguments);
  const char* words[] = {"/bin/sh", "-c", command.c_str(), nullptr};
  const auto start = std::chrono::steady_clock::now();
  pid_t child = 0;
  if (posix_spawn(&child, words[0], nullptr, nullptr, const_cast<char**>(words), environ) != 0) return {};
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, SecondsSince(start),
          static_cast<double>(usage.ru_maxrss) / 1024};
}

// In rows on a sphere round the subject, each with a picture of its own.
void Write(const fs::path& dir, int count) {
  constexpr int kTogether = 200, kWidth = 96, kHeight = 72;
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(kWidth, kHeight, 90);
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  writer.SetSubject({{0, 0, 0}, 0.3});
  const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
  cv::RNG random(7);
  cv::Mat pattern(kHeight / 8, kWidth / 8, CV_8UC3);
  random.fill(pattern, cv::RNG::UNIFORM, 40, 216);
  for (int first = 0; first < count; first += kTogether) {
    std::vector<LightFieldWriter::NewView> views;
    for (int i = first; i < std::min(first + kTogether, count); ++i) {
      const double azimuth = (i % columns - columns / 2) * 1.2 / columns;
      const double elevation = (i / columns - columns / 2) * 1.2 / columns;
      LightFieldWriter::NewView added;
      cv::resize(pattern, added.frame.image.pixels, {kWidth, kHeight}, 0, 0, cv::INTER_CUBIC);
      added.frame.image.transfer = Transfer::kSrgb;
      added.frame.device_time_s = i / 15.0;
      added.view.cam_from_world = LookAt({std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                                          std::cos(azimuth) * std::cos(elevation)},
                                         {0, 0, 0}, {0, 1, 0});
      added.files = writer.Files(added.frame, MakePictures::kNow);
      views.push_back(std::move(added));
    }
    writer.AddViews(views);
  }
  writer.Close(count / 15.0);
}

TEST(ManyViews, TenThousandAreOpenedDescribedAndRendered) {
  ASSERT_TRUE(std::getenv("ULF_BINARY"))
      << "ULF_BINARY is not set: run through ctest, or export ULF_BINARY=$PWD/build/release/ulf";
  struct Measured {
    int views;
    Ended info, picture;
  };
  std::vector<Measured> measured;
  const ScratchFolder scratch;
  for (const int views : {1000, 10000}) {
    const fs::path dir = scratch / fmt::format("lf{}", views), picture = scratch / "picture.png";
    Write(dir, views);
    const LightField light_field = ReadLightField(dir);
    ASSERT_EQ(light_field.views.size(), static_cast<std::size_t>(views));
    EXPECT_TRUE(light_field.doubts.empty()) << light_field.doubts.front();
    Measured one{views, Measure(fmt::format("info {}", dir.string())),
                 Measure(fmt::format(
                     "render {} --path orbit --frames 1 --width 320 --height 240 --proxy plane --field "
                     "subdivision -o {}",
                     dir.string(), picture.string()))};
    EXPECT_EQ(one.info.exit_code, 0) << views;
    EXPECT_EQ(one.picture.exit_code, 0) << views;
    const cv::Mat rendered = cv::imread(picture.string());
    ASSERT_FALSE(rendered.empty()) << views;
    EXPECT_GT(cv::mean(rendered)[0], 20) << views;
    fs::remove(picture);
    PrintFaultRow(fmt::format("{} views: `ulf info` ({:.0f} MB)", views, one.info.peak_mb), 1, "none",
                  one.info.seconds);
    PrintFaultRow(
        fmt::format("{} views: first picture of `ulf render` ({:.0f} MB)", views, one.picture.peak_mb), 1,
        "none", one.picture.seconds);
    measured.push_back(one);
  }
  // What a view may weigh: its line, its pose, its names; rendered, its picture as well.
  const auto kb_a_view = [&](const auto& of) {
    return 1024 * (of(measured[1]) - of(measured[0])) / (measured[1].views - measured[0].views);
  };
  EXPECT_LT(kb_a_view([](const Measured& m) { return m.info.peak_mb; }), 20);
  EXPECT_LT(kb_a_view([](const Measured& m) { return m.picture.peak_mb; }), 120);
}

}  // namespace
}  // namespace ulf::test::many_views_long_test

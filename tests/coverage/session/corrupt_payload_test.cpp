// Tests: acquisition/v4l2/v4l2_device, core/image/files/jpeg_codec, coverage/session/capture_session.
//
// A webcam whose JPEG pictures lose data on the cable, of which nobody tells: what is captured from it. A row
// of docs/measured/cameras.md.
#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>

#include "acquisition/v4l2/v4l2_device.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/coverage/session/kept_views.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/support/v4l2_camera.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::corrupt_payload_test {
namespace {

using Jpeg = std::vector<std::uint8_t>;

// What a lost packet leaves: other bytes, where the transfer keeps its size, or none.
enum class Damage { kNone, kGarbage, kZeros, kGap };

Jpeg Damaged(Jpeg jpeg, Damage damage, unsigned seed) {
  constexpr std::ptrdiff_t kPacket = 512;
  std::mt19937 random(seed);
  // Behind the headers, before the end.
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(jpeg.size()) / 4 +
                            static_cast<std::ptrdiff_t>(random() % (jpeg.size() / 4));
  const auto begin = jpeg.begin() + at, end = begin + kPacket;
  if (damage == Damage::kGarbage)
    std::generate(begin, end, [&] { return static_cast<std::uint8_t>(random()); });
  if (damage == Damage::kZeros) std::fill(begin, end, std::uint8_t{0});
  if (damage == Damage::kGap) jpeg.erase(begin, end);
  return jpeg;
}

// Knows where the camera stands by the number of the frame.
class NumberedSource : public PoseSource {
 public:
  explicit NumberedSource(std::vector<PlanarShot> shots)
      : shots_(std::move(shots)), known_(MakeKnownPoseSource(kCamera, kSubject)) {}
  Track Step(const Frame& frame) override {
    Frame placed = frame;
    placed.known_cam_from_world = shots_[frame.id % shots_.size()].cam_from_world;
    return known_->Step(placed);
  }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    return known_->Locate(photograph, camera, near);
  }
  Rigid3 PoseOf(const Anchored& anchor) const override { return known_->PoseOf(anchor); }
  std::vector<VisiblePoint> VisiblePoints() const override { return known_->VisiblePoints(); }
  std::vector<ScenePoint> Points() const override { return known_->Points(); }
  bool SeedMap(std::span<const SeedView> views, const SeedProgress& progress) override {
    return known_->SeedMap(views, progress);
  }
  void Finish() override { known_->Finish(); }

 private:
  std::vector<PlanarShot> shots_;
  std::unique_ptr<PoseSource> known_;
};

TEST(CorruptPayload, IsCountedAndNeverRecorded) {
  if (const auto why = NoV4l2Emulation()) GTEST_SKIP() << *why;
  constexpr int kShots = 60;
  std::vector<Jpeg> sent;
  std::set<std::string> whole;
  PlanarDevice plane(Arc(kShots));
  plane.Start();
  for (int i = 0; i < kShots; ++i) {
    Jpeg jpeg;
    cv::imencode(".jpg", plane.Next({})->image.pixels, jpeg);
    const Damage damage = i % 2 == 0 ? Damage::kNone : static_cast<Damage>(1 + i / 2 % 3);
    if (damage == Damage::kNone) whole.emplace(jpeg.begin(), jpeg.end());
    sent.push_back(Damaged(jpeg, damage, static_cast<unsigned>(i)));
  }
  const EmulatedV4l2Camera camera(
      {.modes = {{.fourcc = V4L2_PIX_FMT_MJPEG, .width = 320, .height = 240, .fps = {20}}},
       .render = [&](const EmulatedMode&, std::uint32_t sequence) { return sent[sequence % kShots]; }});
  const auto device = acquisition::OpenV4l2Device(DeviceUri::Parse("v4l2:/dev/video0?settle=0"));
  const ScratchFolder scratch;
  NumberedSource poses(Arc(kShots));
  CaptureOptions options = InThreads();
  options.max_frames = 20;
  device->Start();
  const CaptureSummary summary = RunCapture(*device, kCamera, poses, NewWriter(scratch / "lf"), options);
  EXPECT_EQ(summary.frames, 20u) << "it goes on";
  EXPECT_GE(summary.device.incomplete, 15u);
  const int damaged = static_cast<int>(summary.device.incomplete);
  const LightField light_field = ReadLightField(scratch / "lf");
  EXPECT_GT(light_field.views.size(), 10u);
  int spoilt = 0;
  for (const View& view : light_field.views)
    spoilt += !whole.contains(ReadWholeFile(light_field.root / view.image_path));
  EXPECT_EQ(spoilt, 0);
  PrintFaultRow("corrupt payload: a webcam's JPEG with 512 bytes replaced or missing in its middle", damaged,
                fmt::format("those frames, counted; {} views spoilt", spoilt), std::nullopt);
}

}  // namespace
}  // namespace ulf::test::corrupt_payload_test

// Tests: coverage/session/prepared_capture, coverage/session/record/kept_photographs.
//
// Photographs that came before a capture that could not begin.
#include "coverage/session/prepared_capture.h"

#include <gmock/gmock.h>

#include <deque>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::prepared_capture_test {
namespace {

namespace fs = std::filesystem;

Frame Photograph(const std::string& bytes, const std::string& raw = "") {
  Frame frame;
  frame.kind = FrameKind::kStill;
  frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(bytes)};
  if (!raw.empty()) frame.raw = EncodedImage{".nef", std::make_shared<const std::string>(raw)};
  return frame;
}

// A tethered camera with photographs on their way, whose end may fail.
class Tethered : public Device {
 public:
  Tethered(std::deque<Frame> coming, bool stop_fails) : coming_(std::move(coming)), stop_fails_(stop_fails) {}
  DeviceInfo Info() const override { return {}; }
  bool IsLive() const override { return true; }
  bool TakesStills() const override { return true; }
  void Start() override {}
  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override {
    if (coming_.empty()) return std::nullopt;
    Frame frame = std::move(coming_.front());
    coming_.pop_front();
    return frame;
  }
  void Stop() override {
    if (stop_fails_) throw Error("the camera does not answer");
  }
  DeviceState State() const override { return DeviceState::kConnected; }
  DeviceStatistics Statistics() const override { return {}; }

 private:
  std::deque<Frame> coming_;
  const bool stop_fails_;
};

void Keep(const std::vector<std::string>& in_hand, const std::vector<std::string>& coming,
          const fs::path& dir, bool stop_fails = false, LightFieldWriter* writer = nullptr) {
  std::vector<Frame> taken;
  for (const std::string& bytes : in_hand) taken.push_back(Photograph(bytes, "raw " + bytes));
  std::deque<Frame> on_their_way;
  for (const std::string& bytes : coming) on_their_way.push_back(Photograph(bytes));
  Tethered device(std::move(on_their_way), stop_fails);
  KeepPhotographs(device, taken, writer, dir);
}

std::map<std::string, std::string> BytesIn(const fs::path& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::directory_iterator(folder))
    bytes[entry.path().filename().string()] = ReadWholeFile(entry.path());
  return bytes;
}

TEST(KeepPhotographs, RefusedCaptureReplacesNothing) {
  const ScratchFolder scratch;
  Keep({"one"}, {"two"}, scratch / "lf");
  Keep({"three"}, {}, scratch / "lf");
  Keep({}, {"four"}, scratch.path() / "lf" / "");  // written lf/
  const std::map<std::string, std::string> all{{"000001.jpg", "one"},       {"000001.nef", "raw one"},
                                               {"000002.jpg", "two"},       {"000003.jpg", "three"},
                                               {"000003.nef", "raw three"}, {"000004.jpg", "four"}};
  EXPECT_EQ(BytesIn(scratch / "lf.photographs"), all);
  EXPECT_FALSE(fs::exists(scratch / "lf"));
}

TEST(KeepPhotographs, UnstoppableDeviceTakesNone) {
  const ScratchFolder scratch;
  Keep({"one"}, {"two"}, scratch / "lf", true);
  EXPECT_EQ(BytesIn(scratch / "lf.photographs").size(), 3u);
}

TEST(KeepPhotographs, GoBesideALightFieldThatTakesNone) {
  const ScratchFolder scratch;
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(64, 48, 50);
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", header);
  Keep({"one"}, {}, scratch / "lf", false, &writer);
  EXPECT_EQ(BytesIn(scratch / "lf/unposed").size(), 2u);
  fs::remove_all(scratch / "lf/unposed");
  WriteFileAtomically(scratch / "lf/unposed", "in the way");
  Keep({"two"}, {"three"}, scratch / "lf", false, &writer);
  EXPECT_EQ(BytesIn(scratch / "lf.photographs").size(), 3u);
}

}  // namespace
}  // namespace ulf::test::prepared_capture_test

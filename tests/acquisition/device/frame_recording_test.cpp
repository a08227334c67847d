// Tests: acquisition/device/frame_recording, acquisition/device/replay_device, core/image/files/exif.
#include "acquisition/device/frame_recording.h"
#include "acquisition/opening/open_device.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/raw_file.h"
#include "tests/support/dng_file.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"

namespace ulf::test::frame_recording_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

Frame MakeFrame(int number, int type = CV_16UC1, cv::Size size = {40, 30}) {
  Frame frame;
  frame.image.pixels = cv::Mat(size, type);
  cv::theRNG().state = static_cast<std::uint64_t>(number) + 1;
  cv::randu(frame.image.pixels, 0, 255);
  frame.id = 100 + static_cast<std::uint64_t>(number);
  frame.device_time_s = 5 + 0.04 * number;
  frame.host_time_s = 1.7e9 + 0.04 * number;
  frame.exposure_s = 0.004;
  frame.gain = 2;
  frame.black_level = 0.015;
  return frame;
}

// What is said when the frames before are on disk already is written alone, and costs them nothing.
TEST(FrameRecording, LaterNoteLeavesWrittenFramesAlone) {
  const ScratchFolder scratch;
  FrameRecorder recorder(scratch / "session", {});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(recorder.TryAdd(MakeFrame(i)));
  std::this_thread::sleep_for(800ms);  // they are written after half a second
  recorder.Note("poses were corrected");
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written, 3u);
  EXPECT_EQ(summary.problem, "");
  const FrameRecording recording = ReadFrameRecording(scratch / "session");
  ASSERT_EQ(recording.entries.size(), 3u);
  for (const auto& entry : recording.entries) EXPECT_NO_THROW(ReadRecordedFrame(entry));
  EXPECT_THAT(ReadWholeFile(scratch / "session" / "frames.jsonl"), HasSubstr("poses were corrected"));
}

TEST(FrameRecording, GivesBackEveryFrameAsItWas) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "session";
  std::vector<Frame> frames;
  for (const int type : {CV_16UC1, CV_16UC1, CV_8UC1, CV_8UC3, CV_16UC3})
    frames.push_back(MakeFrame(static_cast<int>(frames.size()), type));
  frames[1].image.transfer = Transfer::kLinear;
  frames[1].image.mosaic = Mosaic::kGrbg;
  frames[2].f_number = 5.6;
  frames[3].known_cam_from_world = LookAt({1, 2, -3}, {0, 0, 0}, {0, -1, 0});
  frames[4].kind = FrameKind::kStill;
  frames[4].requested_s = 5.05;
  RecordingHeader header;
  header.device = {.uri = "x:1", .maker = "M", .model = "N", .serial = "S", .bus = "b", .problem = ""};
  header.window = SensorWindow{100, 80, 10, 20, 80, 60, 2, 2};
  header.camera = CameraModel::Pinhole(40, 30, 50);
  header.still_camera = CameraModel::Pinhole(400, 300, 480);
  header.flat_field = FlatField{.width = 40, .height = 30, .powers = {{2, 0, {-0.1, -0.2, -0.3}}}};
  header.still_flat_field = FlatField{.width = 400, .height = 300, .powers = {{0, 2, {-0.4, -0.2, -0.3}}}};
  FrameRecorder recorder(dir, header);
  for (const Frame& frame : frames) EXPECT_TRUE(recorder.TryAdd(frame));
  recorder.Note("the cable was out");
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written, 5u);
  EXPECT_EQ(summary.left_out, 0u);
  EXPECT_THAT(ReadWholeFile(dir / "frames.jsonl"), HasSubstr("the cable was out"));

  const FrameRecording recording = ReadFrameRecording(dir);
  EXPECT_EQ(recording.header.device.maker, "M");
  EXPECT_EQ(recording.header.device.model, "N");
  EXPECT_EQ(recording.header.device.serial, "S");
  EXPECT_EQ(recording.header.device.bus, "b");
  EXPECT_EQ(recording.header.window, header.window);
  EXPECT_EQ(recording.header.camera, header.camera);
  EXPECT_EQ(recording.header.still_camera, header.still_camera);
  EXPECT_EQ(recording.header.flat_field, header.flat_field);
  EXPECT_EQ(recording.header.still_flat_field, header.still_flat_field);
  EXPECT_TRUE(recording.header.takes_stills) << "there is one";
  ASSERT_EQ(recording.entries.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const Frame read = ReadRecordedFrame(recording.entries[i]);
    EXPECT_EQ(read.image.pixels.type(), frames[i].image.pixels.type()) << i;
    EXPECT_EQ(cv::norm(read.image.pixels, frames[i].image.pixels, cv::NORM_INF), 0) << i;
    EXPECT_EQ(read.image.transfer, frames[i].image.transfer) << i;
    EXPECT_EQ(read.image.mosaic, frames[i].image.mosaic) << i;
    EXPECT_EQ(read.id, frames[i].id);
    EXPECT_EQ(read.device_time_s, frames[i].device_time_s);
    EXPECT_EQ(read.host_time_s, frames[i].host_time_s);
    EXPECT_EQ(read.exposure_s, frames[i].exposure_s);
    EXPECT_EQ(read.gain, 2);
    EXPECT_EQ(read.black_level, 0.015);
    EXPECT_EQ(read.f_number, frames[i].f_number);
    EXPECT_EQ(read.kind, frames[i].kind);
    EXPECT_EQ(read.requested_s, frames[i].requested_s);
    EXPECT_EQ(read.known_cam_from_world.has_value(), i == 3);
  }
}

TEST(FrameRecording, ACamerasJpegStaysItself) {
  const ScratchFolder scratch;
  Frame frame = MakeFrame(0, CV_8UC3);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", frame.image.pixels, bytes);
  frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(bytes.begin(), bytes.end())};
  FrameRecorder recorder(scratch / "s", {});
  recorder.TryAdd(frame);
  recorder.Finish();
  const Frame read = ReadRecordedFrame(ReadFrameRecording(scratch / "s").entries.at(0));
  ASSERT_TRUE(read.encoded);
  EXPECT_EQ(*read.encoded->bytes, *frame.encoded->bytes);
}

TEST(FrameRecording, ReplaysAsADevice) {
  const ScratchFolder scratch;
  RecordingHeader header;
  header.device = {.uri = "x:1", .maker = "M", .model = "N", .serial = "S", .bus = "b", .problem = ""};
  header.window = SensorWindow{100, 80, 10, 20, 80, 60, 2, 2};
  header.camera = CameraModel::Pinhole(40, 30, 50);
  header.flat_field = FlatField{.width = 40, .height = 30, .powers = {{2, 0, {-0.1, -0.2, -0.3}}}};
  FrameRecorder recorder(scratch / "s", header);
  for (int i = 0; i < 3; ++i) recorder.TryAdd(MakeFrame(i));
  recorder.Finish();
  const auto device = OpenDevice("replay:" + (scratch / "s").string());
  EXPECT_EQ(device->Camera(), CameraModel::Pinhole(40, 30, 50));
  EXPECT_EQ(device->Info().model, "N") << "the camera that it was: calibrations are bound to it";
  EXPECT_EQ(device->Info().serial, "S");
  EXPECT_EQ(device->Info().bus, "b");
  EXPECT_EQ(device->Window(), header.window);
  ASSERT_TRUE(device->KnownFlatField(FrameKind::kLive));
  EXPECT_EQ(*device->KnownFlatField(FrameKind::kLive), *header.flat_field);
  EXPECT_FALSE(device->TakesStills());
  device->Start();
  for (int i = 0; i < 3; ++i) {
    const auto frame = device->Next(0ms);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->device_time_s, 5 + 0.04 * i);
    EXPECT_EQ(frame->gain, 2);
  }
  EXPECT_FALSE(device->Next(0ms));
  EXPECT_EQ(device->State(), DeviceState::kEnded);
}

TEST(FrameRecording, ReportsTornAndMissingFrames) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "s";
  {
    FrameRecorder recorder(dir, {});
    for (int i = 0; i < 3; ++i) recorder.TryAdd(MakeFrame(i));
    recorder.Finish();
  }
  EXPECT_THROW(FrameRecorder(dir, {}), Error) << "never written over";
  std::ofstream(dir / "frames.jsonl", std::ios::app) << "{\"event\": \"frame\", \"id\": 7, \"fi";
  EXPECT_EQ(ReadFrameRecording(dir).entries.size(), 3u) << "killed in the middle of a line";
  fs::remove(dir / "frames" / "00000002.tif");
  const FrameRecording recording = ReadFrameRecording(dir);
  EXPECT_THROW(ReadRecordedFrame(recording.entries[1]), Error);
  std::ofstream(dir / "frames.jsonl", std::ios::app) << "\n{\"event\": \"note\"}\n";
  EXPECT_THROW(ReadFrameRecording(dir), Error) << "damaged in the middle";
}

// What a tethered camera gives: a JPEG with its raw file, a raw file alone, a file that is no whole picture.
Frame Photograph(int number, const std::string& jpeg, const std::string& raw) {
  Frame frame;
  frame.kind = FrameKind::kStill;
  frame.id = static_cast<std::uint64_t>(number);
  frame.device_time_s = 0.1 * number;
  if (!jpeg.empty()) {
    frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(jpeg)};
    frame.image = {DecodeJpeg(jpeg), Transfer::kSrgb};
  }
  if (!raw.empty()) frame.raw = EncodedImage{".nef", std::make_shared<const std::string>(raw)};
  frame.status = frame.image.empty() ? FrameStatus::kIncomplete : FrameStatus::kComplete;
  return frame;
}

std::string SomeJpeg() {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", MakeFrame(7, CV_8UC3, {200, 150}).image.pixels, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(FrameRecording, PhotographsStayWhatTheyAreToTheByte) {
  const ScratchFolder scratch;
  const std::string jpeg = SomeJpeg(), raw = "raw bytes";
  const std::vector<Frame> photographs{Photograph(1, jpeg, raw), Photograph(2, "", raw),
                                       Photograph(3, jpeg.substr(0, jpeg.size() / 2), "")};
  {
    FrameRecorder recorder(scratch / "s", {});
    for (const Frame& photograph : photographs) EXPECT_TRUE(recorder.TryAdd(photograph));
    EXPECT_EQ(recorder.Finish().written, 3u);
  }
  const FrameRecording recording = ReadFrameRecording(scratch / "s");
  ASSERT_EQ(recording.entries.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Frame read = ReadRecordedFrame(recording.entries[i]);
    const Frame& was = photographs[i];
    EXPECT_EQ(read.kind, FrameKind::kStill);
    EXPECT_EQ(read.status, was.status) << i;
    ASSERT_EQ(read.encoded.has_value(), was.encoded.has_value()) << i;
    if (was.encoded) {
      EXPECT_EQ(*read.encoded->bytes, *was.encoded->bytes) << i;
    }
    ASSERT_EQ(read.raw.has_value(), was.raw.has_value()) << i;
    if (was.raw) {
      EXPECT_EQ(*read.raw->bytes, raw) << i;
    }
    ASSERT_EQ(read.image.pixels.size(), was.image.pixels.size()) << i;
    if (!was.image.empty()) {
      EXPECT_EQ(cv::norm(read.image.pixels, was.image.pixels, cv::NORM_INF), 0) << i;
    }
  }
}

// Its file is kept, not the pixels that were made of it.
TEST(FrameRecording, ARawFileAloneIsDevelopedAgain) {
  const ScratchFolder scratch;
  const std::string raw = DngBytes({}, [](int, int) { return cv::Vec3d(0.2, 0.3, 0.4); });
  Frame photograph = Photograph(1, "", raw);
  photograph.raw->extension = ".dng";
  photograph.focal_mm = 35;
  photograph.lens = "Acme 35mm f/2";
  photograph.status = FrameStatus::kComplete;
  photograph.image = {DecodeRaw(raw, "a.dng", RawQuality::kQuick).light, Transfer::kLinear};
  {
    FrameRecorder recorder(scratch / "s", {});
    EXPECT_TRUE(recorder.TryAdd(photograph));
    EXPECT_EQ(recorder.Finish().written, 1u);
  }
  const FrameRecording recording = ReadFrameRecording(scratch / "s");
  ASSERT_EQ(recording.entries.size(), 1u);
  EXPECT_TRUE(recording.entries[0].file.empty());
  const Frame read = ReadRecordedFrame(recording.entries[0]);
  EXPECT_EQ(*read.raw->bytes, raw);
  EXPECT_EQ(read.focal_mm, 35);
  EXPECT_EQ(read.lens, "Acme 35mm f/2");
  EXPECT_EQ(read.image.transfer, Transfer::kLinear);
  ASSERT_EQ(read.image.pixels.size(), photograph.image.pixels.size());
  EXPECT_EQ(cv::norm(read.image.pixels, photograph.image.pixels, cv::NORM_INF), 0);
}

// The photographer of a recording is the recorded one.
TEST(FrameRecording, ReplaysRequestsWithTheirPhotographs) {
  const ScratchFolder scratch;
  {
    FrameRecorder recorder(scratch / "s", {});
    for (int i = 0; i < 6; ++i) {
      recorder.TryAdd(MakeFrame(i, CV_8UC1));
      if (i % 2 == 0) continue;
      Frame still = Photograph(100 + i, SomeJpeg(), "");
      still.device_time_s = 5 + 0.04 * i;
      if (i != 3) still.requested_s = still.device_time_s;  // the second one was released on the body
      recorder.TryAdd(still);
    }
  }
  const auto device = OpenDevice("replay:" + (scratch / "s").string());
  EXPECT_TRUE(device->TakesStills());
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy) << "not before it plays";
  for (const bool asking : {true, false}) {
    device->Start();
    std::vector<std::uint64_t> order;
    int asked = 0;
    while (const auto frame = device->Next(0ms)) {
      order.push_back(frame->id);
      if (asking) asked += device->RequestStill() == StillRequest::kAsked;
    }
    EXPECT_EQ(order, (std::vector<std::uint64_t>{100, 101, 101, 102, 103, 103, 104, 105, 105}));
    EXPECT_EQ(asked, asking ? 2 : 0) << "one at a time, as many as were asked for";
  }
  // At another rate photographs stay with the live frames that they were taken by.
  const auto slow = OpenDevice("replay:" + (scratch / "s").string() + "?fps=2");
  slow->Start();
  std::vector<double> times;
  while (const auto frame = slow->Next(0ms))
    times.push_back(frame->requested_s.value_or(frame->device_time_s));
  EXPECT_THAT(times, ::testing::ElementsAre(0, 0.5, 0.5, 1, 1.5, 1.5, 2, 2.5, 2.5));
}

TEST(FrameRecording, PlayedInTimeNoPhotographIsDropped) {
  const ScratchFolder scratch;
  {
    FrameRecorder recorder(scratch / "s", {});
    for (int i = 0; i < 20; ++i) recorder.TryAdd(MakeFrame(i, CV_8UC1));
    for (int i = 0; i < 6; ++i) recorder.TryAdd(Photograph(i, i == 2 ? "no picture" : SomeJpeg(), ""));
    for (int i = 20; i < 30; ++i) recorder.TryAdd(MakeFrame(i, CV_8UC1));
  }
  const auto device = OpenDevice("replay:" + (scratch / "s").string() + "?speed=1000");
  ASSERT_TRUE(device->IsLive());
  EXPECT_TRUE(device->TakesStills());
  device->Start();
  // Not reading: the recording has been played when it says so.
  const auto until = std::chrono::steady_clock::now() + 20s;
  while (device->ShareDone() != 1 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(1ms);
  std::this_thread::sleep_for(10ms);
  int stills = 0, live = 0;
  while (const auto frame = device->Next(100ms)) ++(frame->kind == FrameKind::kStill ? stills : live);
  EXPECT_EQ(stills, 6);
  const DeviceStatistics statistics = device->Statistics();
  EXPECT_EQ(statistics.delivered, static_cast<std::uint64_t>(stills + live));
  EXPECT_EQ(statistics.delivered + statistics.dropped, 36u);
  EXPECT_EQ(statistics.incomplete, 1u) << "what the recording itself counts is told as well";
  EXPECT_GT(statistics.bytes, 0u);
}

void ExpectWholeAndNamed(const fs::path& dir, const FrameRecorderSummary& summary) {
  const FrameRecording recording = ReadFrameRecording(dir);
  EXPECT_EQ(recording.entries.size(), summary.written);
  for (const auto& entry : recording.entries) EXPECT_NO_THROW(ReadRecordedFrame(entry)) << entry.file;
}

// The disk does not answer at all while sixty frames come: whoever waited for it would wait until it gives
// up.
TEST(FrameRecording, NeverWaitsForTheDisk) {
  const ScratchFolder scratch;
  constexpr std::uint64_t kFrames = 60, kMayWait = 8;
  FrameRecorder recorder(scratch / "s", {}, {.waiting_bytes = kMayWait * 1000 * 1000});
  std::uint64_t taken = 0;
  {
    const HangingDisk disk;
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      taken += recorder.TryAdd(MakeFrame(static_cast<int>(i), CV_8UC1, {1000, 1000}));
      if (i == 0)
        while (!disk.SomebodyWaits()) std::this_thread::sleep_for(1ms);
    }
    EXPECT_FALSE(disk.GaveUp());
    EXPECT_THAT(recorder.Pause().value_or(""), HasSubstr("disk slow"));
  }
  // The one that is being written counts among those that wait.
  EXPECT_EQ(taken, kMayWait);
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written, taken) << "what was taken is written when the disk answers";
  EXPECT_EQ(summary.left_out, kFrames - taken);
  ExpectWholeAndNamed(scratch / "s", summary);
}

TEST(FrameRecording, FullDiskDropsWhatDoesNotFit) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 16 << 20)) GTEST_SKIP() << *problem;
  FrameRecorder recorder(scratch / "s", {});
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(recorder.TryAdd(MakeFrame(i, CV_8UC1, {1000, 1000})));
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written + summary.left_out, 60u);
  EXPECT_GE(summary.written, 14u);
  EXPECT_LE(summary.written, 16u) << "more do not fit";
  EXPECT_THAT(summary.problem, HasSubstr("free some space"));
  ExpectWholeAndNamed(scratch / "s", summary);
}

}  // namespace
}  // namespace ulf::test::frame_recording_test

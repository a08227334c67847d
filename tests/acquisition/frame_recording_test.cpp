#include "acquisition/frame_recording.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"
#include "tests/support/small_disk.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
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
  const CameraModel camera = CameraModel::Pinhole(40, 30, 50);
  FrameRecorder recorder(
      dir, {.uri = "x:1", .maker = "M", .model = "N", .serial = "S", .bus = "b", .problem = ""}, camera);
  for (const Frame& frame : frames) EXPECT_TRUE(recorder.TryAdd(frame));
  recorder.Note("the cable was out");
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written, 5u);
  EXPECT_EQ(summary.left_out, 0u);
  EXPECT_THAT(ReadWholeFile(dir / "frames.jsonl"), HasSubstr("the cable was out"));

  const FrameRecording recording = ReadFrameRecording(dir);
  EXPECT_EQ(recording.device.serial, "S");
  EXPECT_EQ(recording.camera, camera);
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
    EXPECT_EQ(read.known_cam_from_world.has_value(), i == 3);
  }
}

TEST(FrameRecording, ACamerasJpegStaysItself) {
  const ScratchFolder scratch;
  Frame frame = MakeFrame(0, CV_8UC3);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", frame.image.pixels, bytes);
  frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(bytes.begin(), bytes.end())};
  FrameRecorder recorder(scratch / "s", {}, std::nullopt);
  recorder.TryAdd(frame);
  recorder.Finish();
  const Frame read = ReadRecordedFrame(ReadFrameRecording(scratch / "s").entries.at(0));
  ASSERT_TRUE(read.encoded);
  EXPECT_EQ(*read.encoded->bytes, *frame.encoded->bytes);
}

TEST(FrameRecording, ReplaysAsADevice) {
  const ScratchFolder scratch;
  FrameRecorder recorder(scratch / "s",
                         {.uri = "x:1", .maker = "", .model = "", .serial = "S", .bus = "", .problem = ""},
                         CameraModel::Pinhole(40, 30, 50));
  for (int i = 0; i < 3; ++i) recorder.TryAdd(MakeFrame(i));
  recorder.Finish();
  const auto device = OpenDevice("replay:" + (scratch / "s").string());
  EXPECT_EQ(device->Camera(), CameraModel::Pinhole(40, 30, 50));
  EXPECT_THAT(device->Info().model, HasSubstr("recording of 3 frames from x:1"));
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

TEST(FrameRecording, WhatIsTornOrMissingIsToldOrLeftOut) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "s";
  {
    FrameRecorder recorder(dir, {}, std::nullopt);
    for (int i = 0; i < 3; ++i) recorder.TryAdd(MakeFrame(i));
    recorder.Finish();
  }
  EXPECT_THROW(FrameRecorder(dir, {}, std::nullopt), Error) << "never written over";
  std::ofstream(dir / "frames.jsonl", std::ios::app) << "{\"event\": \"frame\", \"id\": 7, \"fi";
  EXPECT_EQ(ReadFrameRecording(dir).entries.size(), 3u) << "killed in the middle of a line";
  fs::remove(dir / "frames" / "00000002.tif");
  const FrameRecording recording = ReadFrameRecording(dir);
  EXPECT_THROW(ReadRecordedFrame(recording.entries[1]), Error);
  std::ofstream(dir / "frames.jsonl", std::ios::app) << "\n{\"event\": \"note\"}\n";
  EXPECT_THROW(ReadFrameRecording(dir), Error) << "damaged in the middle";
}

// A disk that is behind or full: frames are left out and counted, the reader of the camera never waits.
TEST(FrameRecording, NeverWaitsForTheDisk) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 16 << 20)) GTEST_SKIP() << *problem;
  FrameRecorder recorder(scratch / "s", {}, std::nullopt, 8 << 20);
  std::uint64_t refused = 0;
  for (int i = 0; i < 60; ++i) refused += !recorder.TryAdd(MakeFrame(i, CV_8UC1, {1000, 1000}));
  const FrameRecorderSummary summary = recorder.Finish();
  EXPECT_EQ(summary.written + summary.left_out, 60u);
  EXPECT_GE(summary.left_out, refused);
  EXPECT_GT(summary.left_out, 40u) << "sixteen fit";
  EXPECT_FALSE(summary.problem.empty());
  if (summary.written == 0) return;
  const FrameRecording recording = ReadFrameRecording(scratch / "s");
  EXPECT_EQ(recording.entries.size(), summary.written);
  for (const auto& entry : recording.entries) EXPECT_NO_THROW(ReadRecordedFrame(entry)) << entry.file;
}

}  // namespace
}  // namespace ulf::test

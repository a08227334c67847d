// Tests: acquisition/device/replay_device, acquisition/device/replay_source, core/image/files/image_header,
// core/base/name_order.
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <thread>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "acquisition/device/replay_device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/name_order.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/dng_file.h"
#include "tests/support/floors.h"
#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"
#include "tests/support/video/sample_video.h"

namespace ulf::replay_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A picture that is its own number: its grey value.
cv::Mat Numbered(int number, cv::Size size = {64, 48}) {
  return cv::Mat(size, CV_8UC3, cv::Scalar::all(10.0 + 20.0 * number));
}

int NumberOf(const Frame& frame) {
  return static_cast<int>(std::lround((cv::mean(frame.image.pixels)[0] - 10.0) / 20.0));
}

std::vector<Frame> ReadAll(Device& device) {
  std::vector<Frame> frames;
  while (auto frame = device.Next(100ms)) frames.push_back(std::move(*frame));
  return frames;
}

std::vector<Frame> Replay(const std::string& uri) {
  const auto device = OpenDevice(uri);
  device->Start();
  auto frames = ReadAll(*device);
  EXPECT_EQ(device->State(), DeviceState::kEnded);
  return frames;
}

template <typename Thrown = Error>
std::string ErrorOf(const std::string& uri) {
  try {
    Replay(uri);
  } catch (const Thrown& error) {
    return error.what();
  }
  ADD_FAILURE() << uri << ": no error";
  return "";
}

// Each photograph once, its raw file with it, the exposure from there.
TEST(Replay, AFolderOfRawFilesIsDeveloped) {
  const test::ScratchFolder folder;
  const std::string raw = test::DngBytes({}, [](int, int) { return cv::Vec3d(0.2, 0.3, 0.4); });
  for (const char* name : {"a1.dng", "a2.DNG"}) WriteFileAtomically(folder / name, raw);
  const std::vector<Frame> frames = Replay("replay:" + folder.path().string());
  ASSERT_EQ(frames.size(), 2u);
  for (const Frame& frame : frames) {
    EXPECT_EQ(*frame.raw->bytes, raw);
    EXPECT_EQ(frame.raw->extension, ".dng");
    EXPECT_EQ(frame.image.transfer, Transfer::kLinear);
    EXPECT_NEAR(frame.image.pixels.at<cv::Vec3w>(20, 20)[0] / 65535.0, 0.4, 0.002);
    EXPECT_NEAR(frame.exposure_s, 1 / 60.0, 1e-5);
    EXPECT_DOUBLE_EQ(frame.gain, 4);
  }
  for (const char* name : {"a1.jpg", "a2.jpg"}) cv::imwrite((folder / name).string(), Numbered(3));
  const std::vector<Frame> beside = Replay("replay:" + folder.path().string());
  ASSERT_EQ(beside.size(), 2u) << "the JPEGs";
  EXPECT_TRUE(beside[0].encoded && !beside[0].raw);
}

TEST(ReplayFolder, GivesImagesInNameOrderAtTheirTimes) {
  test::ScratchFolder scratch;
  // Written in another order than their names, and counted without leading zeros.
  for (const int number : {10, 2, 0, 9, 1})
    cv::imwrite((scratch / ("view_" + std::to_string(number) + ".png")).string(), Numbered(number));
  const auto frames = Replay("replay:" + scratch.path().string() + "?fps=10");
  ASSERT_EQ(frames.size(), 5u);
  const int expected[] = {0, 1, 2, 9, 10};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(NumberOf(frames[i]), expected[i]);
    EXPECT_EQ(frames[i].id, i);
    EXPECT_DOUBLE_EQ(frames[i].device_time_s, 0.1 * static_cast<double>(i));
    EXPECT_EQ(frames[i].status, FrameStatus::kComplete);
    EXPECT_EQ(frames[i].image.transfer, Transfer::kSrgb);
    EXPECT_FALSE(frames[i].known_cam_from_world);
    EXPECT_FALSE(frames[i].encoded) << "only a camera's JPEG is kept as the file it is";
  }
}

TEST(ReplayFolder, ThirtyFramesASecondUnlessSaid) {
  test::ScratchFolder scratch;
  for (const int number : {0, 1, 2})
    cv::imwrite((scratch / fmt::format("{}.png", number)).string(), Numbered(number));
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  const auto frames = Replay("replay:" + scratch.path().string());
  const std::string of_the_default = said.str();
  Replay("replay:" + scratch.path().string() + "?fps=10");
  spdlog::set_default_logger(logger);
  EXPECT_DOUBLE_EQ(frames.at(0).device_time_s, 0);
  EXPECT_DOUBLE_EQ(frames.at(2).device_time_s, 2.0 / 30);
  EXPECT_THAT(of_the_default, HasSubstr("30 a second"));
  EXPECT_EQ(said.str(), of_the_default) << "a rate that was given is not said";
}

TEST(ReplayFolder, NamesTheJpegFileBehindAFrame) {
  test::ScratchFolder scratch;
  const fs::path file = scratch / "a.jpg";
  cv::imwrite(file.string(), Numbered(3));
  const auto encoded = Replay("replay:" + scratch.path().string()).at(0).encoded;
  ASSERT_TRUE(encoded);
  EXPECT_EQ(*encoded->bytes, ReadWholeFile(file));
}

TEST(ReplayFolder, IsNotLiveAndRestartsFromTheStart) {
  test::ScratchFolder scratch;
  for (const int number : {0, 1, 2})
    cv::imwrite((scratch / fmt::format("{}.png", number)).string(), Numbered(number));
  const auto device = OpenDevice("replay:" + scratch.path().string());
  EXPECT_FALSE(device->IsLive());
  EXPECT_EQ(device->Info().bus, "files");
  EXPECT_FALSE(device->Camera());
  EXPECT_FALSE(device->Next(0ms)) << "not started";
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  device->Start();
  EXPECT_EQ(NumberOf(device->Next(0ms).value()), 0);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  device->Stop();
  EXPECT_FALSE(device->Next(0ms));
  device->Start();
  EXPECT_EQ(ReadAll(*device).size(), 3u);
  EXPECT_EQ(device->Statistics().delivered, 3u);
}

TEST(ReplayFolder, KnowsHowMuchIsDone) {
  test::ScratchFolder scratch;
  for (const int number : {0, 1, 2, 3})
    cv::imwrite((scratch / fmt::format("{}.png", number)).string(), Numbered(number));
  const auto device = OpenDevice("replay:" + scratch.path().string());
  device->Start();
  EXPECT_EQ(device->ShareDone(), 0);
  device->Next(0ms);
  EXPECT_EQ(device->ShareDone(), 0.25);
}

TEST(ReplayInTime, IsLiveAndDropsWhenTheReaderIsSlow) {
  test::ScratchFolder scratch;
  for (int number = 0; number < 12; ++number)
    cv::imwrite((scratch / fmt::format("{}.png", number)).string(), Numbered(number));
  const std::string uri = "replay:" + scratch.path().string() + "?fps=20";
  for (const double speed : {1.0, 4.0}) {
    const auto device = OpenDevice(WithReplaySpeed(uri, speed));
    EXPECT_TRUE(device->IsLive());
    const auto start = std::chrono::steady_clock::now();
    device->Start();
    std::size_t count = 0;
    while (!IsOver(device->State()))
      if (const auto frame = device->Next(20ms)) {
        EXPECT_GT(frame->host_time_s, 1e9);
        ++count;
      }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_GE(seconds, 11 / 20.0 / speed - 0.01) << "not before their time";
    EXPECT_EQ(count + device->Statistics().dropped, 12u) << "a slow machine drops, and counts";
  }
  // A reader that does not read: four wait, the others are gone and counted.
  const auto device = OpenDevice(uri + "&speed=20");
  device->Start();
  std::this_thread::sleep_for(400ms);
  std::vector<int> numbers;
  while (!IsOver(device->State()))
    if (const auto frame = device->Next(20ms)) numbers.push_back(NumberOf(*frame));
  EXPECT_THAT(numbers, ::testing::ElementsAre(8, 9, 10, 11)) << "the newest";
  EXPECT_EQ(device->Statistics().dropped, 8u);
}

TEST(ReplayInTime, StopsAtOnceAndBeginsAgain) {
  test::ScratchFolder scratch;
  for (int number = 0; number < 3; ++number)
    cv::imwrite((scratch / fmt::format("{}.png", number)).string(), Numbered(number));
  const auto device = OpenDevice("replay:" + scratch.path().string() + "?fps=0.1&speed=1");
  for (int round = 0; round < 2; ++round) {
    device->Start();
    const auto frame = device->Next(5s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(NumberOf(*frame), 0);
    const auto start = std::chrono::steady_clock::now();
    device->Stop();
    EXPECT_LT(std::chrono::steady_clock::now() - start, 5s) << "the next frame is ten seconds away";
  }
}

TEST(ReplayInTime, OnlyARecordingHasASpeed) {
  EXPECT_EQ(WithReplaySpeed("sim:studio", std::nullopt), "sim:studio");
  EXPECT_THROW(WithReplaySpeed("sim:studio", 1), Refusal);
  EXPECT_EQ(WithReplaySpeed("replay:a?speed=3&fps=5", 1), "replay:a?fps=5&speed=1");
}

TEST(ReplayFolder, GlobChooses) {
  test::ScratchFolder scratch;
  cv::imwrite((scratch / "0.color.jpg").string(), Numbered(0));
  cv::imwrite((scratch / "1.color.jpg").string(), Numbered(1));
  cv::imwrite((scratch / "0.depth.png").string(), cv::Mat(24, 32, CV_16UC1, cv::Scalar(7)));
  std::ofstream(scratch / "0.pose.txt") << "not an image\n";
  const std::string folder = "replay:" + scratch.path().string();
  EXPECT_EQ(Replay(folder + "?glob=*.color.jpg").size(), 2u);
  EXPECT_EQ(Replay(folder + "?glob=0.*.png").at(0).image.pixels.type(), CV_16UC1);
  EXPECT_THAT(ErrorOf(folder + "?glob=*.tif"), AllOf(HasSubstr("*.tif"), HasSubstr(scratch.path().string())));
  // Without a choice the two kinds are mixed.
  EXPECT_THAT(ErrorOf(folder), AllOf(HasSubstr("0.color.jpg"), HasSubstr("0.depth.png"), HasSubstr("glob")));
}

TEST(ReplayFolder, MixedSizesNameBothFiles) {
  for (const char* kind : {"png", "jpg", "bmp"}) {
    test::ScratchFolder scratch;
    cv::imwrite((scratch / fmt::format("a.{}", kind)).string(), Numbered(0));
    cv::imwrite((scratch / fmt::format("b.{}", kind)).string(), Numbered(1));
    cv::imwrite((scratch / fmt::format("c.{}", kind)).string(), Numbered(2, {65, 48}));
    EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()),
                AllOf(HasSubstr(fmt::format("a.{}", kind)), HasSubstr(fmt::format("c.{}", kind)),
                      HasSubstr("64x48"), HasSubstr("65x48")));
  }
}

TEST(ReplayFolder, MinorityOfMixedPicturesIsNamed) {
  for (const char* kind : {"png", "bmp"}) {
    test::ScratchFolder scratch;
    for (const int number : {0, 1, 2})
      cv::imwrite((scratch / fmt::format("{}.{}", number, kind)).string(),
                  Numbered(number, number == 0 ? cv::Size(65, 48) : cv::Size(64, 48)));
    EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()),
                ::testing::ContainsRegex(
                    fmt::format("0\\.{} is .*65x48.*, but .*1\\.{} and 1 more are .*64x48", kind, kind)));
    EXPECT_THAT(
        [&] { CollectViews(ImagesIn({scratch.path().string()}), Board::Parse("chessboard:8x6:25"), {}); },
        ::testing::ThrowsMessage<Error>(
            AllOf(HasSubstr(fmt::format("0.{}: is 65x48", kind)), HasSubstr("2 of 3 are 64x48"))));
  }
}

TEST(ReplayFolder, PicturesWithAndWithoutAlphaAreMixed) {
  const test::ScratchFolder scratch;
  const std::string plain = PngBytes(Numbered(1));
  for (const char* name : {"a.png", "b.png"}) WriteFileAtomically(scratch / name, plain);
  WriteFileAtomically(scratch / "c.png", test::WithPngChunk(plain, "tRNS", std::string(6, '\0')));
  EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()),
              AllOf(HasSubstr("c.png"), HasSubstr("with alpha")));
}

// In the recording, too, which keeps the numbers and not the file.
TEST(ReplayFolder, RecordingHeaderNamesConversions) {
  const test::ScratchFolder scratch;
  MakeFolder(scratch / "photographs");
  WriteFileAtomically(scratch / "photographs/a.png",
                      test::WithPngChunk(PngBytes(Numbered(3)), "cICP", std::string("\x0C\x0D\0\x01", 4)));
  const auto device = OpenDevice("replay:" + (scratch / "photographs").string());
  EXPECT_THAT(device->Info().remark, AllOf(HasSubstr("a.png"), HasSubstr("Display P3")));
  FrameRecorder recorder(scratch / "recording", RecordingHeader::Of(*device));
  device->Start();
  recorder.TryAdd(*device->Next(100ms));
  EXPECT_EQ(recorder.Finish().written, 1u);
  EXPECT_THAT(ReadWholeFile(scratch / "recording/frames.jsonl"), HasSubstr("Display P3"));
  EXPECT_THAT(ReadFrameRecording(scratch / "recording").header.device.remark, HasSubstr("Display P3"));
}

std::string JpegTakenAt(int number, const std::string& time) {
  return test::WithSegment(JpegBytes(Numbered(number)), test::ExifSegment(time));
}

std::vector<int> NumbersOf(const std::string& uri) {
  std::vector<int> numbers;
  for (const Frame& frame : Replay(uri)) numbers.push_back(NumberOf(frame));
  return numbers;
}

// A camera counts IMG_9999, then IMG_0001.
TEST(ReplayFolder, RestartedNumbersPlayInOrderOfTimes) {
  using ::testing::ElementsAre;
  const test::ScratchFolder scratch;
  const std::string uri = "replay:" + scratch.path().string();
  const auto write = [&](const char* name, int number, const char* time) {
    WriteFileAtomically(scratch / name, JpegTakenAt(number, fmt::format("2026:11:29 10:00:{}", time)));
  };
  write("IMG_9998.JPG", 0, "01");
  write("IMG_9999.JPG", 1, "02");
  write("IMG_0001.JPG", 2, "02");  // two in a second
  write("IMG_0002.JPG", 3, "05");
  EXPECT_THAT(NumbersOf(uri), ElementsAre(0, 1, 2, 3));
  write("IMG_0002.JPG", 3, "00");
  write("IMG_9999.JPG", 1, "00");
  EXPECT_THAT(NumbersOf(uri), ElementsAre(2, 3, 0, 1))
      << "by name: the times are not in order but for one step";
  write("IMG_0002.JPG", 3, "05");
  write("IMG_9999.JPG", 1, "02");
  WriteFileAtomically(scratch / "IMG_0003.JPG", JpegBytes(Numbered(4)));
  EXPECT_THAT(NumbersOf(uri), ElementsAre(2, 3, 4, 0, 1)) << "one does not say when";
}

TEST(ReplayFolder, ReadsJpegEndingsAndNamesOtherKinds) {
  const test::ScratchFolder scratch;
  const std::string uri = "replay:" + scratch.path().string();
  WriteFileAtomically(scratch / "IMG_1.HEIC", std::string(40, 'h'));
  WriteFileAtomically(scratch / "IMG_2.heic", std::string(40, 'h'));
  EXPECT_THAT(ErrorOf(uri), AllOf(HasSubstr("2 files are HEIC"), HasSubstr("heif-convert")));
  WriteFileAtomically(scratch / "a.jfif", JpegBytes(Numbered(1)));
  WriteFileAtomically(scratch / "b.JPE", JpegBytes(Numbered(2)));
  WriteFileAtomically(scratch / "c.MPO", JpegBytes(Numbered(3)));
  WriteFileAtomically(scratch / "d", JpegBytes(Numbered(4)));
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  EXPECT_THAT(NumbersOf(uri), ::testing::ElementsAre(1, 2, 3));
  spdlog::set_default_logger(logger);
  EXPECT_THAT(said.str(), AllOf(HasSubstr("2 files are HEIC"), HasSubstr("(d)")));
}

TEST(ReplayFolder, MixedFormatsNameBothFiles) {
  test::ScratchFolder scratch;
  cv::imwrite((scratch / "a.png").string(), Numbered(0));
  cv::imwrite((scratch / "b.png").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
  EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()), AllOf(HasSubstr("a.png"), HasSubstr("b.png")));
}

TEST(ReplayFolder, AnEmptyFolderAndAMissingOneAreErrors) {
  test::ScratchFolder scratch;
  EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()), HasSubstr("folder is empty"));
  EXPECT_THAT(ErrorOf("replay:" + (scratch / "nowhere").string()), HasSubstr("nowhere"));
  EXPECT_THAT(ErrorOf<Refusal>("replay:"), HasSubstr("path"));
}

TEST(ReplayFolder, ATruncatedImageIsFoundOnOpening) {
  for (const char* kind : {"png", "jpg"}) {
    test::ScratchFolder scratch;
    cv::Mat noise(48, 64, CV_8UC3);
    cv::randu(noise, 0, 255);
    for (const char* name : {"a", "b", "c"})
      cv::imwrite((scratch / fmt::format("{}.{}", name, kind)).string(), noise);
    const fs::path middle = scratch / fmt::format("b.{}", kind);
    fs::resize_file(middle, fs::file_size(middle) / 2);
    EXPECT_THAT([&] { OpenDevice("replay:" + scratch.path().string()); },
                testing::ThrowsMessage<Error>(AllOf(HasSubstr(middle.string()), HasSubstr("truncated"))))
        << kind << ": opened";
  }
}

TEST(ReplayFolder, AFileThatIsNoImageIsAnError) {
  test::ScratchFolder scratch;
  std::ofstream(scratch / "a.png") << "this is text, whatever its name says";
  EXPECT_THAT(ErrorOf("replay:" + scratch.path().string()), HasSubstr("a.png"));
}

TEST(ReplayFolder, OptionsAreChecked) {
  test::ScratchFolder scratch;
  cv::imwrite((scratch / "a.png").string(), Numbered(0));
  const std::string folder = "replay:" + scratch.path().string();
  EXPECT_THAT(ErrorOf<Refusal>(folder + "?fps=0"), HasSubstr("fps"));
  EXPECT_THAT(ErrorOf<Refusal>(folder + "?fps=fast"), HasSubstr("fps"));
  EXPECT_THAT(ErrorOf<Refusal>(folder + "?colour=2"), HasSubstr("colour"));
  EXPECT_THAT(ErrorOf<Refusal>(folder + "?speed=-1"), HasSubstr("speed"));
  EXPECT_THAT(ErrorOf<Refusal>(folder + "?transfer=gamma"), HasSubstr("transfer"));
  EXPECT_EQ(Replay(folder + "?transfer=linear").at(0).image.transfer, Transfer::kLinear);
}

TEST(ReplayVideo, GivesEveryPictureAtItsTime) {
  test::ScratchFolder scratch;
  const std::string file = (scratch / "video.avi").string();
  test::VideoSample sample;
  sample.encoder = "mjpeg";
  sample.format = AV_PIX_FMT_YUVJ420P;
  sample.range = AVCOL_RANGE_JPEG;
  sample.pictures = 10;
  sample.value = [](int number, int plane, int /*x*/, int /*y*/) {
    return plane > 0 ? 128 : 10 + 20 * number;
  };
  test::WriteVideo(file, sample);
  for (const auto& [uri, fps] :
       {std::pair{"replay:" + file, 25.0}, std::pair{"replay:" + file + "?fps=5", 5.0}}) {
    const auto frames = Replay(uri);
    ASSERT_EQ(frames.size(), 10u) << uri;
    for (int i = 0; i < 10; ++i) {
      const Frame& frame = frames[static_cast<std::size_t>(i)];
      EXPECT_EQ(NumberOf(frame), i) << uri;
      EXPECT_NEAR(frame.device_time_s, i / fps, 1e-6) << uri;
      EXPECT_EQ(frame.id, static_cast<std::uint64_t>(i));
    }
  }
}

// Through a recording, too: the lens is the same in millimetres, a pixel is 4/3 times as wide as high.
TEST(ReplayVideo, NonSquarePixelsGiveTwoFocalLengths) {
  test::ScratchFolder scratch;
  test::VideoSample sample;
  sample.aspect_num = 4;
  sample.aspect_den = 3;
  sample.value = [](int number, int plane, int x, int /*y*/) { return plane > 0 ? 128 : 20 + x + number; };
  test::WriteVideo(scratch / "video.mkv", sample);
  const std::string video = "replay:" + (scratch / "video.mkv").string();
  test::RunUlf("record " + video + " -o " + (scratch / "recorded").string());
  for (const std::string& uri : {video, "replay:" + (scratch / "recorded").string()}) {
    const CameraModel camera = ResolveIntrinsics(*OpenDevice(uri), {.focal_px = 90}, 64, 48);
    EXPECT_DOUBLE_EQ(camera.fx, 90) << uri;
    EXPECT_NEAR(camera.fy, 120, 1e-6) << uri;
  }
}

// An element of EBML, the syntax of Matroska files: identifier, length, contents.
std::string Element(std::uint32_t id, const std::string& contents) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8)
    if (id >> shift) bytes += static_cast<char>(id >> shift & 0xff);
  bytes += '\x01';  // a length of seven bytes follows
  for (int shift = 48; shift >= 0; shift -= 8)
    bytes += static_cast<char>(static_cast<std::uint64_t>(contents.size()) >> shift & 0xff);
  return bytes + contents;
}

std::string Number(std::uint32_t id, std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return Element(id, bytes);
}

// A video of numbered pictures at these times.
std::string Matroska(const std::vector<int>& times_ms) {
  std::string blocks = Number(0xE7, 0);
  for (std::size_t i = 0; i < times_ms.size(); ++i) {
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", Numbered(static_cast<int>(i)), jpeg);
    const std::string head{'\x81', static_cast<char>(times_ms[i] >> 8), static_cast<char>(times_ms[i] & 0xff),
                           '\x80'};
    blocks += Element(0xA3, head + std::string(jpeg.begin(), jpeg.end()));
  }
  const std::string video = Element(0xE0, Number(0xB0, 64) + Number(0xBA, 48));
  const std::string track =
      Element(0xAE, Number(0xD7, 1) + Number(0x73C5, 1) + Number(0x83, 1) + Element(0x86, "V_MJPEG") + video);
  return Element(0x1A45DFA3, Element(0x4282, "matroska") + Number(0x4287, 4) + Number(0x4285, 2)) +
         Element(0x18538067, Element(0x1549A966, Number(0x2AD7B1, 1000000)) + Element(0x1654AE6B, track) +
                                 Element(0x1F43B675, blocks));
}

// A camera's frames are not evenly spaced when some were dropped: their times are the container's own.
TEST(ReplayVideo, KeepsTheContainersOwnTimes) {
  test::ScratchFolder scratch;
  const fs::path file = scratch / "video.mkv";
  const std::vector<int> times_ms{0, 40, 80, 480, 500, 533, 1700, 1740};
  std::ofstream(file, std::ios::binary) << Matroska(times_ms);
  const auto frames = Replay("replay:" + file.string());
  ASSERT_EQ(frames.size(), times_ms.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_NEAR(frames[i].device_time_s, 1e-3 * times_ms[i], 1e-3) << i;
    EXPECT_EQ(NumberOf(frames[i]), static_cast<int>(i));
  }
}

TEST(ReplayVideo, RefusesOtherFiles) {
  test::ScratchFolder scratch;
  std::ofstream(scratch / "video.mp4") << "no video at all";
  EXPECT_THAT(ErrorOf("replay:" + (scratch / "video.mp4").string()), HasSubstr("video.mp4"));
}

fs::path WriteLightField(const fs::path& dir, const std::vector<double>& times_s,
                         const std::optional<SensorWindow>& window = {}) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(64, 48, 70);
  header.device_serial = "S1";
  header.device_maker = "Maker";
  header.device_model = "Model";
  header.window = window;
  auto writer = LightFieldWriter::Create(dir, header);
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    Frame frame;
    frame.image.pixels = Numbered(static_cast<int>(i));
    View view;
    view.cam_from_world = LookAt({0.1 * static_cast<double>(i), 0, -1}, {0, 0, 0}, {0, -1, 0});
    frame.device_time_s = times_s[i];
    frame.host_time_s = 1e9 + times_s[i];
    frame.exposure_s = 0.004;
    frame.gain = 2;
    writer.AddView(frame, view);
  }
  writer.SetSubject({{0, 0, 0}, 0.2});
  writer.Close(1);
  return dir;
}

TEST(ReplayLightField, GivesViewsWithAllTheirMetadata) {
  test::ScratchFolder scratch;
  const fs::path dir = WriteLightField(scratch / "lf", {3.5, 3.7, 4.4});
  const auto device = OpenDevice("replay:" + dir.string());
  ASSERT_TRUE(device->Camera());
  EXPECT_EQ(*device->Camera(), CameraModel::Pinhole(64, 48, 70));
  EXPECT_EQ(device->Info().serial, "S1") << "a calibration is held against it";
  device->Start();
  const auto frames = ReadAll(*device);
  const LightField light_field = ReadLightField(dir);
  ASSERT_EQ(frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const View& view = light_field.views[i];
    EXPECT_EQ(NumberOf(frames[i]), static_cast<int>(i));
    EXPECT_DOUBLE_EQ(frames[i].device_time_s, view.device_time_s);
    EXPECT_DOUBLE_EQ(frames[i].host_time_s, view.host_time_s);
    EXPECT_DOUBLE_EQ(frames[i].exposure_s, 0.004);
    EXPECT_DOUBLE_EQ(frames[i].gain, 2);
    ASSERT_TRUE(frames[i].known_cam_from_world);
    EXPECT_LT((frames[i].known_cam_from_world->Matrix() - view.cam_from_world.Matrix()).norm(), 1e-12);
  }
  EXPECT_DOUBLE_EQ(frames[2].device_time_s, 4.4);
}

// A calibration of the whole sensor is moved to the region that the views show; unknown, it is scaled, and
// that is said.
TEST(ReplayLightField, NamesTheCameraAndItsRegion) {
  test::ScratchFolder scratch;
  const SensorWindow region{
      .sensor_width = 128, .sensor_height = 96, .x = 60, .y = 40, .width = 64, .height = 48};
  const auto file = scratch / "camera.json";
  CalibrationFile calibration;
  calibration.identity.serial = "S1";
  calibration.modes["live"].camera = CameraModel::Pinhole(128, 96, 70);
  calibration.modes["live"].window = SensorWindow{128, 96, 0, 0, 128, 96};
  WriteCalibrationFile(file, calibration);
  const auto resolve = [&](const fs::path& dir) {
    const auto device = OpenDevice("replay:" + dir.string());
    EXPECT_EQ(device->Info().maker, "Maker");
    EXPECT_EQ(device->Info().model, "Model");
    return ResolveCalibration(*device, {.calibration_path = file.string()}, 64, 48, "live");
  };
  const fs::path known = WriteLightField(scratch / "known", {0, 1}, region);
  const ResolvedCalibration moved = resolve(known);
  EXPECT_EQ(moved.camera.fx, 70);
  EXPECT_EQ(moved.camera.cx, 4);
  EXPECT_THAT(moved.warnings, ::testing::IsEmpty());
  fs::remove(known / "journal.jsonl");  // as by a program that goes by the derived file alone
  EXPECT_EQ(resolve(known).camera.cx, 4);

  const ResolvedCalibration scaled = resolve(WriteLightField(scratch / "unknown", {0, 1}));
  EXPECT_EQ(scaled.camera.fx, 35);
  EXPECT_THAT(scaled.warnings, ::testing::ElementsAre(HasSubstr("unknown which part these frames show")));
}

TEST(ReplayLightField, TimesThatDoNotIncreaseAreReplaced) {
  test::ScratchFolder scratch;
  const fs::path dir = WriteLightField(scratch / "lf", {0, 0, 0});
  const auto frames = Replay("replay:" + dir.string() + "?fps=4");
  EXPECT_DOUBLE_EQ(frames.at(2).device_time_s, 0.5);
  EXPECT_DOUBLE_EQ(Replay("replay:" + dir.string()).at(1).device_time_s, 1.0 / 30);
}

TEST(ReplayOfRealData, ReadsTheKitchenFolderAndVideo) {
  ULF_NEED_TEST_DATA(kitchen, "handheld_kitchen");
  const auto folder = OpenDevice("replay:" + kitchen.string() + "?glob=*.color.jpg");
  folder->Start();
  for (int i = 0; i < 3; ++i) {
    const auto frame = folder->Next(1s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->image.pixels.size(), cv::Size(640, 480));
    ASSERT_TRUE(frame->encoded);
    EXPECT_EQ(*frame->encoded->bytes, ReadWholeFile(kitchen / fmt::format("frame-{:06}.color.jpg", i)));
    EXPECT_DOUBLE_EQ(frame->device_time_s, i / 30.0);
  }
  const auto video = OpenDevice("replay:" + (kitchen / "first300.mp4").string());
  video->Start();
  int count = 0;
  double last_s = -1;
  while (const auto frame = video->Next(1s)) {
    EXPECT_GT(frame->device_time_s, last_s);
    last_s = frame->device_time_s;
    EXPECT_EQ(frame->image.pixels.size(), cv::Size(640, 480));
    ++count;
  }
  EXPECT_EQ(count, 300);
  EXPECT_NEAR(last_s, 299 / 30.0, 0.01);
}

TEST(NameOrder, SortsNumbersNaturally) {
  EXPECT_TRUE(NameOrder("a2", "a10"));
  EXPECT_FALSE(NameOrder("a10", "a2"));
  EXPECT_TRUE(NameOrder("frame-000009.color", "frame-000010.color"));
  EXPECT_TRUE(NameOrder("a", "b"));
  EXPECT_TRUE(NameOrder("a", "a1"));
  EXPECT_TRUE(NameOrder("a01", "a1"));
  EXPECT_FALSE(NameOrder("a1", "a01"));
  EXPECT_FALSE(NameOrder("a1", "a1"));
}

}  // namespace
}  // namespace ulf::replay_test

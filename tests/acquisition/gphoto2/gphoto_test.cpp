// Tests: acquisition/gphoto2/gphoto_device, acquisition/gphoto2/gphoto_camera,
// acquisition/gphoto2/gphoto_features, acquisition/gphoto2/gphoto_options,
// acquisition/gphoto2/camera_settings, acquisition/gphoto2/photograph_downloads,
// acquisition/gphoto2/unfetched_photographs, acquisition/gphoto2/ptpip_descriptors,
// acquisition/gphoto2/photograph_recovery, acquisition/gphoto2/camera_watch.
//
// A tethered camera over the stock ptp2 driver, on loopback.
#include <fcntl.h>
#include <unistd.h>

#include <fstream>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/device.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/ptpip_descriptors.h"
#include "acquisition/gphoto2/unfetched_photographs.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/simulated_board.h"
#include "core/base/error.h"
#include "tests/acquisition/gphoto2/gphoto_fixture.h"
#include "tests/support/dng_file.h"
#include "tests/support/floors.h"
#include "tests/support/ptp_wire.h"

namespace ulf::test::gphoto_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST_F(GphotoTest, GivesLiveViewAndAPhotograph) {
  Begin();
  auto device = Open("?liveview_fps=60");
  EXPECT_EQ(device->Info().maker, "Nikon Corporation");
  EXPECT_EQ(device->Info().model, "ULF test camera");
  EXPECT_EQ(device->Info().serial, "3001234");
  EXPECT_TRUE(device->TakesStills());
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy) << "not before it streams";
  device->Start();
  const auto live = AwaitLive(*device);
  ASSERT_TRUE(live);
  EXPECT_EQ(live->image.width(), 320);
  EXPECT_FALSE(live->encoded);

  const double asked_s = live->host_time_s;
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy) << "one at a time";
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->status, FrameStatus::kComplete);
  EXPECT_EQ(still->image.width(), 960);
  ASSERT_TRUE(still->encoded);
  EXPECT_EQ(*still->encoded->bytes, NumberedJpeg(1, 960, 640)) << "byte for byte";
  EXPECT_FALSE(still->raw);
  EXPECT_GE(still->device_time_s, asked_s - 0.001) << "the moment of the release, on the host's clock";
  EXPECT_LE(still->device_time_s, still->host_time_s);
  EXPECT_DOUBLE_EQ(still->exposure_s, 0.008) << "without Exif: as set on the camera";
  EXPECT_DOUBLE_EQ(still->gain, 2);
  ASSERT_TRUE(still->f_number);
  EXPECT_DOUBLE_EQ(*still->f_number, 5.6);
  EXPECT_TRUE(AwaitLive(*device)) << "live view goes on";
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked) << "and so does photographing";
  const auto second = AwaitStill(*device);
  ASSERT_TRUE(second);
  EXPECT_EQ(*second->encoded->bytes, NumberedJpeg(2, 960, 640));
  EXPECT_THAT(camera_->FilesKept(), ElementsAre("DSC_0001.JPG", "DSC_0002.JPG"))
      << "nothing is deleted from a card";
  device->Stop();
  EXPECT_EQ(device->State(), DeviceState::kEnded);
  EXPECT_TRUE(device->Info().problem.empty());
}

TEST_F(GphotoTest, DeliversAShotFromTheBody) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  for (int number = 1; number <= 3; ++number) camera_->PressShutter();
  for (int number = 1; number <= 3; ++number) {
    const auto still = AwaitStill(*device);
    ASSERT_TRUE(still) << number;
    EXPECT_EQ(*still->encoded->bytes, NumberedJpeg(number, 960, 640));
  }
}

// Who released the shutter nobody says: whichever comes first is taken for the answer.
TEST_F(GphotoTest, BodyShotIsDeliveredBesideARequestedOne) {
  PtpipCameraOptions options;
  options.shutter_lag_s = 0.2;
  for (const bool body_first : {true, false}) {
    Begin(NumberedPhotograph, options);
    auto device = Open();
    device->Start();
    ASSERT_TRUE(AwaitLive(*device));
    if (body_first) camera_->PressBeforeNextRelease();
    ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
    if (!body_first) {
      ASSERT_TRUE(Until(*device, [&] { return camera_->ReleasesAsked() == 1; }));
      camera_->PressShutter();
    }
    const auto first = AwaitStill(*device), second = AwaitStill(*device);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(*first->encoded->bytes, NumberedJpeg(1, 960, 640));
    EXPECT_EQ(*second->encoded->bytes, NumberedJpeg(2, 960, 640));
    ASSERT_TRUE(first->requested_s);
    EXPECT_EQ(first->device_time_s, *first->requested_s);
    EXPECT_FALSE(second->requested_s) << "one request has one answer";
    EXPECT_EQ(device->RequestStill(), StillRequest::kAsked) << "which was enough";
  }
}

TEST_F(GphotoTest, ADownloadThatFailsIsTriedAgain) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->FailDownloads(2);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(*still->encoded->bytes, NumberedJpeg(1, 960, 640));
  EXPECT_TRUE(still->requested_s);
  EXPECT_THAT(Said(*device),
              AllOf(HasSubstr("DSC_0001.JPG could not be downloaded"), HasSubstr("tries again")));
}

TEST_F(GphotoTest, UnfetchableFileIsNamedAndCounted) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->FailDownloads(1000);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  EXPECT_TRUE(
      Until(*device, [&] { return Said(*device).find("copy it from the card") != std::string::npos; }));
  EXPECT_THAT(said_, HasSubstr("DSC_0001.JPG was not downloaded"));
  const auto transport = device->Statistics().transport;
  EXPECT_THAT(transport, ::testing::Contains(::testing::Pair(TransportFigure::kNotDownloaded, 1)));
  camera_->FailDownloads(0);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked) << "photographing goes on at once";
  EXPECT_TRUE(AwaitStill(*device));
  // The link goes with a file still in the camera: that one is named, too.
  camera_->FailDownloads(1000);
  camera_->PressShutter();
  EXPECT_TRUE(
      Until(*device, [&] { return Said(*device).find("DSC_0003.JPG could not") != std::string::npos; }));
  camera_->DropLink();
  EXPECT_TRUE(Until(*device, [&] { return device->State() == DeviceState::kLost; }));
  EXPECT_THAT(Said(*device), HasSubstr("DSC_0003.JPG; fetched when the camera is back"));
}

TEST_F(GphotoTest, FileGoneFromTheCameraIsGivenUp) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->FailDownloads(1);
  camera_->PressShutter();
  EXPECT_TRUE(Until(*device, [&] { return Said(*device).find("tries again") != std::string::npos; }));
  camera_->Forget();
  EXPECT_TRUE(Until(*device, [&] { return device->Statistics().transport.at(1).second == 1; }));
  EXPECT_THAT(Said(*device), HasSubstr("DSC_0001.JPG was"));
  EXPECT_TRUE(AwaitLive(*device));
}

// An answer that comes too late would be taken for the next one's: such a connection is of no use any more.
TEST_F(GphotoTest, ACameraThatHangsIsOpenedAgain) {
  using namespace ptp;
  // Any will do; these two the library passes over without a word in its results.
  for (const std::uint16_t operation : {kGetProperty, kGetObjectInfo}) {
    SCOPED_TRACE(fmt::format("operation {:#x}", operation));
    Begin();
    auto device = OpenDevice(camera_->Uri() + "?liveview_fps=30");
    device->Start();
    ASSERT_TRUE(AwaitLive(*device));
    camera_->Stall(operation, 3.5);
    camera_->SetProperty(kPtpIso, 400);  // a reason to ask for settings
    device->RequestStill();
    const auto began = std::chrono::steady_clock::now();
    const auto until = began + std::chrono::seconds(30);
    int live_in_a_row = 0;
    auto last = began;
    while ((camera_->IsToStall() || live_in_a_row < 30) && std::chrono::steady_clock::now() < until) {
      const auto frame = device->Next(milliseconds(50));
      const auto now = std::chrono::steady_clock::now();
      if (!frame || now - last > std::chrono::seconds(1)) live_in_a_row = 0;
      if (frame) last = now;
      if (frame && frame->kind == FrameKind::kLive) ++live_in_a_row;
    }
    EXPECT_GE(live_in_a_row, 30);
    EXPECT_EQ(device->Statistics().reconnects, 1u);
    ASSERT_TRUE(Until(*device, [&] { return device->RequestStill() == StillRequest::kAsked; }));
    EXPECT_TRUE(AwaitStill(*device));
  }
}

TEST_F(GphotoTest, SlowReaderLosesLiveFramesOnly) {
  Begin();
  auto device = Open("?liveview_fps=100&queue=2");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  for (int number = 1; number <= 4; ++number) camera_->PressShutter();
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  // Not reading: the device's own count of photographs says when they are all there.
  const auto downloaded = [&] { return device->Statistics().transport.at(0).second; };
  while ((downloaded() < 4 || device->Statistics().dropped == 0) && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(milliseconds(10));
  EXPECT_GT(device->Statistics().dropped, 0u);
  for (int number = 1; number <= 4; ++number) {
    const auto frame = device->Next(milliseconds(0));
    ASSERT_TRUE(frame) << number;
    EXPECT_EQ(frame->kind, FrameKind::kStill) << "photographs go first";
    EXPECT_EQ(*frame->encoded->bytes, NumberedJpeg(number, 960, 640));
  }
}

TEST_F(GphotoTest, ABusyCameraIsWaitedFor) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->AnswerBusy(3);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  EXPECT_TRUE(AwaitStill(*device));
  EXPECT_EQ(camera_->BusyAnswers(), 3);
  EXPECT_EQ(camera_->Releases(), 1);
  EXPECT_THAT(Said(*device), HasSubstr("the camera is busy"));
}

TEST_F(GphotoTest, FullCardIsReportedAndShootingGoesOn) {
  Begin();
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->SetCardFull(true);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  EXPECT_TRUE(Until(*device, [&] { return Said(*device).find("the card is full") != std::string::npos; }));
  camera_->SetCardFull(false);
  StillRequest asked = StillRequest::kBusy;
  EXPECT_TRUE(Until(*device, [&] { return (asked = device->RequestStill()) == StillRequest::kAsked; }));
  EXPECT_TRUE(AwaitStill(*device));
}

TEST_F(GphotoTest, DroppedLinkIsLostWithItsReason) {
  for (const bool while_photographing : {false, true}) {
    Begin();
    auto device = Open("?liveview_fps=60");
    device->Start();
    ASSERT_TRUE(AwaitLive(*device));
    camera_->PressShutter();
    ASSERT_TRUE(Until(*device, [&] { return device->Statistics().transport.at(0).second >= 1; }));
    if (while_photographing) device->RequestStill();
    camera_->Refuse(true);
    camera_->DropLink();
    EXPECT_TRUE(Until(*device, [&] { return device->State() == DeviceState::kLost; }));
    EXPECT_THAT(device->Info().problem, HasSubstr("no longer answers"));
    EXPECT_EQ(device->RequestStill(), StillRequest::kBusy);
    device->Stop();
    EXPECT_THAT([&] { device->Start(); }, ThrowsMessage<Error>(HasSubstr("open the device again")));
    device.reset();
    EXPECT_THAT([&] { Open(); }, ThrowsMessage<Error>(HasSubstr("network mode")));
    camera_->Refuse(false);
    device = Open();
    device->Start();
    EXPECT_TRUE(AwaitLive(*device)) << "opened anew when it is back";
    device.reset();
  }
}

// The library closes descriptor 0 with a network camera, and forgets its connections.
TEST_F(GphotoTest, ClosingKeepsFilesAndEndsConnections) {
  Begin();
  const auto open_files = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  Open()->Start();  // whatever the library opens once and for all
  const fs::path zero = fs::read_symlink("/proc/self/fd/0");
  const auto before = open_files();
  for (int i = 0; i < 3; ++i) {
    auto device = Open();
    device->Start();
    ASSERT_TRUE(AwaitLive(*device));
    EXPECT_EQ(ConnectionsTo("127.0.0.1", camera_->Port()).size(), 2u);
    device.reset();
    EXPECT_EQ(ConnectionsTo("127.0.0.1", camera_->Port()).size(), 0u);
    EXPECT_EQ(fs::read_symlink("/proc/self/fd/0"), zero);
  }
  camera_->DropLink();  // lets go of the responder's own ends
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (open_files() > before && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(milliseconds(5));  // their threads end
  EXPECT_LE(open_files(), before);
  // Descriptor 0 has become a file of ours, and after that nothing at all.
  auto device = Open();
  const int saved = dup(0);
  const int journal = open((home_ / "journal").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(dup2(journal, 0), 0);
  device.reset();
  EXPECT_EQ(fs::read_symlink("/proc/self/fd/0"), home_ / "journal");
  EXPECT_EQ(ConnectionsTo("127.0.0.1", camera_->Port()).size(), 0u);
  device = Open();
  close(0);
  device.reset();
  EXPECT_EQ(fcntl(0, F_GETFD), -1);
  dup2(saved, 0);
  close(saved);
  close(journal);
}

TEST_F(GphotoTest, DownloadedPhotographOutlivesTheLink) {
  Begin();
  auto device = Open("?liveview_fps=5");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->PressShutter();
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (device->Statistics().transport.at(0).second < 1 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(milliseconds(5));
  camera_->DropLink();
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_TRUE(AwaitStill(*device));
  EXPECT_TRUE(Until(*device, [&] { return device->State() == DeviceState::kLost; }));
}

TEST_F(GphotoTest, ASlowDownloadIsWaitedFor) {
  PtpipCameraOptions slow;
  slow.download_bytes_per_s = 400e3;
  Begin(
      [](int number) -> std::vector<PtpipFile> {
        cv::Mat noise(700, 1000, CV_8UC3);
        cv::theRNG().state = 7;
        cv::randu(noise, 0, 255);
        std::vector<unsigned char> bytes;
        cv::imencode(".jpg", noise, bytes);
        return {{FileName(number), std::string(bytes.begin(), bytes.end())}};
      },
      slow);
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->status, FrameStatus::kComplete);
  EXPECT_GT(still->host_time_s - still->device_time_s, 0.8) << "it took that long";
}

TEST_F(GphotoTest, SettingsAreLockedAndReadBack) {
  Begin();
  auto device = Open("?shutter=1/250&iso=400&aperture=8&focus=manual&imageformat=fine");
  EXPECT_EQ(camera_->Property(kPtpExposure), 40u) << "tenths of a millisecond";
  EXPECT_EQ(camera_->Property(kPtpIso), 400u);
  EXPECT_EQ(camera_->Property(kPtpFNumber), 800u);
  EXPECT_EQ(camera_->Property(kPtpFocusMode), 1u);
  EXPECT_EQ(camera_->Property(kPtpImageFormat), 2u);
  EXPECT_EQ(camera_->Property(kPtpProgram), 1u) << "manual exposure without being asked for";
  EXPECT_THAT(Said(*device), IsEmpty());
  device->Start();
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_DOUBLE_EQ(still->exposure_s, 0.004);
  EXPECT_DOUBLE_EQ(still->gain, 4);
}

TEST_F(GphotoTest, UnofferedSettingListsWhatIsOffered) {
  Begin();
  EXPECT_THAT([&] { Open("?iso=12345"); }, ThrowsMessage<Refusal>(HasSubstr("100, 200, 400, 800, 1600")));
  EXPECT_THAT([&] { Open("?shutter=quick"); }, ThrowsMessage<Refusal>(HasSubstr("0.0080s")));
  EXPECT_THAT([&] { Open("?zoom=2"); }, ThrowsMessage<Refusal>(HasSubstr("known are")));
  EXPECT_THAT([&] { Open("?target=disk"); }, ThrowsMessage<Refusal>(HasSubstr("card or ram")));
  EXPECT_THAT([] { OpenDevice("gphoto2:ptpip:127.0.0.1:port"); },
              ThrowsMessage<Refusal>(HasSubstr("not a port")));
  EXPECT_THAT([] { OpenDevice("gphoto2:usb:255,255"); },
              ThrowsMessage<Error>(HasSubstr("gphoto2:usb:255,255")));
}

TEST_F(GphotoTest, ASettingThatTheCameraTurnsIsToldAndUsed) {
  Begin();
  auto device = Open("?iso=400");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  EXPECT_THAT(Said(*device), HasSubstr("focus is automatic"));
  camera_->SetProperty(kPtpIso, 800);
  camera_->SetProperty(kPtpBattery, 5);
  EXPECT_TRUE(Until(*device, [&] {
    const std::string& said = Said(*device);
    return said.find("iso changed from '400' to '800'") != std::string::npos &&
           said.find("the battery is low (5%)") != std::string::npos;
  })) << said_;
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_DOUBLE_EQ(still->gain, 8);
}

TEST_F(GphotoTest, RawFileBesideItsJpegOrAloneIsKept) {
  const std::string raw_bytes = "raw bytes that nobody reads here";
  std::atomic<bool> raw_only{false};
  Begin([&](int number) -> std::vector<PtpipFile> {
    std::vector<PtpipFile> files{{FileName(number, "NEF"), raw_bytes}};
    if (!raw_only) files.push_back({FileName(number), NumberedJpeg(number, 960, 640)});
    return files;
  });
  auto device = Open("?imageformat=NEF+Basic");
  device->Start();
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(*still->encoded->bytes, NumberedJpeg(1, 960, 640));
  ASSERT_TRUE(still->raw);
  EXPECT_EQ(still->raw->extension, ".nef");
  EXPECT_EQ(*still->raw->bytes, raw_bytes);
  device.reset();

  raw_only = true;
  device = Open("?imageformat=NEF (Raw)");
  EXPECT_THAT(Said(*device),
              HasSubstr("set imageformat= to one of JPEG Basic, JPEG Normal, JPEG Fine, NEF+Basic"));
  device->Start();
  device->RequestStill();
  const auto raw = AwaitStill(*device);
  ASSERT_TRUE(raw);
  EXPECT_EQ(raw->status, FrameStatus::kIncomplete);
  EXPECT_FALSE(raw->encoded);
  EXPECT_EQ(*raw->raw->bytes, raw_bytes);
  EXPECT_THAT(Said(*device), HasSubstr("is no raw file of a kind that LibRaw"));
}

TEST_F(GphotoTest, LoneRawFileIsDevelopedWithItsSettings) {
  DngCamera sensor;
  sensor.exposure_s = 1 / 30.0;
  const std::string bytes = DngBytes(sensor, [](int, int) { return cv::Vec3d(0.1, 0.3, 0.5); });
  Begin([&](int number) -> std::vector<PtpipFile> { return {{FileName(number, "NEF"), bytes}}; });
  auto device = Open("?imageformat=NEF (Raw)");
  device->Start();
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->status, FrameStatus::kComplete);
  EXPECT_TRUE(still->requested_s);
  EXPECT_EQ(*still->raw->bytes, bytes);
  EXPECT_EQ(still->image.transfer, Transfer::kLinear);
  ASSERT_EQ(still->image.pixels.size(), cv::Size(96, 64));
  const cv::Vec3w light = still->image.pixels.at<cv::Vec3w>(20, 20);
  EXPECT_NEAR(light[0] / 65535.0, 0.5, 0.002);
  EXPECT_NEAR(light[2] / 65535.0, 0.1, 0.002);
  EXPECT_NEAR(still->exposure_s, 1 / 30.0, 1e-5) << "by the file, not by the camera's setting";
  EXPECT_DOUBLE_EQ(still->gain, 4);
  EXPECT_NEAR(still->focal_mm.value_or(0), 35, 1e-3);
  EXPECT_NEAR(still->f_number.value_or(0), 5.6, 1e-3);
  EXPECT_EQ(still->lens, "Acme 35mm f/2");
}

// The next photograph, whether the link holds or not.
std::optional<Frame> AwaitStillAcrossAGap(Device& device) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < until)
    if (auto frame = device.Next(milliseconds(100)); frame && frame->kind == FrameKind::kStill) return frame;
  return std::nullopt;
}

// What the camera took while nobody could hear of it, each file once, in order, the request's answer as such.
TEST_F(GphotoTest, FetchesLeftPhotographsAfterReconnect) {
  for (const bool of_a_request : {false, true}) {
    PtpipCameraOptions options;
    options.shutter_lag_s = 0.2;
    Begin(NumberedPhotograph, options);
    auto device = OpenDevice(camera_->Uri() + "?liveview_fps=60");
    device->Start();
    ASSERT_TRUE(AwaitLive(*device));
    camera_->PressShutter();
    ASSERT_TRUE(AwaitStill(*device));
    if (of_a_request) {
      ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
      ASSERT_TRUE(Until(*device, [&] { return camera_->ReleasesAsked() >= 1; }));
    }
    camera_->Refuse(true);
    camera_->DropLink();
    if (!of_a_request) {
      camera_->PressShutter();
      camera_->PressShutter();
    }
    const int taken = of_a_request ? 2 : 3;
    ASSERT_TRUE(
        Until(*device, [&] { return camera_->FilesKept().size() == static_cast<std::size_t>(taken); }));
    camera_->Refuse(false);
    for (int number = 2; number <= taken; ++number) {
      const auto still = AwaitStillAcrossAGap(*device);
      ASSERT_TRUE(still) << number << "\n" << Said(*device);
      EXPECT_EQ(*still->encoded->bytes, NumberedPhotograph(number).front().bytes);
      EXPECT_EQ(still->requested_s.has_value(), of_a_request);
    }
    EXPECT_THAT(Said(*device), HasSubstr("stayed in the camera when its link dropped"));
    EXPECT_THAT(said_, HasSubstr("DSC_0002.JPG"));
    camera_->AnnounceAgain();  // events that it kept for whoever asks
    camera_->PressShutter();
    const auto next = AwaitStill(*device);
    ASSERT_TRUE(next);
    EXPECT_EQ(*next->encoded->bytes, NumberedPhotograph(taken + 1).front().bytes) << "none comes twice";
    EXPECT_EQ(device->Statistics().reconnects, 1u);
    device.reset();
    said_.clear();
  }
}

TEST_F(GphotoTest, FetchesABrokenDownloadAfterReconnect) {
  PtpipCameraOptions slow;
  slow.download_bytes_per_s = 20e3;
  cv::Mat noise(640, 960, CV_8UC3);
  cv::randu(noise, 0, 255);
  std::vector<unsigned char> encoded;
  cv::imencode(".jpg", noise, encoded, {cv::IMWRITE_JPEG_QUALITY, 5});
  const std::string bytes(encoded.begin(), encoded.end());
  ASSERT_GT(bytes.size(), 20'000u) << "a second at least";
  Begin([&](int number) -> std::vector<PtpipFile> { return {{FileName(number), bytes}}; }, slow);
  auto device = OpenDevice(camera_->Uri() + "?liveview_fps=5");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->PressShutter();
  ASSERT_TRUE(Until(*device, [&] { return camera_->Releases() == 1; }));
  for (int drops = 1; drops <= 2; ++drops) {  // the second while it is being fetched
    std::this_thread::sleep_for(milliseconds(500));
    camera_->DropLink();
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (device->Statistics().reconnects < static_cast<std::uint64_t>(drops) &&
           std::chrono::steady_clock::now() < until) {
      const auto frame = device->Next(milliseconds(50));
      ASSERT_FALSE(frame && frame->kind == FrameKind::kStill) << "half a file";
    }
  }
  const auto still = AwaitStillAcrossAGap(*device);
  ASSERT_TRUE(still) << Said(*device);
  EXPECT_EQ(*still->encoded->bytes, bytes);
  EXPECT_EQ(still->status, FrameStatus::kComplete);
  EXPECT_EQ(device->Statistics().reconnects, 2u);
  EXPECT_EQ(FigureIn(device->Statistics().transport, TransportFigure::kNotDownloaded), 0)
      << "it was, in the end";
}

// A card with photographs of earlier sessions, among them higher numbers and the other file of the last name,
// and a camera whose clock is a quarter of a century slow.
TEST_F(GphotoTest, OlderPhotographsStayOnTheCard) {
  const auto photograph = [](int number) -> std::vector<PtpipFile> {
    DngCamera sensor;
    sensor.exposure_s = 1.0 / (10 * number);
    const std::string written = fmt::format("19990501T1200{:02}", 10 * number);
    return {{FileName(number, "NEF"), DngBytes(sensor, [](int, int) { return cv::Vec3d(0.1, 0.3, 0.5); }),
             written}};
  };
  Begin(photograph);
  const std::string old = NumberedJpeg(99, 960, 640);
  for (const char* name : {"DSC_0000.JPG", "DSC_0001.JPG", "DSC_0500.JPG", "DSC_0501.NEF"})
    camera_->PutOnCard({name, old, "19980501T120000"});
  auto device = OpenDevice(camera_->Uri() + "?liveview_fps=30&imageformat=NEF (Raw)");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->PressShutter();
  ASSERT_TRUE(AwaitStill(*device));
  camera_->Refuse(true);
  camera_->DropLink();
  const double dropped_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (int i = 0; i < 3; ++i) camera_->PressShutter();
  ASSERT_TRUE(Until(*device, [&] { return camera_->FilesKept().size() == 8; }));
  camera_->PutOnCard({"DSC_0003.MOV", "a film", "19990501T120035"});
  camera_->Refuse(false);
  for (int number = 2; number <= 4; ++number) {
    const auto still = AwaitStillAcrossAGap(*device);
    ASSERT_TRUE(still) << number << "\n" << Said(*device);
    EXPECT_EQ(*still->raw->bytes, photograph(number).front().bytes) << "in their order";
    EXPECT_NEAR(still->exposure_s, 1.0 / (10 * number), 1e-5);
    EXPECT_NEAR(still->device_time_s, dropped_s, 5) << "the host's time, not the camera's";
    EXPECT_FALSE(still->requested_s);
  }
  EXPECT_THAT(Said(*device), HasSubstr("3 files not fetched"));
  EXPECT_THAT(said_, HasSubstr("DSC_0500.JPG"));
  camera_->PressShutter();
  const auto next = AwaitStill(*device);
  ASSERT_TRUE(next);
  EXPECT_EQ(*next->raw->bytes, photograph(5).front().bytes) << "and nothing between";
}

TEST(LeftPhotographsTest, AreThoseAfterTheLastAnnounced) {
  UnfetchedPhotographs photographs;
  photographs.Announced({"/card", "DSC_0009.JPG"});
  EXPECT_FALSE(photographs.Take()) << "the link was not lost";
  photographs.Lost({.waiting = {}, .released_s = 7, .lost_s = 9});
  const auto left = photographs.Take();
  ASSERT_TRUE(left);
  EXPECT_FALSE(photographs.Take()) << "once";
  const auto files = UnfetchedPhotographs::CameSince(
      *left,
      photographs.PhotographsAfter(*left, {"DSC_0011.JPG", "DSC_0008.JPG", "DSC_0010.NEF", "DSC_0009.JPG",
                                           "DSC_0010.JPG", "DSC_0009.NEF", "DSC_0010.MOV"}));
  std::vector<std::string> names;
  for (const auto& [where, file] : files) {
    EXPECT_EQ(where.folder, "/card");
    EXPECT_EQ(file.released_s, StemOf(file.name) == "dsc_0010" ? 7 : 0) << file.name;
    EXPECT_EQ(file.is_late, file.name == "DSC_0009.NEF");
    EXPECT_EQ(file.announced_s, 9);
    names.push_back(where.name);
  }
  EXPECT_THAT(names, ElementsAre("DSC_0009.NEF", "DSC_0010.JPG", "DSC_0010.NEF", "DSC_0011.JPG"));
  photographs.Announced({"/card", "DSC_0012.JPG"});
  photographs.Lost(*left);
  EXPECT_EQ(photographs.Take()->last->name, "DSC_0009.JPG") << "lost again before they were fetched";
  EXPECT_THAT(UnfetchedPhotographs().PhotographsAfter({}, {"DSC_0001.JPG"}), ::testing::IsEmpty())
      << "none was announced: nobody can tell which are new";
}

TEST_F(GphotoTest, PhotographsOwnDataOverrideSettings) {
  Begin([](int number) -> std::vector<PtpipFile> {
    return {{FileName(number), WithExif(NumberedJpeg(number, 960, 640))}};
  });
  auto device = Open();
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->lens, "Acme 50mm f/1.8");
  EXPECT_EQ(still->status, FrameStatus::kComplete);
  EXPECT_NEAR(still->exposure_s, 1.0 / 60, 1e-9);
  EXPECT_NEAR(still->gain, 6.4, 1e-9);
  EXPECT_NEAR(still->f_number.value(), 7.1, 1e-9);
}

TEST_F(GphotoTest, DamagedFileIsAnIncompleteStill) {
  const std::string cut = NumberedJpeg(1, 960, 640).substr(0, 2000);
  Begin([&](int number) -> std::vector<PtpipFile> { return {{FileName(number), cut}}; });
  auto device = Open();
  device->Start();
  device->RequestStill();
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->status, FrameStatus::kIncomplete);
  EXPECT_EQ(*still->encoded->bytes, cut);
}

TEST_F(GphotoTest, CameraWithoutLiveViewTakesStills) {
  PtpipCameraOptions options;
  options.live_view = false;
  Begin(NumberedPhotograph, options);
  auto device = Open();
  device->Start();
  EXPECT_TRUE(Until(*device, [&] { return Said(*device).find("no live view") != std::string::npos; }));
  EXPECT_FALSE(device->HasLiveFrames());
  device->RequestStill();
  EXPECT_TRUE(AwaitStill(*device));
}

TEST_F(GphotoTest, FlatFieldIsFoundFromPhotographs) {
  const BoardScene card({.board = {}, .camera = SimulatedLens("barrel", 480, 320), .vignetting = 0.4});
  Begin([&](int number) -> std::vector<PtpipFile> {
    std::vector<unsigned char> bytes;
    const Image picture{card.Render({}, static_cast<std::uint64_t>(number)), Transfer::kLinear};
    cv::imencode(".jpg", Srgb8(picture), bytes, {cv::IMWRITE_JPEG_QUALITY, 98});
    return {{FileName(number), std::string(bytes.begin(), bytes.end())}};
  });
  const fs::path file = home_ / "camera.json";
  WriteCalibration(file, card.options().camera, "3001234", "test", "still");
  const CommandResult result =
      RunUlf("calibrate --flat --mode still --frames 3 '" + camera_->Uri() + "' -o " + file.string());
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(camera_->Releases(), 3);
  const auto flat_field = ReadCalibrationFile(file).modes.at("still").flat_field;
  ASSERT_TRUE(flat_field);
  const cv::Mat light = flat_field->Light(480, 320), truth = card.Vignetting();
  EXPECT_NEAR(light.at<cv::Vec3f>(10, 10)[1] / light.at<cv::Vec3f>(160, 240)[1],
              truth.at<float>(10, 10) / truth.at<float>(160, 240), 0.02);
}

// Without live view: Enter takes each photograph, and each is answered.
TEST_F(GphotoTest, LensIsCalibratedFromPhotographs) {
  const BoardScene scene({.board = Board(), .camera = SimulatedLens("barrel", 600, 400)});
  PtpipCameraOptions options;
  options.live_view = false;
  Begin(
      [&](int number) -> std::vector<PtpipFile> {
        std::vector<unsigned char> bytes;
        const auto stop = static_cast<std::uint64_t>(number);
        const Image picture{scene.Render(scene.HeldAt(stop, 0), stop), Transfer::kLinear};
        cv::imencode(".jpg", Srgb8(picture), bytes, {cv::IMWRITE_JPEG_QUALITY, 98});
        return {{FileName(number), std::string(bytes.begin(), bytes.end())}};
      },
      options);
  const fs::path file = home_ / "camera.json", enters = home_ / "enters";
  std::ofstream(enters) << std::string(60, '\n');
  const CommandResult result =
      RunUlf("calibrate --mode still '" + camera_->Uri() + "' -o " + file.string() + " < " + enters.string());
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, AllOf(HasSubstr("photograph 1: hold the board"), HasSubstr("photograph 3: "),
                                   HasSubstr("these are enough")));
  EXPECT_LT(camera_->Releases(), 60);
  EXPECT_NEAR(ReadCalibration(file, "still").fx, scene.options().camera.fx, 5);
}

TEST_F(GphotoTest, ConfigurationIsReadByName) {
  Begin();
  const auto features = OpenGphotoFeatures(DeviceUri::Parse(camera_->Uri()));
  EXPECT_EQ(features->Info().serial, "3001234");
  const auto iso = features->Find("iso");
  ASSERT_TRUE(iso);
  EXPECT_EQ(iso->type, FeatureType::kEnumeration);
  EXPECT_EQ(iso->category, "imgsettings");
  EXPECT_EQ(iso->value, "200");
  EXPECT_THAT(iso->choices, ElementsAre("100", "200", "400", "800", "1600"));
  EXPECT_FALSE(features->Find("batterylevel")->writable);
  EXPECT_FALSE(features->Find("nothing of the kind"));
  features->Set("iso", "1600");
  EXPECT_EQ(camera_->Property(kPtpIso), 1600u);
  EXPECT_THAT([&] { features->Set("iso", "50"); }, ThrowsMessage<Refusal>(HasSubstr("1600")));
  EXPECT_THAT([&] { features->Set("batterylevel", "90"); },
              ThrowsMessage<Refusal>(HasSubstr("batterylevel")));
  EXPECT_GT(features->List().size(), 15u);
}

TEST(PhotographicNumbers, AreReadAsCamerasWriteThem) {
  EXPECT_DOUBLE_EQ(PhotographicNumber("1/125").value(), 0.008);
  EXPECT_DOUBLE_EQ(PhotographicNumber("0.0080s").value(), 0.008);
  EXPECT_DOUBLE_EQ(PhotographicNumber("f/5.6").value(), 5.6);
  EXPECT_DOUBLE_EQ(PhotographicNumber("ISO 200").value(), 200);
  EXPECT_DOUBLE_EQ(PhotographicNumber("2\"").value(), 2);
  for (const char* text : {"Auto", "bulb", "", "1/0", "0", "f/", "12 apples"})
    EXPECT_FALSE(PhotographicNumber(text)) << text;
  EXPECT_TRUE(IsSameSetting("1/60", "0.0166s"));
  EXPECT_FALSE(IsSameSetting("1/60", "1/80")) << "a third of a stop is another setting";
  EXPECT_FALSE(IsSameSetting("5.6", "6.3"));
  EXPECT_TRUE(IsSameSetting("Manual", "manual"));
  EXPECT_EQ(ChoiceFor({"1/50", "1/60", "1/80"}, "0.0167"), "1/60");
  EXPECT_EQ(ChoiceFor({"JPEG Basic", "JPEG Fine", "NEF (Raw)"}, "fine"), "JPEG Fine");
  EXPECT_FALSE(ChoiceFor({"JPEG Basic", "JPEG Fine"}, "jpeg")) << "names two";
  EXPECT_FALSE(ChoiceFor({"100", "200"}, "300"));
}

TEST(UsbHolders, AreFoundByTheirOpenFiles) {
  const ScratchFolder scratch;
  const fs::path usb = scratch / "usb", process = scratch / "proc/4711";
  fs::create_directories(usb / "001");
  fs::create_directories(process / "fd");
  std::ofstream(usb / "001/005") << "";
  std::ofstream(process / "comm") << "gvfsd-gphoto2\n";
  fs::create_directories(scratch / "proc/self");
  const auto holders = [&] { return ProgramsHoldingUsb("usb:001,005", scratch / "proc", usb); };
  EXPECT_THAT(holders(), IsEmpty());
  fs::create_symlink(usb / "001/005", process / "fd/3");
  EXPECT_THAT(holders(), ElementsAre("gvfsd-gphoto2 (process 4711)"));
  EXPECT_THAT(ProgramsHoldingUsb("ptpip:127.0.0.1", scratch / "proc", usb), IsEmpty());
}

}  // namespace
}  // namespace ulf::test::gphoto_test

// Tests: acquisition/gphoto2/photograph_pairing.
//
// One photograph, two files: what waits for what, and which request it answers.
#include "acquisition/gphoto2/photograph_pairing.h"

#include "tests/acquisition/gphoto2/gphoto_fixture.h"
#include "tests/support/floors.h"

namespace ulf::test::photograph_pairing_test {
namespace {

using ::testing::IsEmpty;

TEST(Photographs, PairInEitherOrderOrComeAloneLater) {
  const auto file = [](const char* name) {
    return DownloadedFile{name, std::string("bytes of ") + name, 0, 0};
  };
  PhotographPairing both(3);
  both.ExpectFormat("NEF+Fine");
  both.Add(file("DSC_1.NEF"), 0);
  both.Add(file("DSC_2.JPG"), 0.1);
  EXPECT_THAT(both.Take(0.2), IsEmpty());
  both.Add(file("DSC_1.jpg"), 1);
  auto taken = both.Take(1);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].raw.bytes, "bytes of DSC_1.NEF");
  EXPECT_EQ(taken[0].jpeg.bytes, "bytes of DSC_1.jpg");
  taken = both.Take(3.2);
  ASSERT_EQ(taken.size(), 1u) << "without its raw file";
  EXPECT_EQ(taken[0].jpeg.name, "DSC_2.JPG");

  PhotographPairing jpeg(3);
  jpeg.ExpectFormat("JPEG Fine");
  jpeg.Add(file("DSC_1.JPG"), 0);
  EXPECT_EQ(jpeg.Take(0).size(), 1u) << "at once";
  jpeg.Add(file("DSC_2.NEF"), 0);
  EXPECT_THAT(jpeg.Take(1), IsEmpty());
  jpeg.Add(file("DSC_2.NEF"), 1);  // the camera counts anew
  EXPECT_EQ(jpeg.Take(1).size(), 1u);
  EXPECT_EQ(jpeg.TakeAll().size(), 1u) << "at the end everything";

  PhotographPairing raw(3);
  raw.ExpectFormat("NEF (Raw)");
  EXPECT_FALSE(FilesOf("NEF (Raw)").jpeg);
  raw.Add(file("DSC_1.NEF"), 0);
  EXPECT_EQ(raw.Take(0).size(), 1u);
}

// Retries of a download last longer than a half waits for one of which nothing is known.
TEST(Photographs, HalfWaitsAndALateOneAnswersNoRequest) {
  PhotographPairing pairing(3);
  pairing.ExpectFormat("NEF+Fine");
  pairing.Add({.name = "DSC_1.JPG", .bytes = "jpeg", .announced_s = 100, .released_s = 99}, 0);
  const auto raw_is_coming = [](const std::string& stem) { return stem == "dsc_1"; };
  EXPECT_THAT(pairing.Take(19, raw_is_coming), IsEmpty());
  EXPECT_TRUE(pairing.Holds("dsc_1"));
  EXPECT_FALSE(pairing.LateFile("DSC_1.NEF", 19));
  EXPECT_THAT(pairing.Take(21), IsEmpty()) << "given up: as long as for one that was never announced";
  ASSERT_EQ(pairing.Take(22).size(), 1u);

  EXPECT_FALSE(pairing.LateFile("DSC_1.JPG", 25)) << "the camera counts anew";
  EXPECT_FALSE(pairing.LateFile("DSC_2.NEF", 25));
  EXPECT_FALSE(pairing.LateFile("DSC_1.NEF", 83));
  auto late = pairing.LateFile("DSC_1.NEF", 25);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->announced_s, 100) << "the photograph's time";
  EXPECT_EQ(late->released_s, 99);
  late->bytes = "raw";
  pairing.Add(*late, 26);
  const auto rest = pairing.Take(26);
  ASSERT_EQ(rest.size(), 1u) << "waits for nothing";
  EXPECT_TRUE(rest[0].First().is_late);
  EXPECT_FALSE(pairing.LateFile("DSC_1.NEF", 27)) << "once";
}

std::vector<PtpipFile> RawAndJpeg(int number) {
  return {{FileName(number, "NEF"), "raw bytes"}, {FileName(number), NumberedJpeg(number, 960, 640)}};
}

TEST_F(GphotoTest, LateRawFileJoinsItsPhotograph) {
  Begin(RawAndJpeg);
  auto device = Open("?imageformat=NEF+Basic");
  device->Start();
  camera_->FailDownloadsOfRaw(true);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  ASSERT_TRUE(Until(*device, [&] { return Said(*device).find("tries again") != std::string::npos; }));
  // Attempts at 0, 0.2, 0.6, 1.4 and 3 s fail, that at 6.2 s does not.
  const auto failing_until = std::chrono::steady_clock::now() + std::chrono::milliseconds(4000);
  while (std::chrono::steady_clock::now() < failing_until) {
    const auto frame = device->Next(milliseconds(20));
    ASSERT_FALSE(frame && frame->kind == FrameKind::kStill) << "a half by itself";
  }
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy) << "not answered yet";
  camera_->FailDownloadsOfRaw(false);
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_TRUE(still->encoded && still->raw && still->requested_s);
  EXPECT_THAT(device->Statistics().transport,
              ::testing::Contains(::testing::Pair(TransportFigure::kPhotographs, 1)));
}

TEST_F(GphotoTest, LateFileAnswersNoNewerRequest) {
  PtpipCameraOptions options;
  options.between_files_s = 4;
  Begin(RawAndJpeg, options);
  auto device = Open("?imageformat=NEF+Basic");
  device->Start();
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  const auto raw = AwaitStill(*device);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(raw->requested_s);
  EXPECT_FALSE(raw->encoded);
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked);
  const auto jpeg = AwaitStill(*device);
  ASSERT_TRUE(jpeg);
  EXPECT_EQ(*jpeg->encoded->bytes, NumberedJpeg(1, 960, 640)) << "of the first photograph";
  EXPECT_FALSE(jpeg->requested_s);
  EXPECT_EQ(jpeg->device_time_s, raw->device_time_s);
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy) << "the second is still asked for";
  const auto second = AwaitStill(*device);
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->requested_s);
  EXPECT_EQ(*second->raw->bytes, "raw bytes");
  EXPECT_GT(*second->requested_s, *raw->requested_s);
}

}  // namespace
}  // namespace ulf::test::photograph_pairing_test

// Tests: acquisition/gphoto2/shutter_bracket, acquisition/gphoto2/camera_bracket,
// acquisition/gphoto2/photograph_requests.
//
// Exposure brackets of a tethered camera: by its shutter, and by its own bracketing.
#include <map>

#include "acquisition/gphoto2/camera_bracket.h"
#include "tests/acquisition/gphoto2/gphoto_fixture.h"

namespace ulf::test::gphoto_bracket_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// 8 ms, of 2, 4, 8, 16.6 and 33.3.
TEST_F(GphotoTest, BracketSetsEachShutterAndWaitsWhenBusy) {
  Begin();
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  EXPECT_EQ(device->TakesExposures(), ExposureRequests::kSetTime);
  camera_->AnswerBusy(3);
  ASSERT_EQ(device->RequestExposures({-1, 1, -2}), StillRequest::kAsked);
  EXPECT_EQ(device->RequestExposures({-1}), StillRequest::kBusy) << "one after the other";
  EXPECT_EQ(device->RequestStill(), StillRequest::kBusy);
  for (const auto& [stops, exposure_s] : {std::pair(-1.0, 0.004), {1.0, 0.0166}, {-2.0, 0.002}}) {
    const auto still = AwaitStill(*device);
    ASSERT_TRUE(still) << stops;
    EXPECT_EQ(still->asked_stops, stops);
    EXPECT_NEAR(still->exposure_s, exposure_s, 0.02 * exposure_s);
  }
  EXPECT_EQ(camera_->BusyAnswers(), 3);
  ASSERT_TRUE(Until(*device, [&] { return camera_->Property(kPtpExposure) == 80; }))
      << "the shutter is set back";
  ASSERT_TRUE(Until(*device, [&] { return device->RequestStill() == StillRequest::kAsked; }));
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_FALSE(still->asked_stops);
  EXPECT_NEAR(still->exposure_s, 0.008, 1e-4);
  EXPECT_THAT(Said(*device), Not(HasSubstr("changed from"))) << "what ulf sets itself is no news";
}

TEST_F(GphotoTest, BracketEndsAtTheShuttersRange) {
  Begin();
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestExposures({2, 6}), StillRequest::kAsked);
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_EQ(still->asked_stops, 2.0);
  ASSERT_TRUE(Until(*device, [&] { return camera_->Property(kPtpExposure) == 80; }));
  EXPECT_THAT(Said(*device), HasSubstr("no other shutter time near +6 stops"));
  EXPECT_EQ(camera_->Releases(), 1);
}

TEST_F(GphotoTest, StoppingABracketRestoresTheShutter) {
  PtpipCameraOptions options;
  options.shutter_lag_s = 0.3;
  Begin(NumberedPhotograph, options);
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestExposures({-2, 2, -1, 1}), StillRequest::kAsked);
  ASSERT_TRUE(Until(*device, [&] { return camera_->ReleasesAsked() == 1; }));
  device->Stop();
  EXPECT_EQ(camera_->Property(kPtpExposure), 80u);
}

TEST_F(GphotoTest, StoppedBracketIsForgottenAtTheNextStart) {
  PtpipCameraOptions options;
  options.shutter_lag_s = 0.3;
  Begin(NumberedPhotograph, options);
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestExposures({-2, 2, -1, 1}), StillRequest::kAsked);
  ASSERT_TRUE(Until(*device, [&] { return camera_->ReleasesAsked() == 1; }));
  device->Stop();
  device->Start();
  ASSERT_EQ(device->RequestStill(), StillRequest::kAsked) << "no bracket is being taken";
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_FALSE(still->asked_stops);
}

// As the exposures of 1/125 s, two stops apart, come in the camera's own order.
std::vector<PtpipFile> BracketedPhotograph(int number) {
  const std::uint32_t of_second[] = {125, 500, 30};
  return {{FileName(number), WithExif(NumberedJpeg(number, 960, 640), of_second[(number - 1) % 3])}};
}

PtpipCameraOptions Bracketing() {
  PtpipCameraOptions options;
  options.brackets = true;
  return options;
}

TEST_F(GphotoTest, CamerasOwnBracketIsReleasedOnce) {
  Begin(BracketedPhotograph, Bracketing());
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  camera_->AnswerBracketingBusy(2);
  camera_->AnswerBusy(2);
  camera_->AnswerDownloadsBusy(3);
  ASSERT_EQ(device->RequestExposures({-2, 2}), StillRequest::kAsked);
  std::map<double, double> exposures;
  for (int i = 0; i < 3; ++i) {
    const auto still = AwaitStill(*device);
    ASSERT_TRUE(still) << i << ": " << Said(*device);
    ASSERT_TRUE(still->asked_stops) << i;
    exposures[*still->asked_stops] = still->exposure_s;
  }
  EXPECT_EQ(exposures.size(), 3u);
  EXPECT_NEAR(exposures[0], 1.0 / 125, 1e-6);
  EXPECT_NEAR(exposures[-2], 1.0 / 500, 1e-6);
  EXPECT_NEAR(exposures[2], 1.0 / 30, 1e-6);
  EXPECT_EQ(camera_->ReleasesAsked(), 1);
  EXPECT_EQ(camera_->BusyAnswers(), 7);
  ASSERT_TRUE(Until(*device, [&] { return camera_->Property(kPtpBracketSet) == 0; })) << Said(*device);
  EXPECT_EQ(camera_->Property(kPtpBracketing), 0u);
  EXPECT_EQ(camera_->Property(kPtpBracketStep), 3u);
  EXPECT_EQ(camera_->Property(kPtpBurstNumber), 1u);
  EXPECT_EQ(camera_->Property(kPtpCaptureMode), 1u);
  ASSERT_TRUE(Until(*device, [&] { return device->RequestStill() == StillRequest::kAsked; }));
  const auto still = AwaitStill(*device);
  ASSERT_TRUE(still);
  EXPECT_FALSE(still->asked_stops) << "an ordinary photograph again";
}

TEST_F(GphotoTest, UnsupportedBracketsUseTheShutter) {
  Begin(NumberedPhotograph, Bracketing());
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestExposures({-1.5, 1.5}), StillRequest::kAsked) << "it has steps of 1 and 2 stops";
  for (const double stops : {-1.5, 1.5}) {
    const auto still = AwaitStill(*device);
    ASSERT_TRUE(still) << stops;
    EXPECT_EQ(still->asked_stops, stops);
  }
  EXPECT_EQ(camera_->ReleasesAsked(), 2);
  EXPECT_EQ(camera_->Property(kPtpBracketing), 0u);
}

TEST_F(GphotoTest, StoppingItsOwnBracketRestoresSettings) {
  PtpipCameraOptions options = Bracketing();
  options.shutter_lag_s = 0.3;
  Begin(BracketedPhotograph, options);
  auto device = Open("?shutter=1/125");
  device->Start();
  ASSERT_TRUE(AwaitLive(*device));
  ASSERT_EQ(device->RequestExposures({-2, 2}), StillRequest::kAsked);
  ASSERT_TRUE(Until(*device, [&] { return camera_->ReleasesAsked() == 1; }));
  EXPECT_EQ(camera_->Property(kPtpBracketing), 1u);
  device->Stop();
  EXPECT_EQ(camera_->Property(kPtpBracketing), 0u);
  EXPECT_EQ(camera_->Property(kPtpCaptureMode), 1u);
}

// As libgphoto2 shows them of cameras by both makers.
TEST(CameraBracket, SettingsOfEitherMakerAreFound) {
  std::map<std::string, CameraFeature> settings;
  const auto has = [&](const std::string& name, const std::string& value, std::vector<std::string> choices,
                       bool read_only = false) {
    CameraFeature& setting = settings[name];
    setting.name = name;
    setting.type = FeatureType::kEnumeration;
    setting.value = value;
    setting.choices = std::move(choices);
    setting.writable = !read_only;
  };
  const auto plan = [&](const std::vector<double>& stops) {
    return PlanCameraBracket(stops, [&](const std::string& name) {
      const auto found = settings.find(name);
      return found == settings.end() ? std::nullopt : std::optional(found->second);
    });
  };
  EXPECT_FALSE(plan({-2, 2})) << "no bracketing at all";

  has("aeb", "off", {"off", "+/- 1/3", "+/- 1", "+/- 1 1/3", "+/- 2"});
  has("drivemode", "Continuous", {"Single", "Continuous"});
  const auto canon = plan({-4.0 / 3, 4.0 / 3});
  ASSERT_TRUE(canon);
  EXPECT_THAT(canon->settings,
              ElementsAre(NamedValue("aeb", "+/- 1 1/3"), NamedValue("drivemode", "Single")));
  EXPECT_EQ(canon->exposures, 3);
  EXPECT_FALSE(canon->one_release);
  EXPECT_FALSE(plan({-3, 3})) << "a step that it does not have";
  EXPECT_FALSE(plan({-2, 2, -4, 4})) << "five exposures";
  EXPECT_FALSE(plan({-2})) << "none above";

  settings.clear();
  has("bracketing", "Off", {"On", "Off"});
  has("bracketset", "AE only", {"AE & Flash", "AE only"});
  has("aebracketingstep", "1 EV", {"1/3 EV", "1/2 EV", "2/3 EV", "1 EV", "2 EV", "Unknown value 0002"});
  has("aebracketingpattern", "3 images (normal and 2 unders)",
      {"3 images (normal and 2 unders)", "3 images (normal, under and over)",
       "5 images (normal, 2 unders and 2 overs)"});
  const auto nikon = plan({-2, 2, -4, 4});
  ASSERT_TRUE(nikon);
  EXPECT_THAT(nikon->settings,
              ElementsAre(NamedValue("aebracketingstep", "2 EV"),
                          NamedValue("aebracketingpattern", "5 images (normal, 2 unders and 2 overs)"),
                          NamedValue("bracketing", "On")));
  EXPECT_FALSE(nikon->one_release) << "no burst";
  has("aebracketingpattern", "3 images (normal and 2 unders)", {"3 images (normal and 2 unders)"}, true);
  EXPECT_FALSE(plan({-2, 2})) << "to one side only, and not to be changed";
}

}  // namespace
}  // namespace ulf::test::gphoto_bracket_test

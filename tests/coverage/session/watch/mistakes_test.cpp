// Tests: coverage/session/watch/mistake_watch, coverage/session/watch/light_watch,
// coverage/session/watch/focus_watch, coverage/session/watch/dust_watch,
// coverage/session/watch/picture_tracks, acquisition/simulator/imperfections.
//
// Mistakes that the pictures alone show, one capture each, and none where nothing is wrong. Those that the
// tracker finds, all scenes and recordings by others: mistakes_long_test.
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "acquisition/opening/open_device.h"
#include "coverage/session/light_and_focus.h"
#include "coverage/session/preflight.h"
#include "coverage/session/watch/mistake_watch.h"
#include "tests/support/floors.h"

namespace ulf::test::mistakes_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// What is noticed within `seconds` of a scene, at 15 frames a second. Most mistakes show in small pictures.
std::vector<NoticedMistake> NoticedIn(const std::string& scene_and_faults, double seconds,
                                      const std::string& size = "&width=240&height=180") {
  const auto device = OpenDevice("sim:" + scene_and_faults + size);
  device->Start();
  MistakeWatch watch(FrameSource::kCamera);
  LightAndFocusCheck light_and_focus;
  const double frames = 15 * seconds;
  for (int i = 0; i < frames; ++i) {
    const auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) throw std::runtime_error("no frame");
    const PictureFinding& picture = light_and_focus.Update(frame->device_time_s, frame->image,
                                                           *device->Camera(), std::nullopt, std::nullopt);
    watch.Update(*frame, {.held = device->Held(),
                          .fine_detail = picture.fine_detail,
                          .badly_exposed = picture.light && IsBadlyExposed(*picture.light)});
  }
  return watch.noticed();
}

std::vector<Mistake> Kinds(const std::vector<NoticedMistake>& noticed) {
  std::vector<Mistake> kinds;
  for (const NoticedMistake& one : noticed) kinds.push_back(one.mistake);
  return kinds;
}

TEST(Mistakes, NoneIsNoticedWhereNothingIsWrong) {
  for (const auto& [scene, seconds] :
       {std::pair{"studio?seed=3", 15.0}, {"bust?seed=4", 8.0}, {"wall?seed=5", 8.0}})
    for (const NoticedMistake& wrong : NoticedIn(scene, seconds))
      ADD_FAILURE() << scene << ": " << wrong.InWords();
}

TEST(Mistakes, ALensOutOfFocusIsNoticed) {
  const auto noticed = NoticedIn("studio?seed=6&fault=defocus=8", 5, "&width=400&height=300");
  ASSERT_THAT(Kinds(noticed), ElementsAre(Mistake::kOutOfFocus));
  EXPECT_THAT(noticed[0].cure, HasSubstr("Focus on the subject"));
}

TEST(Mistakes, AnAutomaticFocusThatHuntsIsNoticed) {
  const auto noticed = NoticedIn("studio?seed=7&fault=hunting=3:1.6", 6);
  ASSERT_THAT(Kinds(noticed), ElementsAre(Mistake::kFocusHunts));
  EXPECT_THAT(noticed[0].cure, HasSubstr("auto focus off"));
}

// Where nearly all clips, what is left turns soft and sharp as its edges clip, whatever the lens does.
TEST(Mistakes, PicturesThatClipSayNothingOfTheFocus) {
  EXPECT_THAT(NoticedIn("studio?seed=7&exposure_us=60000&fault=hunting=3:1.6", 8), IsEmpty());
}

TEST(Mistakes, NoticesFlickerOverTimeAndInBands) {
  const auto at_once = NoticedIn("studio?seed=8&fault=flicker=100:0.4", 4);
  ASSERT_THAT(Kinds(at_once), ElementsAre(Mistake::kFlicker));
  EXPECT_THAT(at_once[0].finding, HasSubstr("from picture to picture"));
  EXPECT_THAT(at_once[0].cure, HasSubstr("1/50"));
  // Two whole periods during the readout: the picture as a whole is as bright as ever.
  const auto bands = NoticedIn("studio?seed=8&readout_ms=20&fault=flicker=100:0.4", 4);
  ASSERT_THAT(Kinds(bands), ElementsAre(Mistake::kFlicker));
  EXPECT_THAT(bands[0].finding, HasSubstr("2.0 bands"));
  // The cure: exposures of whole periods see no flicker.
  EXPECT_THAT(NoticedIn("studio?seed=8&exposure_us=20000&gain_db=0&speed_deg_s=3&fault=flicker=100:0.4", 4),
              IsEmpty());
}

TEST(Mistakes, DustOnTheLensIsNoticedWhereItIs) {
  const auto noticed = NoticedIn("studio?seed=12&fault=dust=6", 20);
  ASSERT_THAT(Kinds(noticed), ElementsAre(Mistake::kDust));
  EXPECT_THAT(noticed[0].cure, HasSubstr("Clean the lens"));
}

TEST(Mistakes, NoticesAutoExposureToldOrSeen) {
  const auto told = NoticedIn("studio?seed=9&fault=auto_exposure=told", 4);
  ASSERT_THAT(Kinds(told), ElementsAre(Mistake::kAutoExposure));
  const auto untold = NoticedIn("room?seed=31&dolly=2&fault=auto_exposure=untold", 12);
  ASSERT_THAT(Kinds(untold), ElementsAre(Mistake::kAutoExposure));
  EXPECT_THAT(untold[0].finding, HasSubstr("stops"));
}

TEST(Mistakes, LightChangeAtFixedExposureIsCalledLight) {
  EXPECT_THAT(Kinds(NoticedIn("studio?seed=10&fault=drift=12", 5)), ElementsAre(Mistake::kUnsteadyLight));
}

// What the tracker finds.
TEST(Mistakes, NamesLensAndShutterOnceUnlessGiven) {
  const tracking::CalibrationCheck wrong{
      .given_focal_px = 525, .fitted_focal_px = 500, .sigma_px = 1, .determined = true, .focal_wrong = true};
  const tracking::Readout measured{.readout_s = 0.025, .sigma_s = 0.001}, given{.readout_s = 0.025};
  MistakeWatch watch(FrameSource::kCamera);
  Frame frame;
  EXPECT_THAT(watch.Update(frame, {.rolling_shutter = given}), IsEmpty());
  EXPECT_THAT(Kinds(watch.Update(frame, {.lens_contradicted = wrong, .rolling_shutter = measured})),
              ElementsAre(Mistake::kRollingShutter, Mistake::kWrongLens));
  EXPECT_THAT(watch.Update(frame, {.lens_contradicted = wrong, .rolling_shutter = measured}), IsEmpty());
  watch.Finish(wrong, measured);
  ASSERT_THAT(watch.noticed(), SizeIs(2));
  EXPECT_THAT(watch.noticed()[0].cure, HasSubstr("compensated"));
  EXPECT_THAT(watch.noticed()[1].finding, HasSubstr("500.0 px"));
  const tracking::Readout contradicted{
      .readout_s = 0, .compensated = false, .contradicted = tracking::Readout::Contradiction{0.025, 0.001}};
  MistakeWatch other(FrameSource::kCamera);
  other.Finish(tracking::CalibrationCheck{}, contradicted);
  ASSERT_THAT(Kinds(other.noticed()), ElementsAre(Mistake::kRollingShutter));
  EXPECT_THAT(other.noticed()[0].cure, HasSubstr("readout_ms auto"));
}

TEST(Mistakes, ALensThatTheTrackerTakesBackIsNoMistake) {
  const tracking::CalibrationCheck wrong{
      .given_focal_px = 525, .fitted_focal_px = 500, .sigma_px = 1, .determined = true, .focal_wrong = true};
  MistakeWatch watch(FrameSource::kCamera);
  EXPECT_THAT(Kinds(watch.Update(Frame(), {.lens_contradicted = wrong})), ElementsAre(Mistake::kWrongLens));
  watch.Update(Frame(), {});
  EXPECT_THAT(watch.noticed(), IsEmpty());
  watch.Finish(wrong, {});
  EXPECT_THAT(Kinds(watch.noticed()), ElementsAre(Mistake::kWrongLens));
  watch.Finish(tracking::CalibrationCheck{}, {});
  EXPECT_THAT(watch.noticed(), IsEmpty());
}

// Soft pictures move corners: what the map says of rows and lens under them is not believed.
TEST(Mistakes, WhileAPictureIsOutOfFocusRowsAndLensWait) {
  const tracking::CalibrationCheck wrong{
      .given_focal_px = 525, .fitted_focal_px = 500, .sigma_px = 1, .determined = true, .focal_wrong = true};
  const tracking::Readout rows{.readout_s = 0.025, .sigma_s = 0.001};
  MistakeWatch watch(FrameSource::kCamera);
  const auto after = [&](double time_s, double fine_detail) {
    Frame frame;
    frame.device_time_s = time_s;
    watch.Update(frame, {.fine_detail = fine_detail, .lens_contradicted = wrong, .rolling_shutter = rows});
    return Kinds(watch.noticed());
  };
  EXPECT_THAT(after(0, 0.4), ElementsAre(Mistake::kRollingShutter, Mistake::kWrongLens));
  EXPECT_THAT(after(3, 0.4), ElementsAre(Mistake::kOutOfFocus));
  EXPECT_THAT(after(4, 0.9), ElementsAre(Mistake::kOutOfFocus));
  EXPECT_THAT(after(9, 0.9),
              ElementsAre(Mistake::kOutOfFocus, Mistake::kRollingShutter, Mistake::kWrongLens));
}

TEST(Mistakes, StandInThePreflightWithTheirCure) {
  PreflightInput input;
  input.mistakes = {{.mistake = Mistake::kFlicker, .finding = "it flickers", .cure = "Take others"},
                    {.mistake = Mistake::kDust, .finding = "a spot stays", .cure = "Clean it"},
                    {.mistake = Mistake::kAutoExposure, .finding = "it became darker", .cure = "Hold it"},
                    {.mistake = Mistake::kFocusHunts, .finding = "it hunts", .cure = "Fix it"}};
  std::vector<std::string> wrong;
  for (const PreflightItem& item : Preflight(input))
    if (item.in_order == false && item.name != "tracking") {
      EXPECT_FALSE(item.holds_start) << item.name;
      wrong.push_back(item.name + ": " + item.words);
    }
  EXPECT_THAT(wrong, ElementsAre("exposure: it became darker. Hold it", "focus: it hunts. Fix it",
                                 "lamps: it flickers. Take others", "lens: a spot stays. Clean it"));
}

// Nothing changes, so that every share of a change is 0 of 0.
TEST(PictureTracks, AStillPictureDoesNotFlicker) {
  cv::Mat texture(240, 320, CV_8U);
  cv::RNG(5).fill(texture, cv::RNG::UNIFORM, 40, 200);
  LightWatch light;
  PictureTracks tracks;
  for (int i = 0; i < 60; ++i) {
    const auto pair = tracks.Update(i / 15.0, {.pixels = texture, .transfer = Transfer::kSrgb});
    if (!pair) continue;
    ASSERT_FALSE(light.Update(*pair, 0).flickers) << i;
  }
}

// A hand before the lens, and the picture's jump to another scene, are no change of light and no
// swing of the focus.
TEST(PictureTracks, AnotherSceneIsAGapAndNoChange) {
  cv::Mat texture(240, 320, CV_8U), other(240, 320, CV_8U);
  cv::RNG random(5);
  random.fill(texture, cv::RNG::UNIFORM, 40, 200);
  random.fill(other, cv::RNG::UNIFORM, 20, 90);
  cv::GaussianBlur(texture, texture, {}, 2);
  cv::GaussianBlur(other, other, {}, 2);
  LightWatch light;
  FocusWatch focus;
  PictureTracks tracks;
  for (int i = 0; i < 120; ++i) {
    const cv::Mat& shown = i / 20 % 2 ? other : texture;
    const auto pair = tracks.Update(i / 30.0, {.pixels = shown, .transfer = Transfer::kSrgb});
    if (!pair) continue;
    ASSERT_FALSE(light.Update(*pair, 0).changed) << i;
    focus.Update(*pair);
  }
  EXPECT_FALSE(focus.HuntingAmplitude());
}

}  // namespace
}  // namespace ulf::test::mistakes_test

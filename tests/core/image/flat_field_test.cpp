// Tests: core/image/flat_field, core/geometry/sensor_window, core/light_field/folder/view_images.
#include "core/image/flat_field.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/simulated_board.h"
#include "core/geometry/sensor_window.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::flat_field_test {
namespace {

using ::testing::HasSubstr;

BoardSceneOptions Card(double vignetting) {
  return {.board = {}, .camera = SimulatedLens("barrel", 640, 480), .vignetting = vignetting};
}

std::vector<Image> Cards(const BoardScene& scene, int count = 6) {
  std::vector<Image> cards;
  for (int i = 0; i < count; ++i)
    cards.push_back({scene.Render({}, static_cast<std::uint64_t>(i)), Transfer::kLinear});
  return cards;
}

// The largest difference of estimated and true light over the image, both 1 in the middle.
double WorstError(const FlatField& flat_field, const BoardScene& scene) {
  cv::Mat green;
  cv::extractChannel(flat_field.Light(640, 480), green, 1);
  cv::Mat truth = scene.Vignetting() / scene.Vignetting().at<float>(240, 320);
  green = green / green.at<float>(240, 320);
  return cv::norm(green / truth - 1, cv::NORM_INF);
}

TEST(FlatField, RemovesVignettingToLessThanOnePercent) {
  for (const double vignetting : {0.0, 0.15, 0.4, 0.7})
    for (const std::uint64_t seed : {1u, 2u}) {
      BoardSceneOptions options = Card(vignetting);
      options.seed = seed;
      options.gradient = 0.1;
      options.dust = 3;
      const BoardScene scene(options);
      const FlatFieldResult result = EstimateFlatField(Cards(scene));
      ASSERT_TRUE(result.ok()) << result.refusal;
      EXPECT_LT(WorstError(result.flat_field, scene), 0.01)
          << vignetting << ", seed " << seed << ", " << result.model;
    }
}

TEST(FlatField, IsAsRichAsItMustBe) {
  const FlatFieldResult none = EstimateFlatField(Cards(BoardScene(Card(0))));
  EXPECT_EQ(none.model, "even light");
  const FlatFieldResult strong = EstimateFlatField(Cards(BoardScene(Card(0.6))));
  EXPECT_THAT(strong.model, HasSubstr("r^2"));
  // Shading that no circle explains.
  std::vector<Image> cards;
  for (const Image& card : Cards(BoardScene(Card(0.1)))) {
    cv::Mat pixels = card.pixels.clone();
    for (int y = 0; y < pixels.rows; ++y)
      for (int x = 0; x < pixels.cols; ++x) {
        const double s = (x - 320) / 320.0, t = (y - 240) / 240.0;
        pixels.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(pixels.at<std::uint8_t>(y, x) *
                                                                        (1 + 0.1 * s * s * s - 0.08 * s * t));
      }
    cards.push_back({pixels, Transfer::kLinear});
  }
  const FlatFieldResult odd = EstimateFlatField(cards);
  ASSERT_TRUE(odd.ok()) << odd.refusal;
  EXPECT_THAT(odd.model, HasSubstr("all powers"));
}

TEST(FlatField, CountsDustAndIsNotMovedByIt) {
  BoardSceneOptions options = Card(0.3);
  options.dust = 4;
  options.seed = 11;
  const BoardScene dusty(options);
  const FlatFieldResult result = EstimateFlatField(Cards(dusty));
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_GE(result.dust, 2);
  EXPECT_LE(result.dust, 6);
  EXPECT_LT(WorstError(result.flat_field, dusty), 0.01);
}

TEST(FlatField, RefusesBadCards) {
  BoardSceneOptions bright = Card(0.3), dark = Card(0.3), slanted = Card(0.3);
  bright.card_level = 1.2;
  dark.card_level = 0.03;
  slanted.gradient = 0.7;
  slanted.card_level = 0.5;
  EXPECT_THAT(EstimateFlatField(Cards(BoardScene(bright))).refusal, HasSubstr("clipped"));
  EXPECT_THAT(EstimateFlatField(Cards(BoardScene(dark))).refusal, HasSubstr("too dark"));
  EXPECT_THAT(EstimateFlatField(Cards(BoardScene(slanted), 1)).refusal, HasSubstr("falls off"));
  EXPECT_FALSE(EstimateFlatField({}).ok());
  // A board is no card.
  BoardSceneOptions board = Card(0);
  board.board = Board();
  const BoardScene scene(board);
  EXPECT_FALSE(EstimateFlatField({{scene.Render(scene.HeldAt(1, 0), 0), Transfer::kLinear}}).ok());
}

TEST(FlatField, FollowsTheSensorsWindow) {
  const FlatFieldResult result = EstimateFlatField(Cards(BoardScene(Card(0.5))));
  ASSERT_TRUE(result.ok()) << result.refusal;
  const cv::Mat whole = result.flat_field.Light(640, 480);
  const SensorWindow all{640, 480, 0, 0, 640, 480}, part{640, 480, 100, 60, 320, 240, 2, 2};
  const cv::Mat binned = result.flat_field.ForWindow(all, part).Light(160, 120);
  for (const cv::Point at : {cv::Point(0, 0), cv::Point(159, 119), cv::Point(80, 10)}) {
    const cv::Vec3f expected = 0.25f * (whole.at<cv::Vec3f>(60 + 2 * at.y, 100 + 2 * at.x) +
                                        whole.at<cv::Vec3f>(61 + 2 * at.y, 100 + 2 * at.x) +
                                        whole.at<cv::Vec3f>(60 + 2 * at.y, 101 + 2 * at.x) +
                                        whole.at<cv::Vec3f>(61 + 2 * at.y, 101 + 2 * at.x));
    EXPECT_LT(cv::norm(binned.at<cv::Vec3f>(at) - expected), 1e-4) << at;
  }
  EXPECT_EQ(FlatFieldFromJson(FlatFieldToJson(result.flat_field), "f"), result.flat_field);
}

TEST(FlatField, ALightFieldKeepsItAndIsReadCorrected) {
  const test::ScratchFolder scratch;
  const BoardScene scene(Card(0.4));
  const FlatFieldResult result = EstimateFlatField(Cards(scene));
  ASSERT_TRUE(result.ok()) << result.refusal;
  Frame frame;
  frame.image = {scene.Render({}, 99), Transfer::kLinear};
  {
    CaptureHeader header;
    header.camera = scene.options().camera;
    header.flat_field = result.flat_field;
    LightFieldWriter writer = LightFieldWriter::Create(scratch / "field", header);
    writer.AddView(frame, {});
    writer.Close(1);
  }
  const LightField read = ReadLightField(scratch / "field");
  ASSERT_EQ(read.flat_fields.size(), 1u);
  EXPECT_EQ(read.flat_fields.at(0), result.flat_field);
  // What was recorded is as the camera made it.
  EXPECT_EQ(cv::norm(ReadRecordedImage(read, read.views[0]).pixels, Srgb8(frame.image), cv::NORM_INF), 0);
  const Image corrected = ReadViewImage(read, read.views[0]);
  EXPECT_EQ(corrected.transfer, Transfer::kLinear);
  ASSERT_EQ(corrected.pixels.type(), CV_32FC3);
  // Corners against the middle: 40 % darker before, the same after.
  const auto mean = [](const cv::Mat& pixels, cv::Rect box) { return cv::mean(pixels(box))[1]; };
  const cv::Rect corner(2, 2, 30, 30), middle(305, 225, 30, 30);
  const cv::Mat before = LinearFloat(ReadRecordedImage(read, read.views[0]));
  EXPECT_LT(mean(before, corner), 0.68 * mean(before, middle));
  EXPECT_NEAR(mean(corrected.pixels, corner) / mean(corrected.pixels, middle), 1, 0.01);
}

}  // namespace
}  // namespace ulf::flat_field_test

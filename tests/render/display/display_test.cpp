// Tests: render/display/surface, render/display/painter, render/display/shapes,
// render/display/live_texture, render/display/plain_panels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/base/error.h"
#include "render/display/live_texture.h"
#include "render/display/plain_panels.h"
#include "render/display/surface.h"
#include "tests/support/floors.h"

namespace ulf::display_test {
namespace {

using Eigen::Vector2d;

const cv::Vec3b kRed{0, 0, 255}, kGreen{0, 255, 0}, kBlue{255, 0, 0}, kWhite{255, 255, 255};

// A surface whose pixels are all white.
class Display : public testing::Test {
 protected:
  void Fill() {
    surface_.Bind();
    LiveTexture().FillScreen({}, surface_.Size(), {1, 1, 1});
  }
  cv::Vec3b At(int x, int y) { return surface_.Read().at<cv::Vec3b>(y, x); }
  OffscreenSurface surface_{{320, 240}};
};

TEST_F(Display, EventsComeOnceAndInOrder) {
  surface_.Push(Typed{U'a'});
  surface_.Push(KeyPressed{Key::kLeft, true});
  const auto events = surface_.TakeEvents(0);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<Typed>(events[0]).character, U'a');
  EXPECT_TRUE(std::get<KeyPressed>(events[1]).shift);
  EXPECT_TRUE(surface_.TakeEvents(0).empty());
}

TEST_F(Display, ItsSizeIsThatOfThePictureThatIsRead) {
  Fill();
  EXPECT_EQ(surface_.Read().size(), cv::Size(320, 240));
  surface_.Resize({100, 50}, 2);
  Fill();
  EXPECT_EQ(surface_.Read().size(), cv::Size(100, 50));
  EXPECT_EQ(surface_.ContentScale(), 2);
  EXPECT_EQ(At(99, 49), kWhite);
}

TEST_F(Display, APictureFillsItsAreaAndTheColourTheRest) {
  cv::Mat picture(2, 2, CV_8UC3, cv::Scalar(0, 0, 255));
  picture.at<cv::Vec3b>(1, 0) = kGreen;
  LiveTexture texture;
  texture.Upload(picture);
  surface_.Bind();
  const Placement placement = Placement::Letterboxed(picture.size(), surface_.Size());
  texture.FillScreen(placement.Area(), surface_.Size(), {0, 0, 1});
  EXPECT_EQ(At(10, 120), kBlue) << "beside the picture";
  EXPECT_EQ(At(50, 10), kRed) << "its upper left";
  EXPECT_EQ(At(50, 230), kGreen) << "its lower left";
}

TEST(Placement, KeepsTheAspectAndTheMiddle) {
  const Placement wide = Placement::Letterboxed({200, 100}, {400, 400});
  EXPECT_EQ(wide.scale, 2);
  EXPECT_EQ(wide.ScreenFromImg({100, 50}), Vector2d(200, 200));
  EXPECT_EQ(wide.Area(), cv::Rect2d(0, 100, 400, 200));
}

TEST_F(Display, ThePainterDrawsWhereItIsTold) {
  Painter painter;
  Fill();
  painter.Begin(surface_.Size(), 1);
  painter.Box({10, 20, 30, 40}, {255, 0, 0}, 0);
  painter.Disc({200, 100}, 20, {0, 255, 0});
  painter.Draw({Polygon{{{5, 5}, {5, 15}, {15, 15}, {15, 5}}, {0, 0, 255}}},
               {.origin = {100, 200}, .scale = 2, .picture = {20, 20}});
  painter.End();
  EXPECT_EQ(At(25, 40), kRed);
  EXPECT_EQ(At(200, 100), kGreen);
  EXPECT_EQ(At(120, 220), kBlue) << "a shape in pixels of its picture";
  EXPECT_EQ(At(60, 40), kWhite);
  EXPECT_EQ(At(105, 205), kWhite) << "beside the shape";
}

TEST_F(Display, TextIsAsLargeAsItSays) {
  Painter painter;
  painter.Begin(surface_.Size(), 1);
  const Vector2d small = painter.Extent("words", TextSize::kSmall),
                 large = painter.Extent("words", TextSize::kLarge);
  EXPECT_GT(large.x(), 1.5 * small.x());
  EXPECT_GT(painter.Extent("some more words", TextSize::kSmall, 60).y(), 1.5 * small.y()) << "wrapped";
  painter.End();
}

TEST_F(Display, PanelsAreDarkWhereTheyAreAndNowhereElse) {
  Painter painter;
  Fill();
  painter.Begin(surface_.Size(), 1);
  const PlainPanels panels(painter, surface_.Size(), 1);
  panels.Status({{"a status"}});
  panels.Hint("a hint");
  panels.Flash({255, 0, 0});
  painter.End();
  EXPECT_LT(At(160, 20)[0], 128) << "the status line along the top";
  EXPECT_EQ(At(160, 120), kWhite) << "the middle";
  EXPECT_EQ(At(1, 120), kRed) << "the flash along the edges";
}

TEST_F(Display, SmallWindowsGetSmallText) {
  EXPECT_EQ(ScaleOf(OffscreenSurface({320, 240})), 0.6);
  EXPECT_EQ(ScaleOf(OffscreenSurface({1280, 720})), 1);
  EXPECT_EQ(ScaleOf(OffscreenSurface({2560, 1440}, 2)), 2);
}

TEST(Shapes, ColoursMixAndFade) {
  EXPECT_EQ(Mix({0, 0, 0}, {200, 100, 50, 55}, 0.5), (Rgba{100, 50, 25, 155}));
  EXPECT_EQ(Mix({1, 2, 3}, {4, 5, 6}, 7), (Rgba{4, 5, 6})) << "no farther than the second";
  EXPECT_EQ((Rgba{1, 2, 3, 200}.WithOpacity(0.5)), (Rgba{1, 2, 3, 100}));
}

TEST(KeyNames, AreCharactersOrKeys) {
  const auto keys = KeysFromNames("b,comma,Shift+Up");
  ASSERT_EQ(keys.size(), 3u);
  EXPECT_EQ(std::get<Typed>(keys[0]).character, U'b');
  EXPECT_EQ(std::get<Typed>(keys[1]).character, U',');
  EXPECT_EQ(std::get<KeyPressed>(keys[2]).key, Key::kUp);
  EXPECT_TRUE(std::get<KeyPressed>(keys[2]).shift);
  // As the screens write them.
  EXPECT_EQ(std::get<KeyPressed>(KeysFromNames("Esc")[0]).key, Key::kEscape);
  EXPECT_EQ(std::get<KeyPressed>(KeysFromNames("PgUp")[0]).key, Key::kPageUp);
  EXPECT_THROW(KeysFromNames("Nowhere"), Refusal);
}

TEST(PictureWindow, WithoutADisplayIsAnError) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  EXPECT_THROW(PictureWindow("a picture"), Error);
}

}  // namespace
}  // namespace ulf::display_test

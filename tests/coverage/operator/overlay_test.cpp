// Tests: coverage/operator/overlay, coverage/operator/instruction, coverage/operator/palette.
//
// What is drawn over the live picture, as shapes, from staged states.
#include "coverage/operator/overlay.h"
#include "coverage/operator/instruction.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "coverage/bound/sphere_outline.h"
#include "coverage/measured/error_map.h"
#include "coverage/operator/palette.h"
#include "coverage/operator/panels.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test::overlay_test {
namespace {

using ::testing::IsEmpty;
using ::testing::Not;

template <typename Kind>
std::vector<Kind> All(const Overlay& overlay) {
  std::vector<Kind> found;
  for (const OverlayShape& shape : overlay)
    if (const auto* kind = std::get_if<Kind>(&shape)) found.push_back(*kind);
  return found;
}

std::vector<Spot> CameraDots(const Overlay& overlay, const Palette& palette = Palette::Standard()) {
  std::vector<Spot> dots = All<Spot>(overlay);
  std::erase_if(dots, [&](const Spot& dot) { return dot.color != palette.camera; });
  return dots;
}

const Polyline& Rectangle(const std::vector<Polyline>& lines, const CameraModel& camera) {
  const SafetyRectangle rectangle = SafetyRectangle::Of(camera);
  const Polyline* found = nullptr;
  for (const Polyline& line : lines)
    if (line.closed && line.img.size() == 4 && (line.img[0] - rectangle.low).norm() < 1e-9) found = &line;
  if (!found) throw std::runtime_error("no rectangle is drawn");
  return *found;  // the last: the shade lies below it
}

TEST(Overlay, RedDotIsTheCamerasDirectionOnTheSphere) {
  const StagedCapture stage;
  for (const double distance : {0.7, 1.0, 1.6})
    for (const Eigen::Vector2d& aside :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.2, 0.1), Eigen::Vector2d(-0.25, 0)}) {
      const Rigid3 pose = stage.CameraAt(20, -10, distance, aside);
      const auto dots = CameraDots(MakeOverlay(*stage.At(pose)));
      ASSERT_EQ(dots.size(), 1u);
      // Walked along the way from the camera to the centre, without the overlay's own geometry.
      const Eigen::Vector3d from = pose.OriginInSource(), to = stage.subject().center_in_world;
      double low = 0, high = 1;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        const Eigen::Vector3d at = from + middle * (to - from);
        ((at - to).norm() > stage.subject().radius ? low : high) = middle;
      }
      const auto img = stage.camera().ImgFromCam(pose * Eigen::Vector3d(from + low * (to - from)));
      ASSERT_TRUE(img);
      EXPECT_LT((dots[0].img - *img).norm(), 1e-3) << "at " << distance << ", aside " << aside.transpose();
    }
}

// From a place in the picture to the nearest line of a width.
double DistanceToLines(const Overlay& overlay, double width, const Eigen::Vector2d& img) {
  double least = 1e9;
  for (const Polyline& line : All<Polyline>(overlay)) {
    if (std::abs(line.width - width) > 1e-9) continue;
    for (std::size_t i = 0; i + 1 < line.img.size(); ++i) {
      const Eigen::Vector2d along = line.img[i + 1] - line.img[i];
      const double t =
          std::clamp((img - line.img[i]).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
      least = std::min(least, (img - line.img[i] - t * along).norm());
    }
  }
  return least;
}

// What is on the sphere in a direction of the cap's, through the lens with its distortion.
struct SeenSphere {
  StagedCapture stage;
  Rigid3 pose;
  Overlay overlay;
  explicit SeenSphere(double azimuth_deg = 20, double elevation_deg = -10) {
    stage.Record(stage.CameraAt(0, 0));
    pose = stage.CameraAt(azimuth_deg, elevation_deg, 1, {0.15, 0.05});
    overlay = MakeOverlay(*stage.At(pose));
  }
  Eigen::Vector2d At(double azimuth_deg, double elevation_deg) const {
    const double radius = stage.subject().radius;
    return *stage.camera().ImgFromCam(pose *
                                      stage.CameraAt(azimuth_deg, elevation_deg, radius).OriginInSource());
  }
};

TEST(Overlay, TheSphereIsAWireOfTenDegrees) {
  const SeenSphere seen;
  constexpr double kWire = 1;
  for (const double elevation : {-28.0, -13.0, 4.0, 16.0})
    for (const double azimuth : {-10.0, 0.0, 20.0, 50.0})
      EXPECT_LT(DistanceToLines(seen.overlay, kWire, seen.At(azimuth, elevation)), 0.5) << "meridian";
  for (const double azimuth : {-12.0, 3.0, 37.0})
    for (const double elevation : {-30.0, -10.0, 20.0})
      EXPECT_LT(DistanceToLines(seen.overlay, kWire, seen.At(azimuth, elevation)), 0.5) << "parallel";
  for (const double azimuth : {5.0, 15.0, 25.0})
    for (const double elevation : {-15.0, -5.0, 5.0})
      EXPECT_GT(DistanceToLines(seen.overlay, kWire, seen.At(azimuth, elevation)), 3) << "between them";
}

TEST(Overlay, TheCapIsOutlinedOnTheSphere) {
  const SeenSphere seen;
  constexpr double kOutline = 2.5;
  for (const double elevation : {-20.0, -7.0, 0.0, 12.0, 20.0})
    EXPECT_LT(DistanceToLines(seen.overlay, kOutline, seen.At(30, elevation)), 0.5) << elevation;
  for (const double azimuth : {-12.0, 0.0, 11.0, 30.0})
    EXPECT_LT(DistanceToLines(seen.overlay, kOutline, seen.At(azimuth, -20)), 0.5) << azimuth;
  EXPECT_GT(DistanceToLines(seen.overlay, kOutline, seen.At(20, 0)), 10);
}

TEST(Overlay, NearRecordedViewHasARim) {
  const SeenSphere seen(3, 2);
  constexpr double kRim = 1.2;
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (const Polyline& line : All<Polyline>(seen.overlay))
    if (std::abs(line.width - kRim) < 1e-9)
      for (const Eigen::Vector2d& img : line.img) {
        sum += img;
        ++count;
      }
  ASSERT_GT(count, 10);
  EXPECT_LT((sum / count - seen.At(0, 0)).norm(), 2);
  EXPECT_GT(DistanceToLines(seen.overlay, kRim, seen.At(0, 0)), 3) << "around it, not on it";
}

TEST(Overlay, DistancesOfRecordedViewsAreColours) {
  const Palette& palette = Palette::Standard();
  StagedCapture stage;
  stage.Record(stage.CameraAt(0, 0, 1));
  const auto state = stage.At(stage.CameraAt(0, 0));
  const CoverageMap& map = *state->coverage;
  const DistanceColors limits(map, 1, palette);
  ASSERT_LT(limits.farthest_recorded(), 1);
  ASSERT_GT(limits.nearest_recorded(), 1);
  const auto color_at = [&](double present) {
    const auto patches = All<Patch>(MakeOverlay(*stage.At(stage.CameraAt(0, 0, present))));
    EXPECT_THAT(patches, Not(IsEmpty()));
    for (const Patch& patch : patches) EXPECT_EQ(patch.color, patches[0].color) << "one view, one colour";
    Rgba color = patches.empty() ? Rgba{} : patches[0].color;
    color.a = 255;
    return color;
  };
  EXPECT_EQ(color_at(1), palette.same);
  // Nearer than the recorded view: that one is farther, red.
  EXPECT_EQ(color_at(limits.farthest_recorded()), palette.farther);
  EXPECT_EQ(color_at(0.9 * limits.farthest_recorded()), palette.farther);
  EXPECT_EQ(color_at(limits.nearest_recorded()), palette.nearer);
  // Continuous, and half-way in the logarithm is half of each.
  EXPECT_EQ(color_at(std::sqrt(limits.farthest_recorded())), Mix(palette.same, palette.farther, 0.5));
  EXPECT_EQ(color_at(std::sqrt(limits.nearest_recorded())), Mix(palette.same, palette.nearer, 0.5));
}

TEST(Overlay, PaintLiesWhereTheMapSaysSo) {
  StagedCapture stage;
  stage.RecordRows(-20, 0, -10, 10, 5);
  const Rigid3 pose = stage.CameraAt(-5, 3);
  const auto state = stage.At(pose);
  const auto patches = All<Patch>(MakeOverlay(*state));
  ASSERT_THAT(patches, Not(IsEmpty()));
  for (const Patch& patch : patches) {
    const Eigen::Vector2d middle = 0.25 * (patch.img[0] + patch.img[1] + patch.img[2] + patch.img[3]);
    // Back onto the sphere's near side.
    const Eigen::Vector3d ray = pose.DirectionInSource(*stage.camera().RayFromImg(middle));
    const Eigen::Vector3d to_center = stage.subject().center_in_world - pose.OriginInSource();
    const double along = ray.dot(to_center);
    const double rest =
        stage.subject().radius * stage.subject().radius - to_center.squaredNorm() + along * along;
    ASSERT_GT(rest, 0);
    const Eigen::Vector3d on_sphere = pose.OriginInSource() + (along - std::sqrt(rest)) * ray;
    const auto cell = state->coverage->At((on_sphere - stage.subject().center_in_world).normalized());
    ASSERT_TRUE(cell);
    EXPECT_GE(cell->index, 0);
  }
}

TEST(Overlay, RectangleTurnsRedWhenTheSphereLeavesIt) {
  const StagedCapture stage;
  const Overlay inside = MakeOverlay(*stage.At(stage.CameraAt(0, 0)));
  const auto inside_lines = All<Polyline>(inside);
  const Polyline& white = Rectangle(inside_lines, stage.camera());
  EXPECT_EQ(white.color, (Rgba{255, 255, 255}));
  EXPECT_THAT(All<Label>(inside), IsEmpty());
  for (const Eigen::Vector2d& aside :
       {Eigen::Vector2d(0.45, 0), Eigen::Vector2d(0, -0.4), Eigen::Vector2d(3, 0)}) {
    const Overlay outside = MakeOverlay(*stage.At(stage.CameraAt(0, 0, 1, aside)));
    const auto lines = All<Polyline>(outside);
    const Polyline& red = Rectangle(lines, stage.camera());
    EXPECT_EQ(red.color, Palette::Standard().alarm) << aside.transpose();
    EXPECT_GE(red.width, 2 * white.width);
    const auto labels = All<Label>(outside);
    ASSERT_THAT(labels, Not(IsEmpty()));
    EXPECT_EQ(labels[0].text, "OUTSIDE");
  }
}

TEST(Overlay, AnArrowPointsToASubjectThatHasLeftTheView) {
  const StagedCapture stage;
  const Eigen::Vector2d middle(0.5 * stage.camera().width, 0.5 * stage.camera().height);
  struct Case {
    Eigen::Vector2d aside, toward;
  };
  // Aimed to the right of the subject: it is on the left.
  for (const Case& c : {Case{{1.2, 0}, {-1, 0}}, Case{{-1.2, 0}, {1, 0}}, Case{{0, 1.2}, {0, -1}}}) {
    const Overlay overlay = MakeOverlay(*stage.At(stage.CameraAt(0, 0, 1, c.aside)));
    const auto heads = All<Polygon>(overlay);
    ASSERT_THAT(heads, Not(IsEmpty()));
    const Polygon& head = heads.back();
    EXPECT_EQ(head.color, Palette::Standard().alarm);
    const Eigen::Vector2d tip = head.img[0] - middle;
    EXPECT_GT(tip.normalized().dot(c.toward), 0.99) << c.aside.transpose();
    EXPECT_TRUE(stage.camera().Contains(head.img[0]));
  }
  // Turned round: behind, a little to the camera's left.
  auto behind = stage.At(stage.CameraAt(0, 0));
  const Eigen::Vector3d at = behind->cam_from_world->OriginInSource();
  const Eigen::Vector3d center = stage.subject().center_in_world;
  const Eigen::Vector3d right = behind->cam_from_world->DirectionInSource(Eigen::Vector3d::UnitX());
  const Eigen::Vector3d up = behind->cam_from_world->DirectionInSource(-Eigen::Vector3d::UnitY());
  behind->cam_from_world = LookAt(at, at + (at - center) + 0.2 * right, up);
  const auto heads = All<Polygon>(MakeOverlay(*behind));
  ASSERT_THAT(heads, Not(IsEmpty()));
  const double side = (*behind->cam_from_world * center).x();
  EXPECT_GT((heads.back().img[0] - middle).normalized().x() * (side > 0 ? 1 : -1), 0.9);
}

TEST(Overlay, NothingIsDrawnWhenLost) {
  StagedCapture stage;
  stage.RecordRows(-10, 10, -10, 10, 5);
  EXPECT_THAT(MakeOverlay(*stage.Lost()), IsEmpty());
  EXPECT_TRUE(InstructionFor(*stage.Lost()).urgent);
  EXPECT_EQ(InWords(InstructionFor(*stage.Lost()), *stage.Lost()), stage.Lost()->tracking_words);
}

TEST(Overlay, ArrowPointsToTheTargetAroundTheSphere) {
  StagedCapture stage;
  stage.Record(stage.CameraAt(0, 0));
  const Rigid3 pose = stage.CameraAt(0, 0);
  for (const double target_deg : {15.0, 60.0, 150.0}) {
    auto state = stage.At(pose);
    const Rigid3 there = stage.CameraAt(target_deg, 0);
    state->guidance.toward = (there.OriginInSource() - stage.subject().center_in_world).normalized();
    state->guidance.disc_radius = 0.08;
    const Overlay overlay = MakeOverlay(*state);
    const auto heads = All<Polygon>(overlay);
    ASSERT_THAT(heads, Not(IsEmpty()));
    const Polygon& head = heads.back();
    EXPECT_EQ(head.color, Palette::Standard().guide);
    const Eigen::Vector2d dot = CameraDots(overlay).at(0).img;
    // Azimuth grows to the right of who looks at the subject: the dot has to go there.
    EXPECT_GT((head.img[0] - dot).normalized().x(), 0.95) << target_deg;
    if (target_deg < 40) {
      const auto on_sphere = [&](double azimuth_deg) {
        const Eigen::Vector3d toward =
            (stage.CameraAt(azimuth_deg, 0).OriginInSource() - stage.subject().center_in_world).normalized();
        return *stage.camera().ImgFromCam(
            pose * Eigen::Vector3d(stage.subject().center_in_world + stage.subject().radius * toward));
      };
      // At the ring around the target, on the near side.
      const double ring_deg = state->guidance.disc_radius * 180 / M_PI;
      EXPECT_GE(head.img[0].x(), on_sphere(target_deg - 1.1 * ring_deg).x());
      EXPECT_LT(head.img[0].x(), on_sphere(target_deg - 0.5 * ring_deg).x());
      EXPECT_NEAR(head.img[0].y(), on_sphere(target_deg).y(), 3);
    }
  }
}

TEST(Overlay, ReopenedDirectionsAreMarked) {
  StagedCapture stage;
  stage.RecordRows(-10, 10, 0, 0, 5);
  const Rigid3 pose = stage.CameraAt(0, 0);
  auto state = stage.At(pose);
  const auto marks = [&] {
    std::vector<Spot> dots = All<Spot>(MakeOverlay(*state));
    std::erase_if(dots, [](const Spot& dot) { return dot.color != Palette::Standard().reopened; });
    return dots;
  };
  EXPECT_THAT(marks(), IsEmpty());
  const Eigen::Vector3d front = (pose.OriginInSource() - stage.subject().center_in_world).normalized();
  state->reopened = {front, -front};  // the far side is not seen
  EXPECT_EQ(marks().size(), 1u);
}

// Not only where it lies on the map: on the near side, in the guide's colour, and nothing when it is done.
TEST(Overlay, GapsLeftByTheMovementAreMarked) {
  StagedCapture stage;
  stage.RecordRows(-10, 10, 0, 0, 5);
  const Rigid3 pose = stage.CameraAt(0, 0);
  auto state = stage.At(pose);
  const auto marks = [&] {
    std::vector<Spot> dots = All<Spot>(MakeOverlay(*state));
    std::erase_if(dots, [](const Spot& dot) { return dot.color != Palette::Standard().guide; });
    return dots;
  };
  EXPECT_THAT(marks(), IsEmpty());
  const Eigen::Vector3d center = stage.subject().center_in_world;
  const auto toward = [&](double azimuth_deg) -> Eigen::Vector3d {
    return (stage.CameraAt(azimuth_deg, 3).OriginInSource() - center).normalized();
  };
  state->guidance.left_open = {toward(-6), toward(2), toward(180)};
  const auto found = marks();
  ASSERT_EQ(found.size(), 2u) << "the far side is not seen";
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector3d on_sphere = center + stage.subject().radius * state->guidance.left_open[i];
    EXPECT_LT((found[i].img - *stage.camera().ImgFromCam(pose * on_sphere)).norm(), 1e-6) << i;
  }
}

TEST(Overlay, NoSphereIsDrawnFromInsideIt) {
  const StagedCapture stage;
  const auto state = stage.At(stage.CameraAt(0, 0, 0.5 * stage.subject().radius));
  const Overlay overlay = MakeOverlay(*state);
  EXPECT_THAT(All<Patch>(overlay), IsEmpty());
  EXPECT_THAT(CameraDots(overlay), IsEmpty());
  const auto lines = All<Polyline>(overlay);
  EXPECT_EQ(Rectangle(lines, stage.camera()).color, Palette::Standard().alarm);
}

TEST(CloseLook, HasTheDotInTheMiddleAndLargeDiscs) {
  StagedCapture stage;
  stage.RecordRows(-6, 6, -6, 6, 3);
  for (const Eigen::Vector2d& aside : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.2, 0.1)}) {
    const auto state = stage.At(stage.CameraAt(1, 1, 1, aside));
    const auto look = MakeCloseLook(*state, 280, 210);
    ASSERT_TRUE(look);
    const auto dots = CameraDots(look->shapes);
    ASSERT_EQ(dots.size(), 1u);
    EXPECT_LT((dots[0].img - Eigen::Vector2d(140, 105)).norm(), 1e-6);
    // A step of three degrees between recorded views, against the disc's radius on the map.
    std::vector<Eigen::Vector2d> views;
    for (const Spot& spot : All<Spot>(look->shapes))
      if (spot.radius < 2) views.push_back(spot.img);
    ASSERT_EQ(views.size(), 25u);
    double least = 1e9;
    for (std::size_t i = 1; i < views.size(); ++i) least = std::min(least, (views[i] - views[0]).norm());
    const CoverageMap& map = *state->coverage;
    const double disc_radius = map.spacing() * map.options().cells_per_disc_radius;
    EXPECT_NEAR(least / (3 * M_PI / 180) * disc_radius, 0.11 * 210, 0.15 * 0.11 * 210);
  }
  EXPECT_FALSE(MakeCloseLook(*stage.Lost(), 280, 210));
  EXPECT_FALSE(MakeCloseLook(*StagedCapture().At(stage.CameraAt(0, 0)), 280, 210)) << "nothing is recorded";
}

TEST(Overlay, InstructionsComeInOrderOfUrgency) {
  StagedCapture stage;
  stage.Record(stage.CameraAt(0, 0));
  auto state = stage.At(stage.CameraAt(0, 0));
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "");
  state->guidance.toward = Eigen::Vector3d::UnitX();
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "follow the arrow");
  state->guidance.row = Guidance::RowOffset{0.2, 0.1};
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::HasSubstr("last row"));
  state->guidance.distance = 0.8;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "come 20 % nearer");
  state->metric = true;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "come 20 cm nearer");
  EXPECT_EQ(InstructionFor(*state).kind, InstructionKind::kComeNearer);
  EXPECT_NEAR(InstructionFor(*state).length->ShareOf(1), 0.2, 1e-12) << "as the words say it";
  state->metric = false;
  state->guidance.distance = 1.3;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "go 30 % back");
  state->decision.reason = Reason::kSpeed;
  EXPECT_TRUE(InstructionFor(*state).urgent);
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "too fast: slower");
  state->decision.reason = Reason::kUnsettled;
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::HasSubstr("still changing"));
  state->mistakes = {
      {.mistake = Mistake::kFlicker, .finding = "it flickers", .cure = "Take others", .last_s = 60}};
  state->seconds = 62;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "flickering lamps. Take others")
      << "in place of what it causes";
  state->seconds = 90;
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::HasSubstr("still changing"))
      << "it is over";
  state->decision.reason = Reason::kOutsideRectangle;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "bring the sphere back into the rectangle");
  state->recording = false;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "bring the sphere back into the rectangle");
  state->decision.reason = Reason::kCovered;
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::StartsWith("paused"));
}

TEST(Overlay, InstructionSaysWhatDelaysTheStart) {
  StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  state->waits_to_begin = true;
  state->recording = false;
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::HasSubstr("Space begins"));
  EXPECT_FALSE(InstructionFor(*state).urgent);
  state->preflight.push_back({.name = "views", .in_order = false, .words = "", .holds_start = false});
  EXPECT_FALSE(InstructionFor(*state).urgent) << "a warning";
  state->preflight.push_back({.name = "light", .in_order = false, .words = "too dark"});
  EXPECT_TRUE(InstructionFor(*state).urgent);
  EXPECT_THAT(InWords(InstructionFor(*state), *state), ::testing::HasSubstr("red"));
}

// One covered direction whose pictures are wrong, one whose pictures are right, one that nothing covers.
TEST(Overlay, ErrorLayerMarksErrorsBeyondTheBound) {
  StagedCapture stage;
  stage.RecordRows(-6, 6, -2, 2, 2);
  const auto state = stage.At(stage.CameraAt(0, 0));
  auto errors = std::make_shared<ErrorMap>();
  const auto measure = [&](double azimuth, double above_goal_db, render::ErrorCause cause) {
    MeasuredFrame frame;
    frame.direction = state->coverage->frame()->Direction(Radians(azimuth), Radians(2));
    frame.nearest_view_angle = Radians(2);
    frame.measurable = true;
    frame.db = state->cover.db + above_goal_db;
    frame.cause = cause;
    errors->Add(frame);
  };
  measure(4, -20, render::ErrorCause::kSurface);
  measure(8, 20, render::ErrorCause::kNone);
  measure(25, -20, render::ErrorCause::kGeometry);
  ASSERT_LT(state->coverage->At(state->coverage->frame()->Direction(Radians(25), Radians(2)))->index, 0);
  state->errors = errors;
  const Palette& palette = Palette::Standard();
  const auto drawn = [&](SphereLayer layer) {
    std::pair<std::vector<std::string>, std::vector<Rgba>> letters_and_colors;
    for (const OverlayShape& shape : MakeOverlay(*state, palette, layer)) {
      if (const auto* label = std::get_if<Label>(&shape)) letters_and_colors.first.push_back(label->text);
      if (const auto* disc = std::get_if<Polygon>(&shape))
        letters_and_colors.second.push_back({disc->color.r, disc->color.g, disc->color.b, 255});
    }
    return letters_and_colors;
  };
  const auto [letters, colors] = drawn(SphereLayer::kErrors);
  EXPECT_THAT(letters, ::testing::Contains(LetterOf(render::ErrorCause::kSurface)));
  EXPECT_THAT(letters, ::testing::Not(::testing::Contains(LetterOf(render::ErrorCause::kGeometry))))
      << "where nothing is covered the paint says enough";
  EXPECT_THAT(colors, ::testing::Contains(palette.OfError(-20).WithOpacity(1)));
  EXPECT_THAT(colors, ::testing::Contains(palette.OfError(20).WithOpacity(1)));
  const auto [other_letters, other_colors] = drawn(SphereLayer::kCoverage);
  EXPECT_THAT(other_letters, ::testing::Not(::testing::Contains(LetterOf(render::ErrorCause::kSurface))));
  EXPECT_THAT(other_colors, ::testing::Not(::testing::Contains(palette.OfError(-20).WithOpacity(1))));
  EXPECT_THAT(CauseLines(*state),
              ::testing::ElementsAre(::testing::HasSubstr("(1)"), ::testing::HasSubstr("(1)")));
  // Of many beside each other the worst says what is wrong, and can be read.
  for (const double beside : {2.4, 5.6}) measure(beside, -10, render::ErrorCause::kPose);
  const auto crowded = drawn(SphereLayer::kErrors).first;
  EXPECT_THAT(crowded, ::testing::Contains(LetterOf(render::ErrorCause::kSurface)));
  EXPECT_THAT(crowded, ::testing::Not(::testing::Contains(LetterOf(render::ErrorCause::kPose))));
  for (const render::ErrorCause one : render::kErrorCauses)
    for (const render::ErrorCause other : render::kErrorCauses)
      if (one != other) {
        EXPECT_STRNE(LetterOf(one), LetterOf(other));
      }
}

TEST(Overlay, TheProposedSphereIsDrawnAndNamed) {
  StagedCapture stage;
  const auto without = stage.At(stage.CameraAt(0, 0));
  const auto with = stage.At(stage.CameraAt(0, 0));
  with->proposed_subject = Subject{stage.subject().center_in_world, 0.5 * stage.subject().radius};
  const auto labels = [](const Overlay& overlay) {
    std::vector<std::string> texts;
    for (const OverlayShape& shape : overlay)
      if (const auto* label = std::get_if<Label>(&shape)) texts.push_back(label->text);
    return texts;
  };
  EXPECT_THAT(labels(MakeOverlay(*with)), ::testing::Contains(::testing::HasSubstr("(G)")));
  EXPECT_GT(MakeOverlay(*with).size(), MakeOverlay(*without).size() + 20) << "dashes";
}

TEST(Overlay, ASubjectThatIsInTheMiddleIsNotToBeCentred) {
  StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  state->subject.reset();
  state->finding_subject = true;
  EXPECT_EQ(InWords(InstructionFor(*state), *state),
            "hold the subject in the middle: its distance is being found");
  state->finding_subject = false;
  EXPECT_THAT(InWords(InstructionFor(*state), *state),
              ::testing::HasSubstr("too few trackable points in the middle of the picture"));
  state->without_subject = true;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "walk on");
  state->decision.reason = Reason::kBlur;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "blurred: hold still");
}

TEST(Overlay, TheEndIsSaidBeforeAnythingElse) {
  StagedCapture stage;
  auto state = stage.Lost();
  state->recording = false;
  state->ended = StoppedBecause::kCovered;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "covered: all that was asked for is recorded");
  EXPECT_FALSE(InstructionFor(*state).urgent);
  state->ended = StoppedBecause::kDisk;
  EXPECT_TRUE(InstructionFor(*state).urgent);
  state->ended = StoppedBecause::kDeviceLost;
  EXPECT_TRUE(InstructionFor(*state).urgent);
  state->ended = StoppedBecause::kFrames;
  EXPECT_EQ(InWords(InstructionFor(*state), *state), "finished");
}

// ---- colours

// As an eye without one kind of cone has it (Machado, Oliveira and Fernandes 2009, full severity), on linear
// light.
cv::Vec3d Seen(const Rgba& color, const cv::Matx33d& eye) {
  const cv::Vec3d linear(LinearFromSrgb(color.r / 255.0f), LinearFromSrgb(color.g / 255.0f),
                         LinearFromSrgb(color.b / 255.0f));
  const cv::Vec3d seen = eye * linear;
  cv::Mat rgb(1, 1, CV_32FC3), lab;
  for (int i = 0; i < 3; ++i)
    rgb.at<cv::Vec3f>(0)[i] = SrgbFromLinear(static_cast<float>(std::clamp(seen[i], 0.0, 1.0)));
  cv::cvtColor(rgb, lab, cv::COLOR_RGB2Lab);
  return lab.at<cv::Vec3f>(0);
}

TEST(Palette, TheSecondIsToldApartByColourBlindEyes) {
  const struct {
    const char* name;
    cv::Matx33d eye;
  } eyes[] = {
      {"all cones", cv::Matx33d::eye()},
      {"protan",
       {0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998}},
      {"deutan",
       {0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881}},
      {"tritan",
       {1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900}}};
  const Palette& safe = Palette::ForColourBlind();
  constexpr double kFarApart = 40;  // of Lab's units; 2 can be told apart side by side
  double worst_of_standard = 1e9;
  for (const auto& [name, eye] : eyes) {
    for (const auto& [a, b] :
         {std::pair{safe.same, safe.farther}, {safe.same, safe.nearer}, {safe.nearer, safe.farther}})
      EXPECT_GT(cv::norm(Seen(a, eye) - Seen(b, eye)), kFarApart) << name;
    const Palette& standard = Palette::Standard();
    worst_of_standard =
        std::min(worst_of_standard, cv::norm(Seen(standard.same, eye) - Seen(standard.farther, eye)));
  }
  EXPECT_LT(worst_of_standard, kFarApart) << "the thesis's own colours would do: one palette is enough";
}

}  // namespace
}  // namespace ulf::test::overlay_test

// Tests: tracking/refine/pose_check, tracking/refine/pose_conventions, tracking/refine/repetitions,
// commands/light_field/info_command, commands/reports/light_field_report.
#include "tracking/refine/pose_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/refine_input.h"

namespace ulf::test::pose_check_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::string> WordsOf(const PoseCheck& check, const RefineInput& input) {
  std::vector<View> views(input.views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    views[v].id = static_cast<int>(v) + 1;
    views[v].image_path = input.views[v].name;
  }
  std::vector<std::string> words;
  for (const Finding& each : FindingsOf(check, views)) words.push_back(each.Words());
  return words;
}

TEST(PoseCheck, RightPosesAgreeEvenWhenALittleOff) {
  for (const double shift : {0.0, 0.005}) {
    const auto views = MakeViews(12, shift, 20 * shift, 3);
    const PoseCheck check = CheckPoses(views->input);
    EXPECT_THAT(check.contradicted, IsEmpty()) << shift;
    EXPECT_GE(check.agree, 11) << shift;
    EXPECT_THAT(WordsOf(check, views->input), IsEmpty());
    EXPECT_EQ(check.error_px < 0.5, shift == 0) << check.error_px;
  }
}

std::vector<int> Contradicted(const PoseCheck& check) {
  std::vector<int> views;
  for (const tracking::ContradictedView& view : check.contradicted) views.push_back(view.view);
  return views;
}

TEST(PoseCheck, FindsOneWrongPoseAndNotItsNeighbours) {
  const auto views = MakeViews(10, 0, 0, 6);
  Draw draw(2);
  const Rigid3 right = views->input.views[4].cam_from_world;
  struct {
    double shift, angle_deg;
  } const cases[] = {{0.09, 0}, {0, 2}};  // the panels are at 3 m
  for (const auto& [shift, angle_deg] : cases) {
    views->input.views[4].cam_from_world = Disturbed(right, shift, angle_deg, draw);
    const PoseCheck check = CheckPoses(views->input);
    ASSERT_THAT(Contradicted(check), ElementsAre(4)) << shift << ", " << angle_deg;
    const tracking::ContradictedView& found = check.contradicted[0];
    EXPECT_NEAR(found.turned_deg, angle_deg, 0.3);
    EXPECT_NEAR(found.moved_share, shift / 3, 0.01);
    EXPECT_GT(found.error_px, 3);
    EXPECT_GE(found.by.size(), 2u);
    EXPECT_GE(check.agree, 8);
  }
}

TEST(PoseCheck, APoseThatSaysItIsUnsureMayBeOffByAsMuch) {
  const auto views = MakeViews(10, 0, 0, 6);
  Draw draw(2);
  views->input.views[4].cam_from_world = Disturbed(views->input.views[4].cam_from_world, 0.09, 0, draw);
  views->input.views[4].center_error_share = 0.03;
  EXPECT_THAT(Contradicted(CheckPoses(views->input)), IsEmpty());
}

TEST(PoseCheck, PosesOfOtherPhotographsAreNamed) {
  const auto views = MakeViews(12, 0, 0, 4);
  std::swap(views->images[3], views->images[7]);
  const PoseCheck swapped = CheckPoses(views->input);
  EXPECT_THAT(Contradicted(swapped), ElementsAre(3, 7));
  EXPECT_THAT(WordsOf(swapped, views->input), ElementsAre(AllOf(HasSubstr("views 4 and 8 (view 3, view 7)"),
                                                                HasSubstr("those of 10 views agree"))));

  std::ranges::reverse(views->images);
  const PoseCheck turned = CheckPoses(views->input);
  EXPECT_GE(turned.contradicted.size(), 4u);  // those that are contradicted testify against no others
  EXPECT_THAT(WordsOf(turned, views->input), Contains(HasSubstr("in another order")));
}

// The photographs with poses in a transforms.json: `rows` makes its matrix of the true pose.
void WriteSet(const std::filesystem::path& folder, const RoomViews& views,
              const std::function<Eigen::Matrix4d(const Eigen::Matrix4d& cam_from_world)>& rows) {
  LightField set;
  set.cameras = views.input.lenses;
  for (std::size_t v = 0; v < views.truth.size(); ++v) {
    View& view = set.views.emplace_back();
    view.id = static_cast<int>(v) + 1;
    view.image_path = "images/" + std::to_string(v) + ".png";
    WriteFileAtomically(folder / view.image_path, PngBytes(Srgb8(views.images[v])));
  }
  nlohmann::json document = TransformsDocument(set, {});
  document.erase("ulf");
  for (std::size_t v = 0; v < views.truth.size(); ++v) {
    const Eigen::Matrix4d matrix = rows(views.truth[v].Matrix());
    nlohmann::json& frame = document["frames"][v];
    frame.erase("ulf");
    for (int r = 0; r < 4; ++r)
      frame["transform_matrix"][static_cast<std::size_t>(r)] = {matrix(r, 0), matrix(r, 1), matrix(r, 2),
                                                                matrix(r, 3)};
  }
  WriteFileAtomically(folder / kTransformsFile, JsonText(document));
}

// What other programs take for a pose: a transform_matrix leads from the camera to the world, its y axis
// up and z back.
TEST(PoseCheck, PosesOfAnotherConventionAreNamed) {
  const auto views = MakeViews(8, 0, 0, 5);
  const Eigen::Matrix4d half_turn = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  const auto convention = [&](const std::function<Eigen::Matrix4d(const Eigen::Matrix4d&)>& rows) {
    const ScratchFolder scratch;
    std::filesystem::create_directories(scratch / "images");
    WriteSet(scratch.path(), *views, rows);
    const LightField read = ReadPosedSet(scratch.path(), {}, {}).light_field;
    const PoseCheck check = CheckPoses(tracking::RefineInputOf(read));
    EXPECT_EQ(WordsOf(check, views->input).size(), check.fits_poorly ? 1u : 0u) << "of single views nothing";
    EXPECT_EQ(check.convention.empty(), !check.fits_poorly);
    return check.convention;
  };
  EXPECT_EQ(convention([&](const Eigen::Matrix4d& pose) { return pose.inverse() * half_turn; }), "");
  EXPECT_THAT(convention([](const Eigen::Matrix4d& pose) { return pose.inverse(); }),
              AllOf(HasSubstr("y and z axes point the other way"), Not(HasSubstr("inverted"))));
  EXPECT_THAT(convention([&](const Eigen::Matrix4d& pose) { return half_turn * pose; }),
              AllOf(HasSubstr("inverted"), HasSubstr("y axis up and z back, as in OpenGL")));
  EXPECT_THAT(convention([](const Eigen::Matrix4d& pose) { return pose; }),
              AllOf(HasSubstr("inverted"), HasSubstr("y axis down and z forward, as in OpenCV")));
}

// A walk in a circle that looks outwards.
std::unique_ptr<RoomViews> LookingOutwards(int count, const CameraModel& lens, unsigned seed) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(TexturedRoom::RoundAt(TexturedRoom::kRoundFrames * i / count));
  return ViewsOf(TexturedRoom({.furniture = Furniture::kRound, .seed = seed}), lens, poses);
}

// Photographs that share little have matches that are mostly wrong, whatever the poses.
TEST(PoseCheck, RightPosesThatLookOutwardsAreNotBlamed) {
  const CameraModel lenses[] = {CameraModel::Pinhole(160, 120, 100), CameraModel::Pinhole(640, 480, 400),
                                TexturedRoom::Camera()};
  for (const CameraModel& lens : lenses)
    for (const int count : {8, 12, 24})
      for (const unsigned seed : {1u, 2u}) {
        const auto views = LookingOutwards(count, lens, seed);
        EXPECT_THAT(WordsOf(CheckPoses(views->input), views->input), IsEmpty())
            << count << " of " << lens.width << " px, focal length " << lens.fx << ", seed " << seed;
      }
}

// The same between four walls on which one texture repeats itself, at `radius` metres from their middle.
std::unique_ptr<RoomViews> AmongRepeatedWalls(int count, const CameraModel& lens, double radius,
                                              unsigned seed) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    const Eigen::Vector3d outwards(std::sin(angle), 0, std::cos(angle)), up = -Eigen::Vector3d::UnitY();
    poses.push_back(LookAt(radius * (outwards + 0.15 * std::sin(9 * angle) * up), 3 * outwards, up));
  }
  return ViewsOf(TexturedRoom({.furniture = Furniture::kRepeated, .seed = seed}), lens, poses);
}

TEST(PoseCheck, RepeatedWallsBlameNoRightPoses) {
  for (const auto& [count, radius] : {std::pair(12, 0.15), std::pair(24, 1.0)}) {
    const auto views = AmongRepeatedWalls(count, CameraModel::Pinhole(320, 240, 200), radius, 2);
    EXPECT_THAT(WordsOf(CheckPoses(views->input), views->input), IsEmpty()) << count << " views";
  }
}

// Small pictures of which hardly a part is seen twice: they may be taken for others altogether.
TEST(PoseCheck, SaysThatARepetitionLeavesPosesOpen) {
  const auto views = AmongRepeatedWalls(8, CameraModel::Pinhole(160, 120, 100), 0.15, 1);
  const PoseCheck check = CheckPoses(views->input);
  EXPECT_TRUE(check.fits_poorly && check.is_repetitive);
  EXPECT_GT(check.repeated_share, 0.2);
  EXPECT_THAT(check.contradicted, IsEmpty());
  EXPECT_THAT(WordsOf(check, views->input),
              ElementsAre(AllOf(HasSubstr("cannot be told"), HasSubstr("looks like other places"),
                                Not(HasSubstr("wrong")))));
}

TEST(PoseCheck, TilesBlameNoRightPoses) {
  const TexturedRoom room({.furniture = Furniture::kTiles, .seed = 3});
  const auto views = MakeViews(10, 0, 0, 3);
  for (std::size_t i = 0; i < views->images.size(); ++i)
    views->images[i] = room.Take(views->truth[i], i).image;
  EXPECT_THAT(WordsOf(CheckPoses(views->input), views->input), IsEmpty());
}

TEST(PoseCheck, RepeatedWallsHideNoWrongSet) {
  const auto views = AmongRepeatedWalls(24, CameraModel::Pinhole(320, 240, 200), 1, 3);
  Draw draw(5);
  for (std::size_t i = 0; i < views->truth.size(); ++i)
    views->input.views[i].cam_from_world = Disturbed(views->truth[i], 0.06, 0, draw);  // the walls are at 2 m
  EXPECT_THAT(WordsOf(CheckPoses(views->input), views->input), Contains(HasSubstr("cannot be told")));
}

// A panorama in the hand: between neighbours there is hardly any parallax, and its sign is the pose's error.
TEST(PoseCheck, APanoramasDepthsAreNotJudged) {
  const TexturedRoom room({.furniture = Furniture::kRound, .seed = 4});
  RoomViews views;
  views.input.lenses = {TexturedRoom::Camera()};
  Draw draw(3);
  for (int i = 0; i < 36; ++i) {
    const double angle = 2 * M_PI * i / 36;
    const Eigen::Vector3d center = 0.004 * draw.Direction();
    const Rigid3 pose = LookAt(center, center + Eigen::Vector3d(std::sin(angle), 0, std::cos(angle)),
                               -Eigen::Vector3d::UnitY());
    views.images.push_back(room.Take(pose, static_cast<std::uint64_t>(i)).image);
    views.input.views.push_back({"view " + std::to_string(i), 0, Disturbed(pose, 0.004, 0.05, draw)});
  }
  views.input.read = [&](int i) { return views.images[static_cast<std::size_t>(i)]; };
  const PoseCheck check = CheckPoses(views.input);
  EXPECT_FALSE(check.looks_away);
  EXPECT_THAT(WordsOf(check, views.input), Not(Contains(HasSubstr("wrong as a whole"))));
}

TEST(PoseCheck, WrongPosesThatLookOutwardsAreNoticed) {
  const auto views = LookingOutwards(30, TexturedRoom::Camera(), 3);
  const Rigid3 half_turn{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  const auto words_with = [&](const std::function<Rigid3(int)>& pose) {
    for (int i = 0; i < 30; ++i) views->input.views[static_cast<std::size_t>(i)].cam_from_world = pose(i);
    return WordsOf(CheckPoses(views->input), views->input);
  };
  const auto truth = [&](int i) { return views->truth[static_cast<std::size_t>(i)]; };
  EXPECT_THAT(words_with([&](int i) { return half_turn * truth(i); }),
              Contains(HasSubstr("y and z axes point the other way")));
  EXPECT_THAT(words_with([&](int i) { return truth(i).Inverse(); }), Contains(HasSubstr("inverted")));
  // In another order neighbours by the poses show nothing in common, which says nothing of the poses.
  words_with([&](int i) { return truth((7 * i) % 30); });
  EXPECT_LT(CheckPoses(views->input).agree, 3) << "another order";
  EXPECT_THAT(words_with([&](int i) { return truth(29 - i); }), Not(IsEmpty())) << "the reverse order";
}

// COLMAP's poses lead from the world to the camera, its y axis down and z forward.
TEST(PoseCheck, NamesTheFilesConvention) {
  const Rigid3 half_turn{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  const auto views = MakeViews(8, 0, 0, 5);
  const auto convention = [&](const std::function<Rigid3(const Rigid3&)>& change) {
    for (std::size_t v = 0; v < views->truth.size(); ++v)
      views->input.views[v].cam_from_world = change(views->truth[v]);
    return CheckPoses(views->input).convention;
  };
  EXPECT_THAT(convention([&](const Rigid3& pose) { return half_turn * pose; }),
              HasSubstr("y and z axes point the other way"));
  EXPECT_THAT(convention([](const Rigid3& pose) { return pose.Inverse(); }), HasSubstr("as in OpenCV"));
  EXPECT_THAT(convention([&](const Rigid3& pose) { return (half_turn * pose).Inverse(); }),
              HasSubstr("as in OpenGL"));
}

// A subject that turns before a wall: what stands still speaks against every pose, and is masked.
TEST(PoseCheck, IgnoresMaskedPixels) {
  const auto views = MakeViews(12, 0, 0, 5);
  const cv::Size size = views->images[0].pixels.size();
  const cv::Rect wall(0, 0, size.width * 6 / 10, size.height);
  const cv::Mat standing = views->images[0].pixels(wall).clone();
  for (Image& image : views->images) standing.copyTo(image.pixels(wall));
  const PoseCheck all = CheckPoses(views->input);
  EXPECT_TRUE(all.fits_poorly || !all.contradicted.empty());

  cv::Mat mask(size, CV_8UC1, cv::Scalar(255));
  mask(wall) = 0;
  views->input.read_mask = [&](int) { return mask; };
  const PoseCheck check = CheckPoses(views->input);
  EXPECT_FALSE(check.fits_poorly);
  EXPECT_THAT(check.contradicted, IsEmpty());
  EXPECT_GE(check.agree, 10);
  EXPECT_LT(check.fit_error_px, 1);
}

TEST(PoseCheck, AnotherLensFitsPoorlyAsAWhole) {
  const auto views = MakeViews(8, 0, 0, 5);
  EXPECT_FALSE(CheckPoses(views->input).fits_poorly);
  CameraModel& lens = views->input.lenses[0];
  lens.fx *= 1.25;
  lens.fy *= 1.25;
  const PoseCheck check = CheckPoses(views->input);
  EXPECT_TRUE(check.fits_poorly);
  EXPECT_EQ(check.convention, "");
  EXPECT_GT(check.fit_error_px, 1);
  EXPECT_THAT(WordsOf(check, views->input),
              Contains(AllOf(HasSubstr("by another lens"),
                             HasSubstr(fmt::format("{:.1f} px off in most pairs", check.fit_error_px)))));
}

TEST(PoseCheck, DoesNotBlameUndecidableViews) {
  const auto views = MakeViews(8, 0, 0, 5);
  // One blank photograph and one beyond recognition, of views whose poses are wrong.
  views->images[2].pixels.setTo(cv::Scalar::all(90));
  cv::blur(views->images[5].pixels, views->images[5].pixels, {90, 90});
  for (const std::size_t v : {2u, 5u}) views->input.views[v].cam_from_world = views->truth[0];
  const PoseCheck two = CheckPoses(views->input);
  EXPECT_THAT(two.contradicted, IsEmpty());
  ASSERT_EQ(two.undecided.size(), 2u);
  EXPECT_EQ(two.undecided[0].view, 2);
  EXPECT_THAT(two.undecided[0].why, HasSubstr("shares too little"));
  EXPECT_EQ(two.undecided[1].view, 5);

  for (Image& image : views->images) image.pixels.setTo(cv::Scalar::all(90));
  const PoseCheck plain = CheckPoses(views->input);
  EXPECT_THAT(plain.contradicted, IsEmpty());
  EXPECT_EQ(plain.undecided.size(), 8u);
  views->input.read = [](int) -> Image { throw std::runtime_error("gone"); };
  const PoseCheck unread = CheckPoses(views->input);
  ASSERT_EQ(unread.undecided.size(), 8u);
  EXPECT_EQ(unread.undecided[0].why, "gone");
}

// What ulf info lists, of a folder whose journal has one wrong pose.
TEST(PoseCheck, InfoListsTheViewAndKeepsIt) {
  const auto views = MakeViews(7, 0, 0, 8);
  ScratchFolder scratch;
  const std::filesystem::path dir = scratch / "room";
  Draw draw(2);
  views->input.views[3].cam_from_world = Disturbed(views->truth[3], 0, 2, draw);
  WriteRoom(*views, dir);
  const auto files = [&] {
    std::map<std::string, std::filesystem::file_time_type> times;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(dir))
      times[entry.path().string()] = entry.last_write_time();
    return times;
  };
  const CommandResult told = RunUlf("info " + dir.string() + " --check-poses");
  const auto before = files();
  EXPECT_EQ(told.exit_code, 0) << told.errors;
  EXPECT_THAT(told.output, HasSubstr("6 fit the pictures"));
  EXPECT_THAT(told.output, HasSubstr("contradicted   images/000004.png"));
  EXPECT_THAT(told.output, HasSubstr("ulf refine " + dir.string()));
  const CommandResult as_json = RunUlf("info " + dir.string() + " --check-poses --json");
  EXPECT_THAT(as_json.output, HasSubstr(R"("image":"images/000004.png","moved_share":)"));
  const CommandResult plain = RunUlf("info " + dir.string());
  EXPECT_THAT(plain.output, Not(HasSubstr("contradicted")));
  EXPECT_THAT(plain.errors, HasSubstr("the poses of view 4 (images/000004.png) disagree"));
  EXPECT_EQ(files(), before) << "what was found is kept once";
}

TEST(PoseCheck, RealSetsAgree) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  const LightField light_field = ReadLightField(fox);
  const PoseCheck check = CheckPoses(tracking::RefineInputOf(light_field));
  EXPECT_THAT(check.contradicted, IsEmpty());
  EXPECT_GE(check.agree, 48);
  EXPECT_FALSE(check.fits_poorly);
}

}  // namespace
}  // namespace ulf::test::pose_check_test

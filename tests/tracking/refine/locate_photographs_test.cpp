// Tests: tracking/refine/locate_photographs, commands/tracking/refine_command.
// Photographs without poses are found from views that have them, also those that show nothing of
// these themselves.
#include "tracking/refine/locate_photographs.h"
#include "core/base/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/unposed_photographs.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"

namespace ulf::test::locate_photographs_test {
namespace {

using testing::HasSubstr;

// A walk round the room: its middle shows nothing of its beginning. `unposed`, at its end, is in no order.
struct Walk {
  RefineInput input;
  std::vector<Rigid3> truth;
  std::vector<Image> images;
  std::size_t first_unposed = 0;
};

std::unique_ptr<Walk> MakeWalk(const std::vector<int>& posed, const std::vector<int>& unposed,
                               unsigned seed) {
  const TexturedRoom room({.furniture = Furniture::kRound, .seed = seed});
  auto walk = std::make_unique<Walk>();
  walk->input.lenses = {TexturedRoom::Camera()};
  Draw draw(seed);
  for (const std::vector<int>* steps : {&posed, &unposed})
    for (const int step : *steps) {
      const Rigid3 pose = TexturedRoom::RoundAt(step);
      walk->truth.push_back(pose);
      walk->images.push_back(room.Take(pose, static_cast<std::uint64_t>(step)).image);
      walk->input.views.push_back(
          {"at " + std::to_string(step), 0, steps == &posed ? Disturbed(pose, 0.003, 0.05, draw) : Rigid3()});
    }
  walk->first_unposed = posed.size();
  walk->input.read = [from = walk.get()](int i) { return from->images[static_cast<std::size_t>(i)]; };
  return walk;
}

double CenterError(const Rigid3& pose, const Rigid3& truth) {
  return (pose.OriginInSource() - truth.OriginInSource()).norm();
}

std::vector<int> Steps(int from, int to, int by) {
  std::vector<int> steps;
  for (int k = from; by > 0 ? k < to : k > to; k += by) steps.push_back(k);
  return steps;
}

TEST(LocatePhotographs, FindsThemOneByOneFromEachOther) {
  const auto walk = MakeWalk(Steps(0, 60, 6), Steps(128, 60, -8), 1);
  // The farthest one shows nothing of the views: only through those between is it found.
  const auto alone = MakeWalk(Steps(0, 60, 6), {128}, 1);
  EXPECT_FALSE(LocatePhotographs(alone->input, alone->first_unposed)[0].cam_from_world);
  const auto located = LocatePhotographs(walk->input, walk->first_unposed);
  ASSERT_EQ(located.size(), 9u);
  for (std::size_t i = 0; i < located.size(); ++i) {
    ASSERT_TRUE(located[i].cam_from_world)
        << walk->input.views[walk->first_unposed + i].name << ": " << located[i].why;
    EXPECT_GE(located[i].points, 25);
    EXPECT_LT(CenterError(*located[i].cam_from_world, walk->truth[walk->first_unposed + i]), 0.1)
        << walk->input.views[walk->first_unposed + i].name;
  }
}

TEST(LocatePhotographs, NamesForeignAndUnreadableOnes) {
  const auto walk = MakeWalk(Steps(0, 60, 6), {31, 33, 35}, 1);
  const TexturedRoom other({.furniture = Furniture::kPanels, .seed = 99});
  walk->images[walk->first_unposed + 1] = other.Take(TexturedRoom::HandAt(5), 1).image;
  walk->input.read = [&](int i) {
    if (i == static_cast<int>(walk->first_unposed) + 2) throw Error("x.jpg: is damaged");
    return walk->images[static_cast<std::size_t>(i)];
  };
  const auto located = LocatePhotographs(walk->input, walk->first_unposed);
  EXPECT_TRUE(located[0].cam_from_world);
  EXPECT_FALSE(located[1].cam_from_world);
  EXPECT_THAT(located[1].why, HasSubstr("shows too little"));
  EXPECT_FALSE(located[2].cam_from_world);
  EXPECT_THAT(located[2].why, HasSubstr("x.jpg: is damaged"));
}

// What was found has drifted: the recorded views' place, turn and scale are those of the world all the same.
TEST(LocatePhotographs, DoNotMoveTheRecordedWorld) {
  const auto walk = MakeWalk(Steps(0, 60, 6), Steps(128, 60, -8), 1);
  RefineInput recorded = walk->input;
  recorded.views.resize(walk->first_unposed);
  RefineInput all = walk->input;
  for (std::size_t v = walk->first_unposed; v < all.views.size(); ++v) {
    all.views[v].is_recorded = false;
    all.views[v].cam_from_world = walk->truth[v];
    all.views[v].cam_from_world.translation += Eigen::Vector3d(0.2, 0, 0.1);
  }
  const RefineOptions few{.features = 500};
  const RefineResult alone = Refine(recorded, few), together = Refine(all, few);
  EXPECT_EQ(together.registered, static_cast<int>(all.views.size()));
  for (std::size_t v = 0; v < walk->first_unposed; ++v)
    EXPECT_LT(CenterError(together.views[v].cam_from_world, alone.views[v].cam_from_world), 0.005) << v;
  EXPECT_LT(together.moved_max, 0.02) << "of the recorded views";
  for (std::size_t v = walk->first_unposed; v < all.views.size(); ++v) {
    EXPECT_GT(together.views[v].quality, 0.5);
    EXPECT_LT(together.views[v].quality, 1);
  }
}

// Photographs that fit one another and no recorded view are of another place.
TEST(LocatePhotographs, RefusesAnUnattachedGroup) {
  const auto walk = MakeWalk(Steps(0, 60, 6), Steps(180, 230, 6), 1);
  for (std::size_t v = walk->first_unposed; v < walk->input.views.size(); ++v) {
    walk->input.views[v].is_recorded = false;
    walk->input.views[v].cam_from_world = walk->truth[v];
  }
  const RefineResult result = Refine(walk->input, {.features = 500});
  for (std::size_t v = 0; v < walk->input.views.size(); ++v)
    EXPECT_EQ(result.views[v].registered, v < walk->first_unposed) << v;
  EXPECT_THAT(result.views.back().why, HasSubstr("no recorded view"));
  EXPECT_EQ(result.groups, 1);
}

TEST(RefineCommand, LocatedPhotographsBecomeViews) {
  const ScratchFolder scratch;
  const std::filesystem::path dir = scratch / "room";
  const auto walk = MakeWalk(Steps(0, 60, 5), {32, 12, 47}, 2);
  {
    CaptureHeader header;
    header.camera = walk->input.lenses[0];
    LightFieldWriter writer = LightFieldWriter::Create(dir, header);
    for (std::size_t i = 0; i < walk->truth.size(); ++i) {
      Frame frame;
      frame.image = walk->images[i];
      frame.device_time_s = 0.1 * static_cast<double>(i);
      View view;
      view.cam_from_world = walk->input.views[i].cam_from_world;
      if (i < walk->first_unposed)
        writer.AddView(frame, view);
      else
        writer.KeepUnposed(frame);
    }
    Frame elsewhere;
    elsewhere.image = TexturedRoom({.seed = 77}).Take(TexturedRoom::HandAt(3), 3).image;
    writer.KeepUnposed(elsewhere);
    writer.Close(2);
  }
  const auto without = RunUlf("refine " + dir.string());
  ASSERT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_THAT(without.output, HasSubstr("4 photographs in unposed/ without a pose: ulf refine"));
  EXPECT_EQ(ReadLightField(dir).views.size(), walk->first_unposed);

  const auto run = RunUlf("refine " + dir.string() + " --unposed --json");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto unposed = JsonFromText(run.output)["unposed"];
  EXPECT_EQ(unposed["found"].size(), 3u);
  ASSERT_EQ(unposed["not_found"].size(), 1u);
  EXPECT_EQ(unposed["not_found"][0]["photograph"], "unposed/unposed_000004.png");
  const LightField after = ReadLightField(dir);
  ASSERT_EQ(after.views.size(), walk->truth.size());
  EXPECT_LT(ErrorsOf(walk->truth, [&](std::size_t i) { return after.views[i].cam_from_world; }).center, 0.01);
  EXPECT_NEAR(after.views.back().device_time_s, 0.1 * static_cast<double>(walk->truth.size() - 1), 1e-9);
  EXPECT_EQ(UnposedPhotographs(after).size(), 1u);
  std::size_t seen = 0;
  for (const ScenePoint& point : after.points)
    for (const ViewObservation& observation : point.track)
      seen += observation.view_id == after.views.back().id;
  EXPECT_GT(seen, 50u) << "the points know the new view";

  const auto copy = RunUlf("refine " + dir.string() + " --unposed -o " + (scratch / "copy").string());
  EXPECT_EQ(copy.exit_code, 2);
  EXPECT_THAT(copy.errors, HasSubstr("leave out one of the two"));
}

}  // namespace
}  // namespace ulf::test::locate_photographs_test

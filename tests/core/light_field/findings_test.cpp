// Tests: core/light_field/findings, core/light_field/folder/kept_findings,
// core/light_field/folder/quick_checks.
//
// What checks find wrong: what is kept in the journal, how long it stands, and what every reader
// sees by itself.
#include "core/light_field/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder/kept_findings.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/quick_checks.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::findings_test {
namespace {

using test::ScratchFolder;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> Words(const std::vector<Finding>& findings) {
  std::vector<std::string> words;
  for (const Finding& each : findings) words.push_back(each.Words());
  return words;
}

std::vector<std::string> WordsIn(const fs::path& dir) { return Words(ReadLightField(dir).findings); }

Finding WrongViews(const LightField& light_field, const std::vector<std::size_t>& views) {
  Finding finding{Name(Check::kPoses), "{views} are wrong", {}};
  for (const std::size_t i : views) finding.views[light_field.views[i].id] = light_field.views[i].image_path;
  return finding;
}

class KeptFindings : public testing::Test {
 protected:
  KeptFindings() {
    WriteSample(dir_, 6);
    light_field_ = ReadLightField(dir_);
  }
  void KeepTwo() { ASSERT_EQ(KeepFindings(dir_, Check::kPoses, {WrongViews(light_field_, {1, 2})}), ""); }
  fs::path PhotographOf(std::size_t view) const { return dir_ / light_field_.views[view].image_path; }
  ScratchFolder scratch_;
  fs::path dir_ = scratch_ / "lf";
  LightField light_field_;
};

TEST_F(KeptFindings, AreReadAgainAndNothingElseChanges) {
  ASSERT_THAT(WordsIn(dir_), IsEmpty());
  KeepTwo();
  EXPECT_THAT(WordsIn(dir_), ElementsAre("views 2 and 3 (images/000002.png, images/000003.png) are wrong"));
  EXPECT_THAT(ReadLightField(dir_).doubts, IsEmpty());
  EXPECT_FALSE(PlanRepair(dir_).any()) << "derived files still hold all";
  const auto bytes = fs::file_size(dir_ / kJournalFile);
  KeepTwo();
  EXPECT_EQ(fs::file_size(dir_ / kJournalFile), bytes) << "the same is kept once";
  EXPECT_THAT(Words(LightFieldWriter::Resume(dir_).Contents().findings),
              ElementsAre(HasSubstr("views 2 and 3")));
}

TEST_F(KeptFindings, StandBesideThoseOfOtherChecks) {
  KeepTwo();
  EXPECT_EQ(KeepFindings(dir_, Check::kLight, {{Name(Check::kLight), "the lamp changed", {}}}), "");
  EXPECT_THAT(WordsIn(dir_), ElementsAre(HasSubstr("are wrong"), "the lamp changed"));
  EXPECT_EQ(KeepFindings(dir_, Check::kPoses, {}), "");
  EXPECT_THAT(WordsIn(dir_), ElementsAre("the lamp changed"));
}

TEST_F(KeptFindings, LapseForAViewWhosePhotographChanged) {
  KeepTwo();
  fs::rename(PhotographOf(1), scratch_ / "kept.png");
  fs::copy_file(PhotographOf(4), PhotographOf(1));
  EXPECT_THAT(WordsIn(dir_), ElementsAre(HasSubstr("view 3 (images/000003.png) are wrong")));
  fs::copy_file(PhotographOf(4), PhotographOf(2), fs::copy_options::overwrite_existing);
  EXPECT_THAT(WordsIn(dir_), IsEmpty());
  fs::copy_file(scratch_ / "kept.png", PhotographOf(1), fs::copy_options::overwrite_existing);
  EXPECT_THAT(WordsIn(dir_), ElementsAre(HasSubstr("view 2"))) << "a copy with another time is the same";
}

TEST_F(KeptFindings, LapseForAViewWithAnotherPoseOrNone) {
  KeepTwo();
  LightFieldWriter writer = LightFieldWriter::Resume(dir_);
  writer.UpdatePoses({{2, ViewNumber(5).cam_from_world}});
  EXPECT_THAT(WordsIn(dir_), ElementsAre(HasSubstr("view 3")));
  writer.RemoveViews({3});
  EXPECT_THAT(WordsIn(dir_), IsEmpty());
}

TEST_F(KeptFindings, AboutAllStandWhileMostViewsDo) {
  ASSERT_EQ(KeepFindings(dir_, Check::kPoses, {{Name(Check::kPoses), "all poses are wrong", {}}}), "");
  LightFieldWriter writer = LightFieldWriter::Resume(dir_);
  writer.UpdatePoses({{1, ViewNumber(5).cam_from_world}, {2, ViewNumber(5).cam_from_world}});
  EXPECT_THAT(WordsIn(dir_), ElementsAre("all poses are wrong"));
  writer.UpdatePoses({{3, ViewNumber(5).cam_from_world}});
  EXPECT_THAT(WordsIn(dir_), IsEmpty());
}

// Views 5 and 6 are darker than the others: nothing is said without them, or without the others.
TEST_F(KeptFindings, AboutLightLapseWithTheirViews) {
  Finding darker{Name(Check::kLight), "views 5 to 6 are darker", {}};
  for (const std::size_t i : {4, 5})
    darker.views[light_field_.views[i].id] = light_field_.views[i].image_path;
  ASSERT_EQ(KeepFindings(dir_, Check::kLight, {darker}), "");
  fs::copy(dir_, scratch_ / "other", fs::copy_options::recursive);
  LightFieldWriter::Resume(dir_).RemoveViews({1, 5});
  EXPECT_THAT(WordsIn(dir_), ElementsAre("views 5 to 6 are darker"));
  LightFieldWriter::Resume(dir_).RemoveViews({6});
  EXPECT_THAT(WordsIn(dir_), IsEmpty());
  LightFieldWriter::Resume(scratch_ / "other").RemoveViews({1, 2, 3});
  EXPECT_THAT(WordsIn(scratch_ / "other"), IsEmpty());
}

TEST_F(KeptFindings, GoAlongIntoACopyByImport) {
  KeepTwo();
  Import(dir_, scratch_ / "copy", {});
  EXPECT_THAT(WordsIn(scratch_ / "copy"), ElementsAre(HasSubstr("views 2 and 3")));
}

TEST_F(KeptFindings, SurviveRepairRemovalAndNewViews) {
  KeepTwo();
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir_);
    writer.AddView(NoiseFrame(9), ViewNumber(9));
    writer.RemoveViews({2});
    writer.Close(20);
  }
  fs::remove(dir_ / kTransformsFile);
  EXPECT_TRUE(Repair(dir_).not_done.empty());
  EXPECT_THAT(WordsIn(dir_), ElementsAre(HasSubstr("view 3 (images/000003.png) are wrong")));
}

TEST_F(KeptFindings, AreNotWrittenIntoWhatMustStayAsItIs) {
  const std::vector<Finding> found{WrongViews(light_field_, {1, 2})};
  const std::string journal = ReadWholeFile(dir_ / kJournalFile);
  {
    const LightFieldWriter writer = LightFieldWriter::Resume(dir_);
    EXPECT_THAT(KeepFindings(dir_, Check::kPoses, found), HasSubstr("another process is recording"));
  }
  WriteFileAtomically(dir_ / kJournalFile, journal.substr(0, journal.size() - 20));
  EXPECT_THAT(KeepFindings(dir_, Check::kPoses, found), HasSubstr("damaged"));
  EXPECT_EQ(fs::file_size(dir_ / kJournalFile), journal.size() - 20);
  // The last view is lost, at the end of a line.
  const std::size_t view = journal.rfind('\n', journal.rfind(R"("event":"view")")) + 1;
  ASSERT_GT(view, 0u);
  WriteFileAtomically(dir_ / kJournalFile, journal.substr(0, view));
  EXPECT_THAT(KeepFindings(dir_, Check::kPoses, found), HasSubstr("lost its end"));
  EXPECT_EQ(fs::file_size(dir_ / kJournalFile), view);
  fs::remove(dir_ / kJournalFile);
  EXPECT_THAT(KeepFindings(dir_, Check::kPoses, found), HasSubstr("never written to"));
  EXPECT_FALSE(fs::exists(dir_ / kJournalFile));
}

TEST_F(KeptFindings, FailNothingInAReadOnlyFolder) {
  const std::string dir = dir_.string();
  if (mount(dir.c_str(), dir.c_str(), nullptr, MS_BIND, nullptr) != 0)
    GTEST_SKIP() << "no folder can be made read-only here";
  ASSERT_EQ(mount(nullptr, dir.c_str(), nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr), 0);
  const std::string why = KeepFindings(dir_, Check::kPoses, {WrongViews(light_field_, {1})});
  EXPECT_EQ(umount(dir.c_str()), 0);
  EXPECT_THAT(why, HasSubstr("Read-only"));
}

TEST_F(KeptFindings, OfANewerVersionAreRepeated) {
  std::ofstream(dir_ / kJournalFile, std::ios::app)
      << R"({"event":"checked","check":"smoke","found":[{"text":"it smokes","whole":true,"views":{"1":{}}}]})"
      << "\n"
      << R"({"event":"checked","check":"poses"})"
      << "\n"
      << R"({"event":"checked","check":"poses","found":[]})"
      << "\n";
  const LightField read = ReadLightField(dir_);
  EXPECT_THAT(Words(read.findings), ElementsAre("it smokes"));
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("'found' is missing")));
}

// ---- Points and subject, by numbers alone ----

// As a foreign set writes it: the camera's place `times` as far from the world's origin.
LightField Scaled(LightField light_field, double times) {
  for (View& view : light_field.views) view.cam_from_world.translation *= times;
  return light_field;
}

LightField WithoutTracks(LightField light_field) {
  for (ScenePoint& point : light_field.points) point.track.clear();
  return light_field;
}

TEST(QuickChecks, RightPointsAreNotBlamed) {
  const ScratchFolder scratch;
  const LightField right =
      test::TrackedLightField(scratch / "lf", {test::Straight(), test::Lens(), test::Fisheye()});
  EXPECT_THAT(Words(QuickFindings(right)), IsEmpty());
  EXPECT_THAT(Words(QuickFindings(WithoutTracks(right))), IsEmpty());
  EXPECT_THAT(WordsIn(scratch / "lf"), IsEmpty());
}

TEST(QuickChecks, PointsOfAnotherScaleAreFound) {
  const ScratchFolder scratch;
  LightField right = test::TrackedLightField(scratch / "lf", {test::Straight()});
  right.subject.reset();
  for (const double times : {1000.0, 0.001}) {
    EXPECT_THAT(Words(QuickFindings(Scaled(right, times))),
                ElementsAre(HasSubstr("do not belong to the poses")))
        << times;
    EXPECT_THAT(Words(QuickFindings(WithoutTracks(Scaled(right, times)))),
                ElementsAre(HasSubstr("do not belong to the poses")))
        << times;
  }
}

// Looking inwards at the origin, the points are a speck in the middle of every picture.
TEST(QuickChecks, PointsAroundTheOriginAreFoundAsASpeck) {
  LightField light_field;
  light_field.cameras = {test::Straight()};
  for (int i = 0; i < 12; ++i) {
    View& view = light_field.views.emplace_back();
    view.id = i + 1;
    view.cam_from_world = LookAt({2 * std::cos(0.5 * i), 0.3, 2 * std::sin(0.5 * i)}, {0, 0, 0}, {0, -1, 0});
  }
  cv::RNG random(3);
  for (int i = 0; i < 100; ++i)
    light_field.points.push_back(
        {{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)}});
  EXPECT_THAT(QuickFindings(light_field), IsEmpty());
  EXPECT_THAT(Words(QuickFindings(Scaled(light_field, 1000))), ElementsAre(HasSubstr("a speck")));
}

TEST(QuickChecks, ObservationsLeftOutOnReadingCount) {
  const ScratchFolder scratch;
  LightField moved = test::TrackedLightField(scratch / "lf", {test::Straight()});
  // Another reconstruction: the same photographs, the world turned a little.
  for (ScenePoint& point : moved.points) point.position_in_world.x() += 0.3;
  WriteLightField(moved);
  EXPECT_THAT(WordsIn(scratch / "lf"),
              ElementsAre(HasSubstr("more than 4 px from where the poses put them")));
}

TEST(QuickChecks, ASubjectThatNoPhotographShowsIsSaid) {
  const ScratchFolder scratch;
  WriteSample(scratch / "lf", 4);
  EXPECT_THAT(WordsIn(scratch / "lf"), IsEmpty());
  LightFieldWriter::Resume(scratch / "lf").SetSubject({{0, 0, -3000}, 400});
  EXPECT_THAT(WordsIn(scratch / "lf"),
              ElementsAre(HasSubstr("no photograph shows the middle of the subject")));
}

TEST(QuickChecks, ASubjectThatIsAbsurdlyFarAwayIsSaid) {
  const ScratchFolder scratch;
  LightField light_field = test::TrackedLightField(scratch / "lf", {test::Straight()});
  light_field.subject = Subject{{0, 0, 3000}, 500};
  EXPECT_THAT(Words(QuickFindings(light_field)), ElementsAre(HasSubstr("times as far away as")));
  for (View& view : light_field.views) view.cam_from_world = light_field.views.front().cam_from_world;
  EXPECT_THAT(Words(QuickFindings(light_field)), Not(Contains(HasSubstr("times as far away as"))))
      << "cameras at one place say nothing of the subject";
}

TEST(QuickChecks, AForeignSetIsToldTheSame) {
  const ScratchFolder scratch;
  LightField set = Scaled(test::TrackedLightField(scratch / "set", {test::Straight()}), 1000);
  WriteLightField(set);
  fs::remove(scratch / "set" / kJournalFile);
  EXPECT_THAT(WordsIn(scratch / "set"), Not(IsEmpty()));
}

// ---- The table ----

TEST(Findings, EveryCheckHasARowInTheTable) {
  const std::string page = ReadWholeFile(CHECKOUT "/docs/light_field.md");
  const std::size_t begin = page.find("\n## Checks");
  ASSERT_NE(begin, std::string::npos);
  const std::string table = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  for (const Check check : kChecks)
    EXPECT_THAT(table, HasSubstr("\n| `" + std::string(Name(check)) + "` | "));
}

}  // namespace
}  // namespace ulf::findings_test

// Tests: core/light_field/folder/folder_check, core/light_field/folder/folder_repair,
// core/light_field/folder/repair_plan, core/light_field/folder/derived_files,
// commands/light_field/repair_command, core/light_field/journal_stamp.
//
// Each pair of files that tell one fact, made to disagree: which one is used, what is said, what is kept.
// Every row of the table in docs/light_field.md, "Which file is used", has a test here.
#include "core/light_field/folder/folder_check.h"
#include "core/base/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/derived_files.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::folder_check_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

// Every file below `dir` with its bytes.
std::map<std::string, std::string> Content(const fs::path& dir) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(dir))
    if (entry.is_regular_file())
      content[entry.path().lexically_relative(dir).generic_string()] = ReadWholeFile(entry.path());
  return content;
}

void CutJournal(const fs::path& dir, double share) {
  const fs::path journal = dir / "journal.jsonl";
  fs::resize_file(journal, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(journal))));
}

std::vector<int> Ids(const LightField& light_field) {
  std::vector<int> ids;
  for (const View& view : light_field.views) ids.push_back(view.id);
  return ids;
}

void Rewrite(const fs::path& file, const std::function<void(std::string&)>& change) {
  std::string bytes = ReadWholeFile(file);
  change(bytes);
  std::ofstream(file, std::ios::trunc | std::ios::binary) << bytes;
}

std::size_t LineBegin(const std::string& bytes, int number) {
  std::size_t at = 0;
  for (int n = 1; n < number; ++n) at = bytes.find('\n', at) + 1;
  return at;
}

class Folder : public testing::Test {
 protected:
  fs::path dir() const { return scratch_ / "lf"; }
  LightField Sample(int views) { return WriteSample(dir(), views); }
  // Reading says something with all of these words, throws nothing and writes nothing.
  LightField ReadSaying(const std::vector<std::string>& words) {
    const auto before = Content(dir());
    const LightField read = ReadLightField(dir());
    EXPECT_EQ(Content(dir()), before) << "reading wrote";
    std::string said;
    for (const std::string& each : read.doubts) said += each + "\n";
    for (const std::string& word : words) EXPECT_THAT(said, HasSubstr(word));
    return read;
  }
  ScratchFolder scratch_;
};

TEST_F(Folder, IntactOneHasNoFindings) {
  Sample(4);
  EXPECT_THAT(ReadSaying({}).doubts, IsEmpty());
  EXPECT_FALSE(PlanRepair(dir()).any());
}

TEST_F(Folder, EmptyOneHasNoFindings) {
  LightFieldWriter::Create(dir(), Header()).Close(0, {});
  EXPECT_THAT(ReadSaying({}).doubts, IsEmpty());
  EXPECT_FALSE(PlanRepair(dir()).any());
}

// ---- journal and transforms.json ----

TEST_F(Folder, LostEndOfTheJournalIsReportedOnly) {
  Sample(9);
  CutJournal(dir(), 1.0 / 3);
  const LightField read = ReadSaying({"transforms.json holds", "that the journal has lost", "ulf repair"});
  EXPECT_LT(read.views.size(), 9u);
  EXPECT_EQ(ReadTransformsJson(dir() / "transforms.json").views.size(), 9u);
}

TEST_F(Folder, NoWriterGoesOnWithAJournalThatLostItsEnd) {
  Sample(9);
  CutJournal(dir(), 1.0 / 3);
  const auto before = Content(dir());
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("ulf repair"), HasSubstr("--write"))));
  EXPECT_EQ(Content(dir()), before);
}

TEST_F(Folder, RepairIsAPlanUntilItIsToWrite) {
  Sample(9);
  CutJournal(dir(), 1.0 / 3);
  const auto before = Content(dir());
  const auto plan = test::RunUlf("repair " + dir().string());
  EXPECT_EQ(plan.exit_code, 0) << plan.errors;
  EXPECT_THAT(plan.output, AllOf(HasSubstr("would put"), HasSubstr("nothing has been changed yet")));
  EXPECT_EQ(Content(dir()), before);
}

TEST_F(Folder, RepairSaysWhatItDoesAndNothingElse) {
  Sample(9);
  Rewrite(dir() / "journal.jsonl",
          [](std::string& bytes) { bytes.resize(bytes.rfind('\n', bytes.size() * 2 / 3) + 1); });
  EXPECT_THAT(test::RunUlf("repair " + dir().string()).output,
              AllOf(HasSubstr("would write the journal again; the old one stays in kept/\n"),
                    Not(HasSubstr("damaged"))));
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[LineBegin(bytes, 4) + 9] = '\x01'; });
  EXPECT_THAT(test::RunUlf("repair " + dir().string() + " --write").output,
              AllOf(HasSubstr("did this: write the journal again without 1 damaged line; the old one stays"),
                    Not(HasSubstr("done:"))));
}

TEST_F(Folder, RepairPutsBackWhatTheJournalLost) {
  const LightField whole = Sample(9);
  const std::string old_transforms = ReadWholeFile(dir() / "transforms.json");
  CutJournal(dir(), 1.0 / 3);
  const auto before = Content(dir());
  const auto done = test::RunUlf("repair " + dir().string() + " --write");
  EXPECT_EQ(done.exit_code, 0) << done.errors;
  const LightField repaired = ReadSaying({});
  EXPECT_THAT(repaired.doubts, IsEmpty());
  ExpectSame(whole, repaired);
  for (const auto& [path, bytes] : before)
    if (path.starts_with("images/")) {
      EXPECT_EQ(ReadWholeFile(dir() / path), bytes) << path;
    }
  EXPECT_EQ(ReadWholeFile(dir() / "kept/journal-1.jsonl"), before.at("journal.jsonl"));
  EXPECT_FALSE(PlanRepair(dir()).any());
  EXPECT_EQ(LightFieldWriter::Resume(dir()).AddView(NoiseFrame(30), ViewNumber(3)).id, 10);
}

// Poses that were corrected late stand in transforms.json alone once the end of the journal is gone.
TEST_F(Folder, RepairRestoresLostCorrections) {
  Sample(4);
  const Rigid3 moved = LookAt({9, 9, 9}, {0, 0, 0}, {0, -1, 0});
  const auto length = fs::file_size(dir() / "journal.jsonl");
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    CameraModel found = writer.Contents().cameras.at(0);
    found.fx += 3;
    writer.UpdatePoses({{2, moved}}, {{0, {found, "the images"}}});
    writer.Close(3);
  }
  EXPECT_EQ(ReadSaying({}).CalibrationSource(0), "the images");
  fs::resize_file(dir() / "journal.jsonl", length);
  ReadSaying({"corrections of poses may be lost"});
  EXPECT_THROW(LightFieldWriter::Resume(dir()), Error);
  Repair(dir());
  const LightField repaired = ReadSaying({});
  EXPECT_LT((repaired.views[1].cam_from_world.Matrix() - moved.Matrix()).norm(), 1e-9);
  EXPECT_EQ(repaired.capture_s, 3);
  EXPECT_EQ(repaired.CalibrationSource(0), "the images") << "with the corrected lens";
}

// What has been recorded since is newer than the file: only what is missing comes from it.
TEST_F(Folder, RepairKeepsWhatIsNewerThanItsSource) {
  Sample(4);
  const Rigid3 moved = LookAt({9, 9, 9}, {0, 0, 0}, {0, -1, 0});
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    writer.AddView(NoiseFrame(9), ViewNumber(9));
    writer.UpdatePoses({{2, moved}, {3, moved}});
  }  // not closed: transforms.json has four views and the old poses
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[bytes.find("\"id\":3") + 3] = '\x01'; });
  ReadSaying({"line 6: damaged", "view 3 is in doubt", "holds 1 view that the journal has lost (view 3)"});
  Repair(dir());
  const LightField repaired = ReadSaying({});
  EXPECT_THAT(Ids(repaired), ElementsAre(1, 2, 3, 4, 5));
  for (const std::size_t corrected : {1u, 2u})
    EXPECT_LT((repaired.views[corrected].cam_from_world.Matrix() - moved.Matrix()).norm(), 1e-9) << corrected;
}

TEST_F(Folder, AnEditedTransformsJsonDoesNotCountAndIsKept) {
  const LightField whole = Sample(4);
  json document = JsonFromText(ReadWholeFile(dir() / "transforms.json"));
  document["frames"][1]["transform_matrix"][0][3] = 77.0;
  std::ofstream(dir() / "transforms.json") << JsonText(document);
  const std::string edited = ReadWholeFile(dir() / "transforms.json");
  ExpectSame(whole, ReadSaying({"transforms.json differs from the journal (view 2): the journal is used"}));
  LightFieldWriter::Resume(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "kept/transforms.json"), edited);
  EXPECT_THAT(ReadSaying({}).doubts, IsEmpty());
}

// Another build of ulf, or another compiler, may have written it.
TEST_F(Folder, RoundingInATransformsJsonIsNoDifference) {
  Sample(4);
  const auto edit = [&](double by) {
    json document = JsonFromText(ReadWholeFile(dir() / "transforms.json"));
    json& entry = document["frames"][2]["transform_matrix"][0][3];
    entry = entry.get<double>() + by;
    std::ofstream(dir() / "transforms.json") << JsonText(document, 1) << "\n";
  };
  edit(2e-16);
  EXPECT_THAT(PlanRepair(dir()).found, IsEmpty());
  edit(1e-10);
  EXPECT_THAT(PlanRepair(dir()).found, ElementsAre(HasSubstr("differs from what ulf made")));
}

TEST_F(Folder, UnreadableTransformsJsonIsRemadeAndKept) {
  const LightField whole = Sample(4);
  fs::resize_file(dir() / "transforms.json", 300);
  ExpectSame(whole, ReadSaying({"transforms.json", "not valid JSON", "derived from the journal"}));
  Repair(dir());
  EXPECT_EQ(ReadTransformsJson(dir() / "transforms.json").views.size(), 4u);
  EXPECT_EQ(fs::file_size(dir() / "kept/transforms.json"), 300u);
}

// As after a kill.
TEST_F(Folder, OnlyRepairRenewsOlderDerivedFiles) {
  {
    LightFieldWriter writer = LightFieldWriter::Create(dir(), Header());
    writer.AddView(NoiseFrame(0), ViewNumber(0));
    writer.AddView(NoiseFrame(1), ViewNumber(1));
  }
  EXPECT_EQ(ReadSaying({}).views.size(), 2u);
  EXPECT_FALSE(fs::exists(dir() / "transforms.json"));
  const auto for_others = HasSubstr("'ulf repair " + dir().string() + " --write' writes them");
  EXPECT_THAT(test::RunUlf("info " + dir().string()).output, for_others);
  Repair(dir());
  EXPECT_THAT(test::RunUlf("info " + dir().string()).output, Not(for_others));
  EXPECT_EQ(ReadTransformsJson(dir() / "transforms.json").views.size(), 2u);
  EXPECT_FALSE(fs::exists(dir() / "kept")) << "nothing had to be replaced";
}

TEST_F(Folder, AMissingJournalIsMadeFromTransformsJson) {
  const LightField whole = Sample(4);
  fs::remove(dir() / "journal.jsonl");
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf repair")));
  Repair(dir());
  ExpectSame(whole, ReadSaying({}));
  EXPECT_EQ(LightFieldWriter::Resume(dir()).NextViewId(), 5);
}

// Depth maps, mesh and points are bound to poses by a digest.
TEST_F(Folder, LostJournalComesBackToTheLastDigit) {
  for (const double share : {0.0, 0.5}) {
    fs::remove_all(dir());
    Sample(4);
    {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      cv::RNG random(3);
      std::map<int, Rigid3> poses;
      for (int i = 0; i < 40; ++i) writer.AddView(NoiseFrame(10 + i), ViewNumber(10 + i));
      const auto look = [&] {
        return LookAt({random.uniform(-1., 1.), random.uniform(-1., 1.), -2}, {0, 0, 0}, {0, -1, 0});
      };
      for (const View& view : writer.Contents().views) poses[view.id] = look() * look().Inverse() * look();
      writer.UpdatePoses(poses);
      writer.SetMeasured({.cover = "measured",
                          .goal_db = 35,
                          .frames = 12,
                          .directions = {{.direction = {0, 0, 1}, .db = 40.5, .cause = "none"}}});
      writer.Close(3);
    }
    const LightField whole = ReadSaying({});
    CutJournal(dir(), share);
    if (share == 0) fs::remove(dir() / "journal.jsonl");
    Repair(dir());
    const LightField repaired = ReadSaying({});
    ASSERT_EQ(repaired.views.size(), whole.views.size());
    for (std::size_t i = 0; i < whole.views.size(); ++i) {
      const Rigid3 &is = repaired.views[i].cam_from_world, &was = whole.views[i].cam_from_world;
      EXPECT_EQ(is.rotation.coeffs(), was.rotation.coeffs()) << share << ", view " << whole.views[i].id;
      EXPECT_EQ(is.translation, was.translation) << share << ", view " << whole.views[i].id;
    }
    ASSERT_TRUE(repaired.measured) << share;
    EXPECT_EQ(repaired.measured->frames, 12u);
    EXPECT_EQ(repaired.measured->directions.at(0).db, 40.5);
  }
}

// Its transforms.json is no damaged one.
TEST_F(Folder, TransformsJsonWithoutMeasuresIsAnOlderOne) {
  Sample(4);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    writer.SetMeasured({.cover = "measured", .goal_db = 35, .frames = 12, .directions = {}});
    writer.Close(3);
  }
  LightField as_before = ReadLightField(dir());
  as_before.measured.reset();
  const auto stamp = ReadTransformsText(dir() / "transforms.json").made_from;
  Rewrite(dir() / "transforms.json",
          [&](std::string& bytes) { bytes = TransformsJsonText(as_before, stamp); });
  const RepairPlan plan = PlanRepair(dir());
  EXPECT_THAT(plan.found, IsEmpty());
}

// With the journal and transforms.json gone, or written over by another program.
TEST_F(Folder, AMissingJournalIsMadeFromTheModelAlone) {
  for (const bool foreign : {false, true}) {
    fs::remove_all(dir());
    const LightField whole = Sample(4);
    const auto before = Content(dir());
    fs::remove(dir() / "journal.jsonl");
    fs::remove(dir() / "transforms.json");
    if (foreign) std::ofstream(dir() / "transforms.json") << R"({"fl_x": 60, "frames": []})";
    EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf repair")));
    const auto done = test::RunUlf("repair " + dir().string() + " --write");
    EXPECT_EQ(done.exit_code, 0) << done.errors;
    EXPECT_THAT(done.output,
                AllOf(HasSubstr("subject, up, goal and times"), HasSubstr("header from sparse/0"),
                      HasSubstr("did this: write a journal\n"), HasSubstr("0 views before, 4 now"),
                      Not(HasSubstr("damaged"))));
    const LightField repaired = ReadSaying({});
    ASSERT_EQ(repaired.views.size(), 4u);
    EXPECT_EQ(repaired.cameras, whole.cameras);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(repaired.views[i].image_path, whole.views[i].image_path);
      EXPECT_LT((repaired.views[i].cam_from_world.Matrix() - whole.views[i].cam_from_world.Matrix()).norm(),
                1e-9);
      EXPECT_EQ(ReadWholeFile(dir() / whole.views[i].image_path), before.at(whole.views[i].image_path));
    }
    EXPECT_EQ(LightFieldWriter::Resume(dir()).NextViewId(), 5);
    EXPECT_FALSE(PlanRepair(dir()).any());
  }
}

// The model names none; another view's is none of its own.
TEST_F(Folder, MastersComeBackWithViewsOfTheModel) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 4);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  const std::string other = ReadWholeFile(dir() / "masters/000003.tif");
  std::ofstream(dir() / "masters/000002.tif", std::ios::binary) << other;
  fs::remove(dir() / "journal.jsonl");
  fs::remove(dir() / "transforms.json");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf repair")));
  const auto before = Content(dir());
  Repair(dir());
  std::vector<std::string> masters;
  for (const View& view : ReadLightField(dir()).views) masters.push_back(view.master_path);
  EXPECT_THAT(masters, ElementsAre("masters/000001.tif", "", "masters/000003.tif", "masters/000004.tif"));
  for (const auto& [path, bytes] : before)
    if (path.starts_with("images/") || path.starts_with("masters/")) {
      EXPECT_EQ(ReadWholeFile(dir() / path), bytes) << path;
    }
  EXPECT_NO_THROW(LightFieldWriter::Resume(dir()));
}

// Only what repair can mend is sent there, by a command that a shell takes as it is.
TEST_F(Folder, FoldersWithoutAJournalAreToldApart) {
  const auto refusal = [](const fs::path& folder) {
    try {
      LightFieldWriter::Resume(folder);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(refusal(scratch_ / "nowhere"), AllOf(HasSubstr("no such folder"), Not(HasSubstr("repair"))));
  fs::create_directories(scratch_ / "empty");
  EXPECT_THAT(refusal(scratch_ / "empty"), AllOf(HasSubstr("ulf capture"), Not(HasSubstr("repair"))));
  std::ofstream(scratch_ / "empty/transforms.json") << R"({"fl_x": 60, "frames": []})";
  EXPECT_THAT(refusal(scratch_ / "empty"), AllOf(HasSubstr("ulf import"), Not(HasSubstr("repair"))));

  const fs::path spaced = scratch_ / "my $vase";
  WriteSample(spaced, 2);
  EXPECT_THAT([&] { ReadLightField(spaced / "journal.jsonl"); },
              ThrowsMessage<Error>(HasSubstr("give the folder")));
  const std::string repair = "'ulf repair \"" + (scratch_ / "my \\$vase").string() + "\"'";
  const std::string journal = ReadWholeFile(spaced / "journal.jsonl");
  for (const auto& [damage, change] : {std::pair("nothing", std::string()),
                                       {"noise", std::string("%$&/")},
                                       {"no version", "{\"event\":\"header\"}\n" + journal}}) {
    std::ofstream(spaced / "journal.jsonl", std::ios::trunc) << change;
    EXPECT_THAT([&] { ReadLightField(spaced); }, ThrowsMessage<Error>(HasSubstr(repair))) << damage;
  }
  fs::remove(spaced / "journal.jsonl");
  EXPECT_THAT(refusal(spaced), HasSubstr(repair));
}

TEST_F(Folder, ADamagedHeaderIsMadeFromTransformsJson) {
  const LightField whole = Sample(4);
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[3] = '\0'; });
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf repair")));
  Repair(dir());
  ExpectSame(whole, ReadSaying({}));
}

TEST_F(Folder, ForeignSetIsNotConverted) {
  Sample(3);
  fs::remove(dir() / "journal.jsonl");
  json document = JsonFromText(ReadWholeFile(dir() / "transforms.json"));
  document.erase("ulf");
  std::ofstream(dir() / "transforms.json") << JsonText(document);
  fs::remove_all(dir() / "sparse");
  const auto before = Content(dir());
  EXPECT_THAT([&] { Repair(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf import")));
  EXPECT_EQ(Content(dir()), before);
}

// Its numbers are not ours, and its world is another.
TEST_F(Folder, ForeignTransformsJsonIsNotUsed) {
  const LightField whole = Sample(3);
  json document = JsonFromText(ReadWholeFile(dir() / "transforms.json"));
  document.erase("ulf");
  int number = 0;
  for (json& frame : document["frames"]) {
    frame.erase("ulf");
    frame["file_path"] = fmt::format("images/frame_{:05}.png", ++number);
    frame["transform_matrix"][0][3] = 77.0;
  }
  document["frames"].push_back(document["frames"][0]);
  document["frames"].push_back(document["frames"][1]);
  std::ofstream(dir() / "transforms.json", std::ios::trunc) << JsonText(document);
  const std::string theirs = ReadWholeFile(dir() / "transforms.json");
  ExpectSame(whole, ReadSaying({"transforms.json"}));
  Repair(dir());
  ExpectSame(whole, ReadSaying({}));
  EXPECT_EQ(ReadWholeFile(dir() / "kept/transforms.json"), theirs);
}

TEST_F(Folder, RepairRestoresACorrectionOfADamagedLine) {
  Sample(4);
  const Rigid3 moved = LookAt({9, 9, 9}, {0, 0, 0}, {0, -1, 0});
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    writer.UpdatePoses({{2, moved}});
    writer.Close(3);
  }
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[bytes.find("pose_update") - 3] = '\x01'; });
  ReadSaying({"corrections of poses may be lost (1 pose differ"});
  EXPECT_THROW(LightFieldWriter::Resume(dir()), Error);
  Repair(dir());
  EXPECT_LT((ReadSaying({}).views[1].cam_from_world.Matrix() - moved.Matrix()).norm(), 1e-9);
}

TEST_F(Folder, AModelByAnotherProgramIsKept) {
  const LightField whole = Sample(3);
  Rewrite(dir() / "sparse/0/images.txt",
          [](std::string& bytes) { bytes = "# by another program\n1 1 0 0 0 5 5 5 1 000001.png\n\n"; });
  const std::string theirs = ReadWholeFile(dir() / "sparse/0/images.txt");
  ExpectSame(whole, ReadSaying({"images.txt is by another program"}));
  LightFieldWriter::Resume(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "kept/sparse/images.txt"), theirs);
}

// ---- journal and sparse/0 ----

TEST_F(Folder, ViewsThatOnlyTheModelHasComeBack) {
  const LightField whole = Sample(6);
  fs::remove(dir() / "transforms.json");
  CutJournal(dir(), 0.5);
  const LightField cut = ReadSaying({"sparse/0/images.txt holds", "that the journal has lost"});
  ASSERT_LT(cut.views.size(), 6u);
  EXPECT_THROW(LightFieldWriter::Resume(dir()), Error);
  Repair(dir());
  const LightField repaired = ReadSaying({});
  ASSERT_EQ(repaired.views.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(repaired.views[i].image_path, whole.views[i].image_path);
    EXPECT_LT((repaired.views[i].cam_from_world.Matrix() - whole.views[i].cam_from_world.Matrix()).norm(),
              1e-9);
  }
}

TEST_F(Folder, AChangedModelDoesNotCountAndIsKept) {
  const LightField whole = Sample(3);
  Rewrite(dir() / "sparse/0/images.txt",
          [](std::string& bytes) { bytes += "9 1 0 0 0 5 5 5 1 stranger.png\n\n"; });
  ExpectSame(whole, ReadSaying({"images.txt differs from the journal (view 9)"}));
  LightFieldWriter::Resume(dir());
  EXPECT_THAT(ReadWholeFile(dir() / "kept/sparse/images.txt"), HasSubstr("stranger.png"));
}

TEST_F(Folder, ABinaryModelBesideOursIsSaid) {
  Sample(3);
  std::ofstream(dir() / "sparse/0/images.bin") << "whatever";
  ReadSaying({"COLMAP reads the binary model"});
}

// ---- journal, images/ and masters/ ----

TEST_F(Folder, ANumberThatAFileBearsIsNeverGivenAgain) {
  for (const char* bearer : {"images/000042.png", "masters/000042.tif", "unposed/000042.png",
                             "unposed/000042.master.tif", "masks/000042.png"}) {
    fs::remove_all(dir());
    Sample(3);
    fs::create_directories((dir() / bearer).parent_path());
    std::ofstream(dir() / bearer) << "somebody's only copy";
    ReadLightField(dir());
    {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      EXPECT_EQ(writer.AddView(NoiseFrame(8), ViewNumber(3)).id, 43) << bearer;
      writer.Close(1);
    }
    EXPECT_EQ(ReadWholeFile(dir() / bearer), "somebody's only copy");
    EXPECT_FALSE(PlanRepair(dir()).new_journal) << bearer;
  }
}

TEST_F(Folder, UnnamedPhotographsAreReportedAndStay) {
  Sample(3);
  std::ofstream(dir() / "images/000004.png") << "x";
  ReadSaying({"the journal does not name 1 file (images/000004.png)"});
}

// Whatever appears while a capture runs.
TEST_F(Folder, AFileThatIsThereIsNotWrittenOver) {
  LightFieldWriter writer = LightFieldWriter::Create(dir(), Header());
  std::ofstream(dir() / "images/000001.png") << "somebody's only copy";
  EXPECT_THAT([&] { writer.AddView(NoiseFrame(1), ViewNumber(0)); },
              ThrowsMessage<Error>(AllOf(HasSubstr("000001.png"), HasSubstr("is there already"))));
  EXPECT_EQ(ReadWholeFile(dir() / "images/000001.png"), "somebody's only copy");
  EXPECT_THAT(writer.Contents().views, IsEmpty());
}

TEST_F(Folder, MissingPhotographIsNamedAndTakenOut) {
  Sample(4);
  fs::remove(dir() / "images/000002.png");
  EXPECT_THAT([&] { ReadLightField(dir()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("000002.png"), HasSubstr("ulf repair"))));
  Repair(dir());
  EXPECT_THAT(Ids(ReadSaying({})), ElementsAre(1, 3, 4));
  EXPECT_THAT(ReadWholeFile(dir() / "kept/journal-1.jsonl"), HasSubstr("000002.png"));
}

TEST_F(Folder, AMissingMasterIsSaidAndItsPhotographUsed) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 3);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  fs::remove(dir() / "masters/000002.tif");
  const LightField read = ReadSaying({"the masters of view 2 are missing"});
  EXPECT_EQ(ReadViewLight(read, read.views[1]).pixels.depth(), CV_8U);
}

TEST_F(Folder, PhotographsReplacedByMastersAreReported) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 3);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  fs::remove(dir() / "images/000002.png");
  ReadSaying({"images/ has no photographs of view 2", "ulf repair"});
  fs::remove(dir() / "masters/000002.tif");
  EXPECT_THAT(PlanRepair(dir()).found, testing::Each(Not(HasSubstr("their photographs of 8 bits"))));
}

// ---- images/ and masters/ ----

TEST_F(Folder, PhotographsOfOtherMastersAreMadeAnew) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 4);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  EXPECT_NO_THROW(LightFieldWriter::Resume(dir())) << "they are their masters'";
  const std::string right = ReadWholeFile(dir() / "images/000002.png");
  const std::string other = ReadWholeFile(dir() / "images/000003.png");
  std::ofstream(dir() / "images/000002.png", std::ios::binary) << other;
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("view 2"), HasSubstr("ulf repair"))));
  Repair(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "images/000002.png"), right);
  EXPECT_EQ(ReadWholeFile(dir() / "unposed/000002.png"), other) << "nothing is deleted";
  EXPECT_NO_THROW(LightFieldWriter::Resume(dir()));
}

TEST_F(Folder, APhotographOfAnotherSizeStopsAWriter) {
  Sample(3);
  cv::imwrite((dir() / "images/000002.png").string(), cv::Mat(30, 40, CV_8UC3, cv::Scalar::all(7)));
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); }, ThrowsMessage<Error>(HasSubstr("view 2")));
  const std::string only_copy = ReadWholeFile(dir() / "images/000002.png");
  EXPECT_THAT(Repair(dir()).found, Contains(HasSubstr("differ in size from their camera")));
  EXPECT_EQ(ReadWholeFile(dir() / "images/000002.png"), only_copy) << "nothing could take its place";
}

TEST_F(Folder, DamagedPhotographIsRemadeOrTakenOut) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 3);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  const std::string right = ReadWholeFile(dir() / "images/000002.png");
  fs::resize_file(dir() / "images/000002.png", right.size() / 2);
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); }, ThrowsMessage<Error>(HasSubstr("ulf repair")));
  Repair(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "images/000002.png"), right);
  EXPECT_EQ(fs::file_size(dir() / "unposed/000002.png"), right.size() / 2);

  // Without a master it cannot come back, and a damaged master goes with it.
  fs::remove_all(dir());
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 3);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  for (const char* file : {"images/000002.png", "masters/000002.tif"}) fs::resize_file(dir() / file, 900);
  Repair(dir());
  EXPECT_THAT(Ids(ReadSaying({})), ElementsAre(1, 3));
  for (const char* file : {"images/000002.png", "masters/000002.tif"}) EXPECT_FALSE(fs::exists(dir() / file));
  for (const char* file : {"unposed/000002.png", "unposed/000002.master.tif"})
    EXPECT_EQ(fs::file_size(dir() / file), 900u) << file;

  fs::remove_all(dir());
  Sample(4);
  fs::resize_file(dir() / "images/000003.png", 300);
  EXPECT_THAT(Repair(dir()).found, Contains(HasSubstr("the photographs of view 3 cannot be read")));
  EXPECT_THAT(Ids(ReadSaying({})), ElementsAre(1, 2, 4));
  EXPECT_EQ(fs::file_size(dir() / "unposed/000003.png"), 300u) << "nothing is deleted";
}

TEST_F(Folder, DamagedMasterLeavesItsPhotograph) {
  {
    LightFieldWriter writer = WriterAheadOfItsPhotographs(dir(), 3);
    MakeMissingPictures(writer.Contents());
    writer.Close(1);
  }
  fs::resize_file(dir() / "masters/000002.tif", 900);
  const LightField read = ReadSaying({});
  EXPECT_EQ(ReadViewLight(read, read.views[0]).pixels.depth(), CV_16U);
  EXPECT_EQ(ReadViewLight(read, read.views[1]).pixels.depth(), CV_8U);
  EXPECT_THAT(PlanRepair(dir()).found,
              Contains(AllOf(HasSubstr("the masters of view 2 cannot be read (masters/000002.tif is"),
                             HasSubstr("copy the masters again"))));
  const auto said = test::RunUlf("repair " + dir().string());
  EXPECT_THAT(said.output, HasSubstr("masters/000002.tif"));
  EXPECT_EQ(said.errors, "") << "words of a library";
  EXPECT_NO_THROW(LightFieldWriter::Resume(dir()));
}

// What was planned and failed is not called done.
TEST_F(Folder, RepairSaysWhatItCouldNotDo) {
  { WriterAheadOfItsPhotographs(dir(), 3).Close(1); }
  fs::remove_all(dir() / "images");
  EXPECT_EQ(test::RunUlf("repair " + dir().string() + " --write").exit_code, 0) << "the folder is made, too";
  EXPECT_TRUE(fs::is_regular_file(dir() / "images/000002.png"));
  fs::remove(dir() / "images/000002.png");
  fs::resize_file(dir() / "masters/000002.tif", 900);
  const auto run = test::RunUlf("repair " + dir().string() + " --write");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, AllOf(HasSubstr("not done: make 1 missing photograph"),
                                Not(HasSubstr("did this: make the photographs"))));
}

// An images/ that is not where it was is no reason to give up its views.
TEST_F(Folder, RepairKeepsViewsOfPhotographsElsewhere) {
  Sample(4);
  fs::rename(dir() / "images", dir() / "elsewhere");
  const std::string journal = ReadWholeFile(dir() / "journal.jsonl");
  EXPECT_THAT(Repair(dir()).found, Contains(HasSubstr("put images/ and masters/ back")));
  EXPECT_EQ(ReadWholeFile(dir() / "journal.jsonl"), journal);
  fs::rename(dir() / "elsewhere", dir() / "images");
  EXPECT_EQ(ReadLightField(dir()).views.size(), 4u);
}

// ---- journal and unposed/ ----

TEST_F(Folder, TakingOutOverwritesNothingInUnposed) {
  Sample(3);
  fs::create_directories(dir() / "unposed");
  std::ofstream(dir() / "unposed/000002.png") << "an older one";
  LightFieldWriter::Resume(dir()).RemoveViews({2});
  EXPECT_EQ(ReadWholeFile(dir() / "unposed/000002.png"), "an older one");
  EXPECT_TRUE(fs::exists(dir() / "unposed/000002-2.png"));
  EXPECT_THAT(ReadSaying({}).doubts, IsEmpty());
}

// Numbers of views and names of files are two things where a set was imported.
TEST_F(Folder, TakingOutLeavesOtherViewsPhotographs) {
  {
    LightField light_field = Sample(3);
    const fs::path imported = scratch_ / "imported";
    light_field.root = imported;
    fs::create_directories(imported / "images");
    for (View& view : light_field.views) {
      const std::string name = fmt::format("images/{:06}.png", view.id - 1);
      fs::copy(dir() / view.image_path, imported / name);
      view.image_path = name;
    }
    WriteLightField(light_field);
    fs::remove_all(dir());
    fs::rename(imported, dir());
  }
  LightFieldWriter::Resume(dir()).RemoveViews({1});
  LightFieldWriter::Resume(dir()).Close(1);
  EXPECT_TRUE(fs::exists(dir() / "unposed/000000.png"));
  EXPECT_TRUE(fs::exists(dir() / "images/000001.png")) << "view 2's";
  EXPECT_THAT(Ids(ReadSaying({})), ElementsAre(2, 3));
}

// ---- points ----

TEST_F(Folder, DamagedPointsCostThePointsOnly) {
  Sample(3);
  fs::remove(dir() / "points.ulf");
  fs::resize_file(dir() / "points.ply", fs::file_size(dir() / "points.ply") - 3);
  EXPECT_THAT(ReadSaying({"points.ply", "truncated", "without points"}).points, IsEmpty());
}

TEST_F(Folder, RepairMakesThePointsFilesThatItCan) {
  Sample(3);
  const std::string ply = ReadWholeFile(dir() / "points.ply");
  fs::remove(dir() / "points.ply");
  Repair(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "points.ply"), ply);
  fs::resize_file(dir() / "points.ulf", 20);
  ReadSaying({"points.ply is read instead"});
  EXPECT_TRUE(PlanRepair(dir()).any());
  Repair(dir());
  EXPECT_THAT(ReadSaying({}).points.size(), 2u);
  EXPECT_EQ(fs::file_size(dir() / "kept/points.ulf"), 20u);
  EXPECT_FALSE(PlanRepair(dir()).any());
}

TEST_F(Folder, PointsOfAnotherProgramAreKept) {
  Sample(3);
  const std::string dense =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n7 8 9\n";
  std::ofstream(dir() / "points.ply", std::ios::trunc) << dense;
  ReadSaying({"holds other points than points.ulf"});
  LightFieldWriter::Resume(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "kept/points.ply"), dense);
}

// Also an export's file of points.
TEST_F(Folder, PointsOfAnotherLightFieldAreKept) {
  const fs::path other = scratch_ / "other";
  {
    CaptureHeader header = Header();
    header.device_serial = "S2";
    LightFieldWriter writer = LightFieldWriter::Create(other, header);
    writer.AddView(NoiseFrame(1), ViewNumber(1));
    writer.SetPoints({{{7, 8, 9}, {1, 2, 3}}});
    writer.Close(1);
  }
  const auto exported = test::RunUlf("export nerfstudio " + other.string() + " --known-points -o " +
                                     (scratch_ / "set").string());
  EXPECT_EQ(exported.exit_code, 0) << exported.errors;
  for (const fs::path& points : {other / "points.ply", scratch_ / "set/points.ply"}) {
    if (!fs::exists(points)) continue;
    fs::remove_all(dir());
    Sample(3);
    fs::copy_file(points, dir() / "points.ply", fs::copy_options::overwrite_existing);
    ReadSaying({"holds other points than points.ulf"});
    const auto info = test::RunUlf("info " + dir().string());
    EXPECT_THAT(info.errors, HasSubstr("holds other points than points.ulf"));
    EXPECT_THAT(PlanRepair(dir()).found, Contains(HasSubstr("holds other points than points.ulf")));
    LightFieldWriter::Resume(dir());
    EXPECT_EQ(ReadWholeFile(dir() / "kept/points.ply"), ReadWholeFile(points));
    EXPECT_THAT(ReadLightField(dir()).doubts, IsEmpty());
  }
}

// ---- the journal alone ----

// Whatever one byte of a line becomes: the other views are read, and the line is named or means the same.
TEST_F(Folder, DamagedLineCostsOnlyItself) {
  Sample(5);
  const std::string journal = ReadWholeFile(dir() / "journal.jsonl");
  const std::size_t begin = LineBegin(journal, 6), end = journal.find('\n', begin);
  ASSERT_THAT(journal.substr(begin, end - begin), HasSubstr("\"id\":3"));
  std::size_t named = 0;
  for (std::size_t at = begin; at < end; at += 3) {
    std::string damaged = journal;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    std::ofstream(dir() / "journal.jsonl", std::ios::trunc | std::ios::binary) << damaged;
    JournalContents read;
    ASSERT_NO_THROW(read = ReadJournal(dir() / "journal.jsonl")) << at - begin;
    std::vector<int> ids = Ids(read.light_field);
    std::erase(ids, 3);
    EXPECT_THAT(ids, testing::IsSupersetOf({1, 2, 4, 5})) << at - begin;
    if (read.damaged.empty()) continue;
    ++named;
    EXPECT_THAT(read.damaged.front().Words(), AllOf(HasSubstr("line 6"), HasSubstr("view 3 is in doubt")));
  }
  EXPECT_GT(named, (end - begin) / 6);
}

TEST_F(Folder, RepairPutsBackACameraThatTheJournalLost) {
  for (const bool from_model : {false, true}) {
    fs::remove_all(dir());
    Sample(2);
    CameraModel second = Header().camera;
    second.fx *= 1.03;
    {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      writer.AddCamera({second, {}, {}, "file better.json"});
      writer.AddView(NoiseFrame(2), ViewNumber(2));
      writer.Close(1);
    }
    Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
      const std::size_t line = bytes.find("\"event\":\"camera\"");
      ASSERT_NE(line, std::string::npos);
      bytes[line + 2] = '\x01';
    });
    if (from_model) fs::remove(dir() / "transforms.json");
    EXPECT_EQ(Ids(ReadSaying({"holds 1 view that the journal has lost (view 3)"})), (std::vector<int>{1, 2}));
    Repair(dir());
    const LightField repaired = ReadSaying({});
    EXPECT_THAT(repaired.doubts, IsEmpty()) << from_model;
    ASSERT_EQ(Ids(repaired), (std::vector<int>{1, 2, 3})) << from_model;
    EXPECT_EQ(repaired.CameraOf(repaired.views[0]), Header().camera);
    EXPECT_NEAR(repaired.CameraOf(repaired.views[2]).fx, second.fx, 1e-9) << from_model;
  }
}

// A region of the disk that reads as line ends: every line of it is damaged, and one message says so.
TEST_F(Folder, AdjacentDamagedLinesAreOneFinding) {
  Sample(5);
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
    const std::size_t begin = LineBegin(bytes, 6), end = bytes.find('\n', begin);
    ASSERT_THAT(bytes.substr(begin, end - begin), HasSubstr("\"id\":3"));
    bytes.replace(begin, end - begin, std::string(100'000, '\n'));
  });
  const JournalContents read = ReadJournal(dir() / "journal.jsonl");
  EXPECT_THAT(Ids(read.light_field), testing::ElementsAre(1, 2, 4, 5));
  ASSERT_EQ(read.damaged.size(), 1u);
  EXPECT_EQ(read.damaged.front().lines, 100'001);
  EXPECT_EQ(read.damaged.front().Words(),
            "lines 6 to 100006: damaged; these lines are left out; view 3 is in doubt");
}

TEST_F(Folder, ARefusedLineIsAnEntryOfItsOwn) {
  Sample(3);
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
    bytes.insert(LineBegin(bytes, 5), "?\n{\"event\":\"later\"}\n{\"event\":\"later\"}\n?\n?\n");
  });
  const JournalContents read = ReadJournal(dir() / "journal.jsonl");
  EXPECT_EQ(read.staying_lines, 2u);
  std::vector<std::pair<bool, int>> entries;
  for (const DamagedLine& entry : read.damaged) entries.emplace_back(entry.is_json, entry.lines);
  EXPECT_THAT(entries, testing::ElementsAre(testing::Pair(false, 1), testing::Pair(true, 1),
                                            testing::Pair(true, 1), testing::Pair(false, 2)));
}

// Damaged everywhere, whole lines between: what is whole is read, and the last entry stands for many places.
TEST_F(Folder, ManyDamagedPlacesEndInOneSummary) {
  Sample(5);
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
    const std::size_t begin = LineBegin(bytes, 6), end = bytes.find('\n', begin) + 1;
    std::string gaps;
    for (int i = 0; i < 20'000; ++i)
      gaps += "?\n{\"event\":\"gap\",\"from_s\":1.0,\"to_s\":2.0,\"reason\":\"a cable\"}\n";
    bytes.replace(begin, end - begin, gaps);
  });
  const JournalContents read = ReadJournal(dir() / "journal.jsonl");
  EXPECT_THAT(Ids(read.light_field), testing::ElementsAre(1, 2, 4, 5));
  ASSERT_EQ(read.damaged.size(), 100u);
  int lines = 0;
  for (const DamagedLine& entry : read.damaged) lines += entry.lines;
  EXPECT_EQ(lines, 20'000);
  EXPECT_EQ(read.damaged.back().Words(),
            "lines 204 to 40004: 19901 of them damaged; these lines are left out; view 3 is in doubt; it may "
            "have corrected "
            "poses: views 1, 2, 4 and 5 are in doubt");
}

TEST_F(Folder, DamagedCorrectionPutsItsPosesInDoubt) {
  Sample(4);
  const Rigid3 moved = LookAt({9, 9, 9}, {0, 0, 0}, {0, -1, 0});
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    writer.UpdatePoses({{1, moved}, {2, moved}, {3, moved}});
    writer.UpdatePoses({{2, moved}});
    writer.Close(3);
  }
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[bytes.find("pose_update") - 3] = '\x01'; });
  ReadSaying({"it may have corrected poses: views 1, 3 and 4 are in doubt"});
}

TEST_F(Folder, TwoLinesOfOneViewAreSaid) {
  const LightField whole = Sample(3);
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
    const std::size_t begin = LineBegin(bytes, 5);
    bytes += bytes.substr(begin, bytes.find('\n', begin) + 1 - begin);
  });
  ExpectSame(whole, ReadSaying({"view 2 is recorded twice"}));
}

// The writer that goes on keeps the damaged line where it is.
TEST_F(Folder, ADamagedLineIsNotCutOff) {
  Sample(4);
  fs::remove(dir() / "transforms.json");
  fs::remove_all(dir() / "sparse");
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) { bytes[bytes.find("\"id\":3") + 3] = '\x01'; });
  const std::string damaged = ReadWholeFile(dir() / "journal.jsonl");
  EXPECT_EQ(LightFieldWriter::Resume(dir()).AddView(NoiseFrame(7), ViewNumber(2)).id, 5);
  EXPECT_TRUE(ReadWholeFile(dir() / "journal.jsonl").starts_with(damaged));
  EXPECT_THAT(Ids(ReadSaying({"view 3 is in doubt"})), ElementsAre(1, 2, 4, 5));
}

// A power cut may leave the journal's length, and nothing in its last blocks.
TEST_F(Folder, AnEndOfZerosIsALostEnd) {
  for (const char* end : {"zeros", "more zeros", "noise"}) {
    fs::remove_all(dir());
    const LightField whole = Sample(6);
    std::map<int, Rigid3> moved;
    {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      for (const View& view : writer.Contents().views) {
        moved[view.id] = view.cam_from_world;
        moved[view.id].translation.x() += 0.01;
      }
      writer.UpdatePoses(moved);
      writer.Close(20);
    }
    const auto size = fs::file_size(dir() / "journal.jsonl");
    fs::resize_file(dir() / "journal.jsonl", size - 400);
    if (end == std::string("noise"))
      std::ofstream(dir() / "journal.jsonl", std::ios::app) << std::string(900, '#') << "\n"
                                                            << std::string(99, '%');
    else
      fs::resize_file(dir() / "journal.jsonl",
                      end == std::string("zeros") ? size : (size + 4096) / 4096 * 4096);
    const auto before = Content(dir());
    ReadSaying({"corrections of poses may be lost (6 poses differ)", "ulf repair"});
    EXPECT_THROW(LightFieldWriter::Resume(dir()), Error);
    EXPECT_EQ(Content(dir()), before);
    Repair(dir());
    const LightField repaired = ReadSaying({});
    ASSERT_EQ(repaired.views.size(), 6u);
    for (const View& view : repaired.views)
      EXPECT_LT((view.cam_from_world.translation - moved.at(view.id).translation).norm(), 1e-12) << end;
    EXPECT_EQ(repaired.capture_s, 20);
    EXPECT_EQ(ReadWholeFile(dir() / "kept/journal-1.jsonl"), before.at("journal.jsonl"));
  }
}

TEST_F(Folder, ALostGoalComesBackAndIsNamed) {
  Sample(3);
  Rewrite(dir() / "journal.jsonl",
          [](std::string& bytes) { bytes.resize(bytes.rfind('\n', bytes.find("\"event\":\"close\"")) + 1); });
  ReadSaying({"its last lines are lost", "all poses are there"});
  EXPECT_THAT(Repair(dir()).steps,
              Contains(HasSubstr(
                  "put back the subject, up, goal and counts of the session that transforms.json holds")));
  EXPECT_EQ(ReadSaying({}).capture_s, 12.5);
}

// A model whose end is missing has corrections of some views only.
TEST_F(Folder, AModelThatIsCutIsSaidAndMadeAnew) {
  Sample(5);
  const std::string whole = ReadWholeFile(dir() / "sparse/0/images.txt");
  fs::resize_file(dir() / "sparse/0/images.txt", whole.size() - 3);
  ReadSaying({"sparse/0/images.txt is cut short", "ulf repair"});
  Repair(dir());
  EXPECT_EQ(ReadWholeFile(dir() / "sparse/0/images.txt"), whole);
  for (const char* file : {"sparse/0/points3D.txt", "sparse/0/cameras.txt"}) {
    const std::string right = ReadWholeFile(dir() / file);
    fs::resize_file(dir() / file, right.size() - 5);
    EXPECT_THAT(Repair(dir()).found, Contains(HasSubstr("differs from what ulf made from the journal")));
    EXPECT_EQ(ReadWholeFile(dir() / file), right);
  }
  EXPECT_FALSE(PlanRepair(dir()).any());

  // Of a lost end the whole file tells the poses, the cut one none.
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    std::map<int, Rigid3> moved;
    for (const View& view : writer.Contents().views) {
      moved[view.id] = view.cam_from_world;
      moved[view.id].translation.x() += 0.01;
    }
    writer.UpdatePoses(moved);
    writer.Close(20);
  }
  fs::resize_file(dir() / "sparse/0/images.txt", fs::file_size(dir() / "sparse/0/images.txt") - 3);
  fs::resize_file(dir() / "journal.jsonl", fs::file_size(dir() / "journal.jsonl") - 400);
  fs::remove(dir() / "transforms.json");
  EXPECT_TRUE(PlanRepair(dir()).poses.empty());
}

// A repair that is killed after the journals were exchanged leaves derived files that were made from a longer
// journal: they must not count as newer than corrections that came after them.
TEST_F(Folder, ARepairThatWasKilledTakesNoOlderPoses) {
  Sample(3);
  Rigid3 moved;
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    moved = writer.Contents().views[1].cam_from_world;
    moved.translation.x() += 0.01;
    writer.UpdatePoses({{2, moved}});
  }
  Rewrite(dir() / "journal.jsonl", [](std::string& bytes) {
    const std::size_t close = bytes.find("\"event\":\"close\"");
    bytes.insert(close, std::string(500, '\x01'));
  });
  const auto derived = Content(dir());
  ASSERT_FALSE(PlanRepair(dir()).poses.contains(2));
  Repair(dir());
  for (const auto& [path, bytes] : derived)
    if (path == "transforms.json" || path.starts_with("sparse/"))
      std::ofstream(dir() / path, std::ios::trunc | std::ios::binary) << bytes;
  EXPECT_TRUE(PlanRepair(dir()).poses.empty());
  Repair(dir());
  EXPECT_EQ(ReadLightField(dir()).views[1].cam_from_world.translation, moved.translation);
}

// A disk that is full while the journal is repaired leaves the old one.
TEST_F(Folder, FailedRepairLeavesTheFolderAsItWas) {
  Sample(9);
  CutJournal(dir(), 1.0 / 3);
  std::ofstream(dir() / "kept") << "a file where a folder should be";
  auto before = Content(dir());
  EXPECT_THROW(Repair(dir()), Error);
  EXPECT_EQ(Content(dir()), before);
}

}  // namespace
}  // namespace ulf::folder_check_test

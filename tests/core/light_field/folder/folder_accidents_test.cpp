// Tests: core/light_field/folder/followed_links, core/light_field/folder/leftovers,
// core/light_field/folder/opened_folder, core/light_field/folder/journal_writer, core/base/atomic_file.
//
// Ordinary accidents of a light field's folder: photographs moved to another disk, a copy by hard links,
// a pipe in the place of a file, lines that this version does not read, a kill between two files that
// belong together.
#include "core/light_field/folder/followed_links.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/leftovers.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::folder_accidents_test {
namespace {

using test::PrintFaultRow;
using test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

std::size_t LinesOf(const fs::path& file) {
  const std::string bytes = ReadWholeFile(file);
  return static_cast<std::size_t>(std::ranges::count(bytes, '\n'));
}

class FolderAccident : public testing::Test {
 protected:
  ~FolderAccident() override { FollowOutsideLinks(false); }
  fs::path dir() const { return scratch_ / "lf"; }
  fs::path journal() const { return dir() / kJournalFile; }

  // As people do when a disk is full.
  void MoveImagesTo(const fs::path& elsewhere) {
    fs::create_directories(elsewhere.parent_path());
    fs::copy(dir() / "images", elsewhere, fs::copy_options::recursive);
    fs::remove_all(dir() / "images");
    fs::create_directory_symlink(elsewhere, dir() / "images");
  }

  ScratchFolder scratch_;
};

// ---- links ----

TEST_F(FolderAccident, LinkedPhotographsLoseNoLine) {
  WriteSample(dir(), 30);
  const std::string before = ReadWholeFile(journal());
  MoveImagesTo(scratch_ / "large disk/images");
  const auto says_how =
      ThrowsMessage<Error>(AllOf(HasSubstr("'images' leads to"), HasSubstr("follow_links once")));
  int tried = 0, changed = 0;
  const auto after = [&](const char* what) {
    ++tried;
    changed += ReadWholeFile(journal()) != before;
    EXPECT_EQ(ReadWholeFile(journal()), before) << what;
  };
  EXPECT_THAT([&] { ReadLightField(dir()); }, says_how);
  after("read");
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); }, says_how);
  after("resumed");
  EXPECT_THAT(PlanRepair(dir()).found, testing::Contains(HasSubstr("follow_links once")));
  EXPECT_FALSE(PlanRepair(dir()).any());
  EXPECT_EQ(Repair(dir()).views_after, 30u);
  after("repaired");
  EXPECT_FALSE(fs::exists(dir() / kLinksFile)) << "nobody has said yes";
  test::PrintFaultRow("`images/` moved elsewhere, a link in its place: read, resumed, repaired", tried,
                      fmt::format("{} times the journal was changed; refused until follow_links", changed),
                      std::nullopt);
}

TEST_F(FolderAccident, FollowedLinksAreKeptForThisFolder) {
  const LightField whole = WriteSample(dir(), 4);
  MoveImagesTo(scratch_ / "large disk/images");
  FollowOutsideLinks();
  ExpectSame(whole, ReadLightField(dir()));
  FollowOutsideLinks(false);
  ExpectSame(whole, ReadLightField(dir()));
  LightFieldWriter::Resume(dir()).AddView(NoiseFrame(9), ViewNumber(4));
  EXPECT_TRUE(fs::exists(scratch_ / "large disk/images/000005.png"));
  EXPECT_EQ(ReadLightField(dir()).views.size(), 5u);
  EXPECT_FALSE(PlanRepair(dir()).any() && PlanRepair(dir()).views_after < 5);
  // What was said of this folder counts for no copy of it, whoever made the copy.
  fs::copy(dir(), scratch_ / "copy", fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  EXPECT_THAT([&] { ReadLightField(scratch_ / "copy"); }, ThrowsMessage<Error>(HasSubstr("follow_links")));
  // Another place behind the same name asks again.
  fs::remove(dir() / "images");
  fs::create_directories(scratch_ / "other");
  fs::create_directory_symlink(scratch_ / "other", dir() / "images");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("follow_links")));
}

TEST_F(FolderAccident, AnotherUsersFolderIsNotFollowed) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives files away";
  WriteSample(dir(), 3);
  MoveImagesTo(scratch_ / "theirs");
  ASSERT_EQ(chown((scratch_ / "theirs").c_str(), 4321, 4321), 0);
  FollowOutsideLinks();
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("belongs to another user")));
  fs::remove(dir() / "images");
  fs::create_directory_symlink(scratch_ / "unplugged", dir() / "images");
  EXPECT_THAT([&] { ReadLightField(dir()); },
              ThrowsMessage<Error>(HasSubstr("unplugged, outside of the light field, which is not there")));
  fs::remove(dir() / "images");
  fs::create_directory_symlink("images", dir() / "images");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(Not(HasSubstr("follow_links"))));
}

TEST_F(FolderAccident, EveryEntryThatLeadsOutIsRefused) {
  WriteSample(dir(), 3);
  for (const char* name : {"points.ulf", "points.ply", "transforms.json", "journal.jsonl"}) {
    fs::rename(dir() / name, scratch_ / name);
    fs::create_symlink(scratch_ / name, dir() / name);
    EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr(name)));
    EXPECT_THROW(LightFieldWriter::Resume(dir()), Error) << name;
    fs::remove(dir() / name);
    fs::rename(scratch_ / name, dir() / name);
  }
  fs::rename(dir() / "images/000002.png", scratch_ / "000002.png");
  fs::create_symlink(scratch_ / "000002.png", dir() / "images/000002.png");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("images/000002.png")));
  fs::remove(dir() / "images/000002.png");
  fs::rename(scratch_ / "000002.png", dir() / "images/2.png");
  fs::create_symlink("2.png", dir() / "images/000002.png");
  EXPECT_EQ(ReadLightField(dir()).views.size(), 3u) << "a link inside the folder";
}

// A capture that ended before its first view, then a link in the place of its empty folder.
TEST_F(FolderAccident, NoCaptureBeginsBehindALink) {
  { LightFieldWriter::Create(dir(), Header()); }
  fs::remove_all(dir() / "images");
  MakeFolder(scratch_ / "elsewhere");
  fs::create_directory_symlink(scratch_ / "elsewhere", dir() / "images");
  EXPECT_THAT([&] { LightFieldWriter::Create(dir(), Header()); },
              ThrowsMessage<Error>(HasSubstr("'images' leads to")));
  EXPECT_TRUE(fs::is_empty(scratch_ / "elsewhere"));
}

TEST_F(FolderAccident, ALinkAmongTheUnposedIsRefused) {
  WriteSample(dir(), 3);
  MakeFolder(dir() / "unposed");
  std::ofstream(scratch_ / "private.png") << "of somebody";
  fs::create_symlink(scratch_ / "private.png", dir() / "unposed/000009.png");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("unposed/000009.png")));
}

TEST_F(FolderAccident, TakenBackAcrossDisksIsKept) {
  WriteSample(dir(), 3);
  fs::create_directory(scratch_ / "disk");
  if (const auto why_not = test::MountSmallDisk(scratch_ / "disk", 4 << 20)) GTEST_SKIP() << *why_not;
  MoveImagesTo(scratch_ / "disk/images");
  FollowOutsideLinks();
  const std::string photograph = ReadWholeFile(dir() / "images/000002.png");
  LightFieldWriter::Resume(dir()).RemoveViews({2});
  EXPECT_EQ(ReadWholeFile(dir() / "unposed/000002.png"), photograph);
  EXPECT_FALSE(fs::exists(dir() / "images/000002.png"));
}

// The second photograph cannot be moved at first: asking again for both moves it.
TEST_F(FolderAccident, TakingBackIsTriedAgainForAll) {
  WriteSample(dir(), 4);
  fs::create_directory(scratch_ / "disk");
  if (const auto why_not = test::MountSmallDisk(scratch_ / "disk", 1 << 20)) GTEST_SKIP() << *why_not;
  const std::string stuck = (dir() / "images/000003.png").string();
  ASSERT_EQ(mount(stuck.c_str(), stuck.c_str(), nullptr, MS_BIND, nullptr), 0);
  LightFieldWriter writer = LightFieldWriter::Resume(dir());
  EXPECT_THROW(writer.RemoveViews({2, 3}), Error);
  ASSERT_EQ(umount(stuck.c_str()), 0);
  writer.RemoveViews({2, 3});
  EXPECT_TRUE(fs::exists(dir() / "unposed/000002.png"));
  EXPECT_TRUE(fs::exists(dir() / "unposed/000003.png"));
  EXPECT_EQ(writer.Contents().views.size(), 2u);
}

// ---- lines ----

TEST_F(FolderAccident, AJournalOfZerosIsNoBeginning) {
  WriteSample(dir(), 30);
  fs::remove(dir() / "transforms.json");
  fs::remove_all(dir() / "sparse");
  const std::string bytes = ReadWholeFile(journal());
  const std::size_t header = bytes.find('\n') + 1;
  WriteFileAtomically(journal(), bytes.substr(0, header) + std::string(bytes.size() - header, '\0'));
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); },
              ThrowsMessage<Error>(HasSubstr("has lost its lines; nothing was written")));
}

TEST_F(FolderAccident, RepairKeepsViewsOfACameraThatIsLost) {
  WriteSample(dir(), 3);
  std::string bytes = ReadWholeFile(journal());
  const std::size_t last = bytes.rfind("\"camera\":0", bytes.find("\"id\":3"));
  ASSERT_NE(last, std::string::npos);
  bytes.replace(last, 10, "\"camera\":7");
  WriteFileAtomically(journal(), bytes);
  fs::remove(dir() / "transforms.json");
  fs::remove_all(dir() / "sparse");
  fs::remove(dir() / "images/000001.png");
  Repair(dir());
  EXPECT_THAT(ReadWholeFile(journal()), HasSubstr("\"camera\":7"));
}

TEST_F(FolderAccident, RepairKeepsWholeLinesOfCameras) {
  WriteSample(dir(), 3);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    for (const double factor : {1.02, 1.03}) {
      NewCamera camera{writer.Contents().cameras[0], {}, {}, fmt::format("lens {}", factor)};
      camera.camera.fx *= factor;
      writer.AddCamera(camera);
      writer.AddView(NoiseFrame(9), ViewNumber(4));
    }
  }
  std::string bytes = ReadWholeFile(journal());
  const std::size_t second = bytes.find("\"event\":\"camera\"");
  ASSERT_NE(second, std::string::npos);
  bytes[second] = '#';  // of camera 1
  WriteFileAtomically(journal(), bytes);
  fs::remove(dir() / "transforms.json");
  fs::remove_all(dir() / "sparse");
  Repair(dir());
  EXPECT_THAT(ReadWholeFile(journal()), HasSubstr("lens 1.03"));
}

TEST_F(FolderAccident, RepairKeepsLinesOfANewerVersion) {
  WriteSample(dir(), 3);
  std::ofstream(journal(), std::ios::app) << R"({"event":"hologram","phase":[1,2,3]})"
                                          << "\n";
  EXPECT_THAT(ReadLightField(dir()).doubts, testing::Contains(HasSubstr("use a newer ulf")));
  Repair(dir());
  EXPECT_THAT(ReadWholeFile(journal()), HasSubstr("hologram"));
  fs::remove(dir() / "images/000002.png");
  EXPECT_EQ(Repair(dir()).views_after, 2u);
  EXPECT_THAT(ReadWholeFile(journal()), HasSubstr("hologram")) << "a repair that writes the journal again";
}

TEST_F(FolderAccident, NoWriterGoesOnWithoutMostViews) {
  WriteSample(dir(), 30);
  fs::remove(dir() / "transforms.json");
  fs::remove_all(dir() / "sparse");
  std::string bytes = ReadWholeFile(journal());
  for (std::size_t at = 0; (at = bytes.find("\"images/", at)) != std::string::npos; at += 12)
    bytes.replace(at, 8, "\"../images/");
  WriteFileAtomically(journal(), bytes);
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("30 of its 30 views"), HasSubstr("nothing was written"))));
  EXPECT_EQ(ReadWholeFile(journal()), bytes);
  Repair(dir());
  EXPECT_THAT(ReadWholeFile(journal()), HasSubstr("../images/000030.png")) << "lines that are whole";
}

TEST_F(FolderAccident, WritersNeedMostPhotographs) {
  WriteSample(dir(), 5);
  for (const char* name : {"000001", "000002", "000003"})
    fs::resize_file(dir() / "images" / (std::string(name) + ".png"), 40);
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir()); },
              ThrowsMessage<Error>(HasSubstr("more than half of all")));
}

// ---- copies ----

TEST_F(FolderAccident, ACopyByHardLinksIsACopy) {
  WriteSample(dir(), 3);
  const std::string command = "cp -al '" + dir().string() + "' '" + (scratch_ / "copy").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string before = ReadWholeFile(journal());
  ASSERT_TRUE(fs::equivalent(journal(), scratch_ / "copy" / kJournalFile));
  {
    LightFieldWriter copy = LightFieldWriter::Resume(scratch_ / "copy");
    copy.AddView(NoiseFrame(7), ViewNumber(3));
    EXPECT_EQ(ReadWholeFile(journal()), before);
    LightFieldWriter original = LightFieldWriter::Resume(dir());
    original.AddView(NoiseFrame(8), ViewNumber(4));
    EXPECT_THROW(LightFieldWriter::Resume(scratch_ / "copy"), Error) << "its own lock";
  }
  EXPECT_EQ(ReadLightField(dir()).views.size(), 4u);
  EXPECT_EQ(ReadLightField(scratch_ / "copy").views.size(), 4u);
  EXPECT_NE(ReadWholeFile(dir() / "images/000004.png"), ReadWholeFile(scratch_ / "copy/images/000004.png"));
  EXPECT_THAT(ReadLightField(dir()).doubts, IsEmpty());
}

TEST_F(FolderAccident, ACopyBySymbolicLinksIsACopy) {
  WriteSample(dir(), 3);
  const std::string command = "cp -as '" + dir().string() + "' '" + (scratch_ / "copy").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string before = ReadWholeFile(journal());
  EXPECT_THROW(LightFieldWriter::Resume(scratch_ / "copy"), Error);
  FollowOutsideLinks();
  LightFieldWriter::Resume(scratch_ / "copy").AddView(NoiseFrame(7), ViewNumber(3));
  EXPECT_EQ(ReadWholeFile(journal()), before);
  EXPECT_EQ(ReadLightField(scratch_ / "copy").views.size(), 4u);
  EXPECT_EQ(ReadLightField(dir()).views.size(), 3u);
}

// ---- names that are no files ----

TEST_F(FolderAccident, APipeInAFilesPlaceIsNamed) {
  WriteSample(dir(), 3);
  const auto put_pipe = [&](const char* name) {
    fs::remove_all(dir() / name);
    ASSERT_EQ(mkfifo((dir() / name).c_str(), 0644), 0);
  };
  put_pipe("points.ulf");
  put_pipe("points.ply");
  EXPECT_THROW(ReadWholeFile(dir() / "points.ulf"), Error);
  EXPECT_EQ(ReadLightField(dir()).views.size(), 3u);
  put_pipe("transforms.json");
  EXPECT_EQ(ReadLightField(dir()).views.size(), 3u);
  put_pipe("images/000002.png");
  EXPECT_THAT([&] { ReadLightField(dir()); }, ThrowsMessage<Error>(HasSubstr("000002.png")));
  EXPECT_THAT([&] { ReadImageFile((dir() / "images/000002.png").string()); },
              ThrowsMessage<Error>(HasSubstr("is a pipe and no regular file")));
  put_pipe("journal.jsonl");
  EXPECT_THROW(ReadLightField(dir()), Error);
}

TEST_F(FolderAccident, ADeviceOrAHugeFileIsNotReadToItsEnd) {
  EXPECT_THAT([] { ReadWholeFile("/dev/zero"); },
              ThrowsMessage<Error>(HasSubstr("is a device and no regular file")));
  std::ofstream(scratch_ / "sparse file") << "x";
  fs::resize_file(scratch_ / "sparse file", std::uintmax_t{1} << 42);
  EXPECT_THAT([&] { ReadWholeFile(scratch_ / "sparse file"); },
              ThrowsMessage<Error>(HasSubstr("more than the memory that is left")));
}

// ---- what belongs together ----

TEST_F(FolderAccident, ViewsAreTakenBackTogetherOrNotAtAll) {
  WriteSample(scratch_ / "start", 8);
  const std::size_t lines = LinesOf(scratch_ / "start" / kJournalFile);
  int before = 0, after = 0;
  for (int call = 1;; ++call) {
    fs::remove_all(dir());
    fs::copy(scratch_ / "start", dir(), fs::copy_options::recursive);
    const pid_t child = fork();
    if (child == 0) {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      test::DieBeforeDiskCall(call);
      writer.RemoveViews({2, 3, 5, 7});
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    const std::size_t views = ReadLightField(dir()).views.size();
    EXPECT_TRUE(views == 8 || views == 4) << views << " views after a kill before call " << call;
    (views == 8 ? before : after) += 1;
    { LightFieldWriter::Resume(dir()); }
    EXPECT_EQ(fs::exists(dir() / "unposed/000007.png"), views == 4);
    if (WIFEXITED(status)) break;
  }
  EXPECT_GE(before, 1);
  EXPECT_GE(after, 4);
  EXPECT_EQ(LinesOf(journal()), lines + 1) << "one line for all of them";
  PrintFaultRow("SIGKILL before each call that changes the disk: four views taken back together",
                before + after, "0 times some of them without the others", std::nullopt);
}

TEST_F(FolderAccident, OlderPointsOfOurOwnSayNothing) {
  WriteSample(dir(), 3);
  const std::string older = ReadWholeFile(dir() / "points.ply");
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    writer.SetPoints({{{5, 6, 7}, {1, 2, 3}}, {{1, 1, 1}, {4, 5, 6}}, {{2, 2, 2}, {7, 8, 9}}});
    writer.Close(1);
  }
  WriteFileAtomically(dir() / "points.ply", older);  // A kill came between the two files.
  const LightField read = ReadLightField(dir());
  EXPECT_THAT(read.doubts, IsEmpty());
  EXPECT_EQ(read.points.size(), 3u);
  { LightFieldWriter::Resume(dir()); }
  EXPECT_EQ(ReadPointPly(dir() / "points.ply").size(), 3u);
  EXPECT_FALSE(fs::exists(dir() / "kept/points-2.ply")) << "the older file was taken for another program's";
}

// Points of another program stay in their place until the new ones replace them.
TEST_F(FolderAccident, KillLeavesOldPointsOrNewOnes) {
  WriteSample(scratch_ / "start", 3);
  fs::remove(scratch_ / "start/points.ulf");
  int tried = 0, without = 0;
  for (int call = 1;; ++call) {
    fs::remove_all(dir());
    fs::copy(scratch_ / "start", dir(), fs::copy_options::recursive);
    const pid_t child = fork();
    if (child == 0) {
      LightFieldWriter writer = LightFieldWriter::Resume(dir());
      test::DieBeforeDiskCall(call);
      writer.SetPoints({{{5, 6, 7}, {1, 2, 3}}, {{1, 1, 1}, {4, 5, 6}}, {{2, 2, 2}, {7, 8, 9}}});
      writer.Close(1);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ++tried;
    const bool has_points = !ReadLightField(dir()).points.empty();
    without += !has_points;
    EXPECT_TRUE(has_points) << "after a kill before call " << call;
    if (WIFEXITED(status)) break;
  }
  EXPECT_GE(tried, 5);
  EXPECT_TRUE(fs::exists(dir() / "kept/points.ply"));
  PrintFaultRow("SIGKILL before each call that changes the disk: points of another program replaced", tried,
                fmt::format("{} times there were no points", without), std::nullopt);
}

// Whatever a writer writes: nothing under the old name, neither a folder nor into another one that has
// that name by now.
TEST_F(FolderAccident, MovedFolderIsNotWrittenByOldName) {
  for (const bool another_came : {false, true}) {
    fs::remove_all(dir());
    fs::remove_all(scratch_ / "moved");
    WriteSample(dir(), 3);
    LightFieldWriter writer = LightFieldWriter::Resume(dir());
    fs::rename(dir(), scratch_ / "moved");
    if (another_came) WriteSample(dir(), 2);
    const auto files = [&] {
      std::map<std::string, std::string> of_files;
      std::error_code none;
      for (const auto& entry : fs::recursive_directory_iterator(dir(), none))
        of_files[entry.path().string()] = entry.is_regular_file() ? ReadWholeFile(entry.path()) : "";
      return of_files;
    };
    const auto before = files();
    const auto says_both = ThrowsMessage<Error>(
        AllOf(HasSubstr(dir().string() + ": the folder was moved to " + (scratch_ / "moved").string())));
    const Frame with_master = NoiseFrame(7, Transfer::kLinear, CV_16UC3);
    EXPECT_THAT([&] { writer.AddView(with_master, ViewNumber(3)); }, says_both);
    EXPECT_THAT([&] { writer.AddExposure(1, with_master, {}, false); }, says_both);
    EXPECT_THAT([&] { writer.SetMerged(1, "exr", 2, 0); }, says_both);
    EXPECT_THAT([&] { writer.SetMasks({{1, cv::Mat::ones(kHeight, kWidth, CV_8UC1)}}); }, says_both);
    EXPECT_THAT([&] { writer.SetPoints({{{5, 6, 7}, {1, 2, 3}}}); }, says_both);
    EXPECT_THAT([&] { writer.RemoveViews({2}); }, says_both);
    EXPECT_THAT([&] { writer.KeepUnposed(with_master); }, says_both);
    EXPECT_THAT([&] { writer.Close(1); }, says_both);
    EXPECT_EQ(files(), before);
    EXPECT_EQ(ReadLightField(scratch_ / "moved").views.size(), 3u);
  }
}

TEST_F(FolderAccident, TheNextWriterLeavesNoLitter) {
  WriteSample(dir(), 3);
  const std::string mark = ProcessMark(), computer = mark.substr(0, mark.find('-'));
  const std::string gone = fmt::format(".{}-{}-4.part", computer, 999'999'999);
  for (const char* place : {"", "images/", "masters/", "masks/", "unposed/", "exposures/", "merged/", "kept/",
                            "depth/", "cache/", "cache/pyramids/", "sparse/0/"}) {
    fs::create_directories(dir() / place);
    std::ofstream(dir() / (std::string(place) + "000009.png" + gone)) << "half";
  }
  std::ofstream(dir() / kNewJournal) << "half";
  const fs::path renderers =
      dir() / fmt::format("cache/pyramids/000001.pyramid.{}-{}-1.part", computer, getppid());
  std::ofstream(renderers) << "half";
  std::ofstream(dir() / "images/notes.part") << "somebody else's";
  { LightFieldWriter::Resume(dir()); }
  std::vector<std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(dir()))
    if (entry.path().string().ends_with(".part") || entry.path().filename() == kNewJournal)
      left.push_back(entry.path().lexically_relative(dir()).string());
  EXPECT_THAT(
      left, testing::UnorderedElementsAre(renderers.lexically_relative(dir()).string(), "images/notes.part"));
}

}  // namespace
}  // namespace ulf::folder_accidents_test

// Tests: core/light_field/folder/unposed_photographs, core/light_field/folder/light_field_io.
// Photographs without a pose keep what their camera said of them, and become views when somebody has
// found their place.
#include "core/light_field/folder/unposed_photographs.h"

#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::unposed_photographs_test {
namespace {

using test::ScratchFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> Names(const LightField& light_field) {
  std::vector<std::string> names;
  for (const UnposedPhotograph& photograph : UnposedPhotographs(light_field))
    names.push_back(fs::path(photograph.view.image_path).filename().string());
  return names;
}

// The first photograph without a pose, as a view with a number.
View FirstFound(LightFieldWriter& writer) {
  View found = UnposedPhotographs(writer.Contents()).at(0).view;
  found.id = writer.ReserveViewId();
  return found;
}

Frame DeepFrame(int seed) {
  Frame frame = NoiseFrame(seed);
  frame.image.pixels.convertTo(frame.image.pixels, CV_16U, 257);
  frame.image.transfer = Transfer::kLinear;
  return frame;
}

TEST(Unposed, LocatedPhotographBecomesACompleteView) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  std::string kept_bytes;
  {
    LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
    writer.AddView(NoiseFrame(1), ViewNumber(1));
    writer.KeepUnposed(NoiseFrame(2));
    writer.KeepUnposed(DeepFrame(3));
    kept_bytes = ReadWholeFile(dir / "unposed/unposed_000001.png");
  }
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    const std::vector<UnposedPhotograph> photographs = UnposedPhotographs(writer.Contents());
    ASSERT_EQ(photographs.size(), 2u);
    std::vector<View> found;
    for (const UnposedPhotograph& photograph : photographs) {
      EXPECT_EQ(photograph.problem, "");
      found.push_back(photograph.view);
      found.back().id = writer.ReserveViewId();
      found.back().cam_from_world = ViewNumber(5).cam_from_world;
    }
    writer.AddUnposed(found);
    EXPECT_THAT(UnposedPhotographs(writer.Contents()), IsEmpty());
    // The name of one that became a view is free again, and what was said of the first is not
    // said of the next.
    writer.KeepUnposed(NoiseFrame(7));
    writer.Close(1);
  }
  const LightField read = ReadLightField(dir);
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.views.size(), 3u);
  EXPECT_EQ(ReadWholeFile(dir / read.views[1].image_path), kept_bytes);
  EXPECT_EQ(read.views[1].device_time_s, 0.2);
  EXPECT_EQ(read.views[1].exposure_s, 0.004);
  EXPECT_EQ(read.views[1].gain, 2);
  EXPECT_LT((read.views[2].cam_from_world.Matrix() - ViewNumber(5).cam_from_world.Matrix()).norm(), 1e-12);
  const Image master = ReadViewMaster(read, read.views[2]);
  EXPECT_EQ(master.transfer, Transfer::kLinear);
  EXPECT_EQ(cv::norm(master.pixels, DeepFrame(3).image.pixels, cv::NORM_INF), 0);
  ASSERT_THAT(Names(read), ElementsAre("unposed_000001.png"));
  EXPECT_NEAR(UnposedPhotographs(read)[0].view.device_time_s, 0.7, 1e-9);
}

TEST(Unposed, OffersAddedPicturesNotTakenBackOnes) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  for (int i = 0; i < 3; ++i) writer.AddView(NoiseFrame(i), ViewNumber(i));
  writer.RemoveViews({2});
  writer.KeepUnposed(DeepFrame(4));
  fs::copy_file(dir / "unposed/000002.png", dir / "unposed/DSC_0815.PNG");
  fs::copy_file(dir / "unposed/000002.png", dir / "unposed/20241123_101500.png");  // as telephones name them
  fs::copy_file(dir / "unposed/000002.png", dir / "unposed/000001.png");
  writer.KeepUnposed(NoiseFrame(5), "it was taken with the zoom moved");
  std::ofstream(dir / "unposed/notes.txt") << "none";
  std::ofstream(dir / "unposed/cut.jpg") << "no picture";
  cv::imwrite((dir / "unposed/deep.png").string(), cv::Mat(kHeight, kWidth, CV_16UC3, cv::Scalar::all(9)));
  cv::imwrite((dir / "unposed/large.png").string(),
              cv::Mat(2 * kHeight, 2 * kWidth, CV_8UC3, cv::Scalar::all(9)));
  const std::vector<UnposedPhotograph> photographs = UnposedPhotographs(ReadLightField(dir));
  ASSERT_THAT(Names(ReadLightField(dir)),
              ElementsAre("000001.png", "20241123_101500.png", "DSC_0815.PNG", "cut.jpg", "deep.png",
                          "large.png", "unposed_000001.png", "unposed_000002.png"));
  for (const std::size_t usable : {0, 1, 2, 6}) EXPECT_EQ(photographs[usable].problem, "");
  EXPECT_THAT(photographs[3].problem, ::testing::StartsWith("cannot be decoded as an image"));
  EXPECT_THAT(photographs[4].problem, HasSubstr("8-bit"));
  EXPECT_THAT(photographs[5].problem, HasSubstr("it is 128x96"));
  EXPECT_THAT(photographs[7].problem, HasSubstr("zoom moved"));
  EXPECT_EQ(CountTakenBack(ReadLightField(dir)), 1u);
  for (const char* file : {"unposed/000002.png", "unposed/000002.master.tif"}) fs::remove(dir / file);
  EXPECT_EQ(CountTakenBack(ReadLightField(dir)), 0u) << "no file of it is there any more";
}

// Killed after the journal named the view and before the copy in unposed/ was gone.
TEST(Unposed, ViewIsNotOfferedAgain) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  writer.AddView(NoiseFrame(1), ViewNumber(1));
  writer.KeepUnposed(NoiseFrame(2));
  fs::copy_file(dir / "images/000001.png", dir / "unposed/unposed_000009.png");
  EXPECT_THAT(Names(ReadLightField(dir)), ElementsAre("unposed_000001.png"));
}

TEST(Unposed, PhotographWithoutMasterHasEightBits) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  writer.AddView(NoiseFrame(1), ViewNumber(1));
  writer.KeepUnposed(DeepFrame(3));
  fs::remove(dir / "unposed/unposed_000001.master.tif");
  const View found = FirstFound(writer);
  writer.AddUnposed({found});
  const LightField read = ReadLightField(dir);
  ASSERT_EQ(read.views.size(), 2u);
  EXPECT_EQ(read.views[1].master_path, "");
  EXPECT_FALSE(HasMoreThanEightBits(read, read.views[1]));
}

// A photograph is a view, or waits in unposed/, whenever the writer dies; it is never lost and never
// offered twice.
TEST(Unposed, SurvivesSigkillAtAnyMoment) {
  const ScratchFolder scratch;
  constexpr std::size_t kPhotographs = 40;
  std::mt19937 random(20261126);
  std::size_t views = 0, waiting = 0;
  for (int round = 0; round < 12; ++round) {
    const fs::path dir = scratch / ("lf" + std::to_string(round));
    {
      LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
      writer.AddView(NoiseFrame(500), ViewNumber(1));
      for (std::size_t i = 0; i < kPhotographs; ++i) writer.KeepUnposed(DeepFrame(static_cast<int>(i)));
    }
    const auto before = fs::file_size(dir / "journal.jsonl");
    const pid_t child = fork();
    if (child == 0) {
      LightFieldWriter writer = LightFieldWriter::Resume(dir);
      std::vector<View> found;
      for (const UnposedPhotograph& photograph : UnposedPhotographs(writer.Contents())) {
        found.push_back(photograph.view);
        found.back().id = writer.ReserveViewId();
      }
      writer.AddUnposed(std::move(found));
      _exit(0);
    }
    const auto bytes = std::uniform_int_distribution<std::uintmax_t>(1, 8000)(random);
    while (fs::file_size(dir / "journal.jsonl") < before + bytes) usleep(100);
    usleep(std::uniform_int_distribution<useconds_t>(0, 2000)(random));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    const LightField& after = writer.Contents();
    const std::size_t left = UnposedPhotographs(after).size();
    EXPECT_EQ(after.views.size() - 1 + left, kPhotographs) << "round " << round;
    for (const View& view : after.views) {
      EXPECT_NO_THROW(ReadViewImage(after, view)) << "round " << round;
      EXPECT_NO_THROW(ReadViewMaster(after, view)) << "round " << round;
    }
    views += after.views.size() - 1;
    waiting += left;
  }
  EXPECT_GT(views, 20u);
  EXPECT_GT(waiting, 20u);
}

TEST(Unposed, OnAFullDiskThePhotographStaysWhereItIs) {
  const ScratchFolder small;
  if (const auto problem = test::MountSmallDisk(small.path(), 1 << 20)) GTEST_SKIP() << *problem;
  const fs::path dir = small / "lf";
  {
    LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
    writer.AddView(NoiseFrame(1), ViewNumber(1));
    writer.KeepUnposed(NoiseFrame(2));
    test::FillDisk(small / "ballast");
    const View found = FirstFound(writer);
    EXPECT_THROW(writer.AddUnposed({found}), DiskFullError);
    EXPECT_EQ(writer.Contents().views.size(), 1u);
  }
  const LightField read = ReadLightField(dir);
  EXPECT_EQ(read.views.size(), 1u);
  EXPECT_THAT(Names(read), ElementsAre("unposed_000001.png"));
  EXPECT_FALSE(fs::exists(dir / "images/000002.png"));
}

}  // namespace
}  // namespace ulf::unposed_photographs_test

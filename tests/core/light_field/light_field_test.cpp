// Tests: core/light_field/folder/light_field_io, core/light_field/folder/light_field_writer,
// core/light_field/folder/writer_state, core/light_field/light_field, core/light_field/folder/journal,
// core/light_field/folder/journal_writer, core/light_field/folder/view_files,
// core/light_field/folder/view_images, core/light_field/formats/view_json, core/frames/frame.
//
// The light field on disk: what is written is read back, what is damaged is named, what is killed survives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <random>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::light_field_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(LightFieldOnDisk, ReadsBackWhatWasWritten) {
  ScratchFolder scratch;
  const LightField written = WriteSample(scratch / "lf", 5);
  const LightField read = ReadLightField(scratch / "lf");
  ExpectSame(written, read);
  EXPECT_EQ(read.points[1].rgb[0], 200);
  EXPECT_EQ(cv::norm(ReadViewImage(read, read.views[3]).pixels, NoiseFrame(3).image.pixels, cv::NORM_INF), 0);
}

TEST(LightFieldOnDisk, TransformsJsonAloneSaysTheSame) {
  ScratchFolder scratch;
  const LightField written = WriteSample(scratch / "lf", 4);
  fs::remove(scratch / "lf/journal.jsonl");
  LightField read = ReadLightField(scratch / "lf");
  read.points = written.points;  // the points stand in a file of their own
  ExpectSame(written, read);
}

TEST(LightFieldOnDisk, TransformsJsonIsAsNerfstudios) {
  // A camera at (1, 2, 3) that looks along world +x with world +z up. In OpenGL's axes its columns are
  // right = -y, up = +z, back = -x.
  ScratchFolder scratch;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  View view;
  view.cam_from_world = LookAt({1, 2, 3}, {5, 2, 3}, {0, 0, 1});
  writer.AddView(NoiseFrame(0), view);
  writer.Close(1);
  const json document = JsonFromText(ReadWholeFile(scratch / "lf/transforms.json"));
  const double expected[4][4] = {{0, 0, -1, 1}, {-1, 0, 0, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}};
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(document["frames"][0]["transform_matrix"][r][c].get<double>(), expected[r][c], 1e-12)
          << r << c;
  EXPECT_EQ(document["frames"][0]["file_path"], "images/000001.png");
  EXPECT_EQ(document["camera_model"], "OPENCV");
  EXPECT_NEAR(document["cx"].get<double>(), 31.5, 1e-12) << "pixel centres at integer + 0.5";
  EXPECT_NEAR(document["p2"].get<double>(), -0.0004, 1e-12);
}

TEST(LightFieldOnDisk, SparseModelHoldsColmapsConvention) {
  ScratchFolder scratch;
  const LightField written = WriteSample(scratch / "lf", 3);
  std::istringstream cameras(ReadWholeFile(scratch / "lf/sparse/0/cameras.txt"));
  std::string line;
  std::getline(cameras, line);
  std::getline(cameras, line);
  EXPECT_EQ(line, "1 OPENCV 64 48 60 61 31.5 23.5 0.01 -0.002 0.0003 -0.0004");
  std::istringstream images(ReadWholeFile(scratch / "lf/sparse/0/images.txt"));
  std::getline(images, line);
  for (const View& view : written.views) {
    int id, camera;
    double w, x, y, z;
    Eigen::Vector3d t;
    std::string name, places;
    ASSERT_TRUE(std::getline(images, line));
    std::istringstream(line) >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z() >> camera >> name;
    ASSERT_TRUE(std::getline(images, places));
    EXPECT_EQ(places, "31.5000 23.5000 -1") << "a place without a point: some readers end at an empty line";
    EXPECT_EQ(id, view.id);
    EXPECT_EQ("images/" + name, view.image_path);
    EXPECT_EQ(camera, 1);
    EXPECT_LT((t - view.cam_from_world.translation).norm(), 1e-9);
    EXPECT_LT(RotationAngle(Eigen::Quaterniond(w, x, y, z) * view.cam_from_world.rotation.conjugate()), 1e-9);
  }
}

TEST(LightFieldOnDisk, AMosaicsMasterIsItsLinearColor) {
  ScratchFolder scratch;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  for (const int type : {CV_8UC1, CV_16UC1}) {
    Frame mosaic = NoiseFrame(1, Transfer::kLinear, type);
    mosaic.image.mosaic = Mosaic::kGbrg;
    writer.AddView(mosaic, ViewNumber(type));
    const View& view = writer.Contents().views.back();
    const Image master = ReadViewMaster(writer.Contents(), view);
    EXPECT_EQ(master.pixels.type(), CV_16UC3);
    EXPECT_EQ(master.transfer, Transfer::kLinear);
    EXPECT_EQ(master.mosaic, Mosaic::kNone);
    EXPECT_EQ(cv::norm(master.pixels, Demosaiced(mosaic.image).pixels, cv::NORM_INF), 0);
  }
}

// --raw: what the sensor saw comes back with pattern, transfer and black level, through the journal and
// through transforms.json alone.
TEST(LightFieldOnDisk, ARawMosaicIsUsableAgain) {
  for (const Mosaic pattern : {Mosaic::kRggb, Mosaic::kGrbg, Mosaic::kGbrg, Mosaic::kBggr}) {
    ScratchFolder scratch;
    LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
    writer.KeepMosaics(true);
    Frame frame = NoiseFrame(1, Transfer::kLinear, CV_16UC1);
    frame.image.mosaic = pattern;
    frame.black_level = 0.0625;
    writer.AddView(frame, ViewNumber(0));
    Frame color = NoiseFrame(2);
    writer.AddView(color, ViewNumber(1));
    writer.Close(1);
    for (const bool from_journal : {true, false}) {
      if (!from_journal) fs::remove(scratch / "lf/journal.jsonl");
      const LightField read = ReadLightField(scratch / "lf");
      const Image master = ReadViewMaster(read, read.views[0]);
      EXPECT_EQ(master.mosaic, pattern) << Name(pattern);
      EXPECT_EQ(master.transfer, Transfer::kLinear);
      EXPECT_EQ(read.views[0].black_level, 0.0625);
      EXPECT_EQ(cv::norm(master.pixels, frame.image.pixels, cv::NORM_INF), 0) << Name(pattern);
      EXPECT_EQ(cv::norm(ReadViewImage(read, read.views[0]).pixels, Srgb8(frame.image), cv::NORM_INF), 0);
      // Where the photograph is all there was, it is the master.
      EXPECT_TRUE(read.views[1].master_path.empty());
      EXPECT_EQ(cv::norm(ReadViewMaster(read, read.views[1]).pixels, color.image.pixels, cv::NORM_INF), 0);
    }
  }
}

TEST(LightFieldOnDisk, NamesAMastersUnknownPattern) {
  ScratchFolder scratch;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  writer.KeepMosaics(true);
  Frame frame = NoiseFrame(1, Transfer::kLinear, CV_16UC1);
  frame.image.mosaic = Mosaic::kRggb;
  writer.AddView(frame, ViewNumber(0));
  writer.AddView(NoiseFrame(2), ViewNumber(1));
  std::string journal = ReadWholeFile(scratch / "lf/journal.jsonl");
  journal.replace(journal.find("RGGB"), 4, "RGBW");
  std::ofstream(scratch / "lf/journal.jsonl") << journal;
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_EQ(read.views.size(), 1u);
  EXPECT_THAT(read.doubts,
              Contains(AllOf(HasSubstr("master_mosaic"), HasSubstr("RGBW"), HasSubstr("view 1"))));
}

TEST(LightFieldOnDisk, ACamerasJpegIsKeptByteForByte) {
  ScratchFolder scratch;
  Frame frame = NoiseFrame(1);
  cv::imwrite((scratch / "IMG_1.JPG").string(), frame.image.pixels);
  frame.encoded = {".jpg", std::make_shared<const std::string>(ReadWholeFile(scratch / "IMG_1.JPG"))};
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  const View view = writer.AddView(frame, ViewNumber(0));
  EXPECT_EQ(view.image_path, "images/000001.jpg");
  EXPECT_EQ(ReadWholeFile(scratch / "lf" / view.image_path), *frame.encoded->bytes);
}

TEST(LightFieldOnDisk, KeepsPosesSubjectAndRemovals) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 4);
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  const Rigid3 moved = LookAt({9, 9, 9}, {0, 0, 0}, {0, -1, 0});
  writer.UpdatePoses({{2, moved}});
  writer.RemoveViews({4});
  writer.NoteGap(1, 2, "lost");
  writer.SetSubject({{1, 1, 1}, 2});
  const View added = writer.AddView(NoiseFrame(9), ViewNumber(9));
  EXPECT_EQ(added.id, 5) << "the id of a removed view is not given again";
  writer.Close(20);
  const LightField read = ReadLightField(scratch / "lf");
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_LT((read.views[1].cam_from_world.Matrix() - moved.Matrix()).norm(), 1e-12);
  EXPECT_EQ(read.views[3].id, 5);
  EXPECT_EQ(read.subject->radius, 2);
  EXPECT_TRUE(fs::exists(scratch / "lf/unposed/000004.png")) << "a removed photograph is kept";
  EXPECT_FALSE(fs::exists(scratch / "lf/images/000004.png"));
}

TEST(LightFieldOnDisk, CompletesAKilledRemoval) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 4);
  LightFieldWriter::Resume(scratch / "lf").RemoveViews({2});
  fs::rename(scratch / "lf/unposed/000002.png", scratch / "lf/images/000002.png");
  LightFieldWriter::Resume(scratch / "lf");
  EXPECT_TRUE(fs::exists(scratch / "lf/unposed/000002.png"));
  EXPECT_FALSE(fs::exists(scratch / "lf/images/000002.png"));
  for (const int id : {1, 3, 4})
    EXPECT_TRUE(fs::exists(scratch / "lf/images" / fmt::format("{:06}.png", id))) << id;
}

TEST(LightFieldOnDisk, RefusesASecondWriterOrFullFolder) {
  ScratchFolder scratch;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  EXPECT_THAT([&] { LightFieldWriter::Resume(scratch / "lf"); },
              ThrowsMessage<Error>(HasSubstr("another process")));
  // Nothing is recorded yet, but somebody is about to.
  EXPECT_THAT([&] { LightFieldWriter::Create(scratch / "lf", Header()); },
              ThrowsMessage<Error>(HasSubstr("another process")));
  writer.AddView(NoiseFrame(7), ViewNumber(0));
  EXPECT_THAT([&] { LightFieldWriter::Create(scratch / "lf", Header()); },
              ThrowsMessage<Error>(HasSubstr("(resume)")));
  std::ofstream(scratch / "notes.txt") << "mine";
  EXPECT_THAT([&] { LightFieldWriter::Create(scratch.path(), Header()); },
              ThrowsMessage<Error>(HasSubstr("not empty")));
}

// What was begun and came to nothing does not stand in the way; what was taken back, or kept, does.
TEST(LightFieldOnDisk, AFolderWithoutAViewIsBegunAnew) {
  ScratchFolder scratch;
  LightFieldWriter::Create(scratch / "lf", Header()).Close(1);
  {
    LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
    EXPECT_EQ(writer.AddView(NoiseFrame(7), ViewNumber(0)).id, 1);
    writer.RemoveViews({1});
    writer.Close(1);
  }
  EXPECT_EQ(ReadLightField(scratch / "lf").taken_back.size(), 1u);
  EXPECT_THAT([&] { LightFieldWriter::Create(scratch / "lf", Header()); },
              ThrowsMessage<Error>(HasSubstr("(resume)")));
}

TEST(LightFieldOnDisk, TornLastLineIsIgnoredAndCut) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 3);
  const fs::path journal = scratch / "lf/journal.jsonl";
  const std::string whole = ReadWholeFile(journal);
  std::ofstream(journal, std::ios::app) << "{\"event\":\"view\",\"id\":4,\"ima";
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), 3u);
  LightFieldWriter::Resume(scratch / "lf").AddView(NoiseFrame(7), ViewNumber(3));
  EXPECT_TRUE(ReadWholeFile(journal).starts_with(whole));
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), 4u);

  std::string damaged = ReadWholeFile(journal);
  damaged[damaged.find("\"view\"") + 20] = '\x01';
  damaged[damaged.find("\"view\"") - 3] = '\x01';
  std::ofstream(journal, std::ios::trunc) << damaged;
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_EQ(read.views.size(), 3u) << "a damaged line costs its own view only";
  EXPECT_THAT(read.doubts, Contains(AllOf(HasSubstr("journal.jsonl, line"), HasSubstr("damaged"))));
}

// ---- Photographs that follow their masters. ----

// Of every kind that has a master made by us.
std::vector<Frame> FramesWithMasters() {
  std::vector<Frame> frames;
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3, CV_32FC3}) {
    frames.push_back(NoiseFrame(static_cast<int>(frames.size()), Transfer::kLinear, type));
    cv::Mat& pixels = frames.back().image.pixels;
    if (pixels.depth() == CV_16U) pixels *= 257;
    if (pixels.depth() == CV_32F) pixels /= 255;
  }
  frames.push_back(frames[2]);
  frames.back().image.mosaic = Mosaic::kGrbg;
  frames.push_back(NoiseFrame(9, Transfer::kSrgb, CV_16UC3));
  return frames;
}

void AddAll(LightFieldWriter& writer, const std::vector<Frame>& frames, MakePictures pictures) {
  std::vector<LightFieldWriter::NewView> added;
  for (std::size_t i = 0; i < frames.size(); ++i)
    added.push_back({frames[i], ViewNumber(static_cast<int>(i)), writer.Files(frames[i], pictures)});
  writer.AddViews(added);
}

std::size_t FilesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

// A number is a view's before it is on disk, and nobody else's where it never gets there.
TEST(LightFieldOnDisk, ViewHasItsReservedNumber) {
  ScratchFolder scratch;
  auto writer = std::make_optional(LightFieldWriter::Create(scratch / "lf", Header()));
  const int never_written = writer->ReserveViewId(), written = writer->ReserveViewId();
  EXPECT_EQ(never_written, 1);
  LightFieldWriter::NewView added{NoiseFrame(0), ViewNumber(0),
                                  writer->Files(NoiseFrame(0), MakePictures::kNow)};
  added.view.id = written;
  EXPECT_EQ(writer->AddViews({&added, 1}).front().image_path, "images/000002.png");
  EXPECT_EQ(writer->AddView(NoiseFrame(1), ViewNumber(1)).id, 3);
  for (const int taken : {never_written, written, 3}) {
    added.view.id = taken;
    EXPECT_THAT(
        [&] {
          writer->AddViews({&added, 1});
        },
        ThrowsMessage<Error>(HasSubstr("cannot follow view 3")));
  }
  added.view.id = writer->NextViewId();
  EXPECT_THAT([&] { writer->AddViews({&added, 1}); }, ThrowsMessage<Error>(HasSubstr("was not reserved")));
  EXPECT_EQ(FilesIn(scratch / "lf/images"), 2u);
  writer->Close(1);
  writer.reset();
  EXPECT_EQ(LightFieldWriter::Resume(scratch / "lf").NextViewId(), 4);
}

TEST(LightFieldOnDisk, ManyViewsAtOnceEqualOneByOne) {
  for (const bool keep_mosaics : {false, true}) {
    ScratchFolder scratch;
    const std::vector<Frame> frames = FramesWithMasters();
    LightFieldWriter together = LightFieldWriter::Create(scratch / "together", Header()),
                     single = LightFieldWriter::Create(scratch / "single", Header());
    together.KeepMosaics(keep_mosaics);
    single.KeepMosaics(keep_mosaics);
    AddAll(together, frames, MakePictures::kNow);
    for (std::size_t i = 0; i < frames.size(); ++i)
      single.AddView(frames[i], ViewNumber(static_cast<int>(i)));
    EXPECT_EQ(ReadWholeFile(scratch / "together/journal.jsonl"),
              ReadWholeFile(scratch / "single/journal.jsonl"));
    for (const View& view : single.Contents().views)
      for (const std::string& path : {view.image_path, view.master_path})
        EXPECT_EQ(ReadWholeFile(scratch / "together" / path), ReadWholeFile(scratch / "single" / path))
            << path;
  }
}

TEST(LightFieldOnDisk, MakesAKilledPhotographAnew) {
  for (const bool keep_mosaics : {false, true}) {
    ScratchFolder scratch;
    const std::vector<Frame> frames = FramesWithMasters();
    LightFieldWriter whole = LightFieldWriter::Create(scratch / "whole", Header());
    whole.KeepMosaics(keep_mosaics);
    AddAll(whole, frames, MakePictures::kNow);
    const auto same_as_whole = [&](const View& view) {
      return ReadWholeFile(scratch / "killed" / view.image_path) ==
             ReadWholeFile(scratch / "whole" / view.image_path);
    };
    {
      LightFieldWriter killed = LightFieldWriter::Create(scratch / "killed", Header());
      killed.KeepMosaics(keep_mosaics);
      AddAll(killed, frames, MakePictures::kLater);
      const LightField open = ReadLightField(scratch / "killed");
      ASSERT_EQ(open.views.size(), frames.size());
      EXPECT_EQ(FilesIn(scratch / "killed/images"), 0u) << "somebody is writing: hands off";
      for (const View& view : open.views)
        EXPECT_EQ(cv::norm(ReadViewImage(open, view).pixels, ReadViewImage(whole.Contents(), view).pixels,
                           cv::NORM_INF),
                  0)
            << view.id;
    }
    ReadLightField(scratch / "killed");
    EXPECT_EQ(FilesIn(scratch / "killed/images"), 0u) << "reading writes nothing";
    Repair(scratch / "killed");
    for (const View& view : ReadLightField(scratch / "killed").views)
      EXPECT_TRUE(same_as_whole(view)) << view.id;
    fs::remove(scratch / "killed/images/000003.png");
    LightFieldWriter resumed = LightFieldWriter::Resume(scratch / "killed");
    EXPECT_TRUE(same_as_whole(resumed.Contents().views[2])) << "who goes on with it makes it, too";
    fs::remove(scratch / "killed/images/000004.png");
    resumed.RemoveViews({4});
    EXPECT_TRUE(fs::exists(scratch / "killed/unposed/000004.png"));
  }
}

TEST(LightFieldOnDisk, MissingPhotographNeedsItsMaster) {
  ScratchFolder scratch;
  AddAll(*std::make_unique<LightFieldWriter>(LightFieldWriter::Create(scratch / "lf", Header())),
         FramesWithMasters(), MakePictures::kLater);
  fs::remove(scratch / "lf/masters/000002.tif");
  EXPECT_THAT([&] { ReadLightField(scratch / "lf"); }, ThrowsMessage<Error>(HasSubstr("000002.png")));
}

// What was appended last can be damaged in several lines when the power fails.
TEST(LightFieldOnDisk, ADamagedEndOfTheJournalIsIgnored) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 3);
  const std::string whole = ReadWholeFile(scratch / "lf/journal.jsonl");
  std::ofstream(scratch / "lf/journal.jsonl", std::ios::app)
      << std::string(300, '\0') << "\n{\"event\": \"view\", \"id\n{\"event\": \"vi";
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), 3u);
  LightFieldWriter::Resume(scratch / "lf");
  EXPECT_EQ(ReadWholeFile(scratch / "lf/journal.jsonl"), whole);
}

// Twenty captures killed at a random moment: what the journal names is whole, and the capture goes on.
TEST(LightFieldOnDisk, SurvivesSigkillAtAnyMoment) {
  ScratchFolder scratch;
  std::mt19937 random(20261121);
  std::size_t total = 0;
  for (int round = 0; round < 20; ++round) {
    const fs::path dir = scratch / ("lf" + std::to_string(round));
    const pid_t child = fork();
    if (child == 0) {
      LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
      for (int i = 0; i < 100000; ++i) {
        writer.AddView(NoiseFrame(i, Transfer::kLinear), ViewNumber(i % 7));
        if (i % 5 == 4) writer.UpdatePoses({{i, ViewNumber(i % 11).cam_from_world}});
      }
      _exit(0);
    }
    // By what is written, not by the time: machines may be busy.
    const auto bytes = std::uniform_int_distribution<std::uintmax_t>(1, 8000)(random);
    while (!fs::exists(dir / "journal.jsonl") || fs::file_size(dir / "journal.jsonl") < bytes) usleep(200);
    usleep(std::uniform_int_distribution<useconds_t>(0, 10000)(random));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "round " << round;

    const LightField killed = ReadLightField(dir);
    for (const View& view : killed.views) {
      EXPECT_NO_THROW(ReadViewImage(killed, view)) << "round " << round << " view " << view.id;
      EXPECT_NO_THROW(ReadImageFile((dir / view.master_path).string()))
          << "round " << round << " view " << view.id;
    }
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    writer.AddView(NoiseFrame(1), ViewNumber(1));
    writer.Close(1);
    EXPECT_EQ(ReadLightField(dir).views.size(), killed.views.size() + 1) << "round " << round;
    total += killed.views.size();
  }
  EXPECT_GT(total, 20u) << "the kills came before anything was recorded: the test shows nothing";
}

// ---- Bad input: one valid document, broken in one place at a time. ----

NewCamera SecondCamera() {
  NewCamera camera{Header().camera, {}, {}, "file better.json"};
  camera.camera.fx *= 1.03;
  camera.camera.fy *= 1.03;
  return camera;
}

TEST(LightFieldOnDisk, ASecondCameraIsOfTheViewsBehindIt) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    EXPECT_EQ(writer.CameraInUse(), 0);
    EXPECT_EQ(writer.AddCamera(SecondCamera()), 1);
    writer.AddView(NoiseFrame(2), ViewNumber(2));
    writer.KeepUnposed(NoiseFrame(3));
    writer.Close(2);
  }
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_THAT(read.doubts, testing::IsEmpty());
  ASSERT_EQ(read.cameras.size(), 2u);
  ASSERT_EQ(read.views.size(), 3u);
  EXPECT_EQ(read.CameraOf(read.views[1]), Header().camera);
  EXPECT_EQ(read.CameraOf(read.views[2]), SecondCamera().camera);
  EXPECT_EQ(read.unposed.at(0).view.camera, 1);
  EXPECT_EQ(read.CalibrationSource(0), Header().calibration_source);
  EXPECT_EQ(read.CalibrationSource(1), "file better.json");
  const auto check = ReadTransformsText(scratch / "lf/transforms.json").light_field;
  EXPECT_EQ(check.CameraOf(check.views[0]), Header().camera);
  EXPECT_EQ(check.CameraOf(check.views[2]), SecondCamera().camera);
  EXPECT_EQ(check.CalibrationSource(check.views[0].camera), Header().calibration_source);
  EXPECT_EQ(check.CalibrationSource(check.views[2].camera), "file better.json");
  const std::string cameras = ReadWholeFile(scratch / "lf/sparse/0/cameras.txt");
  EXPECT_THAT(cameras, AllOf(HasSubstr("\n1 OPENCV 64 48 60 "), HasSubstr("\n2 OPENCV 64 48 61.8")));
  // The next session goes on under it.
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  EXPECT_EQ(writer.CameraInUse(), 1);
  EXPECT_EQ(writer.AddView(NoiseFrame(4), ViewNumber(4)).camera, 1);
}

TEST(LightFieldOnDisk, CorrectedCameraChangesItselfAlone) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  CameraModel corrected = Header().camera;
  corrected.fx *= 1.01;
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    writer.AddCamera(SecondCamera());
    writer.AddView(NoiseFrame(2), ViewNumber(2));
    writer.UpdatePoses({}, {{0, {corrected, "the images"}}});
    EXPECT_EQ(writer.Contents().CalibrationSource(1), "file better.json");
    writer.Close(2);
  }
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_EQ(read.cameras[0], corrected);
  EXPECT_EQ(read.CalibrationSource(0), "the images");
  EXPECT_EQ(read.CalibrationSource(1), "file better.json");
}

// No view names it yet, and none is lost.
TEST(LightFieldOnDisk, KillAfterACamerasLineIsHarmless) {
  ScratchFolder scratch;
  const LightField before = WriteSample(scratch / "lf", 2);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    writer.AddCamera(SecondCamera());
  }
  const LightField killed = ReadLightField(scratch / "lf");
  EXPECT_THAT(killed.doubts, testing::IsEmpty());
  EXPECT_EQ(killed.views.size(), before.views.size());
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  EXPECT_EQ(writer.CameraInUse(), 1) << "what was said then still holds";
  writer.AddView(NoiseFrame(2), ViewNumber(2));
  writer.Close(1);
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_THAT(read.doubts, testing::IsEmpty());
  EXPECT_EQ(read.CameraOf(read.views.back()), SecondCamera().camera);
}

TEST(LightFieldOnDisk, RefusesACameraOfAnotherSize) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  const std::string journal = ReadWholeFile(scratch / "lf/journal.jsonl");
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  NewCamera camera = SecondCamera();
  camera.camera = camera.camera.ScaledTo(2 * kWidth, 2 * kHeight);
  EXPECT_THAT([&] { writer.AddCamera(camera); },
              ThrowsMessage<Error>(AllOf(HasSubstr("64x48"), HasSubstr("128x96"))));
  EXPECT_EQ(ReadWholeFile(scratch / "lf/journal.jsonl"), journal);
}

// A line that says which camera a later one is must not be passed over.
TEST(LightFieldOnDisk, AViewWithoutItsCameraIsLeftOut) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    writer.AddCamera(SecondCamera());
    NewCamera third = SecondCamera();
    third.camera.fx *= 2;
    writer.AddCamera(third);
    writer.AddView(NoiseFrame(2), ViewNumber(2));
  }
  std::string journal = ReadWholeFile(scratch / "lf/journal.jsonl");
  const std::size_t line = journal.find("\"event\":\"camera\"");
  ASSERT_NE(line, std::string::npos);
  journal[line + 2] = '\x01';
  std::ofstream(scratch / "lf/journal.jsonl", std::ios::binary) << journal;
  const JournalContents read = ReadJournal(scratch / "lf/journal.jsonl");
  EXPECT_EQ(read.light_field.cameras.size(), 1u) << "the third one does not take the second one's place";
  EXPECT_EQ(read.light_field.views.size(), 2u);
  EXPECT_EQ(read.damaged.size(), 3u);
}

TEST(LightFieldOnDisk, LastOfSeveralGoalsCounts) {
  ScratchFolder scratch;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  EXPECT_FALSE(ReadLightField(scratch / "lf").goal);
  writer.SetGoal({{60, 40}, 0.98});
  writer.SetGoal({{90, 60}, 0.5});
  EXPECT_EQ(ReadLightField(scratch / "lf").goal, (CoverageGoal{{90, 60}, 0.5}));
}

TEST(LightFieldOnDisk, LastReadoutInTheJournalCounts) {
  ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  EXPECT_FALSE(ReadLightField(dir).readout);
  View view = ViewNumber(0);
  view.twist = {0.1, -0.2, 0.3, 0.01, 0.02, -0.03};
  writer.AddView(NoiseFrame(0), view);
  writer.AddView(NoiseFrame(1), ViewNumber(1));
  writer.SetReadout({0.02, {}});
  writer.SetReadout({-0.03, 0.001});
  writer.Close(1);
  LightField read = ReadLightField(dir);
  EXPECT_EQ(read.readout, (ShutterReadout{-0.03, 0.001}));
  EXPECT_EQ(read.views[0].twist, view.twist);
  EXPECT_FALSE(read.views[1].twist);
  std::string transforms = ReadWholeFile(dir / "transforms.json");
  const std::size_t at = transforms.find("-0.03,");
  ASSERT_NE(at, std::string::npos) << "transforms.json tells it, too";
  WriteFileAtomically(dir / "transforms.json", transforms.replace(at, 5, "-0.04"));
  EXPECT_EQ(ReadLightField(dir).readout, (ShutterReadout{-0.03, 0.001}));

  std::ofstream(dir / "journal.jsonl", std::ios::app) << R"({"event":"readout","readout_s":3})" << std::endl;
  read = ReadLightField(dir);
  EXPECT_EQ(read.readout, (ShutterReadout{-0.03, 0.001}));
  EXPECT_THAT(read.doubts, Contains(HasSubstr("a readout of 3 s is not possible")));
}

// The journal tells them, transforms.json too; masks that are made anew leave the former ones in kept/.
TEST(LightFieldOnDisk, KeepsATurntableAndItsMasks) {
  test::ScratchFolder scratch;
  const fs::path dir = scratch / "field";
  const auto mask_of = [](int edge) {
    cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
    mask.colRange(0, edge) = 0;
    return mask;
  };
  {
    LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
    for (int i = 0; i < 3; ++i) writer.AddView(NoiseFrame(i), ViewNumber(i));
    writer.SetTurntable({"charuco:5x5:54:40:DICT_4X4_50"});
    writer.SetMasks({{1, mask_of(5)}, {2, mask_of(6)}, {3, mask_of(7)}});
    writer.Close(1);
  }
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    EXPECT_EQ(writer.Contents().views[1].mask_path, "masks/000002.png");
    writer.SetMasks({{2, mask_of(20)}});
    writer.Close(1);
  }
  const auto expect_both = [&](const LightField& read) {
    ASSERT_TRUE(read.turntable);
    EXPECT_EQ(read.turntable->board, "charuco:5x5:54:40:DICT_4X4_50");
    ASSERT_EQ(read.views.size(), 3u);
    EXPECT_EQ(cv::norm(ReadViewMask(read, read.views[0]), mask_of(5), cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(ReadViewMask(read, read.views[1]), mask_of(20), cv::NORM_INF), 0);
  };
  const LightField read = ReadLightField(dir);
  expect_both(read);
  EXPECT_TRUE(read.doubts.empty());
  EXPECT_EQ(cv::norm(cv::imread((dir / "kept/masks/000002.png").string(), cv::IMREAD_UNCHANGED), mask_of(6),
                     cv::NORM_INF),
            0);
  fs::remove(dir / "journal.jsonl");
  expect_both(ReadLightField(dir / "transforms.json"));
}

TEST(LightFieldOnDisk, AGoalThatNothingReachesIsNamed) {
  ScratchFolder scratch;
  LightFieldWriter::Create(scratch / "lf", Header());
  const fs::path journal = scratch / "lf" / "journal.jsonl";
  std::ofstream(journal, std::ios::app) << R"({"event":"goal","cap_deg":[400,40],"share":0.9})" << std::endl;
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_FALSE(read.goal);
  EXPECT_THAT(read.doubts, Contains(AllOf(HasSubstr("journal.jsonl, line 2"), HasSubstr("400 x 40"))));
}

TEST(LightFieldOnDisk, DamagedMasterAffectsOnlyItself) {
  ScratchFolder scratch;
  WriterAheadOfItsPhotographs(scratch / "lf", 3);  // and no more: as after a kill
  fs::resize_file(scratch / "lf/masters/000002.tif", 50);
  Repair(scratch / "lf");
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), 3u);
  for (const char* made : {"000001.png", "000003.png"})
    EXPECT_TRUE(fs::exists(scratch / "lf/images" / made)) << made;
  EXPECT_FALSE(fs::exists(scratch / "lf/images/000002.png"));
}

// A capture that cannot begin leaves nothing that stands in the way of the next one; nor does a journal that
// was cut off before its header.
TEST(LightFieldOnDisk, OneThatCouldNotBeginLeavesNothing) {
  const ScratchFolder scratch;
  if (const auto problem = test::MountSmallDisk(scratch.path(), 1 << 20)) GTEST_SKIP() << *problem;
  test::FillDisk(scratch / "filler");
  EXPECT_THROW(LightFieldWriter::Create(scratch / "lf", Header()), DiskFullError);
  EXPECT_FALSE(fs::exists(scratch / "lf"));
  fs::remove(scratch / "filler");
  fs::create_directories(scratch / "lf/images");
  std::ofstream(scratch / "lf/journal.jsonl") << "{\"event\":\"hea";
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  EXPECT_EQ(writer.AddView(NoiseFrame(1), ViewNumber(0)).id, 1);
}

// What an import brought, or a scan, no measurement of ours takes the place of.
TEST(LightFieldPoints, ImportedOnesAreKeptWhenReplaced) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  const std::string brought = ReadWholeFile(scratch / "lf/points.ply");
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  writer.SetPoints({});
  EXPECT_EQ(writer.Contents().points.size(), 2u) << "none is no better than some";
  writer.SetPoints({{{0, 0, 3}, {1, 2, 3}}});
  EXPECT_EQ(ReadLightField(scratch / "lf").points.size(), 1u);
  EXPECT_EQ(ReadWholeFile(scratch / "lf/kept/points.ply"), brought);
}

}  // namespace
}  // namespace ulf::light_field_test

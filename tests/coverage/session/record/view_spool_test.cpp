// Tests: coverage/session/record/view_spool, coverage/session/record/kept_photographs.
//
// The spool: order, masters before photographs, full disks and kills.
#include "coverage/session/record/view_spool.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <random>

#include "core/base/atomic_file.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/folder/view_images.h"
#include "tests/support/dng_file.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace {
// While positive: so many files may still be moved into unposed/, then the disk has no room for its folder.
// A real one grows by a block now and then.
std::atomic<int> moves_until_full{-1};
std::atomic<bool> refused{false};
}  // namespace

namespace {
bool RefusesMove(const char* to) {
  if (std::strstr(to, "/unposed/") == nullptr || moves_until_full < 0) return false;
  if (moves_until_full == 0) {
    refused = true;
    errno = ENOSPC;
    return true;
  }
  --moves_until_full;
  return false;
}
}  // namespace

// In place of the library's, which ask for nothing else.
extern "C" int rename(const char* from, const char* to) noexcept {
  return RefusesMove(to) ? -1 : renameat(AT_FDCWD, from, AT_FDCWD, to);
}
extern "C" int renameat2(int from_folder, const char* from, int to_folder, const char* to,
                         unsigned flags) noexcept {
  if (RefusesMove(to)) return -1;
  return static_cast<int>(syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

namespace ulf::test::view_spool_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const cv::Size kSize(320, 240);

CaptureHeader Header(cv::Size size = kSize) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(size.width, size.height, 400);
  return header;
}

// Even numbers have a master (a mosaic of 16 bits), odd ones are 8-bit sRGB and are encoded before they are
// recorded.
Frame FrameNumber(int i, bool with_master, cv::Size size = kSize) {
  Frame frame;
  frame.image.pixels.create(size, with_master ? CV_16UC1 : CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(i) + 1);
  random.fill(frame.image.pixels, cv::RNG::UNIFORM, 0, with_master ? 65536 : 256);
  if (with_master) frame.image.transfer = Transfer::kLinear, frame.image.mosaic = Mosaic::kRggb;
  frame.device_time_s = i;
  return frame;
}
Frame FrameNumber(int i) { return FrameNumber(i, i % 2 == 0); }

void Add(ViewSpool& spool, const Frame& frame) {
  while (!spool.TryAddView(frame, {})) std::this_thread::sleep_for(1ms);
}

LightFieldWriter Fill(const fs::path& dir, int views, bool threaded) {
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  writer.KeepMosaics(true);
  ViewSpool spool(std::move(writer), 16, threaded);
  for (int i = 0; i < views; ++i) {
    Add(spool, FrameNumber(i));
    if (i % 5 == 4) spool.NoteGap(i, i + 0.5, "between");
  }
  return spool.Finish();
}

// Also that what is encoded in several threads is recorded in order, and that lines stay where they were.
TEST(ViewSpool, ThreadsWriteTheSameBytesAsNone) {
  const ScratchFolder scratch;
  constexpr int kViews = 40;
  const LightFieldWriter with = Fill(scratch / "with", kViews, true),
                         without = Fill(scratch / "without", kViews, false);
  EXPECT_EQ(ReadWholeFile(scratch / "with/journal.jsonl"), ReadWholeFile(scratch / "without/journal.jsonl"));
  ASSERT_EQ(with.Contents().views.size(), static_cast<std::size_t>(kViews));
  for (const View& view : without.Contents().views) {
    EXPECT_EQ(view.device_time_s, view.id - 1) << "in order";
    EXPECT_EQ(ReadWholeFile(scratch / "with" / view.image_path),
              ReadWholeFile(scratch / "without" / view.image_path))
        << view.image_path;
    if (view.master_path.empty()) continue;
    EXPECT_EQ(ReadWholeFile(scratch / "with" / view.master_path),
              ReadWholeFile(scratch / "without" / view.master_path))
        << view.master_path;
  }
}

TEST(ViewSpool, AViewIsRecordedBeforeItsPhotographIsMade) {
  const ScratchFolder scratch;
  const cv::Size kLarge(2400, 1800);  // a photograph takes a quarter of a second
  constexpr std::size_t kViews = 5;
  ViewSpool spool(LightFieldWriter::Create(scratch / "lf", Header(kLarge)), 16, true);
  const Frame frame = FrameNumber(0, true, kLarge);
  for (std::size_t i = 0; i < kViews; ++i) Add(spool, frame);
  while (spool.ViewsWaiting() > 0) std::this_thread::sleep_for(1ms);
  EXPECT_GT(spool.PicturesWaiting(), 0u) << "photographs came as fast as masters: the test shows nothing";
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), kViews);
  const LightFieldWriter done = spool.Finish();
  for (const View& view : done.Contents().views)
    EXPECT_NO_THROW(ReadImageFile((scratch / "lf" / view.image_path).string())) << view.id;
}

// Also one whose photograph is just being made from its master.
TEST(ViewSpool, AViewThatIsTakenBackMovesWhole) {
  const ScratchFolder scratch;
  const cv::Size kLarge(2400, 1800);  // a photograph takes a quarter of a second
  ViewSpool spool(LightFieldWriter::Create(scratch / "lf", Header(kLarge)), 16, true);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(spool.AddView(FrameNumber(i, true, kLarge), {}), i + 1);
  while (spool.ViewsWaiting() > 0) std::this_thread::sleep_for(1ms);
  EXPECT_GT(spool.PicturesWaiting(), 0u) << "photographs came as fast as masters: the test shows nothing";
  spool.RemoveViews({1, 2, 6});
  EXPECT_EQ(spool.AddView(FrameNumber(6, true, kLarge), {}), 7) << "no id is given twice";
  spool.RemoveViews({7});  // still waiting
  const LightFieldWriter done = spool.Finish();
  EXPECT_FALSE(spool.Failure());
  ASSERT_EQ(done.Contents().views.size(), 3u);
  for (const int id : {1, 2, 6, 7})
    for (const char* ending : {".png", ".master.tif"})
      EXPECT_TRUE(fs::exists(scratch / "lf/unposed" / fmt::format("{:06}{}", id, ending))) << id << ending;
  for (const View& view : done.Contents().views) {
    EXPECT_EQ(view.device_time_s, view.id - 1);
    EXPECT_TRUE(fs::exists(scratch / "lf" / view.image_path)) << view.id;
  }
}

// The folder has room for one of the view's two files: the other follows when there is more, and the capture
// goes on.
TEST(ViewSpool, TakenBackViewMovesOnceThereIsRoom) {
  for (const bool threaded : {true, false}) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    {
      ViewSpool spool(LightFieldWriter::Create(dir, Header()), 16, threaded);
      Frame with_raw = FrameNumber(1, false);
      with_raw.raw = EncodedImage{".nef", std::make_shared<const std::string>("the camera's raw file")};
      for (const Frame& frame : {FrameNumber(0), with_raw, FrameNumber(2)}) spool.AddView(frame, {});
      while (spool.ViewsWaiting() > 0 || spool.PicturesWaiting() > 0) std::this_thread::sleep_for(1ms);
      refused = false;
      moves_until_full = 1;
      spool.RemoveViews({2});
      // The writer says so a moment after the disk did.
      while (!refused || !spool.Pause()) std::this_thread::sleep_for(1ms);
      moves_until_full = -1;
      spool.AddView(FrameNumber(3, true), {});
      const LightFieldWriter done = spool.Finish();
      EXPECT_FALSE(spool.Failure()) << *spool.Failure();
      EXPECT_EQ(done.Contents().views.size(), 3u);
    }
    EXPECT_TRUE(fs::exists(dir / "unposed/000002.png")) << threaded;
    EXPECT_TRUE(fs::exists(dir / "unposed/000002.master.nef")) << threaded;
    const std::string journal = ReadWholeFile(dir / "journal.jsonl");
    EXPECT_EQ(journal.find("remove"), journal.rfind("remove")) << "said once: " << journal;
    std::vector<int> ids;
    for (const View& view : ReadLightField(dir).views) ids.push_back(view.id);
    EXPECT_EQ(ids, (std::vector<int>{1, 3, 4})) << threaded;
  }
}

std::size_t FilesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

// Views and photographs wait for room, and are all there when it comes.
TEST(ViewSpool, WritesWhatWaitedOnceThereIsRoom) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 64 << 20)) GTEST_SKIP() << *problem;
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "lf", Header());
  ViewSpool spool(std::move(writer), 64, true);
  FillDisk(scratch / "ballast");
  for (int i = 0; i < 12; ++i) spool.AddView(FrameNumber(i), {});  // photographs are taken though it is full
  std::this_thread::sleep_for(500ms);
  EXPECT_TRUE(spool.Pause());
  EXPECT_FALSE(spool.Failure());
  EXPECT_EQ(spool.ViewsWaiting(), 12u);
  EXPECT_FALSE(spool.TryAddView(FrameNumber(12), {}));
  fs::remove(scratch / "ballast");
  const LightFieldWriter done = spool.Finish();
  EXPECT_FALSE(spool.Failure());
  EXPECT_EQ(spool.Unwritten(), 0u);
  EXPECT_EQ(done.Contents().views.size(), 12u);
  EXPECT_EQ(FilesIn(scratch / "lf/images"), 12u);
}

// As a card full of photographs may come at once when a camera's link is back.
TEST(ViewSpool, RawFilesWaitForRoomInTheirOrder) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 32 << 20)) GTEST_SKIP() << *problem;
  DngCamera sensor;
  const auto raw = [&](int i) {
    sensor.iso = 100 * (i + 1);
    return DngBytes(sensor, [](int, int) { return cv::Vec3d(0.2, 0.3, 0.4); });
  };
  ViewSpool spool(LightFieldWriter::Create(scratch / "lf", Header({96, 64})), 64, true);
  FillDisk(scratch / "ballast");
  constexpr int kCount = 5;
  for (int i = 0; i < kCount; ++i) {
    Frame still = FrameNumber(i, false, {96, 64});
    still.kind = FrameKind::kStill;
    still.raw = EncodedImage{".dng", std::make_shared<const std::string>(raw(i))};
    still.image = {DecodeRaw(*still.raw->bytes, "a.dng", RawQuality::kQuick).light, Transfer::kLinear};
    spool.AddView(still, {});
  }
  std::this_thread::sleep_for(300ms);
  EXPECT_TRUE(spool.Pause());
  for (const char* folder : {"images", "masters"})
    EXPECT_TRUE(!fs::exists(scratch / "lf" / folder) || FilesIn(scratch / "lf" / folder) == 0)
        << "nothing half";
  fs::remove(scratch / "ballast");
  const LightFieldWriter done = spool.Finish();
  EXPECT_FALSE(spool.Failure());
  ASSERT_EQ(done.Contents().views.size(), static_cast<std::size_t>(kCount));
  for (int i = 0; i < kCount; ++i) {
    const View& view = done.Contents().views[static_cast<std::size_t>(i)];
    EXPECT_EQ(ReadWholeFile(scratch / "lf" / view.master_path), raw(i));
    EXPECT_TRUE(fs::exists(scratch / "lf" / view.image_path));
  }
}

// What views show of points stands in the files that closing writes.
TEST(ViewSpool, KeepsRoomForWhatIsSaidOfPoints) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 16 << 20)) GTEST_SKIP() << *problem;
  ViewSpool spool(LightFieldWriter::Create(scratch / "lf", Header()), 16, false);
  ASSERT_TRUE(spool.TryAddView(FrameNumber(0), {}));
  spool.ExpectSeenPoints(700);
  EXPECT_FALSE(spool.Pause());
  spool.ExpectSeenPoints(200'000);
  ASSERT_TRUE(spool.Pause());
  EXPECT_TRUE(spool.Pause()->disk_is_full);
}

// Room for some of those that wait: these are recorded, the others are counted.
TEST(ViewSpool, FullDiskRecordsWhatFitsAndCountsTheRest) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 16 << 20)) GTEST_SKIP() << *problem;
  const cv::Size kLarge(1200, 800);  // a master has 5.8 MB, a photograph about half of that
  ViewSpool spool(LightFieldWriter::Create(scratch / "lf", Header(kLarge)), 64, true);
  for (int i = 0; i < 6; ++i) spool.AddView(FrameNumber(i, true, kLarge), {});
  {
    const LightFieldWriter done = spool.Finish();
    ASSERT_TRUE(spool.Failure());
    EXPECT_GE(done.Contents().views.size(), 1u);
    std::size_t somewhere = done.Contents().views.size();
    for (const auto& [folder, count] : spool.SetAside()) somewhere += count;  // a mosaic alone is smaller
    EXPECT_LT(somewhere, 6u);
    EXPECT_EQ(somewhere + spool.Unwritten(), 6u);
  }
  const LightField light_field = ReadLightField(scratch / "lf");
  for (const View& view : light_field.views) EXPECT_NO_THROW(ReadViewImage(light_field, view)) << view.id;
  for (const char* folder : {"images", "masters"})
    for (const auto& entry : fs::directory_iterator(scratch / "lf" / folder))
      EXPECT_NE(entry.path().extension(), kTemporaryEnding) << entry.path();
}

Frame Photograph(int i) {
  Frame frame = FrameNumber(i, false);
  frame.kind = FrameKind::kStill;
  frame.encoded =
      EncodedImage{".jpg", std::make_shared<const std::string>("the camera's file " + std::to_string(i))};
  return frame;
}

void PutAFileInTheWay(const fs::path& folder) {
  if (fs::exists(folder)) fs::rename(folder, folder.string() + ".before");
  std::ofstream(folder) << "in the way";
}

// The disk refuses views, then the folder for photographs without a pose, then the one beside the light
// field: every photograph is somewhere as long as there is somewhere, and else it is counted.
TEST(ViewSpool, AfterAFailureNothingVanishesUncounted) {
  for (const bool threaded : {true, false}) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf", unposed = dir / "unposed", beside = scratch / "lf.photographs";
    ViewSpool spool(LightFieldWriter::Create(dir, Header()), 16, threaded);
    int number = 0;
    const auto add_views = [&](int count) {
      for (int i = 0; i < count; ++i) spool.AddView(Photograph(++number), {});
      while (spool.ViewsWaiting() > 0) std::this_thread::sleep_for(1ms);
    };
    add_views(2);
    PutAFileInTheWay(dir / "images");
    add_views(3);
    ASSERT_TRUE(spool.Failure());
    EXPECT_EQ(FilesIn(unposed), 3u) << threaded;
    spool.KeepUnposed(Photograph(++number));
    add_views(1);  // after the failure, as those that were on their way when the capture ended
    EXPECT_EQ(FilesIn(unposed), 5u) << threaded;
    PutAFileInTheWay(unposed);
    spool.KeepUnposed(Photograph(++number));
    add_views(2);
    EXPECT_EQ(FilesIn(beside), 3u) << threaded;
    EXPECT_EQ(ReadWholeFile(beside / "000001.jpg"), "the camera's file 8");
    PutAFileInTheWay(beside);
    add_views(2);
    const LightFieldWriter done = spool.Finish();
    EXPECT_EQ(done.Contents().views.size(), 2u);
    EXPECT_EQ(spool.Unwritten(), 2u) << threaded;
    const std::map<fs::path, std::size_t> elsewhere{{unposed, 4}, {beside, 3}};
    EXPECT_EQ(spool.SetAside(), elsewhere) << "the one for unposed/ that is there is at its place";
  }
}

// images/ cannot be written, masters/ can.
TEST(ViewSpool, UnmakeablePhotographHoldsNothingUp) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  constexpr int kViews = 20;
  {
    ViewSpool spool(LightFieldWriter::Create(dir, Header()), 4, true);
    PutAFileInTheWay(dir / "images");
    for (int i = 0; i < kViews; ++i) Add(spool, FrameNumber(i, true));
    const LightFieldWriter done = spool.Finish();
    EXPECT_FALSE(spool.Failure()) << *spool.Failure();
    EXPECT_EQ(done.Contents().views.size(), static_cast<std::size_t>(kViews));
    EXPECT_EQ(spool.Unwritten(), 0u);
  }
  fs::remove(dir / "images");
  fs::create_directory(dir / "images");
  LightFieldWriter::Resume(dir);
  EXPECT_EQ(FilesIn(dir / "images"), static_cast<std::size_t>(kViews)) << "made by the next writer";
}

// What the journal names is whole after a kill at any moment, photographs included.
TEST(ViewSpool, SurvivesSigkillAtAnyMoment) {
  std::mt19937 random(5);
  std::size_t total = 0;
  for (int round = 0; round < 12; ++round) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    const pid_t child = fork();
    if (child == 0) {
      ViewSpool spool(LightFieldWriter::Create(dir, Header()), 16, true);
      for (int i = 0;; ++i) Add(spool, FrameNumber(i));
    }
    while (!fs::exists(dir / "journal.jsonl") || fs::file_size(dir / "journal.jsonl") == 0) usleep(500);
    usleep(std::uniform_int_distribution<useconds_t>(0, 300000 * (kIsSanitized ? 4 : 1))(random));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "round " << round;
    const LightField killed = ReadLightField(dir);
    for (const View& view : killed.views)
      EXPECT_NO_THROW(ReadViewImage(killed, view)) << "round " << round << ", " << view.id;
    Repair(dir);
    for (std::size_t i = 0; i < killed.views.size(); ++i) {
      const View& view = killed.views[i];
      EXPECT_EQ(view.device_time_s, static_cast<double>(i))
          << "round " << round << ": none is missing between";
      EXPECT_NO_THROW(ReadImageFile((dir / view.image_path).string()))
          << "round " << round << ", " << view.id;
      EXPECT_NO_THROW(ReadViewMaster(killed, view)) << "round " << round << ", " << view.id;
    }
    total += killed.views.size();
  }
  EXPECT_GT(total, 60u) << "the kills came before anything was recorded: the test shows nothing";
}

}  // namespace
}  // namespace ulf::test::view_spool_test

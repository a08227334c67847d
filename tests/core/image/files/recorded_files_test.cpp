// Tests: core/image/files/tiff_file, core/base/atomic_file.
//
// Files as they come to the disk: several at once, all or none; pictures that every reader opens.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <opencv2/core.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/tiff_file.h"
#include "core/image/image.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::test::recorded_files_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

cv::Mat Noise(int type, cv::Size size) {
  cv::Mat pixels(size, type);
  cv::RNG random(static_cast<std::uint64_t>(type + size.width));
  random.fill(pixels, cv::RNG::UNIFORM, 0,
              pixels.depth() == CV_8U    ? 256
              : pixels.depth() == CV_16U ? 65536
                                         : 2);
  return pixels;
}

void Write(const fs::path& path, const FileContent& content) {
  FileBatch batch;
  batch.Write(path, content);
  batch.Commit();
}

std::size_t FilesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

// The largest go to the disk in several pieces that end inside a pixel.
TEST(TiffFile, IsReadBackAsItWas) {
  const ScratchFolder scratch;
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3, CV_32FC1, CV_32FC3})
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(37, 23), cv::Size(640, 481), cv::Size(1501, 1103)}) {
      const cv::Mat pixels = Noise(type, size);
      const fs::path path = scratch / "picture.tif";
      Write(path, TiffContent(pixels));
      const cv::Mat read = ReadImageFile(path.string());
      ASSERT_EQ(read.type(), type) << size;
      ASSERT_EQ(read.size(), size) << type;
      EXPECT_EQ(cv::norm(read, pixels, cv::NORM_INF), 0) << "type " << type << ", " << size;
    }
}

TEST(TiffFile, APartOfAPictureIsReadBack) {
  const ScratchFolder scratch;
  const cv::Mat part = Noise(CV_16UC3, {300, 200})(cv::Rect(17, 31, 111, 77));
  Write(scratch / "part.tif", TiffContent(part));
  EXPECT_EQ(cv::norm(ReadImageFile((scratch / "part.tif").string()), part, cv::NORM_INF), 0);
}

TEST(TiffFile, PixelsOutliveTheirFirstOwner) {
  const ScratchFolder scratch;
  cv::Mat pixels = Noise(CV_16UC1, {64, 48});
  const cv::Mat copy = pixels.clone();
  const FileContent content = TiffContent(pixels);
  pixels.release();
  Write(scratch / "picture.tif", content);
  EXPECT_EQ(cv::norm(ReadImageFile((scratch / "picture.tif").string()), copy, cv::NORM_INF), 0);
}

TEST(TiffFile, OneThatIsCutIsNoPicture) {
  const ScratchFolder scratch;
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    const fs::path path = scratch / "picture.tif";
    Write(path, TiffContent(Noise(type, {640, 480})));
    for (const double share : {0.001, 0.5, 0.999}) {
      fs::resize_file(path, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(path))));
      EXPECT_THROW(ReadImageFile(path.string()), Error) << "type " << type << ", " << share << " of it";
      Write(path, TiffContent(Noise(type, {640, 480})));
    }
  }
}

TEST(TiffFile, RefusesWhatItCannotHold) {
  for (const int type : {CV_8UC2, CV_8UC4, CV_64FC1, CV_16SC1})
    EXPECT_THROW(TiffContent(cv::Mat(4, 4, type, cv::Scalar(0))), Error) << type;
  EXPECT_THROW(TiffContent(cv::Mat()), Error);
}

TEST(FileBatch, ADeviceIsWrittenToAndNotReplaced) {
  const test::ScratchFolder scratch;
  const fs::path pipe = scratch / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { std::ifstream(pipe) >> read; });
  WriteFileAtomically(pipe, "poses");
  reader.join();
  EXPECT_EQ(read, "poses");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(FileBatch, AllFilesGetTheirNamesTogether) {
  const ScratchFolder scratch;
  const std::string large(1'000'003, 'x'), small = "small";
  FileBatch batch;
  batch.Write(scratch / "a", ContentOf(large));
  batch.Write(scratch / "b", ContentOf(small));
  batch.Write(scratch / "c", ContentOf(""));
  EXPECT_FALSE(fs::exists(scratch / "a"));
  EXPECT_FALSE(fs::exists(scratch / "b"));
  batch.Commit();
  EXPECT_EQ(ReadWholeFile(scratch / "a"), large);
  EXPECT_EQ(ReadWholeFile(scratch / "b"), small);
  EXPECT_EQ(fs::file_size(scratch / "c"), 0u);
  EXPECT_EQ(FilesIn(scratch.path()), 3u) << "no temporary names stay";

  batch.Write(scratch / "d", ContentOf(small));  // a new batch
  batch.TakeBack();
  EXPECT_EQ(FilesIn(scratch.path()), 3u);
}

TEST(FileBatch, WithNothingNewLeavesTheLastOneAlone) {
  const ScratchFolder scratch;
  FileBatch batch;
  batch.Write(scratch / "a", ContentOf("first"));
  batch.Commit();
  batch.Commit();
  batch.TakeBack();
  EXPECT_EQ(ReadWholeFile(scratch / "a"), "first");
}

TEST(FileBatch, OneThatIsNotCommittedLeavesNothing) {
  const ScratchFolder scratch;
  const std::string bytes(300'000, 'x');
  {
    FileBatch batch;
    batch.Write(scratch / "a", ContentOf(bytes));
    EXPECT_EQ(FilesIn(scratch.path()), 1u);
  }
  EXPECT_EQ(FilesIn(scratch.path()), 0u);
  FileBatch batch;
  batch.Write(scratch / "a", ContentOf(bytes));
  batch.Commit();
  batch.TakeBack();
  EXPECT_EQ(FilesIn(scratch.path()), 0u) << "also when it had its name";
}

TEST(FileBatch, AFileInTheWayTakesTheWholeBatchBack) {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "b" / "in the way");
  const std::string bytes(300'000, 'x');
  FileBatch batch;
  batch.Write(scratch / "a", ContentOf(bytes));
  batch.Write(scratch / "b", ContentOf(bytes));
  EXPECT_THROW(batch.Commit(), Error);
  EXPECT_FALSE(fs::exists(scratch / "a"));
  EXPECT_EQ(FilesIn(scratch.path()), 1u);
}

// Two programs that open a light field which was killed make the same photographs.
TEST(FileBatch, TwoThatWriteTheSameFileDoNotMix) {
  const ScratchFolder scratch;
  const std::string first(300'000, '1'), second(200'000, '2');
  FileBatch one, two;
  one.Write(scratch / "a", ContentOf(first));
  two.Write(scratch / "a", ContentOf(second));
  one.Commit();
  EXPECT_EQ(ReadWholeFile(scratch / "a"), first);
  EXPECT_NO_THROW(two.Commit());
  EXPECT_EQ(ReadWholeFile(scratch / "a"), second);
  EXPECT_EQ(FilesIn(scratch.path()), 1u);
}

TEST(FileBatch, ReplacedFilesAreNotTakenBack) {
  const ScratchFolder scratch;
  std::ofstream(scratch / "a") << "old";
  fs::create_directories(scratch / "c" / "in the way");
  {
    FileBatch batch;
    for (const char* name : {"a", "b", "c"}) batch.Write(scratch / name, ContentOf("new"));
    EXPECT_THROW(batch.Commit(), Error);
  }
  EXPECT_EQ(ReadWholeFile(scratch / "a"), "new") << "the old one is gone";
  EXPECT_FALSE(fs::exists(scratch / "b"));
  EXPECT_EQ(FilesIn(scratch.path()), 2u);
}

// Files may be made in it, but it cannot be opened: known before anything is replaced.
TEST(FileBatch, UnsyncableFolderKeepsTheOldFile) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "folder";
  fs::create_directory(folder);
  std::ofstream(folder / "calibration.json") << "old";
  fs::permissions(folder, fs::perms::owner_write | fs::perms::owner_exec);
  constexpr uid_t kNobody = 65534;  // for root every folder can be opened
  if (getuid() == 0) {
    fs::permissions(scratch.path(), fs::perms::group_exec | fs::perms::others_exec, fs::perm_options::add);
    for (const fs::path& path : {folder, folder / "calibration.json"})
      ASSERT_EQ(chown(path.c_str(), kNobody, kNobody), 0);
  }
  EXPECT_EXIT(
      {
        if (getuid() == 0 && seteuid(kNobody) != 0) _exit(3);
        try {
          WriteFileAtomically(folder / "calibration.json", "new");
        } catch (const Error& error) {
          std::fputs(error.what(), stderr);
          _exit(0);
        }
        _exit(1);
      },
      ::testing::ExitedWithCode(0), "cannot open the folder");
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(ReadWholeFile(folder / "calibration.json"), "old");
  EXPECT_EQ(FilesIn(folder), 1u);
}

TEST(FileBatch, FullDiskTakesBackOnlyItsFile) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 8 << 20)) GTEST_SKIP() << *problem;
  const std::string bytes(3 << 20, 'x');
  FileBatch batch;
  batch.Write(scratch / "a", ContentOf(bytes));
  batch.Write(scratch / "b", ContentOf(bytes));
  EXPECT_THROW(batch.Write(scratch / "c", ContentOf(bytes)), DiskFullError);
  EXPECT_EQ(FilesIn(scratch.path()), 2u);
  batch.Commit();
  EXPECT_EQ(ReadWholeFile(scratch / "b"), bytes);
}

TEST(FileBatch, WritesAllFilesOrNone) {
  const ScratchFolder scratch;
  const std::string bytes(300'000, 'x');
  FileBatch batch;
  batch.Write(scratch / "before", ContentOf(bytes));
  const FileContent broken{10, [](std::uint64_t, std::span<char>) { throw Error("no memory"); }};
  const std::vector<std::pair<fs::path, FileContent>> together = {{scratch / "a", ContentOf(bytes)},
                                                                  {scratch / "b", broken}};
  EXPECT_THROW(batch.Write(together), Error);
  EXPECT_EQ(FilesIn(scratch.path()), 1u);
  batch.Commit();
  EXPECT_TRUE(fs::exists(scratch / "before"));
}

TEST(FileBatch, ContentThatCannotBeMadeLeavesNothing) {
  const ScratchFolder scratch;
  FileBatch batch;
  const FileContent broken{1'000'000, [](std::uint64_t, std::span<char>) { throw Error("no memory"); }};
  EXPECT_THROW(batch.Write(scratch / "a", broken), Error);
  EXPECT_EQ(FilesIn(scratch.path()), 0u);
}

TEST(AtomicFile, TheNextWriterRemovesWhatAKilledOneLeft) {
  const ScratchFolder scratch;
  const pid_t dead = fork();
  if (dead == 0) _exit(0);
  waitpid(dead, nullptr, 0);
  const std::string mark = ProcessMark(), computer = mark.substr(0, mark.find('-'));
  const std::string left = fmt::format("report.txt.{}-{}-1.part", computer, dead);
  const std::vector<std::string> others{
      fmt::format("report.txt.{}-9.part", mark),           // may still be written
      fmt::format("report.txt.00c0ffee-{}-1.part", dead),  // on another computer, too
      fmt::format("report.txt.{}-1.part", dead),           // by an older program, of any computer
      fmt::format("other.txt.{}-{}-1.part", computer, dead),
      fmt::format("report.txt.{}-{}-1.part.txt", computer, dead),
      "report.txt.part"};
  std::ofstream(scratch / left) << "half";
  for (const std::string& name : others) std::ofstream(scratch / name) << "half";
  WriteFileAtomically(scratch / "report.txt", "new");
  EXPECT_FALSE(fs::exists(scratch / left));
  for (const std::string& name : others) EXPECT_TRUE(fs::exists(scratch / name)) << name;
  EXPECT_EQ(ReadWholeFile(scratch / "report.txt"), "new");
}

}  // namespace
}  // namespace ulf::test::recorded_files_test

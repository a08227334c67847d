// Tests: core/light_field/exchange/readers/tum_set, core/light_field/exchange/read_posed_set.
//
// Sets in the layout of the TUM RGB-D benchmark, written here: that poses are those of the
// photographs' times, whose intrinsics are whose, and what is said of files that are damaged or belong
// to other photographs.
#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/set_format.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::tum_set_test {
namespace {

using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr double kStartS = 1305031102.175304;

// Turns and moves evenly, so that between any two of its poses it is where interpolation puts it.
Rigid3 MotionAt(double time_s) {
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(0.8 * (time_s - kStartS), Eigen::Vector3d(0.1, 1, 0.2).normalized()));
  const Eigen::Vector3d center =
      Eigen::Vector3d(0.3, -0.1, 0.2) * (time_s - kStartS) + Eigen::Vector3d(1, 2, 3);
  return Rigid3{turn, center}.Inverse();
}

std::string PoseLine(double time_s, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Eigen::Vector3d& t = world_from_cam.translation;
  const Eigen::Quaterniond& q = world_from_cam.rotation;
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", time_s, t.x(),
                     t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

class TumSet : public testing::Test {
 protected:
  fs::path set() const { return scratch_ / "set"; }
  void Write(const std::string& file, const std::string& text) const {
    fs::create_directories(set());
    std::ofstream(set() / file) << text;
  }
  void WritePhotograph(const std::string& name, const cv::Size& size = {kWidth, kHeight}) const {
    fs::create_directories((set() / name).parent_path());
    cv::imwrite((set() / name).string(), cv::Mat(size, CV_8UC3, cv::Scalar(10, 20, 30)));
  }
  static std::string NameAt(double time_s) { return fmt::format("rgb/{:.6f}.png", time_s); }
  // Photographs and poses of MotionAt(), as far apart as given, from kStartS on; with the benchmark's head.
  void WriteMotion(const std::vector<double>& photographs_s, const std::vector<double>& poses_s) const {
    std::string list = "# color images\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n# timestamp filename\n";
    for (const double after_s : photographs_s) {
      WritePhotograph(NameAt(kStartS + after_s));
      list += fmt::format("{:.6f} {}\n", kStartS + after_s, NameAt(kStartS + after_s));
    }
    std::string poses = "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n";
    for (const double after_s : poses_s) poses += PoseLine(kStartS + after_s, MotionAt(kStartS + after_s));
    Write("rgb.txt", list);
    Write("groundtruth.txt", poses);
  }
  LightField Read() const { return ReadPosedSet(set(), {}, {}, camera_).light_field; }
  void ExpectRefused(const std::string& first, const std::string& second) const {
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr(first), HasSubstr(second))));
  }
  ScratchFolder scratch_;
  CameraModel camera_ = CameraModel::Pinhole(kWidth, kHeight, 60);
};

TEST_F(TumSet, PosesAndIntrinsicsComeBack) {
  const LightField written = WriteSample(scratch_ / "written", 6);
  std::string list, poses;
  for (const View& view : written.views) {
    const double time_s = kStartS + view.device_time_s;
    fs::create_directories(set() / "rgb");
    fs::copy(written.root / view.image_path, set() / NameAt(time_s));
    list += fmt::format("{:.17g} {}\r\n", time_s, NameAt(time_s));
    // As its poses come: more of them than photographs.
    poses += PoseLine(time_s, view.cam_from_world) + PoseLine(time_s + 0.03, ViewNumber(9).cam_from_world);
  }
  Write("rgb.txt", "\xEF\xBB\xBF" + list);
  Write("groundtruth.txt", "\xEF\xBB\xBF" + poses);
  const CameraModel& camera = written.cameras.at(0);
  std::ofstream(scratch_ / "camera.txt")
      << fmt::format("{} {} {} {} {} {} {} {} {} {}\n", camera.fx, camera.fy, camera.cx - 0.5,
                     camera.cy - 0.5, camera.coefficients[0], camera.coefficients[1], camera.coefficients[2],
                     camera.coefficients[3], camera.width, camera.height);
  const std::string command = "import " + set().string() + " -o " + (scratch_ / "read").string();
  const auto run = test::RunUlf(command + " --calibration " + (scratch_ / "camera.txt").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("TUM RGB-D, 6 views, 1 camera"));
  const LightField read = ReadLightField(scratch_ / "read");
  EXPECT_EQ(read.units, "metres");
  EXPECT_THAT(read.cameras, ElementsAre(camera));
  ASSERT_EQ(read.views.size(), written.views.size());
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const View &a = read.views[i], &b = written.views[i];
    EXPECT_LT((a.cam_from_world.Matrix() - b.cam_from_world.Matrix()).norm(), 1e-9) << a.image_path;
    EXPECT_NEAR(a.device_time_s, kStartS + b.device_time_s, 1e-6);
    EXPECT_EQ(ReadWholeFile(read.root / a.image_path), ReadWholeFile(written.root / b.image_path))
        << a.image_path;
  }
}

TEST_F(TumSet, APoseIsThatOfThePhotographsTime) {
  std::vector<double> poses_s;
  for (int i = 0; i < 40; ++i) poses_s.push_back(0.01 * i);       // 0 to 0.39
  for (int i = 0; i < 4; ++i) poses_s.push_back(1 + 0.0999 * i);  // 1 to 1.2997
  WriteMotion({0.0149, 0.1, 0.3333, 0.38999, 1.05, 1.29}, poses_s);
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 6u);
  for (const View& view : read.views)
    EXPECT_LT((view.cam_from_world.Matrix() - MotionAt(view.device_time_s).Matrix()).norm(), 1e-6)
        << view.image_path;
  EXPECT_THAT(read.doubts, IsEmpty());
}

TEST_F(TumSet, InAGapANearPoseIsTakenAndNoOther) {
  // Before the first, in a gap (near its beginning, in its middle, near its end), after the last.
  WriteMotion({-0.021, -0.019, 0.519, 0.53, 0.7, 0.981, 1.019, 1.021}, {0, 0.1, 0.2, 0.3, 0.4, 0.5, 1});
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 4u);
  const std::vector<double> nearest_s = {0, 0.5, 1, 1};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((read.views[i].cam_from_world.Matrix() - MotionAt(kStartS + nearest_s[i]).Matrix()).norm(),
              1e-9)
        << i;
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("4 photographs without a pose at its time"),
                                             HasSubstr(NameAt(kStartS - 0.021)))));
}

TEST_F(TumSet, LinesMayComeInAnyOrder) {
  const std::vector<double> sorted_s = {0.05, 0.1, 0.15, 0.25};
  WriteMotion({0.25, 0.05, 0.15, 0.1}, {0.3, 0, 0.2, 0.1});
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const View& view = read.views[i];
    EXPECT_EQ(view.id, static_cast<int>(i) + 1);
    EXPECT_EQ(view.image_path, NameAt(view.device_time_s));
    EXPECT_NEAR(view.device_time_s, kStartS + sorted_s[i], 1e-6);
    EXPECT_LT((view.cam_from_world.Matrix() - MotionAt(view.device_time_s).Matrix()).norm(), 1e-6);
  }
}

TEST_F(TumSet, ReportsWhatIsNotUsed) {
  WriteMotion({0, 0.1, 0.2}, {0, 0.1, 0.2});
  fs::remove(set() / NameAt(kStartS + 0.1));
  Write("depth.txt", "# depth maps\n");
  EXPECT_THAT(Read().doubts,
              ElementsAre(AllOf(HasSubstr("1 photograph of rgb.txt"), HasSubstr(NameAt(kStartS + 0.1))),
                          HasSubstr("depth images are not used")));
  fs::remove(set() / NameAt(kStartS));
  fs::remove(set() / NameAt(kStartS + 0.2));
  WritePhotograph("rgb/another.png");
  ExpectRefused("3 of its 3 photographs are not in", "with images");
}

TEST_F(TumSet, PhotographsMayLieElsewhereOrBeResized) {
  WriteMotion({0, 0.1}, {0, 0.1});
  fs::create_directories(scratch_ / "else");
  for (const double after_s : {0.0, 0.1})
    fs::rename(set() / NameAt(kStartS + after_s),
               scratch_ / "else" / fs::path(NameAt(kStartS + after_s)).filename());
  EXPECT_EQ(ReadPosedSet(set() / "rgb.txt", {}, scratch_ / "else", camera_).light_field.views.size(), 2u);
  camera_ = CameraModel::Pinhole(2 * kWidth, 2 * kHeight, 120);
  const LightField half = ReadPosedSet(set(), SetFormat::kTum, scratch_ / "else", camera_).light_field;
  EXPECT_THAT(half.cameras, ElementsAre(CameraModel::Pinhole(kWidth, kHeight, 60)));
  EXPECT_THAT(half.doubts, ElementsAre(HasSubstr("resized")));
  camera_ = CameraModel::Pinhole(kWidth, kHeight + 4, 60);
  EXPECT_THAT([&] { ReadPosedSet(set(), {}, scratch_ / "else", camera_); },
              ThrowsMessage<Error>(AllOf(HasSubstr("rgb.txt, line 4"), HasSubstr("cropped or turned"))));
}

TEST_F(TumSet, OneGivesTheIntrinsics) {
  WriteMotion({0, 0.1}, {0, 0.1});
  EXPECT_THAT(FormatsIn(set()), ElementsAre(SetFormat::kTum));
  EXPECT_THAT([&] { ReadPosedSet(set(), {}, {}); },
              ThrowsMessage<Refusal>(AllOf(HasSubstr("calibration FILE"), HasSubstr("ulf calibrate"))));
  EXPECT_EQ(test::RunUlf("import " + set().string() + " -o " + (scratch_ / "lf").string()).exit_code, 2);
  Write("poses_bounds.npy", "");
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Refusal>(AllOf(HasSubstr("read as llff"), HasSubstr("leave the option out"))));
  EXPECT_THAT(ReadPosedSet(set(), SetFormat::kTum, {}, camera_).light_field.views.size(), 2u);
  fs::remove(set() / "poses_bounds.npy");
  fs::remove(set() / "groundtruth.txt");
  EXPECT_THAT(FormatsIn(set()), IsEmpty());
}

TEST_F(TumSet, DamagedFilesAreRefused) {
  WriteMotion({0, 0.1}, {0, 0.1});
  const std::string list = ReadWholeFile(set() / "rgb.txt"), poses = ReadWholeFile(set() / "groundtruth.txt");
  for (const char* line :
       {"1305031102.3", "soon rgb/a.png", "nan rgb/a.png", "1e999 rgb/a.png", "rgb/a.png 1305031102.3"}) {
    Write("rgb.txt", list + line + "\n");
    ExpectRefused("rgb.txt, line 6", line);
  }
  Write("rgb.txt", "# color images\n");
  ExpectRefused("rgb.txt", "names no photograph");
  Write("rgb.txt", list + fmt::format("{:.6f} ./{}\n", kStartS + 0.05, NameAt(kStartS)));
  ExpectRefused("rgb.txt, lines 4 and 6", "both lead to");
  Write("rgb.txt", list);
  for (const char* line :
       {"1305031103 1 2 3 0 0 0", "1305031103 1 2 3 0 0 0 2", "1305031103 1 2 nan 0 0 0 1"}) {
    Write("groundtruth.txt", poses + line + "\n");
    ExpectRefused("groundtruth.txt:5", "");
  }
  Write("groundtruth.txt", "# nothing\n");
  ExpectRefused("groundtruth.txt", "holds no pose");
}

TEST_F(TumSet, TimesOfTwoRecordingsAreNamed) {
  WriteMotion({0, 0.1}, {5, 6});
  ExpectRefused("1305031102.175304 to 1305031102.275304", "1305031107.175304 to 1305031108.175304");
}

TEST_F(TumSet, NamesStayInTheFolder) {
  WriteMotion({0, 0.1}, {0, 0.1});
  WritePhotograph("../outside.png");
  fs::create_symlink(scratch_ / "outside.png", set() / "rgb/link.png");
  fs::create_symlink(scratch_ / "outside.png", set() / "another_ending.png");
  const std::string list = ReadWholeFile(set() / "rgb.txt");
  for (const std::string& name :
       {std::string("../outside.png"), std::string("rgb/../../outside.png"), std::string("rgb/link.png"),
        std::string("another_ending.jpg"), (scratch_ / "outside.png").string()}) {
    Write("rgb.txt", list + fmt::format("{:.6f} {}\n", kStartS + 0.05, name));
    ExpectRefused("rgb.txt, line 6", "leaves the folder");
  }
}

TEST_F(TumSet, ARealRecordingFitsItsPoses) {
  ULF_NEED_TEST_DATA(kitchen, "handheld_kitchen");
  const std::vector<TimedPose> truth = ReadTum(kitchen / "colmap_reference.txt");
  fs::create_directories(set() / "rgb");
  std::string list;
  for (int frame = 0; frame < 120; frame += 12) {
    const std::string name = fmt::format("frame-{:06}.color.jpg", frame);
    fs::copy(kitchen / name, set() / "rgb" / name);
    list += fmt::format("{:.6f} rgb/{}\n", frame / 30.0, name);
  }
  Write("rgb.txt", list);
  fs::copy(kitchen / "colmap_reference.txt", set() / "groundtruth.txt");
  const auto run =
      test::RunUlf("import " + set().string() + " --calibration " + (kitchen / "intrinsics.txt").string() +
                   " --subject 0,0,1,0.3 -o " + (scratch_ / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("the photographs fit the poses of 10 views"));
  const LightField read = ReadLightField(scratch_ / "lf");
  ASSERT_EQ(read.views.size(), 10u);
  EXPECT_NEAR(read.cameras.at(0).cx, 320.5, 1e-9);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_LT((read.views[i].cam_from_world.Matrix() - truth.at(i).cam_from_world.Matrix()).norm(), 1e-6)
        << i;
}

}  // namespace
}  // namespace ulf::tum_set_test

// Tests: core/light_field/exchange/readers/bundler_set.
//
// Bundler's files, written here after its manual: that cameras, points and observations come back as they
// were, and what is said of files that are damaged or belong to other photographs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "tests/support/test_paths.h"

namespace ulf::bundler_set_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

struct BundledCamera {
  double f = 100, k1 = 0, k2 = 0;
  Matrix3d rotation = Matrix3d::Identity();  // as in the file: looks along -z, y up
  Vector3d translation = Vector3d::Zero();
  int width = 96, height = 64;

  // The manual's equations.
  Vector2d Project(const Vector3d& point) const {
    const Vector3d in_cam = rotation * point + translation;
    const Vector2d p = -in_cam.head<2>() / in_cam.z();
    return f * (1 + k1 * p.squaredNorm() + k2 * p.squaredNorm() * p.squaredNorm()) * p;
  }
};

class BundlerSet : public testing::Test {
 protected:
  BundlerSet() {
    cv::RNG random(7);
    for (int i = 0; i < 4; ++i) {
      BundledCamera& camera = cameras_.emplace_back();
      camera.f = 90 + 5 * (i / 2);
      if (i >= 2) {
        camera.k1 = -0.11;
        camera.k2 = 0.03;
        camera.height = 80;
      }
      // Looks at about (0, 0, 0) from 4 units.
      camera.rotation = (Eigen::AngleAxisd(0.2 * i - 0.3, Vector3d::UnitY()) *
                         Eigen::AngleAxisd(0.1 * i, Vector3d(1, 0.2, 0.5).normalized()))
                            .toRotationMatrix();
      camera.translation = {0.05 * i, -0.03 * i, -4};
      names_.push_back("photo_" + std::to_string(i) + ".png");
    }
    for (int i = 0; i < 20; ++i)
      points_.emplace_back(random.uniform(-0.9, 0.9), random.uniform(-0.7, 0.7), random.uniform(-0.5, 0.5));
  }

  static void WritePhotograph(const fs::path& file, int width, int height) {
    fs::create_directories(file.parent_path());
    cv::imwrite(file.string(), cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 20, 30)));
  }
  void WritePhotographs(const fs::path& folder) const {
    for (std::size_t i = 0; i < names_.size(); ++i)
      WritePhotograph(folder / names_[i], cameras_[i].width, cameras_[i].height);
  }
  static void Write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }

  std::string List() const {
    std::string text;
    for (const std::string& name : names_) text += name + "\n";
    return text;
  }

  std::string Bundle() const {
    std::string text = fmt::format("# Bundle file v0.3\n{} {}\n", cameras_.size(), points_.size());
    for (const BundledCamera& camera : cameras_) {
      text += fmt::format("{} {} {}\n", camera.f, camera.k1, camera.k2);
      for (int row = 0; row < 3; ++row)
        text += fmt::format("{} {} {}\n", camera.rotation(row, 0), camera.rotation(row, 1),
                            camera.rotation(row, 2));
      text +=
          fmt::format("{} {} {}\n", camera.translation.x(), camera.translation.y(), camera.translation.z());
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      text += fmt::format("{} {} {}\n{} 7 9\n", points_[i].x(), points_[i].y(), points_[i].z(), 10 * i);
      std::string seen;
      int count = 0;
      for (std::size_t c = 0; c < cameras_.size(); ++c) {
        if (cameras_[c].f == 0) continue;
        const Vector2d at = cameras_[c].Project(points_[i]);
        seen += fmt::format(" {} {} {:.6f} {:.6f}", c, i, at.x(), at.y());
        ++count;
      }
      text += fmt::format("{}{}\n", count, seen);
    }
    return text;
  }

  // The whole set in one folder.
  void WriteAll() {
    WritePhotographs(scratch_.path());
    Write(scratch_ / "list.txt", List());
    Write(scratch_ / "bundle.out", Bundle());
  }
  PosedSet Read() { return ReadBundlerSet(scratch_ / "bundle.out", {}); }
  void ExpectError(const std::string& first, const std::string& second) {
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr(first), HasSubstr(second))));
  }
  // With `from` in the file replaced.
  void ExpectErrorWith(const std::string& from, const std::string& to, const std::string& first,
                       const std::string& second) {
    std::string text = Bundle();
    ASSERT_NE(text.find(from), std::string::npos) << from;
    Write(scratch_ / "bundle.out", text.replace(text.find(from), from.size(), to));
    ExpectError(first, second);
  }

  ScratchFolder scratch_;
  std::vector<BundledCamera> cameras_;
  std::vector<std::string> names_;
  std::vector<Vector3d> points_;
};

TEST_F(BundlerSet, CamerasPointsAndTracksComeBack) {
  WriteAll();
  const PosedSet set = Read();
  const LightField& read = set.light_field;
  EXPECT_EQ(set.format, "Bundler");
  EXPECT_EQ(read.units, "arbitrary");
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_EQ(read.cameras.size(), 2u);
  for (std::size_t i = 0; i < 4; ++i) {
    const View& view = read.views[i];
    EXPECT_EQ(view.id, static_cast<int>(i) + 1);
    EXPECT_EQ(view.image_path, names_[i]);
    EXPECT_TRUE(fs::exists(read.root / view.image_path));
    const CameraModel& camera = read.CameraOf(view);
    EXPECT_EQ(camera.width, cameras_[i].width);
    EXPECT_EQ(camera.height, cameras_[i].height);
    EXPECT_EQ(camera.fx, cameras_[i].f);
    EXPECT_EQ(2 * camera.cx, camera.width);
    EXPECT_EQ(2 * camera.cy, camera.height);
    EXPECT_EQ(camera.distortion, i < 2 ? Distortion::kNone : Distortion::kRadialTangential);
    const Vector3d center = -cameras_[i].rotation.transpose() * cameras_[i].translation;
    EXPECT_LT((view.CenterInWorld() - center).norm(), 1e-9);
    // Backwards is z in the file, upwards y.
    EXPECT_LT(
        (view.cam_from_world.DirectionInSource({0, 0, -1}) - cameras_[i].rotation.row(2).transpose()).norm(),
        1e-9);
    EXPECT_LT(
        (view.cam_from_world.DirectionInSource({0, -1, 0}) - cameras_[i].rotation.row(1).transpose()).norm(),
        1e-9);
  }
  ASSERT_EQ(read.points.size(), points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ScenePoint& point = read.points[i];
    EXPECT_LT((point.position_in_world - points_[i]).norm(), 1e-9);
    EXPECT_EQ(point.rgb, (std::array<std::uint8_t, 3>{static_cast<std::uint8_t>(10 * i), 7, 9}));
    EXPECT_LT(point.error_px, 1e-3);
    ASSERT_EQ(point.track.size(), 4u);
    for (const ViewObservation& seen : point.track) {
      const View& view = read.views[static_cast<std::size_t>(seen.view_id - 1)];
      const auto in_img = read.CameraOf(view).ImgFromCam(view.cam_from_world * points_[i]);
      ASSERT_TRUE(in_img);
      EXPECT_LT((*in_img - seen.in_img).norm(), 1e-3);
      // From the middle, y up.
      const BundledCamera& camera = cameras_[static_cast<std::size_t>(seen.view_id - 1)];
      const Vector2d given = camera.Project(points_[i]);
      EXPECT_LT(
          (seen.in_img - Vector2d(camera.width / 2.0 + given.x(), camera.height / 2.0 - given.y())).norm(),
          1e-5);
    }
  }
}

TEST_F(BundlerSet, LeavesOutUnregisteredOrEmptyCameras) {
  cameras_[1] = {0, 0, 0, Matrix3d::Zero()};
  WriteAll();
  fs::remove(scratch_ / names_[3]);
  const LightField read = Read().light_field;
  ASSERT_EQ(read.views.size(), 2u);
  EXPECT_EQ(read.views[0].image_path, names_[0]);
  EXPECT_EQ(read.views[1].image_path, names_[2]);
  EXPECT_EQ(read.views[1].id, 2);
  for (const ScenePoint& point : read.points) {
    ASSERT_EQ(point.track.size(), 2u);
    EXPECT_EQ(point.track[1].view_id, 2);
    EXPECT_LT(point.error_px, 1e-3);
  }
  EXPECT_THAT(read.doubts, Contains(HasSubstr("1 camera left out: not registered")));
  EXPECT_THAT(read.doubts,
              Contains(AllOf(HasSubstr("1 camera left out: no photograph"), HasSubstr(names_[3]))));
}

TEST_F(BundlerSet, PointSeenTwiceKeepsTheFirst) {
  WriteAll();
  points_.resize(1);
  std::string text = Bundle();
  const std::size_t track = text.rfind("\n4 ");
  text.replace(track, 3, "\n5 ");
  text.insert(text.size() - 1, " 3 99 1 2");
  Write(scratch_ / "bundle.out", text);
  const LightField read = Read().light_field;
  EXPECT_EQ(read.points.at(0).track.size(), 4u);
  EXPECT_LT(read.points[0].error_px, 1e-3);
  EXPECT_THAT(read.doubts, Contains(HasSubstr("1 observation of points that a photograph shows twice")));
}

TEST_F(BundlerSet, TheListMayLieInManyPlaces) {
  // Beside the folder of the bundle file, with focal lengths, names with spaces, and folders in the names.
  names_ = {"left/a b.png", "left/c.png", "right/c.png", "right/d 0.png"};
  WritePhotographs(scratch_ / "set/images");
  const std::string mark = "\xEF\xBB\xBF";  // of Windows
  Write(scratch_ / "set/bundle/bundle.out", mark + Bundle());
  std::string list = mark;
  for (const std::string& name : names_) list += "./images/" + name + " 0 532.25\r\n";
  Write(scratch_ / "set/list.txt", list + "\n");
  const PosedSet found = ReadBundlerSet(scratch_ / "set/bundle/bundle.out", {});
  const PosedSet chosen = ReadBundlerSet(scratch_ / "set/bundle/bundle.out", scratch_ / "set/images");
  for (const PosedSet* set : {&found, &chosen}) {
    EXPECT_THAT(set->light_field.doubts, IsEmpty());
    ASSERT_EQ(set->light_field.views.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_TRUE(fs::equivalent(set->light_field.root / set->light_field.views[i].image_path,
                                 scratch_ / "set/images" / names_[i]));
  }
  // The list is named after the bundle file; by COLMAP a.list.txt of a.bundle.out.
  Write(scratch_ / "set/bundle/other.list.txt", "x.png\n");
  fs::copy(scratch_ / "set/bundle/bundle.out", scratch_ / "set/bundle/a.bundle.out");
  fs::copy(scratch_ / "set/list.txt", scratch_ / "set/bundle/a.list.txt");
  fs::rename(scratch_ / "set/list.txt", scratch_ / "set/bundle/bundle.out.list.txt");
  for (const char* file : {"bundle.out", "a.bundle.out"})
    EXPECT_EQ(
        ReadBundlerSet(scratch_ / "set/bundle" / file, scratch_ / "set/images").light_field.views.size(), 4u)
        << file;
  fs::remove(scratch_ / "set/bundle/a.list.txt");
  fs::rename(scratch_ / "set/bundle/bundle.out.list.txt", scratch_ / "set/bundle/mine.list.txt");
  fs::remove(scratch_ / "set/bundle/a.bundle.out");
  EXPECT_THAT([&] { ReadBundlerSet(scratch_ / "set/bundle/bundle.out", {}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("several lists"), HasSubstr("bundle.list.txt"))));
}

TEST_F(BundlerSet, AlmostRotationsAreMadeSuch) {
  cameras_[0].rotation *= 1.0003;
  cameras_[1].rotation(0, 1) += 2e-4;
  WriteAll();
  for (const View& view : Read().light_field.views) {
    const Matrix3d rotation = view.cam_from_world.RotationMatrix();
    EXPECT_LT((rotation.transpose() * rotation - Matrix3d::Identity()).norm(), 1e-12);
    const Matrix3d given = cameras_[static_cast<std::size_t>(view.id - 1)].rotation;
    EXPECT_LT((Vector3d(1, -1, -1).asDiagonal() * rotation - given).norm(), 1e-3);
  }
}

// A scale of a camera's frame leads to the same pixels.
TEST_F(BundlerSet, AScaledCameraSeesTheSame) {
  WriteAll();
  const Rigid3 expected = Read().light_field.views[2].cam_from_world;
  cameras_[2].rotation *= 2;
  cameras_[2].translation *= 2;
  WriteAll();
  const LightField read = Read().light_field;
  EXPECT_LT((read.views[2].cam_from_world.Matrix() - expected.Matrix()).norm(), 1e-9);
  EXPECT_THAT(read.doubts, testing::ElementsAre(AllOf(HasSubstr("1 pose"), HasSubstr("a scale of 2"))));
}

TEST_F(BundlerSet, ListsHaveNamesOfManyPrograms) {
  for (const char* name : {"list.rd.txt", "imagelist.lst", "Set.LST", "list.focal.txt"}) {
    WritePhotographs(scratch_ / "images");
    Write(scratch_ / "bundle.out", Bundle());
    Write(scratch_ / name, List());
    EXPECT_EQ(Read().light_field.views.size(), 4u) << name;
    fs::remove(scratch_ / name);
  }
}

TEST_F(BundlerSet, DamagedFilesAreRefused) {
  WriteAll();
  ExpectErrorWith("v0.3", "v0.2", "bundle.out", "# Bundle file v0.3");
  ExpectErrorWith("90 0 0", "nan 0 0", "line 3", "not finite");
  ExpectErrorWith("90 0 0", "90 1e999 0", "line 3", "not finite");
  ExpectErrorWith("90 0 0", "90 wide 0", "'wide'", "no number");
  ExpectErrorWith("90 0 0", "-90 0 0", "camera 1 of 4 (photo_0.png)", "must be positive");
  ExpectErrorWith("90 0 0", "90 0 0 0", "bundle.out, line 3", "not a rotation");
  ExpectErrorWith("\n4 0 0 ", "\n4 4 0 ", "point 1 of 20", "seen by camera 4");
  ExpectErrorWith("\n4 0 0 ", "\n4 0.5 0 ", "point 1 of 20", "not a whole number");
  ExpectErrorWith("\n4 0 0 ", "\n-4 0 0 ", "point 1 of 20", "not a whole number");
  cameras_[2].rotation *= -1;
  ExpectErrorWith("4 20", "4 20", "camera 3 of 4", "not a rotation");
}

TEST_F(BundlerSet, CountsThatLieAreRefused) {
  WriteAll();
  ExpectErrorWith("4 20", "4 21", "ends in point 21 of 21", "cut short");
  ExpectErrorWith("4 20", "4 19", "goes on after the last point", "counts are wrong");
  ExpectErrorWith("4 20", "4 999999999", "ends in point 21 of 999999999", "cut short");
  ExpectErrorWith("4 20", "4 9999999999", "line 2", "not a whole number");
  ExpectErrorWith("4 20", "999999999 20", "list.txt", "names 4 photographs");
  // A track that says that it is as long as it can be.
  ExpectErrorWith("\n4 0 0 ", "\n999999999 0 0 ", "point 1 of 20", "not a whole number");
}

TEST_F(BundlerSet, FilesThatAreCutShortAreRefused) {
  WriteAll();
  const std::string text = Bundle();
  for (std::size_t size = 0; size < text.rfind(' '); size += 13) {
    Write(scratch_ / "bundle.out", text.substr(0, size));
    EXPECT_THROW(Read(), Error) << size;
  }
}

TEST_F(BundlerSet, ListsAndPhotographsMustBelongToIt) {
  WritePhotographs(scratch_.path());
  Write(scratch_ / "bundle.out", Bundle());
  ExpectError("bundle.out", "no list of its photographs");
  Write(scratch_ / "list.txt", List() + "another.png\n");
  ExpectError("list.txt: names 5 photographs", "bundle.out has 4 cameras");
  Write(scratch_ / "list.txt", "photo_0.png\nx/photo_0.png\nphoto_2.png\nphoto_3.png\n");
  ExpectError("'photo_0.png' and 'x/photo_0.png'", "with images");
  Write(scratch_ / "list.txt", "a.png\nb.png\nc.png\nd.png\n");
  ExpectError("'a.png'", "with images");
  Write(scratch_ / "list.txt", List());
  for (BundledCamera& camera : cameras_) camera.f = 0;
  Write(scratch_ / "bundle.out", Bundle());
  ExpectError("none of its 4 cameras", "registered");
  Write(scratch_ / "list.txt", "\n");
  Write(scratch_ / "bundle.out", "# Bundle file v0.3\n0 0\n");
  ExpectError("bundle.out", "holds no camera");
  EXPECT_THAT([&] { ReadBundlerSet(scratch_.path(), {}); }, ThrowsMessage<Error>(HasSubstr("is a folder")));
  EXPECT_THAT([&] { ReadBundlerSet(scratch_ / "gone.out", {}); },
              ThrowsMessage<Error>(HasSubstr("cannot be read")));
  EXPECT_THAT([&] { ReadBundlerSet(scratch_ / "bundle.out", scratch_ / "gone"); }, testing::Throws<Error>());
}

}  // namespace
}  // namespace ulf::bundler_set_test

// Tests: core/light_field/exchange/readers/realityscan_set.
//
// XMP files of RealityScan, written here after its paper on camera geometry: poses and lenses come back, and
// what is not supported, damaged or left out is said.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "tests/support/test_paths.h"

namespace ulf::realityscan_set_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ScratchFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

struct ScannedPhotograph {
  std::string name;
  int width = 96, height = 72;
  Matrix3d cam_from_world = Matrix3d::Identity();
  Vector3d center = Vector3d::Zero();
  double focal_35mm = 30, aspect = 1, u = 0.01, v = -0.02;
  std::string model = "brown3t2";
  std::array<double, 6> k{-0.12, 0.05, -0.01, 0, 0.002, -0.003};  // k1 k2 k3 k4 t1 t2

  // The paper's equations.
  Vector2d Project(const Vector3d& point) const {
    const Vector3d in_cam = cam_from_world * (point - center);
    const double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z(), r2 = x * x + y * y;
    const double radial =
        1 + k[0] * r2 + k[1] * std::pow(r2, 2) + k[2] * std::pow(r2, 3) + k[3] * std::pow(r2, 4);
    const double xd = x * radial + k[4] * (r2 + 2 * x * x) + 2 * k[5] * x * y;
    const double yd = y * radial + k[5] * (r2 + 2 * y * y) + 2 * k[4] * x * y;
    const double s = std::max(width, height), f = focal_35mm / 36;
    return {width / 2.0 + s * (f * xd + u), height / 2.0 + s * (f * aspect * yd + v)};
  }

  std::map<std::string, std::string> Values() const {
    std::string rotation;
    for (int i = 0; i < 9; ++i)
      rotation += fmt::format("{}{}", i == 0 ? "" : " ", cam_from_world(i / 3, i % 3));
    return {{"Rotation", rotation},
            {"Position", fmt::format("{} {} {}", center.x(), center.y(), center.z())},
            {"FocalLength35mm", fmt::format("{}", focal_35mm)},
            {"Skew", "0"},
            {"AspectRatio", fmt::format("{}", aspect)},
            {"PrincipalPointU", fmt::format("{}", u)},
            {"PrincipalPointV", fmt::format("{}", v)},
            {"DistortionModel", model},
            {"DistortionCoeficients", fmt::format("{}", fmt::join(k, " "))},
            {"Coordinates", "absolute"},
            {"PosePrior", "locked"}};
  }
};

using XcrValues = std::map<std::string, std::string>;

// `elements`: the keys that are elements, all others are attributes.
std::string XmpText(const XcrValues& values, const std::vector<std::string>& elements) {
  std::string attributes, children;
  for (const auto& [key, value] : values)
    if (std::ranges::find(elements, key) != elements.end())
      children += fmt::format("      <xcr:{}>{}</xcr:{}>\n", key, value, key);
    else
      attributes += fmt::format(" xcr:{}=\"{}\"\n      ", key, value);
  return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
         "  <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
         "    <rdf:Description xcr:Version=\"3\" xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\"" +
         attributes + ">\n" + children + "    </rdf:Description>\n  </rdf:RDF>\n</x:xmpmeta>\n";
}

class RealityScanSet : public testing::Test {
 protected:
  RealityScanSet() {
    for (int i = 0; i < 4; ++i) {
      ScannedPhotograph& photograph = photographs_.emplace_back();
      photograph.name = fmt::format("scan {}.png", i);
      photograph.cam_from_world =
          Eigen::AngleAxisd(0.2 * i - 0.3, Vector3d(0.1 * i, 1, 0.2).normalized()).toRotationMatrix();
      photograph.center = -4 * photograph.cam_from_world.row(2).transpose() + Vector3d(0.1, 0.05 * i, 0.2);
    }
    photographs_[1].width = 60;  // upright
    photographs_[1].height = 90;
    photographs_[1].aspect = 1.01;
    photographs_[2].model = "brown3";
    photographs_[2].k = {-0.1, 0.02, 0.003, 0, 0, 0};
    photographs_[3].model = "division";
    photographs_[3].k = {};
    for (int i = 0; i < 20; ++i)
      points_.emplace_back(0.8 * std::sin(3.0 * i), 0.7 * std::cos(5.0 * i), 0.5 * std::sin(7.0 * i));
    for (const ScannedPhotograph& photograph : photographs_) {
      WritePhotograph(scratch_ / photograph.name, photograph.width, photograph.height);
      WriteXmp(scratch_.path(), photograph.name, photograph.Values());
    }
  }

  static void WritePhotograph(const fs::path& file, int width, int height) {
    fs::create_directories(file.parent_path());
    cv::imwrite(file.string(), cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 20, 30)));
  }
  static void WriteXmp(const fs::path& folder, const std::string& photograph, const XcrValues& values,
                       const std::vector<std::string>& elements = {"Rotation", "Position",
                                                                   "DistortionCoeficients"}) {
    fs::create_directories(folder);
    std::ofstream(folder / fs::path(photograph).replace_extension(".xmp")) << XmpText(values, elements);
  }

  LightField Read() { return ReadRealityScanSet(scratch_.path(), {}).light_field; }
  // With a value of the second photograph replaced; empty: without it.
  void ExpectErrorWith(const std::string& key, const std::string& value, const std::string& first,
                       const std::string& second) {
    XcrValues values = photographs_[1].Values();
    if (value.empty())
      values.erase(key);
    else
      values[key] = value;
    WriteXmp(scratch_.path(), photographs_[1].name, values);
    EXPECT_THAT([&] { Read(); },
                ThrowsMessage<Error>(AllOf(HasSubstr("scan 1.xmp"), HasSubstr(first), HasSubstr(second))))
        << key << " " << value;
  }

  void ExpectProjections(const LightField& read) {
    for (const View& view : read.views) {
      const auto photograph = std::ranges::find_if(photographs_, [&](const ScannedPhotograph& other) {
        return other.name == fs::path(view.image_path).filename();
      });
      ASSERT_NE(photograph, photographs_.end());
      EXPECT_LT((view.CenterInWorld() - photograph->center).norm(), 1e-9);
      EXPECT_LT((view.cam_from_world.RotationMatrix() - photograph->cam_from_world).norm(), 1e-9);
      for (const Vector3d& point : points_) {
        const auto in_img = read.CameraOf(view).ImgFromCam(view.cam_from_world * point);
        ASSERT_TRUE(in_img);
        EXPECT_LT((*in_img - photograph->Project(point)).norm(), 1e-3) << view.image_path;
      }
    }
  }

  ScratchFolder scratch_;
  std::vector<ScannedPhotograph> photographs_;
  std::vector<Vector3d> points_;
};

TEST_F(RealityScanSet, PosesAndLensesComeBack) {
  const PosedSet set = ReadRealityScanSet(scratch_.path(), {});
  const LightField& read = set.light_field;
  EXPECT_EQ(set.format, "RealityScan");
  EXPECT_EQ(read.units, "arbitrary");
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_EQ(read.views[3].id, 4);
  EXPECT_EQ(read.cameras[0].distortion, Distortion::kRadialTangential);
  EXPECT_EQ(read.cameras[0].coefficients, (std::array{-0.12, 0.05, -0.003, 0.002, -0.01}))
      << "t1 is p2, t2 is p1";
  EXPECT_DOUBLE_EQ(read.cameras[1].fx, 75) << "30 of 36 times the larger side";
  EXPECT_EQ(read.cameras[3].distortion, Distortion::kNone);
  ExpectProjections(read);
}

TEST_F(RealityScanSet, AnyValueMayBeAnAttributeOrAnElement) {
  XcrValues values = photographs_[0].Values();
  std::vector<std::string> all;
  for (const auto& [key, value] : values) all.push_back(key);
  for (const std::vector<std::string>& elements : {std::vector<std::string>(), all}) {
    WriteXmp(scratch_.path(), photographs_[0].name, values, elements);
    const LightField read = Read();
    ASSERT_EQ(read.views.size(), 4u);
    ExpectProjections(read);
  }
}

TEST_F(RealityScanSet, MissingValuesHaveDefaults) {
  photographs_[0].k = {};
  photographs_[0].u = photographs_[0].v = 0;
  XcrValues values = photographs_[0].Values();
  for (const char* key : {"Skew", "AspectRatio", "PrincipalPointU", "PrincipalPointV", "DistortionModel",
                          "DistortionCoeficients", "Coordinates"})
    values.erase(key);
  WriteXmp(scratch_.path(), photographs_[0].name, values);
  const LightField read = Read();
  EXPECT_EQ(read.cameras[0].distortion, Distortion::kNone);
  ExpectProjections(read);
}

TEST_F(RealityScanSet, PhotographsMayLieElsewhere) {
  for (const ScannedPhotograph& photograph : photographs_) {
    WritePhotograph(scratch_ / "else/photos" / photograph.name, photograph.width, photograph.height);
    WritePhotograph(scratch_ / "below/left" / photograph.name, photograph.width, photograph.height);
    WriteXmp(scratch_ / "else", photograph.name, photograph.Values());
    WriteXmp(scratch_ / "below/left", photograph.name, photograph.Values());
  }
  const LightField chosen = ReadRealityScanSet(scratch_.path(), scratch_ / "else/photos").light_field;
  EXPECT_EQ(chosen.views.size(), 4u);
  EXPECT_TRUE(fs::equivalent(chosen.root, scratch_ / "else/photos"));
  ExpectProjections(chosen);
  EXPECT_EQ(ReadRealityScanSet(scratch_ / "else", scratch_ / "else/photos").light_field.views.size(), 4u);
  const LightField below = ReadRealityScanSet(scratch_ / "below", {}).light_field;
  ASSERT_EQ(below.views.size(), 4u);
  EXPECT_EQ(below.views[0].image_path, "left/scan 0.png");
  ExpectProjections(below);
}

// Windows makes no difference between cases, and other programs keep the photograph's ending.
TEST_F(RealityScanSet, XmpFilesMayBeSpeltOtherwise) {
  fs::rename(scratch_ / "scan 0.xmp", scratch_ / "SCAN 0.XMP");
  fs::rename(scratch_ / "scan 1.xmp", scratch_ / "scan 1.png.xmp");
  fs::rename(scratch_ / "scan 2.xmp", scratch_ / "Scan 2.PNG.xmp");
  const LightField read = Read();
  EXPECT_EQ(read.views.size(), 4u);
  ExpectProjections(read);
}

TEST_F(RealityScanSet, ReportsWhatIsLeftOut) {
  WritePhotograph(scratch_ / "scan 4.png", 96, 72);  // no XMP file
  WritePhotograph(scratch_ / "scan 5.png", 96, 72);  // one without a pose
  std::ofstream(scratch_ / "scan 5.xmp") << XmpText({{"FocalLength35mm", "30"}}, {});
  WritePhotograph(scratch_ / "scan 3.jpg", 96, 72);       // as scan 3.png
  WritePhotograph(scratch_ / "scan 0.mask.png", 96, 72);  // a mask
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_EQ(read.views[0].mask_path, "scan 0.mask.png");
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("1 photograph left out: no XMP file"),
                                       HasSubstr("1 photograph left out: no pose in the XMP file"),
                                       HasSubstr("1 photograph left out: another photograph has the same")));
}

TEST_F(RealityScanSet, OneComponentIsRead) {
  for (std::size_t i = 0; i < 4; ++i) {
    XcrValues values = photographs_[i].Values();
    values["Coordinates"] = "relative";
    values["ComponentId"] = i == 1 ? "{B}" : "{A}";
    WriteXmp(scratch_.path(), photographs_[i].name, values);
  }
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 3u);
  EXPECT_EQ(read.views[1].id, 2);
  EXPECT_EQ(read.views[1].image_path, "scan 2.png");
  EXPECT_THAT(read.doubts,
              ElementsAre(HasSubstr("1 photograph left out: positions count from another component")));
  ExpectProjections(read);
}

TEST_F(RealityScanSet, UnsupportedLensesAreRefused) {
  ExpectErrorWith("Skew", "0.01", "xcr:Skew is 0.01", "Brown 3");
  ExpectErrorWith("DistortionModel", "division", "'division' (xcr:DistortionCoeficients -0.12", "Brown 3");
  ExpectErrorWith("DistortionModel", "rationalP2D1", "'rationalP2D1'", "Brown 3");
  ExpectErrorWith("DistortionCoeficients", "0.1 0 0 0.25 0 0", "(k4) is 0.25", "Brown 3");
  ExpectErrorWith("FocalLength35mm", "", "no xcr:FocalLength35mm", "export");
  ExpectErrorWith("Coordinates", "elsewhere", "'elsewhere'", "export the XMP files again");
}

TEST_F(RealityScanSet, DamagedFilesAreRefused) {
  ExpectErrorWith("Rotation", "1 0 0 0 1 0 0 0", "xcr:Rotation", "9 numbers, not 8");
  ExpectErrorWith("Rotation", "1 0 0 0 1 0 0 0 1 0", "xcr:Rotation", "there are more");
  ExpectErrorWith("Rotation", "2 0 0 0 1 0 0 0 1", "xcr:Rotation", "not a rotation");
  ExpectErrorWith("Rotation", "1 0 0 0 1 0 0 0 -1", "xcr:Rotation", "not a rotation");
  ExpectErrorWith("Rotation", "1 0 0 0 1 0 0 0 nan", "xcr:Rotation", "not finite");
  ExpectErrorWith("Rotation", "", "xcr:Position", "no xcr:Rotation");
  ExpectErrorWith("Position", "", "xcr:Rotation", "no xcr:Position");
  ExpectErrorWith("Position", "1 2 three", "xcr:Position", "'three', which is no number");
  ExpectErrorWith("FocalLength35mm", "0", "focal", "");
  ExpectErrorWith("FocalLength35mm", "inf", "xcr:FocalLength35mm", "not finite");
  ExpectErrorWith("AspectRatio", "-1", "focal", "");
  ExpectErrorWith("DistortionCoeficients", "0 0 0", "xcr:DistortionCoeficients", "6 numbers, not 3");
  const std::string text = XmpText(photographs_[1].Values(), {"Rotation"});
  for (std::size_t size = 0; size < text.find("</x:xmpmeta>"); size += 29) {
    std::ofstream(scratch_ / "scan 1.xmp") << text.substr(0, size);
    EXPECT_THAT([&] { Read(); },
                ThrowsMessage<Error>(AllOf(HasSubstr("scan 1.xmp"), HasSubstr("no valid XML"))));
  }
}

TEST_F(RealityScanSet, AlmostRotationsAreMadeSuch) {
  XcrValues values = photographs_[0].Values();
  values["Rotation"] = "1.0003 0 0 0 1.0003 0 0 0.0002 1.0003";
  WriteXmp(scratch_.path(), photographs_[0].name, values);
  const View view = Read().views[0];
  EXPECT_LT((view.cam_from_world.RotationMatrix() - Matrix3d::Identity()).norm(), 1e-3);
  EXPECT_LT((view.CenterInWorld() - photographs_[0].center).norm(), 1e-9);
}

TEST_F(RealityScanSet, NeedsPosesAndPhotographs) {
  for (const ScannedPhotograph& photograph : photographs_)
    fs::remove(scratch_ / fs::path(photograph.name).replace_extension(".xmp").string());
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("no XMP file with a pose"), HasSubstr("with images"))));
  EXPECT_THAT([&] { ReadRealityScanSet(scratch_ / "gone", {}); },
              ThrowsMessage<Error>(HasSubstr("is no folder")));
  fs::create_directories(scratch_ / "empty/inside");
  EXPECT_THAT([&] { ReadRealityScanSet(scratch_ / "empty/inside", {}); },
              ThrowsMessage<Error>(HasSubstr("with images")));
}

}  // namespace
}  // namespace ulf::realityscan_set_test

// Tests: core/light_field/exchange/readers/metashape_set, core/light_field/exchange/readers/metashape_sensor,
// core/light_field/formats/xml_file.
//
// Metashape's cameras, written here after its manual: poses and lenses come back, and what is not supported,
// damaged or left out is said.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/exchange/writers/set_writers.h"
#include "core/light_field/formats/xml_file.h"
#include "tests/support/test_paths.h"

namespace ulf::metashape_set_test {
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

std::string Numbers(const Matrix3d& matrix) {
  std::string text;
  for (int i = 0; i < 9; ++i) text += fmt::format("{}{}", i == 0 ? "" : " ", matrix(i / 3, i % 3));
  return text;
}

struct ShapeSensor {
  std::string type = "frame";
  int width = 96, height = 72;
  std::map<std::string, double> values{{"f", 90}, {"cx", 1.25}, {"cy", -2.5}};

  double operator[](const std::string& name) const { return values.contains(name) ? values.at(name) : 0; }

  // The manual's equations.
  Vector2d Project(const Vector3d& in_cam) const {
    const ShapeSensor& s = *this;
    Vector2d p = in_cam.head<2>() / in_cam.z();
    if (type == "fisheye") p *= std::atan(p.norm()) / p.norm();
    const double x = p.x(), y = p.y(), r2 = x * x + y * y;
    const double radial =
        1 + s["k1"] * r2 + s["k2"] * std::pow(r2, 2) + s["k3"] * std::pow(r2, 3) + s["k4"] * std::pow(r2, 4);
    const double u = x * radial + s["p1"] * (r2 + 2 * x * x) + 2 * s["p2"] * x * y;
    const double v = y * radial + s["p2"] * (r2 + 2 * y * y) + 2 * s["p1"] * x * y;
    return {width * 0.5 + s["cx"] + u * s["f"] + u * s["b1"] + v * s["b2"],
            height * 0.5 + s["cy"] + v * s["f"]};
  }

  std::string Xml(int id) const {
    std::string text = fmt::format(
        "<sensor id=\"{}\" label=\"lens {}\" type=\"{}\">\n<resolution width=\"{}\" height=\"{}\"/>\n"
        "<calibration type=\"{}\" class=\"initial\">\n<resolution width=\"{}\" height=\"{}\"/>\n<f>1</f>\n"
        "</calibration>\n"
        "<calibration type=\"{}\" class=\"adjusted\">\n<resolution width=\"{}\" height=\"{}\"/>\n",
        id, id, type, width, height, type, width, height, type, width, height);
    for (const auto& [name, value] : values) text += fmt::format("<{}>{}</{}>\n", name, value, name);
    return text + "</calibration>\n</sensor>\n";
  }
};

struct ShapeCamera {
  int sensor = 0;
  Matrix3d chunk_from_cam = Matrix3d::Identity();
  Vector3d center = Vector3d::Zero();
  std::string label, attributes;
  bool posed = true;

  std::string Xml(int id) const {
    const Matrix3d& m = chunk_from_cam;
    std::string text =
        fmt::format("<camera id=\"{}\" sensor_id=\"{}\" label=\"{}\" {}>\n", id, sensor, label, attributes);
    if (posed) {
      text += "<transform>";
      for (int row = 0; row < 3; ++row)
        text += fmt::format("{} {} {} {} ", m(row, 0), m(row, 1), m(row, 2), center(row));
      text += "0 0 0 1</transform>\n";
    }
    return text + "<orientation>1</orientation>\n</camera>\n";
  }
};

struct ShapeTransform {
  double scale = 1;
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();

  Vector3d World(const Vector3d& in_chunk) const { return scale * (rotation * in_chunk) + translation; }
  std::string Xml() const {
    return fmt::format(
        "<transform>\n<rotation locked=\"true\">{}</rotation>\n<translation>{} {} "
        "{}</translation>\n<scale>{}</scale>\n"
        "</transform>\n",
        Numbers(rotation), translation.x(), translation.y(), translation.z(), scale);
  }
};

Matrix3d Turned(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

class MetashapeSet : public testing::Test {
 protected:
  MetashapeSet() {
    sensors_[0].values.insert(
        {{"b1", 0.75}, {"k1", -0.09}, {"k2", 0.02}, {"k3", -0.005}, {"p1", 0.003}, {"p2", -0.002}});
    sensors_[1].type = "fisheye";
    sensors_[1].values = {{"f", 40},      {"cx", 0.5},   {"cy", -1},     {"k1", 0.02},
                          {"k2", -0.004}, {"k3", 0.001}, {"k4", -0.0002}};
    sensors_[2].values = {{"f", 80}};
    for (int i = 0; i < 5; ++i) {
      ShapeCamera& camera = cameras_.emplace_back();
      camera.sensor = i % 3;
      camera.chunk_from_cam = Turned(0.15 * i - 0.3, {0.1 * i, 1, 0.2});
      camera.center = -4 * camera.chunk_from_cam.col(2) + Vector3d(0.1, 0.02 * i, -0.05);
      camera.label = fmt::format("DJI_{:04}", i);
    }
    for (int i = 0; i < 20; ++i)
      points_.emplace_back(0.8 * std::sin(3.0 * i), 0.7 * std::cos(5.0 * i), 0.5 * std::sin(7.0 * i));
    fs::create_directories(scratch_ / "images");
    for (const ShapeCamera& camera : cameras_) WritePhotograph(camera.label + ".jpg", 96, 72);
  }

  void WritePhotograph(const std::string& name, int width, int height) const {
    cv::imwrite((scratch_ / "images" / name).string(),
                cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 20, 30)));
  }

  std::string CamerasXml() const {
    std::string text;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      // Half of them in a group.
      if (i == 2) text += "<group id=\"0\" label=\"flight\" type=\"folder\">\n";
      text += cameras_[i].Xml(static_cast<int>(i));
    }
    return text + "</group>\n";
  }
  std::string ChunkXml(const std::string& transforms) const {
    std::string text = "<chunk label=\"Chunk 1\" enabled=\"true\">\n<sensors next_id=\"3\">\n";
    for (int i = 0; i < 3; ++i) text += sensors_[i].Xml(i);
    return text + "</sensors>\n" + transforms + "<cameras next_id=\"9\">\n" + CamerasXml() +
           "</cameras>\n</chunk>\n";
  }
  std::string Document(const std::string& chunks) const {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n" + chunks +
           "</document>\n";
  }
  std::string Xml() const { return Document(ChunkXml("")); }

  PosedSet Read(const std::string& text) {
    std::ofstream(scratch_ / "cameras.xml") << text;
    return ReadMetashapeSet(scratch_ / "cameras.xml", {});
  }
  void ExpectError(const std::string& text, const std::string& first, const std::string& second) {
    EXPECT_THAT([&] { Read(text); },
                ThrowsMessage<Error>(AllOf(HasSubstr("cameras.xml"), HasSubstr(first), HasSubstr(second))));
  }
  void ExpectErrorWith(const std::string& from, const std::string& to, const std::string& first,
                       const std::string& second) {
    std::string text = Xml();
    ASSERT_NE(text.find(from), std::string::npos) << from;
    ExpectError(text.replace(text.find(from), from.size(), to), first, second);
  }

  // Writes points.ply beside the cameras, in the frame into which the chunk's points are `moved`.
  void WritePoints(const ShapeTransform& moved) const {
    std::ofstream ply(scratch_ / "points.ply");
    ply << "ply\nformat ascii 1.0\nelement vertex " << points_.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    for (const Vector3d& point : points_)
      for (const double coordinate : moved.World(point)) ply << fmt::format("{}\n", coordinate);
  }

  // That views see the chunk's points where the manual's equations have them.
  void ExpectProjections(const LightField& read, const ShapeTransform& world_from_chunk) {
    for (const View& view : read.views) {
      const auto camera = std::ranges::find_if(
          cameras_, [&](const ShapeCamera& other) { return other.label + ".jpg" == view.image_path; });
      ASSERT_NE(camera, cameras_.end()) << view.image_path;
      EXPECT_LT((view.CenterInWorld() - world_from_chunk.World(camera->center)).norm(), 1e-9);
      EXPECT_LT((view.cam_from_world.RotationMatrix().transpose() -
                 world_from_chunk.rotation * camera->chunk_from_cam)
                    .norm(),
                1e-9);
      for (const Vector3d& point : points_) {
        const Vector3d in_cam = camera->chunk_from_cam.transpose() * (point - camera->center);
        const auto in_img =
            read.CameraOf(view).ImgFromCam(view.cam_from_world * world_from_chunk.World(point));
        ASSERT_TRUE(in_img);
        EXPECT_LT((*in_img - sensors_[camera->sensor].Project(in_cam)).norm(), 1e-3);
      }
    }
  }

  ScratchFolder scratch_;
  ShapeSensor sensors_[3];
  std::vector<ShapeCamera> cameras_;
  std::vector<Vector3d> points_;
};

TEST_F(MetashapeSet, PosesAndLensesComeBack) {
  const PosedSet set = Read(Xml());
  const LightField& read = set.light_field;
  EXPECT_EQ(set.format, "Metashape");
  EXPECT_EQ(read.units, "arbitrary");
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.views.size(), 5u);
  ASSERT_EQ(read.cameras.size(), 3u);
  EXPECT_EQ(read.views[3].id, 4);
  EXPECT_EQ(read.cameras[0].distortion, Distortion::kRadialTangential);
  EXPECT_EQ(read.cameras[0].coefficients, (std::array{-0.09, 0.02, -0.002, 0.003, -0.005}))
      << "p1 and p2 change places";
  EXPECT_EQ(read.cameras[1].distortion, Distortion::kFisheye);
  EXPECT_EQ(read.cameras[2].distortion, Distortion::kNone);
  ExpectProjections(read, {});
}

TEST_F(MetashapeSet, TheChunksTransformLeadsToTheWorld) {
  const ShapeTransform world_from_chunk{2.5, Turned(0.8, {1, 2, 3}), {10, -20, 300}};
  const LightField read = Read(Document(ChunkXml(world_from_chunk.Xml()))).light_field;
  ASSERT_EQ(read.views.size(), 5u);
  ExpectProjections(read, world_from_chunk);
  // As it lies in a project of its own.
  EXPECT_EQ(Read(ChunkXml(world_from_chunk.Xml())).light_field.views.size(), 5u);
}

// Every chunk has a transform with a scale, also one that nothing was measured in.
TEST_F(MetashapeSet, UnitsAreMetresWhereTheFileTells) {
  const std::string scaled = ShapeTransform{2.5, Turned(0.8, {1, 2, 3}), {10, -20, 300}}.Xml();
  const auto system = [](const char* unit) {
    return fmt::format("<reference>LOCAL_CS[\"Local\",LOCAL_DATUM[\"Local Datum\",0],UNIT[{}]]</reference>",
                       unit);
  };
  const std::string metres = system("\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]");
  const std::string feet = system("\"foot\",0.3048,AUTHORITY[\"EPSG\",\"9002\"]");
  const auto bar = [](const char* enabled) {
    return fmt::format(
        "<scalebars><scalebar id=\"0\"><reference distance=\"0.5\" enabled=\"{}\"/></scalebar></scalebars>",
        enabled);
  };
  const auto markers = [](int count) {
    std::string text = "<markers>";
    for (int i = 0; i < count; ++i)
      text += fmt::format(
          "<marker id=\"{0}\"><reference x=\"{0}\" y=\"1\" z=\"2\" enabled=\"true\"/></marker>", i);
    return text + "</markers>";
  };
  const std::string far = ShapeTransform{2.5, Turned(0.8, {1, 2, 3}), {4e6, 1e6, 4e6}}.Xml();
  const std::string said = "<meta><property name=\"ulf/units\" value=\"metres\"/></meta>";
  const std::pair<std::string, const char*> cases[] = {{scaled, "arbitrary"},
                                                       {scaled + metres, "arbitrary"},
                                                       {bar("true"), "arbitrary"},
                                                       {scaled + bar("true"), "metres"},
                                                       {scaled + metres + bar("1"), "metres"},
                                                       {scaled + metres + bar("false"), "arbitrary"},
                                                       {scaled + feet + bar("true"), "arbitrary"},
                                                       {scaled + metres + markers(3), "metres"},
                                                       {scaled + metres + markers(2), "arbitrary"},
                                                       {far, "metres"},
                                                       {said, "metres"}};
  for (const auto& [more, units] : cases)
    EXPECT_EQ(Read(Document(ChunkXml(more))).light_field.units, units) << more;
  for (const auto& [units, transform] : {std::pair("metres", true), std::pair("arbitrary", false)}) {
    LightField light_field = Read(Document(ChunkXml(""))).light_field;
    light_field.units = units;
    const std::string ours = MetashapeXmlText(light_field);
    EXPECT_EQ(ours.find("<scale>") != std::string::npos, transform);
    EXPECT_EQ(Read(ours).light_field.units, units);
  }
}

TEST_F(MetashapeSet, AGeocentricTranslationIsLeftOut) {
  ShapeTransform world_from_chunk{12.35, Turned(0.8, {1, 2, 3}), {-2499366.4, -4256836.5, 4029217.9}};
  const LightField read = Read(Document(ChunkXml(world_from_chunk.Xml()))).light_field;
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("geocentric"), HasSubstr("-2499366.400"))));
  world_from_chunk.translation.setZero();
  ExpectProjections(read, world_from_chunk);
}

TEST_F(MetashapeSet, PointsComeInWhereTheirFrameIsClear) {
  const ShapeTransform world_from_chunk{2.5, Turned(0.8, {1, 2, 3}), {10, -20, 300}};
  struct Case {
    const char* name;
    ShapeTransform world_from_chunk, points_from_chunk;
    bool taken;
  } const cases[] = {
      {"no transform", {}, {}, true},
      {"points in the world", world_from_chunk, world_from_chunk, true},
      {"points in the chunk's frame", world_from_chunk, {}, true},
      {"fewer of them in the chunk's frame",
       {1, Matrix3d::Identity(), {0, 5.5, 0}},
       {1, Matrix3d::Identity(), {0, 5.5, 0}},
       true},
      {"points on the earth", world_from_chunk, {1, Matrix3d::Identity(), {500000, 5200000, 340}}, false},
      {"either frame", {1, Turned(0.3, {0, 1, 0}), {0, 0, 0}}, {}, false},
  };
  for (const Case& each : cases) {
    SCOPED_TRACE(each.name);
    WritePoints(each.points_from_chunk);
    const LightField read = Read(Document(ChunkXml(each.world_from_chunk.Xml()))).light_field;
    ASSERT_EQ(read.points.size(), each.taken ? points_.size() : 0);
    for (std::size_t i = 0; i < read.points.size(); ++i)
      EXPECT_LT((read.points[i].position_in_world - each.world_from_chunk.World(points_[i])).norm(), 1e-3);
    if (each.taken)
      EXPECT_THAT(read.doubts, IsEmpty());
    else
      EXPECT_THAT(read.doubts,
                  ElementsAre(AllOf(HasSubstr("points.ply: not used"), HasSubstr("its frame is not clear"))));
  }
}

TEST_F(MetashapeSet, ComponentsHaveTransformsOfTheirOwn) {
  const ShapeTransform chunk{3, Turned(1, {0, 0, 1}), {1, 1, 1}},
      first{2, Turned(0.4, {1, 2, 3}), {2e6, 1, -1}}, second{5, Turned(0.7, {3, 2, 1}), {2e6 + 7, 1, -1}};
  for (ShapeCamera& camera : cameras_) camera.attributes = "component_id=\"0\"";
  cameras_[1].attributes = "component_id=\"1\"";
  const std::string parts = "<components next_id=\"2\" active_id=\"0\">\n<component id=\"0\" label=\"A\">\n" +
                            first.Xml() + "</component>\n<component id=\"1\" label=\"B\">\n" + second.Xml() +
                            "</component>\n</components>\n";
  const LightField both = Read(Document(ChunkXml(chunk.Xml() + parts))).light_field;
  ASSERT_EQ(both.views.size(), 5u);
  EXPECT_LT(
      (both.views[0].CenterInWorld() - ShapeTransform{2, first.rotation}.World(cameras_[0].center)).norm(),
      1e-9);
  EXPECT_LT((both.views[1].CenterInWorld() -
             ShapeTransform{5, second.rotation, {7, 0, 0}}.World(cameras_[1].center))
                .norm(),
            1e-9);
  EXPECT_THAT(both.doubts, ElementsAre(HasSubstr("geocentric")));
  // Where one has none, they do not share a world; older files list the cameras of each.
  for (ShapeCamera& camera : cameras_) camera.attributes.clear();
  const std::string apart =
      "<components next_id=\"2\">\n<component id=\"0\" label=\"A\">\n<partition><camera_ids>0 2 3 "
      "4</camera_ids>"
      "</partition></component>\n<component id=\"1\" "
      "label=\"B\">\n<partition><camera_ids>1</camera_ids></partition>\n" +
      second.Xml() + "</component>\n</components>\n";
  const LightField one = Read(Document(ChunkXml(apart))).light_field;
  ASSERT_EQ(one.views.size(), 4u);
  EXPECT_THAT(one.doubts, ElementsAre(HasSubstr("1 camera left out: of components")));
  ExpectProjections(one, {});
  cameras_[0].attributes = "component_id=\"9\"";
  ExpectError(Document(ChunkXml(apart)), "'DJI_0000'", "component '9'");
}

TEST_F(MetashapeSet, ReportsWhatIsLeftOut) {
  cameras_[0].posed = false;
  cameras_[1].attributes = "enabled=\"0\"";
  cameras_[2].attributes = "enabled=\"false\"";
  cameras_[3].attributes = "enabled=\"true\"";
  fs::remove(scratch_ / "images/DJI_0004.jpg");
  std::string empty = ChunkXml("");
  for (std::size_t at; (at = empty.find("<transform>")) != std::string::npos;)
    empty.erase(at, empty.find("</transform>") + 12 - at);
  empty.replace(empty.find("Chunk 1"), 7, "Nothing");
  std::string other = ChunkXml("");
  other.replace(other.find("Chunk 1"), 7, "Other");
  const PosedSet set = Read(Document(empty + ChunkXml("") + other));
  EXPECT_TRUE(set.counts_unposed);
  const LightField& read = set.light_field;
  ASSERT_EQ(read.views.size(), 1u);
  EXPECT_EQ(read.views[0].image_path, "DJI_0003.jpg");
  EXPECT_THAT(
      read.doubts,
      ElementsAre(AllOf(HasSubstr("'Chunk 1' alone"), HasSubstr("'Nothing', 'Other'")),
                  HasSubstr("1 camera left out: not aligned"), HasSubstr("2 cameras left out: disabled"),
                  AllOf(HasSubstr("1 camera left out: no photograph"), HasSubstr("DJI_0004"))));
  ExpectProjections(read, {});
}

TEST_F(MetashapeSet, OfSeveralChunksTheLargestIsRead) {
  const std::string all = ChunkXml("");
  for (ShapeCamera& camera : cameras_) camera.posed = camera.label == cameras_[0].label;
  std::string test = ChunkXml("");
  test.replace(test.find("Chunk 1"), 7, "Test");
  const LightField read = Read(Document(test + all)).light_field;
  EXPECT_EQ(read.views.size(), 5u);
  EXPECT_THAT(read.doubts,
              ElementsAre(AllOf(HasSubstr("'Chunk 1' alone"), HasSubstr("(5)"), HasSubstr("'Test'"))));
}

// Another chunk that is left out says nothing of the photographs without a pose.
TEST_F(MetashapeSet, ListsUnposedPhotographsBesideAChunk) {
  WritePhotograph("extra.jpg", 96, 72);
  std::string other = ChunkXml("");
  other.replace(other.find("Chunk 1"), 7, "Other");
  EXPECT_FALSE(Read(Document(ChunkXml("") + other)).counts_unposed);
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  Import(scratch_ / "cameras.xml", scratch_ / "lf", {.subject = Subject{Vector3d::Zero(), 0.5}});
  spdlog::set_default_logger(logger);
  EXPECT_THAT(said.str(), AllOf(HasSubstr("chunk 'Chunk 1' alone is read"),
                                HasSubstr("left out: 1 photograph without a pose (extra.jpg)")));
}

TEST_F(MetashapeSet, PhotographsMayBeResized) {
  for (const ShapeCamera& camera : cameras_) WritePhotograph(camera.label + ".jpg", 48, 36);
  const LightField read = Read(Xml()).light_field;
  ASSERT_EQ(read.views.size(), 5u);
  EXPECT_EQ(read.cameras[0].width, 48);
  EXPECT_EQ(read.cameras[0].fy, 45);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("48x36")));
  WritePhotograph("DJI_0001.jpg", 72, 96);
  ExpectError(Xml(), "'DJI_0001'", "cropped or turned");
}

TEST_F(MetashapeSet, OneCalibrationIsEnough) {
  std::string text = Xml();
  for (std::size_t at; (at = text.find("class=\"initial\"")) != std::string::npos;) {
    const std::size_t begin = text.rfind("<calibration", at);
    text.erase(begin, text.find("</calibration>", at) + 14 - begin);
  }
  for (std::size_t at; (at = text.find("\"adjusted\"")) != std::string::npos;)
    text.replace(at, 10, "\"initial\"");
  ExpectProjections(Read(text).light_field, {});
  EXPECT_EQ(Read(text).light_field.views.size(), 5u);
}

// Terms that our lenses lack are taken up where they make no difference, and fitted where they make little.
TEST_F(MetashapeSet, TermsThatOursLackAreFitted) {
  const auto project_apart = [&](double tolerance_px) {
    const LightField read = Read(Xml()).light_field;
    double largest = 0;
    for (const Vector3d& point : {Vector3d(0.4, 0.3, 1), Vector3d(-0.5, 0.35, 1), Vector3d(0.1, -0.38, 1)})
      largest = std::max(
          largest, (*read.CameraOf(read.views[0]).ImgFromCam(point) - sensors_[0].Project(point)).norm());
    EXPECT_LT(largest, tolerance_px);
    return read.doubts;
  };
  const ShapeSensor before = sensors_[0];
  sensors_[0].values["b2"] = -0.02;  // the default adjustment fits it
  EXPECT_THAT(project_apart(0.02), IsEmpty());
  EXPECT_EQ(Read(Xml()).light_field.cameras[0].coefficients[0], -0.09) << "the others stay";
  sensors_[0].values["b2"] = 1;
  EXPECT_THAT(project_apart(0.6),
              ElementsAre(AllOf(HasSubstr("Metashape with b2"), HasSubstr("no pixel moves"))));
  sensors_[0] = before;
  sensors_[0].values["k4"] = 0.05;
  project_apart(0.05);
  sensors_[0] = before;
  sensors_[0].values["p3"] = 0.8;
  EXPECT_THAT(project_apart(0.1), ElementsAre(HasSubstr("Metashape with p3 ")));
  sensors_[0] = {};
  sensors_[0].type = "fisheye";
  sensors_[0].values = {{"f", 70}, {"k1", 0.01}, {"p1", 0.002}, {"p2", -0.001}};
  EXPECT_THAT(project_apart(0.15), ElementsAre(HasSubstr("Metashape with p1, p2 ")));
  sensors_[0].values["p1"] = 0.9;
  ExpectError(Xml(), "with p1, p2 is not one of ours", "Optimize Cameras");
}

// Every camera of a rig stands where the manual's master and sensor put it; the expected places are worked
// out with matrices of their own.
TEST_F(MetashapeSet, CamerasOfARigFollowTheirMaster) {
  const Matrix3d turn = Turned(0.05, {0, 1, 0});
  const Vector3d place(0.12, 0.01, -0.02);
  std::string text = Xml();
  const std::size_t end = text.find("</sensor>", text.find("<sensor id=\"2\""));
  text.insert(
      end, fmt::format("<rotation locked=\"true\">{}</rotation><location locked=\"true\">{} {} {}</location>",
                       Numbers(turn), place.x(), place.y(), place.z()));
  text.insert(text.rfind("</cameras>"),
              "<camera id=\"10\" sensor_id=\"2\" label=\"right_0\" master_id=\"0\"/>\n"
              "<camera id=\"11\" sensor_id=\"2\" label=\"right_1\" master_id=\"77\"/>\n");
  WritePhotograph("right_0.jpg", 96, 72);
  WritePhotograph("right_1.jpg", 96, 72);
  const LightField read = Read(text).light_field;
  ASSERT_EQ(read.views.size(), 6u);
  EXPECT_THAT(read.doubts,
              ElementsAre(HasSubstr("1 camera of a rig"), HasSubstr("1 camera left out: not aligned")));
  const View& right = read.views[5];
  EXPECT_EQ(right.image_path, "right_0.jpg");
  const Matrix3d& master = cameras_[0].chunk_from_cam;
  EXPECT_LT((right.CenterInWorld() - (cameras_[0].center + master * place)).norm(), 1e-9);
  EXPECT_LT((right.cam_from_world.RotationMatrix().transpose() - master * turn).norm(), 1e-9);
}

TEST_F(MetashapeSet, UnsupportedLensesAreRefused) {
  for (const char* type : {"spherical", "cylindrical", "equisolid_fisheye", "rpc"}) {
    sensors_[0].type = type;
    ExpectError(Xml(), "'lens 0'", fmt::format("type '{}' is not supported", type));
  }
  sensors_[0] = {};
  sensors_[0].values = {{"fx", 90}, {"fy", 90}};
  ExpectError(Xml(), "'lens 0'", "older PhotoScan");
  // Of a sensor that no camera with a pose uses nothing is asked.
  for (ShapeCamera& camera : cameras_) camera.sensor = 1;
  EXPECT_EQ(Read(Xml()).light_field.views.size(), 5u);
}

TEST_F(MetashapeSet, AlmostRotationsAreMadeSuch) {
  cameras_[0].chunk_from_cam *= 1.0003;
  const Matrix3d rotation = Read(Xml()).light_field.views[0].cam_from_world.RotationMatrix();
  EXPECT_LT((rotation.transpose() * rotation - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((rotation.transpose() * 1.0003 - cameras_[0].chunk_from_cam).norm(), 1e-9);
}

TEST_F(MetashapeSet, DamagedFilesAreRefused) {
  ExpectErrorWith("<f>90</f>", "<f>ninety</f>", "<f>", "'ninety', which is no number");
  ExpectErrorWith("<f>90</f>", "<f>nan</f>", "<f>", "not finite");
  ExpectErrorWith("<f>90</f>", "<f>-90</f>", "'lens 0'", "focal");
  ExpectErrorWith("<f>90</f>", "<f>90 90</f>", "<f>", "one number");
  ExpectErrorWith("0 0 0 1</transform>", "0 0 1</transform>", "<transform>", "16 numbers, not 15");
  ExpectErrorWith("0 0 0 1</transform>", "0 0 0 1 1</transform>", "<transform>", "there are more");
  ExpectErrorWith("0 0 0 1</transform>", "0 0 0 2</transform>", "<transform>", "0 0 0 1");
  ExpectErrorWith("sensor_id=\"0\"", "sensor_id=\"7\"", "'DJI_0000'", "sensor '7'");
  ExpectErrorWith("<sensors ", "<tensors ", "line", "no valid XML");
  ExpectErrorWith("label=\"DJI_0001\"", "label=\"DJI_0000\"", "DJI_0000.jpg", "labels of their own");
  ExpectErrorWith("label=\"DJI_0001\"", "", "<camera>", "no label");
  std::string text = Xml();
  for (std::size_t at; (at = text.find("width=\"96\"")) != std::string::npos;)
    text.replace(at, 10, "width=\"9e9\"");
  ExpectError(text, "<resolution>", "'width' is '9e9'");
  for (std::size_t at; (at = text.find("width=\"9e9\"")) != std::string::npos;) text.erase(at, 11);
  ExpectError(text, "<resolution>", "'width' is missing");
  cameras_[1].chunk_from_cam *= -1;
  ExpectError(Xml(), "<transform>", "not a rotation");
  cameras_[1].chunk_from_cam *= -1;
  ShapeTransform chunk;
  chunk.scale = -1;
  ExpectError(Document(ChunkXml(chunk.Xml())), "<scale>", "must be positive");
  chunk = {1, 2 * Matrix3d::Identity()};
  ExpectError(Document(ChunkXml(chunk.Xml())), "<rotation>", "not a rotation but scaled by 2");
}

TEST_F(MetashapeSet, FilesThatAreCutShortAreRefused) {
  const std::string text = Xml();
  for (std::size_t size = 0; size < text.find("</document>"); size += 101)
    ExpectError(text.substr(0, size), "line", "no valid XML");
}

TEST_F(MetashapeSet, NeedsCamerasAndPhotographs) {
  for (ShapeCamera& camera : cameras_) camera.label = "other_" + camera.label;
  ExpectError(Xml(), "'other_DJI_0000'", "with images");
  for (ShapeCamera& camera : cameras_) camera.posed = false;
  ExpectError(Xml(), "no camera with a pose", "Agisoft XML");
  ExpectError(Document(""), "no camera with a pose", "Agisoft XML");
}

// ---- XML. ----

TEST(XmlFile, ElementsKnowTheirPlace) {
  ScratchFolder scratch;
  std::ofstream(scratch / "a.xml")
      << "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<!-- -->\n<a>\n <b c='1 '>\n  <d> 1 2\n3 </d>\n"
         " </b><b/>\n <e><b><b/></b></e>\n</a>\n";
  const XmlElement a = ReadXmlFile(scratch / "a.xml");
  EXPECT_EQ(a.Name(), "a");
  EXPECT_EQ(a.Where(), (scratch / "a.xml").string() + ", line 3, <a>");
  EXPECT_EQ(a.Children("b").size(), 2u);
  EXPECT_EQ(a.Descendants("b").size(), 4u);
  EXPECT_EQ(a.Children("b").at(1).Descendants("b").size(), 0u);
  const XmlElement d = *a.FindPath("b/d");
  EXPECT_THAT(d.Where(), HasSubstr("line 5, <d>"));
  EXPECT_THAT(d.Numbers(3), ElementsAre(1, 2, 3));
  EXPECT_EQ(d.Text(), "1 2\n3");
  EXPECT_FALSE(a.FindPath("b/e"));
  EXPECT_FALSE(a.Find("c"));
  EXPECT_FALSE(a.Attribute("c"));
  EXPECT_EQ(a.Child("b").IntegerAttribute("c", 0, 1), 1);
  EXPECT_THAT([&] { a.Child("b").IntegerAttribute("c", 2, 5); },
              ThrowsMessage<Error>(HasSubstr("from 2 to 5")));
  EXPECT_THAT([&] { a.Child("z"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("line 3, <a>"), HasSubstr("no <z>"))));
}

TEST(XmlFile, RefusesInvalidXml) {
  ScratchFolder scratch;
  const auto expect = [&](const std::string& text, const std::string& words) {
    std::ofstream(scratch / "a.xml") << text;
    EXPECT_THAT([&] { ReadXmlFile(scratch / "a.xml"); },
                ThrowsMessage<Error>(AllOf(HasSubstr("a.xml, line"), HasSubstr(words))))
        << text;
  };
  expect("", "no valid XML");
  expect("words", "no valid XML");
  expect("<a>\n<b>\n</a>", "line 3");
  expect("<a>\n<b", "line 2");
  EXPECT_THAT([&] { ReadXmlFile(scratch.path()); }, ThrowsMessage<Error>(HasSubstr("is a folder")));
  EXPECT_THAT([&] { ReadXmlFile(scratch / "gone.xml"); }, ThrowsMessage<Error>(HasSubstr("cannot be read")));
  fs::resize_file(scratch / "a.xml", (256u << 20) + 1);  // takes no room on the disk
  EXPECT_THAT([&] { ReadXmlFile(scratch / "a.xml"); },
              ThrowsMessage<Error>(HasSubstr("is it the right file?")));
}

TEST(XmlFile, SurvivesDeepNesting) {
  ScratchFolder scratch;
  std::string text;
  constexpr int kDeep = 300000;
  for (int i = 0; i < kDeep; ++i) text += "<a>";
  for (int i = 0; i < kDeep; ++i) text += "</a>";
  std::ofstream(scratch / "a.xml") << text;
  EXPECT_EQ(ReadXmlFile(scratch / "a.xml").Descendants("a").size(), kDeep - 1u);
}

}  // namespace
}  // namespace ulf::metashape_set_test

// Tests: core/light_field/exchange/writers/nerf_files, core/light_field/exchange/writers/unit_cube,
// core/light_field/exchange/writers/metashape_xml, core/light_field/exchange/writers/realityscan_xmp,
// core/light_field/exchange/export_light_field, core/image/undistortion,
// core/light_field/exchange/writers/set_writers.
//
// What nerfstudio, instant-ngp, the readers of NeRF's synthetic sets, RealityScan and Metashape make of an
// export, by their own published rules, written here anew: poses and projections are the source's. Then our
// importer takes it back.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <sstream>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/similarity3.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/set_format.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::handed_over_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;
using test::ScratchFolder;
using test::TrackedLightField;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A photograph as another program has it.
struct Taken {
  Matrix4d cam_from_world = Matrix4d::Identity();  // axes as ours
  std::function<Vector2d(const Vector3d& in_cam)> project;
};
using TakenByName = std::map<std::string, Taken>;  // by the photograph's stem

std::vector<double> NumbersIn(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number; stream >> number;) numbers.push_back(number);
  return numbers;
}

std::string Stem(const std::string& path) { return fs::path(path).stem().string(); }

json JsonOf(const fs::path& file) { return JsonFromText(std::ifstream(file)); }

Matrix4d MatrixOf(const json& frame) {
  Matrix4d matrix;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) matrix(r, c) = frame.at("transform_matrix").at(r).at(c);
  return matrix;
}

// OpenCV's two lenses by the keys of transforms.json.
std::function<Vector2d(const Vector3d&)> OpenCvLens(const json& keys, bool fisheye) {
  const double fx = keys.at("fl_x"), fy = keys.at("fl_y"), cx = keys.at("cx"), cy = keys.at("cy");
  const double k1 = keys.value("k1", 0.0), k2 = keys.value("k2", 0.0), k3 = keys.value("k3", 0.0),
               k4 = keys.value("k4", 0.0), p1 = keys.value("p1", 0.0), p2 = keys.value("p2", 0.0);
  return [=](const Vector3d& in_cam) -> Vector2d {
    const double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z();
    const double r2 = x * x + y * y;
    if (fisheye) {
      const double r = std::sqrt(r2), theta = std::atan(r), t2 = theta * theta;
      const double bent = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
      return {fx * x * bent / r + cx, fy * y * bent / r + cy};
    }
    const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
    return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)) + cy};
  };
}

// ---- nerfstudio: nerfstudio_dataparser.py (poses as they are: neither turned, centred nor scaled). ----

TakenByName AsNerfstudio(const fs::path& folder) {
  const json meta = JsonOf(folder / "transforms.json");
  TakenByName photographs;
  for (const json& frame : meta.at("frames")) {
    json keys = frame;
    keys.update(meta);  // what stands at the top is not looked for in a frame
    Matrix4d world_from_cam = MatrixOf(frame);
    world_from_cam.middleCols<2>(1) *= -1;  // x right, y up, z back
    photographs[Stem(frame.at("file_path"))] = {
        world_from_cam.inverse(), OpenCvLens(keys, meta.value("camera_model", "OPENCV") == "OPENCV_FISHEYE")};
  }
  return photographs;
}

// ---- instant-ngp: nerf_loader.h, nerf_matrix_to_ngp(); common_device.cuh, the lens. ----

struct NgpWorld {
  double scale = 0;
  Vector3d offset;
  // Positions come scaled and moved, then with their axes in turn.
  Vector3d Ngp(const Vector3d& p) const {
    const Vector3d moved = p * scale + offset;
    return {moved.y(), moved.z(), moved.x()};
  }
};

NgpWorld WorldOf(const json& meta) {
  const auto offset = meta.at("offset").get<std::vector<double>>();
  return {meta.at("scale").get<double>(), Vector3d(offset.at(0), offset.at(1), offset.at(2))};
}

TakenByName AsInstantNgp(const fs::path& folder) {
  const json meta = JsonOf(folder / "transforms.json");
  const NgpWorld world = WorldOf(meta);
  TakenByName photographs;
  for (const json& frame : meta.at("frames")) {
    json keys = meta;
    keys.update(frame);
    const Matrix4d nerf = MatrixOf(frame);
    // Columns 1 and 2 change sign: then y is down and z forward.
    Matrix4d ngp = Matrix4d::Identity();
    for (int c = 0; c < 3; ++c) {
      const Vector3d column = (c == 0 ? 1 : -1) * nerf.block<3, 1>(0, c);
      ngp.block<3, 1>(0, c) = Vector3d(column.y(), column.z(), column.x());
    }
    ngp.block<3, 1>(0, 3) = world.Ngp(nerf.block<3, 1>(0, 3));
    // Back to the source's world, so that it can be compared.
    Matrix4d ngp_from_world = Matrix4d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      ngp_from_world(axis, (axis + 1) % 3) = world.scale;
      ngp_from_world(axis, 3) = world.offset[(axis + 1) % 3];
    }
    ngp_from_world(3, 3) = 1;
    Matrix4d cam_from_world = ngp.inverse() * ngp_from_world;
    cam_from_world.topRows<3>() /= world.scale;
    // A lens all of whose coefficients are 0 is perspective.
    const bool bends = std::ranges::any_of(std::array{"k1", "k2", "k3", "k4"},
                                           [&](const char* key) { return keys.value(key, 0.0F) != 0; });
    const bool fisheye = keys.value("is_fisheye", false) && bends;
    EXPECT_TRUE(fisheye || keys.value("k3", 0.0) == 0);
    photographs[Stem(frame.at("file_path"))] = {cam_from_world, OpenCvLens(keys, fisheye)};
  }
  return photographs;
}

// ---- NeRF's synthetic sets: load_blender.py. ----

struct SyntheticSet {
  TakenByName all;
  std::size_t train = 0, val = 0, test = 0;
};

SyntheticSet AsBlenderLoader(const fs::path& folder) {
  SyntheticSet set;
  std::vector<cv::Size> sizes;
  for (auto& [part, count] :
       {std::pair("train", &set.train), std::pair("val", &set.val), std::pair("test", &set.test)}) {
    const json meta = JsonOf(folder / fmt::format("transforms_{}.json", part));
    for (const json& frame : meta.at("frames")) {
      ++*count;
      const cv::Mat image = cv::imread(
          (folder / (frame.at("file_path").get<std::string>() + ".png")).string(), cv::IMREAD_UNCHANGED);
      EXPECT_EQ(image.type(), CV_8UC4);
      sizes.push_back(image.size());
      const double width = image.cols, height = image.rows;
      const double focal = 0.5 * width / std::tan(0.5 * meta.at("camera_angle_x").get<double>());
      EXPECT_NEAR(0.5 * height / std::tan(0.5 * meta.at("camera_angle_y").get<double>()), focal, 1e-9)
          << "LichtFeld Studio refuses pictures that are not square without it";
      Matrix4d ours = MatrixOf(frame);
      ours.col(1) *= -1;
      ours.col(2) *= -1;
      set.all[Stem(frame.at("file_path"))] = {ours.inverse(), [=](const Vector3d& in_cam) -> Vector2d {
                                                return {focal * in_cam.x() / in_cam.z() + 0.5 * width,
                                                        focal * in_cam.y() / in_cam.z() + 0.5 * height};
                                              }};
    }
  }
  for (const cv::Size& size : sizes) EXPECT_EQ(size, sizes.front());
  return set;
}

// ---- RealityScan: the paper's equations, as realityscan_set.h has them. ----

TakenByName AsRealityScan(const fs::path& folder) {
  TakenByName photographs;
  for (const auto& entry : fs::directory_iterator(folder / "images")) {
    if (entry.path().extension() != ".xmp") continue;
    const std::string text = ReadWholeFile(entry.path());
    const auto value = [&](const std::string& key) {
      std::smatch found;
      const std::regex as_attribute("xcr:" + key + "=\"([^\"]*)\""), as_element("<xcr:" + key + ">([^<]*)<");
      EXPECT_TRUE(std::regex_search(text, found, as_attribute) || std::regex_search(text, found, as_element))
          << key;
      return found[1].str();
    };
    const auto number = [&](const std::string& key) { return NumbersIn(value(key)).at(0); };
    std::string image;
    for (const char* ending : {".png", ".jpg"})
      if (fs::path name = entry.path(); fs::exists(name.replace_extension(ending))) image = name.string();
    const cv::Size size = cv::imread(image).size();
    const double s = std::max(size.width, size.height), f = number("FocalLength35mm") / 36 * s;
    const double aspect = number("AspectRatio"), u = number("PrincipalPointU"), v = number("PrincipalPointV");
    const std::vector<double> k = NumbersIn(value("DistortionCoeficients")), r = NumbersIn(value("Rotation")),
                              c = NumbersIn(value("Position"));
    EXPECT_EQ(number("Skew"), 0);
    EXPECT_EQ(k.size(), 6u);
    const std::string model = value("DistortionModel");
    EXPECT_EQ(model == "perspective", k == std::vector<double>(6, 0)) << model;
    EXPECT_EQ(model == "brown3t2", k[4] != 0 || k[5] != 0) << model;
    Taken taken;
    for (int i = 0; i < 9; ++i) taken.cam_from_world(i / 3, i % 3) = r[i];
    taken.cam_from_world.block<3, 1>(0, 3) =
        -taken.cam_from_world.topLeftCorner<3, 3>() * Vector3d(c[0], c[1], c[2]);
    taken.project = [=](const Vector3d& in_cam) -> Vector2d {
      const double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z(), r2 = x * x + y * y;
      const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2 + k[3] * r2 * r2 * r2 * r2;
      return {
          0.5 * size.width + s * u + f * (x * radial + k[4] * (r2 + 2 * x * x) + 2 * k[5] * x * y),
          0.5 * size.height + s * v + aspect * f * (y * radial + k[5] * (r2 + 2 * y * y) + 2 * k[4] * x * y)};
    };
    photographs[entry.path().stem().string()] = taken;
  }
  return photographs;
}

// ---- Metashape: the manual's appendix "Camera models", as metashape_set.h has it. ----

TakenByName AsMetashape(const fs::path& folder) {
  const std::string text = ReadWholeFile(folder / "cameras.xml");
  const auto all = [](const std::string& in, const std::string& element) {
    std::vector<std::string> found;
    const std::regex pattern("<" + element + "[ >][\\s\\S]*?</" + element + ">");
    for (std::sregex_iterator it(in.begin(), in.end(), pattern), end; it != end; ++it)
      found.push_back(it->str());
    return found;
  };
  const auto attribute = [](const std::string& in, const std::string& name) {
    std::smatch found;
    EXPECT_TRUE(std::regex_search(in, found, std::regex(" " + name + "=\"([^\"]*)\""))) << name << in;
    return found[1].str();
  };
  const auto inside = [](const std::string& in, const std::string& name) {
    std::smatch found;
    return std::regex_search(in, found, std::regex("<" + name + ">([^<]*)<")) ? NumbersIn(found[1].str())
                                                                              : std::vector<double>{0};
  };
  std::map<std::string, std::function<Vector2d(const Vector3d&)>> lenses;
  for (const std::string& sensor : all(text, "sensor")) {
    const auto value = [&](const char* name) { return inside(sensor, name).at(0); };
    const double w = std::stod(attribute(sensor, "width")), h = std::stod(attribute(sensor, "height"));
    const bool fisheye = attribute(sensor, "type") == "fisheye";
    const double f = value("f"), b1 = value("b1"), cx = value("cx"), cy = value("cy"), k1 = value("k1"),
                 k2 = value("k2"), k3 = value("k3"), k4 = value("k4"), p1 = value("p1"), p2 = value("p2");
    lenses[attribute(sensor, "id")] = [=](const Vector3d& in_cam) -> Vector2d {
      double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z();
      if (fisheye) {
        const double r = std::hypot(x, y), bent = std::atan(r) / r;
        x *= bent;
        y *= bent;
      }
      const double r2 = x * x + y * y, r4 = r2 * r2;
      const double radial = 1 + k1 * r2 + k2 * r4 + k3 * r2 * r4 + k4 * r4 * r4;
      const double xd = x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
      const double yd = y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
      return {w / 2 + cx + xd * (f + b1), h / 2 + cy + yd * f};
    };
  }
  TakenByName photographs;
  for (const std::string& camera : all(text, "camera")) {
    const std::vector<double> rows = inside(camera, "transform");
    Matrix4d chunk_from_cam;
    for (int i = 0; i < 16; ++i) chunk_from_cam(i / 4, i % 4) = rows.at(static_cast<std::size_t>(i));
    photographs[attribute(camera, "label")] = {chunk_from_cam.inverse(),
                                               lenses.at(attribute(camera, "sensor_id"))};
  }
  return photographs;
}

// ---- What they make of it. ----

const std::vector<CameraModel> kLenses{test::Straight(), test::Lens()};
std::vector<CameraModel> And(std::vector<CameraModel> cameras, const CameraModel& more) {
  cameras.push_back(more);
  return cameras;
}

ExportSummary HandOver(const LightField& light_field, const fs::path& out, ExportForm form,
                       bool undistort = false) {
  return ExportLightField(light_field, out, {.form = form, .undistort = undistort});
}

// All projections of the source's points: through the distortion as it is, or the same ray through a pinhole.
void ExpectTheSources(const LightField& source, const TakenByName& taken, bool undistort) {
  ASSERT_EQ(taken.size(), source.views.size());
  std::vector<CameraModel> written = source.cameras;  // found once a camera: it takes long
  if (undistort)
    for (CameraModel& camera : written) camera = UndistortionOf(camera, "a camera").to;
  std::size_t compared = 0;
  for (const View& view : source.views) {
    const Taken& photograph = taken.at(Stem(view.image_path));
    EXPECT_LT((photograph.cam_from_world - view.cam_from_world.Matrix()).norm(), 1e-9);
    const CameraModel& from = source.CameraOf(view);
    const CameraModel& to = written[static_cast<std::size_t>(view.camera)];
    for (const ScenePoint& point : source.points) {
      const Vector3d in_cam = view.cam_from_world * point.position_in_world;
      const auto in_source = from.ImgFromCam(in_cam);
      if (!in_source || !from.Contains(*in_source)) continue;
      const Vector3d read_in_cam =
          (photograph.cam_from_world * point.position_in_world.homogeneous()).head<3>();
      EXPECT_LT((photograph.project(read_in_cam) - *to.ImgFromCam(in_cam)).norm(), 1e-3);
      ++compared;
    }
  }
  EXPECT_GT(compared, 150u);
}

// What our importer makes of it; `format` as on the command line.
void ExpectItComesBack(const LightField& source, const fs::path& out, const char* format, bool undistort) {
  const LightField read = ReadPosedSet(out, SetFormatFromName(format), {}).light_field;
  ASSERT_EQ(read.views.size(), source.views.size());
  for (const View& view : read.views) {
    const auto of_name = std::ranges::find_if(
        source.views, [&](const View& other) { return Stem(other.image_path) == Stem(view.image_path); });
    ASSERT_NE(of_name, source.views.end());
    EXPECT_LT((view.cam_from_world.Matrix() - of_name->cam_from_world.Matrix()).norm(), 1e-9);
    if (undistort) continue;
    for (const Vector3d& ray : {Vector3d(0.2, 0.1, 1), Vector3d(-0.3, 0.15, 1), Vector3d(0.1, -0.2, 1)})
      EXPECT_LT((*read.CameraOf(view).ImgFromCam(ray) - *source.CameraOf(*of_name).ImgFromCam(ray)).norm(),
                1e-6);
  }
}

TEST(HandedOver, NerfstudioHasThePosesAndLenses) {
  ScratchFolder scratch;
  // One kind of lens for all: perspective, or fisheye.
  for (const std::vector<CameraModel>& lenses : {kLenses, std::vector<CameraModel>{test::Fisheye()}}) {
    const std::string kind = lenses.size() == 1 ? "fisheye" : "perspective";
    const LightField source = TrackedLightField(scratch / kind, lenses, 8);
    for (const bool undistort : {false, true}) {
      const fs::path out = scratch / fmt::format("{}_{}", kind, undistort);
      HandOver(source, out, ExportForm::kNerfstudio, undistort);
      EXPECT_EQ(test::ReadAsNerfstudio(out), 8u);
      EXPECT_EQ(test::ReadAsBrush(out), 8u);
      ExpectTheSources(source, AsNerfstudio(out), undistort);
    }
  }
}

TEST(HandedOver, InstantNgpHasTheSubjectInItsCube) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", And(kLenses, test::Fisheye()), 9, true);
  for (const bool undistort : {false, true}) {
    const fs::path out = scratch / fmt::format("out{}", undistort);
    HandOver(source, out, ExportForm::kInstantNgp, undistort);
    EXPECT_EQ(test::ReadAsInstantNgp(out), 9u);
    ExpectTheSources(source, AsInstantNgp(out), undistort);
    ExpectItComesBack(source, out, "nerfstudio", undistort);
    const json meta = JsonOf(out / "transforms.json");
    const NgpWorld world = WorldOf(meta);
    EXPECT_LT((world.Ngp(source.subject->center_in_world) - Vector3d::Constant(0.5)).norm(), 1e-9);
    EXPECT_GT(world.scale * source.subject->radius, 0.25);  // it fills the cube
    EXPECT_LT(world.scale * source.subject->radius, 0.5);   // and is inside
    const int aabb = meta.at("aabb_scale");
    double reach = 0;
    for (const View& view : source.views)
      reach =
          std::max(reach, (world.Ngp(view.CenterInWorld()) - Vector3d::Constant(0.5)).cwiseAbs().maxCoeff());
    EXPECT_LE(reach, 0.5 * aabb);
    EXPECT_GT(reach, 0.25 * aabb);  // and is no larger than needed
  }
  // A pixel that is not 0 is left out.
  for (const View& view : source.views) {
    const cv::Mat dynamic = ReadImageFile(
        (scratch / "outfalse/images" / ("dynamic_mask_" + Stem(view.image_path) + ".png")).string());
    const cv::Mat mask = ReadViewMask(source, view);
    ASSERT_EQ(dynamic.type(), CV_8U);
    if (mask.empty())
      EXPECT_EQ(cv::countNonZero(dynamic), 0);
    else
      EXPECT_EQ(cv::countNonZero(dynamic != (mask == 0)), 0);
  }
  const LightField sixth = TrackedLightField(scratch / "sixth", {test::SixthOrder()});
  EXPECT_THAT([&] { HandOver(sixth, scratch / "no", ExportForm::kInstantNgp); },
              ThrowsMessage<Refusal>(testing::AllOf(HasSubstr("k3"), HasSubstr("give undistort"))));
  EXPECT_FALSE(fs::exists(scratch / "no"));
}

TEST(HandedOver, InstantNgpTakesAStraightFisheyeForOne) {
  ScratchFolder scratch;
  CameraModel straight = test::Fisheye();
  straight.coefficients = {};
  for (const std::vector<CameraModel>& lenses :
       {std::vector{straight}, std::vector{straight, test::Lens()}}) {
    const fs::path folder = scratch / fmt::format("lf{}", lenses.size()), out = folder.string() + "_ngp";
    const LightField source = TrackedLightField(folder, lenses);
    HandOver(source, out, ExportForm::kInstantNgp);
    ExpectTheSources(source, AsInstantNgp(out), false);
    ExpectItComesBack(source, out, "nerfstudio", false);
  }
}

// Without a subject the middle of the points fills the cube; with nothing to go by the way out is named.
TEST(HandedOver, InstantNgpTakesAPlaceWithoutASubject) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", kLenses);
  source.subject.reset();
  HandOver(source, scratch / "out", ExportForm::kInstantNgp);
  const NgpWorld world = WorldOf(JsonOf(scratch / "out/transforms.json"));
  std::size_t inside = 0;
  for (const ScenePoint& point : source.points)
    inside += (world.Ngp(point.position_in_world) - Vector3d::Constant(0.5)).cwiseAbs().maxCoeff() < 0.5;
  EXPECT_GT(inside, source.points.size() * 2 / 3);
  source.points.clear();
  for (View& view : source.views) view.cam_from_world.rotation.setIdentity();  // axes that never meet
  EXPECT_THAT([&] { HandOver(source, scratch / "no", ExportForm::kInstantNgp); },
              ThrowsMessage<Refusal>(HasSubstr("subject x,y,z,radius")));
}

TEST(HandedOver, NerfSyntheticSetIsTheSameScene) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", And(kLenses, test::Fisheye()), 20, true);
  source.up_in_world = Vector3d(0.1, -1, 0.2).normalized();
  const ExportSummary summary = HandOver(source, scratch / "out", ExportForm::kNerfSynthetic);
  const SyntheticSet set = AsBlenderLoader(scratch / "out");
  EXPECT_EQ(set.train, 17u);
  EXPECT_EQ(set.test, 3u);
  EXPECT_EQ(set.val, 3u);
  ASSERT_EQ(set.all.size(), 20u);
  EXPECT_THAT(summary.doubts, testing::Each(testing::Not(HasSubstr("mask"))));
  // One similarity leads from the source to the set.
  std::vector<Vector3d> from, to;
  std::vector<double> distances;
  for (const View& view : source.views) {
    from.push_back(view.CenterInWorld());
    to.push_back(set.all.at(Stem(view.image_path)).cam_from_world.inverse().block<3, 1>(0, 3));
    distances.push_back(to.back().norm());
  }
  const Similarity3 set_from_source = *AlignPoints(from, to);
  for (std::size_t i = 0; i < from.size(); ++i) EXPECT_LT((set_from_source * from[i] - to[i]).norm(), 1e-9);
  EXPECT_LT((set_from_source * source.subject->center_in_world).norm(), 1e-9);
  EXPECT_LT((set_from_source.rotation * *source.up_in_world - Vector3d::UnitZ()).norm(), 1e-9);
  std::ranges::nth_element(distances, distances.begin() + 10);
  EXPECT_NEAR(distances[10], 4, 0.1);
  const CameraModel& first = summary.cameras.front().to;
  for (const Undistortion& camera : summary.cameras) EXPECT_EQ(camera.to, first);
  EXPECT_EQ(first.fx, first.fy);
  for (const View& view : source.views) {
    const Taken& taken = set.all.at(Stem(view.image_path));
    EXPECT_LT((taken.cam_from_world.topLeftCorner<3, 3>() * set_from_source.rotation -
               view.cam_from_world.RotationMatrix())
                  .norm(),
              1e-9);
    for (const ScenePoint& point : source.points) {
      const Vector3d in_set = set_from_source * point.position_in_world;
      const Vector3d in_cam = view.cam_from_world * point.position_in_world;
      EXPECT_LT(
          (taken.project((taken.cam_from_world * in_set.homogeneous()).head<3>()) - *first.ImgFromCam(in_cam))
              .norm(),
          1e-3);
    }
  }
  const PosedSet back = ReadPosedSet(scratch / "out", std::nullopt, {});
  EXPECT_EQ(back.format, "NeRF, synthetic");
  EXPECT_EQ(back.light_field.views.size(), 20u);  // those of val are those of test
  // The photographs' alpha is the mask, moved with them.
  for (const View& view : source.views) {
    const std::size_t index = static_cast<std::size_t>(&view - source.views.data());
    const cv::Mat pixels = cv::imread(
        (scratch / "out" / (index % 8 == 0 ? "test" : "train") / (Stem(view.image_path) + ".png")).string(),
        cv::IMREAD_UNCHANGED);
    cv::Mat alpha;
    cv::extractChannel(pixels, alpha, 3);
    const CameraModel& lens = source.CameraOf(view);
    for (int v = 0; v < alpha.rows; v += 7)
      for (int u = 0; u < alpha.cols; u += 3) {
        const double x = lens.ImgFromCam(*first.RayFromImg({u + 0.5, v + 0.5}))->x();
        if (std::abs(x - lens.width / 2) < 1.5) continue;
        const bool used = view.mask_path.empty() || x > lens.width / 2;
        ASSERT_EQ(alpha.at<std::uint8_t>(v, u), used ? 255 : 0) << view.id << " " << u << " " << v;
      }
  }
}

TEST(HandedOver, NerfSyntheticSetSaysWhatIsCutOff) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", {test::Straight()});
  source.subject->radius = 2;
  EXPECT_THAT(HandOver(source, scratch / "out", ExportForm::kNerfSynthetic).doubts,
              testing::ElementsAre(HasSubstr("no view has a mask"), HasSubstr("near 2 and far 6")));
  source.subject.reset();
  for (View& view : source.views) view.cam_from_world.rotation.setIdentity();
  EXPECT_THAT([&] { HandOver(source, scratch / "no", ExportForm::kNerfSynthetic); },
              ThrowsMessage<Refusal>(HasSubstr("subject x,y,z,radius")));
  EXPECT_FALSE(fs::exists(scratch / "no"));
}

TEST(HandedOver, RealityScanHasThePosesAndLenses) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", And(kLenses, test::SixthOrder()), 9, true);
  for (const bool undistort : {false, true}) {
    const fs::path out = scratch / fmt::format("out{}", undistort);
    HandOver(source, out, ExportForm::kRealityScan, undistort);
    ExpectTheSources(source, AsRealityScan(out), undistort);
    ExpectItComesBack(source, out, "realityscan", undistort);
    for (const View& view : ReadPosedSet(out, std::nullopt, {}).light_field.views)
      EXPECT_EQ(view.mask_path, view.image_path + ".mask.png");
  }
  const LightField fisheye = TrackedLightField(scratch / "fisheye", {test::Lens(), test::Fisheye()});
  EXPECT_THAT([&] { HandOver(fisheye, scratch / "no", ExportForm::kRealityScan); },
              ThrowsMessage<Refusal>(testing::AllOf(HasSubstr("camera 2"), HasSubstr("give undistort"))));
  HandOver(fisheye, scratch / "straight", ExportForm::kRealityScan, true);
  ExpectTheSources(fisheye, AsRealityScan(scratch / "straight"), true);
}

TEST(HandedOver, MetashapeHasThePosesAndEveryLens) {
  ScratchFolder scratch;
  const LightField source =
      TrackedLightField(scratch / "lf", And(And(kLenses, test::SixthOrder()), test::Fisheye()), 9, true);
  for (const bool undistort : {false, true}) {
    const fs::path out = scratch / fmt::format("out{}", undistort);
    HandOver(source, out, ExportForm::kMetashape, undistort);
    ExpectTheSources(source, AsMetashape(out), undistort);
    ExpectItComesBack(source, out, "metashape", undistort);
    // Import Masks looks for {filename}_mask.png.
    for (const View& view : ReadPosedSet(out, std::nullopt, {}).light_field.views) {
      EXPECT_EQ(view.mask_path, "../masks/" + Stem(view.image_path) + "_mask.png");
      EXPECT_TRUE(fs::exists(out / "masks" / (Stem(view.image_path) + "_mask.png")));
    }
    EXPECT_GT(fs::file_size(out / "points.ply"), 60u * 15);
  }
}

// Forms that know a photograph by its name without the ending.
TEST(HandedOver, NamesAreToldApartWithoutTheirEndings) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", {test::Straight()});
  const auto rename = [&](std::size_t view, const std::string& name) {
    fs::rename(scratch / "lf" / source.views[view].image_path, scratch / "lf" / name);
    source.views[view].image_path = name;
  };
  rename(0, "images/a&b.one.png");
  rename(1, "images/a&b_one.png");
  for (const ExportForm form : {ExportForm::kInstantNgp, ExportForm::kNerfSynthetic, ExportForm::kRealityScan,
                                ExportForm::kMetashape}) {
    const fs::path out = scratch / fmt::format("out{}", static_cast<int>(form));
    HandOver(source, out, form);
    EXPECT_EQ(ReadPosedSet(out, std::nullopt, {}).light_field.views.size(), 8u);
  }
}

}  // namespace
}  // namespace ulf::handed_over_test

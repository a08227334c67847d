#include "tests/render/scenes/synthetic_views.h"
#include "tests/render/scenes/held_photograph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <random>

#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"

namespace ulf::test {

using Eigen::Vector3d;

std::vector<Vector3d> CapViewpoints(int count, double half_angle, double distance, double radial_jitter,
                                    unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-radial_jitter, radial_jitter);
  const double golden = M_PI * (3 - std::sqrt(5.0));
  std::vector<Vector3d> viewpoints;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (1 - std::cos(half_angle)) * (i + 0.5) / count;
    const double ring = std::sqrt(1 - z * z);
    const Vector3d direction(ring * std::cos(golden * i), ring * std::sin(golden * i), z);
    viewpoints.push_back(distance * (1 + jitter(random)) * direction);
  }
  return viewpoints;
}

std::vector<Vector3d> RingViewpoints(int count, double elevation, double distance, double noise,
                                     unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
  std::vector<Vector3d> viewpoints;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * M_PI * i / count;
    Vector3d c = distance * Vector3d(std::cos(elevation) * std::cos(a), std::cos(elevation) * std::sin(a),
                                     std::sin(elevation));
    if (noise > 0) c += Vector3d(normal(random), normal(random), normal(random));
    viewpoints.push_back(c);
  }
  return viewpoints;
}

std::vector<Vector3d> GridViewpoints(int columns, int rows, double spacing, double distance) {
  std::vector<Vector3d> viewpoints;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      viewpoints.emplace_back((x - 0.5 * (columns - 1)) * spacing, (y - 0.5 * (rows - 1)) * spacing,
                              distance);
  return viewpoints;
}

cv::Vec3f PlaneTexture(double x, double y) {
  const auto wave = [](double v) { return static_cast<float>(0.5 + 0.4 * std::sin(v)); };
  cv::Vec3f light(wave(3.1 * x + 1.0), wave(2.7 * y - 0.5 + x), wave(4.0 * x - 3.0 * y));
  const int tile = static_cast<int>(std::floor(2 * x)) + static_cast<int>(std::floor(2 * y));
  if (tile % 3 == 0) light *= 0.3f;
  return light;
}

std::shared_ptr<const TriangleMesh> PlaneAndSquare(double unit) {
  auto mesh = std::make_shared<TriangleMesh>();
  const auto add = [&](float half, float z) {
    const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
    for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
      mesh->vertices.push_back(static_cast<float>(unit) * Eigen::Vector3f(x, y, z));
    mesh->triangles.push_back({first, first + 1, first + 2});
    mesh->triangles.push_back({first, first + 2, first + 3});
  };
  add(100, 0);
  add(static_cast<float>(kSquareHalf), static_cast<float>(kSquareZ));
  return mesh;
}

std::vector<ScenePoint> PointsOfPlaneAndSquare(int on_plane, int on_square, double unit) {
  std::vector<ScenePoint> points;
  cv::RNG random(5);
  const auto add = [&](int count, double half, double z) {
    for (int i = 0; i < count; ++i) {
      const double x = random.uniform(-half, half), y = random.uniform(-half, half);
      points.push_back({unit * Vector3d(x, y, z)});
    }
  };
  add(on_plane, 2, 0);
  add(on_square, kSquareHalf, kSquareZ);
  return points;
}

cv::Mat LightOfPlane(const CameraModel& camera, const Rigid3& cam_from_world, bool with_square) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d center = cam_from_world.OriginInSource();
  cv::Mat linear(camera.height, camera.width, CV_32FC3, cv::Scalar::all(0.02));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto ray_in_cam = camera.RayFromImg({x + 0.5, y + 0.5});
      if (!ray_in_cam) continue;
      const Vector3d ray = world_from_cam.rotation * *ray_in_cam;
      if (with_square) {
        const double t = (kSquareZ - center.z()) / ray.z();
        const Vector3d point = center + t * ray;
        if (t > 0 && point.head<2>().cwiseAbs().maxCoeff() <= kSquareHalf) {
          linear.at<cv::Vec3f>(y, x) = PlaneTexture(5 * point.x() + 7, 5 * point.y() - 3);
          continue;
        }
      }
      const double t = -center.z() / ray.z();
      if (!(t > 0) || t > 100) continue;
      const Vector3d point = center + t * ray;
      linear.at<cv::Vec3f>(y, x) = PlaneTexture(point.x(), point.y());
    }
  return linear;
}

cv::Mat PhotographOfPlane(const CameraModel& camera, const Rigid3& cam_from_world, bool with_square) {
  return Srgb8FromLinear(LightOfPlane(camera, cam_from_world, with_square));
}

namespace {

CameraModel CameraOf(const SceneSpec& spec, std::size_t index) {
  CameraModel camera = CameraModel::Pinhole(spec.width, spec.height, spec.focal_px);
  camera.distortion = spec.distortion;
  if (spec.distortion == Distortion::kRadialTangential) camera.coefficients = {-0.12, 0.03, 0.002, -0.001, 0};
  if (spec.distortion == Distortion::kFisheye) camera.coefficients = {-0.03, 0.004, 0, 0, 0};
  if (spec.folds && spec.distortion == Distortion::kRadialTangential)
    camera.coefficients = {-0.25, 0, 0, 0, 0};
  if (spec.folds && spec.distortion == Distortion::kFisheye) camera.coefficients = {-0.27, 0, 0, 0, 0};
  if (spec.two_sizes && index % 3 == 2) camera = camera.ScaledTo(spec.width / 2, spec.height / 2);
  return camera;
}

ViewPyramid PyramidWithGaps(const SceneView& view, std::size_t index, bool with_square) {
  cv::Mat light = LightOfPlane(view.camera, view.cam_from_world, with_square);
  if (index % 5 == 0)
    light(cv::Rect(light.cols / 4, light.rows / 4, light.cols / 2, light.rows / 2)) =
        cv::Scalar::all(std::numeric_limits<float>::quiet_NaN());
  return MakeLinearPyramid(light);
}

std::shared_ptr<RenderScene> DrawScene(const SceneSpec& spec) {
  auto scene = std::make_shared<RenderScene>();
  scene->subject = {spec.unit * spec.subject.center_in_world, spec.unit * spec.subject.radius};
  scene->up_in_world = Vector3d::UnitY();
  for (std::size_t i = 0; i < spec.viewpoints.size(); ++i) {
    SceneView& view = scene->views.emplace_back();
    view.id = static_cast<int>(i);
    view.camera = CameraOf(spec, i);
    view.cam_from_world = LookAt(spec.viewpoints[i], spec.subject.center_in_world, Vector3d::UnitY());
    view.photograph = test::HoldPhotograph(
        spec.linear_with_gaps
            ? PyramidWithGaps(view, i, spec.with_square)
            : MakePyramid(PhotographOfPlane(view.camera, view.cam_from_world, spec.with_square)));
    view.center_in_world = spec.unit * spec.viewpoints[i];
    view.cam_from_world.translation *= spec.unit;
  }
  scene->mesh = MakeViewpointMesh(scene->Centers(), scene->subject);
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

}  // namespace

// The tests of a program ask for few scenes, again and again: the last ones are kept.
std::shared_ptr<RenderScene> MakeScene(const SceneSpec& spec) {
  constexpr std::size_t kMostKept = 12;
  static std::mutex mutex;
  static std::deque<std::pair<SceneSpec, std::shared_ptr<const RenderScene>>> kept;
  const std::lock_guard lock(mutex);
  auto known = std::ranges::find(kept, spec, [](const auto& one) -> const SceneSpec& { return one.first; });
  if (known == kept.end()) {
    if (kept.size() == kMostKept) kept.pop_front();
    kept.emplace_back(spec, DrawScene(spec));
    known = std::prev(kept.end());
  }
  return std::make_shared<RenderScene>(*known->second);
}

void WriteLightField(const std::filesystem::path& dir, const SceneSpec& spec, bool with_subject) {
  CaptureHeader header;
  header.camera = CameraOf(spec, 0);
  auto writer = LightFieldWriter::Create(dir, header);
  for (std::size_t i = 0; i < spec.viewpoints.size(); ++i) {
    View view;
    view.cam_from_world = LookAt(spec.viewpoints[i], spec.subject.center_in_world, Vector3d::UnitY());
    Frame frame;
    frame.image = {.pixels = PhotographOfPlane(header.camera, view.cam_from_world, spec.with_square),
                   .transfer = Transfer::kSrgb};
    frame.id = i;
    writer.AddView(frame, view);
  }
  if (with_subject) writer.SetSubject(spec.subject);
  writer.Close(1.0);
}

}  // namespace ulf::test

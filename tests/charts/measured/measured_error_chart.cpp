// The error that is measured at frames against the error that is there, on all simulated scenes: a light
// field that a hand has recorded, and frames that it saw besides; what render/prediction measures at these
// frames, and what is true there. Frames have noise, and poses the error that is asked for; true pictures and
// depths have neither.
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "acquisition/simulator/scene/scene.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/geometry/pinhole.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/prediction/prediction_error.h"
#include "render/proxy/proxy.h"
#include "render/quality/evaluate.h"
#include "render/scene/scene.h"
#include "render/stereo/growing_geometry.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

struct RecordedOptions {
  std::string scene = "studio";
  std::uint64_t seed = 1;
  double view_spacing = Radians(6);  // directions of recorded views are at least this far apart
  double pose_error_px = 0.3;        // of recorded views and of frames, at the subject, 640 pixels wide
  int frames = 24;
};

struct FrameMeasurement {
  PredictionError measured;
  double true_db = 0;        // of the renderer's picture, on the subject's disc, display-encoded grey
  double true_small_db = 0;  // the same of both pictures reduced and smoothed as those that are measured
  double true_px = 0;     // displacement on the disc, pixels of 320: root mean square, views by their weight
  double measure_ms = 0;  // processor time
};

constexpr int kSmallPx = 320;
constexpr double kPeak = 255;

SimulationOptions Simulated(const RecordedOptions& options, std::uint64_t seed) {
  SimulationOptions simulated;
  simulated.scene = options.scene;
  simulated.seed = seed;
  simulated.looks_away = false;
  simulated.sways_from_s = 1e6;
  simulated.row_spacing = std::min(options.view_spacing, Radians(19));
  return simulated;
}

// The pose, turned and moved by what an error of so many pixels is at the subject.
Rigid3 WithPoseError(const Rigid3& cam_from_world, const Subject& subject, double pixel_angle,
                     std::mt19937& random) {
  std::normal_distribution<double> error(0, pixel_angle / std::sqrt(2.0));
  const double distance = (cam_from_world * subject.center_in_world).norm();
  const Vector3d turn(error(random), error(random), error(random));
  const Vector3d move = distance * Vector3d(error(random), error(random), error(random));
  const Eigen::Quaterniond small(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return {small * cam_from_world.rotation, small * cam_from_world.translation + move};
}

double PsnrDb(const cv::Mat& difference, const cv::Mat& mask) {
  cv::Mat squared = difference.mul(difference);
  return 10 * std::log10(kPeak * kPeak / std::max(1e-3, cv::mean(squared, mask)[0]));
}

// As the pictures that are measured; reducing is linear, so that of a difference is that of both.
cv::Mat Small(const cv::Mat& grey) {
  const double scale = static_cast<double>(kSmallPx) / std::max(grey.cols, grey.rows);
  cv::Mat small;
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  return Smoothed(small);
}

cv::Mat GreyOf(const cv::Mat& srgb8) {
  cv::Mat grey;
  cv::cvtColor(srgb8, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  return grey;
}

// How far the proxy's point of a pixel lies off in the views that show it, by their shares.
double TrueMisregistration(const SimulatedCamera& camera, const Rigid3& pose, const Rigid3& assumed_pose,
                           const RenderScene& scene, const std::vector<Rigid3>& true_poses,
                           const PredictedFrame& predicted) {
  const CameraModel pinhole = camera.camera().WithoutDistortion();
  const cv::Mat depth = scene.proxy->Depth(pinhole, assumed_pose);
  std::vector<double> off;
  constexpr int kStep = 6;
  const double to_small = static_cast<double>(kSmallPx) / pinhole.width;
  for (int y = kStep / 2; y < pinhole.height; y += kStep)
    for (int x = kStep / 2; x < pinhole.width; x += kStep) {
      const Vector3d ray = PinholeRay(pinhole, x, y);
      const Vector3d center = pose * scene.subject.center_in_world;
      if (ray.cross(center).norm() > scene.subject.radius * ray.norm()) continue;
      const Rigid3 world_from_cam = pose.Inverse();
      const double length =
          camera.scene().DepthAlong(world_from_cam.translation, (world_from_cam.rotation * ray).normalized());
      const Vector3d truth = world_from_cam * (length * ray.normalized());
      const Vector3d shown = assumed_pose.Inverse() * (static_cast<double>(depth.at<float>(y, x)) * ray);
      double of_pixel = 0;
      for (const PredictedByView& view : predicted.views) {
        const auto id = static_cast<std::size_t>(view.id);
        const auto at = pinhole.ImgFromCam(true_poses[id] * truth);
        const auto wrong = pinhole.ImgFromCam(scene.views[id].cam_from_world * shown);
        if (at && wrong) of_pixel += view.weight * (*at - *wrong).squaredNorm();
      }
      off.push_back(std::sqrt(of_pixel));
    }
  return to_small * Median(std::move(off));
}

std::vector<FrameMeasurement> MeasureFrames(const RecordedOptions& options) {
  const SimulatedCamera camera(Simulated(options, options.seed));
  const Subject& subject = camera.scene().subject();
  std::mt19937 random(static_cast<unsigned>(options.seed));
  const double pixel_angle = options.pose_error_px / camera.camera().MeanFocalPx();

  auto scene = std::make_shared<RenderScene>();
  scene->subject = subject;
  scene->up_in_world = Vector3d::UnitZ();
  StereoViewMaker maker(kSmallPx);
  GrowingGeometry geometry;
  FramePredictor predictor;
  geometry.SetSubject(subject);
  std::vector<Rigid3> true_poses;
  std::vector<Vector3d> directions;
  const double end_s = dynamic_cast<const Hand&>(camera.hand()).FirstPassEndS();
  for (double time_s = 1; time_s < end_s; time_s += 0.05) {
    const Rigid3 pose = camera.hand().CamFromWorld(time_s);
    const Vector3d direction = (pose.OriginInSource() - subject.center_in_world).normalized();
    if (std::ranges::any_of(directions, [&](const Vector3d& other) {
          return AngleBetween(direction, other) < options.view_spacing;
        }))
      continue;
    directions.push_back(direction);
    const int id = static_cast<int>(true_poses.size());
    const Rigid3 assumed = WithPoseError(pose, subject, pixel_angle, random);
    const Frame frame = camera.Capture({.open_s = time_s, .id = static_cast<std::uint64_t>(id)});
    const StereoView small = maker.Make(Srgb8(frame.image), camera.camera(), assumed);
    geometry.AddView(id, small);
    predictor.AddView(id, small);
    true_poses.push_back(pose);
    SceneView view;
    view.id = id;
    view.camera = camera.camera();
    view.cam_from_world = assumed;
    view.center_in_world = assumed.OriginInSource();
    view.photograph = HoldPhotograph(MakePyramid(camera.CleanSrgb(pose)));
    scene->views.push_back(view);
  }
  scene->MakeMesh();
  geometry.MakeMissingMaps(1e9);
  MapsMesh made = MeshOfMaps(geometry.Maps(), subject, {.most_triangles = 30000});
  const auto mesh = std::make_shared<const TriangleMesh>(std::move(made.mesh));
  predictor.SetGeometry(subject, mesh);
  scene->proxy = std::make_shared<PlaneProxy>(subject);
  const auto with_mesh = WithProxy(*scene, std::make_shared<MeshProxy>(subject, mesh));
  GlRenderer renderer(with_mesh, {.field = {.kind = FieldKind::kSubdivision, .level = 1}});

  std::vector<FrameMeasurement> frames;
  const CameraModel pinhole = camera.camera().WithoutDistortion();
  HandOptions hand_options = dynamic_cast<const Hand&>(camera.hand()).options();
  hand_options.seed += 1000;
  hand_options.cap_azimuth *= 0.8;
  hand_options.cap_elevation *= 0.8;
  hand_options.margin = 0;
  const auto hand = std::make_shared<const Hand>(hand_options);
  const SimulatedCamera held(Simulated(options, options.seed), hand);
  for (int i = 0; i < options.frames; ++i) {
    const double time_s = hand->FirstPassEndS() * (0.1 + 0.9 * (i + 0.5) / options.frames);
    const Rigid3 pose = hand->CamFromWorld(time_s),
                 assumed = WithPoseError(pose, subject, pixel_angle, random);
    const Frame frame = held.Capture({.open_s = time_s, .id = static_cast<std::uint64_t>(5000 + i)});
    FrameMeasurement measurement;
    const double before_s = ThreadCpuSeconds();
    const StereoView small = maker.Make(Srgb8(frame.image), camera.camera(), assumed);
    const auto predicted = predictor.Predict(small);
    if (!predicted) continue;
    measurement.measured =
        MeasureError(small, *predicted, subject,
                     {.center_sigma = options.pose_error_px > 0
                                          ? std::optional(pixel_angle * camera.scene().FirstDistance())
                                          : std::optional(0.0)});
    measurement.measure_ms = 1e3 * (ThreadCpuSeconds() - before_s);
    SceneView truth = scene->views.front();
    truth.cam_from_world = pose;
    truth.photograph = HoldPhotograph(MakePyramid(camera.CleanSrgb(pose)));
    const UndistortedPhotograph photograph = Undistort(truth);
    const Rendering rendering = renderer.Render(pinhole, pose);
    cv::Mat disc = SubjectDisc(pinhole, pose, subject) & photograph.valid;
    const cv::Mat difference = GreyOf(Srgb8FromLinear(rendering.linear)) - GreyOf(photograph.srgb8);
    measurement.true_db = PsnrDb(difference, disc);
    measurement.true_small_db = PsnrDb(Small(difference), SubjectDisc(small.camera, pose, subject));
    measurement.true_px = TrueMisregistration(camera, pose, pose, *with_mesh, true_poses, *predicted);
    frames.push_back(measurement);
  }
  return frames;
}

struct Pairs {
  std::vector<double> measured, truth;

  void Add(double measured_value, double true_value) {
    measured.push_back(measured_value);
    truth.push_back(true_value);
  }
  static double Mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
  double Correlation() const {
    const double mean_measured = Mean(measured), mean_truth = Mean(truth);
    double both = 0, of_measured = 0, of_truth = 0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const double a = measured[i] - mean_measured, b = truth[i] - mean_truth;
      both += a * b;
      of_measured += a * a;
      of_truth += b * b;
    }
    return both / std::sqrt(of_measured * of_truth);
  }
  double Bias() const { return Mean(measured) - Mean(truth); }
};

constexpr char kSmall[] = "at the size that is measured, on the subject's disc",
               kFull[] = "against the renderer's picture at full size", kOff[] = "displacement";

Chart MeasureMeasuredErrors(const Effort& effort) {
  Table table;
  table.Panel(kSmall, {"true [dB]"}, MoreIsBetter({"measured [dB]"}),
              {.compared = false, .joined = false, .diagonal = true});
  table.Panel(kFull, {"true [dB]"}, MoreIsBetter({"measured [dB]"}), {.compared = false, .joined = false});
  table.Panel(kOff, {"true [px]"}, {"measured [px]"}, {.compared = false, .joined = false, .diagonal = true});
  Pairs db_small, db_full, px;
  std::vector<double> ms;
  for (const std::string& scene :
       effort.Of(std::vector<std::string>{"studio", "glass"}, acquisition::Scene::Names()))
    for (const double spacing : effort.Of(std::vector{10.0}, {6.0, 12.0}))
      for (const unsigned seed : effort.Seeds(2)) {
        const std::vector<FrameMeasurement> frames = MeasureFrames(
            {.scene = scene, .seed = seed, .view_spacing = Radians(spacing), .frames = effort.Of(4, 16)});
        const std::string name = fmt::format("{:g}", spacing);
        for (const FrameMeasurement& frame : frames) {
          const double db = frame.measured.inside.db, off_px = frame.measured.inside.misregistration_px;
          table.Add(kSmall, scene, name, frame.true_small_db, db);
          table.Add(kFull, scene, name, frame.true_db, db);
          table.Add(kOff, scene, name, frame.true_px, off_px);
          db_small.Add(db, frame.true_small_db);
          db_full.Add(db, frame.true_db);
          px.Add(off_px, frame.true_px);
          ms.push_back(frame.measure_ms);
        }
      }
  return {.found = fmt::format(
              "Over all {} frames: dB at the same size correlate by {:.2f}, bias {:+.1f} dB; against "
              "full size {:.2f}, {:+.1f} dB; displacements {:.2f}, {:+.2f} px. {:.0f} ms of processor a "
              "frame.",
              ms.size(), db_small.Correlation(), db_small.Bias(), db_full.Correlation(), db_full.Bias(),
              px.Correlation(), px.Bias(), Median(ms)),
          .panels = table.panels()};
}

CHART(measured_error, MeasureMeasuredErrors,
      "Measured errors: what frames say of the light field, against what is true", R"(All scenes of the
  simulator, views 6 and 12 degrees apart (the number beside a row), two seeds; frames with the sensor's
  noise, poses of views and frames off by 0.3 pixels, geometry from those views. A row: median, lowest and
  highest of 16 frames of each seed.)");

}  // namespace
}  // namespace ulf::test

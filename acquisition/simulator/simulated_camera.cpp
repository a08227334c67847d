#include "acquisition/simulator/simulated_camera.h"

#include <charconv>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/tripod.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr int kMostInstants = 64;  // of an exposure; guessed
constexpr int kRowsPerPose = 8;    // of a rolling shutter
constexpr int kMeterWidth = 32;    // pixels

std::uint64_t SeedOf(const DeviceUri& uri, std::uint64_t otherwise) {
  const auto text = uri.Option("seed");
  if (!text) return otherwise;
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), seed);
  if (error != std::errc() || end != text->data() + text->size())
    throw Refused(uri, fmt::format("seed must be a whole number, 0 or more, not '{}'", *text));
  return seed;
}

void ReadCap(const DeviceUri& uri, SimulationOptions& options) {
  const auto text = uri.Option("cap");
  if (!text) return;
  double width_deg = 0, height_deg = 0;
  char rest = 0;
  if (std::sscanf(text->c_str(), "%lfx%lf%c", &width_deg, &height_deg, &rest) != 2)
    throw Refused(uri, fmt::format("cap must be degrees WIDTHxHEIGHT, such as 60x40, not '{}'", *text));
  options.cap_azimuth = Radians(width_deg);
  options.cap_elevation = Radians(height_deg);
}

void RequireRange(const char* what, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw Refusal("", fmt::format("{:g}", value),
                  fmt::format("the simulated camera's {} is {:g}", what, value),
                  fmt::format("it must be {:g} to {:g}", low, high));
}

HandOptions HandFor(const SimulationOptions& options, const Scene& scene) {
  return {.subject_in_world = scene.subject().center_in_world,
          .up_in_world = scene.UpInWorld(),
          .first_direction = scene.FirstDirection(),
          .distance_m = scene.FirstDistance(),
          .cap_azimuth = options.cap_azimuth,
          .cap_elevation = options.cap_elevation,
          .row_spacing = options.row_spacing,
          .speed = options.speed,
          .dolly = options.dolly,
          .looks_away = options.looks_away,
          .seed = options.seed};
}

std::shared_ptr<const HandMotion> MotionFor(const SimulationOptions& options, const Scene& scene) {
  const HandOptions hand = HandFor(options, scene);
  if (!scene.IsTurntable()) return std::make_shared<Hand>(hand);
  const double stands_s = options.turn_speed > 0 ? 2 * M_PI / options.turn_speed : 15;
  return std::make_shared<Tripod>(hand, stands_s, options.unsteady);
}

// `colors`: of R G B; the radiance has B, G, R and a fourth channel.
cv::Mat InColors(const cv::Mat& radiance, const Eigen::Matrix3d& colors) {
  cv::Matx44f bgr = cv::Matx44f::eye();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      bgr(row, column) = static_cast<float>(colors(2 - row, 2 - column));
  cv::Mat out;
  cv::transform(radiance, out, bgr);
  return out;
}

cv::Mat InFourChannels(const cv::Mat& factors) {
  cv::Mat four;
  cv::merge(std::vector<cv::Mat>(4, factors), four);
  return four;
}

const SimulationOptions& Validated(const SimulationOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

SimulationOptions SimulationOptions::FromUri(const DeviceUri& uri) {
  uri.AllowOnly({"seed",       "fps",       "width",      "height",       "format",  "exposure_us",
                 "readout_ms", "gain_db",   "noise",      "cap",          "row_deg", "speed_deg_s",
                 "dolly",      "look_away", "duration_s", "sways_from_s", "sways_s", "lamp_k",
                 "crosstalk",  "fault",     "turn_deg_s", "unsteady"});
  SimulationOptions options;
  const auto read = [&](const char* key, double scale, double& value) {
    if (const auto number = uri.Number(key)) value = scale * *number;
  };
  const auto is_on = [&](const char* key, bool otherwise) {
    return uri.Whole(key, 0, 1).value_or(otherwise ? 1 : 0) == 1;
  };
  if (!uri.path.empty()) options.scene = uri.path;
  options.seed = SeedOf(uri, options.seed);
  options.width = uri.Whole("width", 0, 1 << 20).value_or(options.width);
  options.height = uri.Whole("height", 0, 1 << 20).value_or(options.height);
  if (const auto format = SensorFormatOf(uri)) options.format = *format;
  read("fps", 1, options.fps);
  read("exposure_us", 1e-6, options.exposure_s);
  read("readout_ms", 1e-3, options.readout_s);
  read("gain_db", 1, options.gain_db);
  read("duration_s", 1, options.duration_s);
  read("dolly", 1, options.dolly);
  read("sways_from_s", 1, options.sways_from_s);
  read("sways_s", 1, options.sways_s);
  read("unsteady", 1, options.unsteady);
  if (const auto degrees = uri.Number("turn_deg_s")) options.turn_speed = Radians(*degrees);
  if (const auto degrees = uri.Number("row_deg")) options.row_spacing = Radians(*degrees);
  if (const auto degrees = uri.Number("speed_deg_s")) options.speed = Radians(*degrees);
  ReadCap(uri, options);
  options.noise = is_on("noise", options.noise);
  options.looks_away = is_on("look_away", options.looks_away);
  options.colors = SensorColors::FromUri(uri);
  for (const auto& [key, text] : uri.options)
    if (key == "fault") options.faults.Add(text);
  options.Validate();
  return options;
}

void SimulationOptions::Validate() const {
  RequireRange("frame rate", fps, 0.1, 1000);
  RequireRange("width", width, 16, 4096);
  RequireRange("height", height, 16, 4096);
  RequireRange("exposure in microseconds", exposure_s * 1e6, 10, 1e6);
  RequireRange("readout in milliseconds (at most a frame's time)", readout_s * 1e3, 0, 1e3 / fps);
  RequireRange("gain in dB", gain_db, 0, 36);
  RequireRange("cap's width in degrees", Degrees(cap_azimuth), 1, 120);
  RequireRange("cap's height in degrees", Degrees(cap_elevation), 1, 50);
  RequireRange("row spacing in degrees", Degrees(row_spacing), 0.1, 20);
  RequireRange("speed in degrees per second", Degrees(speed), 0.1, 90);
  RequireRange("dolly (how many times nearer and farther it goes)", dolly, 1, 4);
  RequireRange("start of the swaying in seconds", sways_from_s, 0, 1e6);
  RequireRange("time of swaying in seconds", sways_s, 0, 1e6);
  RequireRange("turntable's speed in degrees per second", Degrees(turn_speed), 0, 360);
  RequireRange("unsteadiness (1: as a hand)", unsteady, 0, 10);
  if (!(duration_s > 0))
    throw Refusal("", fmt::format("{:g}", duration_s),
                  fmt::format("the simulated camera's duration is {:g} s", duration_s),
                  "it must be positive");
}

CameraModel SimulatedIntrinsics(int width, int height) {
  CameraModel camera = CameraModel::Pinhole(width, height, 0.875 * width);
  camera.cx += 0.006 * width;
  camera.cy -= 0.004 * width;
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.055, 0.021, 0.0004, -0.0003, 0};
  return camera;
}

namespace {

CameraModel LensOf(const SimulationOptions& options) {
  CameraModel camera = SimulatedIntrinsics(options.width, options.height);
  camera.fx *= options.faults.focal_ratio;
  camera.fy *= options.faults.focal_ratio;
  return camera;
}

}  // namespace

SimulatedCamera::SimulatedCamera(const SimulationOptions& options, std::shared_ptr<const HandMotion> hand)
    : options_(Validated(options)),
      caster_(Scene::Named(options.scene), LensOf(options)),
      hand_(hand ? std::move(hand) : MotionFor(options, caster_.scene())) {
  const SimulatedFaults& faults = options_.faults;
  if (faults.auto_exposure != AutoExposure::kOff)
    meter_ = std::make_unique<const RayCaster>(
        Scene::Named(options.scene),
        camera().ScaledTo(kMeterWidth, kMeterWidth * options.height / options.width));
  if (faults.dust_spots > 0) dust_ = DustSpots(camera(), faults.dust_spots, options_.seed);
}

CameraModel SimulatedCamera::StoredCamera() const {
  return SimulatedIntrinsics(options_.width, options_.height);
}

double SimulatedCamera::MeteredExposure(double open_s) const {
  constexpr double kMiddle = 0.2;  // share of full scale that the mean is brought to
  constexpr int kLooks = 5;
  constexpr double kApart_s = 0.1, kShortest_s = 1e-4, kLongest_s = 0.03;
  double log_mean = 0;
  for (int back = 1; back <= kLooks; ++back) {
    const double at_s = std::max(0.0, open_s - kApart_s * back);
    const cv::Scalar mean = cv::mean(meter_->Radiance(hand_->CamFromWorld(at_s), SwayAngle(at_s)));
    log_mean += std::log(0.114 * mean[0] + 0.587 * mean[1] + 0.299 * mean[2]) / kLooks;
  }
  return std::clamp(kReferenceExposure_s * kMiddle / std::exp(log_mean), kShortest_s, kLongest_s);
}

Frame SimulatedCamera::Capture(std::uint64_t index) const {
  const double open_s = static_cast<double>(index) / options_.fps;
  return Capture(index, meter_ ? MeteredExposure(open_s) : options_.exposure_s);
}

Frame SimulatedCamera::Capture(std::uint64_t index, double exposure_s) const {
  const double open_s = static_cast<double>(index) / options_.fps;
  return Capture({.open_s = open_s,
                  .exposure_s = exposure_s,
                  .gain = std::pow(10, options_.gain_db / 20),
                  .format = options_.format,
                  .id = index,
                  .light = options_.faults.Light(open_s)});
}

double SimulatedCamera::SwayAngle(double time_s) const {
  if (scene().IsTurntable()) return options_.turn_speed * time_s;
  return scene().SwayAngle(time_s - options_.sways_from_s, options_.sways_s);
}

Rigid3 SimulatedCamera::CamFromRest(double time_s) const {
  const Rigid3 cam_from_world = hand_->CamFromWorld(time_s);
  return scene().IsTurntable() ? cam_from_world * scene().MovedFromRest(SwayAngle(time_s)) : cam_from_world;
}

cv::Mat SimulatedCamera::MovingPixels(double time_s) const {
  return caster_.MovingPixels(hand_->CamFromWorld(time_s), SwayAngle(time_s));
}

double SimulatedCamera::BlurPx(double open_s, double exposure_s) const {
  const Rigid3 before = hand_->CamFromWorld(open_s), after = hand_->CamFromWorld(open_s + exposure_s);
  const Rigid3 world_from_before = before.Inverse();
  const double sway_before = SwayAngle(open_s), sway_after = SwayAngle(open_s + exposure_s);
  constexpr int kGrid = 5;
  double longest = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const int row = i / kGrid, column = i % kGrid;
    const Eigen::Vector2d img((column + 0.5) / kGrid * camera().width, (row + 0.5) / kGrid * camera().height);
    const auto ray = camera().RayFromImg(img);
    if (!ray) continue;
    const Eigen::Vector3d direction = world_from_before.rotation * *ray;
    const Hit hit = scene().FirstHit(world_from_before.translation, direction, sway_before);
    Eigen::Vector3d point = world_from_before.translation + hit.distance * direction;
    if (hit.part >= 0 && scene().primitives()[static_cast<std::size_t>(hit.part)].moves)
      point = scene().MovedFromRest(sway_after) * (scene().MovedFromRest(sway_before).Inverse() * point);
    const auto moved = camera().ImgFromCam(after * point);
    if (moved) longest = std::max(longest, (*moved - img).norm());
  }
  return longest;
}

Frame SimulatedCamera::Capture(const Shot& shot) const {
  const int instants =
      std::clamp(static_cast<int>(std::lround(BlurPx(shot.open_s, shot.exposure_s))), 1, kMostInstants);
  const SimulatedFaults& faults = options_.faults;
  cv::Mat radiance = cv::Mat::zeros(camera().height, camera().width, CV_32FC4);
  const int band = options_.readout_s > 0 ? kRowsPerPose : camera().height;
  for (int row = 0; row < camera().height; row += band) {
    const int end = std::min(row + band, camera().height);
    const double opens_s = shot.open_s + options_.readout_s * 0.5 * (row + end) / camera().height;
    const auto weight =
        static_cast<float>(faults.flicker.During(opens_s, shot.exposure_s, options_.seed) / instants);
    for (int i = 0; i < instants; ++i) {
      const double at_s = opens_s + (i + 0.5) / instants * shot.exposure_s;
      caster_.AccumulateRows(hand_->CamFromWorld(at_s), weight, row, end, radiance, SwayAngle(at_s));
    }
  }
  const double middle_s = shot.open_s + 0.5 * (shot.exposure_s + options_.readout_s);
  Defocus(radiance, faults.defocus_px + faults.hunting.BlurPx(middle_s));
  Breathe(radiance, camera(), faults.hunting.FocalRatio(middle_s));
  if (!dust_.empty()) cv::multiply(radiance, InFourChannels(dust_), radiance);
  const Eigen::Matrix3d camera_from_scene =
      options_.colors.CameraFromSrgb() *
      Eigen::Vector3d(shot.light[0], shot.light[1], shot.light[2]).asDiagonal();
  if (camera_from_scene != Eigen::Matrix3d::Identity()) radiance = InColors(radiance, camera_from_scene);
  Frame frame;
  frame.image = Expose(radiance, {shot.exposure_s, shot.gain, shot.format,
                                  options_.seed * 0x9E3779B97F4A7C15u + shot.id, options_.noise});
  frame.id = shot.id;
  frame.device_time_s = middle_s;
  if (faults.auto_exposure != AutoExposure::kUntold) frame.exposure_s = shot.exposure_s;
  frame.gain = shot.gain;
  frame.known_cam_from_world = CamFromRest(frame.device_time_s);
  return frame;
}

double SimulatedCamera::LightScale() const {
  return options_.exposure_s / kReferenceExposure_s * std::pow(10, options_.gain_db / 20);
}

cv::Mat SimulatedCamera::CleanLinear(const Rigid3& cam_from_world) const {
  return caster_.Radiance(cam_from_world) * LightScale();
}

cv::Mat SimulatedCamera::CleanSrgb(const Rigid3& cam_from_world) const {
  return Srgb8FromLinear(CleanLinear(cam_from_world));
}

}  // namespace ulf::acquisition

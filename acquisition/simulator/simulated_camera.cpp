#include "acquisition/simulator/simulated_camera.h"

#include <charconv>
#include <functional>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr int kMostInstants = 64;
constexpr int kRowsPerPose = 8;  // of a rolling shutter

// One option of a URI as a number; the whole text must be one.
double NumberFrom(const std::string& key, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError("sim: option {}: '{}' is not a number", key, text);
  return value;
}

std::uint64_t WholeFrom(const std::string& key, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw UsageError("sim: option {}: '{}' is not a whole number from 0 on", key, text);
  return value;
}

bool SwitchFrom(const std::string& key, const std::string& text) {
  if (text != "0" && text != "1") throw UsageError("sim: option {}: '{}' must be 0 or 1", key, text);
  return text == "1";
}

void ReadCap(const std::string& text, SimulationOptions& options) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos)
    throw UsageError("sim: option cap: '{}' must be degrees HxV, for example 60x40", text);
  options.cap_azimuth = Radians(NumberFrom("cap", text.substr(0, cross)));
  options.cap_elevation = Radians(NumberFrom("cap", text.substr(cross + 1)));
}

SensorFormat FormatFrom(const std::string& text) {
  const auto format = SensorFormatByName(text);
  if (!format)
    throw UsageError("sim: option format: '{}' is unknown; there are {}", text, SensorFormatNames());
  return *format;
}

using Setter = std::function<void(SimulationOptions&, const std::string& key, const std::string& text)>;
const std::vector<std::pair<std::string, Setter>>& Setters() {
  using O = SimulationOptions;
  using S = const std::string&;
  static const std::vector<std::pair<std::string, Setter>> setters = {
      {"seed", [](O& o, S k, S t) { o.seed = WholeFrom(k, t); }},
      {"fps", [](O& o, S k, S t) { o.fps = NumberFrom(k, t); }},
      {"width", [](O& o, S k,
                   S t) { o.width = static_cast<int>(std::min<std::uint64_t>(WholeFrom(k, t), 1u << 20)); }},
      {"height",
       [](O& o, S k, S t) {
         o.height = static_cast<int>(std::min<std::uint64_t>(WholeFrom(k, t), 1u << 20));
       }},
      {"format", [](O& o, S, S t) { o.format = FormatFrom(t); }},
      {"exposure_us", [](O& o, S k, S t) { o.exposure_s = 1e-6 * NumberFrom(k, t); }},
      {"readout_ms", [](O& o, S k, S t) { o.readout_s = 1e-3 * NumberFrom(k, t); }},
      {"gain_db", [](O& o, S k, S t) { o.gain_db = NumberFrom(k, t); }},
      {"noise", [](O& o, S k, S t) { o.noise = SwitchFrom(k, t); }},
      {"cap", [](O& o, S, S t) { ReadCap(t, o); }},
      {"row_deg", [](O& o, S k, S t) { o.row_spacing = Radians(NumberFrom(k, t)); }},
      {"speed_deg_s", [](O& o, S k, S t) { o.speed = Radians(NumberFrom(k, t)); }},
      {"look_away", [](O& o, S k, S t) { o.looks_away = SwitchFrom(k, t); }},
      {"duration_s", [](O& o, S k, S t) { o.duration_s = NumberFrom(k, t); }},
  };
  return setters;
}

void RequireRange(const char* what, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw UsageError("the simulated camera's {} is {:g}; it must be from {:g} to {:g}", what, value, low,
                     high);
}

HandOptions HandFor(const SimulationOptions& options, const Scene& scene) {
  HandOptions hand;
  hand.subject_in_world = scene.subject().center_in_world;
  hand.up_in_world = scene.UpInWorld();
  hand.first_direction = scene.FirstDirection();
  hand.distance_m = scene.FirstDistance();
  hand.cap_azimuth = options.cap_azimuth;
  hand.cap_elevation = options.cap_elevation;
  hand.row_spacing = options.row_spacing;
  hand.speed = options.speed;
  hand.looks_away = options.looks_away;
  hand.seed = options.seed;
  return hand;
}

const SimulationOptions& Validated(const SimulationOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

SimulationOptions SimulationOptions::FromUri(const DeviceUri& uri) {
  SimulationOptions options;
  if (!uri.path.empty()) options.scene = uri.path;
  std::vector<std::string> known;
  for (const auto& [key, setter] : Setters()) known.push_back(key);
  known.push_back("fault");
  uri.AllowOnly(known);
  for (const auto& [key, setter] : Setters())
    if (const auto text = uri.Option(key)) setter(options, key, *text);
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
  if (!(duration_s > 0))
    throw UsageError("the simulated camera's duration is {:g} s; it must be positive", duration_s);
}

CameraModel SimulatedIntrinsics(int width, int height) {
  CameraModel camera = CameraModel::Pinhole(width, height, 0.875 * width);
  camera.cx += 0.006 * width;
  camera.cy -= 0.004 * width;
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.055, 0.021, 0.0004, -0.0003, 0};
  return camera;
}

SimulatedCamera::SimulatedCamera(const SimulationOptions& options, std::shared_ptr<const HandMotion> hand)
    : options_(Validated(options)),
      caster_(Scene::Named(options.scene), SimulatedIntrinsics(options.width, options.height)),
      hand_(hand ? std::move(hand) : std::make_shared<Hand>(HandFor(options, caster_.scene()))) {}

Frame SimulatedCamera::Capture(std::uint64_t index) const {
  const double open_s = static_cast<double>(index) / options_.fps;
  return Capture({.open_s = open_s,
                  .exposure_s = options_.exposure_s,
                  .gain = std::pow(10, options_.gain_db / 20),
                  .format = options_.format,
                  .id = index,
                  .light = options_.faults.Light(open_s)});
}

double SimulatedCamera::BlurPx(double open_s, double exposure_s) const {
  const Rigid3 before = hand_->CamFromWorld(open_s), after = hand_->CamFromWorld(open_s + exposure_s);
  const Rigid3 world_from_before = before.Inverse();
  constexpr int kGrid = 5;
  double longest = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Eigen::Vector2d img((i % kGrid + 0.5) / kGrid * camera().width,
                              (i / kGrid + 0.5) / kGrid * camera().height);
    const auto ray = camera().RayFromImg(img);
    if (!ray) continue;
    const Eigen::Vector3d direction = world_from_before.rotation * *ray;
    const double distance = scene().DepthAlong(world_from_before.translation, direction);
    const auto moved = camera().ImgFromCam(after * (world_from_before.translation + distance * direction));
    if (moved) longest = std::max(longest, (*moved - img).norm());
  }
  return longest;
}

Frame SimulatedCamera::Capture(const Shot& shot) const {
  const int instants =
      std::clamp(static_cast<int>(std::lround(BlurPx(shot.open_s, shot.exposure_s))), 1, kMostInstants);
  cv::Mat radiance = cv::Mat::zeros(camera().height, camera().width, CV_32FC4);
  const int band = options_.readout_s > 0 ? kRowsPerPose : camera().height;
  for (int row = 0; row < camera().height; row += band) {
    const int end = std::min(row + band, camera().height);
    const double opens_s = shot.open_s + options_.readout_s * 0.5 * (row + end) / camera().height;
    for (int i = 0; i < instants; ++i) {
      const double share = (i + 0.5) / instants;
      caster_.AccumulateRows(hand_->CamFromWorld(opens_s + share * shot.exposure_s),
                             1.0f / static_cast<float>(instants), row, end, radiance);
    }
  }
  Frame frame;
  frame.image = Expose(
      radiance, {.noise = options_.noise},
      {shot.exposure_s * shot.light, shot.gain, shot.format, options_.seed * 0x9E3779B97F4A7C15u + shot.id});
  frame.id = shot.id;
  frame.device_time_s = shot.open_s + 0.5 * (shot.exposure_s + options_.readout_s);
  frame.exposure_s = shot.exposure_s;
  frame.gain = shot.gain;
  frame.known_cam_from_world = hand_->CamFromWorld(frame.device_time_s);
  return frame;
}

double SimulatedCamera::LightScale() const {
  return options_.exposure_s / SensorOptions{}.reference_exposure_s * std::pow(10, options_.gain_db / 20);
}

cv::Mat SimulatedCamera::CleanLinear(const Rigid3& cam_from_world) const {
  return caster_.Radiance(cam_from_world) * LightScale();
}

cv::Mat SimulatedCamera::CleanSrgb(const Rigid3& cam_from_world) const {
  return Srgb8FromLinear(CleanLinear(cam_from_world));
}

}  // namespace ulf::acquisition

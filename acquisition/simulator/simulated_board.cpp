#include "acquisition/simulator/simulated_board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/bench_device.h"
#include "acquisition/simulator/scene/noise.h"
#include "core/base/error.h"
#include "core/geometry/angles.h"
#include "core/geometry/sensor_window.h"
#include "core/geometry/small_matrices.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kCellsPerMm = 8;
constexpr double kPaperMarginMm = 12;
constexpr float kInkLight = 0.04f, kPaperLight = 0.8f, kRoomLight = 0.25f;  // radiances
constexpr double kStopS = 1.2;  // the time of one stop: half of it held still, half of it moved to the next

double UnitNumber(std::uint64_t seed, std::uint64_t index, int which) {
  return UnitFloat(
      HashLattice(static_cast<std::int32_t>(index), which, 17, static_cast<std::uint32_t>(seed)));
}

cv::Mat DarkCells(const Board& board) {
  cv::Mat cells = cv::Mat::zeros(static_cast<int>(std::ceil(board.HeightMm() * kCellsPerMm)),
                                 static_cast<int>(std::ceil(board.WidthMm() * kCellsPerMm)), CV_8UC1);
  const cv::Rect all(0, 0, cells.cols, cells.rows);
  for (const RectangleMm& r : board.Dark()) {
    const auto cell = [](double mm) { return static_cast<int>(std::lround(mm * kCellsPerMm)); };
    cells(cv::Rect({cell(r.x), cell(r.y)}, cv::Point(cell(r.x + r.width), cell(r.y + r.height))) & all) = 1;
  }
  return cells;
}

// cos^4 of an angle whose tangent grows with the distance from the middle.
cv::Mat VignettingOf(const CameraModel& camera, double lost_in_the_corner) {
  const double tangent = std::sqrt(1 / std::sqrt(1 - lost_in_the_corner) - 1);
  const Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
  cv::Mat light(camera.height, camera.width, CV_32FC1);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double t = tangent * (Vector2d(x + 0.5, y + 0.5) - middle).norm() / middle.norm();
      light.at<float>(y, x) = static_cast<float>(1 / std::pow(1 + t * t, 2));
    }
  return light;
}

cv::Mat DustOn(const CameraModel& camera, int spots, std::uint64_t seed) {
  cv::Mat light(camera.height, camera.width, CV_32FC1, cv::Scalar(1));
  for (int i = 0; i < spots; ++i) {
    const cv::Point at(static_cast<int>(UnitNumber(seed, static_cast<std::uint64_t>(i), 91) * camera.width),
                       static_cast<int>(UnitNumber(seed, static_cast<std::uint64_t>(i), 92) * camera.height));
    cv::circle(light, at, std::max(2, camera.width / 100), cv::Scalar(0.7), cv::FILLED);
  }
  return light;
}

}  // namespace

CameraModel SimulatedLens(const std::string& name, int width, int height) {
  CameraModel camera = CameraModel::Pinhole(width, height, 0.875 * width);
  camera.cx += 0.009 * width;
  camera.cy -= 0.006 * width;
  if (name == "pinhole") return camera;
  if (name == "barrel") {
    camera.distortion = Distortion::kRadialTangential;
    camera.coefficients = {-0.09, 0, 0, 0, 0};
  } else if (name == "wide") {
    camera.fx = camera.fy = 0.46 * width;
    camera.distortion = Distortion::kRadialTangential;
    camera.coefficients = {-0.21, 0.035, 0.0012, -0.0009, 0};
  } else if (name == "fisheye") {
    camera.fx = camera.fy = 0.37 * width;
    camera.distortion = Distortion::kFisheye;
    camera.coefficients = {0.03, -0.012, 0.004, -0.0004, 0};
  } else {
    throw Refused(fmt::format("lens '{}'", name), "there are pinhole, barrel, wide and fisheye");
  }
  return camera;
}

BoardScene::BoardScene(const BoardSceneOptions& options) : options_(options) {
  const CameraModel& camera = options_.camera;
  camera.Validate("the simulated camera");
  vignetting_ = VignettingOf(camera, options_.vignetting);
  dust_ = DustOn(camera, options_.dust, options_.seed);
  if (!options_.board) return;
  dark_ = DarkCells(*options_.board);
  corner_rays_.resize(static_cast<std::size_t>((camera.width + 1) * (camera.height + 1)), Vector3f::Zero());
  auto out = corner_rays_.begin();
  for (int y = 0; y <= camera.height; ++y)
    for (int x = 0; x <= camera.width; ++x, ++out)
      if (const auto ray = camera.RayFromImg({x, y})) *out = ray->cast<float>();
}

cv::Mat BoardScene::BoardLight(const Rigid3& cam_from_board) const {
  const CameraModel& camera = options_.camera;
  const double board_width = options_.board->WidthMm(), board_height = options_.board->HeightMm();
  // The points at which the rays of pixel corners meet the board, in millimetres; far outside for none.
  const Rigid3 board_from_cam = cam_from_board.Inverse();
  const Eigen::Matrix3f rotation = board_from_cam.RotationMatrix().cast<float>();
  const Vector3f eye = board_from_cam.translation.cast<float>();
  std::vector<Eigen::Vector2f> met(corner_rays_.size(), Eigen::Vector2f::Constant(-1e6f));
  for (std::size_t i = 0; i < met.size(); ++i) {
    const Vector3f ray = rotation * corner_rays_[i];
    // The printed side faces -z.
    if (eye.z() < 0 && ray.z() > 1e-6f) met[i] = (eye - ray * (eye.z() / ray.z())).head<2>();
  }
  const auto light_at = [&](float x, float y) {
    if (x >= 0 && y >= 0 && x < board_width && y < board_height)
      return dark_.at<std::uint8_t>(std::min(static_cast<int>(y * kCellsPerMm), dark_.rows - 1),
                                    std::min(static_cast<int>(x * kCellsPerMm), dark_.cols - 1))
                 ? kInkLight
                 : kPaperLight;
    const bool paper = x >= -kPaperMarginMm && y >= -kPaperMarginMm && x < board_width + kPaperMarginMm &&
                       y < board_height + kPaperMarginMm;
    return paper ? kPaperLight : kRoomLight;
  };
  constexpr int kSamples = 4;
  cv::Mat light(camera.height, camera.width, CV_32FC1);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width + 1) +
                             static_cast<std::size_t>(x);
      const Eigen::Vector2f a = met[at], b = met[at + 1],
                            c = met[at + static_cast<std::size_t>(camera.width) + 1],
                            d = met[at + static_cast<std::size_t>(camera.width) + 2];
      float sum = 0;
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i) {
          const float s = (static_cast<float>(i) + 0.5f) / kSamples,
                      t = (static_cast<float>(j) + 0.5f) / kSamples;
          const Eigen::Vector2f p = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d);
          sum += light_at(p.x(), p.y());
        }
      light.at<float>(y, x) = sum / (kSamples * kSamples);
    }
  return light;
}

cv::Mat BoardScene::CardLight(std::uint64_t noise_seed) const {
  const CameraModel& camera = options_.camera;
  const double direction = 2 * M_PI * UnitNumber(options_.seed, noise_seed, 5);
  cv::Mat light(camera.height, camera.width, CV_32FC1);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double along = std::cos(direction) * ((x + 0.5) / camera.width - 0.5) +
                           std::sin(direction) * ((y + 0.5) / camera.height - 0.5);
      light.at<float>(y, x) = static_cast<float>(options_.card_level * (1 + options_.gradient * along));
    }
  return light;
}

cv::Mat BoardScene::Light(const Rigid3& cam_from_board, std::uint64_t noise_seed) const {
  cv::Mat light = options_.board ? BoardLight(cam_from_board) : CardLight(noise_seed);
  if (options_.blur_px > 0) cv::GaussianBlur(light, light, {}, options_.blur_px);
  return light.mul(vignetting_).mul(dust_);
}

cv::Mat BoardScene::Render(const Rigid3& cam_from_board, std::uint64_t noise_seed) const {
  cv::Mat light = Light(cam_from_board, noise_seed);
  if (options_.noise_levels > 0) {
    cv::RNG random(options_.seed * 1000003 + noise_seed);
    cv::Mat noise(light.size(), CV_32FC1);
    random.fill(noise, cv::RNG::NORMAL, 0, options_.noise_levels / 255);
    light += noise;
  }
  cv::Mat pixels;
  light.convertTo(pixels, CV_8U, 255);
  return pixels;
}

// Visits the places of a 5 x 4 grid over the image in a scattered order; tilts and sizes vary independently.
Rigid3 BoardScene::Place(std::uint64_t stop) const {
  constexpr int kColumns = 5, kRows = 4, kJump = 7;  // coprime to the number of places
  const CameraModel& camera = options_.camera;
  const auto place = static_cast<int>((stop * kJump) % (kColumns * kRows));
  const double share = 0.32 + 0.3 * UnitNumber(options_.seed, stop, 1);  // of the image's width
  const auto across = [&](int cell, int cells, int which) {
    const double jitter = 0.06 * (UnitNumber(options_.seed, stop, which) - 0.5);
    return 0.16 + 0.68 * cell / (cells - 1) + jitter;
  };
  const Vector2d img(across(place % kColumns, kColumns, 2) * camera.width,
                     across(place / kColumns, kRows, 3) * camera.height);
  const Vector3d ray = camera.RayFromImg(img).value_or(Vector3d::UnitZ());
  const double distance = camera.MeanFocalPx() * options_.board->WidthMm() / (share * camera.width);

  const double tilt = Radians(8 + 34 * UnitNumber(options_.seed, stop, 4));
  const double about =
      2 * M_PI * (0.25 * static_cast<double>(stop % 4) + 0.15 * UnitNumber(options_.seed, stop, 5));
  const double roll = 0.7 * (UnitNumber(options_.seed, stop, 6) - 0.5);
  const Eigen::Quaterniond facing = TurnBetween(Vector3d::UnitZ(), ray);
  const Eigen::Quaterniond rotation = facing *
                                      Eigen::AngleAxisd(tilt, Vector3d(std::cos(about), std::sin(about), 0)) *
                                      Eigen::AngleAxisd(roll, Vector3d::UnitZ());
  const Vector3d middle(0.5 * options_.board->WidthMm(), 0.5 * options_.board->HeightMm(), 0);
  return {rotation, distance * ray - rotation * middle};
}

Rigid3 BoardScene::HeldAt(std::uint64_t stop, double share) const {
  if (!options_.board) return {};
  const Rigid3 from = Place(stop);
  if (share <= 0) return from;
  const Rigid3 to = Place(stop + 1);
  const double s = share * share * (3 - 2 * share);
  return {from.rotation.slerp(s, to.rotation), (1 - s) * from.translation + s * to.translation};
}

Rigid3 BoardScene::HeldAtTime(double time_s) const {
  const double stops = std::max(0.0, time_s) / kStopS;
  return HeldAt(static_cast<std::uint64_t>(stops), 2 * (stops - std::floor(stops)) - 1);
}

namespace {

SensorWindow WindowOf(const DeviceUri& uri, int width, int height) {
  SensorWindow window{width, height, 0, 0, width, height};
  window.binning_x = window.binning_y = static_cast<int>(uri.Number("binning", 1, 1, 8));
  if (const auto roi = uri.Option("roi")) {
    const bool read =
        std::sscanf(roi->c_str(), "%d,%d,%d,%d", &window.x, &window.y, &window.width, &window.height) == 4;
    if (!read || window.x < 0 || window.y < 0 || window.width < 32 || window.height < 32 ||
        window.x + window.width > width || window.y + window.height > height)
      throw Refused(uri.Text(),
                    fmt::format("roi={} is not X,Y,WIDTH,HEIGHT within {}x{}", *roi, width, height));
  }
  return window;
}

}  // namespace

BoardSceneOptions BoardSceneFromUri(const DeviceUri& uri, SensorWindow& window) {
  uri.AllowOnly({"board", "lens", "seed", "width", "height", "fps", "noise", "vignetting", "gradient", "dust",
                 "stops", "roi", "binning"});
  const int width = static_cast<int>(uri.Number("width", 640, 64, 8192));
  const int height = static_cast<int>(uri.Number("height", 480, 64, 8192));
  window = WindowOf(uri, width, height);
  BoardSceneOptions options;
  if (uri.path == "board") options.board = Board::Parse(uri.Option("board").value_or(Board().Text()));
  options.camera = ForWindow(SimulatedLens(uri.Option("lens").value_or("barrel"), width, height),
                             {width, height, 0, 0, width, height}, window);
  options.seed = static_cast<std::uint64_t>(uri.Number("seed", 7, 0, 1e9));
  options.noise_levels = uri.Number("noise", 1, 0, 50);
  options.vignetting = uri.Number("vignetting", uri.path == "card" ? 0.4 : 0, 0, 0.95);
  options.gradient = uri.Number("gradient", 0, 0, 1);
  options.dust = static_cast<int>(uri.Number("dust", 0, 0, 1000));
  return options;
}

std::unique_ptr<Device> OpenSimulatedBoard(const DeviceUri& uri) {
  SensorWindow window;
  const BoardSceneOptions options = BoardSceneFromUri(uri, window);
  const auto scene = std::make_shared<const BoardScene>(options);
  const double fps = uri.Number("fps", 15, 1, 1000), stops = std::floor(uri.Number("stops", 40, 1, 1e6));
  return MakeBenchDevice(
      {.uri = uri,
       .seed = options.seed,
       .camera = options.camera,
       .window = window,
       .fps = fps,
       .picture =
           [scene](std::uint64_t frame, double time_s) {
             return Image{scene->Render(scene->HeldAtTime(time_s), frame), Transfer::kLinear};
           },
       .is_over = [fps, stops](
                      std::uint64_t frames) { return static_cast<double>(frames) / fps >= kStopS * stops; }});
}

}  // namespace ulf::acquisition

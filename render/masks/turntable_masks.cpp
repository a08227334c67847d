#include "render/masks/turntable_masks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/fiducials/board.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "render/masks/background_cut.h"
#include "render/masks/silhouette_hull.h"
#include "render/masks/still_background.h"

namespace ulf::render {
namespace {

constexpr int kFewestViews = 8;        // needed to estimate a stand's background. Guessed.
constexpr int kMostCompared = 72;      // number of a stand's views for its background. Guessed.
constexpr int kMostSilhouettes = 120;  // for the hull. Guessed.

using Eigen::Vector3d;

struct Picture {
  CameraModel camera;  // of the picture's size
  Rigid3 cam_from_world;
  cv::Mat pixels;  // CV_8UC3
  cv::Mat board;   // CV_8U, 255 at the board, and what stands on it; empty: no board is known
  cv::Mat mask;    // CV_8U, 255: subject
};

CameraModel Reduced(const CameraModel& camera, int size_px) {
  const double scale = std::min(1.0, static_cast<double>(size_px) / std::max(camera.width, camera.height));
  return camera.ScaledTo(static_cast<int>(std::lround(scale * camera.width)),
                         static_cast<int>(std::lround(scale * camera.height)));
}

// The board hides the still background, and what hides the board turns with it. Empty when seen from below.
cv::Mat BoardIn(const Board& board, const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat covered = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  if (cam_from_world.OriginInSource().z() >= 0) return covered;
  const double width = 0.001 * board.WidthMm(), height = 0.001 * board.HeightMm();
  const Vector3d corners[] = {{0, 0, 0}, {width, 0, 0}, {width, height, 0}, {0, height, 0}};
  std::vector<cv::Point> outline;
  constexpr int kParts = 12;  // per side, since the lens bends it
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < kParts; ++i) {
      const Vector3d point = corners[side] + (corners[(side + 1) % 4] - corners[side]) * i / kParts;
      const auto img = camera.ImgFromCam(cam_from_world * point);
      if (!img || img->norm() > 1e5) return covered;
      outline.emplace_back(static_cast<int>(std::floor(img->x())), static_cast<int>(std::floor(img->y())));
    }
  cv::fillPoly(covered, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(255));
  return covered;
}

std::vector<Picture> PicturesOf(const LightField& light_field, const TurntableMaskOptions& options) {
  std::optional<Board> board;
  if (light_field.turntable && !light_field.turntable->board.empty())
    board = Board::Parse(light_field.turntable->board);
  std::vector<Picture> pictures(light_field.views.size());
  ParallelFor(pictures.size(), [&](std::size_t i) {
    const View& view = light_field.views[i];
    Picture& picture = pictures[i];
    picture.camera = Reduced(light_field.CameraOf(view), options.size_px);
    picture.cam_from_world = view.cam_from_world;
    cv::resize(Srgb8(ReadRecordedImage(light_field, view)), picture.pixels,
               {picture.camera.width, picture.camera.height}, 0, 0, cv::INTER_AREA);
    if (board) picture.board = BoardIn(*board, picture.camera, picture.cam_from_world);
  });
  return pictures;
}

double TurnBetweenPoses(const Rigid3& a, const Rigid3& b) {
  return RotationAngle(a.rotation * b.rotation.conjugate());
}

// Returns stands with enough views of one camera.
std::vector<Stand> UsableStands(const TurnAxis& axis, const LightField& light_field,
                                const std::vector<Rigid3>& poses) {
  const std::vector<int> stand_of = StandsOf(axis, poses);
  std::vector<Stand> stands;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool goes_on =
        i > 0 && stand_of[i] == stand_of[i - 1] &&
        light_field.CameraOf(light_field.views[i]) == light_field.CameraOf(light_field.views[i - 1]);
    if (!goes_on) stands.emplace_back();
    if (goes_on) stands.back().turned += TurnBetweenPoses(poses[i - 1], poses[i]);
    stands.back().views.push_back(static_cast<int>(i));
  }
  std::erase_if(stands,
                [&](const Stand& stand) { return static_cast<int>(stand.views.size()) < kFewestViews; });
  return stands;
}

cv::Mat Shifted(const cv::Mat& pixels, const cv::Point2d& by, int interpolation) {
  cv::Mat shifted;
  cv::warpAffine(pixels, shifted, cv::Matx23d(1, 0, by.x, 0, 1, by.y), pixels.size(),
                 interpolation | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return shifted;
}

// A stand's background and the shift of each view against it.
struct StandBackground {
  StillBackground background;
  std::vector<cv::Point2d> shifts;  // in the order of Stand::views
};

constexpr double kWorthShifting = 0.1;  // px; guessed

StandBackground EstimateStand(const std::vector<Picture>& pictures, const Stand& stand) {
  StandBackground estimated;
  estimated.shifts.assign(stand.views.size(), {});
  const double step = std::max(1.0, static_cast<double>(stand.views.size()) / kMostCompared);
  const auto learn = [&] {
    std::vector<cv::Mat> compared, turning;
    for (double at = 0; at < static_cast<double>(stand.views.size()); at += step) {
      const auto k = static_cast<std::size_t>(at);
      const Picture& picture = pictures[At(stand.views[k])];
      const bool shifts = std::hypot(estimated.shifts[k].x, estimated.shifts[k].y) > kWorthShifting;
      compared.push_back(shifts ? Shifted(picture.pixels, estimated.shifts[k], cv::INTER_LINEAR)
                                : picture.pixels);
      turning.push_back(shifts && !picture.board.empty()
                            ? Shifted(picture.board, estimated.shifts[k], cv::INTER_NEAREST)
                            : picture.board);
    }
    estimated.background = EstimateBackground(compared, turning);
  };
  learn();
  double largest = 0;
  std::vector<cv::Point2d> found(stand.views.size());
  ParallelFor(stand.views.size(), [&](std::size_t k) {
    found[k] = ShiftAgainst(estimated.background, pictures[At(stand.views[k])].pixels);
  });
  for (const cv::Point2d& shift : found) largest = std::max(largest, std::hypot(shift.x, shift.y));
  if (largest < kWorthShifting) return estimated;
  estimated.shifts = found;
  learn();
  return estimated;
}

// Removes components that touch neither the axis' surroundings nor the board: they are noise.
void KeepLargest(cv::Mat& mask) {
  cv::Mat parts, figures, middles;
  const int count = cv::connectedComponentsWithStats(mask, parts, figures, middles, 8, CV_32S);
  int largest = 0;
  for (int i = 1; i < count; ++i)
    if (largest == 0 || figures.at<int>(i, cv::CC_STAT_AREA) > figures.at<int>(largest, cv::CC_STAT_AREA))
      largest = i;
  constexpr double kWorthKeeping = 0.02;  // of the largest. Guessed.
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const int part = parts.at<int>(y, x);
      if (part != 0 && figures.at<int>(part, cv::CC_STAT_AREA) <
                           kWorthKeeping * figures.at<int>(largest, cv::CC_STAT_AREA))
        mask.at<std::uint8_t>(y, x) = 0;
    }
}

// Returns the mask's extent from a point, as seen by its camera; 0 if it is empty.
double ReachOf(const Picture& picture, const Vector3d& center_in_world) {
  const Vector3d center = picture.cam_from_world * center_in_world;
  double reach = 0;
  for (int y = 0; y < picture.mask.rows; y += 4)
    for (int x = 0; x < picture.mask.cols; x += 4) {
      if (picture.mask.at<std::uint8_t>(y, x) == 0) continue;
      if (const auto ray = picture.camera.RayFromImg({x + 0.5, y + 0.5}))
        reach = std::max(reach, ray->cross(center).norm());
    }
  return reach;
}

// Returns the point of the axis that the cameras look at.
Vector3d AimedAt(const TurnAxis& axis, const std::vector<Rigid3>& poses) {
  std::vector<double> along;
  for (const Rigid3& pose : poses) {
    const Vector3d eye = pose.OriginInSource(), look = pose.DirectionInSource(Vector3d::UnitZ());
    const Vector3d between = axis.point_in_world - eye;
    const double slant = look.dot(axis.direction_in_world), parallel = 1 - slant * slant;
    if (parallel < 1e-4) continue;  // the view is along the axis
    along.push_back((slant * look.dot(between) - axis.direction_in_world.dot(between)) / parallel);
  }
  return axis.point_in_world + (along.empty() ? 0 : Quantile(along, 0.5)) * axis.direction_in_world;
}

cv::Mat Grown(const cv::Mat& mask, double by_px) {
  const int side = 2 * std::max(1, static_cast<int>(std::ceil(by_px))) + 1;
  cv::Mat grown;
  cv::dilate(mask, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return grown;
}

cv::Mat Shrunk(const cv::Mat& mask, double by_px) {
  const int side = 2 * std::max(1, static_cast<int>(std::ceil(by_px))) + 1;
  cv::Mat shrunk;
  cv::erode(mask, shrunk, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1}, 1,
            cv::BORDER_CONSTANT, cv::Scalar(255));
  return shrunk;
}

class Masking {
 public:
  Masking(const LightField& light_field, const TurntableMaskOptions& options, Progress* progress)
      : light_field_(light_field), options_(options), progress_(progress) {}

  TurntableMasks Run() {
    FindStands();
    Show(0.02, "reading the views");
    pictures_ = PicturesOf(light_field_, options_);
    Show(0.15, "learning what stands still");
    for (std::size_t s = 0; s < result_.stands.size(); ++s) LearnStandAt(s);
    Show(0.35, "cutting the views from it");
    CutAll(nullptr, 0.35, 0.6);
    const SilhouetteHull hull = HullOfAll();
    Show(0.7, "cutting again by their hull");
    CutAll(&hull, 0.7, 0.98);
    return Finished(hull);
  }

 private:
  void Show(double share, const std::string& what) const {
    if (progress_) progress_->Show(share, what);
  }

  void FindStands() {
    for (const View& view : light_field_.views) poses_.push_back(view.cam_from_world);
    const auto axis = FitTurnAxis(poses_);
    if (!axis)
      throw Error(
          "{}: the views do not turn about one axis: either the subject did not turn, or the camera did not "
          "stand; the next time let the camera stand for a whole turn of the table, then take the next "
          "height",
          light_field_.root.string());
    result_.axis = *axis;
    result_.stands = UsableStands(*axis, light_field_, poses_);
    if (result_.stands.empty())
      throw Error(
          "{}: the camera nowhere stood for {} or more, and what stands still is told from what turns by "
          "them; the next time let it stand for a whole turn of the table",
          light_field_.root.string(), Counted(kFewestViews, "view"));
    stand_of_.assign(poses_.size(), -1);
    for (std::size_t s = 0; s < result_.stands.size(); ++s)
      for (const int view : result_.stands[s].views) stand_of_[At(view)] = static_cast<int>(s);
    result_.views_between = static_cast<int>(std::ranges::count(stand_of_, -1));
  }

  void LearnStandAt(std::size_t s) {
    stand_backgrounds_.push_back(EstimateStand(pictures_, result_.stands[s]));
    outside_.push_back(StillConnectedToRim(stand_backgrounds_.back().background));
    colors_.emplace_back(stand_backgrounds_.back().background, outside_.back());
    DropForeignColors(stand_backgrounds_.back().background, outside_.back(), colors_.back());
    for (const cv::Point2d& shift : stand_backgrounds_.back().shifts)
      result_.stands[s].shift_px = std::max(result_.stands[s].shift_px, std::hypot(shift.x, shift.y));
  }

  // Cuts again with the limits of a hull, if given.
  void CutAll(const SilhouetteHull* hull, double from_share, double to_share) {
    std::atomic<int> done = 0;
    for (std::size_t s = 0; s < result_.stands.size(); ++s) {
      const Stand& stand = result_.stands[s];
      ParallelFor(stand.views.size(), [&](std::size_t k) {
        Cut(pictures_[At(stand.views[k])], s, stand_backgrounds_[s].shifts[k], hull);
        ++done;
      });
      Show(from_share + (to_share - from_share) * done / static_cast<double>(pictures_.size()), "cutting");
    }
  }

  void Cut(Picture& picture, std::size_t s, const cv::Point2d& shift, const SilhouetteHull* hull) const {
    const StillBackground& background = stand_backgrounds_[s].background;
    const bool shifts = std::hypot(shift.x, shift.y) > kWorthShifting;
    const auto to_stand = [&](const cv::Mat& m, int interpolation) {
      return shifts && !m.empty() ? Shifted(m, shift, interpolation) : m;
    };
    const cv::Mat pixels = to_stand(picture.pixels, cv::INTER_LINEAR);
    cv::Mat labels = cv::Mat::zeros(picture.pixels.size(), CV_8U), leans = LeansByColor(pixels, s);
    labels.setTo(static_cast<int>(CutLabel::kStill), outside_[s]);
    if (hull && !hull->empty()) {
      const cv::Mat seen =
          to_stand(hull->ProjectedInto(picture.camera, picture.cam_from_world), cv::INTER_NEAREST);
      const double cell = hull->CellPx(picture.camera, picture.cam_from_world);
      constexpr float kOutside = -4, kInside = 6;  // guessed, logarithms of odds
      cv::add(leans, kOutside, leans, Grown(seen, 1) == 0);
      cv::add(leans, kInside, leans, Shrunk(seen, 2 * cell));
      labels.setTo(static_cast<int>(CutLabel::kStill), Grown(seen, 2 * cell + 2) == 0);
    }
    if (!picture.board.empty())
      labels.setTo(static_cast<int>(CutLabel::kTurning), to_stand(picture.board, cv::INTER_NEAREST));
    picture.mask = CutFromBackground(to_stand(picture.pixels, cv::INTER_LINEAR), background, labels, leans);
    if (shifts) picture.mask = Shifted(picture.mask, -shift, cv::INTER_NEAREST);
    KeepLargest(picture.mask);
  }

  // Leans towards the background, if unknown, as far as the pixel has one of its usual colours.
  cv::Mat LeansByColor(const cv::Mat& pixels, std::size_t s) const {
    constexpr float kUsual = 0.06f, kPerDecade = 2.5f;  // share of the outside; logarithms of odds. Guessed.
    cv::Mat leans = cv::Mat::zeros(pixels.size(), CV_32F);
    if (!colors_[s].IsReliable()) return leans;
    for (int y = 0; y < pixels.rows; ++y)
      for (int x = 0; x < pixels.cols; ++x) {
        const float unknown = 1 - stand_backgrounds_[s].background.known.at<float>(y, x);
        if (unknown <= 0) continue;
        const float share = colors_[s].ShareAround(pixels.at<cv::Vec3b>(y, x));
        if (share > kUsual) leans.at<float>(y, x) = -unknown * kPerDecade * std::log10(share / kUsual);
      }
    return leans;
  }

  SilhouetteHull HullOfAll() const {
    Vector3d center =
        light_field_.subject ? light_field_.subject->center_in_world : AimedAt(result_.axis, poses_);
    const Vector3d from = center - result_.axis.point_in_world;
    center = result_.axis.point_in_world +
             from.dot(result_.axis.direction_in_world) * result_.axis.direction_in_world;
    std::vector<double> reaches;
    std::vector<Silhouette> silhouettes;
    std::vector<const Picture*> cut;
    for (std::size_t i = 0; i < pictures_.size(); ++i)
      if (stand_of_[i] >= 0) cut.push_back(&pictures_[i]);
    const double step = std::max(1.0, static_cast<double>(cut.size()) / kMostSilhouettes);
    for (double at = 0; at < static_cast<double>(cut.size()); at += step) {
      const Picture& picture = *cut[static_cast<std::size_t>(at)];
      if (const double reach = ReachOf(picture, center); reach > 0) reaches.push_back(reach);
      silhouettes.push_back({picture.camera, picture.cam_from_world, picture.mask});
    }
    if (2 * reaches.size() < silhouettes.size())
      throw Error(
          "{}: nothing turns in most of the pictures, although the poses do: is the subject on the board, "
          "and in the picture?",
          light_field_.root.string());
    constexpr double kMargin = 1.05;
    return {silhouettes, center, kMargin * Quantile(reaches, 0.5)};
  }

  TurntableMasks Finished(const SilhouetteHull& hull) {
    double share = 0;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      Picture& picture = pictures_[i];
      if (stand_of_[i] < 0) {
        picture.mask = Shrunk(hull.ProjectedInto(picture.camera, picture.cam_from_world),
                              0.5 * hull.CellPx(picture.camera, picture.cam_from_world));
        if (!picture.board.empty()) picture.mask |= picture.board;
      }
      const View& view = light_field_.views[i];
      const CameraModel& camera = light_field_.CameraOf(view);
      cv::Mat& mask = result_.masks[view.id];
      cv::resize(picture.mask, mask, {camera.width, camera.height}, 0, 0, cv::INTER_LINEAR);
      mask = mask >= 128;
      share += static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
    }
    result_.turning_share = share / static_cast<double>(pictures_.size());
    return std::move(result_);
  }

  const LightField& light_field_;
  const TurntableMaskOptions options_;
  Progress* const progress_;
  TurntableMasks result_;
  std::vector<Rigid3> poses_;
  std::vector<int> stand_of_;  // by view; -1: none
  std::vector<Picture> pictures_;
  std::vector<StandBackground> stand_backgrounds_;  // by stand
  std::vector<cv::Mat> outside_;                    // by stand: CV_8U, 255 where nothing turns
  std::vector<BackgroundColors> colors_;            // by stand
};

}  // namespace

TurntableMasks MakeTurntableMasks(const LightField& light_field, const TurntableMaskOptions& options,
                                  Progress* progress) {
  return Masking(light_field, options, progress).Run();
}

TurntableMasks WriteTurntableMasks(const std::filesystem::path& dir, const TurntableMaskOptions& options) {
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  Progress progress("mask");
  TurntableMasks masks = MakeTurntableMasks(writer.Contents(), options, &progress);
  if (!writer.Contents().turntable) writer.SetTurntable({});
  writer.SetMasks(masks.masks);
  writer.Close(writer.Contents().capture_s, writer.Contents().reasons);
  return masks;
}

}  // namespace ulf::render

#include "render/masks/moved_masks.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/mesh_file.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

// Guessed, and tried on drawn hands and on sets in which nothing moved (docs/measured/rendering.md, "Masks of
// what moved"). Grey levels are of 255; windows are shares of the picture's longer side.
constexpr int kMovedNeighbours = 8, kFewestNeighbours = 3;
constexpr double kVisibleTolerance = 0.02;      // of the depth
constexpr double kMovedWindow = 0.012;          // half side of a correlation's window
constexpr float kStructure = 5;                 // standard deviation of a structured window
constexpr float kAlike = 0.6f, kUnlike = 0.3f;  // normalised correlation
constexpr float kSteadyAlike = 0.7f, kSteadyLevels = 8;
constexpr float kRougher = 2.5f, kRougherLevels = 5;       // a view's window against a plain prediction
constexpr float kOtherColor = 14, kSameLight = 1.3F;       // of L*a*b*
constexpr double kSmoothing = 0.02;                        // half side over which votes are counted
constexpr double kThinnest = 0.015;                        // half width of the thinnest part
constexpr double kLeastPart = 0.015, kLargestHole = 0.03;  // of the picture
constexpr double kLeastUnlike = 0.6;                       // of a part's judged pixels
constexpr double kLeastAgreeing = 0.02;                    // of the picture
constexpr double kMostPictureBytes = 1.5e9;                // of all reduced pictures and depths together

struct MovedPicture {
  CameraModel camera;  // of the picture's size
  Rigid3 cam_from_world;
  cv::Mat pixels;         // CV_8UC3
  cv::Mat mask;           // CV_8U, 0: excluded; empty: no mask
  CameraModel straight;   // without distortion; covers the picture
  cv::Mat inverse_depth;  // CV_32F, as `straight` sees the mesh; 0: no mesh
};

// Returns a camera without distortion that sees what `camera` does, up to some 75 degrees from the axis.
CameraModel StraightCamera(const CameraModel& camera) {
  constexpr double kLeastZ = 0.25;
  double right = 0.1, down = 0.1;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i)
    for (const Eigen::Vector2d& img : {Eigen::Vector2d(camera.width * i / kSteps, 0),
                                       Eigen::Vector2d(camera.width * i / kSteps, camera.height),
                                       Eigen::Vector2d(0, camera.height * i / kSteps),
                                       Eigen::Vector2d(camera.width, camera.height * i / kSteps)})
      if (const auto ray = camera.RayFromImg(img)) {
        const double z = std::max(ray->z(), kLeastZ);
        right = std::max(right, std::abs(ray->x()) / z);
        down = std::max(down, std::abs(ray->y()) / z);
      }
  const double focal_px = camera.MeanFocalPx();
  return CameraModel::Pinhole(static_cast<int>(2 * std::ceil(focal_px * right) + 2),
                              static_cast<int>(2 * std::ceil(focal_px * down) + 2), focal_px);
}

// Returns the mesh's inverse depth in this direction; 0 without a mesh.
float InverseDepthAlong(const MovedPicture& picture, const Vector3d& in_cam) {
  if (!(in_cam.z() > 0)) return 0;
  const auto img = picture.straight.ImgFromCam(in_cam);
  if (!img || !picture.straight.Contains(*img)) return 0;
  return picture.inverse_depth.at<float>(static_cast<int>(img->y()), static_cast<int>(img->x()));
}

std::vector<MovedPicture> MovedPicturesOf(const LightField& light_field, const TriangleMesh& mesh,
                                          int size_px) {
  std::vector<MovedPicture> pictures(light_field.views.size());
  constexpr double kBytesAPixel = 3 + 1 + 4;
  const double most_px = std::sqrt(kMostPictureBytes / kBytesAPixel / static_cast<double>(pictures.size()));
  ParallelFor(pictures.size(), [&](std::size_t i) {
    const View& view = light_field.views[i];
    const CameraModel& camera = light_field.CameraOf(view);
    const double scale = std::min({1.0, static_cast<double>(size_px) / std::max(camera.width, camera.height),
                                   most_px / std::max(camera.width, camera.height)});
    MovedPicture& picture = pictures[i];
    picture.camera = camera.ScaledTo(std::max(1, static_cast<int>(std::lround(scale * camera.width))),
                                     std::max(1, static_cast<int>(std::lround(scale * camera.height))));
    picture.cam_from_world = view.cam_from_world;
    cv::resize(Srgb8(ReadRecordedImage(light_field, view)), picture.pixels, SizeOf(picture.camera), 0, 0,
               cv::INTER_AREA);
    if (picture.pixels.channels() == 1) cv::cvtColor(picture.pixels, picture.pixels, cv::COLOR_GRAY2BGR);
    if (const cv::Mat mask = ReadViewMask(light_field, view); !mask.empty())
      cv::resize(mask, picture.mask, SizeOf(picture.camera), 0, 0, cv::INTER_NEAREST);
    picture.straight = StraightCamera(picture.camera);
    picture.inverse_depth = DrawInverseDepth(mesh, picture.straight, picture.cam_from_world);
  });
  return pictures;
}

// Returns the views that stand and look most alike, nearest first.
std::vector<std::size_t> MovedNeighboursOf(std::size_t view, const std::vector<MovedPicture>& pictures,
                                           double distance) {
  const auto eye = [&](std::size_t i) { return pictures[i].cam_from_world.OriginInSource(); };
  const auto look = [&](std::size_t i) {
    return pictures[i].cam_from_world.DirectionInSource(Vector3d::UnitZ());
  };
  std::vector<std::pair<double, std::size_t>> others;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (i != view)
      others.emplace_back((eye(i) - eye(view)).norm() / distance + AngleBetween(look(i), look(view)), i);
  const std::size_t count = std::min<std::size_t>(kMovedNeighbours, others.size());
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end());
  std::vector<std::size_t> nearest;
  for (std::size_t k = 0; k < count; ++k) nearest.push_back(others[k].second);
  return nearest;
}

// A neighbour's picture, drawn from a view's place over the mesh.
struct NeighbourDrawn {
  cv::Mat pixels;  // CV_32FC3
  cv::Mat gray;    // CV_32F
  cv::Mat valid;   // CV_8U, 255 where the neighbour sees the surface
};

NeighbourDrawn DrawFrom(const MovedPicture& view, const std::vector<Vector3d>& surface,
                        const MovedPicture& neighbour) {
  const cv::Size size = view.pixels.size();
  cv::Mat x(size, CV_32F, cv::Scalar(-10)), y(size, CV_32F, cv::Scalar(-10));
  NeighbourDrawn drawn;
  drawn.valid = cv::Mat::zeros(size, CV_8U);
  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column) {
      const Vector3d& point = surface[At(row * size.width + column)];
      if (!point.allFinite()) continue;
      const Vector3d in_cam = neighbour.cam_from_world * point;
      if (!(in_cam.z() > 0)) continue;
      const auto img = neighbour.camera.ImgFromCam(in_cam);
      if (!img || !neighbour.camera.Contains(*img)) continue;
      if (InverseDepthAlong(neighbour, in_cam) > (1 + kVisibleTolerance) / in_cam.z()) continue;
      if (!neighbour.mask.empty() &&
          neighbour.mask.at<std::uint8_t>(static_cast<int>(img->y()), static_cast<int>(img->x())) == 0)
        continue;
      x.at<float>(row, column) = static_cast<float>(img->x() - 0.5);
      y.at<float>(row, column) = static_cast<float>(img->y() - 0.5);
      drawn.valid.at<std::uint8_t>(row, column) = 255;
    }
  cv::Mat pixels;
  cv::remap(neighbour.pixels, pixels, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  pixels.convertTo(drawn.pixels, CV_32F);
  return drawn;
}

cv::Mat GrayOf(const cv::Mat& pixels) {
  cv::Mat gray;
  cv::cvtColor(pixels, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

// Means, variances and correlations in windows, of valid pixels alone.
class MaskWindows {
 public:
  MaskWindows(const cv::Mat& valid, int half_side) : side_(2 * half_side + 1, 2 * half_side + 1) {
    valid.convertTo(valid_, CV_32F, 1 / 255.0);
    cv::blur(valid_, share_, side_, {-1, -1}, cv::BORDER_CONSTANT);
    cv::max(share_, 1e-3, share_);
  }
  cv::Mat Mean(const cv::Mat& values) const {
    cv::Mat mean;
    cv::blur(values.mul(valid_), mean, side_, {-1, -1}, cv::BORDER_CONSTANT);
    return mean / share_;
  }
  cv::Mat Deviation(const cv::Mat& values) const {
    const cv::Mat mean = Mean(values);
    cv::Mat variance = Mean(values.mul(values)) - mean.mul(mean), deviation;
    cv::max(variance, 0, variance);
    cv::sqrt(variance, deviation);
    return deviation;
  }
  // Normalised; noise of about a level counts, so that plain windows correlate with nothing.
  cv::Mat Correlation(const cv::Mat& a, const cv::Mat& b) const {
    const cv::Mat covariance = Mean(a.mul(b)) - Mean(a).mul(Mean(b));
    return covariance / (Deviation(a) + 1).mul(Deviation(b) + 1);
  }

 private:
  cv::Size side_;
  cv::Mat valid_, share_;
};

double MedianOf(const cv::Mat& values, const cv::Mat& where) {
  std::vector<double> chosen;
  constexpr int kStep = 3;
  for (int y = 0; y < values.rows; y += kStep)
    for (int x = 0; x < values.cols; x += kStep)
      if (where.at<std::uint8_t>(y, x) != 0) chosen.push_back(values.at<float>(y, x));
  constexpr std::size_t kFewest = 30;
  return chosen.size() < kFewest ? std::numeric_limits<double>::quiet_NaN() : Median(std::move(chosen));
}

// Scales the channels of `pixels` (CV_32FC3) so that their medians over `where` become those of `like`.
void EvenOut(const cv::Mat& like, const cv::Mat& where, cv::Mat& pixels) {
  std::array<cv::Mat, 3> own, other;
  cv::split(pixels, own.data());
  cv::split(like, other.data());
  for (std::size_t c = 0; c < 3; ++c) {
    const cv::Mat ratio = (other[c] + 2) / (own[c] + 2);
    if (const double gain = MedianOf(ratio, where); std::isfinite(gain)) own[c] *= gain;
  }
  cv::merge(own.data(), 3, pixels);
}

// Holds what the neighbours predict of a view.
struct MovedPrediction {
  cv::Mat pixels;  // CV_32FC3
  cv::Mat valid;   // CV_8U, 255 where enough neighbours see the surface
  cv::Mat steady;  // CV_8U, 255 where they agree with each other
};

MovedPrediction PredictFrom(std::vector<NeighbourDrawn> drawn, cv::Size size, int window) {
  MovedPrediction predicted{cv::Mat(size, CV_32FC3, cv::Scalar::all(0)), cv::Mat::zeros(size, CV_8U),
                            cv::Mat::zeros(size, CV_8U)};
  for (std::size_t k = 1; k < drawn.size(); ++k)
    EvenOut(drawn[0].pixels, drawn[0].valid & drawn[k].valid, drawn[k].pixels);
  std::vector<float> of_channel;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      cv::Vec3f& median = predicted.pixels.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) {
        of_channel.clear();
        for (const NeighbourDrawn& each : drawn)
          if (each.valid.at<std::uint8_t>(y, x) != 0)
            of_channel.push_back(each.pixels.at<cv::Vec3f>(y, x)[c]);
        if (static_cast<int>(of_channel.size()) < kFewestNeighbours) break;
        std::ranges::nth_element(of_channel,
                                 of_channel.begin() + static_cast<std::ptrdiff_t>(of_channel.size() / 2));
        median[c] = of_channel[of_channel.size() / 2];
        predicted.valid.at<std::uint8_t>(y, x) = 255;
      }
    }
  const cv::Mat median = GrayOf(predicted.pixels);
  std::vector<cv::Mat> alike, apart;
  cv::Mat deviation;
  for (NeighbourDrawn& each : drawn) {
    const MaskWindows windows(each.valid & predicted.valid, window);
    const cv::Mat gray = GrayOf(each.pixels);
    alike.push_back(windows.Correlation(gray, median));
    apart.push_back(windows.Mean(cv::abs(gray - median)));
  }
  deviation = MaskWindows(predicted.valid, window).Deviation(median);
  std::vector<double> of_alike, of_apart;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (predicted.valid.at<std::uint8_t>(y, x) == 0) continue;
      of_alike.clear();
      of_apart.clear();
      for (std::size_t k = 0; k < drawn.size(); ++k)
        if (drawn[k].valid.at<std::uint8_t>(y, x) != 0) {
          of_alike.push_back(alike[k].at<float>(y, x));
          of_apart.push_back(apart[k].at<float>(y, x));
        }
      const bool is_structured = deviation.at<float>(y, x) >= kStructure;
      if (is_structured ? Median(of_alike) >= kSteadyAlike : Median(of_apart) <= kSteadyLevels)
        predicted.steady.at<std::uint8_t>(y, x) = 255;
    }
  return predicted;
}

// Returns the best correlation of the prediction with the view, moved by up to `reach` pixels.
cv::Mat MovedCorrelation(const MaskWindows& windows, const cv::Mat& predicted, const cv::Mat& gray,
                         float reach) {
  cv::Mat best(gray.size(), CV_32F, cv::Scalar(-1)), moved;
  for (const float dy : {0.f, -reach, reach})
    for (const float dx : {0.f, -reach, reach}) {
      cv::warpAffine(gray, moved, cv::Matx23f(1, 0, dx, 0, 1, dy), gray.size(), cv::INTER_LINEAR,
                     cv::BORDER_REPLICATE);
      cv::max(best, windows.Correlation(moved, predicted), best);
    }
  return best;
}

// Returns the mean colours (CV_32FC3, 0 to 1) in windows.
cv::Mat ColorsAround(const cv::Mat& pixels, int window) {
  cv::Mat smooth;
  cv::blur(pixels, smooth, {2 * window + 1, 2 * window + 1});
  return smooth / 255;
}

// Returns L*a*b* of colours whose light is multiplied by `times` (CV_32F, at most fourfold; empty: 1):
// without it a surface in shadow has less colour.
cv::Mat InLab(const cv::Mat& colors, const cv::Mat& times) {
  cv::Mat lit = colors.clone(), lab;
  constexpr float kMostTimes = 4;
  if (!times.empty())
    for (int y = 0; y < lit.rows; ++y)
      for (int x = 0; x < lit.cols; ++x)
        lit.at<cv::Vec3f>(y, x) *= std::clamp(times.at<float>(y, x), 1 / kMostTimes, kMostTimes);
  cv::cvtColor(lit, lab, cv::COLOR_BGR2Lab);
  return lab;
}

// Returns votes, CV_32F: 1 where the view shows something else than predicted, -1 where it shows the same, 0
// where neither can be told.
cv::Mat Votes(const MovedPicture& view, const MovedPrediction& predicted, int window) {
  cv::Mat pixels;
  view.pixels.convertTo(pixels, CV_32F);
  const MaskWindows windows(predicted.valid, window);
  const cv::Mat median = GrayOf(predicted.pixels), structure = windows.Deviation(median);
  const cv::Mat alike =
      MovedCorrelation(windows, median, GrayOf(pixels), std::max(1.f, 0.1f * static_cast<float>(window)));
  EvenOut(predicted.pixels, predicted.steady & (alike > kAlike) & (structure >= kStructure), pixels);
  const cv::Mat own_structure = windows.Deviation(GrayOf(pixels));
  const cv::Mat own_color = ColorsAround(pixels, window),
                median_color = ColorsAround(predicted.pixels, window);
  const cv::Mat darker = (GrayOf(median_color) + 2 / 255.F) / (GrayOf(own_color) + 2 / 255.F);
  const cv::Mat own_lab = InLab(own_color, darker), median_lab = InLab(median_color, cv::Mat());
  cv::Mat votes = cv::Mat::zeros(median.size(), CV_32F);
  for (int y = 0; y < votes.rows; ++y)
    for (int x = 0; x < votes.cols; ++x) {
      if (predicted.steady.at<std::uint8_t>(y, x) == 0) continue;
      if (!view.mask.empty() && view.mask.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Vec3f apart = own_lab.at<cv::Vec3f>(y, x) - median_lab.at<cv::Vec3f>(y, x);
      const bool is_other_color = std::hypot(apart[1], apart[2]) > kOtherColor;
      const float times = darker.at<float>(y, x);
      float& vote = votes.at<float>(y, x);
      if (const float structured = structure.at<float>(y, x); structured >= kStructure) {
        const float like = alike.at<float>(y, x);
        vote = like >= kAlike ? -1.f : like < kUnlike || is_other_color ? 1.f : 0.f;
      } else if (is_other_color || own_structure.at<float>(y, x) > kRougher * structured + kRougherLevels) {
        vote = 1;
      } else if (times < kSameLight && times > 1 / kSameLight) {
        vote = -1;
      }
    }
  return votes;
}

// Fills holes up to this many pixels.
void FillHolesUpTo(double most_px, cv::Mat& parts) {
  cv::Mat labels, figures, middles;
  const int count = cv::connectedComponentsWithStats(parts == 0, labels, figures, middles, 4, CV_32S);
  for (int i = 1; i < count; ++i)
    if (figures.at<int>(i, cv::CC_STAT_AREA) <= most_px) parts.setTo(255, labels == i);
}

// Returns the large parts that differ, CV_8U, 255 there.
cv::Mat LargeUnlikeParts(const cv::Mat& votes) {
  const double side = std::max(votes.cols, votes.rows), total = static_cast<double>(votes.total());
  const cv::Mat parts_none = cv::Mat::zeros(votes.size(), CV_8U);
  if (cv::countNonZero(votes < 0) < kLeastAgreeing * total) return parts_none;
  const auto ellipse = [&](double share) {
    const int half = std::max(1, static_cast<int>(std::lround(share * side)));
    return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1});
  };
  const int half = std::max(1, static_cast<int>(std::lround(kSmoothing * side)));
  cv::Mat smooth;
  cv::blur(votes, smooth, {2 * half + 1, 2 * half + 1});
  cv::Mat parts = smooth > 0.1;
  cv::morphologyEx(parts, parts, cv::MORPH_OPEN, ellipse(kThinnest), {-1, -1}, 1, cv::BORDER_REPLICATE);
  FillHolesUpTo(kLargestHole * total, parts);
  cv::Mat labels, kept = parts_none;
  const int count = cv::connectedComponents(parts, labels, 8, CV_32S);
  for (int i = 1; i < count; ++i) {
    const cv::Mat part = labels == i;
    const double unlike = cv::countNonZero(part & (votes > 0)), alike = cv::countNonZero(part & (votes < 0));
    if (cv::countNonZero(part) >= kLeastPart * total && unlike >= kLeastUnlike * (unlike + alike))
      kept.setTo(255, part);
  }
  return kept;
}

cv::Mat HiddenPartsOf(std::size_t view, const std::vector<MovedPicture>& pictures, double distance,
                      double& judged_share) {
  const MovedPicture& own = pictures[view];
  std::vector<Vector3d> surface(own.pixels.total(), Vector3d::Constant(std::nan("")));
  std::vector<double> depths;
  for (int y = 0; y < own.pixels.rows; ++y)
    for (int x = 0; x < own.pixels.cols; ++x) {
      const auto ray = own.camera.RayFromImg({x + 0.5, y + 0.5});
      const float inverse = ray ? InverseDepthAlong(own, *ray) : 0;
      if (inverse > 0)
        surface[At(y * own.pixels.cols + x)] =
            own.cam_from_world.Inverse() * Vector3d(*ray / (ray->z() * inverse));
    }
  std::vector<NeighbourDrawn> drawn;
  for (const std::size_t neighbour : MovedNeighboursOf(view, pictures, distance))
    drawn.push_back(DrawFrom(own, surface, pictures[neighbour]));
  if (static_cast<int>(drawn.size()) < kFewestNeighbours) return cv::Mat::zeros(own.pixels.size(), CV_8U);
  const int window =
      std::max(3, static_cast<int>(std::lround(kMovedWindow * std::max(own.pixels.cols, own.pixels.rows))));
  const cv::Mat votes = Votes(own, PredictFrom(std::move(drawn), own.pixels.size(), window), window);
  judged_share = static_cast<double>(cv::countNonZero(votes)) / static_cast<double>(votes.total());
  spdlog::debug("view {}: {:.3f} judged, {:.3f} unlike", view, judged_share,
                static_cast<double>(cv::countNonZero(votes > 0)) / static_cast<double>(votes.total()));
  return LargeUnlikeParts(votes);
}

// Returns the usual depth of the mesh, by which the neighbours' distances are measured.
double UsualDepth(const std::vector<MovedPicture>& pictures) {
  std::vector<double> depths;
  for (const MovedPicture& picture : pictures) {
    std::vector<double> own;
    for (int y = 0; y < picture.inverse_depth.rows; y += 16)
      for (int x = 0; x < picture.inverse_depth.cols; x += 16)
        if (const float inverse = picture.inverse_depth.at<float>(y, x); inverse > 0)
          own.push_back(1 / inverse);
    if (!own.empty()) depths.push_back(Median(std::move(own)));
  }
  return depths.empty() ? 1 : Median(std::move(depths));
}

}  // namespace

MovedMasks MakeMovedMasks(const LightField& light_field, const TriangleMesh& mesh,
                          const MovedMaskOptions& options, Progress* progress) {
  if (progress) progress->Show(0, "reading the views");
  const std::vector<MovedPicture> pictures = MovedPicturesOf(light_field, mesh, options.size_px);
  const double distance = UsualDepth(pictures);
  std::vector<cv::Mat> moved(pictures.size());
  std::vector<double> judged(pictures.size());
  std::atomic<int> done = 0;
  ParallelFor(pictures.size(), [&](std::size_t i) {
    moved[i] = HiddenPartsOf(i, pictures, distance, judged[i]);
    ++done;
    if (progress) progress->Show(0.4 + 0.6 * done / static_cast<double>(pictures.size()), "comparing");
  });
  MovedMasks result;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    result.judged_share += judged[i] / static_cast<double>(pictures.size());
    const int hidden = cv::countNonZero(moved[i]);
    if (hidden == 0) continue;
    const View& view = light_field.views[i];
    cv::Mat large;
    cv::resize(moved[i], large, SizeOf(light_field.CameraOf(view)), 0, 0, cv::INTER_LINEAR);
    cv::Mat mask = large < 128;
    if (const cv::Mat own = ReadViewMask(light_field, view); !own.empty()) mask &= own != 0;
    result.masks[view.id] = mask;
    result.shares[view.id] = static_cast<double>(hidden) / static_cast<double>(moved[i].total());
  }
  return result;
}

MovedMasks WriteMovedMasks(const std::filesystem::path& dir, const MovedMaskOptions& options) {
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  const std::filesystem::path file = dir / kMeshProxyFile;
  if (!std::filesystem::exists(file))
    throw Error(
        "{}: there is no mesh of this light field, over which its views are compared; make it with: {}",
        file.string(), ProxyCommand(dir));
  const TriangleMesh mesh = ReadMeshFile(file).mesh;
  Progress progress("mask");
  MovedMasks masks = MakeMovedMasks(writer.Contents(), mesh, options, &progress);
  writer.SetMasks(masks.masks);
  writer.Close(writer.Contents().capture_s, writer.Contents().reasons);
  return masks;
}

}  // namespace ulf::render

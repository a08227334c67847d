#include "coverage/session/light_and_focus.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "coverage/bound/sphere_outline.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kLookEvery_s = 0.25;  // a frame is looked at so often; each costs some milliseconds
constexpr double kLookBestOf_s = 2;    // a moving camera blurs some frames

// At most so many pixels of each side are looked at, in the middle of the outline's box; more takes longer.
constexpr int kDetailMost_px = 1024;
// Grey values that the coarser octave needs at an edge: less may be noise. Where no part has edges enough,
// the picture is looked at once more at half the size, where a lens far out of focus still shows some.
// Guessed.
constexpr double kDetailLeastTexture = 6;
constexpr int kDetailTimesHalved = 2;
constexpr double kDetailLeastSlope = 1.5;  // grey values a pixel: the same for slopes. Guessed
// The parts' sides, pixels of the halved picture, and the edges that each needs, so that the noise of one
// alone does not tell. Smaller parts hold little but a thin thing, and judge by less.
constexpr int kDetailPart_px = 32, kDetailLeastEdges = 3;
// Weaker edges of a part, as a share of its strongest, belong to what lies behind it.
constexpr double kDetailStrongShare = 0.5;
// Share of all edges (by their strength) that the sharpest parts hold, the last of which is the result: more
// finds a thin sharp thing before a blurred background out of focus, less takes chance for sharpness. Values
// of 0.1 to 0.2 were measured as in the header.
constexpr double kDetailSharpest = 0.1;

struct PicturePart {
  double strongest = 0;         // of the coarser octave, grey values
  double fine = 0, coarse = 0;  // summed over its strong edges
  int edges = 0;
};

// Two measures of the same things, the finer over the coarser.
struct DetailPair {
  cv::Mat fine, coarse;
  double least_coarse = 0;
};

DetailPair Octaves(const cv::Mat& grey) {
  cv::Mat smooth, smoother, fine;
  cv::GaussianBlur(grey, smooth, {0, 0}, 1);
  cv::GaussianBlur(grey, smoother, {0, 0}, 2);
  // An edge is where the coarser octave is strongest; its finer octave is strongest a little nearer to the
  // step.
  cv::dilate(cv::abs(grey - smooth), fine, cv::Mat::ones(5, 5, CV_8U));
  return {fine, cv::abs(smooth - smoother), kDetailLeastTexture};
}

// Returns how steep edges are after a little smoothing and after more: of a step, as many times as steep as
// it was smoothed less. For edges that are blurred by more than both, the two are equal.
DetailPair Slopes(const cv::Mat& grey) {
  constexpr double kLess = 1, kMore = 2.5;  // pixels
  const auto slope = [&](double sigma) {
    cv::Mat smooth, right, down, steep;
    cv::GaussianBlur(grey, smooth, {0, 0}, sigma);
    cv::Sobel(smooth, right, CV_32F, 1, 0, 1, 0.5);
    cv::Sobel(smooth, down, CV_32F, 0, 1, 1, 0.5);
    cv::magnitude(right, down, steep);
    return steep;
  };
  cv::Mat fine;
  cv::dilate(slope(kLess), fine, cv::Mat::ones(3, 3, CV_8U));
  return {fine * (kLess / kMore), slope(kMore), kDetailLeastSlope};
}

std::optional<double> SharpestParts(const DetailPair& detail, const cv::Mat& inside) {
  const cv::Mat &fine = detail.fine, &coarse = detail.coarse;
  cv::Mat coarse_around;
  cv::dilate(coarse, coarse_around, cv::Mat::ones(5, 5, CV_8U));
  std::vector<cv::Point> edges;
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x) {
      const float here = coarse.at<float>(y, x);
      if (here >= detail.least_coarse && here >= coarse_around.at<float>(y, x) &&
          inside.at<std::uint8_t>(y, x))
        edges.push_back({x, y});
    }
  const int columns = coarse.cols / kDetailPart_px + 1, rows = coarse.rows / kDetailPart_px + 1;
  std::vector<PicturePart> parts(static_cast<std::size_t>(columns * rows));
  const auto part_at = [&](const cv::Point& at) -> PicturePart& {
    return parts[static_cast<std::size_t>(at.y / kDetailPart_px * columns + at.x / kDetailPart_px)];
  };
  for (const cv::Point& at : edges)
    part_at(at).strongest = std::max<double>(part_at(at).strongest, coarse.at<float>(at));
  for (const cv::Point& at : edges) {
    PicturePart& part = part_at(at);
    if (coarse.at<float>(at) < kDetailStrongShare * part.strongest) continue;
    part.fine += fine.at<float>(at);
    part.coarse += coarse.at<float>(at);
    ++part.edges;
  }
  std::erase_if(parts, [&](const PicturePart& part) { return part.edges < kDetailLeastEdges; });
  if (parts.empty()) return std::nullopt;
  const auto sharpness = [](const PicturePart& part) { return part.fine / part.coarse; };
  std::ranges::sort(parts, std::greater{}, sharpness);
  double left = 0;
  for (const PicturePart& part : parts) left += kDetailSharpest * part.coarse;
  auto last = parts.begin();
  for (left -= last->coarse; left > 0 && last + 1 != parts.end(); left -= last->coarse) ++last;
  return sharpness(*last);
}

// Returns where the subject is while nobody has placed it.
std::vector<Eigen::Vector2d> Middle(const Image& image) {
  const double width = image.width(), height = image.height();
  return {{0.25 * width, 0.25 * height},
          {0.75 * width, 0.25 * height},
          {0.75 * width, 0.75 * height},
          {0.25 * width, 0.75 * height}};
}

cv::Rect BoxOf(const std::vector<Eigen::Vector2d>& outline) {
  Eigen::Vector2d low = outline[0], high = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return {cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
          cv::Point(static_cast<int>(high.x()), static_cast<int>(high.y()))};
}

}  // namespace

std::optional<double> FineDetail(const cv::Mat& grey8, const std::vector<Eigen::Vector2d>& outline) {
  constexpr int kLeastPx = 32;
  cv::Rect box = BoxOf(outline) & cv::Rect({0, 0}, grey8.size());
  const int cut_x = std::max(0, box.width - kDetailMost_px), cut_y = std::max(0, box.height - kDetailMost_px);
  box = {box.x + cut_x / 2, box.y + cut_y / 2, box.width - cut_x, box.height - cut_y};
  if (box.width < kLeastPx || box.height < kLeastPx) return std::nullopt;
  cv::Mat reduced = grey8(box), inside = cv::Mat::zeros(box.size(), CV_8U);
  std::vector<cv::Point> polygon;
  for (const Eigen::Vector2d& corner : outline)
    polygon.push_back(cv::Point(static_cast<int>(corner.x()), static_cast<int>(corner.y())) - box.tl());
  cv::fillPoly(inside, polygon, 255);
  std::optional<double> slopes;
  for (int times = 0; times < kDetailTimesHalved; ++times) {
    if (std::min(reduced.cols, reduced.rows) < kLeastPx) break;
    cv::resize(reduced, reduced, {}, 0.5, 0.5, cv::INTER_AREA);
    cv::resize(inside, inside, reduced.size(), 0, 0, cv::INTER_NEAREST);
    cv::Mat grey;
    reduced.convertTo(grey, CV_32F);
    if (times == 0) slopes = SharpestParts(Slopes(grey), inside);
    if (const auto octaves = SharpestParts(Octaves(grey), inside)) {
      constexpr double kSurelySharp = 1.1;  // of the photographs above; a soft shade has gentle slopes, too
      const bool is_sharp = times == 0 && *octaves >= kSurelySharp;
      return is_sharp ? *octaves : std::min(*octaves, slopes.value_or(*octaves));
    }
  }
  return slopes;
}

const PictureFinding& LightAndFocusCheck::Update(double time_s, const Image& image, const CameraModel& camera,
                                                 const std::optional<Rigid3>& cam_from_world,
                                                 const std::optional<Subject>& subject) {
  if (image.empty()) return finding_;
  if (!looked_.empty() && time_s >= looked_.back().time_s && time_s - looked_.back().time_s < kLookEvery_s)
    return finding_;
  std::optional<std::vector<Eigen::Vector2d>> outline;
  if (subject && cam_from_world) outline = SphereOutline(camera, *cam_from_world, *subject);
  const std::vector<Eigen::Vector2d> shape = outline.value_or(Middle(image));
  finding_.is_of_subject = outline.has_value();
  finding_.light = LightInside(image, shape);
  looked_.push_back({time_s, FineDetail(GrayForTracking(image), shape)});
  while (time_s - looked_.front().time_s > kLookBestOf_s || looked_.front().time_s > time_s)
    looked_.pop_front();
  finding_.fine_detail.reset();
  if (time_s - looked_.front().time_s < 0.5 * kLookBestOf_s) return finding_;
  for (const Looked& look : looked_)
    if (look.fine_detail)
      finding_.fine_detail = std::max(finding_.fine_detail.value_or(0), *look.fine_detail);
  return finding_;
}

}  // namespace ulf::coverage

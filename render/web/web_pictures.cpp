#include "render/web/web_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/image/files/picture_codecs.h"
#include "render/scene/even_picture.h"

namespace ulf::render {
namespace {

constexpr int kBestQuality = 95, kUsualQuality = 80, kLeastQuality = 40,
              kSmallQuality = 70;  // WebP's. Guessed.
constexpr int kLeastPx = 64;       // of the longer side. Guessed.

class PicturesOfViews {
 public:
  explicit PicturesOfViews(const RenderScene& scene) : scene_(scene), kept_(scene.views.size()) {
    for (const SceneView& view : scene.views)
      undistortions_.push_back(!undistortions_.empty() && undistortions_.back().from == view.camera
                                   ? undistortions_.back()
                                   : UndistortionOf(view));
  }

  std::size_t count() const { return scene_.views.size(); }
  int LongestPx() const {
    int longest = 1;
    for (const Undistortion& undistortion : undistortions_)
      longest = std::max({longest, undistortion.to.width, undistortion.to.height});
    return longest;
  }

  CameraModel CameraOf(std::size_t index, int longest_px) const {
    return Within(undistortions_[index].to, longest_px);
  }

  // Returns CV_8UC3, or CV_8UC4 with alpha if some of the picture has no light. Only one thread at a time may
  // call it for an index.
  cv::Mat Draw(std::size_t index, const CameraModel& camera) {
    cv::Mat& kept = kept_[index];
    if (kept.cols == camera.width && kept.rows == camera.height) return kept;
    cv::Mat picture = EvenPicture(scene_.views[index], undistortions_[index], camera);
    constexpr std::size_t kMostKeptBytes = std::size_t{1} << 30;  // other pictures are drawn again. Guessed.
    if (picture.total() * picture.elemSize() * count() <= kMostKeptBytes) kept = picture;
    return picture;
  }

 private:
  const RenderScene& scene_;
  std::vector<Undistortion> undistortions_;
  std::vector<cv::Mat> kept_;  // of the last drawn size
};

WebPicture Encoded(PicturesOfViews& views, std::size_t index, int longest_px, int quality) {
  WebPicture encoded{.camera = views.CameraOf(index, longest_px), .fine = {}, .small = {}};
  const cv::Mat picture = views.Draw(index, encoded.camera);
  encoded.has_gaps = picture.channels() == 4;
  encoded.fine = WebpBytes(picture, quality);
  const cv::Size small(std::max(1, encoded.camera.width / kSmallWebPictureDivisor),
                       std::max(1, encoded.camera.height / kSmallWebPictureDivisor));
  cv::Mat reduced;
  cv::resize(picture, reduced, small, 0, 0, cv::INTER_AREA);
  encoded.small = WebpBytes(reduced, kSmallQuality);
  return encoded;
}

std::vector<WebPicture> EncodeSome(PicturesOfViews& views, const std::vector<std::size_t>& which,
                                   int longest_px, int quality, const WebPictureOptions& options,
                                   double progress_from, double progress_to) {
  std::vector<WebPicture> encoded(which.size());
  const std::size_t at_once = 4 * static_cast<std::size_t>(std::max(1, cv::getNumThreads()));
  for (std::size_t done = 0; done < which.size(); done += at_once) {
    if (options.stop && options.stop()) throw Error("stopped before the end, as asked; nothing was exported");
    const std::size_t some = std::min(at_once, which.size() - done);
    std::vector<std::exception_ptr> problems(some);
    ParallelFor(some, [&](std::size_t i) {
      try {
        encoded[done + i] = Encoded(views, which[done + i], longest_px, quality);
      } catch (...) {
        problems[i] = std::current_exception();
      }
    });
    for (const std::exception_ptr& problem : problems)
      if (problem) std::rethrow_exception(problem);
    if (options.progress)
      options.progress(progress_from + (progress_to - progress_from) * static_cast<double>(done + some) /
                                           static_cast<double>(which.size()),
                       fmt::format("quality {}, picture {} of {}", quality, done + some, which.size()));
  }
  return encoded;
}

std::size_t BytesOf(const std::vector<WebPicture>& pictures) {
  std::size_t bytes = 0;
  for (const WebPicture& picture : pictures) bytes += picture.fine.size() + picture.small.size();
  return bytes;
}

}  // namespace

WebPictures MakeWebPictures(const RenderScene& scene, const WebPictureOptions& options) {
  PicturesOfViews views(scene);
  constexpr std::size_t kSample = 12;  // views that represent the others. Guessed.
  std::vector<std::size_t> all(views.count()), sample;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const std::size_t samples = std::min(kSample, all.size());
  for (std::size_t i = 0; i < samples; ++i) sample.push_back((2 * i + 1) * all.size() / (2 * samples));
  const auto expected = [&](int longest_px, int quality) {
    return static_cast<double>(BytesOf(EncodeSome(views, sample, longest_px, quality, options, 0, 0))) *
           static_cast<double>(all.size()) / static_cast<double>(samples);
  };
  const auto budget = static_cast<double>(options.most_bytes);

  const int most_px = std::min(views.LongestPx(), options.longest_px);
  int longest_px = most_px;
  if (expected(most_px, kUsualQuality) > budget) {
    double small = std::min(kLeastPx, most_px), large = most_px;
    constexpr double kNear = 1.02;  // ratio of two sizes that count as equal
    while (large > kNear * small) {
      const double middle = std::sqrt(small * large);
      (expected(static_cast<int>(middle), kUsualQuality) > budget ? large : small) = middle;
    }
    longest_px = static_cast<int>(small);
  }
  int quality = kLeastQuality;
  for (int step = 32; step > 0; step /= 2)
    if (quality + step <= kBestQuality && expected(longest_px, quality + step) <= budget) quality += step;

  // Nothing is drawn for a thousand views that are far too many.
  constexpr double kSampleMayBeOff = 1.25;  // guessed
  constexpr double kBase64 = 4.0 / 3;       // base64 expands three bytes to four
  const auto too_little = [&](double bytes) {
    return Refusal(
        fmt::format("the pictures of {} take at least {:.3g} MB, and the budget leaves {:.3g} MB for them",
                    Counted(all.size(), "view"), kBase64 * 1e-6 * bytes, kBase64 * 1e-6 * budget),
        "", "", "give a larger one, or export fewer views");
  };
  if (quality == kLeastQuality)
    if (const double bytes = expected(longest_px, quality); bytes > kSampleMayBeOff * budget)
      throw too_little(bytes);

  // The sample may be off by some percent: all views are used to find the highest quality that fits, and as
  // many views as there is room for get the next one.
  WebPictures result;
  std::vector<WebPicture> too_large;  // of the next quality
  for (double from = 0.1;; from += 0.5 * (1 - from)) {
    std::vector<WebPicture> pictures =
        EncodeSome(views, all, longest_px, quality, options, from, 0.5 * (1 + from));
    const std::size_t bytes = BytesOf(pictures);
    if (bytes > options.most_bytes) {
      too_large = std::move(pictures);
      if (!result.views.empty()) break;
      if (quality <= kLeastQuality) throw too_little(static_cast<double>(bytes));
      --quality;
      continue;
    }
    result = {.views = std::move(pictures), .quality = quality, .bytes = bytes};
    if (!too_large.empty() || quality >= kBestQuality) break;
    ++quality;
  }
  for (std::size_t i = 0; i < too_large.size(); ++i) {
    const std::size_t with = result.bytes - result.views[i].fine.size() + too_large[i].fine.size();
    if (with > options.most_bytes) continue;
    result.bytes = with;
    result.views[i] = std::move(too_large[i]);
  }
  return result;
}

}  // namespace ulf::render

// Tests: render/quality/protocol, render/quality/quality.
#include "render/quality/protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::protocol_test {
namespace {

using test::ScratchFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;
using testing::ThrowsMessage;

LightField Named(const std::vector<std::string>& names) {
  LightField light_field;
  light_field.cameras = {CameraModel::Pinhole(100, 80, 90)};
  for (std::size_t i = 0; i < names.size(); ++i) {
    View view;
    view.id = static_cast<int>(i) + 1;
    view.image_path = "images/" + names[i];
    view.cam_from_world = LookAt({0.8 * static_cast<double>(i), 0, 0}, {0.5, 0, 3}, {0, -1, 0});
    light_field.views.push_back(view);
  }
  return light_field;
}

TEST(Protocol, LlffLeavesOutEveryEighthByName) {
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) names.push_back(fmt::format("image{:03}.png", i));
  const ProtocolSplit split = SplitByProtocol(Named(names), "llff");
  EXPECT_THAT(split.test, ElementsAre(0, 8, 16));
  EXPECT_THAT(split.given, SizeIs(17));
  std::ranges::reverse(names);
  EXPECT_THAT(SplitByProtocol(Named(names), "llff").test, ElementsAre(3, 11, 19)) << "the names count";
  EXPECT_THAT(SplitByProtocol(Named({"a10.png", "a2.png", "a1.png", "b.png"}), "every:2").test,
              ElementsAre(1, 2))
      << "as computers sort: a1, a10, a2, b";
}

TEST(Protocol, NerfsScenesAreSplitByFolder) {
  const ProtocolSplit split = SplitByProtocol(
      Named({"train/r_0.png", "train/r_1.png", "val/r_0.png", "test/r_0.png", "test/r_1.png"}),
      "nerf-synthetic");
  EXPECT_THAT(split.given, ElementsAre(0, 1));
  EXPECT_THAT(split.test, ElementsAre(3, 4));
  EXPECT_THAT(
      [] {
        SplitByProtocol(Named({"a.png", "b.png", "c.png"}), "nerf-synthetic");
      },
      ThrowsMessage<Refusal>(HasSubstr("images/train")));
}

TEST(Protocol, AFileNamesWhatIsLeftOut) {
  const ScratchFolder scratch;
  const std::string file = (scratch / "test.txt").string();
  const LightField light_field = Named({"left/a.png", "left/b.png", "right/a.png", "c.jpg"});
  std::ofstream(file) << "# for the paper\nleft/b\nc.jpg  \r\n\nimages/right/a.png\n";
  EXPECT_THAT(
      SplitByProtocol(Named({"left/a.png", "left/b.png", "right/a.png", "c.jpg", "d.png"}), file).test,
      ElementsAre(1, 2, 3));
  for (const auto& [line, words] :
       std::initializer_list<std::pair<const char*, const char*>>{{"e.png", "no photograph"},
                                                                  {"a.png", "several"},
                                                                  {"", "0 photographs"},
                                                                  {"left/a\nleft/b\nright/a", "1 given"}}) {
    std::ofstream(file) << line << "\n";
    EXPECT_THAT([&] { SplitByProtocol(light_field, file); }, ThrowsMessage<Refusal>(HasSubstr(words)))
        << line;
  }
  for (const char* bad : {"nerf", "every:1", "every:8x", "every:-3", ""})
    EXPECT_THROW(SplitByProtocol(light_field, bad), Refusal) << bad;
}

TEST(Protocol, PointsKnowNothingOfWhatIsLeftOut) {
  LightField all = Named({"a.png", "b.png", "c.png", "d.png"});
  all.device_uri = "import:x";
  const auto seen = [&](const Eigen::Vector3d& point, std::initializer_list<int> views) {
    ScenePoint made{.position_in_world = point};
    for (const int view : views) {
      const View& of = all.views[static_cast<std::size_t>(view)];
      made.track.push_back({of.id, *all.CameraOf(of).ImgFromCam(of.cam_from_world * point)});
    }
    return made;
  };
  const Eigen::Vector3d place(0.4, 0.1, 3);
  all.points = {
      seen(place, {0, 1, 2, 3}), seen(place, {1, 2}), seen(place, {0, 1}), {.position_in_world = place}};
  all.points[0].track[1].in_img +=
      Eigen::Vector2d(30, -20);  // a wrong observation of the view that is left out
  all.points[0].position_in_world += Eigen::Vector3d(0.1, 0, 0.2);
  all.subject = Subject{{9, 9, 9}, 1};
  const LightField given = SubsetOfViews(all, {0, 2, 3});
  ASSERT_THAT(given.views, SizeIs(3));
  ASSERT_THAT(given.points, SizeIs(1)) << "two views see only this one, and know that they do";
  EXPECT_LT((given.points[0].position_in_world - place).norm(), 1e-6);
  EXPECT_THAT(given.points[0].track, SizeIs(3));
  EXPECT_LT((given.subject->center_in_world - Eigen::Vector3d(0.5, 0, 3)).norm(), 1e-6) << "found anew";
  all.device_uri = "sim:studio";
  EXPECT_EQ(SubsetOfViews(all, {0, 2, 3}).subject, all.subject) << "the operator's stays";
}

// Straight from the definitions: a window around each pixel, channel by channel.
double SlowSsim(const cv::Mat& a, const cv::Mat& b, int side, double sigma, bool sample, bool padded) {
  const int edge = side / 2;
  const double c1 = std::pow(0.01 * 255, 2), c2 = std::pow(0.03 * 255, 2);
  std::vector<double> weights;
  double total = 0;
  for (int v = -edge; v <= edge; ++v)
    for (int u = -edge; u <= edge; ++u)
      total += weights.emplace_back(sigma > 0 ? std::exp(-(u * u + v * v) / (2 * sigma * sigma)) : 1.0);
  double sum = 0, count = 0;
  const int from = padded ? 0 : edge;
  for (int c = 0; c < 3; ++c)
    for (int y = from; y < a.rows - from; ++y)
      for (int x = from; x < a.cols - from; ++x) {
        double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        std::size_t i = 0;
        for (int v = -edge; v <= edge; ++v)
          for (int u = -edge; u <= edge; ++u) {
            const double w = weights[i++] / total;
            const bool inside = y + v >= 0 && x + u >= 0 && y + v < a.rows && x + u < a.cols;
            const double p = inside ? a.at<cv::Vec3b>(y + v, x + u)[c] : 0;
            const double q = inside ? b.at<cv::Vec3b>(y + v, x + u)[c] : 0;
            ma += w * p, mb += w * q, aa += w * p * p, bb += w * q * q, ab += w * p * q;
          }
        const double factor = sample ? side * side / (side * side - 1.0) : 1;
        sum += (2 * ma * mb + c1) * (2 * factor * (ab - ma * mb) + c2) /
               ((ma * ma + mb * mb + c1) * (factor * (aa - ma * ma + bb - mb * mb) + c2));
        ++count;
      }
  return sum / count;
}

TEST(Protocol, SsimMatchesEachPaper) {
  cv::Mat a(40, 52, CV_8UC3), b(40, 52, CV_8UC3);
  cv::RNG(4).fill(a, cv::RNG::UNIFORM, 0, 256);
  cv::RNG(5).fill(b, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(a, a, {0, 0}, 1.5);
  cv::addWeighted(a, 0.7, b, 0.3, 0, b);
  const PaperQuality papers = CompareAsPapers(b, a, cv::Mat(a.size(), CV_8U, cv::Scalar(255)));
  EXPECT_NEAR(papers.ssim, SlowSsim(b, a, 11, 1.5, false, false), 1e-9);
  EXPECT_NEAR(papers.ssim_uniform, SlowSsim(b, a, 7, 0, true, false), 1e-9);
  EXPECT_NEAR(papers.ssim_padded, SlowSsim(b, a, 11, 1.5, false, true), 1e-9);
  EXPECT_GT(std::abs(papers.ssim - papers.ssim_uniform), 1e-3) << "they differ";
  double squares = 0;
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x)
      for (int c = 0; c < 3; ++c)
        squares += std::pow((a.at<cv::Vec3b>(y, x)[c] - b.at<cv::Vec3b>(y, x)[c]) / 255.0, 2);
  EXPECT_NEAR(papers.psnr_db, -10 * std::log10(squares / (3 * 40 * 52)), 1e-9);
}

TEST(Protocol, PixelsWithoutLightDoNotCount) {
  cv::Mat a(40, 52, CV_8UC3), b;
  cv::RNG(4).fill(a, cv::RNG::UNIFORM, 0, 256);
  b = a + cv::Scalar::all(3);
  cv::Mat valid(a.size(), CV_8U, cv::Scalar(255));
  const double whole = CompareAsPapers(b, a, valid).psnr_db;
  valid.rowRange(0, 9).setTo(0);
  a.rowRange(0, 9).setTo(cv::Scalar::all(0));
  const PaperQuality papers = CompareAsPapers(b, a, valid);
  EXPECT_NEAR(papers.psnr_db, whole, 0.1);
  for (const double ssim : {papers.ssim, papers.ssim_uniform, papers.ssim_padded}) EXPECT_GT(ssim, 0.99);
}

}  // namespace
}  // namespace ulf::protocol_test

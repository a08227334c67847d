// Tests: core/image/image.
//
// Mosaics as colour: the four orders, the precision, and the grey picture that the tracker sees.
#include <gmock/gmock.h>

#include <array>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/image/image.h"
#include "tests/support/test_paths.h"

namespace ulf::demosaic_test {
namespace {

constexpr std::array kOrders{Mosaic::kRggb, Mosaic::kGrbg, Mosaic::kGbrg, Mosaic::kBggr};
constexpr std::array kNames{"RGGB", "GRBG", "GBRG", "BGGR"};

// Which channel (B, G, R) the pixel at x, y sees.
int ChannelAt(Mosaic mosaic, int x, int y) {
  const char* first = mosaic == Mosaic::kRggb   ? "RGGB"
                      : mosaic == Mosaic::kGrbg ? "GRBG"
                      : mosaic == Mosaic::kGbrg ? "GBRG"
                                                : "BGGR";
  switch (first[2 * (y % 2) + x % 2]) {
    case 'B':
      return 0;
    case 'G':
      return 1;
    default:
      return 2;
  }
}

cv::Mat MosaicOf(const cv::Mat& color, Mosaic mosaic) {
  cv::Mat result(color.size(), CV_16U);
  for (int y = 0; y < color.rows; ++y)
    for (int x = 0; x < color.cols; ++x)
      result.at<std::uint16_t>(y, x) = color.at<cv::Vec3w>(y, x)[ChannelAt(mosaic, x, y)];
  return result;
}

// Colours that change slowly, with discs of other colours: 16 bits, linear.
cv::Mat ColorScene(int width, int height) {
  cv::Mat scene(height, width, CV_32FC3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      scene.at<cv::Vec3f>(y, x) = {0.15f + 0.5f * static_cast<float>(x) / static_cast<float>(width),
                                   0.3f + 0.2f * std::sin(0.05f * static_cast<float>(y)),
                                   0.7f - 0.5f * static_cast<float>(y) / static_cast<float>(height)};
  cv::circle(scene, {width / 3, height / 3}, height / 6, {0.1, 0.2, 0.8}, cv::FILLED, cv::LINE_AA);
  cv::circle(scene, {2 * width / 3, height / 2}, height / 5, {0.7, 0.3, 0.05}, cv::FILLED, cv::LINE_AA);
  cv::GaussianBlur(scene, scene, {}, 1.2);  // a lens
  cv::Mat result;
  scene.convertTo(result, CV_16U, 65535);
  return result;
}

double PsnrDb(const cv::Mat& a, const cv::Mat& b) {
  const cv::Rect inside(2, 2, a.cols - 4, a.rows - 4);
  const double rms = cv::norm(a(inside), b(inside), cv::NORM_L2) /
                     std::sqrt(3.0 * inside.width * static_cast<double>(inside.height));
  return 20 * std::log10(65535 / std::max(rms, 1e-9));
}

TEST(Demosaic, OnlyTheRightOrderRestoresTheScene) {
  const cv::Mat scene = ColorScene(160, 120);
  for (std::size_t is = 0; is < 4; ++is)
    for (std::size_t named = 0; named < 4; ++named) {
      const Image color = Demosaiced({MosaicOf(scene, kOrders[is]), Transfer::kLinear, kOrders[named]});
      ASSERT_EQ(color.pixels.type(), CV_16UC3);
      EXPECT_EQ(color.mosaic, Mosaic::kNone);
      EXPECT_EQ(color.transfer, Transfer::kLinear);
      const double psnr_db = PsnrDb(color.pixels, scene);
      if (is == named)
        EXPECT_GT(psnr_db, 38) << kNames[is];
      else
        EXPECT_LT(psnr_db, 25) << kNames[is] << " taken for " << kNames[named];
    }
}

// Without its first column, row or both, a mosaic is one of another order that shows the same: the colours
// must be the same numbers, but for the margin.
void ExpectShiftedCropsAgree(const cv::Mat& mosaic) {
  const cv::Mat whole = Demosaiced({mosaic, Transfer::kLinear, Mosaic::kRggb}).pixels;
  for (const auto& [order, dx, dy] :
       {std::tuple{Mosaic::kGrbg, 1, 0}, {Mosaic::kGbrg, 0, 1}, {Mosaic::kBggr, 1, 1}}) {
    const cv::Mat crop = mosaic(cv::Rect(dx, dy, mosaic.cols - dx, mosaic.rows - dy)).clone();
    const cv::Mat color = Demosaiced({crop, Transfer::kLinear, order}).pixels;
    const cv::Rect inside(4, 4, crop.cols - 8, crop.rows - 8);
    EXPECT_EQ(cv::norm(color(inside), whole(inside + cv::Point(dx, dy)), cv::NORM_INF), 0)
        << "shifted by " << dx << "," << dy;
  }
}

TEST(Demosaic, ShiftedCropsOfASceneAgree) {
  ExpectShiftedCropsAgree(MosaicOf(ColorScene(160, 120), Mosaic::kRggb));
}

// A Nikon's 14-bit mosaic, black 600, white 15520.
cv::Mat RealMosaic(const std::filesystem::path& folder, const std::string& order) {
  const auto path = folder / "images" / ("DSC_1339_768x512_" + order + ".raw");
  cv::Mat raw(512, 768, CV_16U), mosaic;
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(raw.data), 768 * 512 * 2);
  if (!file) throw Error("{}: cannot be read", path.string());
  raw.convertTo(mosaic, CV_16U, 65535.0 / (15520 - 600), -600 * 65535.0 / (15520 - 600));
  return mosaic;
}

TEST(Demosaic, ShiftedCropsOfARealMosaicAgree) {
  ULF_NEED_TEST_DATA(folder, "bayer_raw");
  ExpectShiftedCropsAgree(RealMosaic(folder, "rggb"));
}

// The mean colours of blocks of `size` pixels: where in its 2x2 block a sample lies no longer matters much.
cv::Mat BlockColors(const cv::Mat& mosaic, Mosaic order, int size) {
  cv::Mat small;
  cv::resize(Demosaiced({mosaic, Transfer::kLinear, order}).pixels, small, mosaic.size() / size, 0, 0,
             cv::INTER_AREA);
  return small;
}

// Pictures of one scene whose samples were exchanged inside their 2x2 blocks: the colours stay where they
// are.
void ExpectPermutedAgree(const std::array<cv::Mat, 4>& mosaics) {
  const cv::Mat first = BlockColors(mosaics[0], kOrders[0], 8);
  const double contrast = cv::norm(first, first.clone().setTo(cv::mean(first)), cv::NORM_L2);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_LT(cv::norm(first, BlockColors(mosaics[i], kOrders[i], 8), cv::NORM_L2), 0.1 * contrast)
        << kNames[i];
    EXPECT_GT(cv::norm(first, BlockColors(mosaics[i], kOrders[0], 8), cv::NORM_L2), 0.3 * contrast)
        << kNames[i] << " taken for RGGB must not agree";
  }
}

TEST(Demosaic, RealMosaicsOfFourOrdersGiveTheSamePicture) {
  ULF_NEED_TEST_DATA(folder, "bayer_raw");
  ExpectPermutedAgree({RealMosaic(folder, "rggb"), RealMosaic(folder, "grbg"), RealMosaic(folder, "gbrg"),
                       RealMosaic(folder, "bggr")});
}

TEST(Demosaic, PermutedMosaicsOfASceneGiveTheSamePicture) {
  const cv::Mat rggb = MosaicOf(ColorScene(320, 240), Mosaic::kRggb);
  const auto permuted = [&](std::array<int, 4> from) {
    cv::Mat result(rggb.size(), CV_16U);
    for (int y = 0; y < rggb.rows; ++y)
      for (int x = 0; x < rggb.cols; ++x) {
        const int k = from[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
        result.at<std::uint16_t>(y, x) = rggb.at<std::uint16_t>(y / 2 * 2 + k / 2, x / 2 * 2 + k % 2);
      }
    return result;
  };
  ExpectPermutedAgree({rggb, permuted({1, 0, 3, 2}), permuted({2, 3, 0, 1}), permuted({3, 2, 1, 0})});
}

// Twice the light is twice the number, far below what 8 bits can hold.
TEST(Demosaic, StaysLinearBelowEightBits) {
  const cv::Mat scene = ColorScene(64, 48);
  cv::Mat half, dark;
  scene.convertTo(half, CV_16U, 0.5);
  scene.convertTo(dark, CV_16U, 1.0 / 512);
  const cv::Mat full_light = LinearFloat({MosaicOf(scene, Mosaic::kGbrg), Transfer::kLinear, Mosaic::kGbrg});
  for (const auto& [mosaic, factor] : {std::pair{half, 0.5}, {dark, 1.0 / 512}}) {
    const cv::Mat light = LinearFloat({MosaicOf(mosaic, Mosaic::kGbrg), Transfer::kLinear, Mosaic::kGbrg});
    const cv::Rect inside(2, 2, 60, 44);
    EXPECT_LE(cv::norm(light(inside), full_light(inside) * factor, cv::NORM_INF), 3.0 / 65535) << factor;
  }
}

TEST(Demosaic, InterpolatesEightBitsMoreFinely) {
  // Neighbours of 100 and 101: between them lies 100.5.
  cv::Mat mosaic(8, 8, CV_8U);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) mosaic.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(100 + (x / 2) % 2);
  const Image color = Demosaiced({mosaic, Transfer::kLinear, Mosaic::kRggb});
  ASSERT_EQ(color.pixels.depth(), CV_16U);
  EXPECT_NEAR(color.pixels.at<cv::Vec3w>(4, 3)[2], 257 * 100.5, 1);
}

TEST(Demosaic, TooSmallForInterpolationStillHasColor) {
  for (const auto& [width, height] : {std::pair{2, 2}, {3, 3}, {4, 2}, {2, 5}}) {
    const Image image{cv::Mat(height, width, CV_8U, cv::Scalar(77)), Transfer::kLinear, Mosaic::kRggb};
    EXPECT_EQ(Srgb8(image).size(), image.pixels.size());
    EXPECT_EQ(GrayForTracking(image).size(), image.pixels.size());
  }
}

// What the tracker sees of a mosaic against what it would see of the colours: no pattern, no shift.
TEST(Demosaic, GrayOfAMosaicIsTheGrayOfItsColors) {
  const cv::Mat scene = ColorScene(160, 120);
  const cv::Rect inside(4, 4, 152, 112);
  cv::Mat truth;
  cv::GaussianBlur(GrayForTracking({scene, Transfer::kLinear}), truth, {3, 3}, 0);
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Mat gray = GrayForTracking({MosaicOf(scene, kOrders[i]), Transfer::kLinear, kOrders[i]});
    ASSERT_EQ(gray.type(), CV_8U);
    cv::Mat a, b;
    gray(inside).convertTo(a, CV_32F);
    truth(inside).convertTo(b, CV_32F);
    // Its weights are not quite those of luma; its place is.
    const cv::Point2d shift = cv::phaseCorrelate(a, b);
    EXPECT_LT(std::hypot(shift.x, shift.y), 0.05) << kNames[i];
    // No trace of the pattern in a flat place: neighbouring pixels agree.
    const cv::Mat flat =
        GrayForTracking({MosaicOf(cv::Mat(40, 40, CV_16UC3, cv::Scalar(5000, 30000, 60000)), kOrders[i]),
                         Transfer::kLinear, kOrders[i]});
    double low = 0, high = 0;
    cv::minMaxLoc(flat, &low, &high);
    EXPECT_LE(high - low, 1) << kNames[i];
  }
}

}  // namespace
}  // namespace ulf::demosaic_test

// Tests: core/image/files/exif_insertion, core/image/files/exif.
#include "core/image/files/exif_insertion.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/image/files/jpeg_codec.h"
#include "core/image/files/png_picture.h"
#include "tests/support/pictures/exif_tags.h"

namespace ulf::exif_insertion_test {
namespace {

cv::Mat Picture() {
  cv::Mat pixels(40, 60, CV_8UC3);
  cv::RNG(3).fill(pixels, cv::RNG::UNIFORM, 0, 255);
  return pixels;
}

cv::Mat Decoded(const std::string& bytes) {
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
}

ExifFacts AllFacts() {
  ExifFacts facts;
  facts.exposure_s = 1.0 / 60;
  facts.f_number = 5.6;
  facts.iso = 250;
  facts.focal_mm = 35;
  facts.lens = "Lens 35";
  facts.maker = "Maker";
  facts.model = "Model 1";
  return facts;
}

ExifFacts Exposed(double seconds) {
  ExifFacts facts;
  facts.exposure_s = seconds;
  return facts;
}

TEST(ExifInsertion, FactsAreReadByTheDocument) {
  for (const std::string& bytes : {JpegBytes(Picture()), PngBytes(Picture())}) {
    const auto with = WithExif(bytes, AllFacts());
    ASSERT_TRUE(with);
    const test::ExifTags tags = test::ExifTagsOf(*with);
    EXPECT_DOUBLE_EQ(tags.numbers.at(test::kExposureTimeTag), 1.0 / 60);
    EXPECT_DOUBLE_EQ(tags.numbers.at(test::kFNumberTag), 5.6);
    EXPECT_EQ(tags.numbers.at(test::kIsoTag), 250);
    EXPECT_EQ(tags.numbers.at(test::kFocalLengthTag), 35);
    EXPECT_EQ(tags.texts.at(test::kLensModelTag), "Lens 35");
    EXPECT_EQ(tags.texts.at(test::kMakeTag), "Maker");
    EXPECT_EQ(tags.texts.at(test::kModelTag), "Model 1");
    EXPECT_EQ(tags.numbers.size() + tags.texts.size(), 7u) << "nothing that nobody said";
    EXPECT_EQ(cv::norm(Decoded(*with), Decoded(bytes), cv::NORM_INF), 0);
    EXPECT_NO_THROW(ReadExif(*with));
    EXPECT_EQ(ExifOfPicture(*with).lens, "Lens 35");
  }
}

TEST(ExifInsertion, ExposureTimesComeBackExactly) {
  for (const double seconds : {1e-6, 1 / 8000.0, 0.00123, 1 / 3.0, 0.4, 1.0, 2.5, 30.0, 1000.0}) {
    const auto with = WithExif(JpegBytes(Picture()), Exposed(seconds));
    EXPECT_NEAR(test::ExifTagsOf(*with).numbers.at(test::kExposureTimeTag) / seconds, 1, 1e-6) << seconds;
  }
}

TEST(ExifInsertion, OtherDataStay) {
  for (const std::string& bytes : {JpegBytes(Picture()), PngBytes(Picture())}) {
    const std::string first = *WithExif(bytes, AllFacts());
    EXPECT_EQ(*WithExif(first, AllFacts()), first);
    const std::string second = *WithExif(first, Exposed(0.5));
    test::ExifTags expected = test::ExifTagsOf(first);
    expected.numbers[test::kExposureTimeTag] = 0.5;
    EXPECT_EQ(test::ExifTagsOf(second), expected);
    EXPECT_EQ(cv::norm(Decoded(second), Decoded(bytes), cv::NORM_INF), 0);
  }
}

TEST(ExifInsertion, OtherFilesAreLeftAlone) {
  EXPECT_FALSE(WithExif("II*\0and so on", AllFacts()));
  EXPECT_FALSE(WithExif("", AllFacts()));
  EXPECT_FALSE(WithExif("\xff\xd8\xff\xe0\xff", AllFacts())) << "cut short";
  EXPECT_FALSE(ExifOfPicture("nothing").exposure_s);
}

}  // namespace
}  // namespace ulf::exif_insertion_test

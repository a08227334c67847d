// Tests: core/light_field/formats/transforms_json, core/light_field/formats/transforms_camera,
// core/light_field/exchange/import_light_field, core/light_field/exchange/staged_folder,
// core/light_field/points/ply_reader, core/light_field/points/point_io, core/base/json_fields,
// commands/light_field/import_command.
//
// Light fields of others: transforms.json that is damaged or of another dialect, and what import makes of
// them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::transforms_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class BadTransforms : public testing::Test {
 protected:
  void SetUp() override {
    WriteSample(scratch_ / "lf", 3);
    fs::remove(scratch_ / "lf/journal.jsonl");
    document_ = JsonFromText(ReadWholeFile(scratch_ / "lf/transforms.json"));
  }
  LightField Read() {
    std::ofstream(scratch_ / "lf/transforms.json") << JsonText(document_);
    return ReadLightField(scratch_ / "lf");
  }
  void ExpectError(const std::string& first, const std::string& second) {
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr("transforms.json"), HasSubstr(first),
                                                            HasSubstr(second))));
  }
  ScratchFolder scratch_;
  json document_;
};

TEST_F(BadTransforms, MissingKeysAreRefused) {
  document_["frames"][1].erase("transform_matrix");
  ExpectError("frame 1", "'transform_matrix' is missing");
}
TEST_F(BadTransforms, MissingFilePathIsRefused) {
  document_["frames"][2].erase("file_path");
  ExpectError("frame 2", "'file_path' is missing");
}
TEST_F(BadTransforms, MissingFocalLengthIsRefused) {
  document_.erase("fl_x");
  document_.erase("fl_y");
  ExpectError("frame 0", "fl_x");
}
TEST_F(BadTransforms, PrincipalPointInPartsIsRefused) {
  document_["cx"] = 0.5;
  document_["cy"] = 0.5;
  ExpectError("'cx' and 'cy' are 0.5 and 0.5", "Write pixels");
}
TEST_F(BadTransforms, FisheyeWithTangentialTermsIsRefused) {
  document_["camera_model"] = "OPENCV_FISHEYE";
  document_["p1"] = 0.001;
  ExpectError("'p1' and 'p2' are 0.001", "OPENCV_FISHEYE");
}
TEST_F(BadTransforms, MissingFramesAreRefused) {
  document_.erase("frames");
  ExpectError("'frames'", "missing");
}
TEST_F(BadTransforms, EmptyFramesAreRefused) {
  document_["frames"] = json::array();
  ExpectError("'frames'", "empty");
}
TEST_F(BadTransforms, WrongTypeIsRefused) {
  document_["fl_x"] = "wide";
  ExpectError("'fl_x'", "must be a number");
}
TEST_F(BadTransforms, FramesOfAWrongTypeAreRefused) {
  document_["frames"] = 7;
  ExpectError("'frames'", "list");
}
TEST_F(BadTransforms, MatrixOfAWrongShapeIsRefused) {
  document_["frames"][0]["transform_matrix"] = {{1, 0}, {0, 1}};
  ExpectError("frame 0", "4 rows of 4");
}
TEST_F(BadTransforms, MatrixThatIsNoRotationIsRefused) {
  document_["frames"][1]["transform_matrix"][0][0] = 3.0;
  ExpectError("frame 1", "not a rotation");
}
TEST_F(BadTransforms, MirroredPoseIsRefused) {
  for (std::size_t r = 0; r < 3; ++r)
    document_["frames"][1]["transform_matrix"][r][0] =
        -document_["frames"][1]["transform_matrix"][r][0].get<double>();
  ExpectError("frame 1", "not a rotation");
}
TEST_F(BadTransforms, PoseThatIsNotFiniteIsRefused) {
  document_["frames"][1]["transform_matrix"][0][3] =
      std::numeric_limits<double>::quiet_NaN();  // written as null
  ExpectError("frame 1", "not a finite number");
}
TEST_F(BadTransforms, LiteralNanIsRefused) {
  std::string text = JsonText(document_);
  text.replace(text.find("\"cx\":") + 5, 4, "NaN ");
  std::ofstream(scratch_ / "lf/transforms.json") << text;
  EXPECT_THAT([&] { ReadLightField(scratch_ / "lf"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("transforms.json"), HasSubstr("'cx'"), HasSubstr("NaN"))));
}
TEST_F(BadTransforms, BracketsOneLevelTooDeepAreRefused) {
  constexpr std::size_t kLevels = 101;  // within the whole's
  std::ofstream(scratch_ / "lf/transforms.json")
      << "{\"w\": " << std::string(kLevels, '[') << std::string(kLevels, ']') << "}";
  EXPECT_THAT([&] { ReadLightField(scratch_ / "lf"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("transforms.json"), HasSubstr("nested too deeply"))));
}
TEST_F(BadTransforms, FileCutInTheMiddleIsRefused) {
  const std::string text = JsonText(document_);
  std::ofstream(scratch_ / "lf/transforms.json") << text.substr(0, text.size() / 2);
  EXPECT_THAT([&] { ReadLightField(scratch_ / "lf"); }, ThrowsMessage<Error>(HasSubstr("not valid JSON")));
}
TEST_F(BadTransforms, AnotherKindOfFileIsRefused) {
  std::ofstream(scratch_ / "poses.txt") << "0.0 1 2 3 0 0 0 1\n";
  EXPECT_THAT([&] { ReadLightField(scratch_ / "poses.txt"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("is no light field"), HasSubstr("ulf import"))));
}
TEST_F(BadTransforms, PathOutOfTheFolderIsRefused) {
  cv::imwrite((scratch_ / "outside.png").string(), NoiseFrame(0).image.pixels);
  document_["frames"][0]["file_path"] = "../outside.png";
  ExpectError("../outside.png", "leaves the folder");
  document_["frames"][0]["file_path"] = (scratch_ / "outside.png").string();
  ExpectError("outside.png", "leaves the folder");
  fs::create_symlink(scratch_ / "outside.png", scratch_ / "lf/images/link.png");
  document_["frames"][0]["file_path"] = "images/link.png";
  ExpectError("link.png", "leaves the folder");
}
TEST_F(BadTransforms, MissingImageIsRefused) {
  fs::remove(scratch_ / "lf/images/000002.png");
  ExpectError("000002.png", "missing");
}
TEST_F(BadTransforms, TruncatedImageIsRefused) {
  const fs::path image = scratch_ / "lf/images/000002.png";
  fs::resize_file(image, fs::file_size(image) - 20);
  const LightField read = Read();
  EXPECT_THAT([&] { ReadViewImage(read, read.views[1]); },
              ThrowsMessage<Error>(AllOf(HasSubstr("000002.png"), HasSubstr("truncated"))));
}
TEST_F(BadTransforms, ImageOfAnotherSizeIsRefused) {
  document_["w"] = 65;
  const LightField read = Read();
  EXPECT_THAT([&] { ReadViewImage(read, read.views[0]); },
              ThrowsMessage<Error>(AllOf(HasSubstr("64x48"), HasSubstr("65x48"))));
}
TEST_F(BadTransforms, SubjectWithoutExtentIsRefused) {
  document_["ulf"]["subject"]["radius"] = -1;
  ExpectError("'radius'", "must be positive");
}
TEST_F(BadTransforms, IdThatIsNoWholeNumberIsRefused) {
  document_["frames"][1]["ulf"]["id"] = 1e300;
  ExpectError("frame 1", "whole number");
}
TEST_F(BadTransforms, ReasonsThatAreNoCountsAreRefused) {
  document_["ulf"]["reasons"] = {{"covered", "many"}};
  ExpectError("'covered'", "must be a count");
}
TEST_F(BadTransforms, NewerFormatIsRefused) {
  document_["ulf"]["format_version"] = 99;
  ExpectError("99", "newer");
}
TEST_F(BadTransforms, IdsGivenTwiceAreRefused) {
  document_["frames"][1]["ulf"]["id"] = 1;
  ExpectError("id 1", "given once");
}

TEST(BadLightField, EmptyAndMissingFoldersAreRefused) {
  ScratchFolder scratch;
  EXPECT_THAT([&] { ReadLightField(scratch.path()); },
              ThrowsMessage<Error>(HasSubstr("holds no light field")));
  EXPECT_THAT([&] { ReadLightField(scratch / "gone"); }, ThrowsMessage<Error>(HasSubstr("no such folder")));
}

TEST(Transforms, InstantNgpsAndBlendersKeysAreUnderstood) {
  ScratchFolder scratch;
  cv::imwrite((scratch / "a.png").string(), cv::Mat(40, 80, CV_8UC3, cv::Scalar(1, 2, 3)));
  std::ofstream(scratch / "transforms.json") << R"({"camera_angle_x": 1.5707963267948966, "frames": [
    {"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})";
  const LightField read = ReadLightField(scratch.path());
  EXPECT_NEAR(read.cameras[0].fx, 40, 1e-9) << "half the width over tan 45 degrees";
  EXPECT_EQ(read.cameras[0].height, 40);
  EXPECT_EQ(read.views[0].image_path, "a.png");
  // Identity in OpenGL's axes looks along -z.
  EXPECT_LT((read.views[0].cam_from_world.DirectionInSource({0, 0, 1}) - Eigen::Vector3d(0, 0, -1)).norm(),
            1e-12);
}

TEST(Import, CopiesPhotographsExactlyAndFindsSubject) {
  ScratchFolder scratch;
  WriteSample(scratch / "source", 6);
  fs::remove(scratch / "source/journal.jsonl");
  json document = JsonFromText(ReadWholeFile(scratch / "source/transforms.json"));
  document.erase("ulf");
  std::ofstream(scratch / "source/transforms.json") << JsonText(document);
  const LightField imported = Import(scratch / "source", scratch / "lf", {}).light_field;
  EXPECT_LT((imported.subject->center_in_world - Eigen::Vector3d(0, 0, 3)).norm(), 1e-6);
  EXPECT_EQ(ReadWholeFile(scratch / "lf/images/000003.png"),
            ReadWholeFile(scratch / "source/images/000003.png"));
  ExpectSame(imported, ReadLightField(scratch / "lf"));
}

TEST(Import, TakesWhatIsStillInItsMasterAlone) {
  ScratchFolder scratch;
  const LightFieldWriter capturing = WriterAheadOfItsPhotographs(scratch / "source", 2);
  ASSERT_FALSE(fs::exists(scratch / "source/images/000001.png"));
  const LightField imported =
      Import(scratch / "source", scratch / "lf", {.subject = Subject{{0, 0, 5}, 1}}).light_field;
  for (const View& view : ReadLightField(scratch / "lf").views) {
    EXPECT_EQ(cv::norm(ReadImageFile((scratch / "lf" / view.image_path).string()),
                       ReadRecordedImage(capturing.Contents(), view).pixels, cv::NORM_INF),
              0);
    EXPECT_EQ(ReadWholeFile(scratch / "lf" / view.master_path),
              ReadWholeFile(scratch / "source" / view.master_path))
        << "the master comes along";
  }
  EXPECT_EQ(imported.views.size(), 2u);
}

TEST(Import, TakesASubjectOrLeavesItsOwnOut) {
  ScratchFolder scratch;
  {
    LightFieldWriter writer = LightFieldWriter::Create(scratch / "source", Header());
    for (int i = 0; i < 3; ++i) {
      View view;
      view.cam_from_world.translation = {0.2 * i, 0, 0};
      writer.AddView(NoiseFrame(i), view);
    }
    writer.Close(1);
  }
  EXPECT_FALSE(Import(scratch / "source", scratch / "lf", {}).light_field.subject)
      << "a light field that has none, and whose cameras are parallel";
  EXPECT_EQ(Import(scratch / "source", scratch / "lf2", {.subject = Subject{{0, 0, 5}, 1}})
                .light_field.subject->radius,
            1);
  EXPECT_EQ(ParseSubject("0,0,-8.12,1.5").center_in_world.z(), -8.12);
  for (const char* bad :
       {"", "1,2,3", "1,2,3,4,5", "1,2,3,-1", "a,b,c,d", "1,2,3,0", "nan,0,0,1", "0,0,0,inf"})
    EXPECT_THROW(ParseSubject(bad), Refusal) << bad;
}

// A set as another program leaves it: three views, a picture each of its own kind.
class Foreign : public testing::Test {
 protected:
  void SetUp() override {
    WriteSample(source(), 3);
    for (const char* ours : {"journal.jsonl", "points.ply"}) fs::remove(source() / ours);
    document_ = JsonFromText(ReadWholeFile(source() / "transforms.json"));
    document_.erase("ulf");
    document_.erase("ply_file_path");
    for (json& frame : document_["frames"]) frame.erase("ulf");
  }
  fs::path source() const { return scratch_ / "source"; }
  LightField Imported() {
    std::ofstream(source() / "transforms.json") << JsonText(document_);
    return Import(source(), scratch_ / "lf", {.subject = Subject{{0, 0, 3}, 0.4}}).light_field;
  }
  ScratchFolder scratch_;
  json document_;
};

TEST_F(Foreign, PointsComeAlong) {
  fs::create_directories(source() / "clouds");
  std::ofstream(source() / "clouds/sparse.ply")
      << "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n"
         "property float nx\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
         "1 2 3 0 10 20 30\n-1.5 0 4 0 200 100 0\n";
  document_["ply_file_path"] = "clouds/sparse.ply";
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  ASSERT_EQ(read.points.size(), 2u);
  EXPECT_EQ(read.points[1].position_in_world, Eigen::Vector3d(-1.5, 0, 4));
  EXPECT_EQ(read.points[1].rgb[0], 200);
  EXPECT_EQ(ReadLightField(source()).points.size(), 2u) << "and without importing";
}

TEST_F(Foreign, PointsWithoutVerticesAreASetWithoutPoints) {
  std::ofstream(source() / "points.ply") << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float "
                                            "x\nproperty float y\nproperty float z\nend_header\n";
  document_["ply_file_path"] = "points.ply";
  std::ofstream(source() / "transforms.json") << JsonText(document_);
  const LightField read = ReadLightField(source());
  EXPECT_TRUE(read.points.empty());
  EXPECT_TRUE(read.doubts.empty());
}

TEST_F(Foreign, MasksComeAlong) {
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 10, kHeight)) = 0;
  fs::create_directories(source() / "cut");
  cv::imwrite((source() / "cut/second.png").string(), mask);
  document_["frames"][1]["mask_path"] = "cut/second.png";
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  EXPECT_TRUE(read.views[0].mask_path.empty());
  EXPECT_EQ(read.views[1].mask_path, "masks/000002.png");
  EXPECT_EQ(cv::norm(ReadViewMask(read, read.views[1]), mask, cv::NORM_INF), 0);
}

TEST_F(Foreign, AlphaIsAMask) {
  cv::Mat pixels(kHeight, kWidth, CV_8UC4, cv::Scalar(1, 2, 3, 255));
  pixels(cv::Rect(5, 5, 7, 9)) = cv::Scalar(200, 2, 3, 20);
  cv::imwrite((source() / "images/000001.png").string(), pixels);
  cv::imwrite((source() / "images/000002.png").string(),
              cv::Mat(kHeight, kWidth, CV_8UC4, cv::Scalar(1, 2, 3, 255)));
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  const cv::Mat mask = ReadViewMask(read, read.views[0]);
  EXPECT_EQ(mask.total() - static_cast<std::size_t>(cv::countNonZero(mask)), 7u * 9u);
  EXPECT_EQ(mask.at<std::uint8_t>(6, 6), 0);
  EXPECT_TRUE(read.views[1].mask_path.empty()) << "nothing of it is transparent";
  EXPECT_EQ(ReadWholeFile(scratch_ / "lf/images/000001.png"), ReadWholeFile(source() / "images/000001.png"));
}

TEST_F(Foreign, AMaskAndAlphaBothExclude) {
  cv::Mat pixels(kHeight, kWidth, CV_8UC4, cv::Scalar(1, 2, 3, 255));
  pixels.colRange(0, 20) = cv::Scalar(1, 2, 3, 0);
  cv::imwrite((source() / "images/000001.png").string(), pixels);
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  mask.colRange(10, 30) = 0;
  cv::imwrite((source() / "mask.png").string(), mask);
  document_["frames"][0]["mask_path"] = "mask.png";
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  const cv::Mat both = ReadViewMask(read, read.views[0]);
  EXPECT_EQ(cv::countNonZero(both.colRange(0, 30)), 0);
  EXPECT_EQ(cv::countNonZero(both.colRange(30, kWidth)), (kWidth - 30) * kHeight);
}

// A PNG of grey and alpha, which OpenCV does not write (colour type 4 of ISO 15948).
void WriteGreyWithAlpha(const fs::path& png, const cv::Mat& grey, const cv::Mat& alpha) {
  const auto four = [](std::uint32_t n) {
    return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8),
                       static_cast<char>(n)};
  };
  const auto chunk = [&](const std::string& name, const std::string& content) {
    const std::string named = name + content;
    const auto checksum = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(named.data()), static_cast<uInt>(named.size())));
    return four(static_cast<std::uint32_t>(content.size())) + named + four(checksum);
  };
  std::string rows;
  for (int y = 0; y < grey.rows; ++y) {
    rows += '\0';  // no filter
    for (int x = 0; x < grey.cols; ++x) {
      rows += static_cast<char>(grey.at<std::uint8_t>(y, x));
      rows += static_cast<char>(alpha.at<std::uint8_t>(y, x));
    }
  }
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           rows.size());
  packed.resize(size);
  const std::string header = four(static_cast<std::uint32_t>(grey.cols)) +
                             four(static_cast<std::uint32_t>(grey.rows)) + std::string{8, 4, 0, 0, 0};
  std::ofstream(png, std::ios::binary) << "\x89PNG\r\n\x1a\n"
                                       << chunk("IHDR", header) << chunk("IDAT", packed) << chunk("IEND", "");
}

// Alpha without colour.
TEST_F(Foreign, GreyWithAlphaIsAGreyPictureAndAMask) {
  const cv::Mat grey(kHeight, kWidth, CV_8UC1, cv::Scalar(90));
  cv::Mat alpha(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  alpha.colRange(0, 11) = 0;
  WriteGreyWithAlpha(source() / "images/000001.png", grey, alpha);
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  EXPECT_EQ(cv::countNonZero(ReadViewMask(read, read.views[0])), (kWidth - 11) * kHeight);
  const cv::Mat srgb = Srgb8(ReadViewImage(read, read.views[0]));
  ASSERT_EQ(srgb.type(), CV_8UC3);
  EXPECT_EQ(srgb.at<cv::Vec3b>(kHeight / 2, kWidth / 2), cv::Vec3b(90, 90, 90));
}

// A picture that is transparent all over shows nothing: it is imported with a mask that excludes all of it.
TEST_F(Foreign, TransparentAllOverExcludesAllOfIt) {
  cv::imwrite((source() / "images/000001.png").string(),
              cv::Mat(kHeight, kWidth, CV_8UC4, cv::Scalar(1, 2, 3, 0)));
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  EXPECT_EQ(cv::countNonZero(ReadViewMask(read, read.views[0])), 0);
}

// tRNS (ISO 15948) behind the header of a PNG without an alpha channel.
void AddTransparentColors(const fs::path& png, const std::string& content) {
  constexpr std::size_t kSignatureAndHeader = 33;
  const auto four = [](std::uint32_t n) {
    return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8),
                       static_cast<char>(n)};
  };
  const std::string named = "tRNS" + content;
  const auto checksum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(named.data()), static_cast<uInt>(named.size())));
  std::string bytes = ReadWholeFile(png);
  bytes.insert(kSignatureAndHeader,
               four(static_cast<std::uint32_t>(content.size())) + named + four(checksum));
  std::ofstream(png, std::ios::binary) << bytes;
}

TEST_F(Foreign, AColorThatIsTransparentIsAMask) {
  cv::Mat pixels(kHeight, kWidth, CV_8UC3, cv::Scalar(1, 2, 3));
  pixels(cv::Rect(5, 5, 7, 9)) = cv::Scalar(200, 100, 50);
  cv::imwrite((source() / "images/000001.png").string(), pixels);
  using namespace std::string_literals;
  AddTransparentColors(source() / "images/000001.png", "\0\x32\0\x64\0\xC8"s);  // red, green, blue
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  const cv::Mat mask = ReadViewMask(read, read.views[0]);
  ASSERT_EQ(mask.total(), static_cast<std::size_t>(kWidth * kHeight));
  EXPECT_EQ(mask.total() - static_cast<std::size_t>(cv::countNonZero(mask)), 7u * 9u);
  EXPECT_EQ(mask.at<std::uint8_t>(6, 6), 0);
}

// As nerfstudio has it: each key in the frame or, where it is not there, of the set.
TEST_F(Foreign, IntrinsicsAreReadKeyByKey) {
  for (const char* key : {"k1", "k2", "k3", "p1", "p2"}) document_.erase(key);
  document_["camera_model"] = "OPENCV";
  document_["cx"] = 30;
  document_["k1"] = -0.2;
  document_["fl_x"] = document_["fl_y"] = 60;
  document_["frames"][0]["fl_x"] = 90;
  document_["frames"][2]["cy"] = 20;
  Imported();
  const LightField read = ReadLightField(scratch_ / "lf");
  ASSERT_EQ(read.cameras.size(), 3u);
  const auto camera = [&](std::size_t view) { return read.CameraOf(read.views[view]); };
  EXPECT_EQ(camera(0).fx, 90);
  EXPECT_EQ(camera(0).fy, 90);
  EXPECT_EQ(camera(1).fx, 60) << "which says nothing of its own";
  EXPECT_EQ(camera(2).fx, 60);
  EXPECT_EQ(camera(2).cy, 20);
  for (const std::size_t view : {0, 1, 2}) {
    EXPECT_EQ(camera(view).cx, 30);
    EXPECT_EQ(camera(view).coefficients[0], -0.2);
  }
}

// A light field of ours: who only looks at it must hear of it, too.
TEST(LostJournal, IsSaidByReadersAndNamesRepair) {
  ScratchFolder scratch;
  WriteSample(scratch / "lf", 2);
  EXPECT_TRUE(ReadLightField(scratch / "lf").doubts.empty());
  fs::remove(scratch / "lf/journal.jsonl");
  EXPECT_THAT(ReadLightField(scratch / "lf").doubts,
              testing::ElementsAre(AllOf(HasSubstr("the journal is missing"), HasSubstr("ulf repair"))));
  const auto refine = test::RunUlf("refine " + (scratch / "lf").string());
  EXPECT_NE(refine.exit_code, 0);
  EXPECT_THAT(refine.errors, HasSubstr("ulf repair"));
}

TEST_F(Foreign, DamagedPointsAreNamedAndLeftOut) {
  std::ofstream(source() / "points.ply") << "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n";
  std::ofstream(source() / "transforms.json") << JsonText(document_);
  const LightField read = ReadLightField(source());
  EXPECT_EQ(read.views.size(), 3u);
  EXPECT_TRUE(read.points.empty());
  EXPECT_THAT(read.doubts, testing::ElementsAre(HasSubstr("points.ply")));
}

TEST_F(Foreign, AMaskOfAnotherAspectIsNamed) {
  cv::imwrite((source() / "mask.png").string(), cv::Mat(48, 48, CV_8UC1, cv::Scalar(255)));
  document_["frames"][0]["mask_path"] = "mask.png";
  EXPECT_THAT([&] { Imported(); }, ThrowsMessage<Error>(AllOf(HasSubstr("mask.png"), HasSubstr("48x48"))));
}

TEST_F(Foreign, NamesWhatIsNotUnderstood) {
  document_["sky_color"] = "blue";
  document_["frames"][0]["depth_file_path"] = "d.png";
  document_["frames"][2]["depth_file_path"] = "e.png";
  std::ofstream(source() / "transforms.json") << JsonText(document_);
  EXPECT_THAT(ReadLightField(source()).doubts,
              testing::UnorderedElementsAre(AllOf(HasSubstr("'sky_color' is not used")),
                                            AllOf(HasSubstr("'depth_file_path' of 2 frames is not used"))));
  const auto said =
      test::RunUlf("import " + source().string() + " --subject 0,0,3,0.4 -o " + (scratch_ / "lf").string());
  EXPECT_EQ(said.exit_code, 0);
  EXPECT_THAT(said.errors, AllOf(HasSubstr("sky_color"), HasSubstr("depth_file_path")));
}

// Every row of the COLMAP text model has the fields that its readers count on, and every file is there.
TEST_F(Foreign, NamesBreakNoRow) {
  // The last with a space of the kind that macOS writes into the names of screenshots, which parts fields
  // too.
  const char* const names[] = {"images/a view.png", "images/a\nview.png",
                               "images/sub dir/\tthird\u202f2.png"};
  fs::create_directories(source() / "images/sub dir");
  for (std::size_t i = 0; i < 3; ++i) {
    fs::rename(source() / "images" / fmt::format("{:06}.png", i + 1), source() / names[i]);
    document_["frames"][i]["file_path"] = names[i];
  }
  Imported();
  std::vector<std::string> found;
  for (const auto& [id, image] : test::ReadAsColmap(scratch_ / "lf/sparse/0").images) {
    found.push_back(image.name);
    EXPECT_TRUE(fs::exists(scratch_ / "lf/images" / image.name)) << image.name;
  }
  EXPECT_THAT(found, testing::UnorderedElementsAre("a_view.png", "a_view-2.png", "sub_dir/_third_2.png"));
  EXPECT_EQ(ReadLightField(scratch_ / "lf").views.size(), 3u);
}

TEST_F(Foreign, SizesThatNoImageHasAreShownAsTheyAre) {
  document_["w"] = 2147483648.0;
  EXPECT_THAT([&] { Imported(); }, ThrowsMessage<Error>(AllOf(HasSubstr("'w'"), HasSubstr("2147483648"))));
}

// What people try first has no poses, or has them in a way that is not read.
TEST_F(Foreign, OtherFoldersAreToldApart) {
  const auto refusal = [&](const fs::path& path) {
    const auto run = test::RunUlf("import '" + path.string() + "' -o " + (scratch_ / "lf").string());
    EXPECT_EQ(run.exit_code, 1) << run.output;
    EXPECT_FALSE(fs::exists(scratch_ / "lf"));
    return run.errors;
  };
  std::ofstream(scratch_ / "my walk.MP4") << "film";
  EXPECT_THAT(refusal(scratch_ / "my walk.MP4"),
              HasSubstr("ulf capture replay:\"" + (scratch_ / "my walk.MP4").string() + "\" -o"));
  fs::create_directories(scratch_ / "photographs");
  fs::copy(source() / "images/000001.png", scratch_ / "photographs/a.PNG");
  EXPECT_THAT(refusal(scratch_ / "photographs"), HasSubstr("photographs without poses"));
  fs::create_directories(scratch_ / "photographs/sparse/0");
  std::ofstream(scratch_ / "photographs/sparse/0/images.bin") << "?";
  EXPECT_THAT(refusal(scratch_ / "photographs"), HasSubstr("sparse/0/cameras.bin"));
  EXPECT_THAT(refusal(scratch_ / "nowhere"), HasSubstr("no such file or folder"));
}

TEST_F(Foreign, AnImportThatFailsLeavesNothing) {
  fs::resize_file(source() / "images/000003.png", 200);
  EXPECT_THROW(Imported(), Error);
  for (const auto& entry : fs::directory_iterator(scratch_.path()))
    EXPECT_EQ(entry.path().filename(), "source") << "left behind";
}

TEST_F(Foreign, FailedImportOnAFullDiskLeavesNothing) {
  fs::create_directories(scratch_ / "disk");
  if (const auto why = test::MountSmallDisk(scratch_ / "disk", 1 << 20)) GTEST_SKIP() << *why;
  std::ofstream(source() / "transforms.json") << JsonText(document_);
  test::FillDisk(scratch_ / "disk/filler");
  fs::resize_file(scratch_ / "disk/filler", fs::file_size(scratch_ / "disk/filler") - 24000);
  EXPECT_THAT(
      [&] {
        Import(source(), scratch_ / "disk/new/lf", {.subject = Subject{{0, 0, 3}, 0.4}});
      },
      ThrowsMessage<DiskFullError>(
          AllOf(HasSubstr("disk/new/lf"), HasSubstr("no file was left behind"), HasSubstr("MB are needed"))))
      << "known from the photographs' sizes";
  for (const auto& entry : fs::directory_iterator(scratch_ / "disk"))
    EXPECT_EQ(entry.path().filename(), "filler") << "left behind";
}

// A frame costs what its view needs, not what its text does.
TEST_F(Foreign, ManyFramesNeedLittleMemory) {
  if (test::kIsSanitized) GTEST_SKIP() << "a sanitizer's memory is another";
  constexpr int kFrames = 10000;
  json frame = document_["frames"][0];
  frame["w"] = kWidth;
  frame["h"] = kHeight;
  frame["comment"] = std::string(2000, 'x');
  document_["frames"] = json::array();
  std::string text = JsonText(document_);
  text.resize(text.rfind("[]") + 1);
  {
    std::ofstream file(source() / "transforms.json");
    file << text;
    for (int i = 0; i < kFrames; ++i) {
      frame["fl_x"] = 60 + 1e-4 * i;  // a camera a frame, as COLMAP gives where it is told nothing
      file << (i > 0 ? "," : "") << JsonText(frame);
    }
    file << JsonText(document_).substr(text.size());
  }
  ASSERT_GT(fs::file_size(source() / "transforms.json"), kFrames * 2000u);
  const pid_t child = fork();
  if (child == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const bool all = ReadLightField(source()).views.size() == kFrames;
    getrusage(RUSAGE_SELF, &after);
    _exit(all && after.ru_maxrss - before.ru_maxrss < 20 << 10 ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "not read, or by more than 20 MiB";
}

TEST(Import, TakesInRealCaptures) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  ScratchFolder scratch;
  const LightField imported = Import(fox, scratch / "lf", {}).light_field;
  EXPECT_EQ(imported.views.size(), 50u);
  EXPECT_EQ(imported.cameras.size(), 1u);
  // The fox's head is what every camera looks at.
  for (const View& view : imported.views) {
    const auto img =
        imported.CameraOf(view).ImgFromCam(view.cam_from_world * imported.subject->center_in_world);
    ASSERT_TRUE(img) << view.image_path;
    EXPECT_TRUE(imported.CameraOf(view).Contains(*img)) << view.image_path << " " << img->transpose();
  }
}

}  // namespace
}  // namespace ulf::transforms_test

// Tests: core/light_field/formats/raw_beside, core/light_field/exchange/import_light_field,
// core/light_field/folder/view_files.
#include "core/base/json_text.h"
#include "core/light_field/formats/raw_beside.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/posed_set.h"
#include "core/light_field/formats/view_json.h"
#include "tests/support/dng_file.h"
#include "tests/support/test_paths.h"

namespace ulf::test::raw_sets_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Something to see everywhere, without edges that a mosaic cannot hold.
cv::Vec3d Waves(int x, int y) {
  const double a = std::sin(0.31 * x + 0.11 * y), b = std::cos(0.23 * y - 0.07 * x),
               c = std::sin(0.05 * x * y / 30);
  return {0.30 + 0.06 * a + 0.05 * c, 0.35 + 0.06 * b + 0.05 * c, 0.25 + 0.05 * (a + b) + 0.03 * c};
}

const DngCamera& StudioCamera() {
  static const DngCamera camera = [] {
    DngCamera studio;
    studio.sensor = {320, 224};
    studio.visible = {8, 4, 304, 216};
    studio.crop = cv::Rect(2, 4, 300, 208);
    return studio;
  }();
  return camera;
}

const std::string& StudioDng() {
  static const std::string bytes = DngBytes(StudioCamera(), Waves);
  return bytes;
}

// As the camera would show the same, with a tone curve of its own.
std::string CameraJpeg(const cv::Rect& crop) {
  cv::Mat levels;
  cv::sqrt(LightOf(Waves, crop), levels);
  levels.convertTo(levels, CV_8UC3, 255);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", levels, bytes, {cv::IMWRITE_JPEG_QUALITY, 97});
  return {bytes.begin(), bytes.end()};
}

class RawSetTest : public ::testing::Test {
 protected:
  void Put(const std::string& name, const std::string& bytes) {
    fs::create_directories((set_ / name).parent_path());
    std::ofstream(set_ / name, std::ios::binary) << bytes;
  }
  // Three cameras that look at the origin.
  void PutTransforms(const std::vector<std::string>& names, cv::Size size = {300, 208}) {
    nlohmann::json set = {{"fl_x", 280.0}, {"w", size.width}, {"h", size.height}};
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double x = 0.2 * (static_cast<double>(i) - 1), length = std::hypot(x, 1);
      const double c = 1 / length, s = x / length;
      set["frames"].push_back(
          {{"file_path", names[i]},
           {"transform_matrix", {{c, 0, s, x}, {0, 1, 0, 0}, {-s, 0, c, 1}, {0, 0, 0, 1}}}});
    }
    Put("transforms.json", JsonText(set));
  }
  LightField Taken() {
    ImportOptions options;
    options.subject = Subject{Eigen::Vector3d::Zero(), 0.2};
    Import(set_.path(), folder_ / "lf", options);
    return ReadLightField(folder_ / "lf");
  }
  static Frame Still(const std::string& raw) {
    Frame still;
    still.kind = FrameKind::kStill;
    still.raw = EncodedImage{".dng", std::make_shared<const std::string>(raw)};
    still.image = {DecodeRaw(raw, "a.dng", RawQuality::kQuick).light, Transfer::kLinear};
    return still;
  }
  static double WorstError(const Image& image, const cv::Rect& crop) {
    const cv::Mat truth = LightOf(Waves, crop), light = LinearFloat(image);
    if (truth.size() != light.size()) return 1e9;
    const cv::Rect inside(4, 4, truth.cols - 8, truth.rows - 8);
    return cv::norm(light(inside), truth(inside), cv::NORM_INF);
  }

  ScratchFolder folder_, set_;
};

// Of full scale, at waves of twenty pixels: what the mosaic's interpolation makes of them.
constexpr double kTolerance = 0.02;

TEST_F(RawSetTest, LoneRawFilesBecomeMasters) {
  for (const char* name : {"a.dng", "b.DNG", "c.dng"}) Put(name, StudioDng());
  PutTransforms({"a.dng", "b.DNG", "c.dng"});
  const LightField light_field = Taken();
  ASSERT_EQ(light_field.views.size(), 3u);
  EXPECT_THAT(light_field.doubts, ::testing::IsEmpty());
  for (const View& view : light_field.views) {
    EXPECT_EQ(fs::path(view.image_path).extension(), ".png");
    EXPECT_EQ(fs::path(view.master_path).extension(), ".dng");
    EXPECT_EQ(ReadWholeFile(light_field.root / view.master_path), StudioDng());
    EXPECT_NEAR(view.exposure_s, 1 / 60.0, 1e-5);
    EXPECT_DOUBLE_EQ(view.gain, 4);
    EXPECT_NEAR(view.f_number.value_or(0), 5.6, 1e-3);
    EXPECT_NEAR(view.focal_mm.value_or(0), 35, 1e-3);
    EXPECT_EQ(view.lens, "Acme 35mm f/2");
    EXPECT_TRUE(HasMoreThanEightBits(light_field, view));
    for (const Image& image : {ReadViewMaster(light_field, view), ReadViewLight(light_field, view)}) {
      EXPECT_EQ(image.transfer, Transfer::kLinear);
      EXPECT_LT(WorstError(image, *StudioCamera().crop), kTolerance);
    }
    EXPECT_LT(WorstError(ReadRecordedImage(light_field, view), *StudioCamera().crop), kTolerance + 0.01);
  }
  const PictureCheck check = CheckPictures(light_field);
  EXPECT_TRUE(check.others.empty() && check.damaged.empty() && check.damaged_masters.empty());
  // A photograph that is gone is read from its raw file, and comes again.
  const fs::path photograph = light_field.root / light_field.views[1].image_path;
  const std::string before = ReadWholeFile(photograph);
  fs::remove(photograph);
  EXPECT_LT(WorstError(ReadRecordedImage(light_field, light_field.views[1]), *StudioCamera().crop),
            kTolerance + 0.01);
  LightFieldWriter::Resume(light_field.root).Close(0);
  EXPECT_EQ(ReadWholeFile(photograph), before);
}

TEST_F(RawSetTest, SlightlySmallerCameraCropsTheRawFile) {
  Put("a.dng", StudioDng());
  Put("b.dng", StudioDng());
  PutTransforms({"a.dng", "b.dng"}, {296, 204});
  const LightField light_field = Taken();
  const cv::Rect crop(4, 6, 296, 204);
  EXPECT_LT(WorstError(ReadViewLight(light_field, light_field.views[0]), crop), kTolerance);
  EXPECT_EQ(ReadRecordedImage(light_field, light_field.views[0]).width(), 296);
}

TEST_F(RawSetTest, JpegBesideIsThePhotograph) {
  const std::string jpeg = CameraJpeg(*StudioCamera().crop);
  for (const char* name : {"a", "b"}) {
    Put(std::string("photographs/") + name + ".JPG", jpeg);
    Put(std::string("photographs/") + name + ".DNG", StudioDng());
  }
  PutTransforms({"photographs/a.JPG", "photographs/b.DNG"});
  const LightField light_field = Taken();
  for (const View& view : light_field.views) {
    EXPECT_EQ(ReadWholeFile(light_field.root / view.image_path), jpeg) << view.image_path;
    EXPECT_EQ(ReadWholeFile(light_field.root / view.master_path), StudioDng()) << view.image_path;
    EXPECT_LT(WorstError(ReadViewLight(light_field, view), *StudioCamera().crop), kTolerance);
    EXPECT_GT(view.exposure_s, 0);
  }
  EXPECT_THAT(SetImages({}, set_ / "photographs", {}).names(), ElementsAre("a.JPG", "b.JPG")) << "each once";
}

TEST_F(RawSetTest, LeavesOutRawFilesUnlikeTheirJpeg) {
  // The camera has taken a lens's distortion out of its JPEG: the corners lie elsewhere.
  const cv::Rect crop = *StudioCamera().crop;
  cv::Mat picture = cv::imdecode(std::vector<char>([](const std::string&bytes) {
                                   return std::vector<char>(bytes.begin(), bytes.end());
                                 }(CameraJpeg(crop))),
                                 cv::IMREAD_COLOR),
          corrected;
  const cv::Matx33d camera(280, 0, 150, 0, 280, 104, 0, 0, 1);
  cv::Mat map_x(crop.height, crop.width, CV_32F), map_y = map_x.clone();
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x) {
      const double u = (x - camera(0, 2)) / 280, v = (y - camera(1, 2)) / 280,
                   bent = 1 - 0.1 * (u * u + v * v);
      map_x.at<float>(y, x) = static_cast<float>(camera(0, 2) + 280 * bent * u);
      map_y.at<float>(y, x) = static_cast<float>(camera(1, 2) + 280 * bent * v);
    }
  cv::remap(picture, corrected, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", corrected, bytes);
  const std::string jpeg(bytes.begin(), bytes.end());
  for (const char* name : {"a", "b"}) {
    Put(std::string(name) + ".jpg", jpeg);
    Put(std::string(name) + ".dng", StudioDng());
  }
  EXPECT_GT(LargestShiftPx(picture, corrected).value_or(0), 1);
  EXPECT_LT(LargestShiftPx(picture, picture).value_or(9), 0.1);
  EXPECT_FALSE(LargestShiftPx(cv::Mat(208, 300, CV_8UC3, cv::Scalar::all(9)), cv::Mat(208, 300, CV_8UC3)))
      << "nothing to be seen";
  PutTransforms({"a.jpg", "b.dng"});
  const LightField light_field = Taken();
  EXPECT_EQ(light_field.views[0].master_path, "") << "the poses are the JPEG's";
  EXPECT_EQ(ReadWholeFile(light_field.root / light_field.views[0].image_path), jpeg);
  EXPECT_EQ(fs::path(light_field.views[1].image_path).extension(), ".png") << "the poses are the raw file's";
}

TEST_F(RawSetTest, NamesACutRawFileAndLeavesNothing) {
  Put("a.dng", StudioDng());
  Put("b.dng", StudioDng().substr(0, StudioDng().size() / 2));
  PutTransforms({"a.dng", "b.dng"});
  EXPECT_THAT([&] { Taken(); }, ThrowsMessage<Error>(AllOf(HasSubstr("b.dng"), HasSubstr("copy it again"))));
  EXPECT_FALSE(fs::exists(folder_ / "lf"));
  // Beside its JPEG it is left.
  for (const char* name : {"a.jpg", "b.jpg"}) Put(name, CameraJpeg(*StudioCamera().crop));
  PutTransforms({"a.jpg", "b.jpg"});
  const LightField light_field = Taken();
  EXPECT_NE(light_field.views[0].master_path, "");
  EXPECT_EQ(light_field.views[1].master_path, "");
}

TEST_F(RawSetTest, UnreadableRawFileNamesTheRemedy) {
  Put("a.dng", StudioDng());
  Put("b.nef", std::string(100'000, 'x'));
  PutTransforms({"a.dng", "b.nef"});
  EXPECT_THAT([&] { Taken(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("b.nef"), HasSubstr("LibRaw"), HasSubstr("to DNG"))));
  EXPECT_FALSE(fs::exists(folder_ / "lf"));
  for (const char* name : {"a.jpg", "b.jpg"}) Put(name, CameraJpeg(*StudioCamera().crop));
  PutTransforms({"a.jpg", "b.jpg"});
  const LightField light_field = Taken();
  EXPECT_NE(light_field.views[0].master_path, "");
  EXPECT_EQ(light_field.views[1].master_path, "") << "its JPEG is used alone";
}

TEST_F(RawSetTest, FolderMayMixRawPairsAndLoneFiles) {
  const std::string jpeg = CameraJpeg(*StudioCamera().crop);
  for (const char* name : {"a.dng", "b.dng", "d.DNG"}) Put(name, StudioDng());
  for (const char* name : {"b.jpg", "c.jpg"}) Put(name, jpeg);
  PutTransforms({"a.jpg", "b.jpg", "c.jpg", "d.jpg"});  // as named by a program that made JPEGs of all
  const LightField light_field = Taken();
  ASSERT_EQ(light_field.views.size(), 4u);
  const auto endings = [&](std::size_t view) {
    return fs::path(light_field.views[view].image_path).extension().string() +
           fs::path(light_field.views[view].master_path).extension().string();
  };
  EXPECT_EQ(endings(0), ".png.dng");
  EXPECT_EQ(endings(1), ".jpg.dng");
  EXPECT_EQ(endings(2), ".jpg");
  EXPECT_EQ(endings(3), ".png.dng");
  EXPECT_GT(light_field.views[3].exposure_s, 0);
}

// An automatic white balance, in a set and in a capture that is resumed.
TEST_F(RawSetTest, AllUseTheWhiteBalanceOfTheFirst) {
  DngCamera other = StudioCamera();
  other.told_neutral = {0.6, 1, 0.5};
  const std::string other_dng = DngBytes(other, Waves);
  Put("a.dng", StudioDng());
  Put("b.dng", other_dng);
  PutTransforms({"a.dng", "b.dng"});
  const LightField taken = Taken();
  CaptureHeader header;
  header.camera = taken.cameras[0];
  {
    auto writer = LightFieldWriter::Create(folder_ / "captured", header);
    writer.AddView(Still(StudioDng()), {});
    writer.AddView(Still(other_dng), {});
    writer.Close(1);
  }
  {
    auto writer = LightFieldWriter::Resume(folder_ / "captured");
    const Frame third = Still(other_dng);
    const LightFieldWriter::NewView later{third, {}, writer.Files(third, MakePictures::kLater)};
    for (const View& view : writer.AddViews({&later, 1})) WritePictureFromMaster(folder_ / "captured", view);
    writer.Close(1);
  }
  const LightField captured = ReadLightField(folder_ / "captured");
  ASSERT_EQ(captured.views.size(), 3u);
  for (const LightField* light_field : {&taken, &captured}) {
    const cv::Mat first = ReadRecordedImage(*light_field, light_field->views[0]).pixels;
    EXPECT_FALSE(light_field->views[0].raw_white_balance);
    for (const View& view : light_field->views) {
      EXPECT_EQ(view.raw_white_balance.has_value(), &view != &light_field->views[0]) << view.id;
      EXPECT_LT(WorstError(ReadViewLight(*light_field, view), *StudioCamera().crop), kTolerance) << view.id;
      EXPECT_LE(cv::norm(ReadRecordedImage(*light_field, view).pixels, first, cv::NORM_INF), 1) << view.id;
    }
    EXPECT_EQ(ReadWholeFile(light_field->root / light_field->views[1].master_path), other_dng)
        << "as it came";
    const PictureCheck check = CheckPictures(*light_field);
    EXPECT_TRUE(check.others.empty() && check.damaged.empty() && check.damaged_masters.empty());
  }
}

TEST_F(RawSetTest, ResumedCaptureKeepsEachCamerasBalance) {
  DngCamera second = StudioCamera();
  second.model = "Acme Studio 2";
  const std::string second_dng = DngBytes(second, Waves);
  second.told_neutral = {0.6, 1, 0.5};
  CaptureHeader header;
  header.camera = {.width = 300, .height = 208, .fx = 280, .fy = 280, .cx = 150, .cy = 104};
  {
    auto writer = LightFieldWriter::Create(folder_ / "lf", header);
    writer.AddView(Still(StudioDng()), {});
    writer.AddView(Still(second_dng), {});
    writer.Close(1);
  }
  const View view = LightFieldWriter::Resume(folder_ / "lf").AddView(Still(DngBytes(second, Waves)), {});
  ASSERT_TRUE(view.raw_white_balance);
  EXPECT_EQ(*view.raw_white_balance, RawFactsOf(second_dng, "b.dng").white_balance);
}

TEST(RawWhiteBalance, FactorsThatNoSensorHasAreRefused) {
  View view, read;
  view.raw_white_balance = {2, 1, 1.5};
  view.lens = "Acme 35mm f/2";
  nlohmann::json keys = PhotographToJson(view);
  ReadPhotographJson({keys, "a line"}, read);
  EXPECT_EQ(read.raw_white_balance, view.raw_white_balance);
  EXPECT_EQ(read.lens, view.lens);
  keys["raw_white_balance"] = {2, 1, 0};
  EXPECT_THAT(
      [&] {
        ReadPhotographJson({keys, "a line"}, read);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("a line"), HasSubstr("raw_white_balance"))));
}

TEST_F(RawSetTest, ScalesTheCameraUnlessTheAspectDiffers) {
  Put("a.dng", StudioDng());
  PutTransforms({"a.dng"}, {150, 90});
  EXPECT_THAT([&] { Taken(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("a.dng"), HasSubstr("300x208"), HasSubstr("150x90"))));
  PutTransforms({"a.dng"}, {150, 104});
  const LightField light_field = Taken();
  EXPECT_EQ(light_field.cameras.at(0).width, 300);
  EXPECT_DOUBLE_EQ(light_field.cameras.at(0).fx, 2 * 280);
  EXPECT_LT(WorstError(ReadViewMaster(light_field, light_field.views[0]), *StudioCamera().crop), kTolerance);
}

TEST(RawSetDoubtsTest, SaysWhatDiffers) {
  RawFacts facts;
  facts.white_balance = {2, 1, 1.5};
  facts.has_white_balance = facts.has_color_matrix = true;
  RawSetDoubts doubts;
  doubts.Add("a.nef", facts);
  doubts.Add("b.nef", facts);
  EXPECT_THAT(doubts.Lines(), ::testing::IsEmpty());
  facts.white_balance[0] = 2.1;
  facts.has_color_matrix = false;
  doubts.Add("c.nef", facts);
  EXPECT_THAT(doubts.Lines(),
              ElementsAre(AllOf(HasSubstr("c.nef"), HasSubstr("another white balance than a.nef")),
                          AllOf(HasSubstr("c.nef"), HasSubstr("no colour matrix"))));
}

// A tethered camera that gives raw files alone.
TEST_F(RawSetTest, RecordedRawFileIsAMaster) {
  CaptureHeader header;
  header.camera.width = 300;
  header.camera.height = 208;
  header.camera.fx = header.camera.fy = 280;
  header.camera.cx = 150;
  header.camera.cy = 104;
  auto writer = LightFieldWriter::Create(folder_ / "lf", header);
  Frame frame;
  frame.kind = FrameKind::kStill;
  frame.raw = EncodedImage{".dng", std::make_shared<const std::string>(StudioDng())};
  frame.focal_mm = 35;
  frame.lens = "Acme 35mm f/2";
  frame.image = {DecodeRaw(StudioDng(), "a.dng", RawQuality::kQuick).light, Transfer::kLinear};
  writer.AddView(frame, {});
  const ViewFiles later = writer.Files(frame, MakePictures::kLater);
  EXPECT_FALSE(later.image) << "made when the raw file is on disk";
  const LightFieldWriter::NewView second{frame, {}, later};
  for (const View& view : writer.AddViews({&second, 1})) WritePictureFromMaster(folder_ / "lf", view);
  writer.Close(1);
  const LightField light_field = ReadLightField(folder_ / "lf");
  ASSERT_EQ(light_field.views.size(), 2u);
  for (const View& view : light_field.views) {
    EXPECT_THAT(view.master_path, HasSubstr(".dng"));
    EXPECT_EQ(view.focal_mm, 35);
    EXPECT_EQ(view.lens, "Acme 35mm f/2");
    EXPECT_FALSE(view.master_transfer) << "a raw file says itself what its numbers are";
    EXPECT_LT(WorstError(ReadViewLight(light_field, view), *StudioCamera().crop), kTolerance);
  }
  EXPECT_EQ(ReadWholeFile(light_field.root / light_field.views[0].image_path),
            ReadWholeFile(light_field.root / light_field.views[1].image_path));
}

}  // namespace
}  // namespace ulf::test::raw_sets_test

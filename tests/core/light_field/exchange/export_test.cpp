// Tests: core/light_field/exchange/export_light_field, core/light_field/formats/colmap_model,
// core/light_field/formats/colmap_binary, core/light_field/formats/colmap_text,
// core/light_field/formats/image_names, core/light_field/exchange/staged_folder, core/image/undistortion,
// core/light_field/exchange/conversions.
//
// A light field for other programs: what stays exactly as it is, what is undistorted, and that each program's
// reader takes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/conversions.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/colmap_model.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"

namespace ulf::export_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ScratchFolder;
using test::TrackedLightField;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr ExportForm kForms[] = {ExportForm::kColmapText, ExportForm::kColmapBinary, ExportForm::kNerfstudio};

CameraModel FromColmap(const test::ColmapRead::Camera& camera) {
  const auto& p = camera.parameters;
  CameraModel model{static_cast<int>(camera.width), static_cast<int>(camera.height), p[0], p[1], p[2], p[3]};
  if (camera.model == "OPENCV_FISHEYE") {
    model.distortion = Distortion::kFisheye;
    std::copy(p.begin() + 4, p.end(), model.coefficients.begin());
  } else if (camera.model != "PINHOLE") {
    model.distortion = Distortion::kRadialTangential;
    std::copy(p.begin() + 4, p.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(9, p.size())),
              model.coefficients.begin());
  }
  return model;
}

ExportSummary Export(const LightField& light_field, const fs::path& out, ExportForm form, bool undistort) {
  return ExportLightField(light_field, out, {.form = form, .undistort = undistort});
}

const std::vector<CameraModel> kEveryLens{test::Straight(), test::Lens(), test::SixthOrder(),
                                          test::Fisheye()};

// Every program's projection of every point, against the source's: through the distortion as it is, or the
// same ray through a pinhole.
TEST(Export, PosesAndProjectionsAreTheSources) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", kEveryLens);
  for (const bool undistort : {false, true})
    for (const ExportForm form : {ExportForm::kColmapText, ExportForm::kColmapBinary}) {
      const fs::path out = scratch / fmt::format("out{}{}", undistort, static_cast<int>(form));
      Export(source, out, form, undistort);
      const test::ColmapRead model = test::ReadAsColmap(out / "sparse/0");
      ASSERT_EQ(model.images.size(), source.views.size());
      std::size_t compared = 0;
      for (const View& view : source.views) {
        const auto& image = test::ImageNamed(model, fs::path(view.image_path).filename());
        EXPECT_LT((image.rotation.toRotationMatrix() - view.cam_from_world.RotationMatrix()).norm(), 1e-9);
        EXPECT_LT((image.translation - view.cam_from_world.translation).norm(), 1e-9);
        const CameraModel to = FromColmap(model.cameras.at(image.camera)), &from = source.CameraOf(view);
        for (std::size_t i = 0; i < image.places.size(); ++i) {
          if (image.point_ids[i] < 0) continue;
          const Vector3d in_cam = view.cam_from_world * model.points.at(image.point_ids[i]).position;
          const auto in_source = from.ImgFromCam(in_cam), in_export = to.ImgFromCam(in_cam);
          ASSERT_TRUE(in_source && in_export);
          const Vector2d expected = undistort ? *to.ImgFromCam(*from.RayFromImg(*in_source)) : *in_source;
          EXPECT_LT((*in_export - expected).norm(), 1e-3);
          EXPECT_LT((image.places[i] - expected).norm(), 1e-3);
          ++compared;
        }
      }
      EXPECT_GT(compared, 150u);
      for (const auto& [id, point] : model.points) EXPECT_LT(point.error_px, 1e-3);
    }
}

// COLMAP's files hold no points without a track beside those that have one.
TEST(Export, LargePhotographsAreMadeFewerAtOnce) {
  LightField large;
  large.cameras = {CameraModel::Pinhole(640, 480, 600), CameraModel::Pinhole(12000, 8500, 9000)};
  EXPECT_EQ(PicturesAtOnce(large, 1'000'000'000), 1u) << "also where not one fits";
  EXPECT_EQ(PicturesAtOnce(large, 14'000'000'000), 2u);
  large.cameras.pop_back();
  EXPECT_GE(PicturesAtOnce(large, 14'000'000'000), 4u);
  EXPECT_EQ(PicturesAtOnce(large, 14'000'000'000), PicturesAtOnce(large, 1'000'000'000'000));
}

TEST(Export, ThePointsThatAreCountedAreThoseInTheFiles) {
  const ScratchFolder scratch;
  LightField source = test::TrackedLightField(scratch / "lf", {test::Straight()});
  const std::size_t tracked = source.points.size();
  source.points.push_back({{0, 0, 3}});
  const auto points_in = [&](ExportForm form, const char* name) {
    return ExportLightField(source, scratch / name, {.form = form}).points.points;
  };
  EXPECT_EQ(points_in(ExportForm::kColmapText, "text"), tracked);
  EXPECT_EQ(points_in(ExportForm::kColmapBinary, "binary"), tracked);
  EXPECT_EQ(points_in(ExportForm::kNerfstudio, "nerfstudio"), tracked + 1) << "points.ply holds all";
  for (ScenePoint& point : source.points) point.track.clear();
  EXPECT_EQ(points_in(ExportForm::kColmapText, "untracked"), tracked + 1);
}

TEST(Export, NerfstudiosPosesAreTheSources) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight(), test::Lens()});
  for (const bool undistort : {false, true}) {
    const fs::path out = scratch / fmt::format("out{}", undistort);
    Export(source, out, ExportForm::kNerfstudio, undistort);
    const LightField read = ReadLightField(out);
    ASSERT_EQ(read.views.size(), source.views.size());
    for (std::size_t i = 0; i < read.views.size(); ++i) {
      EXPECT_LT((read.views[i].cam_from_world.Matrix() - source.views[i].cam_from_world.Matrix()).norm(),
                1e-9);
      const CameraModel& camera = read.CameraOf(read.views[i]);
      if (!undistort) {
        EXPECT_EQ(camera, source.CameraOf(source.views[i]));
        continue;
      }
      EXPECT_EQ(camera.distortion, Distortion::kNone);
      EXPECT_EQ(2 * camera.cx, camera.width);
      EXPECT_EQ(2 * camera.cy, camera.height);
    }
    EXPECT_GT(fs::file_size(out / "points.ply"), 60u * 15);
  }
}

// A program that passes over a profile sees other colours in the copy than ulf does.
TEST(Export, CountsNonSrgbCopiesWithTheirProfile) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight()}, 6);
  EXPECT_THAT(Export(source, scratch / "plain", ExportForm::kColmapText, false).doubts, testing::IsEmpty());
  for (const std::size_t i : {0U, 2U, 4U}) {
    const std::string png = ReadWholeFile(source.root / source.views[i].image_path);
    WriteFileAtomically(source.root / source.views[i].image_path,
                        test::WithPngChunk(png, "cICP", std::string("\x0C\x0D\0\x01", 4)));
  }
  const ExportSummary copied = Export(source, scratch / "copied", ExportForm::kColmapText, false);
  EXPECT_EQ(copied.copied, 6u);
  EXPECT_THAT(copied.doubts,
              testing::ElementsAre(testing::AllOf(HasSubstr("3 of 6 photographs"), HasSubstr("Display P3"),
                                                  testing::Not(HasSubstr("magick")))));
  EXPECT_THAT(Export(source, scratch / "drawn", ExportForm::kNerfSynthetic, false).doubts,
              testing::Not(testing::Contains(HasSubstr("Display P3"))))
      << "what is drawn anew is sRGB";
}

// Notes alone are doubts; ImageMagick's way is told where a profile says all, since it would only attach
// sRGB's to others.
TEST(Export, OnlyWhatOtherProgramsSeeOtherwiseIsDoubted) {
  const ScratchFolder scratch;
  CopiedColorEncodings meanings;
  StoredPicture first_of_two, turned;
  first_of_two.remarks = {"it holds 2 pictures, of which the first is taken"};
  meanings.Add(first_of_two);
  EXPECT_EQ(meanings.Doubt(1), "");
  test::WritePngSample(scratch / "profile.png", {.icc = test::IccProfile("P3")});
  test::WritePngSample(scratch / "gamma.png", {.gamma = 1});
  NoteOrientation(6, turned);
  meanings.Add(turned);
  meanings.Add(ReadPicture((scratch / "profile.png").string()));
  EXPECT_THAT(meanings.Doubt(3), testing::AllOf(HasSubstr("2 of 3"), HasSubstr("-profile sRGB.icc")));
  meanings.Add(ReadPicture((scratch / "gamma.png").string()));
  EXPECT_THAT(meanings.Doubt(4), testing::AllOf(HasSubstr("3 of 4"), testing::Not(HasSubstr("magick"))));
}

// Whatever words a note has.
TEST(Export, ANotesKindTellsWhetherAProgramConvertsIt) {
  CopiedColorEncodings meanings;
  StoredPicture tagged, other;
  tagged.notes = {{"it is tagged", " and changed", PictureNote::Kind::kTagged}};
  other.notes = {{"its mark says something", " of the profile"}};
  meanings.Add(tagged);
  EXPECT_THAT(meanings.Doubt(1), testing::AllOf(HasSubstr("(1: it is tagged)"), HasSubstr("magick")));
  meanings.Add(other);
  EXPECT_THAT(meanings.Doubt(2),
              testing::AllOf(HasSubstr("1: its mark says something)"), testing::Not(HasSubstr("magick"))));
}

TEST(Export, OnePhotographOfEachKindTellsWhatIsConverted) {
  const ScratchFolder scratch;
  const LightField source =
      TrackedLightField(scratch / "lf", {test::Straight(), test::Straight(), test::Straight()}, 3);
  for (const View& view : source.views)
    test::WritePngSample(source.root / view.image_path, {.icc = test::IccProfile("P3")});
  EXPECT_EQ(ConversionsOf(source).size(), 1u) << "a camera each";
}

TEST(Export, APhotographWithAWarningIsReadOnce) {
  const ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight()}, 2);
  const fs::path file = source.root / source.views[1].image_path;
  const auto times_opened = [&](const char* out) {
    const int watch = inotify_init1(IN_NONBLOCK);
    EXPECT_GE(inotify_add_watch(watch, file.c_str(), IN_OPEN | IN_CLOSE), 0);  // alike ones in a row are one
    EXPECT_EQ(Export(source, scratch / out, ExportForm::kColmapText, false).copied, 2u);
    inotify_event event{};
    int times = 0;
    while (read(watch, &event, sizeof event) == sizeof event) times += (event.mask & IN_OPEN) != 0;
    close(watch);
    return times;
  };
  const int without = times_opened("without");
  WriteFileAtomically(
      file, test::WithPngChunk(ReadWholeFile(file), "pHYs", std::string("\0\0\0\x04\0\0\0\x03\0", 9)));
  EXPECT_GT(without, 0);
  EXPECT_EQ(times_opened("with"), without);
}

TEST(Export, ReadersTakeWhatIsUndistorted) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", kEveryLens, 8, true);
  for (const ExportForm form : kForms) {
    const fs::path out = scratch / fmt::format("out{}", static_cast<int>(form));
    const ExportSummary summary = Export(source, out, form, true);
    EXPECT_EQ(summary.masks, 8u);
    if (form == ExportForm::kNerfstudio) {
      EXPECT_EQ(test::ReadAsNerfstudio(out), 8u);
      EXPECT_EQ(test::ReadAsInstantNgp(out), 8u);
      continue;
    }
    EXPECT_EQ(test::ReadAsInria(out), 8u);
    EXPECT_EQ(test::ReadAsSceneManager(out), 8u);
    EXPECT_EQ(test::ReadAsLichtFeld(out), 8u);
    EXPECT_EQ(test::ReadAsNerfstudioColmap(out), 8u);
    EXPECT_EQ(test::ReadAsColmap(out / "sparse/0").images.size(), 8u);
  }
}

// The rules bite: this is what those programs say of a set as it was recorded.
TEST(Export, ReadersRefuseWhatIsNotUndistorted) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Lens()});
  for (const ExportForm form : {ExportForm::kColmapText, ExportForm::kColmapBinary}) {
    const fs::path out = scratch / fmt::format("out{}", static_cast<int>(form));
    Export(source, out, form, false);
    EXPECT_THAT([&] { test::ReadAsInria(out); }, ThrowsMessage<std::runtime_error>(HasSubstr("undistorted")));
    EXPECT_EQ(test::ReadAsLichtFeld(out), 8u);
    EXPECT_EQ(test::ReadAsSceneManager(out), 8u);
    EXPECT_EQ(test::ReadAsNerfstudioColmap(out), 8u);
  }
  // An image without points, as the text was before.
  const fs::path images = scratch / "out0/sparse/0/images.txt";
  std::string text = ReadWholeFile(images);
  const std::size_t first = text.find("\n", text.find(".png")) + 1;
  text.erase(first, text.find("\n", first) - first);
  WriteFileAtomically(images, text);
  EXPECT_THAT([&] { test::ReadAsSceneManager(scratch / "out0"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("empty line")));
  // Sixth order is a model that nerfstudio does not know, unless it is undistorted.
  const LightField sixth = TrackedLightField(scratch / "sixth", {test::SixthOrder()});
  Export(sixth, scratch / "full", ExportForm::kColmapText, false);
  EXPECT_THAT([&] { test::ReadAsNerfstudioColmap(scratch / "full"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("FULL_OPENCV")));
  const LightField fisheye = TrackedLightField(scratch / "fisheye", {test::Fisheye()});
  Export(fisheye, scratch / "fisheye_out", ExportForm::kColmapText, false);
  EXPECT_THAT([&] { test::ReadAsNerfstudioColmap(scratch / "fisheye_out"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("K4")));
  const LightField mixed = TrackedLightField(scratch / "mixed", {test::Lens(), test::Fisheye()});
  EXPECT_THAT([&] { Export(mixed, scratch / "mixed_out", ExportForm::kNerfstudio, false); },
              ThrowsMessage<Refusal>(HasSubstr("give undistort")));
  EXPECT_FALSE(fs::exists(scratch / "mixed_out"));
}

TEST(Export, TheSmallestModelThatSaysTheSameIsNamed) {
  CameraModel lens = test::Lens();
  EXPECT_STREQ(ToColmapCamera(lens).name, "OPENCV");
  EXPECT_STREQ(ToColmapCamera(test::SixthOrder()).name, "FULL_OPENCV");
  lens.coefficients = {};
  EXPECT_STREQ(ToColmapCamera(lens).name, "PINHOLE");
  EXPECT_STREQ(ToColmapCamera(test::Straight()).name, "PINHOLE");
  EXPECT_STREQ(ToColmapCamera(test::Fisheye()).name, "OPENCV_FISHEYE");
}

TEST(Export, CopiesFilesThatNeedNoChange) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight(), test::Lens()});
  for (const ExportForm form : kForms)
    for (const bool undistort : {false, true}) {
      const fs::path out = scratch / fmt::format("out{}{}", undistort, static_cast<int>(form));
      const ExportSummary summary = Export(source, out, form, undistort);
      EXPECT_EQ(summary.copied, undistort ? 4u : 8u);
      EXPECT_EQ(summary.copied + summary.made, 8u);
      for (const View& view : source.views)
        if (!undistort || view.camera == 0) {
          EXPECT_EQ(ReadWholeFile(out / view.image_path), ReadWholeFile(source.root / view.image_path));
        }
    }
}

TEST(Export, NamesLoseWhatReadersStumbleOver) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", {test::Straight()});
  const auto rename = [&](std::size_t view, const std::string& name) {
    MakeFolder((scratch / "lf" / name).parent_path());
    fs::rename(scratch / "lf" / source.views[view].image_path, scratch / "lf" / name);
    source.views[view].image_path = name;
  };
  rename(0, "images/left/a b.png");
  rename(1, "images/left_a_b.png");
  rename(2, "elsewhere/two\nlines.png");
  Export(source, scratch / "out", ExportForm::kColmapText, false);
  EXPECT_EQ(test::ReadAsInria(scratch / "out"), 8u);
  EXPECT_TRUE(fs::exists(scratch / "out/images/left_a_b.png"));
  EXPECT_TRUE(fs::exists(scratch / "out/images/left_a_b-2.png"));
  EXPECT_TRUE(fs::exists(scratch / "out/images/elsewhere_two_lines.png"));
}

TEST(Export, NamesThatNoFolderTakesAreCut) {
  ScratchFolder scratch;
  LightField source = TrackedLightField(scratch / "lf", {test::Straight()});
  std::string folders = "images";
  for (const char letter : {'a', 'b', 'c', 'd', 'e'}) folders += "/" + std::string(60, letter);
  MakeFolder(scratch / "lf" / folders);
  for (const std::size_t view : {0, 1}) {
    const std::string name = folders + (view == 0 ? "/left.png" : "/right.png");
    fs::rename(scratch / "lf" / source.views[view].image_path, scratch / "lf" / name);
    source.views[view].image_path = name;
  }
  Export(source, scratch / "out", ExportForm::kColmapText, false);
  EXPECT_EQ(test::ReadAsInria(scratch / "out"), 8u);
}

// ---- Undistortion. ----

TEST(Undistortion, TheWindowIsCentredAndHasNoRim) {
  std::vector<CameraModel> cameras{test::Lens(), test::SixthOrder(), test::Fisheye()};
  CameraModel pincushion = test::Lens();
  pincushion.coefficients = {0.2, -0.05, 0, 0, 0};
  cameras.push_back(pincushion);
  CameraModel off = test::Straight();
  off.cx += 3.3;
  cameras.push_back(off);
  CameraModel upright{
      480, 960, 700, 705, 251.7, 466.2, Distortion::kRadialTangential, {0.05, -0.1, 0.001, 0, 0}};
  cameras.push_back(upright);
  for (const CameraModel& camera : cameras) {
    const Undistortion undistortion = UndistortionOf(camera, "a camera");
    const CameraModel& to = undistortion.to;
    EXPECT_FALSE(undistortion.is_identity);
    EXPECT_EQ(to.distortion, Distortion::kNone);
    EXPECT_EQ(2 * to.cx, to.width);
    EXPECT_EQ(2 * to.cy, to.height);
    EXPECT_EQ(to.fx, camera.fx);
    EXPECT_GT(undistortion.kept_share, undistortion.is_limited ? 0.3 : 0.7) << camera.cx;
    EXPECT_LE(undistortion.kept_share, 1);
    const UndistortionMap map = MapOf(undistortion);
    // All that is asked of the source is there.
    double low_x, high_x, low_y, high_y;
    cv::minMaxLoc(map.x, &low_x, &high_x);
    cv::minMaxLoc(map.y, &low_y, &high_y);
    EXPECT_GE(low_x, -1e-4);
    EXPECT_GE(low_y, -1e-4);
    EXPECT_LE(high_x, camera.width - 1 + 1e-4);
    EXPECT_LE(high_y, camera.height - 1 + 1e-4);
    // And it is as large as it can be: a pixel more in width or height asks for what is not there.
    const double reach = std::min({low_x, low_y, camera.width - 1 - high_x, camera.height - 1 - high_y});
    EXPECT_TRUE(reach < 1.5 || undistortion.is_limited) << reach;
    const cv::Mat white(camera.height, camera.width, CV_8UC3, cv::Scalar::all(255));
    double darkest;
    cv::minMaxLoc(Undistorted(map, white).reshape(1), &darkest);
    EXPECT_EQ(darkest, 255);
  }
}

TEST(Undistortion, PixelsGoWhereTheirRaysGo) {
  for (const CameraModel& camera : {test::Lens(), test::Fisheye()}) {
    // Brightness rises evenly: a pixel tells where it comes from.
    cv::Mat ramp(camera.height, camera.width, CV_32FC2);
    for (int v = 0; v < ramp.rows; ++v)
      for (int u = 0; u < ramp.cols; ++u) ramp.at<cv::Vec2f>(v, u) = {u + 0.5f, v + 0.5f};
    const Undistortion undistortion = UndistortionOf(camera, "a camera");
    const cv::Mat moved = Undistorted(MapOf(undistortion), ramp);
    for (int v = 5; v < moved.rows - 5; v += 5)
      for (int u = 5; u < moved.cols - 5; u += 5) {
        const Vector2d expected = *camera.ImgFromCam(*undistortion.to.RayFromImg({u + 0.5, v + 0.5}));
        // OpenCV looks for them in steps of a 32nd of a pixel.
        EXPECT_NEAR(moved.at<cv::Vec2f>(v, u)[0], expected.x(), 0.035);
        EXPECT_NEAR(moved.at<cv::Vec2f>(v, u)[1], expected.y(), 0.035);
      }
  }
}

TEST(Undistortion, MasksGoWithTheirPhotographs) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Lens(), test::Straight()}, 4, true);
  Export(source, scratch / "out", ExportForm::kNerfstudio, true);
  const Undistortion undistortion = UndistortionOf(test::Lens(), "a camera");
  for (const View& view : source.views) {
    const fs::path name = fs::path(view.image_path).filename();
    const cv::Mat mask = ReadImageFile((scratch / "out/masks" / (name.string() + ".png")).string());
    ASSERT_EQ(mask.type(), CV_8U);
    EXPECT_EQ(mask.size(), ReadImageFile((scratch / "out/images" / name).string()).size());
    if (view.mask_path.empty()) {
      EXPECT_EQ(cv::countNonZero(mask), static_cast<int>(mask.total()));
      continue;
    }
    const CameraModel& from = source.CameraOf(view);
    const CameraModel& to = view.camera == 0 ? undistortion.to : from;
    for (int v = 0; v < mask.rows; ++v)
      for (int u = 0; u < mask.cols; ++u) {
        const double x = from.ImgFromCam(*to.RayFromImg({u + 0.5, v + 0.5}))->x();
        if (std::abs(x - from.width / 2) < 1) continue;
        ASSERT_EQ(mask.at<std::uint8_t>(v, u), x > from.width / 2 ? 255 : 0) << u << " " << v;
      }
  }
}

TEST(Undistortion, AFisheyeBeyondAHalfSphereIsLimited) {
  // 190 degrees from edge to edge.
  const CameraModel wide{400, 400, 120.6, 120.6, 200, 200, Distortion::kFisheye, {}};
  const Undistortion undistortion = UndistortionOf(wide, "a camera");
  EXPECT_TRUE(undistortion.is_limited);
  EXPECT_LT(undistortion.to.MaxRayAngle(), 61 * M_PI / 180);
  EXPECT_GT(undistortion.to.MaxRayAngle(), 58 * M_PI / 180);
  CameraModel off = wide;
  off.cx = -20;
  EXPECT_THAT([&] { UndistortionOf(off, "camera 3"); },
              ThrowsMessage<Error>(testing::AllOf(HasSubstr("camera 3"), HasSubstr("without undistort"))));
}

// ---- All of it or nothing. ----

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Export, LeavesNothingWhereItFails) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Lens()});
  fs::resize_file(source.root / source.views[6].image_path, 300);
  MakeFolder(scratch / "out");
  EXPECT_THAT([&] { Export(source, scratch / "out", ExportForm::kColmapText, true); },
              ThrowsMessage<Error>(HasSubstr("000015.png")));
  EXPECT_TRUE(fs::is_empty(scratch / "out"));
  EXPECT_THAT(NamesIn(scratch.path()), testing::ElementsAre("lf", "out"));
  EXPECT_THAT([&] { ExportLightField(source, scratch / "out", {.stop = [] { return true; }}); },
              ThrowsMessage<Error>(HasSubstr("nothing was exported")));
  EXPECT_THAT(NamesIn(scratch.path()), testing::ElementsAre("lf", "out"));
}

TEST(Export, RefusesAFolderThatHoldsSomething) {
  ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight()});
  MakeFolder(scratch / "out/mine");
  EXPECT_THAT([&] { Export(source, scratch / "out", ExportForm::kColmapText, false); },
              ThrowsMessage<Error>(HasSubstr("not an empty folder")));
  std::ofstream(scratch / "out/mine/file") << "mine";
  EXPECT_THAT([&] { Export(source, scratch / "out/mine/file", ExportForm::kColmapText, false); },
              ThrowsMessage<Error>(HasSubstr("not an empty folder")));
  EXPECT_THAT([&] { Export(source, scratch / "lf/journal.jsonl", ExportForm::kColmapText, false); },
              ThrowsMessage<Error>(HasSubstr("lies in the light field")));
  // What a killed export left of this name goes with the next, what a living one writes stays.
  const std::string mark = ProcessMark(), computer = mark.substr(0, mark.find('-'));
  MakeFolder(scratch / fmt::format(".new.{}-999999999.part/images", computer));
  const std::string living = fmt::format(".new.{}-{}.part", computer, getppid());
  MakeFolder(scratch / living);
  Export(source, (scratch / "new").string() + "/", ExportForm::kColmapText, false);
  EXPECT_THAT(NamesIn(scratch.path()), testing::ElementsAre(living, "lf", "new", "out"));
}

TEST(Export, AFullDiskIsNamedAndNothingStays) {
  ScratchFolder scratch;
  if (const auto problem = test::MountSmallDisk(scratch.path(), 8 << 20)) GTEST_SKIP() << *problem;
  const LightField source = TrackedLightField(scratch / "lf", {test::Lens()});
  test::FillDisk(scratch / "ballast");
  fs::resize_file(scratch / "ballast", fs::file_size(scratch / "ballast") - (64 << 10));
  EXPECT_THROW(Export(source, scratch / "out", ExportForm::kColmapBinary, true), DiskFullError);
  EXPECT_THAT(NamesIn(scratch.path()), testing::ElementsAre("ballast", "lf"));
}

}  // namespace
}  // namespace ulf::export_test

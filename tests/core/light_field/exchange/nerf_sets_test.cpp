// Tests: core/light_field/formats/transforms_json, core/light_field/formats/frame_files,
// core/light_field/exchange/readers/nerf_synthetic_set,
// core/light_field/formats/posed_set, core/image/files/picture_file.
//
// Sets in transforms.json as trainers have them: NeRF's synthetic ones in three parts, and those
// whose photographs lie elsewhere, because the set comes from another computer or its photographs
// were made smaller.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::nerf_sets_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

json MatrixRows(const Eigen::Matrix4d& matrix) {
  json rows = json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  return rows;
}

class NerfSet : public testing::Test {
 protected:
  NerfSet() {
    for (const char* part : {"train", "test"}) {
      json frames = json::array();
      fs::create_directories(scratch_ / "set" / part);
      for (int i = 0; i < 3; ++i) {
        View view = ViewNumber(part == std::string("test") ? i + 3 : i);
        const Eigen::Matrix4d pose =
            view.cam_from_world.Inverse().Matrix() * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
        frames.push_back({{"file_path", fmt::format("./{}/r_{}", part, i)},
                          {"rotation", 0.01},
                          {"transform_matrix", MatrixRows(pose)}});
        cv::Mat picture(kHeight, kWidth, CV_8UC4, cv::Scalar(40, 80, 120, 255));
        picture.at<cv::Vec4b>(2, 3) = {200, 100, 0, 0};
        picture.at<cv::Vec4b>(2, 4) = {200, 100, 0, 51};
        cv::imwrite((scratch_ / "set" / part / fmt::format("r_{}.png", i)).string(), picture);
      }
      std::ofstream(scratch_ / "set" / fmt::format("transforms_{}.json", part))
          << JsonText(json{{"camera_angle_x", 0.7}, {"frames", frames}});
    }
  }
  ScratchFolder scratch_;
};

TEST_F(NerfSet, HasAllPartsOverWhite) {
  const Imported imported = Import(scratch_ / "set", scratch_ / "lf", {});
  const LightField& read = imported.light_field;
  ASSERT_EQ(read.views.size(), 6u);
  EXPECT_EQ(imported.format, "NeRF, synthetic");
  EXPECT_EQ(read.views[0].image_path, "images/train/r_0.png");
  EXPECT_EQ(read.views[5].image_path, "images/test/r_2.png");
  EXPECT_EQ(read.cameras.size(), 1u);
  EXPECT_NEAR(read.cameras[0].fx, 0.5 * kWidth / std::tan(0.35), 1e-9);
  EXPECT_LT((read.views[4].cam_from_world.Matrix() - ViewNumber(4).cam_from_world.Matrix()).norm(), 1e-9);
  const cv::Mat picture = ReadImageFile((scratch_ / "lf/images/test/r_2.png").string());
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(40, 80, 120));
  EXPECT_EQ(picture.at<cv::Vec3b>(2, 3), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(picture.at<cv::Vec3b>(2, 4), cv::Vec3b(244, 224, 204)) << "a fifth of the colour";
  EXPECT_FALSE(HasMask(read, read.views[0]));
}

TEST_F(NerfSet, TheBackgroundCanBeChosen) {
  const std::string import = "import " + (scratch_ / "set").string() + " -o " + (scratch_ / "lf").string();
  const auto run = test::RunUlf(import + " --background 10,20,30");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(ReadImageFile((scratch_ / "lf/images/train/r_0.png").string()).at<cv::Vec3b>(2, 3),
            cv::Vec3b(30, 20, 10));
  for (const char* bad : {"red", "1,2", "1,2,3,4", "256,0,0", "-1,0,0"})
    EXPECT_EQ(test::RunUlf(import + "2 --background " + bad).exit_code, 2) << bad;
}

TEST_F(NerfSet, WithoutAlphaIsNotLaidOverWhite) {
  const auto import = [&](const char* name) {
    const auto run = test::RunUlf("import " + (scratch_ / "set").string() + " --no-check -o " +
                                  (scratch_ / name).string());
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.errors;
  };
  EXPECT_THAT(import("with"), HasSubstr("6 pictures with alpha: laid over white"));
  // Opaque everywhere is as good as without.
  for (const int type : {CV_8UC4, CV_8UC3}) {
    for (const char* part : {"train", "test"})
      for (const auto& entry : fs::directory_iterator(scratch_ / "set" / part))
        cv::imwrite(entry.path().string(), cv::Mat(kHeight, kWidth, type, cv::Scalar(40, 80, 120, 255)));
    EXPECT_THAT(import(type == CV_8UC4 ? "opaque" : "without"), testing::Not(HasSubstr("alpha")));
  }
}

// Its photographs lie in another folder, where only the ends of their names lead.
TEST_F(NerfSet, IsFoundByTheEndsOfItsNames) {
  fs::create_directories(scratch_ / "elsewhere");
  for (const char* part : {"train", "test"})
    fs::rename(scratch_ / "set" / part, scratch_ / "elsewhere" / part);
  const PosedSet set = ReadPosedSet(scratch_ / "set", {}, scratch_ / "elsewhere");
  ASSERT_EQ(set.light_field.views.size(), 6u);
  EXPECT_EQ(set.light_field.views[5].image_path, "test/r_2.png");
  EXPECT_EQ(set.light_field.root, scratch_ / "elsewhere");
  // In the folder of one part the names of the other lead to the same photographs.
  EXPECT_THAT([&] { ReadPosedSet(scratch_ / "set", {}, scratch_ / "elsewhere/train"); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("'r_0.png', and so it is with 2 more"), HasSubstr("with images"))));
}

TEST(OverBackground, SixteenBitsStaySixteen) {
  const ScratchFolder scratch;
  cv::Mat picture(2, 2, CV_16UC4, cv::Scalar(1000, 2000, 3000, 65535));
  picture.at<cv::Vec<std::uint16_t, 4>>(0, 0)[3] = 0;
  cv::imwrite((scratch / "a.png").string(), picture);
  const cv::Mat over = ReadOverBackground((scratch / "a.png").string(), {1, 0, 0.5});
  ASSERT_EQ(over.type(), CV_16UC3);
  EXPECT_EQ((over.at<cv::Vec<std::uint16_t, 3>>(0, 0)), (cv::Vec<std::uint16_t, 3>(65535, 0, 32768)));
  EXPECT_EQ((over.at<cv::Vec<std::uint16_t, 3>>(1, 1)), (cv::Vec<std::uint16_t, 3>(1000, 2000, 3000)));
  cv::imwrite((scratch / "b.png").string(), cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_TRUE(ReadOverBackground((scratch / "b.png").string(), {1, 1, 1}).empty());
}

TEST_F(NerfSet, TakesTheTestSetOnceIfItValidates) {
  fs::copy(scratch_ / "set/transforms_test.json", scratch_ / "set/transforms_val.json");
  const LightField read = ReadPosedSet(scratch_ / "set", {}, {}).light_field;
  EXPECT_EQ(read.views.size(), 6u);
  EXPECT_THAT(read.doubts, Contains(HasSubstr("3 photographs named more than once")));
}

// ---- photographs elsewhere ----

// Three views, whose photographs lie in shots/ instead of where the frames say.
class SetNamedElsewhere : public testing::Test {
 protected:
  SetNamedElsewhere() {
    WriteSample(scratch_ / "set", 3);
    fs::remove(scratch_ / "set/journal.jsonl");
    written_ = ReadTransformsJson(file());
    document_ = JsonFromText(ReadWholeFile(file()));
    fs::rename(scratch_ / "set/images", scratch_ / "shots");
  }
  fs::path file() const { return scratch_ / "set/transforms.json"; }
  // `name` of each frame's photograph: "000001.png" in the set as it was.
  void NameFrames(const std::function<std::string(const std::string&)>& name) {
    for (std::size_t i = 0; i < 3; ++i)
      document_["frames"][i]["file_path"] = name(fs::path(written_.views[i].image_path).filename().string());
    std::ofstream(file()) << JsonText(document_);
  }
  LightField Read() { return ReadPosedSet(scratch_ / "set", {}, scratch_ / "shots").light_field; }
  void HalvePhotographs() const {
    for (const auto& entry : fs::directory_iterator(scratch_ / "shots")) {
      cv::Mat half;
      cv::resize(cv::imread(entry.path().string()), half, {kWidth / 2, kHeight / 2});
      cv::imwrite(entry.path().string(), half);
    }
  }

  ScratchFolder scratch_;
  LightField written_;
  json document_;
};

TEST_F(SetNamedElsewhere, IsFoundByName) {
  for (const char* folders : {"images/", "./images/", "../fox/images/", "/data/fox/images/",
                              "C:\\Users\\anna\\fox\\images\\", "images\\"}) {
    NameFrames([&](const std::string& name) { return folders + name; });
    EXPECT_THAT([&] { ReadPosedSet(scratch_ / "set", {}, {}); },
                ThrowsMessage<Error>(AllOf(HasSubstr("frame 0"), HasSubstr("--images FOLDER"))))
        << folders;
    const LightField read = Read();
    ASSERT_EQ(read.views.size(), 3u) << folders;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(read.views[i].image_path, fs::path(written_.views[i].image_path).filename()) << folders;
      EXPECT_EQ(read.views[i].cam_from_world.Matrix(), written_.views[i].cam_from_world.Matrix());
    }
    EXPECT_EQ(read.cameras, written_.cameras);
    EXPECT_EQ(read.points.size(), written_.points.size()) << "of the set's own folder";
  }
}

TEST_F(SetNamedElsewhere, IgnoresEndingAndCase) {
  for (const std::string ending : {".jpg", ".PNG", ""}) {
    NameFrames([&](const std::string& name) { return "images/" + fs::path(name).stem().string() + ending; });
    EXPECT_EQ(Read().views[2].image_path, fs::path(written_.views[2].image_path).filename()) << ending;
  }
  NameFrames([&](const std::string& name) { return "images/other_" + name; });
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("frame 0"), HasSubstr("and 2 more are missing"), HasSubstr("shots"))));
}

TEST_F(SetNamedElsewhere, IsFoundInFoldersWithinFolders) {
  fs::create_directories(scratch_ / "day1");
  fs::rename(scratch_ / "shots", scratch_ / "day1/left");
  fs::create_directories(scratch_ / "shots");
  fs::rename(scratch_ / "day1", scratch_ / "shots/day1");
  for (const std::string ending : {".png", ".jpg", ".PNG", ""}) {
    NameFrames([&](const std::string& name) {
      return "C:\\shoot\\day1\\left\\" + fs::path(name).stem().string() + ending;
    });
    EXPECT_EQ(Read().views[2].image_path,
              "day1/left/" + fs::path(written_.views[2].image_path).filename().string())
        << ending;
  }
}

TEST_F(SetNamedElsewhere, ADotInANameIsNoEnding) {
  const auto name_of = [](std::size_t i) {
    return fmt::format("r_{}", i == 0 ? "0.5" : i == 1 ? "0" : "0.25");
  };
  for (std::size_t i = 0; i < 3; ++i) {
    fs::rename(scratch_ / "shots" / fs::path(written_.views[i].image_path).filename(),
               scratch_ / "shots" / (name_of(i) + ".png"));
    document_["frames"][i]["file_path"] = "images/" + name_of(i);
  }
  std::ofstream(file()) << JsonText(document_);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(Read().views[i].image_path, name_of(i) + ".png");
  fs::remove(scratch_ / "shots/r_0.5.png");
  const LightField read = Read();
  EXPECT_EQ(read.views.size(), 2u) << "r_0 is another photograph";
  EXPECT_THAT(read.doubts, Contains(HasSubstr("'images/r_0.5'")));
}

// Without 'w' and 'h' it is in pixels of the photographs that were measured, whichever are read.
TEST_F(SetNamedElsewhere, FocalLengthIsOfTheSetsOwnPixels) {
  fs::copy(scratch_ / "shots", scratch_ / "set/images");
  HalvePhotographs();
  for (const char* side : {"w", "h"}) document_.erase(side);
  NameFrames([](const std::string& name) { return "images/" + name; });
  const CameraModel whole = written_.cameras[0];
  EXPECT_EQ(Read().cameras, std::vector{whole.ScaledTo(kWidth / 2, kHeight / 2)});
  fs::remove_all(scratch_ / "set/images");
  const LightField guessed = Read();
  EXPECT_EQ(guessed.cameras[0].fx, whole.fx);
  EXPECT_THAT(guessed.doubts,
              Contains(AllOf(HasSubstr("'fl_x' is in pixels"), HasSubstr("those of images"))));
}

TEST_F(SetNamedElsewhere, SmallerPhotographsScaleTheCamera) {
  HalvePhotographs();
  fs::rename(scratch_ / "shots", scratch_ / "set/images_2");
  const LightField read = ReadPosedSet(scratch_ / "set", {}, scratch_ / "set/images_2").light_field;
  ASSERT_EQ(read.views.size(), 3u);
  EXPECT_EQ(read.CameraOf(read.views[1]),
            written_.CameraOf(written_.views[1]).ScaledTo(kWidth / 2, kHeight / 2));
  EXPECT_EQ(read.cameras.size(), 1u);
  EXPECT_THAT(read.doubts, Contains(HasSubstr("resized")));
  const auto run = test::RunUlf("import " + (scratch_ / "set").string() + " --images images_2 -o " +
                                (scratch_ / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const LightField imported = ReadLightField(scratch_ / "lf");
  EXPECT_EQ(ReadViewImage(imported, imported.views[0]).pixels.cols, kWidth / 2);
}

TEST_F(SetNamedElsewhere, FindsMasksByPhotographsOrSet) {
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 8, 8)) = 0;
  fs::create_directories(scratch_ / "set/masks");
  for (std::size_t i = 0; i < 3; ++i) {
    cv::imwrite((scratch_ / "set/masks" / fmt::format("{}.png", i)).string(), mask);
    document_["frames"][i]["mask_path"] = fmt::format("masks/{}.png", i);
  }
  fs::create_directories(scratch_ / "masks");
  const std::string second = fs::path(written_.views[1].image_path).filename().string();
  cv::imwrite((scratch_ / "masks" / second).string(), mask);
  NameFrames([&](const std::string& name) { return "images/" + name; });
  const LightField read = Read();
  EXPECT_EQ(read.views[0].mask_path, "../set/masks/0.png");
  EXPECT_EQ(read.views[1].mask_path, "../masks/" + second);
  for (const View& view : read.views)
    EXPECT_EQ(cv::countNonZero(ReadViewMask(read, view)), kWidth * kHeight - 64);

  // Masks are made once, and photographs resized afterwards.
  HalvePhotographs();
  const auto run = test::RunUlf("import " + (scratch_ / "set").string() + " --images " +
                                (scratch_ / "shots").string() + " -o " + (scratch_ / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const LightField imported = ReadLightField(scratch_ / "lf");
  for (const View& view : imported.views)
    EXPECT_EQ(cv::countNonZero(ReadViewMask(imported, view)), kWidth * kHeight / 4 - 16);
  EXPECT_EQ(cv::imread((scratch_ / "lf" / imported.views[0].mask_path).string()).cols, kWidth / 2);
}

TEST_F(SetNamedElsewhere, PrefersMasksOfSmallerPhotographs) {
  HalvePhotographs();
  fs::rename(scratch_ / "shots", scratch_ / "set/images_2");
  for (const char* folder : {"masks", "masks_2"}) {
    fs::create_directories(scratch_ / "set" / folder);
    cv::imwrite((scratch_ / "set" / folder / "000001.png").string(),
                cv::Mat(kHeight / 2, kWidth / 2, CV_8UC1, cv::Scalar(255)));
  }
  NameFrames([](const std::string& name) { return "images/" + name; });
  EXPECT_EQ(ReadPosedSet(scratch_ / "set", {}, scratch_ / "set/images_2").light_field.views[0].mask_path,
            "../masks_2/000001.png");
}

TEST_F(SetNamedElsewhere, NamesOfWindowsAreFoundInTheSet) {
  fs::rename(scratch_ / "shots", scratch_ / "set/images");
  fs::create_directories(scratch_ / "set/sparse");
  fs::rename(scratch_ / "set/points.ply", scratch_ / "set/sparse/points.ply");
  document_["ply_file_path"] = "sparse\\points.ply";
  NameFrames([](const std::string& name) { return "images\\" + name; });
  const LightField read = ReadLightField(scratch_ / "set");
  EXPECT_EQ(read.views[1].image_path, written_.views[1].image_path);
  EXPECT_EQ(read.points.size(), written_.points.size());
}

TEST_F(SetNamedElsewhere, SmallerOnesInPlaceScaleTheCamera) {
  HalvePhotographs();
  fs::rename(scratch_ / "shots", scratch_ / "set/images");
  const LightField read = ReadPosedSet(scratch_ / "set", {}, {}).light_field;
  EXPECT_EQ(read.cameras, std::vector{written_.cameras[0].ScaledTo(kWidth / 2, kHeight / 2)});
  EXPECT_EQ(ReadLightField(scratch_ / "set").cameras, written_.cameras) << "a light field is what it says";
}

TEST_F(SetNamedElsewhere, AbsoluteNamesInTheSetAreItsOwn) {
  fs::rename(scratch_ / "shots", scratch_ / "set/images");
  NameFrames([&](const std::string& name) { return (scratch_ / "set/images" / name).string(); });
  EXPECT_EQ(ReadPosedSet(scratch_ / "set", {}, {}).light_field.views[1].image_path,
            written_.views[1].image_path);
}

TEST_F(SetNamedElsewhere, RefusesTwoPosesOfOnePhotograph) {
  fs::rename(scratch_ / "shots", scratch_ / "set/images");
  document_["frames"][2]["file_path"] = document_["frames"][0]["file_path"];
  std::ofstream(file()) << JsonText(document_);
  EXPECT_THAT([&] { ReadPosedSet(scratch_ / "set", {}, {}); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("two poses, number 1 and 3, lead to the photograph 'images/000001.png'"),
                        HasSubstr("take one of the poses out"))));
  document_["frames"][2]["transform_matrix"] = document_["frames"][0]["transform_matrix"];
  std::ofstream(file()) << JsonText(document_);
  const LightField read = ReadPosedSet(scratch_ / "set", {}, {}).light_field;
  EXPECT_EQ(read.views.size(), 2u);
  EXPECT_THAT(read.doubts, Contains(HasSubstr("1 photograph named more than once")));
}

// Coordinates of a survey: large numbers, and cameras a few metres apart.
TEST_F(SetNamedElsewhere, TwoPosesFarFromTheOriginDiffer) {
  fs::rename(scratch_ / "shots", scratch_ / "set/images");
  document_["frames"][2]["file_path"] = document_["frames"][0]["file_path"];
  for (auto& frame : document_["frames"])
    for (const std::size_t row : {0, 1}) {
      auto& coordinate = frame["transform_matrix"][row][3];
      coordinate = 5e6 + coordinate.get<double>();
    }
  std::ofstream(file()) << JsonText(document_);
  EXPECT_THAT([&] { ReadPosedSet(scratch_ / "set", {}, {}); },
              ThrowsMessage<Error>(HasSubstr("two poses, number 1 and 3, lead")));
}

// A set of poses alone, as another program has it: `change` of each matrix that the format would have. On a
// cap around the origin, or along a rail.
void WriteSetWith(const fs::path& set, bool around,
                  const std::function<Eigen::Matrix4d(const Eigen::Matrix4d&)>& change) {
  WriteSample(set, 9);
  fs::remove(set / "journal.jsonl");
  fs::remove(set / "points.ply");
  json document = JsonFromText(ReadWholeFile(set / "transforms.json"));
  for (const char* ours : {"ulf", "ply_file_path"}) document.erase(ours);
  for (int i = 0; i < 9; ++i) {
    const double turn = 0.2 * i, rise = 0.3 * (i % 3);
    const Rigid3 pose = around ? LookAt(4 * Eigen::Vector3d(std::cos(turn) * std::cos(rise),
                                                            std::sin(turn) * std::cos(rise), std::sin(rise)),
                                        {0, 0, 0}, {0, 0, 1})
                               : ViewNumber(i).cam_from_world;
    document["frames"][static_cast<std::size_t>(i)]["transform_matrix"] =
        MatrixRows(change(pose.Inverse().Matrix() * Eigen::Vector4d(1, -1, -1, 1).asDiagonal()));
  }
  std::ofstream(set / "transforms.json") << JsonText(document);
}

TEST(WrongAxes, InvertedPosesAreSaidToBe) {
  const ScratchFolder scratch;
  const Eigen::Matrix4d half_turn = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  WriteSetWith(scratch / "set", true, [](const Eigen::Matrix4d& matrix) { return matrix.inverse(); });
  WriteSetWith(scratch / "opencv", true,
               [&](const Eigen::Matrix4d& matrix) { return (matrix * half_turn).inverse(); });
  for (const char* set : {"set", "opencv"})
    EXPECT_THAT([&] { Import(scratch / set, scratch / "lf", {}); },
                ThrowsMessage<Refusal>(
                    AllOf(HasSubstr("those of the inverted poses do"), HasSubstr("subject x,y,z,radius"))))
        << set;
}

TEST(WrongAxes, CamerasThatLookAwayHaveOtherAxes) {
  const ScratchFolder scratch;
  const Eigen::Matrix4d half_turn = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  WriteSetWith(scratch / "set", false, [&](const Eigen::Matrix4d& matrix) { return matrix * half_turn; });
  EXPECT_THAT(
      [&] { Import(scratch / "set", scratch / "lf", {}); },
      ThrowsMessage<Refusal>(AllOf(HasSubstr("meet behind the cameras"), HasSubstr("y up and z back"))));
  const auto run = test::RunUlf("import " + (scratch / "set").string() +
                                " --no-check --subject 100,0,0,1 -o " + (scratch / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("no photograph shows the middle of the subject"));
}

TEST_F(SetNamedElsewhere, ALightFieldHoldsItsOwn) {
  WriteSample(scratch_ / "lf", 3);
  EXPECT_THAT([&] { ReadPosedSet(scratch_ / "lf", {}, scratch_ / "shots"); },
              ThrowsMessage<Refusal>(AllOf(HasSubstr("images: "), HasSubstr("leave the option out"))));
}

}  // namespace
}  // namespace ulf::nerf_sets_test

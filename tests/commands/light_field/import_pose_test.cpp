// Tests: commands/light_field/import_command, core/light_field/exchange/colmap_posing.
//
// Photographs in any order get poses through COLMAP: by Debian's, compared with the truth of a drawn room,
// and by a program in its place that writes down what it is asked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/aligned_centres.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"

namespace ulf::import_pose_test {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::RunUlf;
using test::TexturedRoom;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const CameraModel kCamera = CameraModel::Pinhole(240, 180, 210);

Rigid3 PoseAt(int i) {
  const double angle = 0.1 * i - 0.25;
  return LookAt({2.4 * std::sin(angle), 0.15 * std::sin(3.0 * i), 2.4 - 2.4 * std::cos(angle)},
                {0, 0.1 * std::cos(2.0 * i), 2.4}, -Eigen::Vector3d::UnitY());
}

// In another order than that of their places.
std::string NameAt(int i) { return fmt::format("shot {:02}.jpg", 5 * i % 13); }

void WriteJpeg(const fs::path& file, const cv::Mat& pixels, const std::string& exif = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", pixels, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  const std::string jpeg(bytes.begin(), bytes.end());
  WriteFileAtomically(file, jpeg.substr(0, 2) + exif + jpeg.substr(2));
}

cv::Mat SeenIn(unsigned room, int i) {
  return TexturedRoom({.seed = room}).Take(PoseAt(i), static_cast<std::uint64_t>(i), kCamera).image.pixels;
}

class ImportPose : public testing::Test {
 protected:
  ImportPose() { fs::create_directories(Set()); }
  fs::path Set() const { return scratch_ / "set"; }
  fs::path Out() const { return scratch_ / "out"; }
  CommandResult Import(const std::string& more = "--pose") const {
    return RunUlf(fmt::format("import {} -o {} {}", Set().string(), Out().string(), more));
  }
  // With nothing but this in PATH.
  CommandResult ImportBy(const fs::path& folder, const std::string& more = "") const {
    return test::RunProgram(fmt::format("PATH={} {}", folder.string(), std::getenv("ULF_BINARY")),
                            fmt::format("import {} -o {} --pose {}", Set().string(), Out().string(), more));
  }
  // A program in COLMAP's place, whose help knows these options. It notes what it is asked in asked.txt.
  fs::path Program(const std::string& script, const std::string& options) const {
    const fs::path folder = scratch_ / "programs";
    fs::create_directories(folder);
    std::ofstream(folder / "colmap")
        << "#!/bin/sh\nPATH=/usr/bin:/bin\nif [ \"$2\" = --help ]; then\n  for name in " << options
        << "; do echo \"  --$name arg (=1)\"; done\n  exit 0\nfi\nprintf '%s ' \"$@\" >>" << Asked().string()
        << "\necho >>" << Asked().string() << "\n"
        << script << "\n";
    fs::permissions(folder / "colmap", fs::perms::owner_all);
    return folder;
  }
  fs::path Asked() const { return scratch_ / "asked.txt"; }
  // Returns what is left beside the set, hidden or not.
  std::vector<std::string> Left() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(scratch_.path()))
      if (entry.path().filename().string().find("out") != std::string::npos)
        names.push_back(entry.path().filename().string());
    return names;
  }
  const test::ScratchFolder scratch_;
};

constexpr const char* kOptions =
    "database_path image_path image_list_path output_path ImageReader.single_camera "
    "ImageReader.camera_model ImageReader.camera_params SiftExtraction.use_gpu SiftMatching.use_gpu";

// Poses so many photographs of a room and some of other rooms, and compares with the truth.
class ImportPoseOfARoom : public ImportPose {
 protected:
  void ExpectPosesOf(int count, unsigned strangers) {
    ASSERT_EQ(std::system("command -v colmap >/dev/null"), 0) << "colmap is not installed: ./run deps";
    for (int i = 0; i < count; ++i) WriteJpeg(Set() / NameAt(i), SeenIn(4, i));
    for (unsigned i = 0; i < strangers; ++i)
      WriteJpeg(Set() / fmt::format("elsewhere {}.jpg", i), SeenIn(7 + i, 3));
    // A mask beside one of them changes no pose and comes along.
    cv::Mat mask(kCamera.height, kCamera.width, CV_8UC1, 255.0);
    mask(cv::Rect(0, 0, 60, kCamera.height)) = 0;
    fs::create_directories(Set() / "masks");
    cv::imwrite((Set() / "masks" / (NameAt(0) + ".png")).string(), mask);
    const CommandResult run = Import();
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, Not(HasSubstr("left out: 1 folder")));
    EXPECT_THAT(run.output, AllOf(HasSubstr(fmt::format("{} views (1 masked)", count)), HasSubstr("1 camera"),
                                  HasSubstr("fit the poses")));
    EXPECT_THAT(run.errors, HasSubstr(fmt::format("{} without a pose", Counted(strangers, "photograph"))));
    for (unsigned i = 0; i < strangers; ++i)
      EXPECT_THAT(run.errors, HasSubstr(fmt::format("elsewhere {}.jpg", i)));
    EXPECT_THAT(Left(), testing::ElementsAre("out"));
    ExpectTheTruth(count);
    // It is a set as any other.
    const CommandResult refined = RunUlf("refine " + Out().string());
    EXPECT_EQ(refined.exit_code, 0) << refined.errors;
    ExpectTheTruth(count);
  }
  void ExpectTheTruth(int count) const {
    const LightField light_field = ReadLightField(Out());
    std::vector<Rigid3> found, truth;
    for (int i = 0; i < count; ++i) {
      std::string name = "images/" + NameAt(i);
      std::ranges::replace(name, ' ', '_');
      const auto view = std::ranges::find(light_field.views, name, &View::image_path);
      ASSERT_NE(view, light_field.views.end()) << name;
      found.push_back(view->cam_from_world);
      truth.push_back(PoseAt(i));
      const Rigid3 one = found.back() * found[0].Inverse(), other = truth.back() * truth[0].Inverse();
      EXPECT_LT(RotationAngle(one.rotation * other.rotation.conjugate()), 0.01) << name;
    }
    EXPECT_NEAR(light_field.cameras[0].MeanFocalPx(), kCamera.fx, 0.03 * kCamera.fx);
    EXPECT_LT(test::AlignedCentreError(found, truth), 0.015) << "metres; a pixel is 11 mm wide there";
  }
};

TEST_F(ImportPoseOfARoom, IsRightInAnyOrder) { ExpectPosesOf(6, 1); }
TEST_F(ImportPoseOfARoom, IsRightForManyPhotographs) { ExpectPosesOf(12, 2); }

TEST_F(ImportPose, FindsNoneForUnrelatedPhotographs) {
  for (int i = 0; i < 3; ++i)
    WriteJpeg(Set() / fmt::format("{}.jpg", i), SeenIn(20 + static_cast<unsigned>(i), 3));
  const CommandResult run = Import();
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("finds no poses for the 3 photographs"),
                                HasSubstr("neighbours must show mostly the same"), HasSubstr("stay in")));
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(ImportPose, SaysWhatToInstall) {
  fs::create_directories(scratch_ / "programs");
  const CommandResult run = ImportBy(scratch_ / "programs");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("COLMAP"), HasSubstr("apt install colmap")));
  EXPECT_THAT(Left(), testing::IsEmpty());
}

TEST_F(ImportPose, KeepsItsFolderWhenColmapFails) {
  for (int i = 0; i < 3; ++i) WriteJpeg(Set() / fmt::format("{}.jpg", i), cv::Mat(24, 32, CV_8UC1, 90.0));
  const fs::path failing =
      Program("for i in 1 2 3 4 5 6; do echo \"line $i\"; done; echo; echo '=====' >&2; exit 5", kOptions);
  const CommandResult run = ImportBy(failing);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("feature_extractor failed (exit status 5)"),
                                HasSubstr("line 3 / line 4 / line 5 / line 6;"), Not(HasSubstr("line 2"))));
  const std::string said = "its files stay in ";
  const std::size_t at = run.errors.find(said) + said.size();
  const fs::path kept = run.errors.substr(at, run.errors.find_first_of("\n", at) - at);
  EXPECT_THAT(ReadWholeFile(kept / "colmap.log"),
              AllOf(HasSubstr("feature_extractor --"), HasSubstr("line 1")));
  EXPECT_FALSE(fs::exists(Out()));
  Program("kill -9 $$", kOptions);
  EXPECT_THAT(ImportBy(failing).errors, HasSubstr("feature_extractor failed (killed"));
  EXPECT_FALSE(fs::exists(kept)) << "the next run removes it";
  EXPECT_EQ(Left().size(), 1u);
}

// Exif of a camera's model and the focal length for 36 x 24 mm.
std::string Exif(const std::string& model, char focal_mm) {
  using namespace std::string_literals;
  std::string name = model;
  name.resize(8, '\0');
  const std::string tiff = "II*\0\x08\0\0\0"s + "\x02\0"s +                       // IFD 0, two entries
                           "\x10\x01\x02\0\x08\0\0\0\x26\0\0\0"s +                // the model, at 38
                           "\x69\x87\x04\0\x01\0\0\0\x2E\0\0\0"s + "\0\0\0\0"s +  // Exif IFD, at 46
                           name + "\x01\0\x05\xA4\x03\0\x01\0\0\0"s + focal_mm + "\0\0\0"s + "\0\0\0\0"s;
  const auto length = static_cast<char>(2 + 6 + tiff.size());
  return "\xFF\xE1\0"s + length + "Exif\0\0"s + tiff;
}

TEST_F(ImportPose, GivesOneCameraToEachLens) {
  const cv::Mat wide(24, 32, CV_8UC1, 90.0), high(32, 24, CV_8UC1, 90.0);
  WriteJpeg(Set() / "a.jpg", wide, Exif("Phone", 27));
  WriteJpeg(Set() / "b.jpg", wide, Exif("Phone", 54));
  WriteJpeg(Set() / "c.jpg", wide, Exif("Phone", 27));
  WriteJpeg(Set() / "d.jpg", wide, Exif("Other", 27));
  WriteJpeg(Set() / "e.jpg", high, Exif("Phone", 27));
  WriteJpeg(Set() / "f.jpg", wide);
  const fs::path programs =
      Program("while [ $# -gt 0 ]; do [ \"$1\" != --image_list_path ] || cat \"$2\" >>" + Asked().string() +
                  "; shift; done",
              kOptions);
  const CommandResult run = ImportBy(programs);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("5 cameras"), HasSubstr("finds no poses for the 6 photographs")));
  const std::string asked = ReadWholeFile(Asked());
  // 27 and 54 mm on a diagonal of 43.27 mm, 40 pixels.
  const auto lens = [&](const std::string& focal, const std::string& middle, const std::string& names) {
    const std::string params = focal.empty() ? "--SiftExtraction.use_gpu 0 "
                                             : "--ImageReader.camera_params " + focal + "," + middle + ",0 ";
    EXPECT_THAT(asked, HasSubstr(params + "\n" + names)) << asked;
  };
  lens("24.962", "16,12", "000001/a.jpg\n000003/c.jpg\n");
  lens("49.923", "16,12", "000002/b.jpg\n");
  lens("24.962", "16,12", "000004/d.jpg\n");
  lens("24.962", "12,16", "000005/e.jpg\n");
  lens("", "", "000006/f.jpg\n");
  EXPECT_THAT(asked, AllOf(HasSubstr("--SiftExtraction.use_gpu 0"), HasSubstr("--SiftMatching.use_gpu 0"),
                           HasSubstr("exhaustive_matcher"), Not(HasSubstr("sequential_matcher"))));
}

// Masks of every kind that lies beside photographs, and alpha, as the program in COLMAP's place gets them.
TEST_F(ImportPose, TakesNoFeaturesWhereMasksAre) {
  for (int i = 0; i < 3; ++i) {
    WriteJpeg(Set() / fmt::format("{}.jpg", i), cv::Mat(24, 32, CV_8UC1, 90.0));
    cv::Mat mask(24, 32, CV_8UC1, 255.0);
    mask(cv::Rect(i, 0, 1, 24)) = 0;
    if (i == 0) cv::imwrite((Set() / "0.jpg.mask.png").string(), mask);
    if (i == 1) cv::imwrite((Set() / "dynamic_mask_1.png").string(), 255 - mask);
  }
  cv::Mat transparent(24, 32, CV_8UC4, cv::Scalar(90, 90, 90, 255));
  transparent(cv::Rect(5, 0, 1, 24)) = cv::Scalar::all(0);
  cv::imwrite((Set() / "3.png").string(), transparent);
  const fs::path kept = scratch_ / "kept";
  const fs::path programs =
      Program("while [ $# -gt 0 ]; do [ \"$1\" != --ImageReader.mask_path ] || cp -r \"$2\" " +
                  kept.string() + "; shift; done",
              std::string(kOptions) + " ImageReader.mask_path");
  const CommandResult run = ImportBy(programs);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("poses 4 photographs"), HasSubstr("what masks do not exclude")));
  for (const auto& [name, column] : std::map<std::string, int>{
           {"000001/0.jpg", 0}, {"000002/1.jpg", 1}, {"000003/2.jpg", -1}, {"000004/3.png", 5}}) {
    const cv::Mat mask = cv::imread((kept / (name + ".png")).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(mask.size(), cv::Size(32, 24)) << name;
    for (int x = 0; x < 32; ++x) EXPECT_EQ(mask.at<std::uint8_t>(7, x), x == column ? 0 : 255) << name;
  }
  // Without any there is nothing to be said.
  for (const char* name : {"0.jpg.mask.png", "dynamic_mask_1.png", "3.png"}) fs::remove(Set() / name);
  fs::remove(Asked());
  ImportBy(programs);
  EXPECT_THAT(ReadWholeFile(Asked()), Not(HasSubstr("mask_path")));
}

TEST_F(ImportPose, ComparesManyAlongTheirOrder) {
  for (int i = 0; i < 151; ++i) WriteJpeg(Set() / fmt::format("{}.jpg", i), cv::Mat(8, 8, CV_8UC1, 90.0));
  // As COLMAP 4 names its options.
  const CommandResult run = ImportBy(
      Program("", "database_path image_path output_path FeatureExtraction.use_gpu FeatureMatching.use_gpu"));
  EXPECT_THAT(run.errors, HasSubstr("sequential_matcher, transitive_matcher"));
  EXPECT_THAT(ReadWholeFile(Asked()),
              AllOf(HasSubstr("sequential_matcher --database_path"), HasSubstr("transitive_matcher"),
                    HasSubstr("--FeatureExtraction.use_gpu 0"), HasSubstr("--FeatureMatching.use_gpu 0"),
                    Not(HasSubstr("exhaustive_matcher")), Not(HasSubstr("Sift"))));
}

// A program in COLMAP's place whose mapper finds these models of photographs of the room.
class ImportPoseOfModels : public ImportPose {
 protected:
  CommandResult ImportModels(int photographs, const std::vector<std::vector<int>>& models,
                             const std::string& more = "") {
    for (int i = 0; i < photographs; ++i) WriteJpeg(Set() / fmt::format("{}.jpg", i), SeenIn(4, i));
    const fs::path made = scratch_ / "models";
    for (std::size_t k = 0; k < models.size(); ++k) {
      const fs::path model = made / std::to_string(k);
      fs::create_directories(model);
      std::ofstream(model / "cameras.txt") << "1 PINHOLE 240 180 210 210 120 90\n";
      std::ofstream(model / "points3D.txt");
      std::ofstream images(model / "images.txt");
      for (const int i : models[k]) {
        const Rigid3 pose = PoseAt(i);
        const Eigen::Quaterniond& q = pose.rotation;
        const Eigen::Vector3d& t = pose.translation;
        images << fmt::format("{} {} {} {} {} {} {} {} 1 {:06}/{}.jpg\n\n", i + 1, q.w(), q.x(), q.y(), q.z(),
                              t.x(), t.y(), t.z(), i + 1, i);
      }
    }
    return ImportBy(Program("[ \"$1\" != mapper ] || cp -r " + made.string() +
                                "/* \"$(echo $@ | sed 's/.*--output_path \\([^ ]*\\).*/\\1/')\"",
                            kOptions),
                    more);
  }
};

TEST_F(ImportPoseOfModels, FailWhereMostHaveNoPose) {
  const CommandResult run = ImportModels(5, {{2}, {0, 4}}, "--no-check");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("could not join all photographs: 2 have poses in one world"),
                                HasSubstr("groups of 1"), HasSubstr("only 2 of 5 photographs have a pose")));
  EXPECT_EQ(ReadLightField(Out()).views.size(), 2u);
  EXPECT_THAT(Left(), testing::ElementsAre("out"));
}

TEST_F(ImportPoseOfModels, MayBeWithoutASubject) {
  const CommandResult run = ImportModels(3, {{0, 1}});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("2 views"), HasSubstr("no subject")));
  EXPECT_FALSE(ReadLightField(Out()).subject);
}

TEST_F(ImportPose, EndsColmapWhenInterrupted) {
  for (int i = 0; i < 3; ++i) WriteJpeg(Set() / fmt::format("{}.jpg", i), cv::Mat(24, 32, CV_8UC1, 90.0));
  const fs::path process = scratch_ / "process";
  const fs::path programs = Program("echo $$ >" + process.string() + "; exec sleep 100", kOptions);
  test::ChildProcess ulf({"/usr/bin/env", "PATH=" + programs.string(), std::getenv("ULF_BINARY"), "import",
                          Set().string(), "-o", Out().string(), "--pose"});
  std::string number;
  for (int i = 0; i < 400 && number.empty(); ++i) {
    std::ifstream(process) >> number;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_FALSE(number.empty());
  ulf.Signal(SIGINT);
  EXPECT_EQ(ulf.Wait(20), 1);
  EXPECT_NE(kill(std::stoi(number), 0), 0) << "COLMAP still runs";
  EXPECT_THAT(Left(), testing::IsEmpty());
}

TEST_F(ImportPose, RefusesOptionsAboutPosesThatAreThere) {
  for (const std::string option :
       {"--format colmap", "--images .", "--calibration /dev/null", "--subject 0,0,1,1"}) {
    const CommandResult run = Import("--pose " + option);
    EXPECT_EQ(run.exit_code, 2) << option;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("--pose and " + option.substr(0, option.find(' '))),
                                  HasSubstr("leave out one of the two")));
  }
}

TEST_F(ImportPose, NamesWhatCannotBePosed) {
  fs::create_directories(Set() / "images");
  WriteJpeg(Set() / "images/1.jpg", cv::Mat(24, 32, CV_8UC1, 90.0));
  EXPECT_THAT(Import().errors, HasSubstr("1 folder inside holds pictures (images)"));
  WriteJpeg(Set() / "1.jpg", cv::Mat(24, 32, CV_8UC1, 90.0));
  EXPECT_THAT(Import().errors, HasSubstr("holds 1 photograph,"));
  EXPECT_THAT(Import("").errors, HasSubstr("ulf import " + Set().string() + " --pose -o DIR"));
  fs::create_directories(Out() / "mine");
  for (const char* how : {"--pose", ""})
    EXPECT_THAT(Import(how).errors, HasSubstr("exists already and is not an empty folder")) << how;
  EXPECT_THAT(Left(), testing::ElementsAre("out"));
}

TEST_F(ImportPose, AnEmptyFolderIsNamedAsByOtherCommands) {
  const std::string folder = Set().string(), out = " -o " + Out().string();
  for (const std::string& command : {"import " + folder + " --pose" + out, "import " + folder + out,
                                     "capture replay:" + folder + " --headless --no-subject" + out,
                                     "calibrate " + folder + out + ".json"}) {
    const CommandResult run = RunUlf(command);
    EXPECT_EQ(run.exit_code, 1) << command;
    EXPECT_THAT(run.errors,
                HasSubstr(folder + ": the folder is empty; give the one that holds the photographs"))
        << command;
  }
  WriteFileAtomically(Set() / "notes.md", "none");
  EXPECT_THAT(Import().errors, HasSubstr("contains no images, only 1 other file; give the one"));
}

}  // namespace
}  // namespace ulf::import_pose_test

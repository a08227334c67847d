#include "acquisition/calibration/lens_files/lens_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <sstream>
#include <string_view>
#include <vector>

#include "acquisition/calibration/lens_files/lens_tree.h"
#include "acquisition/calibration/lens_files/matrix_files.h"
#include "acquisition/calibration/lens_files/program_files.h"
#include "acquisition/calibration/lens_files/set_files.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// Returns whether damaged text has words of a lens file: else it is of something else, which no message
// should tell to mend.
bool HasLensWords(const std::string& text) {
  for (const char* word :
       {"intrinsic", "matrix", "ameraMatrix", "istortion", "resolution", "K:", "\"K\"", "fx", "<f>", "fl_x",
        "camera_angle", "projection", "amera_model", "mage_width", "opencv"})
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// Throws Error for a message of ROS (CameraInfo) that ends before its camera matrix does.
void RefuseCutMessage(const LensNode& top, const std::string& where) {
  if (!top.Has("distortion_model") || !top.Has("height")) return;
  const char* key = top.Has("K") ? "K" : "k";
  const LensNode* matrix = top.Find(key);
  throw Error("{}: '{}' has {} of 9 values: the file may be cut; write it again", where, key,
              matrix ? std::ranges::count_if(matrix->items, &LensNode::IsText) : 0);
}

// Does as LensTreesOf(), but returns none, too, for damaged text without words of a lens file.
std::optional<std::vector<LensNode>> TreesOfLensText(const std::string& text, const std::string& where) {
  try {
    return LensTreesOf(text, where);
  } catch (const Error&) {
    if (HasLensWords(text)) throw;
    return std::nullopt;
  }
}

// Files of programs whose lenses ulf does not read are recognised, so that a refusal names the program and
// the way out instead of a fault that is none.
struct OtherText {
  const char* mark;  // in the text
  const char* what;
};

constexpr const char* kAsOpenCv =
    "write its numbers as an OpenCV file (image_width, image_height, camera_matrix, distortion_coefficients)";

constexpr const char* kOfSet =
    "of RealityScan (RealityCapture), in millimetres of film; ulf import takes its export with the "
    "photographs. For the lens alone, calibrate with ulf calibrate";

constexpr std::array kOtherTexts = {
    OtherText{"LENSMODEL_",
              "a camera model of mrcal; convert it to LENSMODEL_OPENCV5 (mrcal-convert-lensmodel) and {}"},
    OtherText{"stCamera:",
              "an Adobe lens profile (LCP), which does not tell pixels; calibrate with ulf calibrate"},
    OtherText{"#polynomial coefficients for the DIRECT mapping",
              "a calibration of Scaramuzza's OCamCalib, a lens model that ulf does not have; calibrate again "
              "with a fisheye of four coefficients (ulf calibrate, Kalibr's pinhole-equi)"},
    OtherText{"ParGroup: Cam",
              "a camera of HALCON, whose lens model (division or polynomial, in metres) ulf does not "
              "have; calibrate with ulf calibrate or OpenCV"},
    OtherText{
        "sensor_msgs.msg.CameraInfo(",
        "a message of ROS as Python prints it; write it by ros2 topic echo --once TOPIC > camera_info.yaml"},
    OtherText{"Intrinsic of \"", "a report of RealSense cameras (rs-enumerate-devices); {}"},
    OtherText{"Camera-system parameters",
              "Kalibr's report in words; give its camchain YAML file (camchain-*.yaml)"},
    OtherText{"[LEFT_CAM_", "a settings file of a ZED camera; {}"},
    OtherText{"xcr:DistortionModel", kOfSet},
    OtherText{"#name,x,y,alt", kOfSet},
    OtherText{"NVM_V3", "a set of VisualSFM; import it to COLMAP, and give the cameras.txt of that"},
    OtherText{"# Bundle file v", "a set of Bundler, whose lenses have no size; {}"},
    OtherText{"<lensdatabase", "lensfun's, which does not tell pixels; calibrate with ulf calibrate"},
    OtherText{"calibu_", "a camera of Calibu; {}"},
    OtherText{"<CalibrationInternConique",
              "a camera of MicMac, whose distortion is about a centre of its own; {}"},
    OtherText{"<BlocksExchange",
              "a set in Bentley's BlocksExchange form; export it to COLMAP, and give its cameras.txt"},
    OtherText{"VICON_RADIAL", "a calibration of Vicon's cameras; {}"},
    OtherText{"centerPointU", "a calibration of Qualisys's cameras, in parts of a pixel; {}"},
    OtherText{"# hugin project file",
              "a project of Hugin, which does not tell pixels; calibrate with ulf calibrate"},
    OtherText{"Pix4D camera", "a camera of Pix4D, in millimetres; {}"},
    OtherText{
        "fc = [",
        "a result of the calibration toolbox for MATLAB (Calib_Results.m); {}, with cc less 0 and kc as "
        "it is: both count pixels from 0"},
};

bool BeginsWithBytes(const std::string& text, std::string_view bytes) {
  return text.compare(0, bytes.size(), bytes) == 0;
}

bool HasAny(const LensNode& map, std::initializer_list<std::string_view> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return map.Has(key); });
}

// Returns whether the map or anything in its values has the key.
bool HasBelow(const LensNode& top, std::string_view key) {
  return top.Has(key) || std::ranges::any_of(top.items, [key](const LensNode& item) {
           return item.Has(key) || (item.IsList() && !item.items.empty() && item.items.front().Has(key));
         });
}

// Returns the key of numbers named a fisheye's, at the top or one level below; empty if there is none.
std::string KeyOfFisheyeNumbers(const LensNode& map, int levels) {
  for (std::size_t i = 0; i < map.items.size(); ++i) {
    const LensNode& value = map.items[i];
    const bool is_numbers = value.IsMap() || (value.IsList() && LensNumbersIn(value)) ||
                            (value.IsText() && LensNumbersIn(value) && LensNumbersIn(value)->size() > 1);
    if (map.IsMap() && is_numbers && LensWord(map.keys[i]).find("fisheye") != std::string::npos)
      return map.keys[i];
    const std::string inner = levels > 0 ? KeyOfFisheyeNumbers(value, levels - 1) : "";
    if (!inner.empty()) return inner;
  }
  return "";
}

bool IsKittiLens(const LensNode& top) {
  for (const char* key : {"P0", "P1", "P2", "P3", "P_rect_00", "P_rect_02"})
    if (const LensNode* matrix = top.Find(key)) {
      const auto numbers = LensNumbersIn(*matrix);
      if (numbers && numbers->size() == 12) return true;
    }
  return false;
}

// Camera files of DSO and LSD-SLAM without a word: five numbers in parts of the picture, two sides, what to
// do with the rest, two sides.
bool IsDsoFov(const std::string& text) {
  std::istringstream lines(text);
  std::string line, word;
  double number = 0;
  std::vector<int> counts;
  for (int i = 0; i < 2 && std::getline(lines, line); ++i) {
    std::istringstream words(line);
    counts.push_back(0);
    while (words >> number) ++counts.back();
    if (!words.eof()) return false;
  }
  return counts == std::vector{5, 2} && lines >> word &&
         (word == "crop" || word == "full" || word == "none" ||
          std::isdigit(static_cast<unsigned char>(word[0])));
}

// Returns what the file is and what to do, as the end of a sentence that begins with the file's name: "is
// ...; ...". Returns none when it is unknown. The first looks at the text before it is parsed, which may not
// be possible.
std::optional<std::string> OtherLensText(const std::string& text) {
  using namespace std::string_view_literals;
  if (BeginsWithBytes(text, "\x1f\x8b"sv))
    return "is packed by gzip; unpack it first (of ROS's calibrationdata.tar.gz, give ost.yaml)";
  for (const auto picture :
       {"\x89PNG"sv, "\xff\xd8\xff"sv, "II*\0"sv, "MM\0*"sv, "BM"sv, "RIFF"sv, "v/1\x01"sv})
    if (BeginsWithBytes(text, picture) && text.find('\0') != std::string::npos)
      return "is a picture or a video, and no lens; pictures of a board make one: ulf calibrate FOLDER";
  if (BeginsWithBytes(text, "\x93NUMPY"sv) || BeginsWithBytes(text, "PK\x03\x04"sv))
    return fmt::format("is an archive (of NumPy, or zip); {}", kAsOpenCv);
  if (BeginsWithBytes(text, "MATLAB 5.0"sv))
    return fmt::format("is a MATLAB file; write the camera with cameraIntrinsicsToOpenCV and {}", kAsOpenCv);
  if (BeginsWithBytes(text, "\xff\xfe"sv) || BeginsWithBytes(text, "\xfe\xff"sv))
    return "is text of 16 bits a letter, as PowerShell writes it; save it as UTF-8";
  constexpr std::size_t kBeginning = 4096;
  if (text.substr(0, kBeginning).find('\0') != std::string::npos)
    return "is no text (of COLMAP's binary models, write text: colmap model_converter --output_type TXT)";
  for (const OtherText& other : kOtherTexts)
    if (text.find(other.mark) != std::string::npos)
      return "is " + fmt::format(fmt::runtime(other.what), kAsOpenCv);
  const std::string first = text.substr(0, text.find_first_of(" \t\r\n"));
  for (const char* model : {"RadTan", "FOV", "EquiDistant", "KannalaBrandt", "Pinhole"})
    if (first == model) return fmt::format("is a camera of DSO; {}", kAsOpenCv);
  if (IsDsoFov(text))
    return fmt::format("is a camera of DSO or LSD-SLAM with the field-of-view model, {}; {}",
                       "which ulf does not have",
                       "calibrate again with ulf calibrate, or Kalibr's pinhole-radtan");
  return std::nullopt;
}

std::optional<std::string> OtherLensTree(const LensNode& top) {
  if (HasBelow(top, "RadialDistortion") || HasBelow(top, "IntrinsicMatrix") ||
      (HasBelow(top, "FocalLength") && HasBelow(top, "PrincipalPoint")))
    return fmt::format(
        "is a camera of MATLAB, which counts pixels from 1; convert it with cameraIntrinsicsToOpenCV and {}",
        kAsOpenCv);
  if (HasBelow(top, "CameraIntrinsicsPrior") || top.Has("priors"))
    return fmt::format("is a calibration of Theia; {}", kAsOpenCv);
  if (top.Has("sfm_data_version"))
    return "is a scene of OpenMVG; export it to COLMAP (openMVG_main_openMVG2Colmap), and give its "
           "cameras.txt";
  if ((top.Has("views") || HasBelow(top, "distortionParams")) && top.Has("intrinsics"))
    return "is a scene of AliceVision (Meshroom); export it to COLMAP (ExportColmap), and give its "
           "cameras.txt";
  if (HasBelow(top, "projection_type"))
    return "is of OpenSfM, in parts of the picture's longer side; export it to COLMAP (bin/export_colmap), "
           "and give its cameras.txt";
  if (top.Has("CalibrationInformation"))
    return fmt::format(
        "is a calibration of Azure Kinect, in parts of the picture and with a rational lens model; {}",
        "calibrate with ulf calibrate");
  if (top.Has("cameraData")) return fmt::format("is a calibration of DepthAI (OAK cameras); {}", kAsOpenCv);
  if (HasBelow(top, "pixel_aspect") && HasBelow(top, "focal_length"))
    return fmt::format("is a view of MVE, in parts of the picture's longer side; {}", kAsOpenCv);
  if (HasCameraMatrix(top)) return std::nullopt;
  if (top.Has("target_type"))
    return "is a calibration target of Kalibr and no lens; give its camchain YAML file";
  if (HasAny(top, {"accelerometer_noise_density", "gyroscope_noise_density"}))
    return "is an inertial sensor's calibration and no lens; give the camera's file";
  if (HasAny(top, {"cam0_calib", "cam1_calib"}))
    return "is the configuration of VINS; give the camera's file that it names (cam0_calib)";
  if (HasBelow(top, "Calibrate_Pattern"))
    return "is the settings of OpenCV's calibration program; give what it wrote (Write_outputFileName)";
  if (top.Has("Q") || (HasAny(top, {"R1", "P1"}) && HasAny(top, {"R2", "P2"})))
    return "is a stereo pair's rectification (OpenCV's extrinsics.yml) and no lens; give intrinsics.yml";
  if (top.FindPath({"document", "chunk"}))
    return "is Metashape's cameras (Export Cameras); ulf import takes them with their photographs. For the "
           "lens alone, save it by Tools > Camera Calibration";
  if (IsKittiLens(top))
    return fmt::format(
        "is KITTI's calib.txt, projections of rectified pictures without their size; {}: the first three "
        "columns of the camera's P are the camera matrix, and all coefficients are 0",
        kAsOpenCv);
  if (const std::string key = KeyOfFisheyeNumbers(top, 1); !key.empty())
    return fmt::format(
        "holds a fisheye's numbers under '{}', whose order and pixels no program that ulf knows defines; {}, "
        "with k1 k2 k3 k4 as coefficients, and the line distortion_model: equidistant",
        key, kAsOpenCv);
  return std::nullopt;
}

}  // namespace

std::optional<ReadLens> ReadLensText(const std::string& text, const std::string& where,
                                     const std::string& camera) {
  const auto refuse = [&](const std::string& what) {
    throw Error("{}: {}. {}", where, what, ReadableLensFiles());
  };
  // It checks the numbers of readers that do not check them by themselves.
  const auto checked = [&](Lens lens, const char* program) {
    CheckLensNumbers(lens, where);
    return ReadLens{lens, program};
  };
  if (const auto other = OtherLensText(text)) refuse(*other);
  if (IsColmapCameras(text)) return checked(ReadColmapLens(text, where, camera), "COLMAP");
  const auto trees = TreesOfLensText(text, where);
  if (!trees || trees->empty()) return std::nullopt;
  const LensNode& top = trees->front();
  if (IsTransformsLens(top)) return checked(ReadTransformsLens(text, where, camera), "nerfstudio");
  for (const LensProgram& program : LensPrograms())
    if (program.is(top)) return ReadLens{program.read(top, where, camera), program.name};
  if (const auto other = OtherLensTree(top)) refuse(*other);
  if (std::ranges::any_of(*trees,
                          [](const LensNode& tree) { return HasCameraMatrix(WithCameraMatrices(tree)); })) {
    // JSON and XML close what they open.
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool is_section =
        text[first] == '[' && std::isalpha(static_cast<unsigned char>(text[first + 1])) != 0;
    const bool may_be_cut = is_section || std::string_view("{[<").find(text[first]) == std::string_view::npos;
    return ReadLens{ReadMatrixLens(*trees, where, camera, may_be_cut), IsRosLens(top) ? "ROS" : "OpenCV"};
  }
  RefuseCutMessage(top, where);
  constexpr std::size_t kMostKeys = 6;
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < std::min(kMostKeys, top.keys.size()); ++i)
    keys.push_back("'" + top.keys[i].substr(0, 40) + "'");
  if (top.keys.size() > kMostKeys) keys.emplace_back("...");
  refuse(fmt::format("holds no lens that ulf knows: neither a camera matrix nor fx, fy, cx and cy{}",
                     keys.empty() ? "" : fmt::format(" (its keys are {})", fmt::join(keys, ", "))));
  return std::nullopt;
}

std::string ReadableLensFiles() {
  return fmt::format("Lenses of {} are read (docs/calibration.md)", fmt::join(ReadableLensPrograms(), ", "));
}

std::vector<std::string> ReadableLensPrograms() {
  std::vector<std::string> names{"ulf", "COLMAP", "nerfstudio"};
  for (const LensProgram& program : LensPrograms()) names.emplace_back(program.name);
  names.insert(names.end(), {"ROS", "OpenCV"});
  return names;
}

}  // namespace ulf::acquisition

#include "acquisition/calibration/lens_files/program_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_words.h"
#include "acquisition/calibration/lens_files/matrix_files.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// Returns the wanted camera of a file that numbers them from 0.
std::size_t NumberOfLens(std::size_t count, const std::string& wanted, const std::string& where) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(std::to_string(i));
  return std::stoul(PickLens(names, wanted, where));
}

// Returns the numbers behind these keys; 0 for those that are not there, unless all must be.
std::vector<double> NumbersBehind(const LensNode& map, std::initializer_list<const char*> keys,
                                  const std::string& where, bool all_required) {
  std::vector<double> numbers;
  for (const char* key : keys)
    numbers.push_back(all_required || map.Has(key) ? RequiredLensNumber(map, key, where) : 0);
  return numbers;
}

void SetPinhole(LensNumbers& numbers, const std::vector<double>& fx_fy_cx_cy) {
  numbers.fx = fx_fy_cx_cy[0];
  numbers.fy = fx_fy_cx_cy[1];
  numbers.cx = fx_fy_cx_cy[2];
  numbers.cy = fx_fy_cx_cy[3];
}

// Reads a camera of Kalibr or EuRoC: lists of four intrinsics, of coefficients, and of width and height.
Lens LensOfLists(const LensNode& camera, const std::string& where) {
  LensNumbers numbers{.size_keys = "resolution: [W, H]"};
  // The model comes before the numbers, because other models have other counts.
  numbers.named = NamedLensModelOf(camera, where);
  if (!numbers.named) RequiredLensNode(camera, "distortion_model", where);
  const auto intrinsics = RequiredLensNumbers(camera, "intrinsics", where);
  if (intrinsics.size() != 4)
    throw Error("{}: a pinhole has 4 intrinsics, not {}; correct the file or calibrate again", where,
                intrinsics.size());
  SetPinhole(numbers, intrinsics);
  ReadLensSize({&camera}, "", numbers, where);
  for (const char* key : {"distortion_coeffs", "distortion_coefficients"})
    if (camera.Has(key)) numbers.coefficients = RequiredLensNumbers(camera, key, where);
  const bool needs_coefficients = !numbers.named || numbers.named->model != LensModel::kNone;
  if (needs_coefficients && numbers.coefficients.empty())
    throw Error("{}: the distortion coefficients are missing; write the file again", where);
  return FinishedLens(numbers, where);
}

bool IsLensOfLists(const LensNode& node) {
  return node.Has("intrinsics") && !LooksLikeLensMatrix(*node.Find("intrinsics")) &&
         (node.Has("camera_model") || node.Has("distortion_model") || node.Has("distortion_coeffs"));
}

bool IsMaplabCamera(const LensNode& node) {
  const LensNode* intrinsics = node.Find("intrinsics");
  const LensNode* distortion = node.Find("distortion");
  if (!intrinsics || !intrinsics->IsMap() || !intrinsics->Has("data")) return false;
  const auto numbers = LensNumbersIn(*intrinsics->Find("data"));
  constexpr std::size_t kOfMatrix = 9;  // a camera matrix is of another program
  return numbers && numbers->size() != kOfMatrix &&
         ((distortion && distortion->IsMap() && distortion->Has("type")) ||
          (node.Has("type") && node.Has("line-delay-nanoseconds")));
}

// Returns the cameras of a rig, each below its pose, or the only one; empty if the file is of something else.
std::vector<const LensNode*> MaplabCameras(const LensNode& top) {
  if (IsMaplabCamera(top)) return {&top};
  std::vector<const LensNode*> cameras;
  const LensNode* rig = top.Find("cameras");
  for (const LensNode* list : {rig, &top}) {
    if (!list || !cameras.empty()) continue;
    for (const LensNode& item : list->items) {
      const LensNode* camera = item.Find("camera");
      if (!camera) camera = &item;
      if (IsMaplabCamera(*camera)) cameras.push_back(camera);
    }
  }
  return cameras;
}

// Returns a column of numbers: rows, cols and data.
std::vector<double> MaplabColumn(const LensNode& map, std::string_view key, const std::string& where) {
  const LensMatrix column = LensMatrixOf(RequiredLensNode(map, key, where), key, where);
  if (std::min(column.rows, column.cols) > 1)
    throw Error("{}: '{}' has {} x {} values; one column belongs there", where, key, column.rows,
                column.cols);
  return column.numbers;
}

// Gyroflow's lens profile holds OpenCV's fisheye, unless its distortion_model says otherwise; camera_model
// names the camera.
bool IsGyroflowLens(const LensNode& top) {
  const LensNode* parameters = top.Find("fisheye_params");
  return parameters && parameters->Has("camera_matrix") && parameters->Has("distortion_coeffs");
}

Lens ReadGyroflowLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  RequireOnlyLens(wanted, where);
  const LensNode& parameters = *top.Find("fisheye_params");
  LensNumbers numbers{.size_keys = "\"calib_dimension\": {\"w\": W, \"h\": H}"};
  const LensNode* word = top.Find("distortion_model");
  numbers.named = word ? LensModelOfWord(word->text, "distortion_model: " + word->text, where) : std::nullopt;
  if (!numbers.named) numbers.named = NamedLensModel{LensModel::kFisheye, "fisheye_params"};
  // What the camera or an adapter does to the picture besides, which no lens model describes.
  for (const char* key : {"digital_lens", "input_horizontal_stretch", "input_vertical_stretch"})
    if (const LensNode* more = top.Find(key); more && !more->text.empty()) {
      const auto factor = LensNumber(*more);
      if (!factor || (*factor != 1 && *factor != 0))
        throw Error(
            "{}: '{}: {}' of Gyroflow changes the picture besides the lens, which ulf does not have; "
            "calibrate with ulf calibrate, from pictures as they come",
            where, key, more->text.substr(0, 40));
    }
  SetCameraMatrix(numbers,
                  LensMatrixOf(RequiredLensNode(parameters, "camera_matrix", where), "camera_matrix", where),
                  "camera_matrix", where);
  ReadLensSize({&top}, "", numbers, where);
  numbers.coefficients = RequiredLensNumbers(parameters, "distortion_coeffs", where);
  return FinishedLens(numbers, where);
}

// okvis and okvis2 describe cameras by lists for focal length, principal point and size.
bool IsOkvisLens(const LensNode& top) {
  const LensNode* cameras = top.Find("cameras");
  return cameras && cameras->IsList() && std::ranges::any_of(cameras->items, [](const LensNode& camera) {
           return camera.Has("focal_length") && camera.Has("principal_point") &&
                  camera.Has("distortion_type");
         });
}

Lens ReadOkvisLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  LensNode cameras{.kind = LensNode::Kind::kMap};
  for (const LensNode& camera : top.Find("cameras")->items)
    cameras.Add(std::to_string(cameras.keys.size()), camera);
  return ReadMatrixLens({cameras}, where, wanted);
}

bool IsKalibrLens(const LensNode& top) {
  return top.IsMap() && std::ranges::any_of(top.items, IsLensOfLists);
}

Lens ReadKalibrLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  std::vector<std::string> names, topics;
  for (std::size_t i = 0; i < top.keys.size(); ++i)
    if (IsLensOfLists(top.items[i])) {
      names.push_back(top.keys[i]);
      const LensNode* topic = top.items[i].Find("rostopic");
      topics.push_back(topic ? topic->text : "");
    }
  const std::string name = PickLens(names, wanted, where, topics), place = where + ", " + name;
  return LensOfLists(*top.Find(name), place);
}

// EuRoC's sensor.yaml describes one camera as Kalibr does, at the top level.
bool IsEurocLens(const LensNode& top) { return IsLensOfLists(top); }

Lens ReadEurocLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  RequireOnlyLens(wanted, where);
  return LensOfLists(top, where);
}

// maplab and aslam_cv2 describe a camera, or the cameras of a rig: intrinsics of four numbers as a matrix,
// distortion with a type and parameters. Their "fisheye" is the field-of-view model.
bool IsMaplabLens(const LensNode& top) { return !MaplabCameras(top).empty(); }

Lens ReadMaplabLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  const auto cameras = MaplabCameras(top);
  if (cameras.size() == 1 && cameras[0] == &top) RequireOnlyLens(wanted, where);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensNode* label = cameras[i]->Find("label");
    const bool is_name = label && label->IsText() && !LensWord(label->text).empty() &&
                         std::ranges::find(names, label->text) == names.end();
    names.push_back(is_name ? label->text : std::to_string(i));
  }
  const std::string name = PickLens(names, wanted, where);
  const LensNode& camera = *cameras[static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())];
  const std::string place = cameras.size() == 1 ? where : where + ", camera " + name;
  const auto word_of = [&](const LensNode& map) {
    const LensNode* type = map.Find("type");
    return type && type->IsText() ? type->text : std::string();
  };
  const std::string projection = word_of(camera);
  if (const std::string word = LensWord(projection); !word.empty() && word != "pinhole")
    throw Error("{}: the camera type '{}' of maplab is not one of ulf's; {}", place, projection, kLensWayOut);
  LensNumbers numbers;
  const LensNode* distortion = camera.Find("distortion");
  if (!distortion)
    throw Error(
        "{}: 'distortion' is missing: the file may be cut. Write it again; if the lens has no distortion, "
        "add distortion: {{type: none}}",
        place);
  const std::string type = word_of(*distortion), word = LensWord(type);
  const std::string named = "distortion type: " + type;
  if (word == "equidistant")
    numbers.named = NamedLensModel{LensModel::kFisheye, named};
  else if (word == "radialtangential" || word == "radtan")
    numbers.named = NamedLensModel{LensModel::kRadialTangential, named};
  else if (word == "none")
    numbers.named = NamedLensModel{LensModel::kNone, named};
  else
    throw Error("{}: the distortion '{}' of maplab{} is not one of ulf's; {}", place, type,
                word == "fisheye" ? ", the field-of-view model," : "", kLensWayOut);
  const auto intrinsics = MaplabColumn(camera, "intrinsics", place);
  if (intrinsics.size() != 4)
    throw Error("{}: a pinhole has 4 intrinsics, not {}; correct the file or calibrate again", place,
                intrinsics.size());
  SetPinhole(numbers, intrinsics);
  if (word != "none" || distortion->Has("parameters"))
    numbers.coefficients = MaplabColumn(*distortion, "parameters", place);
  if (word != "none" && numbers.coefficients.empty())
    throw Error("{}: the distortion's parameters are missing; write the file again", place);
  if (camera.Has("image_width")) numbers.width = RequiredLensNumber(camera, "image_width", place);
  if (camera.Has("image_height")) numbers.height = RequiredLensNumber(camera, "image_height", place);
  return FinishedLens(numbers, place);
}

// ORB-SLAM2 and 3 and stella_vslam have settings such as Camera.fx or Camera1.fx.
bool IsOrbSlamLens(const LensNode& top) {
  for (const char* key : {"Camera.fx", "Camera1.fx", "Camera.type", "Camera.model"})
    if (top.Has(key)) return true;
  return top.FindPath({"Camera", "fx"}) != nullptr;
}

Lens ReadOrbSlamLens(const LensNode& settings, const std::string& where, const std::string& wanted) {
  // stella_vslam has a map of its own where ORB-SLAM has names with a dot.
  LensNode top = settings;
  if (const LensNode* nested = settings.Find("Camera"))
    for (std::size_t i = 0; i < nested->keys.size(); ++i)
      top.Add("Camera." + nested->keys[i], nested->items[i]);
  std::vector<std::string> names;
  for (const char* name : {"Camera", "Camera1", "Camera2"})
    if (top.Has(std::string(name) + ".fx")) names.push_back(name);
  // ORB-SLAM2 for stereo pairs: Camera is what remains after rectifying, LEFT and RIGHT are the lenses.
  for (const char* name : {"LEFT", "RIGHT"})
    if (top.Has(std::string(name) + ".K")) names.push_back(name);
  const std::string name = PickLens(names, wanted, where);
  if (name == "LEFT" || name == "RIGHT") return ReadMatrixLens({top}, where, name);
  const std::string place = where + ", " + name;
  LensNumbers numbers{.size_keys = "Camera.width: W and Camera.height: H"};
  LensNode words{.kind = LensNode::Kind::kMap};
  for (const char* key : {"Camera.type", "Camera.model"})
    if (const LensNode* word = top.Find(key))
      words.Add(words.keys.empty() ? "cameramodel" : "modeltype", *word);
  const std::string type = words.items.empty() ? "PinHole" : words.items[0].text;
  numbers.named = NamedLensModelOf(words, where);
  // PinHole is a word for k1 k2 p1 p2 here; what stands elsewhere counts where there is no word.
  if (words.items.empty()) {
    LensNode part{.kind = LensNode::Kind::kMap};
    for (std::size_t i = 0; i < settings.keys.size(); ++i)
      if (settings.keys[i].starts_with("Camera")) part.Add(settings.keys[i], settings.items[i]);
    CheckLensMentions(part, numbers.named, "Camera.type: \"KannalaBrandt8\", or Camera.type: \"PinHole\"",
                      place, numbers.warnings);
  }
  const auto number = [&](const char* key, bool required) {
    const std::string full = name + "." + key;
    return required || top.Has(full) ? RequiredLensNumber(top, full, where) : 0.0;
  };
  SetPinhole(numbers, {number("fx", true), number("fy", true), number("cx", true), number("cy", true)});
  const bool is_fisheye = numbers.IsFisheye();
  if (is_fisheye) {
    numbers.coefficients = {number("k1", true), number("k2", true), number("k3", true), number("k4", true)};
    for (const char* key : {"p1", "p2"})
      if (number(key, false) != 0)
        throw Error("{}: '{}.{}' does not belong to a fisheye ({}); {}", place, name, key, type, kLensWayOut);
  } else {
    if (number("k4", false) != 0)
      throw Error(
          "{}: '{}.k4' belongs to a fisheye, but the model is {}; write Camera.type: KannalaBrandt8, or "
          "leave out k4",
          place, name, type);
    // All four keys or none must be there, as the programs themselves require.
    const bool any = std::ranges::any_of(std::array{"k1", "k2", "p1", "p2"},
                                         [&](const char* key) { return top.Has(name + "." + key); });
    numbers.coefficients = {number("k1", any), number("k2", any), number("p1", any), number("p2", any),
                            number("k3", false)};
    if (!any && !numbers.named) numbers.warnings.push_back(WarningOfNoCoefficients(place));
    if (!numbers.named) numbers.named = NamedLensModel{LensModel::kRadialTangential, "Camera.type: " + type};
  }
  for (const auto& [key, side] : {std::pair{"width", &numbers.width}, std::pair{"height", &numbers.height},
                                  std::pair{"cols", &numbers.width}, std::pair{"rows", &numbers.height}})
    for (const std::string& owner : {name, std::string("Camera")})
      if (*side == 0 && top.Has(owner + "." + key)) *side = RequiredLensNumber(top, owner + "." + key, where);
  return FinishedLens(numbers, place);
}

// VINS-Mono, VINS-Fusion and camodocal share a format.
bool IsVinsLens(const LensNode& top) {
  for (const char* key : {"projection_parameters", "mirror_parameters", "poly_parameters"})
    if (top.Has(key)) return true;
  return top.Has("model_type") && !HasCameraMatrix(top);
}

Lens ReadVinsLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  RequireOnlyLens(wanted, where);
  LensNumbers numbers;
  const LensNode& type = RequiredLensNode(top, "model_type", where);
  const std::string word = LensWord(type.text), named = "model_type: " + type.text;
  numbers.named = LensModelOfWord(type.text, named, where);
  if (top.Has("image_width")) numbers.width = RequiredLensNumber(top, "image_width", where);
  if (top.Has("image_height")) numbers.height = RequiredLensNumber(top, "image_height", where);
  const LensNode& projection = RequiredLensNode(top, "projection_parameters", where);
  const LensNode nothing{.kind = LensNode::Kind::kMap};
  const LensNode* found = top.Find("distortion_parameters");
  const bool has_distortion = found && found->IsMap();
  const LensNode& distortion = has_distortion ? *found : nothing;
  if (numbers.IsFisheye()) {
    SetPinhole(numbers, NumbersBehind(projection, {"mu", "mv", "u0", "v0"}, where, true));
    // VINS has them in the projection, converters write them into the distortion.
    const LensNode& coefficients = projection.Has("k2") ? projection : distortion;
    numbers.coefficients = NumbersBehind(coefficients, {"k2", "k3", "k4", "k5"}, where, true);
    if (projection.Has("k2") && distortion.Has("k2") &&
        NumbersBehind(distortion, {"k2", "k3", "k4", "k5"}, where, true) != numbers.coefficients)
      throw Error(
          "{}: k2 k3 k4 k5 of projection_parameters and distortion_parameters differ; delete the wrong ones",
          where);
    return FinishedLens(numbers, where);
  }
  SetPinhole(numbers, NumbersBehind(projection, {"fx", "fy", "cx", "cy"}, where, true));
  if (!has_distortion)
    throw Error(
        "{}: 'distortion_parameters' are missing: the file may be cut. Write it again; if the lens has no "
        "distortion, add them with k1, k2, p1 and p2 of 0",
        where);
  numbers.coefficients = NumbersBehind(distortion, {"k1", "k2", "p1", "p2"}, where, true);
  if (word == "pinholefull")
    for (const double more : NumbersBehind(distortion, {"k3", "k4", "k5", "k6"}, where, false))
      numbers.coefficients.push_back(more);
  if (!numbers.named) numbers.named = NamedLensModel{LensModel::kRadialTangential, named};
  return FinishedLens(numbers, where);
}

bool IsBasaltLens(const LensNode& top) { return top.FindPath({"value0", "intrinsics"}) != nullptr; }

Lens ReadBasaltLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  const LensNode& cameras = *top.FindPath({"value0", "intrinsics"});
  const LensNode* sizes = top.FindPath({"value0", "resolution"});
  const std::size_t count = cameras.items.size();
  if (sizes && sizes->items.size() != count)
    throw Error("{}: {} cameras, but {} sizes ('resolution'); write the file again", where, count,
                sizes->items.size());
  const std::size_t at = NumberOfLens(count, wanted, where);
  const std::string place = fmt::format("{}, camera {}", where, at);
  LensNumbers numbers{.size_keys = "resolution: [[W, H]]"};
  const LensNode& type = RequiredLensNode(cameras.items[at], "camera_type", place);
  const LensNode& values = RequiredLensNode(cameras.items[at], "intrinsics", place);
  const std::string word = LensWord(type.text), named = "camera_type: " + type.text;
  numbers.named = LensModelOfWord(type.text, named, place);
  SetPinhole(numbers, NumbersBehind(values, {"fx", "fy", "cx", "cy"}, place, true));
  if (numbers.IsFisheye())
    numbers.coefficients = NumbersBehind(values, {"k1", "k2", "k3", "k4"}, place, true);
  else if (numbers.named)
    numbers.coefficients =
        NumbersBehind(values, {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}, place, true);
  else
    numbers.named = NamedLensModel{LensModel::kNone, named};
  if (sizes) {
    const auto size = LensNumbersIn(sizes->items[at]);
    if (!size || size->size() != 2)
      throw Error("{}: 'resolution' must be width and height, two numbers", place);
    numbers.width = (*size)[0];
    numbers.height = (*size)[1];
  }
  return FinishedLens(numbers, place);
}

bool IsCalibIoLens(const LensNode& top) { return top.FindPath({"Calibration", "cameras"}) != nullptr; }

Lens ReadCalibIoLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  const LensNode& cameras = *top.FindPath({"Calibration", "cameras"});
  const std::size_t at = NumberOfLens(cameras.items.size(), wanted, where);
  const std::string place = fmt::format("{}, camera {}", where, at);
  // The kind's name stands with the first camera of the kind, whose number has the topmost bit; others have
  // the number.
  std::string kind;
  const auto number_of = [](const LensNode& camera) {
    const LensNode* id = camera.FindPath({"model", "polymorphic_id"});
    return id ? std::fmod(LensNumber(*id).value_or(0), 2147483648.0) : 0;
  };
  for (const LensNode& camera : cameras.items)
    if (const LensNode* name = camera.FindPath({"model", "polymorphic_name"});
        name && number_of(camera) == number_of(cameras.items[at]))
      kind = name->text;
  if (kind != "libCalib::CameraModelOpenCV")
    throw Error(
        "{}: the lens model '{}' is not one of ulf's; export the calibration with the OpenCV model, or: {}",
        place, kind.empty() ? "unknown" : kind, kLensWayOut);
  const LensNode* data = cameras.items[at].FindPath({"model", "ptr_wrapper", "data"});
  if (!data) throw Error("{}: the camera's data ('ptr_wrapper') is missing; write the file again", place);
  const LensNode& parameters = RequiredLensNode(*data, "parameters", place);
  const auto value = [&](const char* key, bool required) {
    if (!required && !parameters.Has(key)) return 0.0;
    return RequiredLensNumber(RequiredLensNode(parameters, key, place), "val", place + ", " + key);
  };
  LensNumbers numbers{.size_keys = "imageSize"};
  const double f = value("f", true), ratio = value("ar", true);
  SetPinhole(numbers, {f, f * ratio, value("cx", true), value("cy", true)});
  numbers.named = NamedLensModel{LensModel::kRational, kind};
  for (const char* key :
       {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tauX", "tauY"})
    numbers.coefficients.push_back(value(key, false));
  if (const LensNode* size = data->FindPath({"CameraModelCRT", "CameraModelBase", "imageSize"})) {
    numbers.width = RequiredLensNumber(*size, "width", place);
    numbers.height = RequiredLensNumber(*size, "height", place);
  }
  return FinishedLens(numbers, place);
}

bool IsMetashapeLens(const LensNode& top) {
  const LensNode* calibration = top.Find("calibration");
  return calibration && (calibration->Has("projection") || calibration->Has("f") || calibration->Has("fx"));
}

Lens ReadMetashapeLens(const LensNode& top, const std::string& where, const std::string& wanted) {
  RequireOnlyLens(wanted, where);
  const LensNode& calibration = *top.Find("calibration");
  if (!calibration.Has("f") && calibration.Has("fx"))
    throw Error(
        "{}: is of an older PhotoScan (fx and no f); open the project in Metashape and save the calibration "
        "again",
        where);
  LensNumbers numbers{.from_corner = true, .size_keys = "<width> and <height>"};
  const LensNode* projection = calibration.Find("projection");
  const std::string type = projection ? projection->text : "frame", named = "projection: " + type;
  numbers.named = LensModelOfWord(type, named, where);
  const auto value = [&](const char* key) {
    return calibration.Has(key) ? RequiredLensNumber(calibration, key, where) : 0.0;
  };
  const bool is_fisheye = numbers.IsFisheye();
  const auto refuse = [&](std::initializer_list<const char*> keys) {
    for (const char* key : keys)
      if (value(key) != 0)
        throw Error(
            "{}: {} is {}, which ulf does not have for '{}'; optimise the cameras without it (Tools > "
            "Optimize Cameras), and save the calibration again",
            where, key, value(key), type);
  };
  refuse({"b2", "p3", "p4"});
  if (is_fisheye)
    refuse({"p1", "p2"});
  else
    refuse({"k4"});
  numbers.width = RequiredLensNumber(calibration, "width", where);
  numbers.height = RequiredLensNumber(calibration, "height", where);
  const double f = RequiredLensNumber(calibration, "f", where);
  SetPinhole(numbers,
             {f + value("b1"), f, 0.5 * numbers.width + value("cx"), 0.5 * numbers.height + value("cy")});
  if (is_fisheye)
    numbers.coefficients = {value("k1"), value("k2"), value("k3"), value("k4")};
  else
    numbers.coefficients = {value("k1"), value("k2"), value("p2"), value("p1"), value("k3")};
  if (!numbers.named) numbers.named = NamedLensModel{LensModel::kRadialTangential, named};
  return FinishedLens(numbers, where);
}

constexpr std::array kLensPrograms = {
    LensProgram{"Gyroflow", IsGyroflowLens, ReadGyroflowLens},
    LensProgram{"Basalt", IsBasaltLens, ReadBasaltLens},
    LensProgram{"calib.io", IsCalibIoLens, ReadCalibIoLens},
    LensProgram{"Metashape", IsMetashapeLens, ReadMetashapeLens},
    LensProgram{"maplab", IsMaplabLens, ReadMaplabLens},
    LensProgram{"Kalibr", IsKalibrLens, ReadKalibrLens},
    LensProgram{"EuRoC", IsEurocLens, ReadEurocLens},
    LensProgram{"okvis", IsOkvisLens, ReadOkvisLens},
    LensProgram{"ORB-SLAM", IsOrbSlamLens, ReadOrbSlamLens},
    LensProgram{"VINS", IsVinsLens, ReadVinsLens},
};

}  // namespace

std::span<const LensProgram> LensPrograms() { return kLensPrograms; }

}  // namespace ulf::acquisition

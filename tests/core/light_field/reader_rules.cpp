#include "tests/core/light_field/reader_rules.h"
#include "core/base/json_text.h"
#include "tests/support/floors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

namespace ulf::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

[[noreturn]] void Refuse(const std::string& why) { throw std::runtime_error(why); }
void Require(bool holds, const std::string& otherwise) {
  if (!holds) Refuse(otherwise);
}

std::vector<std::string> Lines(const fs::path& path) {
  std::ifstream file(path);
  Require(file.good(), path.string() + ": is not there");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// As Python's split() has it, which also parts at white space beyond ASCII.
std::vector<std::string> Words(std::string line) {
  for (const std::string_view space : {"\u0085", "\u00a0", "\u1680", "\u2002", "\u2003", "\u2009", "\u2028",
                                       "\u2029", "\u202f", "\u205f", "\u3000"})
    for (std::size_t at; (at = line.find(space)) != std::string::npos;) line.replace(at, space.size(), " ");
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

// At every single space, as a split by one character does.
std::vector<std::string> SplitAtSpaces(const std::string& line) {
  std::vector<std::string> parts{""};
  for (const char c : line) {
    if (c == ' ')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

double Real(const std::string& word) {
  std::size_t used = 0;
  const double number = std::stod(word, &used);
  Require(used == word.size() && std::isfinite(number), word + ": is no number");
  return number;
}

long Whole(const std::string& word) {
  std::size_t used = 0;
  const long number = std::stol(word, &used);
  Require(used == word.size(), word + ": is no whole number");
  return number;
}

const std::map<std::string, std::size_t>& ParametersOf() {
  static const std::map<std::string, std::size_t> counts{
      {"SIMPLE_PINHOLE", 3}, {"PINHOLE", 4},        {"SIMPLE_RADIAL", 4}, {"RADIAL", 5},
      {"OPENCV", 8},         {"OPENCV_FISHEYE", 8}, {"FULL_OPENCV", 12}};
  return counts;
}

constexpr const char* kByNumber[] = {"SIMPLE_PINHOLE", "PINHOLE",        "SIMPLE_RADIAL", "RADIAL",
                                     "OPENCV",         "OPENCV_FISHEYE", "FULL_OPENCV"};

// ---- Text, as COLMAP documents it: comments by '#', an image's two lines, the second possibly empty. ----

void AddCamera(const std::string& line, ColmapRead& read) {
  const auto words = Words(line);
  Require(words.size() > 4 && ParametersOf().contains(words[1]), line + ": is no camera");
  Require(words.size() == 4 + ParametersOf().at(words[1]), line + ": has a wrong number of parameters");
  ColmapRead::Camera camera{words[1], Whole(words[2]), Whole(words[3]), {}};
  for (std::size_t i = 4; i < words.size(); ++i) camera.parameters.push_back(Real(words[i]));
  Require(read.cameras.emplace(Whole(words[0]), camera).second, line + ": its id is given already");
}

void AddImage(const std::string& line, const std::string& points, ColmapRead& read) {
  const auto words = Words(line), places = Words(points);
  Require(words.size() == 10, line + ": is no image");
  ColmapRead::Image image;
  image.rotation = {Real(words[1]), Real(words[2]), Real(words[3]), Real(words[4])};
  image.translation = {Real(words[5]), Real(words[6]), Real(words[7])};
  image.camera = Whole(words[8]);
  image.name = words[9];
  Require(places.size() % 3 == 0, points.substr(0, 80) + ": is no list of X Y POINT3D_ID");
  for (std::size_t i = 0; i < places.size(); i += 3) {
    image.places.emplace_back(Real(places[i]), Real(places[i + 1]));
    image.point_ids.push_back(Whole(places[i + 2]));
  }
  Require(read.images.emplace(Whole(words[0]), image).second, line + ": its id is given already");
}

void AddPoint(const std::string& line, ColmapRead& read) {
  const auto words = Words(line);
  Require(words.size() >= 8 && words.size() % 2 == 0, line.substr(0, 80) + ": is no point");
  ColmapRead::Point point;
  point.position = {Real(words[1]), Real(words[2]), Real(words[3])};
  point.rgb = {static_cast<int>(Whole(words[4])), static_cast<int>(Whole(words[5])),
               static_cast<int>(Whole(words[6]))};
  Require(point.rgb.minCoeff() >= 0 && point.rgb.maxCoeff() <= 255, line.substr(0, 80) + ": is no colour");
  point.error_px = Real(words[7]);
  for (std::size_t i = 8; i < words.size(); i += 2)
    point.track.emplace_back(Whole(words[i]), Whole(words[i + 1]));
  Require(read.points.emplace(Whole(words[0]), point).second, words[0] + ": this id is given already");
}

ColmapRead FromText(const fs::path& model) {
  ColmapRead read;
  const auto is_data = [](const std::string& line) { return !line.empty() && line[0] != '#'; };
  for (const std::string& line : Lines(model / "cameras.txt"))
    if (is_data(line)) AddCamera(line, read);
  const std::vector<std::string> images = Lines(model / "images.txt");
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!is_data(images[i])) continue;
    Require(i + 1 < images.size(), "images.txt: the last image has no line of points");
    AddImage(images[i], images[i + 1], read);
    ++i;
  }
  for (const std::string& line : Lines(model / "points3D.txt"))
    if (is_data(line)) AddPoint(line, read);
  return read;
}

// ---- Binary, little-endian. ----

class Bytes {
 public:
  explicit Bytes(const fs::path& path) : name_(path.filename().string()), file_(path, std::ios::binary) {
    Require(file_.good(), name_ + ": is not there");
  }
  template <typename T>
  T Get() {
    T value{};
    file_.read(reinterpret_cast<char*>(&value), sizeof value);
    Require(file_.good(), name_ + ": ends too early");
    return value;
  }
  std::string Name() {
    std::string name;
    for (char c; (c = Get<char>()) != '\0';) name += c;
    return name;
  }
  void RequireEnd() { Require(file_.peek() == EOF, name_ + ": goes on after its end"); }

 private:
  std::string name_;
  std::ifstream file_;
};

ColmapRead FromBinary(const fs::path& model) {
  ColmapRead read;
  Bytes cameras(model / "cameras.bin"), images(model / "images.bin"), points(model / "points3D.bin");
  for (auto left = cameras.Get<std::uint64_t>(); left > 0; --left) {
    const auto id = cameras.Get<std::uint32_t>();
    const auto number = cameras.Get<std::int32_t>();
    Require(number >= 0 && number < 7, "cameras.bin: there is no such model");
    ColmapRead::Camera& camera = read.cameras[id];
    camera.model = kByNumber[number];
    camera.width = static_cast<long>(cameras.Get<std::uint64_t>());
    camera.height = static_cast<long>(cameras.Get<std::uint64_t>());
    for (std::size_t i = 0; i < ParametersOf().at(camera.model); ++i)
      camera.parameters.push_back(cameras.Get<double>());
  }
  cameras.RequireEnd();
  for (auto left = images.Get<std::uint64_t>(); left > 0; --left) {
    ColmapRead::Image& image = read.images[images.Get<std::uint32_t>()];
    double q[4], t[3];
    for (double& part : q) part = images.Get<double>();
    for (double& part : t) part = images.Get<double>();
    image.rotation = {q[0], q[1], q[2], q[3]};
    image.translation = {t[0], t[1], t[2]};
    image.camera = images.Get<std::uint32_t>();
    image.name = images.Name();
    for (auto places = images.Get<std::uint64_t>(); places > 0; --places) {
      const double x = images.Get<double>(), y = images.Get<double>();
      image.places.emplace_back(x, y);
      image.point_ids.push_back(images.Get<std::int64_t>());
    }
  }
  images.RequireEnd();
  for (auto left = points.Get<std::uint64_t>(); left > 0; --left) {
    ColmapRead::Point& point = read.points[static_cast<long>(points.Get<std::uint64_t>())];
    for (int i = 0; i < 3; ++i) point.position(i) = points.Get<double>();
    for (int i = 0; i < 3; ++i) point.rgb(i) = points.Get<std::uint8_t>();
    point.error_px = points.Get<double>();
    for (auto seen = points.Get<std::uint64_t>(); seen > 0; --seen) {
      const long image = points.Get<std::uint32_t>(), index = points.Get<std::uint32_t>();
      point.track.emplace_back(image, index);
    }
  }
  points.RequireEnd();
  return read;
}

void RequireConsistent(const ColmapRead& read) {
  std::set<std::string> names;
  for (const auto& [id, image] : read.images) {
    Require(read.cameras.contains(image.camera), image.name + ": has no camera");
    Require(std::abs(image.rotation.norm() - 1) < 1e-6, image.name + ": is not turned by a unit quaternion");
    Require(names.insert(image.name).second, image.name + ": is named twice");
    for (std::size_t i = 0; i < image.point_ids.size(); ++i) {
      if (image.point_ids[i] == -1) continue;
      const auto point = read.points.find(image.point_ids[i]);
      Require(point != read.points.end(), image.name + ": shows a point that is not there");
      const auto& track = point->second.track;
      Require(std::count(track.begin(), track.end(), std::pair(id, static_cast<long>(i))) == 1,
              image.name + ": shows a point that does not know it");
    }
  }
  for (const auto& [id, point] : read.points) {
    for (const auto& [image, index] : point.track) {
      const auto of = read.images.find(image);
      Require(of != read.images.end() && index >= 0 &&
                  index < static_cast<long>(of->second.point_ids.size()) &&
                  of->second.point_ids[static_cast<std::size_t>(index)] == id,
              "a track names what does not name it");
    }
  }
}

void RequireTracks(const ColmapRead& read) {
  Require(!read.points.empty(), "there are no points to begin from");
  for (const auto& [id, point] : read.points) Require(point.track.size() >= 2, "a point without a track");
}

void RequirePicture(const fs::path& path, long width, long height) {
  const cv::Mat picture = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  Require(!picture.empty(), path.string() + ": is no picture");
  Require(picture.cols == width && picture.rows == height, path.string() + ": has not its camera's size");
}

bool HasBinary(const fs::path& model) { return fs::exists(model / "cameras.bin"); }

}  // namespace

std::size_t ColmapRead::Observations() const {
  std::size_t count = 0;
  for (const auto& [id, point] : points) count += point.track.size();
  return count;
}

const ColmapRead::Image& ImageNamed(const ColmapRead& model, const std::string& name) {
  for (const auto& [id, image] : model.images)
    if (image.name == name) return image;
  Refuse(name + ": is not in the model");
}

ColmapRead ReadAsColmap(const fs::path& model) {
  ColmapRead read = HasBinary(model) ? FromBinary(model) : FromText(model);
  RequireConsistent(read);
  return read;
}

std::size_t ReadAsInria(const fs::path& folder) {
  const fs::path model = folder / "sparse/0";
  const bool binary = HasBinary(model);
  const ColmapRead read = binary ? FromBinary(model) : FromText(model);
  for (const auto& [id, camera] : read.cameras) {
    Require(camera.model == "PINHOLE" || (binary && camera.model == "SIMPLE_PINHOLE"),
            camera.model + ": only undistorted sets (PINHOLE) are supported");
    // The field of view is all it keeps.
    const std::size_t at = camera.parameters.size() - 2;
    Require(2 * camera.parameters[at] == static_cast<double>(camera.width) &&
                2 * camera.parameters[at + 1] == static_cast<double>(camera.height),
            "the principal point is not in the middle, which would be assumed");
  }
  std::set<std::string> stems;
  for (const auto& [id, image] : read.images) {
    const ColmapRead::Camera& camera = read.cameras.at(image.camera);
    RequirePicture(folder / "images" / fs::path(image.name).filename(), camera.width, camera.height);
    Require(stems.insert(fs::path(image.name).filename()).second, image.name + ": two have this bare name");
  }
  RequireTracks(read);
  return read.images.size();
}

std::size_t ReadAsSceneManager(const fs::path& folder) {
  const fs::path model = folder / "sparse/0";
  if (HasBinary(model)) {
    const ColmapRead read = FromBinary(model);
    RequireTracks(read);
    return read.images.size();
  }
  // All three files end for it at the first line that is empty or blank.
  const auto data = [&](const char* name) {
    std::vector<std::string> lines;
    for (const std::string& line : Lines(model / name)) {
      if (Words(line).empty()) break;
      if (line[0] != '#') lines.push_back(line);
    }
    return lines;
  };
  std::size_t in_file = 0;
  for (const std::string& line : Lines(model / "images.txt")) {
    const auto words = Words(line);
    in_file += words.size() == 10 && words[0][0] != '#' && words.back().find('.') != std::string::npos &&
               std::isalpha(static_cast<unsigned char>(words.back().back()));
  }
  ColmapRead read;
  for (const std::string& line : data("cameras.txt")) AddCamera(line, read);
  const std::vector<std::string> images = data("images.txt");
  Require(images.size() % 2 == 0, "images.txt: an empty line, at which it ends, in place of points");
  for (std::size_t i = 0; i < images.size(); i += 2) AddImage(images[i], images[i + 1], read);
  for (const std::string& line : data("points3D.txt")) AddPoint(line, read);
  Require(read.images.size() == in_file, "images.txt: what follows an empty line is not read");
  RequireTracks(read);
  return read.images.size();
}

std::size_t ReadAsLichtFeld(const fs::path& folder) {
  const fs::path model = folder / "sparse/0";
  ColmapRead read;
  if (HasBinary(model)) {
    read = FromBinary(model);
  } else {
    const auto data = [&](const char* name) {
      std::vector<std::string> lines;
      for (const std::string& line : Lines(model / name))
        if (!line.starts_with("#")) lines.push_back(line);
      Require(!lines.empty(), std::string(name) + ": is empty");
      if (lines.back().empty()) lines.pop_back();
      return lines;
    };
    for (const std::string& line : data("cameras.txt")) AddCamera(line, read);
    const std::vector<std::string> images = data("images.txt");
    Require(images.size() % 2 == 0, "images.txt should have an even number of lines");
    for (std::size_t i = 0; i < images.size(); i += 2) {
      Require(SplitAtSpaces(images[i]).size() == 10, "invalid format in images.txt");
      AddImage(images[i], images[i + 1], read);
    }
    for (const std::string& line : data("points3D.txt")) {
      Require(SplitAtSpaces(line).size() >= 8, "invalid format in points3D.txt");
      AddPoint(line, read);
    }
  }
  for (const auto& [id, image] : read.images) {
    const ColmapRead::Camera& camera = read.cameras.at(image.camera);
    RequirePicture(folder / "images" / image.name, camera.width, camera.height);
    const fs::path mask = folder / "masks" / (image.name + ".png");
    if (fs::exists(mask)) RequirePicture(mask, camera.width, camera.height);
  }
  RequireTracks(read);
  return read.images.size();
}

std::size_t ReadAsNerfstudioColmap(const fs::path& folder) {
  const fs::path model = folder / "sparse/0";
  const ColmapRead read = fs::exists(model / "cameras.txt") ? FromText(model) : FromBinary(model);
  std::set<bool> fisheye;
  for (const auto& [id, camera] : read.cameras) {
    Require(camera.model != "FULL_OPENCV", camera.model + " camera model is not supported yet!");
    Require(camera.model != "OPENCV_FISHEYE" || camera.parameters.back() == 0, "K4/K5/K6 is non-zero!");
    fisheye.insert(camera.model == "OPENCV_FISHEYE");
  }
  Require(fisheye.size() == 1, "multiple camera models are not supported");
  for (const auto& [id, image] : read.images) {
    const ColmapRead::Camera& camera = read.cameras.at(image.camera);
    RequirePicture(folder / "images" / image.name, camera.width, camera.height);
  }
  RequireTracks(read);
  return read.images.size();
}

namespace {

void RequireMatrix(const json& frame) {
  const json& rows = frame.at("transform_matrix");
  Eigen::Matrix4d matrix;
  Require(rows.size() == 4, "transform_matrix has not four rows");
  for (std::size_t r = 0; r < 4; ++r) {
    Require(rows[r].size() == 4, "transform_matrix has not four columns");
    for (std::size_t c = 0; c < 4; ++c)
      matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows[r][c].get<double>();
  }
  const Eigen::Matrix3d turned = matrix.topLeftCorner<3, 3>();
  Require((turned * turned.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9, "is no rotation");
}

}  // namespace

std::size_t ReadAsNerfstudio(const fs::path& folder) {
  const json meta = JsonFromText(std::ifstream(folder / "transforms.json"));
  static const std::set<std::string> known{"SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL",
                                           "RADIAL",         "OPENCV",  "OPENCV_FISHEYE"};
  // One kind for all, at the top; without it, perspective.
  const std::string model = meta.value("camera_model", "OPENCV");
  Require(known.contains(model), model + ": is no camera model");
  std::size_t masks = 0;
  for (const json& frame : meta.at("frames")) {
    // Each of these at the top or in every frame.
    const auto number = [&](const char* key) {
      Require(meta.contains(key) || frame.contains(key), std::string(key) + " not specified in frame");
      return (meta.contains(key) ? meta : frame).at(key).get<double>();
    };
    Require(number("fl_x") > 0 && number("fl_y") > 0 && number("cx") > 0 && number("cy") > 0,
            "no intrinsics");
    const std::string own = frame.value("camera_model", model);
    Require((own == "OPENCV_FISHEYE") == (model == "OPENCV_FISHEYE"),
            "a frame's own camera_model is not looked at");
    const long width = static_cast<long>(number("w")), height = static_cast<long>(number("h"));
    RequirePicture(folder / frame.at("file_path").get<std::string>(), width, height);
    RequireMatrix(frame);
    if (!frame.contains("mask_path")) continue;
    ++masks;
    RequirePicture(folder / frame.at("mask_path").get<std::string>(), width, height);
  }
  Require(masks == 0 || masks == meta.at("frames").size(), "different number of image and mask filenames");
  if (meta.contains("ply_file_path"))
    Require(fs::file_size(folder / meta.at("ply_file_path").get<std::string>()) > 0, "no points");
  return meta.at("frames").size();
}

std::size_t ReadAsBrush(const fs::path& folder) {
  const json meta = JsonFromText(std::ifstream(folder / "transforms.json"));
  for (const json& frame : meta.at("frames")) {
    const std::string model = frame.value("camera_model", meta.value("camera_model", ""));
    Require(model.empty() || model == "OPENCV" || model == "OPENCV_FISHEYE",
            "Unsupported nerfstudio camera_model " + model);
    Require(fs::exists(folder / frame.at("file_path").get<std::string>()), "image file not found");
    RequireMatrix(frame);
  }
  return meta.at("frames").size();
}

std::size_t ReadAsInstantNgp(const fs::path& folder) {
  const json meta = JsonFromText(std::ifstream(folder / "transforms.json"));
  Require(meta.contains("frames") && meta.at("frames").is_array(), "does not contain any frames");
  const int scale = meta.value("aabb_scale", 1);
  Require(scale > 0 && scale <= 128 && (scale & (scale - 1)) == 0, "aabb_scale must be a power of two");
  for (const json& frame : meta.at("frames")) {
    const auto has = [&](const char* key) { return meta.contains(key) || frame.contains(key); };
    Require(has("fl_x") || has("camera_angle_x"), "couldn't read fov");
    Require(fs::exists(folder / frame.at("file_path").get<std::string>()), "could not find image file");
    // Of OPENCV's distortion it knows k1 k2 p1 p2, at the top or in the frame.
    for (const json* place : {&meta, &frame}) {
      const bool fisheye = place->value("is_fisheye", false);
      Require(fisheye || place->value("k3", 0.0) == 0, "k3 is not looked at");
    }
    RequireMatrix(frame);
  }
  return meta.at("frames").size();
}

}  // namespace ulf::test

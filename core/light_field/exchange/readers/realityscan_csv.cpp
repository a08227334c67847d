#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kFilmWidth_mm = 36;
constexpr const char* kExportAll =
    "export it again: Alignment > Export > Registration > Internal/External camera parameters";

// Returns what separates the columns: spreadsheets of many countries write semicolons or tabs.
char SeparatorOf(const std::string& titles) {
  return std::ranges::max(std::string(",;\t"), {}, [&](char c) { return std::ranges::count(titles, c); });
}

std::vector<std::string> CsvCells(const std::string& line, char separator) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"')
      is_quoted = !is_quoted;
    else if (c == separator && !is_quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  for (std::string& cell : cells) {
    cell.erase(cell.find_last_not_of(" \t\r") + 1);
    cell.erase(0, cell.find_first_not_of(" \t"));
  }
  return cells;
}

// The rows of the table; columns are found by their titles.
class CsvRows {
 public:
  explicit CsvRows(const fs::path& file) : name_(file.string()), stream_(OpenTextFile(file)) {
    while (Next() && Lowercase(cells_.front()) != "#name") {
    }
    for (std::size_t i = 0; i < cells_.size(); ++i) columns_.emplace(Lowercase(cells_[i]), i);
    for (const char* title : {"#name", "x", "y", "alt", "heading", "pitch", "roll", "f"})
      if (!columns_.contains(title))
        throw Error("{}: the first row names no column '{}'; {}", name_, title, kExportAll);
  }

  bool Next() {
    for (std::string line; std::getline(stream_, line);) {
      ++number_;
      if (columns_.empty()) separator_ = SeparatorOf(line);
      cells_ = CsvCells(line, separator_);
      const bool is_count = cells_.front().starts_with("#cameras");
      if (!is_count && !(cells_.size() == 1 && cells_.front().empty())) return true;
    }
    cells_ = {""};
    return false;
  }

  bool Has(const char* title) const { return columns_.contains(title); }
  const std::string& Name() const { return Cell("#name"); }
  std::string Where() const { return fmt::format("{}, line {}", name_, number_); }

  double Number(const char* title) const {
    double number = 0;
    std::string digits = Cell(title);
    if (separator_ != ',') std::ranges::replace(digits, ',', '.');  // 3,5 where semicolons separate
    if (!ParseNumber(digits, number) || !std::isfinite(number))
      throw Error("{}: '{}' in the column '{}' is not a finite number; {}", Where(), Cell(title), title,
                  kExportAll);
    return number;
  }
  double Number(const char* title, double otherwise) const { return Has(title) ? Number(title) : otherwise; }

 private:
  const std::string& Cell(const char* title) const {
    const std::size_t column = columns_.at(title);
    if (column >= cells_.size())
      throw Error("{}: has {} cells and none for the column '{}'; {}", Where(), cells_.size(), title,
                  kExportAll);
    return cells_[column];
  }

  std::string name_;
  std::ifstream stream_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> cells_;
  char separator_ = ',';
  int number_ = 0;
};

Rigid3 PoseOfRow(const CsvRows& row) {
  constexpr double kDegree = std::numbers::pi / 180;
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Eigen::Quaterniond world_from_cam =
      AngleAxisd(-row.Number("heading") * kDegree, Vector3d::UnitZ()) *
      AngleAxisd(row.Number("pitch") * kDegree, Vector3d::UnitX()) *
      AngleAxisd(row.Number("roll") * kDegree, Vector3d::UnitY()) *
      AngleAxisd(std::numbers::pi, Vector3d::UnitX());  // from y up, z back
  return Rigid3{world_from_cam.normalized(), {row.Number("x"), row.Number("y"), row.Number("alt")}}.Inverse();
}

CameraModel CameraOfRow(const CsvRows& row, const fs::path& image, FittedLenses& fitted) {
  const cv::Size size = ReadImageSize(image.string());
  const double scale = std::max(size.width, size.height);
  CameraModel camera = CameraModel::Pinhole(size.width, size.height, row.Number("f") / kFilmWidth_mm * scale);
  camera.cx += scale * row.Number("px", 0);
  camera.cy += scale * row.Number("py", 0);
  std::array<double, 6> c{};
  constexpr std::array kTitles{"k1", "k2", "k3", "k4", "t1", "t2"};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = row.Number(kTitles[i], 0);
  camera.Validate(row.Where());
  if (c == std::array<double, 6>{}) return camera;
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {c[0], c[1], c[5], c[4], c[2]};  // t1, t2 are OpenCV's p2, p1
  if (c[3] == 0) return camera;
  const CameraModel start = camera;
  const Projection project = [&](const Eigen::Vector3d& point_in_cam) -> std::optional<Eigen::Vector2d> {
    if (!(point_in_cam.z() > 0)) return std::nullopt;
    const Eigen::Vector2d p = point_in_cam.head<2>() / point_in_cam.z();
    const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
    const double radial = 1 + r2 * (c[0] + r2 * (c[1] + r2 * (c[2] + r2 * c[3])));
    return Eigen::Vector2d(start.fx * (x * radial + c[4] * (r2 + 2 * x * x) + 2 * c[5] * x * y) + start.cx,
                           start.fy * (y * radial + c[5] * (r2 + 2 * y * y) + 2 * c[4] * x * y) + start.cy);
  };
  return fitted.Take(project, start, "RealityScan's distortion with k4", row.Where(),
                     "align and export with the model Brown 3 (Alignment Settings > Distortion model)");
}

}  // namespace

PosedSet ReadRealityScanCsv(const fs::path& file, const fs::path& chosen) {
  PosedSet set;
  set.format = "RealityScan, csv";
  LightField& light_field = set.light_field;
  std::vector<std::string> names;
  for (CsvRows rows(file); rows.Next();) names.push_back(rows.Name());
  if (names.empty()) throw Error("{}: lists no camera; {}", file.string(), kExportAll);
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  SetImages images(base, chosen, FoldersOfNames(base, names));
  images.Reserve(names);

  NamedViews named(file, images, set);
  FittedLenses fitted;
  std::size_t with_k1_alone = 0;
  CsvRows rows(file);
  std::vector<std::string> absent;
  for (const char* title : {"px", "py", "k1", "k2", "k3", "k4", "t1", "t2"})
    if (!rows.Has(title)) absent.push_back(title);
  if (!absent.empty())
    light_field.doubts.push_back(
        fmt::format("{}: there are no columns {}: these parameters are taken to be 0", file.string(),
                    fmt::join(absent, ", ")));
  while (rows.Next()) {
    const std::string where = fmt::format("{} ({})", rows.Where(), rows.Name());
    const std::string path = named.Find(rows.Name(), where);
    if (path.empty()) continue;
    const CameraModel camera = CameraOfRow(rows, images.folder() / path, fitted);
    const auto& [k1, k2, p1, p2, k3] = camera.coefficients;
    with_k1_alone += k1 != 0 && k2 == 0 && k3 == 0 && p1 == 0 && p2 == 0;
    named.Add(path, camera, PoseOfRow(rows), where);
  }
  named.RequireFound();
  fitted.Note(light_field.doubts);
  if (with_k1_alone > 0)
    light_field.doubts.push_back(fmt::format(
        "{}: the lens of {} has k1 alone, and a csv does not name its model: it is read as Brown's; if the "
        "project has the model Division, export XMP files or align with Brown 3",
        file.string(), Counted(with_k1_alone, "camera")));
  return set;
}

}  // namespace ulf

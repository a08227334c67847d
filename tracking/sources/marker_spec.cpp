#include "tracking/sources/marker_spec.h"

#include <fmt/core.h>

#include <cstdio>

#include "core/base/error.h"

namespace ulf::tracking {

MarkerSpec MarkerSpec::Parse(const std::string& text) {
  MarkerSpec spec;
  const std::string quoted = fmt::format("'{}'", text);
  if (!text.starts_with("marker:")) {
    if (text.starts_with("chessboard"))
      throw Refusal("markers", quoted, "a chessboard looks the same turned by half a turn",
                    "use a charuco, aruco or aprilgrid board");
    if (!text.starts_with("charuco:") && !text.starts_with("aruco:") && !text.starts_with("aprilgrid:"))
      throw Refusal("markers", quoted,
                    "markers are written as charuco:7x5:30:22:DICT_5X5_100, aruco:4x5:37.5:5:DICT_6X6_1000, "
                    "aprilgrid:6x6:30:9 or marker:80:DICT_APRILTAG_36h11:3 (side in mm, dictionary, number)",
                    "");
    spec.board = Board::Parse(text);
    spec.dictionary = spec.board.dictionary;
    return spec;
  }
  double side_mm = 0;
  char dictionary[64] = {}, id_text[16] = {}, rest = 0;
  const int read =
      std::sscanf(text.c_str(), "marker:%lf:%63[^:]:%15[^:]%c", &side_mm, dictionary, id_text, &rest);
  if ((read != 2 && read != 3) || text.ends_with(':') || !(side_mm > 0 && side_mm < 1e5))
    throw Refusal("markers", quoted,
                  "a marker is written as marker:SIDE_MM:DICTIONARY or with its number behind, as "
                  "marker:80:DICT_APRILTAG_36h11:3",
                  "");
  DictionaryNumber(dictionary);
  spec.dictionary = dictionary;
  spec.side_m = side_mm / 1000;
  spec.kind = read == 3 ? Kind::kOne : Kind::kSeveral;
  if (read == 3) {
    int used = 0;
    if (std::sscanf(id_text, "%d%n", &spec.id, &used) != 1 || id_text[used] != 0 || spec.id < 0)
      throw Refusal("markers", quoted, fmt::format("'{}' is not a marker's number", id_text), "");
  }
  return spec;
}

std::string MarkerSpec::Text() const {
  if (kind == Kind::kBoard) return board.Text();
  return fmt::format("marker:{:g}:{}{}", 1000 * side_m, dictionary,
                     kind == Kind::kOne ? fmt::format(":{}", id) : "");
}

Eigen::Vector3d MarkerSpec::Middle() const {
  if (kind != Kind::kBoard) return Eigen::Vector3d::Zero();
  return {0.0005 * board.WidthMm(), 0.0005 * board.HeightMm(), 0};
}

std::vector<Eigen::Vector3d> MarkerCorners(double side_m) {
  const double h = 0.5 * side_m;
  return {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
}

}  // namespace ulf::tracking

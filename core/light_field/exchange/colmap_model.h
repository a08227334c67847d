// A light field in COLMAP's terms, before it is text (colmap_text) or binary (colmap_binary). Its poses are
// world-to-camera with our axes, its pixel centres at integer + 0.5: both as ours. Image names are relative
// to the images folder. Ids: a camera's is its index + 1, an image's is its view's, points are numbered.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

struct ColmapReconstruction {
  struct Camera {
    std::uint32_t id = 0;
    int model = 0;          // COLMAP's number of it
    const char* name = "";  // and its name
    std::uint64_t width = 0, height = 0;
    std::vector<double> parameters;
  };
  struct Point2d {
    Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
    std::uint64_t point = kNoPoint;
  };
  struct Image {
    std::uint32_t id = 0, camera = 0;
    Rigid3 cam_from_world;
    std::string name;
    std::vector<Point2d> points;  // never empty: readers stumble over empty lines
  };
  struct Seen {
    std::uint32_t image = 0, index = 0;  // into its points
  };
  struct Point {
    std::uint64_t id = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::array<std::uint8_t, 3> rgb{};
    double error_px = 0;
    std::vector<Seen> track;
  };
  static constexpr std::uint64_t kNoPoint = static_cast<std::uint64_t>(-1);

  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Point> points;
};

// Points without observations are left out where others have some. A view that shows none gets one place
// without a point, its principal point, which every reader skips. Names are as SafeName() has them
// (image_names.h).
ColmapReconstruction ToColmap(const LightField& light_field);

// The smallest of COLMAP's models that says the same.
ColmapReconstruction::Camera ToColmapCamera(const CameraModel& camera);

}  // namespace ulf

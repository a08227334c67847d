// A light field as COLMAP's model, to be written as text (colmap_text) or binary (colmap_binary). Poses are
// world-to-camera with y down and z forward, pixel centres at integer + 0.5, both as in ulf. Image names are
// relative to the images folder. A camera's id is its index + 1, an image's id is its view's; points are
// numbered.
#pragma once

#include <array>
#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

struct ColmapReconstruction {
  struct Camera {
    std::uint32_t id = 0;
    int model = 0;          // COLMAP's number of the camera model
    const char* name = "";  // of the camera model
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
    std::vector<Point2d> points;  // never empty, because some readers fail on empty lines
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

// How far from 1 the length of a pose's quaternion may be.
inline constexpr double kQuaternionTolerance = 1e-3;

// Points without observations are left out if others have some. A view without observations gets one at its
// principal point that belongs to no point, which every reader skips. Names are those of SafeName()
// (image_names.h).
ColmapReconstruction ToColmap(const LightField& light_field);

// The simplest of COLMAP's camera models that is equivalent.
ColmapReconstruction::Camera ToColmapCamera(const CameraModel& camera);

// A row of cameras.txt behind the camera's number: MODEL WIDTH HEIGHT PARAMS[]. Knows (SIMPLE_)PINHOLE,
// (SIMPLE_)RADIAL, OPENCV, FULL_OPENCV without k4 k5 k6, and (SIMPLE_RADIAL_, RADIAL_, OPENCV_)FISHEYE.
// Throws Error that begins with `where`.
CameraModel ReadColmapCamera(std::istream& row, const std::string& where);

// How many parameters the camera model of this number of COLMAP's has. Throws Error that begins with `where`
// for one that ReadColmapCamera() does not know.
std::size_t ColmapParameters(int model, const std::string& where);
// By model number, width, height and parameters. Throws as ReadColmapCamera().
CameraModel FromColmapCamera(const ColmapReconstruction::Camera& camera, const std::string& where);

}  // namespace ulf

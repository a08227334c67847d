// COLMAP's model of a scene, as its files (colmap_files.h) hold it. Poses are world-to-camera with y down and
// z forward, pixel centres at integer + 0.5, both as in ulf. Image names are relative to the images folder.
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
    std::uint64_t point = kNoPoint;  // id of a Point
  };
  struct Image {
    std::uint32_t id = 0, camera = 0;
    Rigid3 cam_from_world;
    std::string name;
    std::vector<Point2d> points;  // never empty, because some readers fail on empty lines
  };
  struct Seen {
    std::uint32_t image = 0, index = 0;  // index into the image's points
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
  std::vector<std::string> doubts;  // sentences on what a reader replaced
};

// The length of a pose's quaternion may differ from 1 by this much without a word.
inline constexpr double kQuaternionTolerance = 1e-3;

// Normalises the pose's quaternion, whose length may be any but zero, and returns by how much it differed
// from 1. Throws an Error that begins with `where` unless it and the translation are finite.
double NormalizeColmapPose(Rigid3& pose, const std::string& where);

// A camera's id is its index + 1, an image's id is its view's; points are numbered from 1. Points without
// observations are left out if others have some. A view without observations gets one at its principal point
// that belongs to no point, which every reader skips. Names are those of SafeName() (image_names.h).
ColmapReconstruction ToColmap(const LightField& light_field);

// Returns the model with cameras and images sorted and numbered from 1 as COLMAP's database numbers them when
// its feature_extractor reads the photographs of one camera after another: images by the bytes of their
// names, cameras by their first images (src/colmap/controllers/image_reader.cc). Cameras without an image are
// left out. COLMAP's point_triangulator demands it: it compares frames, rigs and cameras by number.
ColmapReconstruction NumberedAsInDatabase(const ColmapReconstruction& model);

// Returns the first of PINHOLE, OPENCV, FULL_OPENCV and OPENCV_FISHEYE that is equivalent; its id is 0.
ColmapReconstruction::Camera ToColmapCamera(const CameraModel& camera);

// Reads the part of a cameras.txt row behind the camera's number: MODEL WIDTH HEIGHT PARAMS[]. It knows the
// models 0 to 17 of COLMAP (src/colmap/sensor/models.h of August 2026), and takes each that is equivalent to
// a CameraModel with its parameters. Throws an Error that begins with `where` for anything else, with the
// model and the program that converts it.
CameraModel ReadColmapCamera(std::istream& row, const std::string& where);

// Returns how many parameters COLMAP's camera model of this number has. Throws an Error that begins with
// `where` for one that ReadColmapCamera() does not know.
std::size_t ColmapParameters(int model, const std::string& where);
// Converts by model number, width, height and parameters. Throws as ReadColmapCamera() does.
CameraModel FromColmapCamera(const ColmapReconstruction::Camera& camera, const std::string& where);

}  // namespace ulf

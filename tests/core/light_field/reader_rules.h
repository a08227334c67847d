// What other programs' readers ask of a set, as small readers of our own after their sources (looked up in
// November 2026): each throws std::runtime_error where that program would stop, or would take something for
// what it is not.
//
//   ReadAsColmap            COLMAP 3.8, Reconstruction::Read: binary wins over text; ids and indices agree
//   ReadAsInria             graphdeco-inria/gaussian-splatting, scene/colmap_loader.py, dataset_readers.py:
//                           binary first, then text, which must be PINHOLE; photographs by their bare names;
//                           the principal point is taken to be in the middle
//   ReadAsSceneManager      the pycolmap scene manager (trueprice, rmbrualla) that gsplat's examples used:
//                           text ends at the first empty line (and needs Python 2)
//   ReadAsLichtFeld         MrNeRF's LichtFeld Studio before it took empty lines: ten words an image, as many
//                           lines of points as of images
//   ReadAsNerfstudioColmap  nerfstudio's colmap dataparser: text first; one kind of camera for all, no
//                           FULL_OPENCV, no fisheye with k4
//   ReadAsNerfstudio        nerfstudio's own dataparser: transforms.json; masks for all frames or for none
//   ReadAsBrush             ArthurBrussee/brush, formats/nerfstudio.rs: OPENCV, OPENCV_FISHEYE or no word
//   ReadAsInstantNgp        NVlabs/instant-ngp, src/nerf_loader.cu
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ulf::test {

struct ColmapRead {
  struct Camera {
    std::string model;
    long width = 0, height = 0;
    std::vector<double> parameters;
  };
  struct Image {
    Eigen::Quaterniond rotation;
    Eigen::Vector3d translation;
    long camera = 0;
    std::string name;
    std::vector<Eigen::Vector2d> places;
    std::vector<long> point_ids;  // -1: none
  };
  struct Point {
    Eigen::Vector3d position;
    Eigen::Vector3i rgb;
    double error_px = 0;
    std::vector<std::pair<long, long>> track;  // image, index
  };
  std::map<long, Camera> cameras;
  std::map<long, Image> images;
  std::map<long, Point> points;

  std::size_t Observations() const;
};

ColmapRead ReadAsColmap(const std::filesystem::path& model);
// The image of this name; throws if there is none.
const ColmapRead::Image& ImageNamed(const ColmapRead& model, const std::string& name);
// The following take the folder that holds images/ and sparse/0 or transforms.json. How many images they
// found.
std::size_t ReadAsInria(const std::filesystem::path& folder);
std::size_t ReadAsSceneManager(const std::filesystem::path& folder);
std::size_t ReadAsLichtFeld(const std::filesystem::path& folder);
std::size_t ReadAsNerfstudioColmap(const std::filesystem::path& folder);
std::size_t ReadAsNerfstudio(const std::filesystem::path& folder);
std::size_t ReadAsBrush(const std::filesystem::path& folder);
std::size_t ReadAsInstantNgp(const std::filesystem::path& folder);

}  // namespace ulf::test

// A mesh with its cameras as glTF 2.0 (registry.khronos.org/glTF/specs/2.0), in one binary file (.glb).
//
// glTF's world has y up; the light field's lies below a node "world" that turns it, so that all in it keeps
// its numbers. glTF's cameras look along -z with y up, have square or oblong pixels, the principal point in
// the middle and no distortion. What shows a photograph is light already: materials are unlit
// (KHR_materials_unlit), seen from both sides. glTF's unit is the metre; where the light field's is
// arbitrary, "extras" of the world's node say so.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct GltfCamera {
  std::string name;
  CameraModel camera;  // without distortion, principal point in the middle
  Rigid3 cam_from_world;
  nlohmann::json extras;  // what glTF has no words for
};

struct GltfModel {
  std::string name;
  TriangleMesh mesh;
  // Either a texture or colours: where both are given viewers multiply them.
  std::vector<Eigen::Vector2f> texel;  // of each vertex, pixels of the texture
  std::string texture_png;
  cv::Size texture_size;
  std::vector<cv::Vec3f> colors;  // of each vertex, linear B G R
  std::vector<GltfCamera> cameras;
  double near_distance = 0;  // from the cameras, the world's unit, above zero: what is nearer is not drawn
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitY();
  std::string units;  // LightField::units
};

// Throws Error where the file would be larger than the format's 4 GB, or a camera is none of glTF's.
std::string GlbBytes(const GltfModel& model);

}  // namespace ulf::render

// Writes a mesh with its cameras as glTF 2.0 (registry.khronos.org/glTF/specs/2.0), in one .glb file.
//
// glTF's world has y up; the light field's lies below a node "world" that rotates it, so that all in it keeps
// its numbers. glTF's cameras look along -z with y up, have square or oblong pixels, the principal point in
// the middle and no distortion. Photographs contain the scene's lighting: materials are unlit
// (KHR_materials_unlit), seen from both sides. glTF's unit is the metre; "extras" of the world's node tell
// the light field's unit.
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
  nlohmann::json extras;  // properties that glTF cannot express
};

struct GltfModel {
  std::string name;
  TriangleMesh mesh;
  // Give either a texture (the next three) or colours: viewers multiply them.
  std::vector<Eigen::Vector2f> texel;  // per vertex, pixels of the texture from its upper left corner
  std::string texture_png;
  cv::Size texture_size;
  std::vector<cv::Vec3f> colors;  // per vertex, linear B G R
  std::vector<GltfCamera> cameras;
  double near_distance = 0;  // world units, above zero: nearer parts are not drawn
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitY();
  std::string units;  // LightField::units
};

// Throws Error if the file would be larger than the format's 4 GB, or glTF cannot express a camera.
std::string GlbBytes(const GltfModel& model);

}  // namespace ulf::render

// Which recorded views have which part of a picture in their images: where a pixel looks through views until
// one sees its point, all others need not be looked at. Conservative, by the half-spaces of the views'
// images.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "render/proxy/proxy.h"
#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewTiles {
  struct Tile {
    cv::Rect px;
    int first = 0, end = 0;  // of `views`
  };
  std::vector<Tile> tiles;  // the whole picture, each part once
  std::vector<int> views;   // of each tile in the order in which they are looked through
};

class ViewTiler {
 public:
  explicit ViewTiler(const std::vector<SceneView>& views);

  // What pixels of the picture show: the plane, and before or behind it points of triangles.
  struct Picture {
    CameraModel camera;  // without distortion
    Rigid3 cam_from_world;
    PlaneInCamera plane;
    std::shared_ptr<const TriangleMesh> triangles;
  };
  // `ends`: a pixel needs none of the views behind `enough` such ones that have it in their images.
  ViewTiles Tile(const std::vector<SceneView>& views, std::span<const int> in_order, const Picture& picture,
                 const std::function<bool(int view)>& ends, int enough = 1);

 private:
  // Of what an image has the slopes x/z and y/z; none where it reaches to the side of the camera.
  struct Slopes {
    Eigen::Vector2d low, high;
  };
  static std::optional<Slopes> SlopesOf(const CameraModel& camera);
  void Surround(const std::shared_ptr<const TriangleMesh>& triangles);

  std::vector<std::optional<Slopes>> slopes_;
  std::shared_ptr<const TriangleMesh> surrounded_;  // held: another may not come to lie where it was
  Eigen::AlignedBox3f box_;                         // of the triangles
};

}  // namespace ulf::render

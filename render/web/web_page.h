// Exports a light field as a page for browsers: a folder that opens by a double click or on any host, without
// a server program (docs/web_page.md).
//
//   OUT/index.html   the page with its help
//   OUT/page.js      its program, bundled from render/web/page/
//   OUT/poster.webp  the picture until the page draws
//   OUT/data/*.js    cameras, blending field, geometry, small and fine pictures, in order of need
//
// Expensive steps are done here: the mesh of the viewpoints with its subdivided weights (MakeFieldMesh),
// geometry of few triangles, photographs without distortion on one scale of light. The page draws as
// GlRenderer does.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "render/scene/scene.h"

namespace ulf::render {

struct WebPageOptions {
  std::string title = {};
  std::size_t budget_bytes = 20'000'000;  // of the whole folder
  int longest_px = 1280;                  // WebPictureOptions::longest_px
  // The picture of a StartingCamera() with zoom 1: 8 bits, B G R and, if parts have no light, alpha. Empty:
  // the page begins without a picture.
  cv::Mat poster = {};
  std::function<void(double share, const std::string& what)> progress = {};  // share: 0 to 1
  std::function<bool()> stop = {};  // polled; if true, the export throws Error and leaves nothing
};

struct WebPageSummary {
  std::size_t views = 0;
  int width = 0, height = 0, quality = 0;  // of the pictures
  std::size_t triangles = 0, triangles_before = 0;
  std::size_t bytes = 0;        // of the folder
  std::size_t first_bytes = 0;  // loaded before the page draws
  std::size_t files = 0;
};

struct LeastWebPage {
  std::size_t views = 0;
  std::size_t bytes = 0;       // with the smallest pictures (kLeastWebPicture)
  std::size_t views_held = 0;  // about how many views fit into a page of `budget_bytes`
};
// Estimates the least size of a light field's page before any photograph or geometry is read.
LeastWebPage LeastPageOf(const LightField& light_field, const SceneOptions& options,
                         std::size_t budget_bytes);

// `scene` has a plane through the subject that faces the camera, or triangles that do not change from picture
// to picture, as its proxy. `out` must not exist, or be an empty folder. Throws Error, and Refusal if the
// budget is too small; then it leaves nothing.
WebPageSummary ExportWebPage(const RenderScene& scene, const std::filesystem::path& out,
                             const WebPageOptions& options);

}  // namespace ulf::render

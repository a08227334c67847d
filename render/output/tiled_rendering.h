// Pictures larger than graphics hardware draws at once, or than its memory holds: in tiles, by cameras whose
// principal points are moved.
#pragma once

#include "render/scene/renderer.h"

namespace ulf::render {

// Width and height of a tile: what every OpenGL 4.5 can draw into fits easily.
inline constexpr int kTilePx = 4096;

Rendering RenderInTiles(Renderer& renderer, const CameraModel& camera, const Rigid3& cam_from_world,
                        int tile_px = kTilePx);

}  // namespace ulf::render

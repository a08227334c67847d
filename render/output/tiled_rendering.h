// Renders pictures that are too large for the graphics hardware in tiles with shifted principal points.
#pragma once

#include "render/renderer/renderer.h"

namespace ulf::render {

// Width and height of a tile in px: a quarter of what every OpenGL 4.5 can draw into.
inline constexpr int kTilePx = 4096;

// Renders as renderer.Render() does; sums counts and times over the tiles.
Rendering RenderInTiles(Renderer& renderer, const CameraModel& camera, const Rigid3& cam_from_world,
                        int tile_px = kTilePx);

}  // namespace ulf::render

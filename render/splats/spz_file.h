// SPZ (nianticlabs/spz), version 2, which all of its readers know: gzip over a header of 16 bytes and streams
// of positions (24 bits, fixed point), alphas, colours, scales, rotations and harmonics (8 bits each). Its
// axes are x right, y up, z back, so that y and z of the world are negated, as Niantic's own converter does
// with a PLY.
#pragma once

#include <string>

#include "render/splats/gaussians.h"

namespace ulf::render {

// Each coordinate of an SPZ must be nearer to the origin than this, in the light field's unit: other programs
// write the format with 12 fractional bits, and farther ones wrap round in silence.
inline constexpr float kSpzRange = 2048;

// Throws Error if a position is beyond the range, or if sizes are outside those that the format holds (4.5e-5
// to 378), so that it would show another scene.
std::string SpzBytes(const Gaussians& gaussians);

}  // namespace ulf::render

// Reads a view's pixels from those of its files that hold them: photograph, master, merged exposures, mask.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/image.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Returns the photograph as stored, or made from its master if it is missing. Throws Error if neither can be
// read, or if it has not its camera's size.
Image ReadRecordedImage(const LightField& light_field, const View& view);
// Does the same for rendering: divided by its camera's flat field and in linear sRGB by its colour profile,
// if there are any (then linear float, three channels). `*clipped` becomes a mask of the pixels of which only
// a lower bound of the light is known (core/image/clipped.h): CV_8UC1, 255 there; empty if there are none.
Image ReadViewImage(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);

// Returns whether the view has a mask, or a photograph with alpha, that may exclude parts of it.
bool HasMask(const LightField& light_field, const View& view);
// Returns CV_8UC1 of the camera's size, 0: excluded by mask or alpha; empty without both. A mask of another
// size is resized (nearest pixel). Throws Error for a mask that is missing or of another aspect ratio.
cv::Mat ReadViewMask(const LightField& light_field, const View& view);

// Returns the master with its transfer and mosaic, or the photograph if there is no master; the black level
// is in the view. A camera's raw file is developed (core/image/files/raw_file.h), cropped to the camera
// model's size. Throws Error as ReadRecordedImage() does.
Image ReadViewMaster(const LightField& light_field, const View& view);

// Returns whether the view has more than 8 bits: merged exposures, a readable master, or a photograph in
// floating point or of 16 bits.
bool HasMoreThanEightBits(const LightField& light_field, const View& view);
// Returns the view's image of highest dynamic range, for rendering: its merged exposures, or else its master
// if ulf reads it, or else its photograph; with flat field, colour profile and `clipped` as in
// ReadViewImage(). A file that cannot be read is a warning, and the next is taken. A raw file with a profile
// is developed by that profile's white balance.
Image ReadViewLight(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);
// Does the same without flat field and colour profile.
Image ReadRecordedLight(const LightField& light_field, const View& view);

}  // namespace ulf

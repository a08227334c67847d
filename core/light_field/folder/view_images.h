// Reads a view's pixels from whichever of its files holds them: photograph, master, light and mask.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/image.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Returns the photograph as stored. Throws Error if it is missing, truncated or not of its camera's size.
Image ReadRecordedImage(const LightField& light_field, const View& view);
// Does the same for rendering: divided by its camera's flat field and in linear sRGB by its colour profile,
// if there is one (then linear float, three channels). `clipped` receives the pixels of which only a lower
// bound of the light is known (core/image/clipped.h): CV_8UC1 of the image's size, 255 there; empty if there
// is none.
Image ReadViewImage(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);

// Returns whether a mask, or the alpha of a PNG, excludes parts of the photograph.
bool HasMask(const LightField& light_field, const View& view);
// Returns CV_8UC1 of the photograph's size, 0: excluded; empty if nothing is. A mask of another size is
// resized (nearest pixel). Throws Error for a mask that is missing or of another aspect ratio.
cv::Mat ReadViewMask(const LightField& light_field, const View& view);

// Returns the master with its transfer and mosaic, or the photograph if there is no master; the black level
// is in the view. A camera's raw file is developed (core/image/files/raw_file.h), cropped to the camera
// model's size. Throws Error as ReadRecordedImage() does.
Image ReadViewMaster(const LightField& light_field, const View& view);

// Returns whether the view has more than 8 bits: a readable master, or a photograph in EXR or of 16 bits.
bool HasMoreThanEightBits(const LightField& light_field, const View& view);
// Returns the view's image of highest dynamic range, for rendering: its merged exposures, or else its master
// if ulf reads it, or else its photograph; with flat field, colour profile and `clipped` as in ReadViewImage.
// A raw file with a profile is developed by that profile's white balance.
Image ReadViewLight(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);

}  // namespace ulf

// Draws an overview picture: a headline, and below it a grid of pictures with captions.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ulf::commands {

struct SheetPanel {
  cv::Mat image;  // CV_8UC3 of any size; scaled into its cell with its aspect ratio kept
  std::string caption;
};

struct ContactSheetLayout {
  int columns = 2;
  int cell_width_px = 640;
  int cell_height_px = 480;
};

// Returns the sheet, CV_8UC3, with the panels row by row. Throws Error if a panel has no image.
cv::Mat ComposeSheet(const std::string& headline, const std::vector<SheetPanel>& panels,
                     const ContactSheetLayout& layout = {});

}  // namespace ulf::commands

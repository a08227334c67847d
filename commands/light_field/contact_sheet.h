// Draws an overview picture: panels with captions below a headline.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ulf::commands {

struct SheetPanel {
  cv::Mat image;  // CV_8UC3, any size and shape; fitted into its cell, never distorted
  std::string caption;
};

struct ContactSheetLayout {
  int columns = 2;
  int cell_width_px = 640;
  int cell_height_px = 480;
};

// Returns CV_8UC3. Throws Error if a panel has no image.
cv::Mat ComposeSheet(const std::string& headline, const std::vector<SheetPanel>& panels,
                     const ContactSheetLayout& layout = {});

}  // namespace ulf::commands

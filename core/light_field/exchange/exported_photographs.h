// Makes the photographs of an export, with their masks and depth maps, as the contents of files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/image/files/exif.h"
#include "core/image/files/stored_picture.h"
#include "core/image/undistortion.h"
#include "core/light_field/exchange/export_options.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Tells where a form of export wants masks: in masks/NAME.png, masks/STEM_mask.png, images/NAME.mask.png, in
// images/dynamic_mask_STEM.png (excluded is not 0), or in the photograph's alpha channel.
enum class MaskPlace { kBeside, kSuffix, kDynamic, kLayer, kAlpha };
// Returns the path of the mask of a photograph of this name in images/; empty for kAlpha.
std::string MaskPathOf(MaskPlace place, const std::string& name);

// Returns the path of a depth map without its ending, depths/STEM, for a photograph at `image_path`.
std::string DepthPathOf(const std::string& image_path);

std::string LowercaseEnding(const std::string& path);  // ".png"

// Returns whether the view's pixels stay where they are; `cameras` as of ExportedPhotographs.
bool StaysAsItIs(const View& view, const std::vector<Undistortion>& cameras, const ExportOptions& options);
// Returns whether the photograph is copied, but for its Exif data, if its pixels stay where they are.
bool IsCopied(const LightField& light_field, const View& view, bool stays, const ExportOptions& options);
// Returns the ending of the exported photograph's name.
std::string EndingInExport(const LightField& light_field, const View& view, bool stays,
                           const ExportOptions& options);

struct ExportedFiles {
  std::vector<std::pair<std::filesystem::path, std::string>> contents;  // the photograph's first
  bool copied = false;                                                  // its pixels are the original's
  bool has_mask = false;
  std::optional<ExifFacts> exposure = {};  // that it says, as was asked
  StoredPicture stored = {};               // facts of a copied picture, without its pixels
  DepthSummary depths = {};
};

class ExportedPhotographs {
 public:
  // `to` is `from` as it is exported: the same views, with paths below `folder`. `cameras` are by index, or
  // empty if nothing is undistorted. All must outlive it.
  ExportedPhotographs(const LightField& from, const LightField& to, const std::vector<Undistortion>& cameras,
                      MaskPlace masks, const ExportOptions& options, const std::filesystem::path& folder);
  // Returns the files of the view at this index. Several threads may call it. Throws Error if the photograph
  // cannot be read.
  ExportedFiles Of(std::size_t index) const;

 private:
  // A view, and how its pixels move.
  struct Task {
    const View &view, &exported;
    UndistortionMap map;  // empty: they stay
  };
  UndistortionMap MapFor(const View& view, const View& exported) const;
  ExportedFiles PhotographOf(const Task& task) const;
  ExportedFiles CopyOf(const Task& task) const;
  std::string Made(const Task& task, const ExifFacts& exposure) const;
  std::string AsItIs(const Task& task) const;
  std::string AsExr(const Task& task, const ExifFacts& exposure) const;
  cv::Mat EightBits(const Task& task) const;  // sRGB
  cv::Mat LinearLight(const Task& task) const;
  ExifFacts ExposureOf(const View& view) const;
  cv::Mat MaskFor(const Task& task) const;
  void AddDepth(const Task& task, const cv::Mat& mask, ExportedFiles& files) const;

  const LightField &from_, &to_;
  const std::vector<Undistortion>& cameras_;
  const MaskPlace masks_;
  const ExportOptions& options_;
  const std::filesystem::path folder_;
  const bool knows_gains_;
  std::vector<UndistortionMap> maps_;
};

}  // namespace ulf

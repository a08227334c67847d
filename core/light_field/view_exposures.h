// The files of a view and of its other exposures (`ulf capture --bracket`). docs/disk_format.md describes them.
#pragma once

#include <set>
#include <string>

#include "core/light_field/light_field.h"

namespace ulf {

inline constexpr const char* kExposuresFolder = "exposures";
inline constexpr const char* kMergedFolder = "merged";
// Of merged/*.exr, besides R, G and B: 1 where no exposure tells the light; 1 where an exposure is left out.
inline constexpr const char* kClippedChannel = "clipped";
inline constexpr const char* kGhostsChannel = "ghosts";

// exposures/000012-2 for the second one of view 12, without an ending; the master's is 000012-2.master.
std::string ExposureName(int view_id, std::size_t number);
// merged/000012.exr
std::string MergedPath(int view_id);

// All files that belong to a view alone, relative to the light field; not its mask.
std::set<std::string> FilesOf(const View& view);

// The exposure as a photograph of its own, for ReadViewMaster(): with the view's camera and id, the pose where it was taken.
View PhotographOf(const View& view, const ViewExposure& exposure);

}  // namespace ulf

// The depth maps of a light field's views on disk: DIR/depth/, a 16-bit PNG for each (1 / depth along the optical axis,
// in units of its own) and maps.json, which says whose they are, by which camera, in which unit, how uncertain, and
// which pose the view had. docs/disk_format.md describes it.
//
// maps.json is written last and names what counts; a kill at any moment leaves the maps of before or the new ones.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>

#include "core/light_field/light_field.h"
#include "render/proxy/soft_proxy.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

inline constexpr char kDepthMapsFolder[] = "depth";

// `maps`: by View::id. Replaces the maps that `light_field` has. Throws DiskFullError, Error.
void WriteDepthMaps(const std::filesystem::path& light_field_folder, const LightField& light_field,
                    const std::map<int, ViewDepthMap>& maps);

bool HasDepthMaps(const std::filesystem::path& light_field_folder);

struct DepthMapReading {
  SoftProxy::Maps
      maps;  // read when they are needed; of one that cannot be read then, the mesh's stands in (a warning)
  std::size_t stale = 0;  // maps of views that are gone, or have another pose or camera now
};
// Throws Error for a maps.json that is no such file.
DepthMapReading ReadDepthMaps(const std::filesystem::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh);

}  // namespace ulf::render

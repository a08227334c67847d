// Proxies by name, as on the command line.
//   plane            through the subject, facing the virtual camera
//   plane:x,y,z,d    the points p of the world with (x, y, z) . p = d
//   points           the tracked points of the light field, triangulated in each picture
//   mesh             DIR/proxy.ply, which `ulf proxy DIR` makes
//   FILE.ply, .obj   a mesh made elsewhere, in the light field's frame
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/proxy/proxy.h"

namespace ulf::render {

inline constexpr char kMeshProxyFile[] = "proxy.ply";

// What geometry the light field brings itself, simplest first: points, mesh, both or none.
std::vector<std::string> OwnProxies(const std::filesystem::path& light_field);

// Says on the log what a mesh file holds. UsageError for a name that is none, Error for a file that is not to
// be had.
std::shared_ptr<const Proxy> ProxyFromName(const std::string& name, const Subject& subject,
                                           const std::filesystem::path& light_field);

// The plane and what the light field brings itself, simplest first. Throws as ProxyFromName().
std::vector<std::shared_ptr<const Proxy>> EveryProxyOf(const std::filesystem::path& light_field,
                                                       const Subject& subject);

}  // namespace ulf::render

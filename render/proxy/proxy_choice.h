// Proxies by name, as on the command line.
//
//   plane            through the subject, facing the virtual camera
//   plane:0.9        the same at nine tenths of the subject's distance
//   plane:x,y,z,d    the points p of the world with (x, y, z) . p = d
//   planes           the few planes on which most of the tracked points lie
//   points           the tracked points of the light field, triangulated in each picture
//   mesh             DIR/proxy.ply, which `ulf proxy DIR` makes
//   soft             the same mesh and DIR/depth, the views' depth maps beside it
//   FILE.ply, .obj   a mesh of another program, in the light field's frame
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/proxy/proxy.h"

namespace ulf::render {

// Is fitted to photographs that are left out (render/quality/choice.h), not made by its name.
inline constexpr char kFittedPlane[] = "plane:fitted";

// The names of the geometry that the light field itself has, simplest first: planes, points, and mesh or,
// where it has depth maps as well, soft. Warns of a mesh that cannot be read, and leaves it out.
std::vector<std::string> OwnProxies(const std::filesystem::path& light_field);

// Logs what a mesh file holds. Throws Refusal for a name that does not exist, Error for a file that cannot
// be read.
std::shared_ptr<const Proxy> ProxyFromName(const std::string& name, const Subject& subject,
                                           const std::filesystem::path& light_field);

// The names of OwnProxies() and of the plane, the most geometry first: where nothing is compared, the first
// that can be drawn is taken.
std::vector<std::string> DefaultProxies(const std::filesystem::path& light_field);

// ProxyFromName() of one of OwnProxies(); where the depth maps cannot be used, the mesh alone,
// with a warning.
std::shared_ptr<const Proxy> OwnProxy(const std::string& name, const Subject& subject,
                                      const std::filesystem::path& light_field);

// The plane and OwnProxies(), simplest first. Throws as ProxyFromName().
std::vector<std::shared_ptr<const Proxy>> EveryProxyOf(const std::filesystem::path& light_field,
                                                       const Subject& subject);

}  // namespace ulf::render

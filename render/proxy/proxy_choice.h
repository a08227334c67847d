// Makes proxies by their names on the command line.
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

// This plane is fitted to left-out photographs (render/quality/choice.h), not made by its name.
inline constexpr char kFittedPlane[] = "plane:fitted";

// Returns the names of the light field's own geometry, simplest first: planes, points, and mesh or, if it has
// depth maps as well, soft. Warns of a mesh that cannot be read, and leaves it out.
std::vector<std::string> OwnProxies(const std::filesystem::path& light_field);

// Logs what a mesh file holds. Throws Refusal for an unknown name, Error for a file that cannot be read, or
// that is in another world (mesh_world.h).
std::shared_ptr<const Proxy> ProxyFromName(const std::string& name, const Subject& subject,
                                           const std::filesystem::path& light_field);

// Returns the names of OwnProxies() and of the plane, the most detailed geometry first: without a comparison,
// the first that can be drawn is used.
std::vector<std::string> DefaultProxies(const std::filesystem::path& light_field);

// Makes one of DefaultProxies(); if the depth maps cannot be used, the mesh alone, with a warning.
std::shared_ptr<const Proxy> OwnProxy(const std::string& name, const Subject& subject,
                                      const std::filesystem::path& light_field);

// Returns the plane and OwnProxies(), simplest first. Throws as ProxyFromName() does.
std::vector<std::shared_ptr<const Proxy>> EveryProxyOf(const std::filesystem::path& light_field,
                                                       const Subject& subject);

}  // namespace ulf::render

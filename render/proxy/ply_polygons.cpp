// Meshes in Stanford PLY: reads the properties x y z of "vertex" and the list vertex_indices (or
// vertex_index) of "face", and ignores everything else.
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/light_field/points/ply_reader.h"
#include "render/proxy/polygon_soup.h"

namespace ulf::render {
namespace {

// Replaces an index that no vertex can have.
constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

void ReadVertices(const ply::Element& element, ply::Body& body, PolygonSoup& soup) {
  soup.vertices.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    for (const ply::Property& property : element.properties) {
      if (property.count_type) {
        const double count = body.Next(*property.count_type);
        for (double k = 0; k < count; ++k) body.Next(property.type);
        continue;
      }
      const float value = static_cast<float>(body.Next(property.type));
      if (property.name == "x") position.x() = value;
      if (property.name == "y") position.y() = value;
      if (property.name == "z") position.z() = value;
    }
    soup.vertices.push_back(position);
  }
}

void ReadFaces(const ply::Element& element, const std::string& name, ply::Body& body, PolygonSoup& soup) {
  soup.sizes.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i)
    for (const ply::Property& property : element.properties) {
      const double count = body.Count(property);
      if (!(count >= 0 && count == std::floor(count)))
        throw Error("{}: a face with {} corners; the file is damaged", name, count);
      const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
      for (double k = 0; k < count; ++k) {
        const double index = body.Next(property.type);
        if (!corners) continue;
        const bool fits = index >= 0 && index < kNoVertex;
        soup.corners.push_back(fits ? static_cast<std::uint32_t>(index) : kNoVertex);
      }
      if (corners) soup.sizes.push_back(static_cast<std::uint32_t>(count));
    }
}

}  // namespace

PolygonSoup PolygonsFromPly(const std::string& bytes, const std::string& name) {
  const ply::Header header = ply::ParseHeader(bytes, name);
  ply::Body body(bytes, header, name);
  PolygonSoup soup;
  for (const ply::Element& element : header.elements) {
    body.Require(element);
    if (element.name == "vertex")
      ReadVertices(element, body, soup);
    else if (element.name == "face")
      ReadFaces(element, name, body, soup);
    else
      body.Skip(element);
  }
  for (const std::uint32_t corner : soup.corners)
    if (corner >= soup.vertices.size())
      throw Error("{}: a face names a vertex that does not exist (there are {}); the file is damaged", name,
                  soup.vertices.size());
  return soup;
}

}  // namespace ulf::render

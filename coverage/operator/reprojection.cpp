#include "coverage/operator/reprojection.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace ulf {
namespace {

constexpr std::size_t kMostUploaded = 64;
constexpr int kColumns = 24, kRows = 18;  // of the grid
constexpr int kFloatsAVertex = 5;

constexpr const char* kHead = "#version 450 core\n";
constexpr const char* kAddVertex = R"(
layout(std430, binding = 0) readonly buffer Vertices { float value[]; };
out vec2 uv;
flat out float weight;
void main() {
  int at = gl_VertexID * 5;
  gl_Position = vec4(value[at], value[at + 1], 0.0, 1.0);
  uv = vec2(value[at + 2], value[at + 3]);
  weight = value[at + 4];
}
)";
// A picture fades over the last 3 % of its sides, as in the renderers.
constexpr const char* kAddFragment = R"(
layout(binding = 0) uniform sampler2D picture;
in vec2 uv;
flat in float weight;
out vec4 sum;
void main() {
  vec2 to_edge = min(uv, 1.0 - uv);
  float edge = min(to_edge.x, to_edge.y);
  if (edge <= 0.0) discard;
  float w = weight * min(1.0, edge / 0.03);
  sum = vec4(texture(picture, uv).rgb * w, w);
}
)";
constexpr const char* kWholeScreen = R"(
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }
)";
constexpr const char* kNormaliseFragment = R"(
layout(binding = 0) uniform sampler2D sums;
out vec4 color;
void main() {
  vec4 sum = texelFetch(sums, ivec2(gl_FragCoord.xy), 0);
  vec3 light = sum.rgb / max(sum.a, 1e-4);
  vec3 shown = mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light));
  color = sum.a > 1e-4 ? vec4(shown, 1.0) : vec4(0.0);
}
)";

// Where a grid over the output lies in the world.
struct Grid {
  std::array<Eigen::Vector3d, (kColumns + 1) * (kRows + 1)> in_world;
  std::array<bool, (kColumns + 1) * (kRows + 1)> is_there{};
  static std::size_t At(int column, int row) {
    return static_cast<std::size_t>(row * (kColumns + 1) + column);
  }
};

Grid OnPlane(const CameraModel& camera, const Rigid3& cam_from_world, double depth) {
  Grid grid;
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  for (int row = 0; row <= kRows; ++row)
    for (int column = 0; column <= kColumns; ++column) {
      const auto ray = camera.RayFromImg({static_cast<double>(camera.width) * column / kColumns,
                                          static_cast<double>(camera.height) * row / kRows});
      const std::size_t at = Grid::At(column, row);
      if (!ray || !(ray->z() > 1e-6)) continue;
      grid.is_there[at] = true;
      grid.in_world[at] = world_from_cam * (depth / ray->z() * *ray);
    }
  return grid;
}

}  // namespace

Reprojection::Reprojection() : sum_(GL_RGBA16F), result_(GL_RGBA8) {
  const std::string head = kHead;
  add_.Build("reprojection", head + kAddVertex, head + kAddFragment);
  normalise_.Build("reprojection's weights", head + kWholeScreen, head + kNormaliseFragment);
}

Reprojection::~Reprojection() {
  for (const Uploaded& uploaded : uploaded_) glDeleteTextures(1, &uploaded.texture);
  add_.Release();
  normalise_.Release();
  vertices_.Release();
  no_attributes_.Release();
  sum_.Release();
  result_.Release();
}

unsigned Reprojection::TextureOf(const PosedPicture& picture) {
  const auto found = std::find_if(uploaded_.begin(), uploaded_.end(),
                                  [&](const Uploaded& uploaded) { return uploaded.key == picture.key; });
  if (found != uploaded_.end()) {
    uploaded_.splice(uploaded_.begin(), uploaded_, found);
    return found->texture;
  }
  if (uploaded_.size() >= kMostUploaded) {
    glDeleteTextures(1, &uploaded_.back().texture);
    uploaded_.pop_back();
  }
  cv::Mat pixels;
  cv::cvtColor(picture.Srgb8(), pixels, cv::COLOR_BGR2RGBA);
  unsigned texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, GL_SRGB8_ALPHA8, pixels.cols, pixels.rows);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(texture, 0, 0, 0, pixels.cols, pixels.rows, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data);
  uploaded_.push_front({picture.key, texture});
  return texture;
}

unsigned Reprojection::Draw(const CameraModel& camera, const Rigid3& cam_from_world,
                            const Eigen::Vector3d& on_plane, const std::vector<WeightedPicture>& pictures) {
  std::vector<float> vertices;
  std::vector<std::pair<unsigned, std::pair<int, int>>> draws;  // texture; first vertex, count
  const double depth = (cam_from_world * on_plane).z();
  const Grid grid = depth > 0 ? OnPlane(camera, cam_from_world, depth) : Grid{};
  std::array<std::optional<Eigen::Vector2d>, (kColumns + 1) * (kRows + 1)> img;
  for (const WeightedPicture& use : pictures) {
    const PosedPicture& picture = *use.picture;
    for (std::size_t i = 0; i < img.size(); ++i)
      img[i] = grid.is_there[i] ? picture.camera.ImgFromCam(picture.cam_from_world * grid.in_world[i])
                                : std::nullopt;
    const int first = static_cast<int>(vertices.size()) / kFloatsAVertex;
    const auto add = [&](int column, int row) {
      const Eigen::Vector2d& at = *img[Grid::At(column, row)];
      // Row 0 of the target is the picture's top.
      vertices.insert(vertices.end(), {2.0f * static_cast<float>(column) / kColumns - 1,
                                       2.0f * static_cast<float>(row) / kRows - 1,
                                       static_cast<float>(at.x() / picture.camera.width),
                                       static_cast<float>(at.y() / picture.camera.height), use.weight});
    };
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) {
        const std::array corners{Grid::At(column, row), Grid::At(column + 1, row), Grid::At(column, row + 1),
                                 Grid::At(column + 1, row + 1)};
        if (!std::all_of(corners.begin(), corners.end(), [&](std::size_t at) { return img[at].has_value(); }))
          continue;
        add(column, row), add(column + 1, row), add(column, row + 1);
        add(column + 1, row), add(column + 1, row + 1), add(column, row + 1);
      }
    const int count = static_cast<int>(vertices.size()) / kFloatsAVertex - first;
    if (count > 0) draws.push_back({TextureOf(picture), {first, count}});
  }

  sum_.Resize(camera.width, camera.height);
  result_.Resize(camera.width, camera.height);
  glTextureParameteri(result_.texture(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(result_.texture(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  no_attributes_.Bind();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  sum_.Bind();
  sum_.Clear(0);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  add_.Use();
  vertices_.Upload(vertices);
  vertices_.BindStorage(0);
  for (const auto& [texture, range] : draws) {
    glBindTextureUnit(0, texture);
    glDrawArrays(GL_TRIANGLES, range.first, range.second);
  }
  glDisable(GL_BLEND);
  result_.Bind();
  normalise_.Use();
  sum_.BindTexture(0);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  CheckGl("reprojecting pictures");
  return result_.texture();
}

cv::Mat Reprojection::Read() const {
  cv::Mat picture;
  cv::cvtColor(result_.Read(), picture, cv::COLOR_BGRA2BGR);
  picture.convertTo(picture, CV_8UC3, 255);
  return picture;
}

}  // namespace ulf

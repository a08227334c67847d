#include "coverage/operator/reprojection.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace ulf::coverage {
namespace {

constexpr std::size_t kMostUploaded = 64;
constexpr int kColumns = 24, kRows = 18;  // of the grid
constexpr std::size_t kNodes = (kColumns + 1) * (kRows + 1);

constexpr const char* kHead = "#version 450 core\n";
// Several pictures in one pass: in a software rasteriser, blending into the target costs more than sampling.
constexpr int kPicturesAPass = 4, kFloatsAVertex = 2 + 2 * kPicturesAPass;
constexpr const char* kAddVertex = R"(
layout(std430, binding = 0) readonly buffer Vertices { float value[]; };
out vec4 uv01, uv23;
void main() {
  int at = gl_VertexID * 10;
  gl_Position = vec4(value[at], value[at + 1], 0.0, 1.0);
  uv01 = vec4(value[at + 2], value[at + 3], value[at + 4], value[at + 5]);
  uv23 = vec4(value[at + 6], value[at + 7], value[at + 8], value[at + 9]);
}
)";
// A picture fades over the last 3 % of its sides, as in the renderers. Linear light is approximated by the
// square of the pixel's value, which is good enough for a preview.
constexpr const char* kAddFragment = R"(
layout(binding = 0) uniform sampler2D photographs[4];
uniform vec4 weights;
in vec4 uv01, uv23;
out vec4 sum;
vec4 light(vec4 shown, vec2 uv, float weight) {
  vec2 to_edge = min(uv, 1.0 - uv);
  float w = weight * clamp(min(to_edge.x, to_edge.y) * (1.0 / 0.03), 0.0, 1.0);
  return vec4(shown.rgb * shown.rgb * w, w);
}
void main() {
  sum = light(texture(photographs[0], uv01.xy), uv01.xy, weights.x) +
        light(texture(photographs[1], uv01.zw), uv01.zw, weights.y) +
        light(texture(photographs[2], uv23.xy), uv23.xy, weights.z) +
        light(texture(photographs[3], uv23.zw), uv23.zw, weights.w);
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
  color = sum.a > 1e-4 ? vec4(sqrt(sum.rgb / sum.a), 1.0) : vec4(0.0);
}
)";

// Describes where a grid over the output lies in the world.
struct Grid {
  std::array<Eigen::Vector3d, kNodes> in_world;
  std::array<bool, kNodes> is_there{};
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

Reprojection::Reprojection() : sum_(GL_RGBA32F), result_(GL_RGBA8) {
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
  const auto found =
      std::ranges::find_if(uploaded_, [&](const Uploaded& uploaded) { return uploaded.key == picture.key; });
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
  glTextureStorage2D(texture, 1, GL_RGBA8, pixels.cols, pixels.rows);
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
  const double depth = (cam_from_world * on_plane).z();
  const Grid grid = depth > 0 ? OnPlane(camera, cam_from_world, depth) : Grid{};
  // Texture coordinates by picture and node of the grid, as shares of the picture's width and height.
  const Eigen::Vector2f kNowhere(-10, -10);
  std::vector<std::array<Eigen::Vector2f, kNodes>> uv(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const PosedPicture& picture = *pictures[i].picture;
    for (std::size_t at = 0; at < kNodes; ++at) {
      const auto img = grid.is_there[at]
                           ? picture.camera.ImgFromCam(picture.cam_from_world * grid.in_world[at])
                           : std::nullopt;
      uv[i][at] =
          img ? Eigen::Vector2f(img->x() / picture.camera.width, img->y() / picture.camera.height) : kNowhere;
    }
  }
  struct Pass {
    std::array<unsigned, kPicturesAPass> textures{};
    std::array<float, kPicturesAPass> weights{};
  };
  std::vector<Pass> passes;
  std::vector<float> vertices;
  constexpr int kVerticesAPass = 6 * kColumns * kRows;
  for (std::size_t first = 0; first < pictures.size(); first += kPicturesAPass) {
    const std::size_t count = std::min<std::size_t>(kPicturesAPass, pictures.size() - first);
    Pass& pass = passes.emplace_back();
    for (std::size_t i = 0; i < kPicturesAPass; ++i) {
      pass.textures[i] = TextureOf(*pictures[first + std::min(i, count - 1)].picture);
      pass.weights[i] = i < count ? pictures[first + i].weight : 0;
    }
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) {
        // A picture that shows only a part of a cell is not drawn there.
        std::array<bool, kPicturesAPass> whole{};
        for (std::size_t i = 0; i < count; ++i) {
          const auto& nodes = uv[first + i];
          whole[i] = nodes[Grid::At(column, row)] != kNowhere &&
                     nodes[Grid::At(column + 1, row)] != kNowhere &&
                     nodes[Grid::At(column, row + 1)] != kNowhere &&
                     nodes[Grid::At(column + 1, row + 1)] != kNowhere;
        }
        const auto add = [&](int at_column, int at_row) {
          // Row 0 of the target is the picture's top.
          vertices.push_back(2.0f * static_cast<float>(at_column) / kColumns - 1);
          vertices.push_back(2.0f * static_cast<float>(at_row) / kRows - 1);
          for (std::size_t i = 0; i < kPicturesAPass; ++i) {
            const Eigen::Vector2f at = whole[i] ? uv[first + i][Grid::At(at_column, at_row)] : kNowhere;
            vertices.push_back(at.x());
            vertices.push_back(at.y());
          }
        };
        add(column, row), add(column + 1, row), add(column, row + 1);
        add(column + 1, row), add(column + 1, row + 1), add(column, row + 1);
      }
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
  for (std::size_t i = 0; i < passes.size(); ++i) {
    for (unsigned unit = 0; unit < kPicturesAPass; ++unit) glBindTextureUnit(unit, passes[i].textures[unit]);
    add_.Set("weights", passes[i].weights);
    glDrawArrays(GL_TRIANGLES, static_cast<int>(i) * kVerticesAPass, kVerticesAPass);
  }
  glDisable(GL_BLEND);
  result_.Bind();
  normalise_.Use();
  sum_.BindTexture(0);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  render::CheckGl("reprojecting pictures");
  return result_.texture();
}

cv::Mat Reprojection::Read() const {
  cv::Mat picture;
  cv::cvtColor(result_.Read(), picture, cv::COLOR_BGRA2BGR);
  picture.convertTo(picture, CV_8UC3, 255);
  return picture;
}

}  // namespace ulf::coverage

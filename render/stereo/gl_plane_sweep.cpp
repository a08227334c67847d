#include "render/stereo/gl_plane_sweep.h"

#include <epoxy/gl.h>
#include <fmt/core.h>

#include <algorithm>

#include "core/base/at.h"
#include "render/gl/embedded_shaders.h"

namespace ulf::render {
namespace {

// Grey images as layers of one texture, each in its upper left corner.
class GreyLayers {
 public:
  explicit GreyLayers(const std::vector<const StereoView*>& views) {
    int width = 1, height = 1;
    for (const StereoView* view : views) {
      width = std::max(width, view->grey.cols);
      height = std::max(height, view->grey.rows);
    }
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture_);
    glTextureStorage3D(texture_, 1, GL_R32F, width, height, static_cast<GLsizei>(views.size()));
    for (std::size_t i = 0; i < views.size(); ++i) {
      const cv::Mat grey = views[i]->grey.isContinuous() ? views[i]->grey : views[i]->grey.clone();
      glTextureSubImage3D(texture_, 0, 0, 0, static_cast<GLint>(i), grey.cols, grey.rows, 1, GL_RED, GL_FLOAT,
                          grey.data);
    }
    // Without filtering: an image smaller than the texture must not blend with the texels beside it.
    SetSampling(texture_, GL_NEAREST);
    CheckGl("uploading the pictures to compare");
  }
  ~GreyLayers() { glDeleteTextures(1, &texture_); }
  GreyLayers(const GreyLayers&) = delete;
  GreyLayers& operator=(const GreyLayers&) = delete;
  void Bind(unsigned unit) const { glBindTextureUnit(unit, texture_); }

 private:
  unsigned texture_ = 0;
};

struct CarrierTexels {
  std::array<float, 16> values;
};

CarrierTexels TexelsOf(const PlaneCarrier& carrier, const cv::Mat& grey) {
  CarrierTexels texels{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      texels.values[static_cast<std::size_t>(4 * row + column)] = carrier.at_infinity(row, column);
    texels.values[static_cast<std::size_t>(4 * row + 3)] = carrier.per_inverse_depth(row);
  }
  texels.values[12] = static_cast<float>(grey.cols);
  texels.values[13] = static_cast<float>(grey.rows);
  return texels;
}

constexpr int kPlanesAtOnce = 4;  // the channels of a target

}  // namespace

const unsigned GlPlaneSweep::kCostsFormat = GL_RGBA32F;

GlPlaneSweep::~GlPlaneSweep() {
  const GlContext::Current current(context_);
  program_.Release();
  no_vertices_.Release();
  carriers_.Release();
  costs_.Release();
}

bool GlPlaneSweep::IsSoftware() const { return context_.IsSoftware(); }

CostVolume GlPlaneSweep::MatchingCosts(const StereoView& view,
                                       const std::vector<const StereoView*>& neighbours,
                                       const InverseDepthRange& range, const SweepOptions& options) {
  const GlContext::Current current(context_);
  const Shape shape{std::clamp(options.window_radius_px, 1, 3), static_cast<int>(neighbours.size())};
  if (shape != built_) {
    program_.Release();
    program_.Build(
        "sweep", std::string("#version 450 core\n") + shaders::k_fullscreen_vert,
        fmt::format("#version 450 core\n#define RADIUS {}\n#define NEIGHBOURS {}\n#define KEEP {}\n{}",
                    shape.radius, shape.neighbours, KeptNeighbours(neighbours.size()),
                    shaders::k_sweep_frag));
    built_ = shape;
  }
  const GreyLayers own({&view}), others(neighbours);
  std::vector<CarrierTexels> carriers;
  for (const StereoView* neighbour : neighbours)
    carriers.push_back(TexelsOf(MakePlaneCarrier(view, *neighbour), neighbour->grey));
  carriers_.Upload(carriers);
  costs_.Resize(view.grey.cols, view.grey.rows);
  costs_.Bind();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  program_.Use();
  program_.Set("noise_floor", static_cast<float>(options.noise * options.noise * (2 * shape.radius + 1) *
                                                 (2 * shape.radius + 1)));
  program_.Set("truncation", static_cast<float>(options.truncation));
  own.Bind(0);
  others.Bind(1);
  carriers_.Bind(2);
  no_vertices_.Bind();
  CostVolume volume(view.grey.cols, view.grey.rows, range.planes);
  for (int first = 0; first < range.planes; first += kPlanesAtOnce) {
    std::array<float, 4> inverse_depths{};
    for (int k = 0; k < kPlanesAtOnce; ++k) inverse_depths[At(k)] = static_cast<float>(range.At(first + k));
    program_.Set("inverse_depths", inverse_depths);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    const cv::Mat costs = costs_.Read();
    constexpr std::array<int, kPlanesAtOnce> kChannel{2, 1, 0, 3};  // read as blue, green, red, alpha
    const int planes = std::min(kPlanesAtOnce, range.planes - first);
    for (int y = 0; y < costs.rows; ++y) {
      const float* row = costs.ptr<float>(y);
      std::uint8_t* out = volume.At(0, y) + first;
      for (int x = 0; x < costs.cols; ++x, row += 4, out += volume.stride())
        for (int k = 0; k < planes; ++k) out[k] = CostByte(row[kChannel[At(k)]]);
    }
  }
  CheckGl("sweeping planes");
  return volume;
}

}  // namespace ulf::render

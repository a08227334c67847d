#include "render/stereo/gl_plane_sweep.h"

#include <epoxy/gl.h>
#include <fmt/core.h>

#include <algorithm>

#include "core/base/at.h"
#include "core/base/error.h"
#include "render/gl/embedded_shaders.h"

namespace ulf::render {
namespace {

std::string SmallerPictures() {
  return fmt::format("compare smaller pictures ({}), or use {} reference", Parameter("size"),
                     Parameter("renderer"));
}

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
    // Sampling is unfiltered: an image smaller than the texture must not blend with the texels beside it.
    SetSampling(texture_, GL_NEAREST);
    try {
      CheckGl("uploading the pictures to compare", SmallerPictures);
    } catch (const Error&) {
      glDeleteTextures(1, &texture_);
      throw;
    }
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

constexpr int kGroupPx = 8;  // sides of a work group (sweep.comp)

}  // namespace

GlPlaneSweep::~GlPlaneSweep() {
  const GlContext::Current current(context_);
  program_.Release();
  carriers_.Release();
  inverse_depths_.Release();
  costs_.Release();
}

CostVolume GlPlaneSweep::MatchingCosts(const StereoView& view,
                                       const std::vector<const StereoView*>& neighbours,
                                       const InverseDepthRange& range, const SweepOptions& options) {
  const GlContext::Current current(context_);
  const Shape shape{std::clamp(options.window_radius_px, 1, 3), static_cast<int>(neighbours.size())};
  if (shape != built_) {
    program_.Release();
    program_.BuildCompute(
        "sweep", fmt::format("#version 450 core\n#define RADIUS {}\n#define NEIGHBOURS {}\n#define KEEP {}\n"
                             "#define COST_UNIT {:.9e}\n{}",
                             shape.radius, shape.neighbours, KeptNeighbours(neighbours.size()), kCostUnit,
                             shaders::k_sweep_comp));
    built_ = shape;
  }
  const GreyLayers own({&view}), others(neighbours);
  std::vector<CarrierTexels> carriers;
  for (const StereoView* neighbour : neighbours)
    carriers.push_back(TexelsOf(MakePlaneCarrier(view, *neighbour), neighbour->grey));
  carriers_.Upload(carriers);
  std::vector<float> inverse_depths;
  for (int plane = 0; plane < range.planes; ++plane)
    inverse_depths.push_back(static_cast<float>(range.At(plane)));
  inverse_depths_.Upload(inverse_depths);
  program_.Use();
  program_.Set("noise_floor", static_cast<float>(options.noise * options.noise * (2 * shape.radius + 1) *
                                                 (2 * shape.radius + 1)));
  program_.Set("truncation", static_cast<float>(options.truncation));
  own.Bind(0);
  others.Bind(1);
  carriers_.Bind(2);
  inverse_depths_.BindStorage(2);
  CostVolume volume(view.grey.cols, view.grey.rows, range.planes);
  const std::size_t row_bytes = At(volume.width()) * volume.stride();
  const int band = std::clamp(static_cast<int>(band_bytes_ / row_bytes), 1, volume.height());
  const auto quads = static_cast<int>(volume.stride() / 4);
  program_.Set("planes", range.planes);
  program_.Set("quads", quads);
  for (int first = 0; first < volume.height(); first += band) {
    const int end = std::min(first + band, volume.height());
    // The buffer is allocated anew for each band: on NVIDIA's driver 580 one that was read back gave wrong
    // costs the second time.
    costs_.Reserve(At(end - first) * row_bytes);
    CheckGl("making room for what is compared", SmallerPictures);  // before a shader writes into it
    costs_.BindStorage(3);
    program_.Set("first_row", first);
    program_.Set("end_row", end);
    const auto groups = [](int px) { return static_cast<GLuint>((px + kGroupPx - 1) / kGroupPx); };
    glDispatchCompute(groups(volume.width()), groups(end - first), static_cast<GLuint>(quads));
    costs_.ReadBytes(volume.At(0, first), At(end - first) * row_bytes);
  }
  CheckGl("sweeping planes", SmallerPictures);
  return volume;
}

}  // namespace ulf::render

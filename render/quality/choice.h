// Which blending field and which proxy a light field deserves, by evidence: a few views are left out,
// rendered small from the others, and compared with their photographs. The first, in an order of preference,
// that is within a margin of the best is taken. A mesh that was built from all views knows the left-out ones,
// too, and scores a little too well.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "render/fields/blending_field.h"
#include "render/proxy/proxy.h"
#include "render/scene/renderer.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ScoredChoice {
  FieldOptions field;
  std::shared_ptr<const Proxy> proxy;
  double psnr_db = 0;  // mean over the left-out views
};

struct Choice {
  FieldOptions field;
  std::shared_ptr<const Proxy> proxy;
  std::vector<ScoredChoice> candidates;  // none where there was nothing to choose
  std::string why;                       // one line for people
  std::vector<ModelChoice> explained;    // of the proxy, and of the field
};

inline constexpr char kAuto[] = "auto";
inline constexpr double kPreferredWithinDb = 0.3;
inline constexpr int kLeastViewsToCompare = 10;
inline constexpr int kChoiceViews = 8;     // left out, evenly through the light field
inline constexpr int kChoiceSizePx = 320;  // longer side of the pictures

// The first of the candidates, of which there is one at least, that is within kPreferredWithinDb of the best.
const ScoredChoice& FirstWithinTolerance(const std::vector<ScoredChoice>& candidates);

// `fields` and `proxies`: in order of preference, proxies the simplest first. Every proxy is tried with the
// first field, then every field with the proxy that was chosen: what geometry brings is more than what
// weights bring. Fewer than ten views are too few to leave some out: then it is lumigraph weights, where they
// are among the fields, which do not smooth over the little there is, and the last proxy, the one that knows
// most. Lumigraph weights serve as well where the viewpoints span no surface.
Choice ChooseByEvidence(const RenderScene& scene, const std::vector<FieldOptions>& fields,
                        const std::vector<std::shared_ptr<const Proxy>>& proxies, RendererKind renderer);

// What a command line asks for: "auto" leaves the choice of subdivision (with `level`), linear, subdivision
// in the limit, and lumigraph weights to the evidence, and that of the plane and of the light field's own
// points and mesh where it has them. Subdivision comes first for being the calmest in motion, which views
// that stand still do not tell; then what costs less.
Choice ChooseByName(const RenderScene& scene, const std::string& field, const FieldOptions& details,
                    const std::string& proxy, const std::filesystem::path& light_field,
                    RendererKind renderer);

}  // namespace ulf::render

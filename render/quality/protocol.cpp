#include "render/quality/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <set>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/light_field/exchange/subject_of_set.h"
#include "core/light_field/points/point_tracks.h"
#include "render/quality/quality.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

constexpr int kLlffEvery = 8;

std::vector<int> ByName(const LightField& light_field) {
  std::vector<int> order(light_field.views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    return light_field.views[At(a)].image_path < light_field.views[At(b)].image_path;
  });
  return order;
}

void SplitEvery(const LightField& light_field, int every, ProtocolSplit& split) {
  const std::vector<int> order = ByName(light_field);
  for (std::size_t i = 0; i < order.size(); ++i)
    (i % At(every) == 0 ? split.test : split.given).push_back(order[i]);
}

void SplitByFolder(const LightField& light_field, ProtocolSplit& split) {
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    const std::string& path = light_field.views[i].image_path;
    if (path.starts_with("images/test/")) split.test.push_back(static_cast<int>(i));
    if (path.starts_with("images/train/")) split.given.push_back(static_cast<int>(i));
  }
  if (split.test.empty() || split.given.empty())
    throw Refusal(
        Parameter("protocol"), split.name, "the photographs are not in images/train and images/test",
        "import a set of NeRF's synthetic scenes with ulf import, or give every:8 or a file of names");
}

void SplitByList(const LightField& light_field, const fs::path& file, ProtocolSplit& split) {
  std::ifstream lines(file);
  std::map<std::string, int> views;
  std::set<std::string> ambiguous;
  const auto know = [&](const fs::path& name, std::size_t view) {
    const auto [known, is_new] = views.try_emplace(name.generic_string(), static_cast<int>(view));
    if (!is_new && known->second != static_cast<int>(view)) ambiguous.insert(known->first);
  };
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    const fs::path path = light_field.views[i].image_path;
    for (const fs::path& name : {path, path.lexically_relative("images")}) {
      know(name, i);
      know(fs::path(name).replace_extension(), i);
    }
    know(path.filename(), i);
    know(path.stem(), i);
  }
  std::set<int> test;
  for (std::string line; std::getline(lines, line);) {
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty() || line.starts_with('#')) continue;
    const auto view = views.find(line);
    if (view == views.end() || ambiguous.contains(line))
      throw Refusal(
          Parameter("protocol"), file.string(),
          fmt::format("'{}' is {}", line,
                      view == views.end() ? "no photograph of this light field" : "the name of several"),
          "give names as ulf export writes them, such as " + light_field.views.front().image_path);
    test.insert(view->second);
  }
  split.test.assign(test.begin(), test.end());
  for (int i = 0; i < static_cast<int>(light_field.views.size()); ++i)
    if (!test.contains(i)) split.given.push_back(i);
}

}  // namespace

ProtocolSplit SplitByProtocol(const LightField& light_field, const std::string& protocol) {
  ProtocolSplit split{protocol, {}, {}};
  std::error_code unknown;
  int every = 0, used = 0;
  if (protocol == "llff") {
    SplitEvery(light_field, kLlffEvery, split);
  } else if (protocol == "nerf-synthetic") {
    SplitByFolder(light_field, split);
  } else if (std::sscanf(protocol.c_str(), "every:%d%n", &every, &used) == 1 && every >= 2 &&
             At(used) == protocol.size()) {
    SplitEvery(light_field, every, split);
  } else if (fs::is_regular_file(protocol, unknown)) {
    SplitByList(light_field, protocol, split);
  } else {
    throw Refusal(
        Parameter("protocol"), protocol,
        "there are llff, nerf-synthetic, every:N with an N of 2 or more, and files that name the photographs "
        "to leave out",
        "");
  }
  if (split.test.empty() || split.given.size() < 2)
    throw Refusal(Parameter("protocol"), protocol,
                  fmt::format("{} would be left out and {} given", Counted(split.test.size(), "photograph"),
                              split.given.size()),
                  "two have to be given and one left out");
  std::ranges::sort(split.test);
  std::ranges::sort(split.given);
  return split;
}

LightField SubsetOfViews(const LightField& light_field, const std::vector<int>& views) {
  LightField only = light_field;
  only.views.clear();
  std::map<int, const View*> by_id;
  for (const int view : views) {
    only.views.push_back(light_field.views[At(view)]);
    by_id[only.views.back().id] = &light_field.views[At(view)];
  }
  only.points.clear();
  for (const ScenePoint& point : light_field.points) {
    ScenePoint kept = point;
    std::erase_if(kept.track, [&](const ViewObservation& seen) { return !by_id.contains(seen.view_id); });
    std::vector<PosedObservation> observations;
    for (const ViewObservation& seen : kept.track) {
      const View& view = *by_id.at(seen.view_id);
      observations.push_back({&light_field.CameraOf(view), &view.cam_from_world, seen.in_img});
    }
    const auto position = FitPoint(observations);
    if (!position) continue;
    kept.position_in_world = *position;
    only.points.push_back(std::move(kept));
  }
  if (light_field.device_uri.starts_with("import:"))
    if (const auto found = FindSubject({only, {}, {}, {}})) only.subject = found->subject;
  only.measured.reset();
  return only;
}

PaperQuality CompareAsPapers(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid) {
  // Windows at the edge of the excluded area see no difference beyond it.
  cv::Mat filled = photograph.clone();
  rendered.copyTo(filled, valid);
  const Quality ours = CompareImages(filled, photograph, valid);
  return {ours.psnr_db, ours.ssim, SsimUniform(filled, photograph, valid),
          SsimPadded(filled, photograph, valid)};
}

}  // namespace ulf::render

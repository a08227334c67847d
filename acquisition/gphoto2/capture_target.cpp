#include "acquisition/gphoto2/capture_target.h"

#include <algorithm>
#include <vector>

#include "core/base/error.h"

namespace ulf::acquisition {

bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card) {
  const auto target = camera.Setting("capturetarget");
  if (!target) return false;
  const auto choice = [&](const char* word) -> std::optional<std::string> {
    for (const std::string& offered : target->choices)
      if (offered.find(word) != std::string::npos) return offered;
    return std::nullopt;
  };
  const auto card = choice("card"), ram = choice("RAM");
  bool wants_card = to_card.value_or(false);
  std::vector<GphotoStorage> storages;
  if (!to_card && camera.Storages(storages).ok())
    wants_card = std::any_of(storages.begin(), storages.end(), [](const GphotoStorage& storage) {
      return storage.is_card && !storage.is_full;
    });
  const auto wanted = wants_card ? card : ram;
  if (to_card && !wanted)
    throw UsageError("{}: this camera does not offer target={}; leave it out", uri,
                     wants_card ? "card" : "ram");
  if (wanted && target->value != *wanted) {
    const GphotoResult result = camera.Set("capturetarget", *wanted);
    if (!result.ok() && to_card)
      throw Error("{}: the target cannot be set ({}); leave target= out", uri, result.text);
  }
  const auto now = camera.Setting("capturetarget");
  return now && now->value.find("RAM") != std::string::npos;
}

bool IsInCameraMemory(const std::string& folder, bool target_is_memory) {
  return target_is_memory && !folder.starts_with("/store_");
}

}  // namespace ulf::acquisition

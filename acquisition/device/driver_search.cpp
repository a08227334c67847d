#include "acquisition/device/driver_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquisition/device/background_closer.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFirstPauseS = 0.1;  // doubled after each attempt; guessed

std::string Describe(const DeviceInfo& info) {
  std::string text = info.maker + (info.maker.empty() ? "" : " ") + info.model;
  if (!info.serial.empty()) text += ", serial " + info.serial;
  return text;
}

// Without a serial number, all cameras of a model count as the same. Serial numbers are unique only per
// maker.
bool IsSameCamera(const DeviceInfo& known, const DeviceInfo& found) {
  return known.maker == found.maker && known.model == found.model &&
         (known.serial.empty() || known.serial == found.serial);
}

void RunSearch(const std::shared_ptr<DriverSearch>& search, const Reconnection& how, const DeviceInfo& known,
               Clock::time_point begin, Clock::time_point give_up) {
  const auto stopped = [&]() ULF_REQUIRES(search->mutex) { return search->stop; };
  {
    MutexLock lock(search->mutex);
    if (search->changed.wait_until(lock, begin, stopped)) return;
  }
  double wait_s = kFirstPauseS;
  for (int attempt = 0;; ++attempt) {
    std::unique_ptr<Device> driver;
    std::string problem, refused;
    try {
      driver = FindAgain(how, known, attempt, &refused);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    MutexLock lock(search->mutex);
    if (search->stop) {
      lock.unlock();
      return;  // closes `driver` here, where nobody waits
    }
    search->problem = problem;
    if (!refused.empty()) search->refused = refused;
    search->found = std::move(driver);
    search->over = !search->found && Clock::now() >= give_up;
    search->changed.notify_all();
    if (search->found || search->over) return;
    const auto until = std::min(Clock::now() + DurationOf(wait_s), give_up);
    if (search->changed.wait_until(lock, until, stopped)) return;
    wait_s = std::min(2 * wait_s, kLongestSearchPauseS);
  }
}

}  // namespace

std::unique_ptr<Device> FindAgain(const Reconnection& how, const DeviceInfo& known, int attempt,
                                  std::string* refused) {
  const bool elsewhere = how.elsewhere && attempt % 2 == 1;
  std::unique_ptr<Device> driver = (elsewhere ? how.elsewhere : how.where_it_was)(known);
  if (!IsSameCamera(known, driver->Info())) {
    *refused = fmt::format("{}: found another camera ({}) instead of {}; connect the original camera again",
                           known.uri, Describe(driver->Info()), Describe(known));
    throw Error("{}", *refused);
  }
  driver->Start();
  return driver;
}

std::shared_ptr<DriverSearch> SearchDriver(const Reconnection& how, const DeviceInfo& known,
                                           Clock::time_point begin, Clock::time_point give_up) {
  auto search = std::make_shared<DriverSearch>();
  CloseInBackground(std::function<void()>(
      [search, how, known, begin, give_up] { RunSearch(search, how, known, begin, give_up); }));
  return search;
}

}  // namespace ulf::acquisition

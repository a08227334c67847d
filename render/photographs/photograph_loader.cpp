#include "render/photographs/photograph_loader.h"

#include <algorithm>
#include <set>

namespace ulf::render {
namespace {

std::size_t MemoryOf(const cv::Mat& pixels) { return pixels.total() * pixels.elemSize(); }

}  // namespace

PhotographLoader::PhotographLoader(int threads) {
  const int count =
      threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (int n = 0; n < count; ++n) threads_.emplace_back([this] { Run(); });
}

PhotographLoader::~PhotographLoader() {
  {
    const MutexLock lock(mutex_);
    over_ = true;
  }
  work_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void PhotographLoader::SetRequests(std::vector<Request> requests) {
  {
    const MutexLock lock(mutex_);
    std::set<Key> asked;
    waiting_.clear();
    for (Request& request : requests) {
      if (!asked.insert(request.key).second) continue;
      if (!read_.contains(request.key) && !being_read_.contains(request.key))
        waiting_.push_back(std::move(request));
    }
    std::ranges::reverse(waiting_);
    for (auto& [key, wanted] : being_read_) wanted = asked.contains(key);
    std::erase_if(read_, [&](const auto& entry) ULF_REQUIRES(mutex_) {
      if (asked.contains(entry.first)) return false;
      read_bytes_ -= MemoryOf(entry.second.pixels);
      return true;
    });
  }
  work_.notify_all();
}

std::optional<cv::Mat> PhotographLoader::TakeLocked(const Key& key) {
  const auto found = read_.find(key);
  if (found == read_.end()) return std::nullopt;
  const Read read = std::move(found->second);
  read_.erase(found);
  read_bytes_ -= MemoryOf(read.pixels);
  work_.notify_all();
  if (read.problem) std::rethrow_exception(read.problem);
  return read.pixels;
}

std::optional<cv::Mat> PhotographLoader::Take(const Key& key) {
  const MutexLock lock(mutex_);
  return TakeLocked(key);
}

cv::Mat PhotographLoader::Wait(const Key& key) {
  MutexLock lock(mutex_);
  ++waiters_;
  work_.notify_all();
  news_.wait(lock, [&]() ULF_REQUIRES(mutex_) { return read_.contains(key); });
  --waiters_;
  return *TakeLocked(key);
}

std::optional<PhotographLoader::Request> PhotographLoader::Next() {
  MutexLock lock(mutex_);
  work_.wait(lock, [this]() ULF_REQUIRES(mutex_) {
    return over_ || (!waiting_.empty() && (read_bytes_ < kMostBytes || waiters_ > 0));
  });
  if (over_) return std::nullopt;
  Request request = std::move(waiting_.back());
  waiting_.pop_back();
  being_read_[request.key] = true;
  return request;
}

void PhotographLoader::Run() {
  while (const auto request = Next()) {
    Read read;
    try {
      read.pixels = request->photograph->Level(request->key.second);
    } catch (...) {
      read.problem = std::current_exception();
    }
    {
      const MutexLock lock(mutex_);
      const bool wanted = being_read_[request->key];
      being_read_.erase(request->key);
      if (wanted) {
        read_bytes_ += MemoryOf(read.pixels);
        read_[request->key] = std::move(read);
      }
    }
    news_.notify_all();
  }
}

}  // namespace ulf::render

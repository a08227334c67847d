#include "acquisition/gphoto2/photograph_pairing.h"

#include <cctype>
#include <utility>

#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf {
namespace {

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::string StemOf(const std::string& file_name) { return Lower(file_name.substr(0, file_name.rfind('.'))); }

std::string ExtensionOf(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  const std::string extension = dot == std::string::npos ? "" : Lower(file_name.substr(dot));
  return extension == ".jpeg" || extension == ".jpe" ? ".jpg" : extension;
}

std::string FormatsWithJpeg(GphotoCamera& camera) {
  for (const char* name : {"imageformat", "imagequality"}) {
    const auto setting = camera.Setting(name);
    if (!setting) continue;
    std::string with_jpeg;
    for (const std::string& choice : setting->choices) {
      PhotographPairing asks(0);
      asks.ExpectFormat(choice);
      if (asks.ExpectsJpeg()) with_jpeg += (with_jpeg.empty() ? "" : ", ") + choice;
    }
    return with_jpeg;
  }
  return "";
}

void PhotographPairing::ExpectFormat(const std::string& image_format) {
  const std::string format = Lower(image_format);
  const auto holds = [&](const char* word) { return format.find(word) != std::string::npos; };
  const bool both = holds("+");
  const bool raw =
      holds("raw") || holds("nef") || holds("cr2") || holds("cr3") || holds("arw") || holds("raf");
  expects_raw_ = raw || both;
  expects_jpeg_ = !raw || both || holds("jpeg") || holds("jpg");
}

bool PhotographPairing::IsComplete(const DownloadedPhotograph& photograph) const {
  const bool jpeg = !photograph.jpeg.name.empty(), raw = !photograph.raw.name.empty();
  return (jpeg || !expects_jpeg_) && (raw || !expects_raw_);
}

void PhotographPairing::Add(DownloadedFile file, double now_s) {
  const std::string stem = StemOf(file.name);
  const bool is_jpeg = ExtensionOf(file.name) == ".jpg";
  Waiting& waiting = waiting_[stem];
  const bool taken = !(is_jpeg ? waiting.photograph.jpeg : waiting.photograph.raw).name.empty();
  // The camera has begun to count again: another photograph.
  if (taken) ready_.push_back(std::exchange(waiting, {}).photograph);
  if (waiting.photograph.First().name.empty()) waiting.since_s = now_s;
  (is_jpeg ? waiting.photograph.jpeg : waiting.photograph.raw) = std::move(file);
  if (!IsComplete(waiting.photograph)) return;
  ready_.push_back(std::move(waiting.photograph));
  waiting_.erase(stem);
}

std::vector<DownloadedPhotograph> PhotographPairing::Take(double now_s, bool all) {
  for (auto entry = waiting_.begin(); entry != waiting_.end();) {
    if (!all && now_s - entry->second.since_s < patience_s_) {
      ++entry;
      continue;
    }
    ready_.push_back(std::move(entry->second.photograph));
    entry = waiting_.erase(entry);
  }
  return std::exchange(ready_, {});
}

}  // namespace ulf

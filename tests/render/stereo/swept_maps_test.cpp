// Tests: render/stereo/swept_maps, render/proxy/depth_map_files.
#include "render/stereo/swept_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "render/proxy/depth_map_files.h"
#include "tests/support/test_paths.h"

namespace ulf::test::swept_maps_test {
namespace {

using nlohmann::json;
using render::FindSweptMaps;
using render::SweptMap;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::uint64_t kMadeOf = 0x0123456789abcdef;
const cv::Size kSize(40, 30);

class SweptMapsOnDisk : public testing::Test {
 protected:
  SweptMapsOnDisk() {
    for (const int id : {3, 8}) {
      cv::Mat depth(kSize, CV_32FC1);
      cv::randu(depth, 0.5, 4);
      maps_[id] = {depth, 0.01 * id};
    }
    Write({0, 1});
  }
  void Write(const render::MapShare& share) const { WriteSweptMaps(folder_, share, kMadeOf, maps_); }
  void Change(const std::string& index, const std::function<void(json&)>& change) const {
    json content = JsonFromText(ReadWholeFile(folder_ / index));
    change(content);
    WriteFileAtomically(folder_ / index, JsonText(content));
  }
  // What reading says; empty: nothing is wrong.
  std::string Problem(const cv::Size& size = kSize) const {
    try {
      const render::SweptMapFiles found = FindSweptMaps(folder_, kMadeOf);
      for (const auto& [id, map] : maps_) found.Read(id, size);
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  }
  const ScratchFolder scratch_;
  const std::filesystem::path folder_ = scratch_ / "maps";
  render::SweptMaps maps_;
};

TEST_F(SweptMapsOnDisk, ComeBackAsTheyWere) {
  const render::SweptMapFiles found = FindSweptMaps(folder_, kMadeOf);
  for (const auto& [id, map] : maps_) {
    const SweptMap read = found.Read(id, kSize);
    EXPECT_EQ(cv::norm(read.depth, map.depth, cv::NORM_INF), 0) << id;
    EXPECT_EQ(read.plane_step, map.plane_step);
  }
  EXPECT_THROW(found.Read(4, kSize), Error);
  // Another program reads them as well.
  EXPECT_EQ(cv::norm(cv::imread((folder_ / "000003.tiff").string(), cv::IMREAD_UNCHANGED), maps_[3].depth),
            0);
}

TEST_F(SweptMapsOnDisk, HaveExactlyTheSizeAskedFor) {
  for (const cv::Size& size : {cv::Size(30, 40), cv::Size(41, 30), cv::Size(1, 1)})
    EXPECT_THAT(Problem(size), AllOf(HasSubstr("000003.tiff: is no depth map of"), HasSubstr("again")))
        << size;
  // What claims to be large is not decoded: a compressed picture of nine megapixels.
  const cv::Mat huge(3000, 3000, CV_32FC1, cv::Scalar(1));
  std::vector<unsigned char> bytes;
  cv::imencode(".tiff", huge, bytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  WriteFileAtomically(folder_ / "000003.tiff", text);
  Change("share-0-of-1.json",
         [&](json& index) { index["views"][0]["checksum"] = render::ChecksumForIndex(text); });
  EXPECT_THAT(Problem(), HasSubstr("000003.tiff: is no depth map of 40x30"));
}

TEST_F(SweptMapsOnDisk, MissingSharesAreNamedTenAtMost) {
  std::filesystem::remove(folder_ / "share-0-of-1.json");
  Write({1, 3});
  EXPECT_THAT(Problem(), AllOf(HasSubstr("maps_of 0/3, 2/3"), Not(HasSubstr("more"))));
  std::filesystem::remove(folder_ / "share-1-of-3.json");
  Write({4, render::MapShare::kMost});
  EXPECT_THAT(Problem(), AllOf(HasSubstr("maps_of 0/60000, 1/60000"), HasSubstr("10/60000 and 59989 more"),
                               Not(HasSubstr("4/60000, 4")), Not(HasSubstr("11/60000"))));
}

TEST_F(SweptMapsOnDisk, RefuseAnImpossibleIndex) {
  struct Case {
    const char* key;
    json value;
    const char* says;
  };
  for (const Case& c :
       {Case{"of", 2000000000, "share 0 of 2000000000"}, Case{"of", 0, "share 0 of 0"},
        Case{"share", 1, "share 1 of 1"}, Case{"share", -1, "share -1 of 1"},
        Case{"share", "first", "is damaged"}, Case{"views", 7, "is damaged"},
        Case{"made_of", "00", "was made of other photographs"}, Case{"format", 5, "holds no depth maps"}}) {
    Write({0, 1});
    Change("share-0-of-1.json", [&](json& index) { index[c.key] = c.value; });
    EXPECT_THAT(Problem(), HasSubstr(c.says)) << c.key;
  }
}

TEST_F(SweptMapsOnDisk, AMapWhoseBytesHaveChangedIsRefused) {
  std::string bytes = ReadWholeFile(folder_ / "000008.tiff");
  bytes.back() ^= 1;
  std::ofstream(folder_ / "000008.tiff", std::ios::binary) << bytes;
  EXPECT_THAT(Problem(), AllOf(HasSubstr("000008.tiff: its bytes have changed"), HasSubstr("again")));
}

}  // namespace
}  // namespace ulf::test::swept_maps_test

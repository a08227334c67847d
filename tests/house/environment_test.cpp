// What the build gives every test that CTest starts.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

namespace {

TEST(Environment, ReachesTheTest) {
  ASSERT_NE(std::getenv("OMP_NUM_THREADS"), nullptr) << "not started by ctest, or the variable was lost";
  EXPECT_STREQ(std::getenv("OMP_NUM_THREADS"), "1");
  ASSERT_NE(std::getenv("ULF_BINARY"), nullptr);
  EXPECT_EQ(std::filesystem::path(std::getenv("ULF_BINARY")).filename(), "ulf");
}

}  // namespace

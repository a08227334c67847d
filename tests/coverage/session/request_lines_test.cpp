// Tests: coverage/session/capture_request.
//
// Requests as a person or a script writes them.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "coverage/session/capture_request.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::request_lines_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename Request>
Request Parsed(const std::string& line) {
  const CaptureRequest request = ParseCaptureRequest(line);
  if (!std::holds_alternative<Request>(request)) throw std::runtime_error(line + " is another request");
  return std::get<Request>(request);
}

TEST(CaptureRequest, ViewsAreTakenBackByCountOrByNumber) {
  EXPECT_EQ(Parsed<TakeBackLast>("take-back").count, 1);
  EXPECT_EQ(Parsed<TakeBackLast>("take-back 12").count, 12);
  EXPECT_THAT(Parsed<TakeBackViews>("take-back views 17").ids, ElementsAre(17));
  EXPECT_THAT(Parsed<TakeBackViews>("  take-back \t views 17 3  0 ").ids, ElementsAre(17, 3, 0));
}

TEST(CaptureRequest, ASubjectIsPlacedOrFound) {
  const Subject placed = Parsed<PlaceSphere>("subject 0,-0.5,1.25,0.2").subject;
  EXPECT_EQ(placed, (Subject{{0, -0.5, 1.25}, 0.2}));
  EXPECT_FALSE(Parsed<FindSubject>("subject").depth);
  EXPECT_FALSE(Parsed<FindSubject>("subject").width_share);
  EXPECT_EQ(Parsed<FindSubject>("subject depth 0.9").depth, 0.9);
  EXPECT_FALSE(Parsed<FindSubject>("subject depth 0.9").width_share);
  for (const char* both : {"subject depth 0.9 size 0.3", "subject size 0.3 depth 0.9"}) {
    EXPECT_EQ(Parsed<FindSubject>(both).depth, 0.9);
    EXPECT_EQ(Parsed<FindSubject>(both).width_share, 0.3);
  }
}

TEST(CaptureRequest, ParsesRecordingAndTheEnd) {
  EXPECT_FALSE(Parsed<SetRecording>("pause").on);
  EXPECT_TRUE(Parsed<SetRecording>("record").on);
  Parsed<FinishCapture>("finish");
}

TEST(CaptureRequest, UnknownOnesListWhatThereIs) {
  for (const char* line : {"", " ", "take-back 0", "take-back -1", "take-back two", "take-back 1.5",
                           "take-back 1 2", "take-back views", "take-back views x", "take-back views 1 -2",
                           "subject depth 0", "subject depth -1", "subject size nan", "subject depth 1 size",
                           "subject colour 1", "pause now", "record 3", "Finish", "finish it"}) {
    EXPECT_THAT([&] { ParseCaptureRequest(line); },
                testing::ThrowsMessage<Refusal>(AllOf(HasSubstr(std::string("'") + line + "'"),
                                                      HasSubstr("take-back views"), HasSubstr("[depth D]"),
                                                      HasSubstr("finish"))))
        << "'" << line << "' is taken";
  }
  for (const char* line :
       {"subject depth", "subject 0,0,1", "subject 0,0,1,0", "subject 0,0,x,1", "subject 0,0,1,-0.2"})
    EXPECT_THROW(ParseCaptureRequest(line), Refusal) << line;
}

TEST(RequestLines, LinesComeWholeAndWrongOnesAreAnswered) {
  const ScratchFolder scratch;
  const std::string fifo = scratch / "requests";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  CaptureRequests requests;
  const auto ask = [&](const std::string& line) { requests.Push(ParseCaptureRequest(line)); };
  RequestLines lines(fifo, ask);
  std::vector<std::string> said;
  const auto take = [&] {
    lines.Take([&](const std::string& line) { said.push_back(line); });
    return requests.Take();
  };
  EXPECT_TRUE(take().empty()) << "nobody has written";
  {
    std::ofstream writer(fifo);
    writer << "pause\n\ntake-b" << std::flush;
    EXPECT_EQ(take().size(), 1u);
    writer << "ack 3\ntake-bak\nrecord\n" << std::flush;
    const auto taken = take();
    ASSERT_EQ(taken.size(), 2u);
    EXPECT_EQ(std::get<TakeBackLast>(taken[0]).count, 3);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_THAT(said[0], HasSubstr("'take-bak' is not a request"));
  }
  EXPECT_TRUE(take().empty());
  std::ofstream(fifo) << "finish\n" << std::flush;  // another one writes: the fifo has no end
  EXPECT_THROW(RequestLines((scratch / "none").string(), ask), Refusal);
  EXPECT_THROW(RequestLines(scratch.path().string(), ask), Refusal);
}

// Through the command: a wrong line is answered, the capture goes on to the next.
TEST(RequestLines, WorkThroughTheCommand) {
  const ScratchFolder scratch;
  const std::string requests = scratch / "requests", dir = scratch / "lf";
  std::ofstream(requests) << "tak-back\nfinish";
  const CommandResult result = RunUlf(
      "capture --no-geometry 'sim:studio?width=160&height=120' --headless --frames 60 --poses known "
      "--subject "
      "0,0,0,0.2 --json -o " +
      dir + " --requests - < " + requests);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors,
              AllOf(HasSubstr("'tak-back' is not a request"), HasSubstr("finishing, as asked")));
  EXPECT_EQ(JsonFromText(result.output)["stopped_because"], "closed");
}

}  // namespace
}  // namespace ulf::test::request_lines_test

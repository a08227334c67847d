// The room that draws: which rows are the front and which is ringed, that tables come back as they were, and
// that names lie on nothing.
#include "tests/measure/chart_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "tests/measure/chart_layout.h"
#include "tests/measure/gnuplot.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

ChartRow Row(double cost, double error, bool is_default = false) {
  return {"series", "", Spread::Exactly(cost), Spread::Exactly(error), is_default};
}

ChartPanel PanelOf(std::vector<ChartRow> rows) { return {"panel", {"ms"}, {"error"}, std::move(rows)}; }

TEST(ChartFront, HoldsWhatNoOtherRowBeatsInBoth) {
  //                            0          1           2          3          4
  const auto panel = PanelOf({Row(3, 1), Row(1, 4), Row(2, 5), Row(2, 2), Row(4, 1)});
  EXPECT_THAT(ParetoFront(panel), ElementsAre(1, 3, 0));
}

TEST(ChartFront, MoreMayBeBetter) {
  auto panel = PanelOf({Row(3, 30), Row(1, 20), Row(2, 19), Row(4, 29)});
  panel.error.more_is_better = true;
  EXPECT_THAT(ParetoFront(panel), ElementsAre(1, 0));
}

TEST(ChartFront, KeepsTheFirstOfEqualsAndNoFailures) {
  const double none = std::nan("");
  EXPECT_THAT(ParetoFront(PanelOf({Row(1, none), Row(2, 3), Row(2, 3), Row(none, 0)})), ElementsAre(1));
}

TEST(ChartFront, RowsThatAreNoRivalsHaveNone) {
  auto panel = PanelOf({Row(1, 2), Row(2, 1)});
  panel.compared = false;
  EXPECT_THAT(ParetoFront(panel), IsEmpty());
}

TEST(Spread, IsTheMedianWithTheLowestAndTheHighest) {
  const Spread spread = Spread::Of({5, 1, 9, 2, 3});
  EXPECT_EQ(spread.median, 3);
  EXPECT_EQ(spread.low, 1);
  EXPECT_EQ(spread.high, 9);
  EXPECT_TRUE(std::isnan(Spread::Of({}).median));
}

Chart Sample() {
  Chart chart{.name = "sample",
              .title = "A title, with \"quotes\"",
              .about = "Seeds 1 to 3",
              .caption = "./run measure charts/sample"};
  chart.panels.push_back({"left, of two",
                          {"ms", true},
                          {"dB", false, true},
                          {{"a, b", "850 \"in use\"", {2, 1, 4}, {30, 29, 31}, true},
                           {"a, b", "300", {1, 1, 1}, {25, 24, 26}},
                           {"c_d", "", {3, 3, 3}, Spread::Of({})}}});
  chart.panels.push_back({"right", {"n"}, {"px"}, {{"c_d", "x", {5, 5, 5}, {6, 6, 6}}}, false});
  return chart;
}

TEST(ChartTable, ComesBackAsItWas) {
  const ScratchFolder scratch;
  Chart chart = Sample();
  chart.panels[0].all_named = chart.panels[1].diagonal = true;
  WriteChart(scratch / "sample.csv", chart);
  const Chart read = ReadChart(scratch / "sample.csv");
  WriteChart(scratch / "again.csv", read);
  const auto text = [&](const char* name) {
    std::ifstream file(scratch / name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(text("sample.csv"), text("again.csv"));
  // Cost, error, is the default, is of the front.
  EXPECT_THAT(text("sample.csv"),
              HasSubstr("\"left, of two\",\"a, b\",\"850 \"\"in use\"\"\",2,1,4,30,29,31,1,1\n"));
  EXPECT_THAT(text("sample.csv"), HasSubstr("\"right\",\"c_d\",\"x\",5,5,5,6,6,6,0,0\n"));
  ASSERT_EQ(read.panels.size(), 2u);
  EXPECT_TRUE(read.panels[0].all_named && read.panels[1].diagonal);
  EXPECT_FALSE(read.panels[0].diagonal || read.panels[1].all_named);
  EXPECT_TRUE(read.panels[0].points[0].is_default);
  EXPECT_FALSE(read.panels[0].points[1].is_default);
  EXPECT_TRUE(std::isnan(read.panels[0].points[2].error.median));
}

TEST(ChartTable, OtherTablesAreRefused) {
  const ScratchFolder scratch;
  std::ofstream(scratch / "other.csv") << "a,b\n1,2\n";
  EXPECT_THROW(ReadChart(scratch / "other.csv"), Error);
}

TEST(ChartScaleTest, HoldsBarsAndCountsByPowers) {
  const ChartScale scale = ScaleOf({{10, 1, 100}}, true);
  EXPECT_LT(scale.Share(1), 0.2);
  EXPECT_GT(scale.Share(1), 0);
  EXPECT_NEAR(scale.Share(10), 0.5, 1e-9);
  EXPECT_LT(scale.Share(100), 1);
  const ChartScale linear = ScaleOf({{2, 1, 10}}, false);
  EXPECT_EQ(linear.low, 0) << "errors are seen from nought where that costs no room";
  EXPECT_GT(ScaleOf({{30, 29, 31}}, false).low, 20);
  EXPECT_EQ(ScaleOf({{30, 29, 31}}, false, true).low, 0);
  EXPECT_LE(ScaleOf({{1e5, 1, 1e13}}, true).tics.size(), 8u) << "or their numbers overlap";
  const ChartScale nought = ScaleOf({{0, 0, 0}}, false);
  EXPECT_EQ(nought.low, 0) << "nothing is less than none";
  EXPECT_GE(nought.high, 1);
}

TEST(ChartNames, LieOnNoPointAndOnNoOtherName) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  ChartPanel panel = PanelOf({});
  for (int i = 0; i < 60; ++i) {
    panel.points.push_back(Row(unit(random), unit(random), i == 17));
    panel.points.back().name = "name " + std::to_string(i);
  }
  const ChartBox inside{100, 50, 700, 450};
  const ChartScale scale{0, 1, false, {}, false};
  const auto names = PlaceNames(panel, scale, scale, inside);
  ASSERT_GT(names.size(), 20u);
  EXPECT_EQ(names[0].point, 17u) << "the default's first";
  for (std::size_t a = 0; a < names.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_FALSE(names[a].box.Overlaps(names[b].box)) << names[a].point << " and " << names[b].point;
    EXPECT_GE(names[a].box.left, inside.left);
    EXPECT_LE(names[a].box.right, inside.right);
    for (const ChartRow& point : panel.points) {
      const double x = 100 + 600 * point.cost.median, y = 450 - 400 * point.error.median;
      EXPECT_FALSE(names[a].box.Overlaps({x - 3, y - 3, x + 3, y + 3})) << names[a].point;
    }
  }
}

TEST(ChartNames, AvoidBarsAndLinesWhereThereIsRoom) {
  ChartPanel panel = PanelOf({Row(0.5, 0.5), Row(0.9, 0.9)});
  panel.compared = false;
  panel.points[0].name = "name";
  // Above, where a name is best, is where the bar is; to the right and above the line to the other point.
  panel.points[0].error = {0.5, 0.5, 0.9};
  const ChartBox inside{0, 0, 600, 400};
  const ChartScale scale{0, 1, false, {}, false};
  const auto names = PlaceNames(panel, scale, scale, inside);
  ASSERT_EQ(names.size(), 1u);
  EXPECT_FALSE(names[0].box.Overlaps({299, 40, 301, 200})) << "the bar";
  for (double along = 0; along < 1; along += 0.01)
    EXPECT_FALSE(names[0].box.Overlaps(
        {300 + 240 * along, 200 - 160 * along, 300 + 240 * along + 1, 200 - 160 * along + 1}));
}

// A run that failed has no place, and no line leads to it.
TEST(ChartNames, ALineGoesPastRowsThatFailed) {
  const double failed = std::numeric_limits<double>::infinity();
  ChartPanel panel = PanelOf({Row(0.2, 0.5), Row(0.5, failed), Row(0.8, 0.5), Row(0.9, failed)});
  for (std::size_t i = 0; i < panel.points.size(); ++i) panel.points[i].name = "row " + std::to_string(i);
  const ChartScale scale{0, 1, false, {}, false};
  EXPECT_EQ(PlaceNames(panel, scale, scale, {0, 0, 600, 400}).size(), 2u);
}

// At the end of the axis, with another point and its name to the left: above, pushed to the left.
TEST(ChartNames, AtTheAxisEndIsPushedInside) {
  const auto panel = [] {
    auto made = PanelOf({Row(8, 5), Row(1, 5)});
    made.points[0].name = "a name of twenty-two..";
    made.points[1].name = "another that is as long";
    return made;
  }();
  const ChartBox inside{0, 0, 200, 100};
  const auto placed = PlaceNames(panel, ChartScale{0, 8.2, false, {}}, ChartScale{0, 10, false, {}}, inside);
  ASSERT_EQ(placed.size(), 2u);
  for (const PlacedName& name : placed) {
    EXPECT_GE(name.box.left, inside.left);
    EXPECT_LE(name.box.right, inside.right);
  }
}

TEST(ChartNames, CrowdedNamesStandFartherOff) {
  std::vector<ChartRow> rows;
  for (int i = 0; i < 9; ++i) {
    rows.push_back(Row(5 + 0.05 * (i % 3), 5 + 0.05 * (i / 3)));
    rows.back().name = "a long name, " + std::to_string(i);
  }
  auto panel = PanelOf(rows);
  const auto place = [&] {
    return PlaceNames(panel, ChartScale{0, 10, false, {}}, ChartScale{0, 10, false, {}}, {0, 0, 700, 400});
  };
  EXPECT_LT(place().size(), rows.size());
  panel.all_named = true;
  const auto placed = place();
  ASSERT_EQ(placed.size(), rows.size());
  for (std::size_t i = 0; i < placed.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(placed[i].box.Overlaps(placed[j].box)) << i << " " << j;
}

TEST(ChartDrawing, RingsTheDefaultAndDashesTheFront) {
  const std::string script = PictureOf(Sample()).script;
  EXPECT_THAT(script, HasSubstr("$ringed0 << EOD\n2 30 1 4 29 31\nNaN"));
  EXPECT_THAT(script, HasSubstr("$front0 << EOD\n1 25 1 1 24 26\n2 30 1 4 29 31\nNaN"));
  EXPECT_THAT(script, HasSubstr("$ringed1 << EOD\nNaN"));
  EXPECT_THAT(script, HasSubstr("$front1 << EOD\nNaN"));
  EXPECT_THAT(script, HasSubstr("$front0 with steps"));
  EXPECT_THAT(script, HasSubstr("$ringed0 using 1:2 with points pt 6"));
}

std::vector<std::string> RangesOf(const std::string& script, const std::string& axis) {
  std::vector<std::string> ranges;
  const std::string begin = "set " + axis + "range ";
  for (std::size_t at = script.find(begin); at != std::string::npos; at = script.find(begin, at + 1))
    ranges.push_back(script.substr(at + begin.size(), script.find('\n', at) - at - begin.size()));
  return ranges;
}

TEST(ChartDrawing, PanelsOfOneCostShareTheirRange) {
  Chart chart = Sample();
  chart.panels[0].points[2].cost = Spread::Exactly(100);
  chart.panels[1] = chart.panels[0];
  for (ChartRow& point : chart.panels[1].points) point.error = Spread::Exactly(1);
  const auto apart = RangesOf(PictureOf(chart).script, "x");
  ASSERT_EQ(apart.size(), 2u);
  EXPECT_NE(apart[0], apart[1]);
  chart.same_costs = true;
  const auto same = RangesOf(PictureOf(chart).script, "x");
  EXPECT_EQ(same[0], same[1]);
}

TEST(ChartDrawing, AnAxisMayFall) {
  Chart chart = Sample();
  const std::string rises = RangesOf(PictureOf(chart).script, "x")[1];
  chart.panels[1].cost.falls = true;
  const std::string falls = RangesOf(PictureOf(chart).script, "x")[1];
  const std::size_t middle = rises.find(':');
  EXPECT_EQ(falls, "[" + rises.substr(middle + 1, rises.size() - middle - 2) + ":" +
                       rises.substr(1, middle - 1) + "]");
}

TEST(ChartDrawing, TheDiagonalIsOneOfEqualAxes) {
  Chart chart = Sample();
  EXPECT_THAT(PictureOf(chart).script, Not(HasSubstr("to graph 1, graph 1")));
  chart.panels[1].diagonal = true;
  const std::string script = PictureOf(chart).script;
  EXPECT_THAT(script, HasSubstr("to graph 1, graph 1"));
  EXPECT_EQ(RangesOf(script, "x")[1], RangesOf(script, "y")[1]);
}

TEST(ChartDrawing, OmitsRowsThatOnlyAPageShows) {
  Chart chart = Sample();
  chart.about = "the mesh of `ulf proxy`";
  chart.panels[0].points[0].series = "over `x`";
  const std::string script = PictureOf(chart).script;
  EXPECT_THAT(script, Not(HasSubstr("`")));
  EXPECT_THAT(script, HasSubstr("the mesh of ulf proxy"));
}

TEST(ChartDrawing, MakesBothPictures) {
  const ScratchFolder scratch;
  DrawChart(scratch.path(), Sample());
  for (const char* name : {"sample.svg", "sample.png"})
    EXPECT_GT(std::filesystem::file_size(scratch / name), 1000u) << name;
  std::ifstream file(scratch / "sample.svg");
  const std::string svg(std::istreambuf_iterator<char>(file), {});
  for (const char* text :
       {"left, of two", "c_d", "the default", "Pareto front", "./run measure charts/sample"})
    EXPECT_THAT(svg, HasSubstr(text));
}

TEST(ChartDrawing, AFailingChartLeavesNoHalfPicture) {
  const ScratchFolder scratch;
  const std::string path = (scratch / "chart.png").string();
  EXPECT_THAT([&] { DrawChart(path, 100, 100, "plot sin(x)\nplot nothing_of_this_name\n"); },
              testing::ThrowsMessage<Error>(HasSubstr("nothing_of_this_name")))
      << "drawn";
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace ulf::test

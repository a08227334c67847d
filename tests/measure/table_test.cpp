// Values that are collected become the rows of panels.
#include "tests/measure/table.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace ulf::test {
namespace {

Table TwoPanels() {
  Table table;
  table.Panel("left", {"ms"}, {"px"});
  table.Panel("right", {"n"}, {"dB"}, {.compared = false});
  return table;
}

TEST(Table, MakesMediansOfTheValuesOfARow) {
  Table table = TwoPanels();
  for (const double value : {3.0, 1.0, 2.0}) {
    table.Add("left", "a", "1", 10 * value, value);
    table.Add("left", "a", "2", 7, 5);
  }
  const auto panels = table.panels();
  ASSERT_EQ(panels.size(), 2u);
  ASSERT_EQ(panels[0].points.size(), 2u);
  EXPECT_EQ(panels[0].points[0].error.median, 2);
  EXPECT_EQ(panels[0].points[0].cost.low, 10);
  EXPECT_EQ(panels[0].points[0].cost.high, 30);
  EXPECT_EQ(panels[0].points[1].name, "2");
  EXPECT_FALSE(panels[1].compared);
  EXPECT_TRUE(panels[1].points.empty());
}

TEST(Table, TellsRowsWithoutANameByTheirCost) {
  Table table = TwoPanels();
  for (const double cost : {1.0, 2.0, 1.0}) table.Add("left", "a", "", cost, 5);
  EXPECT_EQ(table.panels()[0].points.size(), 2u);
}

TEST(Table, RingsWhatMostValuesCallTheDefault) {
  Table table = TwoPanels();
  for (const bool is_default : {true, false, true}) {
    table.Add("left", "a", "mostly", 1, 1, is_default);
    table.Add("left", "a", "hardly", 1, 1, !is_default);
  }
  EXPECT_TRUE(table.panels()[0].points[0].is_default);
  EXPECT_FALSE(table.panels()[0].points[1].is_default);
}

TEST(Table, KeepsAPanelThatIsThereAndKnowsNoOther) {
  Table table = TwoPanels();
  table.Panel("left", {"other"}, {"px"});
  EXPECT_EQ(table.panels()[0].cost.label, "ms");
  EXPECT_THROW(table.Add("middle", "a", "1", 1, 1), Error);
}

}  // namespace
}  // namespace ulf::test

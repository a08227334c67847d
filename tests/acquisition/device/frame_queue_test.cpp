// Tests: acquisition/device/frame_queue, acquisition/device/frame_id_counter.
#include "acquisition/device/frame_queue.h"

#include <gmock/gmock.h>

#include <set>
#include <thread>

#include "acquisition/device/frame_id_counter.h"
#include "tests/support/floors.h"

namespace ulf::frame_queue_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

std::vector<int> Drain(BoundedQueue<int>& queue) {
  std::vector<int> items;
  while (const auto item = queue.Pop(0ms)) items.push_back(*item);
  return items;
}

TEST(BoundedQueue, KeepsOrder) {
  BoundedQueue<int> queue(3);
  for (const int i : {1, 2, 3}) EXPECT_TRUE(queue.Push(i));
  EXPECT_EQ(queue.Size(), 3u);
  EXPECT_THAT(Drain(queue), ElementsAre(1, 2, 3));
  EXPECT_EQ(queue.Dropped(), 0u);
}

TEST(BoundedQueue, DropsTheOldestCountsItAndHandsItBack) {
  BoundedQueue<int> queue(2);
  std::vector<int> made_room;
  for (const int i : {1, 2, 3, 4, 5}) {
    std::optional<int> dropped;
    EXPECT_TRUE(queue.Push(i, &dropped));
    if (dropped) made_room.push_back(*dropped);
  }
  EXPECT_EQ(queue.Dropped(), 3u);
  EXPECT_THAT(made_room, ElementsAre(1, 2, 3));
  EXPECT_THAT(Drain(queue), ElementsAre(4, 5));
}

TEST(BoundedQueue, PopTimesOutWhenEmpty) {
  BoundedQueue<int> queue(1);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(queue.Pop(30ms));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 29ms);
}

TEST(BoundedQueue, CloseRefusesNewItemsAndKeepsOldOnes) {
  BoundedQueue<int> queue(1);
  ASSERT_TRUE(queue.Push(1));
  queue.Close();
  EXPECT_FALSE(queue.Push(3));
  EXPECT_EQ(queue.Dropped(), 0u);
  EXPECT_EQ(queue.Pop(0ms), 1);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(queue.Pop(10s)) << "closed and drained: nothing to wait for";
  EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);
}

TEST(BoundedQueue, CloseEndsAWaitingPop) {
  BoundedQueue<int> queue(1);
  std::thread closer([&] {
    std::this_thread::sleep_for(20ms);
    queue.Close();
  });
  EXPECT_FALSE(queue.Pop(10s));
  closer.join();
}

TEST(BoundedQueue, RefusesZeroCapacity) { EXPECT_THROW((BoundedQueue<int>(0)), Error); }

// Every item is either taken once or counted as dropped.
TEST(BoundedQueue, AccountsForEveryItemAmongThreads) {
  for (const std::size_t capacity : {1u, 3u, 16u}) {
    constexpr int kProducers = 3, kEach = 2000;
    BoundedQueue<int> queue(capacity);
    std::vector<std::thread> producers;
    for (int p = 0; p < kProducers; ++p)
      producers.emplace_back([&, p] {
        for (int i = 0; i < kEach; ++i) queue.Push(p * kEach + i);
      });
    std::mutex mutex;
    std::multiset<int> taken;
    std::vector<std::thread> consumers;
    for (int c = 0; c < 2; ++c)
      consumers.emplace_back([&] {
        int last_of_producer[kProducers] = {-1, -1, -1};
        while (const auto item = queue.Pop(10s)) {
          const int producer = *item / kEach;
          EXPECT_GT(*item, last_of_producer[producer]) << "out of order within one producer";
          last_of_producer[producer] = *item;
          const std::lock_guard lock(mutex);
          taken.insert(*item);
        }
      });
    for (std::thread& producer : producers) producer.join();
    queue.Close();
    for (std::thread& consumer : consumers) consumer.join();
    EXPECT_EQ(taken.size() + queue.Dropped(), static_cast<std::size_t>(kProducers * kEach)) << capacity;
    EXPECT_EQ(std::set<int>(taken.begin(), taken.end()).size(), taken.size()) << "an item was taken twice";
  }
}

std::uint64_t MissingAfter(const std::vector<std::uint64_t>& ids) {
  FrameIdCounter counter;
  for (const std::uint64_t id : ids) counter.Arrived(id);
  return counter.Missing();
}

TEST(FrameIdCounter, CountsGaps) {
  EXPECT_EQ(MissingAfter({5, 6, 7}), 0u);
  EXPECT_EQ(MissingAfter({5, 7, 10}), 3u);
}

TEST(FrameIdCounter, WrapsAtSixteenBitsWithoutZero) {
  EXPECT_EQ(MissingAfter({65534, 65535, 1, 2}), 0u);
  EXPECT_EQ(MissingAfter({65534, 2}), 2u);  // 65535 and 1
  EXPECT_EQ(MissingAfter({65535, 3, 1, 2}), 0u);
}

TEST(FrameIdCounter, CountsOnBeyondSixteenBits) {
  EXPECT_EQ(MissingAfter({65534, 65535, 65536, 65537}), 0u);
  EXPECT_EQ(MissingAfter({0, 1, 2}), 0u);
  EXPECT_EQ(MissingAfter({70000, 70003}), 2u);
}

TEST(FrameIdCounter, LateFramesAreNotLost) {
  EXPECT_EQ(MissingAfter({1, 2, 4, 3, 5}), 0u);
  EXPECT_EQ(MissingAfter({1, 5, 2, 6}), 2u);
  EXPECT_EQ(MissingAfter({3, 3, 4}), 0u) << "a number twice is no gap";
}

TEST(FrameIdCounter, RestartCountsAsNeitherLateNorGap) {
  FrameIdCounter counter;
  for (const std::uint64_t id : {0, 1, 4}) counter.Arrived(id);
  counter.Restarted();
  for (const std::uint64_t id : {0, 1}) counter.Arrived(id);
  EXPECT_EQ(counter.Missing(), 2u) << "those of before";
  EXPECT_EQ(counter.OutOfOrder(), 0u);
}

TEST(FrameIdCounter, AFrameWithoutItsNumberFillsItsGap) {
  FrameIdCounter counter;
  counter.Arrived(10);
  counter.ArrivedWithoutId();
  counter.Arrived(12);
  EXPECT_EQ(counter.Missing(), 0u);
  counter.ArrivedWithoutId();
  counter.Arrived(16);
  EXPECT_EQ(counter.Missing(), 2u);
}

}  // namespace
}  // namespace ulf::frame_queue_test

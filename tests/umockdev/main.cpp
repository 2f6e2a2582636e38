// To be run under umockdev-wrapper; elsewhere it says so and ends with 77 (skipped).
#include <cstdio>

#include "tests/umockdev/node.hpp"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  UMockdevTestbed* const testbed = umockdev_testbed_new();
  ferrule::testing::Node::add(testbed, {}, 0);
  const bool mocked = umockdev_in_mock_environment();  // it needs a device to tell
  g_object_unref(testbed);
  if (!mocked) {
    std::puts("skipped: not run under umockdev-wrapper");
    return 77;
  }
  return RUN_ALL_TESTS();
}

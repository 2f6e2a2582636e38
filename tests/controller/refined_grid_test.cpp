#include "controller/refined_grid.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

using Function = std::function<double(double, double)>;

RefinedGrid refined(int cells, const Function& f) {
  RefinedGrid grid(cells);
  for (auto nodes = grid.next(); !nodes.empty(); nodes = grid.next())
    for (const auto& node : nodes) {
      EXPECT_FALSE(grid.values().contains(node));
      grid.set(node, f(node[0], node[1]));
    }
  return grid;
}

double length(const RefinedGrid::Line& line) {
  double sum = 0;
  for (std::size_t k = 1; k < line.size(); ++k) sum += (line[k] - line[k - 1]).norm();
  return sum;
}

TEST(RefinedGrid, FindsACircleWithATenthOfTheNodes) {
  constexpr double r = 9.3;
  const auto f = [](double x, double y) { return r - std::hypot(x - 33.1, y - 30.7); };
  const RefinedGrid grid = refined(64, f);
  const auto lines = grid.contour();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].front(), lines[0].back());
  for (const auto& p : lines[0]) EXPECT_NEAR(f(p.x(), p.y()), 0, 0.02);
  EXPECT_CLOSE(length(lines[0]), 2 * std::numbers::pi * r, 0.01);
  EXPECT_LT(grid.values().size(), 65u * 65u / 10);
}

// Whatever the function: the lines are those of the whole grid.
TEST(RefinedGrid, HasEveryCrossingOfTheWholeGridThatItsLinesMeet) {
  const auto f = [](double x, double y) { return std::sin(0.17 * x) * std::cos(0.13 * y) - 0.2; };
  const RefinedGrid grid = refined(32, f);
  for (const auto& line : grid.contour()) {
    const bool closed = line.front() == line.back();
    const auto at_edge = [](const Eigen::Vector2d& p) {
      return p.x() == 0 || p.x() == 32 || p.y() == 0 || p.y() == 32;
    };
    EXPECT_TRUE(closed || (at_edge(line.front()) && at_edge(line.back())));
    for (const auto& p : line) EXPECT_NEAR(f(p.x(), p.y()), 0, 0.01);
  }
  int beside = 0;
  const auto nodes_beside = grid.beside_contour();
  for (const auto& [node, value] : grid.values()) {
    bool crossed = false;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const auto other = grid.values().find({node[0] + dx, node[1] + dy});
      crossed |= other != grid.values().end() && (other->second >= 0) != (value >= 0);
    }
    EXPECT_EQ(nodes_beside.contains(node), crossed);
    beside += crossed;
  }
  EXPECT_GT(beside, 20);
}

// A straight line from edge to edge, and a second one: two pieces.
TEST(RefinedGrid, LinesEndAtTheEdges) {
  const RefinedGrid grid =
      refined(16, [](double x, double y) { return (x - 0.3 * y - 3.3) * (x - 0.3 * y - 9.1); });
  const auto lines = grid.contour();
  ASSERT_EQ(lines.size(), 2u);
  for (const auto& line : lines) {
    EXPECT_EQ(std::min(line.front().y(), line.back().y()), 0);
    EXPECT_EQ(std::max(line.front().y(), line.back().y()), 16);
  }
}

// While it is refined: whatever is known is a whole grid that is coarser, and its line.
TEST(RefinedGrid, IsOnTheWayWhatACoarserOneIs) {
  const auto f = [](double x, double y) { return std::sin(0.21 * x) - 0.7 + 0.02 * y; };
  RefinedGrid fine(32);
  EXPECT_FALSE(fine.coarser(4));
  int reached = 0;
  for (auto nodes = fine.next(); !nodes.empty(); nodes = fine.next()) {
    for (const auto& node : nodes) fine.set(node, f(node[0], node[1]));
    for (int cells = 32; cells >= 4; cells /= 2) {
      const auto grid = fine.coarser(cells);
      if (!grid) continue;
      const double size = 32.0 / cells;
      const RefinedGrid alone =
          refined(cells, [&](double x, double y) { return f(size * x, size * y); });
      EXPECT_EQ(grid->values(), alone.values());
      EXPECT_EQ(grid->contour(), alone.contour());
      EXPECT_GE(cells, reached);
      reached = cells;
      break;
    }
  }
  EXPECT_EQ(reached, 32);
}

TEST(RefinedGrid, OfOneSignHasNoContour) {
  for (const double sign : {-1.0, 0.0, 1.0}) {
    const RefinedGrid grid = refined(64, [&](double, double) { return sign; });
    EXPECT_TRUE(grid.contour().empty());
    EXPECT_EQ(grid.values().size(), 25u);
  }
}

// Corners of opposite signs: the middle decides which are together.
TEST(RefinedGrid, ASaddleIsTwoLines) {
  for (const double middle : {-0.1, 0.1}) {
    const RefinedGrid grid =
        refined(4, [&](double x, double y) { return (x - 1.5) * (y - 1.5) + middle; });
    const auto lines = grid.contour();
    ASSERT_EQ(lines.size(), 2u);
    for (const auto& line : lines) {
      const auto side = [&](const Eigen::Vector2d& p) {
        return middle > 0 ? p.x() > p.y() : p.x() + p.y() > 3;
      };
      for (const auto& p : line) EXPECT_EQ(side(p), side(line.front())) << middle;
    }
  }
}

// Stopped before its end: the lines are those of the squares that are known.
TEST(RefinedGrid, HasLinesBeforeItIsWhole) {
  RefinedGrid grid(64);
  for (int round = 0; round < 5; ++round) {
    const auto nodes = grid.next();
    for (std::size_t k = 0; k < (round < 4 ? nodes.size() : nodes.size() / 2); ++k)
      grid.set(nodes[k], 30.5 - std::hypot(nodes[k][0], nodes[k][1]));
    EXPECT_EQ(grid.beside_contour().empty(), round < 4);
    EXPECT_EQ(grid.contour().empty(), round < 4);
  }
}

TEST(RefinedGrid, NeedsAPowerOfTwo) {
  for (const int cells : {-4, 0, 2, 6, 33})
    EXPECT_THROW(RefinedGrid{cells}, std::invalid_argument) << cells;
}

}  // namespace
}  // namespace ferrule

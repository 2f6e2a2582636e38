#include "controller/refined_grid.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace ferrule {
namespace {

using Node = RefinedGrid::Node;
using Edge = std::array<Node, 2>;  // of a finest square, the lower node first

// Counterclockwise from the lowest.
std::array<Node, 4> corners(const Node& low, int size) {
  const auto [x, y] = low;
  return {{{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}}};
}

// Lines out of pieces that share their ends.
std::vector<std::vector<Edge>> joined(std::map<Edge, std::set<Edge>> neighbours) {
  std::vector<std::vector<Edge>> lines;
  const auto walk = [&](Edge at) {
    std::vector<Edge>& line = lines.emplace_back(1, at);
    while (!neighbours[at].empty()) {
      const Edge to = *neighbours[at].begin();
      neighbours[at].erase(to);
      neighbours[to].erase(at);
      line.push_back(at = to);
    }
  };
  const std::map<Edge, std::set<Edge>> all = neighbours;
  for (const auto& [edge, next] : all)  // first those with ends
    if (next.size() == 1 && !neighbours[edge].empty()) walk(edge);
  for (const auto& [edge, next] : all)
    if (!neighbours[edge].empty()) walk(edge);
  return lines;
}

}  // namespace

RefinedGrid::RefinedGrid(int cells) : cells_(cells) {
  if (cells < kCoarsest || !std::has_single_bit(static_cast<unsigned>(cells)))
    throw std::invalid_argument("RefinedGrid: cells must be a power of 2, at least 4");
}

bool RefinedGrid::cut(const Square& square) const {
  const std::array<Node, 4> at = corners(square.low, square.size);
  const bool first = positive(at[0]);
  for (std::size_t i = 0; i < 4; ++i) {  // along its sides, where its neighbours are finer too
    const Node &from = at[i], &to = at[(i + 1) % 4];
    for (int k = 0; k < square.size; ++k) {
      const auto between = [&](std::size_t axis) {
        return from[axis] + k * (to[axis] - from[axis]) / square.size;
      };
      const auto known = values_.find({between(0), between(1)});
      if (known != values_.end() && (known->second >= 0) != first) return true;
    }
  }
  return false;
}

std::vector<Node> RefinedGrid::next() {
  std::set<Node> wanted;
  const auto add = [&](const Square& square) {
    squares_.push_back(square);
    for (const Node& node : corners(square.low, square.size))
      if (!values_.contains(node)) wanted.insert(node);
  };
  if (squares_.empty()) {
    const int size = cells_ / kCoarsest;
    for (int x = 0; x < cells_; x += size)
      for (int y = 0; y < cells_; y += size) add({{x, y}, size});
  }
  while (wanted.empty()) {
    const auto done = std::stable_partition(
        squares_.begin(), squares_.end(),
        [&](const Square& square) { return square.size == 1 || !cut(square); });
    if (done == squares_.end()) break;
    const std::vector<Square> coarse(done, squares_.end());
    squares_.erase(done, squares_.end());
    for (const Square& square : coarse)
      for (const Node& low : corners(square.low, square.size / 2)) add({low, square.size / 2});
  }
  return {wanted.begin(), wanted.end()};
}

std::optional<RefinedGrid> RefinedGrid::coarser(int cells) const {
  RefinedGrid grid(cells);
  const int size = cells_ / cells;
  for (auto nodes = grid.next(); !nodes.empty(); nodes = grid.next())
    for (const Node& node : nodes) {
      const auto known = values_.find({size * node[0], size * node[1]});
      if (known == values_.end()) return std::nullopt;
      grid.set(node, known->second);
    }
  return grid;
}

std::vector<std::array<Node, 4>> RefinedGrid::finest() const {
  std::vector<std::array<Node, 4>> all;
  for (const Square& square : squares_)
    if (const auto at = corners(square.low, 1);
        square.size == 1 &&
        std::all_of(at.begin(), at.end(), [&](const Node& node) { return values_.contains(node); }))
      all.push_back(at);
  return all;
}

std::set<Node> RefinedGrid::beside_contour() const {
  std::set<Node> beside;
  for (const std::array<Node, 4>& at : finest())
    for (std::size_t i = 0; i < 4; ++i)
      if (const Node& a = at[i], &b = at[(i + 1) % 4]; positive(a) != positive(b))
        beside.insert({a, b});
  return beside;
}

std::vector<RefinedGrid::Line> RefinedGrid::contour() const {
  std::map<Edge, std::set<Edge>> neighbours;
  const auto join = [&](const Edge& a, const Edge& b) {
    neighbours[a].insert(b);
    neighbours[b].insert(a);
  };
  for (const std::array<Node, 4>& at : finest()) {
    std::vector<Edge> crossed;
    for (std::size_t i = 0; i < 4; ++i)
      if (const Node& a = at[i], &b = at[(i + 1) % 4]; positive(a) != positive(b))
        crossed.push_back({std::min(a, b), std::max(a, b)});
    if (crossed.size() == 2) join(crossed[0], crossed[1]);
    if (crossed.size() != 4) continue;
    // A saddle: its middle belongs to the first corner, or separates it from its like.
    const double middle = value(at[0]) + value(at[1]) + value(at[2]) + value(at[3]);
    const bool together = (middle >= 0) == positive(at[0]);
    join(crossed[0], crossed[together ? 1 : 3]);
    join(crossed[2], crossed[together ? 3 : 1]);
  }
  std::vector<Line> lines;
  for (const std::vector<Edge>& edges : joined(std::move(neighbours))) {
    Line& line = lines.emplace_back();
    for (const auto& [a, b] : edges) {
      const Eigen::Vector2d from(a[0], a[1]), to(b[0], b[1]);
      const double share = value(a) / (value(a) - value(b));
      const Eigen::Vector2d at = from + share * (to - from);
      if (line.empty() || at != line.back()) line.push_back(at);  // in a node edges meet
    }
  }
  return lines;
}

}  // namespace ferrule

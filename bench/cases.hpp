// The cases of a benchmark one after the other, so that somebody can watch them and stop.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace ferrule {

// Before each case: how many are done, of how many. False: enough, the rows so far are the result.
using GoOn = std::function<bool(std::size_t done, std::size_t all)>;

template <class Row>
using Cases = std::vector<std::function<void(std::vector<Row>& rows)>>;  // each adds its own

template <class Row>
std::vector<Row> rows_of(const Cases<Row>& cases, const GoOn& go_on) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (go_on && !go_on(i, cases.size())) break;
    cases[i](rows);
  }
  return rows;
}

// A case of one row.
template <class Row, class Measure>
void add_case(Cases<Row>& cases, const Measure& measure) {
  cases.push_back([measure](std::vector<Row>& rows) { rows.push_back(measure()); });
}

}  // namespace ferrule

// Which rows of sweep or compare are best, by a rule that is stated: first by success, as far as
// the trials can tell; then by what is preferred among those that they cannot tell apart.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// --prefer and --price.
struct PreferArguments {
  std::string prefer;               // one of loss, time, force, price; empty: none of them
  std::vector<std::string> prices;  // KEY=COST,COST,...

  void add_to(CLI::App& verb);
  // Into the result of a sweep: "prefer", and the "price" of each row, which is the sum over the
  // keys. Throws BadInput.
  void put_into(Json& result) const;
};

// Of rows as short_row of varied_scene.hpp makes them; there is one at least.
struct BestRows {
  // Those whose success the trials cannot tell from that of the row with the highest lower end of
  // its 95 % interval: the 95 % interval of the difference (Newcombe 1998, method 10, of Wilson's
  // intervals) has 0. Rows without a feasible trial are not among them unless all are so.
  std::vector<const Json*> alike;
  // Of `alike`: with a preference the one that is least by it, and where several are, by loss,
  // time, force and price in turn; else each that no other one beats, being less in one of them and
  // more in none. Mated losses differ where their 95 % intervals do not meet, and without intervals
  // as other numbers do.
  std::vector<const Json*> best;
};
BestRows best_rows(const Json& rows, const std::string& prefer);

// "loss, time and force", and "price" where the rows have one.
std::string criteria_in_words(const Json& rows);

}  // namespace ferrule

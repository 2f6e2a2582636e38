#include "app/best_rows.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "app/validators.hpp"
#include "app/varied_plots.hpp"
#include "controller/statistics.hpp"
#include "sim/scene/distribution.hpp"

namespace ferrule {
namespace {

constexpr std::array<const char*, 4> kCriteria = {"loss", "time", "force", "price"};

double number_in(const Json& row, const char* key) {
  return row.is_object() ? number_or_nan(row.value(key, Json())) : NAN;
}

// What a row has of a criterion: within these bounds. What it does not have is worst.
Interval cost(const Json& row, const std::string& criterion) {
  const auto known = [](double x) {
    return std::isnan(x) ? std::numeric_limits<double>::infinity() : x;
  };
  const char* key = criterion == "time" ? "time_s" : criterion == "force" ? "peak_force_uN" : "";
  if (criterion == "price") key = "price";
  if (*key) return {known(number_in(row, key)), known(number_in(row, key))};
  const Json mated = row.value("mated", Json());
  const double mean = known(number_in(mated, "mean_dB")), low = number_in(mated, "mean_low_dB"),
               high = number_in(mated, "mean_high_dB");
  if (std::isfinite(low) && std::isfinite(high)) return {low, high};
  const double alone = std::isfinite(mean) ? mean : known(number_in(row, "loss_dB"));
  return {alone, alone};
}

bool less(const Json& a, const Json& b, const std::string& criterion) {
  return cost(a, criterion).high < cost(b, criterion).low;
}

bool beats(const Json& a, const Json& b) {
  return std::any_of(kCriteria.begin(), kCriteria.end(),
                     [&](const char* criterion) { return less(a, b, criterion); }) &&
         std::none_of(kCriteria.begin(), kCriteria.end(),
                      [&](const char* criterion) { return less(b, a, criterion); });
}

// `better` has the higher success rate.
bool told_apart(const Json& better, const Json& other) {
  const double p = better.at("success_rate"), q = other.at("success_rate");
  const double down = p - better.at("low").get<double>(), up = other.at("high").get<double>() - q;
  return p - q > std::sqrt(down * down + up * up);
}

std::vector<const Json*> alike_rows(const Json& rows) {
  const auto lower = [](const Json& a, const Json& b) {
    return std::pair(a.at("feasible") > 0, a.at("low").get<double>()) <
           std::pair(b.at("feasible") > 0, b.at("low").get<double>());
  };
  const Json& highest = *std::max_element(rows.begin(), rows.end(), lower);
  std::vector<const Json*> alike;
  for (const Json& row : rows)
    if ((row.at("feasible") > 0) == (highest.at("feasible") > 0) &&
        (row.at("feasible") == 0 || !told_apart(highest, row)))
      alike.push_back(&row);
  return alike;
}

// Those of which no other one is less.
std::vector<const Json*> least(const std::vector<const Json*>& rows, const std::string& criterion) {
  const Json& first = **std::min_element(rows.begin(), rows.end(), [&](auto* a, auto* b) {
    return cost(*a, criterion).high < cost(*b, criterion).high;
  });
  std::vector<const Json*> kept;
  for (const Json* row : rows)
    if (!less(first, *row, criterion)) kept.push_back(row);
  return kept;
}

// KEY=COST,COST,...
struct Price {
  std::string key;
  std::vector<double> costs;
};

Price price_of(const std::string& text) {
  const auto refuse = [&] {
    return BadInput("--price " + text + ": must be KEY=COST,COST,..., one cost for each value");
  };
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0) throw refuse();
  Price price{text.substr(0, equals), {}};
  for (const std::string& cost : CLI::detail::split(text.substr(equals + 1), ',')) {
    if (cost.find(':') != cost.npos) throw refuse();
    price.costs.push_back(parse_range(cost, "--price " + price.key).front());
  }
  return price;
}

// The values of a key in the order in which the rows have them first.
std::vector<Json> values_of(const Json& rows, const std::string& key) {
  std::vector<Json> values;
  for (const Json& row : rows)
    if (const Json& value = row.at("values").at(key);
        std::find(values.begin(), values.end(), value) == values.end())
      values.push_back(value);
  return values;
}

void add_price(Json& result, const Price& price) {
  Json& rows = result.at("rows");
  const Json keys = result.value("keys", Json::array());
  if (std::find(keys.begin(), keys.end(), Json(price.key)) == keys.end())
    throw BadInput("--price " + price.key + ": must be a key of the sweep: " +
                   fmt::format("{}", fmt::join(keys.get<std::vector<std::string>>(), ", ")));
  const std::vector<Json> values = values_of(rows, price.key);
  if (values.size() != price.costs.size())
    throw BadInput(fmt::format("--price {}: {} costs, must be one for each of its {} values",
                               price.key, price.costs.size(), values.size()));
  for (Json& row : rows) {
    const auto at = std::find(values.begin(), values.end(), row["values"][price.key]);
    const double cost = price.costs[static_cast<std::size_t>(at - values.begin())];
    row["price"] = as_written(row.value("price", 0.0) + cost);
  }
}

}  // namespace

void PreferArguments::add_to(CLI::App& verb) {
  verb.add_option("--prefer", prefer,
                  "Which counts among points whose success the trials cannot tell apart")
      ->check(one_of({kCriteria.begin(), kCriteria.end()}));
  verb.add_option("--price", prices,
                  "What each value of a key costs, in the order of the sweep; can be repeated: a "
                  "point costs the sum")
      ->type_name("KEY=COST,COST,...")
      ->expected(1)
      ->take_all();
}

void PreferArguments::put_into(Json& result) const {
  if (!prices.empty())
    for (Json& row : result.at("rows")) row.erase("price");
  std::set<std::string> priced;
  for (const std::string& text : prices) {
    const Price price = price_of(text);
    if (!priced.insert(price.key).second)
      throw BadInput("--price " + price.key + ": is there twice");
    add_price(result, price);
  }
  if (!prefer.empty()) result["prefer"] = prefer;
  const Json& rows = result.at("rows");
  if (result.value("prefer", "") == "price" && !rows.empty() && !rows[0].contains("price"))
    throw BadInput("--prefer price: needs --price KEY=COST,COST,...");
}

BestRows best_rows(const Json& rows, const std::string& prefer) {
  BestRows found{alike_rows(rows), {}};
  if (!prefer.empty()) {
    found.best = least(found.alike, prefer);
    for (const char* criterion : kCriteria) found.best = least(found.best, criterion);
    found.best.resize(1);
    return found;
  }
  for (const Json* row : found.alike)
    if (std::none_of(found.alike.begin(), found.alike.end(),
                     [&](const Json* other) { return beats(*other, *row); }))
      found.best.push_back(row);
  return found;
}

std::string criteria_in_words(const Json& rows) {
  const bool priced = !rows.empty() && rows[0].contains("price");
  return priced ? "loss, time, force and price" : "loss, time and force";
}

}  // namespace ferrule

#include "app/varied_plots.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "controller/statistics.hpp"
#include "sim/scene/distribution.hpp"

namespace ferrule {
namespace {

// Adds a point to the series of that name.
void add(Axes& axes, const std::string& name, double x, double y) {
  auto series = std::find_if(axes.series.begin(), axes.series.end(),
                             [&](const Series& s) { return s.name == name; });
  if (series == axes.series.end())
    series = axes.series.insert(axes.series.end(), {name, {}, {}, Series::points});
  series->x.push_back(x);
  series->y.push_back(y);
}

// The points of a map in the quarters of a quantity's values.
Axes by_quarters(const Json& rows, Axes axes, const std::array<std::string, 2>& keys,
                 const char* quantity, const char* format) {
  std::vector<double> all;
  for (const Json& row : rows)
    if (row.at(quantity).is_number()) all.push_back(row.at(quantity));
  for (int q = 0; q < 4; ++q) {
    const double low = quantile(all, 0.25 * q), high = quantile(all, 0.25 * (q + 1));
    for (const Json& row : rows)
      if (const double x = number_or_nan(row.at(quantity));
          x <= high && (x > low || (q == 0 && x == low)))
        add(axes, fmt::format(fmt::runtime(format), low, high), row.at("values").at(keys[0]),
            row.at("values").at(keys[1]));
  }
  return axes;
}

}  // namespace

double number_or_nan(const Json& value) {
  return value.is_number() ? value.get<double>() : NAN;
}

std::string setting_text(const Json& value) {
  if (value.is_object() && value.size() == 1 && value.begin()->is_array() &&
      value.begin()->size() == 2) {
    const Json &a = (*value.begin())[0], &b = (*value.begin())[1];
    if (value.contains("uniform")) return a.dump() + ".." + b.dump();
    if (value.contains("normal")) return fmt::format("{}+-{:.4g}", a.dump(), 3 * b.get<double>());
  }
  return value.is_string() ? value.get<std::string>() : value.dump();
}

Plot sweep_plot(const Json& result) {
  const Json& keys = result.at("keys");
  const std::string x_key = keys.at(0);
  Axes success, force, loss;
  success.y_label = "inserted [%]";
  force.y_label = "peak force [uN]";
  loss.y_label = "mated, mean [dB]";
  success.y_low = 0;
  success.y_high = 100;
  for (double place = 0; const Json& row : result.at("rows")) {
    std::string name;
    for (std::size_t i = 1; i < keys.size(); ++i)
      name += (i > 1 ? ", " : "") + keys[i].get<std::string>() + " " +
              setting_text(row.at("values").at(keys[i].get<std::string>()));
    const Json& value = row.at("values").at(x_key);
    const auto drawn = Distribution::read(value);
    const double x = drawn ? drawn->centre() : value.is_number() ? value.get<double>() : place;
    add(success, name, x, 100 * number_or_nan(row.at("success_rate")));
    add(force, name, x, number_or_nan(row.at("peak_force_uN")));
    add(loss, name, x, number_or_nan(row.value(Json::json_pointer("/mated/mean_dB"), Json())));
    ++place;
  }
  for (Axes* axes : {&success, &force, &loss}) {
    axes->x_label = x_key;
    for (Series& series : axes->series) series.style = Series::points_on_line;
  }
  return {
      "Trials of " + result.at("controller").get<std::string>(), {success, force, loss}, 860, 300};
}

Plot map_plot(const Json& result) {
  const Json &x = result.at("keys").at(0), &y = result.at("keys").at(1);
  const std::array<std::string, 2> keys = {x.at("key"), y.at("key")};
  const Axes like{keys[0], keys[1], x.at("log"), y.at("log"), {}, y.at("low"), y.at("high")};
  const double target = result.at("target");
  Axes success = like;
  for (const Json& row : result.at("rows")) {
    const char* kind = !row.at("can_be").get<bool>()                     ? "infeasible"
                       : number_or_nan(row.at("success_rate")) >= target ? "{:g} % or more"
                                                                         : "less than {:g} %";
    add(success, fmt::format(fmt::runtime(kind), 100 * target), row.at("values").at(keys[0]),
        row.at("values").at(keys[1]));
  }
  std::sort(success.series.begin(), success.series.end(),
            [](const Series& a, const Series& b) { return a.name < b.name; });
  Series line{fmt::format("{:g} % inserted", 100 * target), {}, {}, Series::line};
  const Json& begins = result.at("contour_begins");
  for (std::size_t k = 0; const Json& point : result.at("contour")) {
    if (k > 0 && std::find(begins.begin(), begins.end(), k) != begins.end()) {
      line.x.push_back(NAN);
      line.y.push_back(NAN);
    }
    line.x.push_back(point.at(0));
    line.y.push_back(point.at(1));
    ++k;
  }
  if (!line.x.empty()) success.series.push_back(line);
  const Json& rows = result.at("rows");
  return {"Trials of " + result.at("controller").get<std::string>(),
          {success, by_quarters(rows, like, keys, "time_s", "time {:.4g} to {:.4g} s"),
           by_quarters(rows, like, keys, "peak_force_uN", "peak {:.4g} to {:.4g} uN"),
           by_quarters(rows, like, keys, "loss_dB", "loss {:.3g} to {:.3g} dB")},
          860,
          380};
}

}  // namespace ferrule

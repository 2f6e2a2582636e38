#include "controller/search_file.hpp"

#include <algorithm>
#include <string_view>

namespace ferrule {
namespace {

constexpr std::int64_t kSearchFormatVersion = 1;

double gain_of(const SearchFile& c, std::string_view name) {
  const auto gain = std::find_if(kSearchGains.begin(), kSearchGains.end(),
                                 [&](const Gain& g) { return g.name == name; });
  return c.gains[static_cast<std::size_t>(gain - kSearchGains.begin())];
}

}  // namespace

void write_controller(const std::string& file, const SearchFile& c) {
  Json gains = Json::object();
  for (std::size_t i = 0; i < kSearchGains.size(); ++i)
    gains[kSearchGains[i].name] = {
        {"value", c.gains[i]}, {"unit", kSearchGains[i].unit}, {"source", c.sources[i]}};
  const Json json = {{"format", kControllerFormat},
                     {"format_version", kSearchFormatVersion},
                     {"method", "search"},
                     {"world", "hand"},
                     {"gains", gains},
                     {"trained_on", to_json(c.trained_on)}};
  write_text(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

SearchFile parse_search(const Json& json, const std::string& file) {
  JsonFields fields(json, file);
  SearchFile c;
  expect_heading(fields, "search", kSearchFormatVersion);
  JsonFields gains = fields.object("gains");
  for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
    JsonFields gain = gains.object(kSearchGains[i].name);
    c.gains[i] = gain.number("value", range_of(kSearchGains[i]));
    gain.choice("unit", {kSearchGains[i].unit});
    c.sources[i] = gain.text("source");
    gain.finish();
  }
  const double bore = gain_of(c, "bore_radius");
  if (!(bore > gain_of(c, "fibre_radius") && bore <= gain_of(c, "mouth_radius")))
    gains.refuse("bore_radius", "must be larger than fibre_radius, and at most mouth_radius");
  gains.finish();
  c.trained_on = read_trained_on(fields, file);
  fields.finish();
  return c;
}

}  // namespace ferrule

#include "controller/controller_file.hpp"

namespace ferrule {
namespace {

constexpr const char* kFormat = "ferrule controller";

std::vector<std::string> text_list(JsonFields& fields, const std::string& key) {
  const Json& value = fields.raw(key);
  if (!value.is_array()) fields.refuse(key, "must be a list of texts");
  std::vector<std::string> list;
  for (const Json& each : value) {
    if (!each.is_string()) fields.refuse(key, "must be a list of texts");
    list.push_back(each);
  }
  return list;
}

double optional_number(JsonFields& fields, const std::string& key) {
  return fields.has(key) ? fields.number(key, rule::any())
                         : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

InsertionLaw ControllerFile::law() const {
  std::array<double, kGains> values;
  for (std::size_t i = 0; i < kGains; ++i) values[i] = gains[i].value;
  return InsertionLaw(values);
}

void write_controller(const std::string& file, const ControllerFile& c) {
  Json gains = Json::object();
  for (std::size_t i = 0; i < kGains; ++i)
    gains[kGainTable[i].name] = {{"value", c.gains[i].value},
                                 {"unit", kGainTable[i].unit},
                                 {"low", number_or_null(c.gains[i].low)},
                                 {"high", number_or_null(c.gains[i].high)}};
  const Json json = {{"format", kFormat},
                     {"format_version", 1},
                     {"method", "ceres"},
                     {"world", "hand"},
                     {"law", "insertion"},
                     {"gains", gains},
                     {"reaction_time_s", c.reaction_time},
                     {"trained_on",
                      {{"scenes", c.scenes},
                       {"episodes", c.episodes},
                       {"held_out", c.held_out},
                       {"rows", c.rows},
                       {"seed", c.seed}}},
                     {"metrics",
                      {{"residual_m_s", c.residual},
                       {"held_out_residual_m_s", number_or_null(c.held_out_residual)}}}};
  write_text(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

ControllerFile read_controller(const std::string& file) {
  const Json json = parse_json(read_text(file), file);
  JsonFields fields(json, file);
  ControllerFile c;
  fields.choice("format", {kFormat});
  fields.integer("format_version", 1, 1);
  fields.choice("method", {"ceres"});
  fields.choice("world", {"hand"});
  fields.choice("law", {"insertion"});
  JsonFields gains = fields.object("gains");
  for (std::size_t i = 0; i < kGains; ++i) {
    const bool positive = i == 1 || i == 3;  // times and lengths that are divided by
    JsonFields gain = gains.object(kGainTable[i].name);
    c.gains[i].value = gain.number("value", positive ? rule::positive() : rule::any());
    gain.choice("unit", {kGainTable[i].unit});
    c.gains[i].low = optional_number(gain, "low");
    c.gains[i].high = optional_number(gain, "high");
    gain.finish();
  }
  gains.finish();
  c.reaction_time = fields.number("reaction_time_s", rule::not_negative());
  JsonFields trained = fields.object("trained_on");
  c.scenes = text_list(trained, "scenes");
  c.episodes = text_list(trained, "episodes");
  c.held_out = text_list(trained, "held_out");
  c.rows = static_cast<std::size_t>(trained.integer("rows", 0, INT64_MAX));
  c.seed = static_cast<std::uint64_t>(trained.integer("seed", 0, INT64_MAX));
  trained.finish();
  JsonFields metrics = fields.object("metrics");
  c.residual = metrics.number("residual_m_s", rule::not_negative());
  c.held_out_residual = optional_number(metrics, "held_out_residual_m_s");
  metrics.finish();
  fields.finish();
  return c;
}

}  // namespace ferrule

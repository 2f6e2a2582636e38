#include "controller/law_file.hpp"

#include "sim/base/json_file.hpp"

namespace ferrule {
namespace {

constexpr std::int64_t kControllerFormatVersion = 2;  // in 1 the insertion law sped up otherwise

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for (const LawKind kind : kLaws) names.push_back(name(kind));
  return names;
}

FittedGain read_gain(JsonFields fields, const Gain& gain) {
  FittedGain g;
  g.value = fields.number("value", range_of(gain));
  fields.choice("unit", {gain.unit});
  g.low = fields.number_or_nan("low", rule::any());
  g.high = fields.number_or_nan("high", rule::any());
  fields.finish();
  return g;
}

Json to_json(const std::vector<CrossValidated>& laws) {
  Json json = Json::object();
  for (const CrossValidated& law : laws)
    json[name(law.kind)] = {{"gains", gain_table(law.kind).size()},
                            {"error_m_s", number_or_null(law.error)},
                            {"standard_error_m_s", number_or_null(law.standard_error)}};
  return json;
}

std::vector<CrossValidated> read_cross_validation(JsonFields fields) {
  std::vector<CrossValidated> laws;
  for (const LawKind kind : kLaws)
    if (fields.present(name(kind))) {
      JsonFields law = fields.object(name(kind));
      const auto gains = static_cast<std::int64_t>(gain_table(kind).size());
      law.integer("gains", gains, gains);
      laws.push_back({kind, law.number_or_nan("error_m_s", rule::any()),
                      law.number_or_nan("standard_error_m_s", rule::any())});
      law.finish();
    }
  fields.finish();
  return laws;
}

}  // namespace

Law LawFile::law() const {
  std::vector<double> values;
  for (const FittedGain& gain : gains) values.push_back(gain.value);
  return {kind, values};
}

void write_controller(const std::string& file, const LawFile& c) {
  Json gains = Json::object();
  for (std::size_t i = 0; i < c.gains.size(); ++i)
    gains[gain_of(c.kind, i).name] = {{"value", c.gains[i].value},
                                      {"unit", gain_of(c.kind, i).unit},
                                      {"low", number_or_null(c.gains[i].low)},
                                      {"high", number_or_null(c.gains[i].high)}};
  Json json = {{"format", kControllerFormat},
               {"format_version", kControllerFormatVersion},
               {"method", "ceres"},
               {"world", "hand"},
               {"law", name(c.kind)},
               {"gains", gains},
               {"reaction_time_s", c.reaction_time},
               {"trained_on", to_json(c.trained_on)},
               {"metrics",
                {{"residual_m_s", c.residual},
                 {"held_out_residual_m_s", number_or_null(c.held_out_residual)}}}};
  if (!c.cross_validation.empty())
    json["metrics"]["cross_validation"] = to_json(c.cross_validation);
  write_text(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

LawFile read_law(const std::string& file) {
  return read_json(file, [&](const Json& json) { return parse_law(json, file); });
}

LawFile parse_law(const Json& json, const std::string& file) {
  JsonFields fields(json, file);
  LawFile c;
  expect_heading(fields, "ceres", kControllerFormatVersion);
  c.kind = kLaws[fields.choice("law", law_names())];
  JsonFields gains = fields.object("gains");
  c.gains.clear();
  for (const Gain& gain : gain_table(c.kind))
    c.gains.push_back(read_gain(gains.object(gain.name), gain));
  if (gains.has(kTiltGains[0].name) || gains.has(kTiltGains[1].name))
    for (const Gain& gain : kTiltGains) c.gains.push_back(read_gain(gains.object(gain.name), gain));
  gains.finish();
  c.reaction_time = fields.number("reaction_time_s", rule::not_negative());
  c.trained_on = read_trained_on(fields, file);
  JsonFields metrics = fields.object("metrics");
  c.residual = metrics.number("residual_m_s", rule::not_negative());
  c.held_out_residual = metrics.number_or_nan("held_out_residual_m_s", rule::any());
  if (metrics.has("cross_validation"))
    c.cross_validation = read_cross_validation(metrics.object("cross_validation"));
  metrics.finish();
  fields.finish();
  return c;
}

}  // namespace ferrule

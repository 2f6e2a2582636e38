#include "controller/graded_joint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "sim/base/units.hpp"
#include "sim/scene/distribution.hpp"

namespace ferrule {
namespace {

constexpr double kCoreSd = 0.2e-6, kBoreSd = 0.3e-6;  // [m]

// Of G.652 fibre [m].
double usual_mode_radius(double wavelength) {
  return 4.6e-6 + (5.2e-6 - 4.6e-6) * (wavelength - 1310e-9) / (1550e-9 - 1310e-9);
}

// The numbers of a key, each at its centre, in the unit of the file: none, one or a list.
std::vector<double> numbers_of(const Json& value) {
  std::vector<double> numbers;
  if (value.is_array()) {
    for (const Json& each : value) numbers.push_back(numbers_of(each).at(0));
  } else if (const auto drawn = Distribution::read(value)) {
    numbers.push_back(drawn->centre());
  } else if (value.is_number()) {
    numbers.push_back(value.get<double>());
  }
  return numbers;
}

// That of a wavelength; one number stands for all.
double at_or_only(const std::vector<double>& numbers, std::size_t i) {
  return numbers.size() == 1 ? numbers[0] : numbers.at(i);
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

// "1310 and 1550 nm" of each wavelength's joint; once where all are the same.
template <class Number>
std::string at_each(const GradedJoint& joint, const Number& number, const char* unit) {
  std::vector<std::string> words;
  for (const Joint& at : joint.at) words.push_back(fmt::format("{:.5g}", number(at)));
  if (std::count(words.begin(), words.end(), words[0]) == static_cast<std::ptrdiff_t>(words.size()))
    words.resize(1);
  return listed(words) + " " + unit;
}

double mode_field_um(const Joint& at) {
  return 2e6 * at.mode_radius;
}
double partner_mode_field_um(const Joint& at) {
  return 2e6 * at.partner_mode_radius.value_or(at.mode_radius);
}
double wavelength_nm(const Joint& at) {
  return 1e9 * at.wavelength;
}

// Without the last bits that a change of unit leaves.
Json as_stated(double x) {
  return as_written(std::round(1e9 * x) / 1e9);
}

std::string off_text(const GradedJoint& joint) {
  if (!joint.core_sd) return "core off as the scene states (offset_y_um, offset_z_um)";
  if (*joint.core_sd == 0 && *joint.bore_sd == 0) return "perfect cores and bores";
  return fmt::format("core off by {:.3g} um and bore by {:.3g} um (standard deviations in y and z)",
                     1e6 * *joint.core_sd, 1e6 * *joint.bore_sd);
}

}  // namespace

GradedJoint graded_joint(const Scene& scene) {
  const Json stated = scene.document().value("joint", Json::object());
  GradedJoint graded;
  const auto states = [&](const char* key) {
    if (stated.contains(key)) return true;
    graded.assumed.emplace_back(key);
    return false;
  };
  std::vector<double> nanometres = {1310, 1550}, fields;
  if (states("wavelength_nm")) nanometres = numbers_of(stated["wavelength_nm"]);
  if (states("mode_field_diameter_um")) fields = numbers_of(stated["mode_field_diameter_um"]);
  const std::vector<double> partners =
      numbers_of(stated.value("partner_mode_field_diameter_um", Json()));
  for (std::size_t i = 0; i < nanometres.size(); ++i) {
    Joint& at = graded.at.emplace_back(scene.joint);
    at.wavelength = nano * nanometres[i];
    at.mode_radius =
        fields.empty() ? usual_mode_radius(at.wavelength) : 0.5 * micro * at_or_only(fields, i);
    if (!partners.empty()) at.partner_mode_radius = 0.5 * micro * at_or_only(partners, i);
  }
  states("index");
  states("gap_um");
  if (stated.contains("offset_y_um")) return graded;
  const bool core = states("core_concentricity_sd_um"), bore = states("bore_concentricity_sd_um");
  graded.core_sd = core ? scene.joint.core_sd : kCoreSd;
  graded.bore_sd = bore ? scene.joint.bore_sd : kBoreSd;
  const double of_core = core ? 0 : kCoreSd, of_bore = bore ? 0 : kBoreSd;
  graded.unstated_sd = std::sqrt(of_core * of_core + of_bore * of_bore);
  return graded;
}

Vector2d GradedJoint::unstated_offset(std::uint64_t seed, std::uint64_t trial) const {
  if (unstated_sd == 0) return Vector2d::Zero();
  const auto is_assumed = [&](const char* key) {
    return std::find(assumed.begin(), assumed.end(), key) != assumed.end();
  };
  // One of them alone comes beside the other one, which the scene draws by these names.
  const bool both =
      is_assumed("core_concentricity_sd_um") && is_assumed("bore_concentricity_sd_um");
  const std::string name = both ? "joint." : "joint.unstated_";
  const Distribution normal = Distribution::about(0, 1e6 * unstated_sd);
  RandomStream y(seed, trial, name + "offset_y_um"), z(seed, trial, name + "offset_z_um");
  return {micro * normal.draw(y), micro * normal.draw(z)};
}

std::string to_text(const GradedJoint& joint) {
  const Joint& first = joint.at.front();
  std::string text =
      at_each(joint, wavelength_nm, "nm") + ", mode field " + at_each(joint, mode_field_um, "um");
  if (first.partner_mode_radius)
    text += ", of the partner " + at_each(joint, partner_mode_field_um, "um");
  text += ", " + off_text(joint);
  text +=
      first.gap > 0 ? fmt::format(", a gap of {:.3g} um", 1e6 * first.gap) : ", ends that touch";
  const std::vector<std::string>& assumed = joint.assumed;
  if (assumed.empty()) return text + "; all as the scene states";
  if (assumed.size() == 6) return text + "; all assumed, as the scene states none of it (joint)";
  return text + "; assumed, as the scene does not state them: joint." +
         fmt::format("{}", fmt::join(assumed, ", joint."));
}

Json to_json(const GradedJoint& joint) {
  const auto of_each = [&](auto number) {
    Json numbers = Json::array();
    for (const Joint& at : joint.at) numbers.push_back(as_stated(number(at)));
    return numbers;
  };
  const auto um = [](const std::optional<double>& sd) {
    return sd ? as_stated(1e6 * *sd) : Json();
  };
  Json json = {{"wavelength_nm", of_each(wavelength_nm)},
               {"mode_field_diameter_um", of_each(mode_field_um)},
               {"index", joint.at.front().index},
               {"gap_um", as_stated(1e6 * joint.at.front().gap)},
               {"core_concentricity_sd_um", um(joint.core_sd)},
               {"bore_concentricity_sd_um", um(joint.bore_sd)},
               {"assumed", joint.assumed},
               {"text", to_text(joint)}};
  if (joint.at.front().partner_mode_radius)
    json["partner_mode_field_diameter_um"] = of_each(partner_mode_field_um);
  return json;
}

}  // namespace ferrule
